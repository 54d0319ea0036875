//! Is an adapter fit to be trusted? What its driver does to a shader, found out by running one.

pub mod arithmetic;
pub mod loads;
pub mod loops;
pub mod precision;
mod probe;

use super::context::{AdapterFacts, Context, adapters};
use crate::error::GpuError;
use arithmetic::Arithmetic;
use loads::Loads;
use loops::LoopBudget;
use precision::Precision;
use serde::Serialize;

/// What was found out about an adapter.
#[derive(Debug, Clone, Serialize)]
pub struct Diagnosis {
    /// Which one.
    pub adapter: AdapterFacts,
    /// What it offers.
    pub limits: LimitFacts,
    /// What its driver does to shaders; the error when that could not be found out.
    pub driver: Result<DriverFacts, String>,
}

/// What a driver does to shaders.
#[derive(Debug, Clone, Serialize)]
pub struct DriverFacts {
    /// Whether loops run to their end.
    pub loop_budget: LoopBudget,
    /// Numbers that are not ordinary ones, and the order of operations.
    pub arithmetic: Arithmetic,
    /// Errors of elementary functions.
    pub precision: Vec<Precision>,
    /// What loads cost.
    pub loads: Loads,
}

impl DriverFacts {
    /// # Errors
    /// A kernel does not compile or the driver fails.
    fn of(context: &Context) -> Result<Self, GpuError> {
        Ok(Self {
            loop_budget: loops::loop_budget(context)?,
            arithmetic: arithmetic::arithmetic(context)?,
            precision: precision::sweep(context)?,
            loads: loads::loads(context)?,
        })
    }

    /// What direkt's images rest on and the driver does not give.
    fn faults(&self) -> Vec<String> {
        let mut faults = Vec::new();
        if self.arithmetic.misclassified > 0 {
            faults.push("bits of floats do not tell NaN and infinity".to_owned());
        }
        let off = self.precision.iter().filter(|p| p.needed && !p.is_within());
        faults.extend(off.map(|p| {
            format!(
                "{} is off by {}, more than {}",
                p.function,
                p.worst(),
                p.bound()
            )
        }));
        faults
    }
}

/// Limits that decide what can be rendered.
#[derive(Debug, Clone, Serialize)]
pub struct LimitFacts {
    /// Bytes of one storage buffer binding.
    pub max_storage_buffer_binding_size: u64,
    /// Bytes of one buffer.
    pub max_buffer_size: u64,
    /// Texels along a side of a texture.
    pub max_texture_dimension_2d: u32,
    /// Storage buffers of one shader.
    pub max_storage_buffers_per_shader_stage: u32,
    /// Invocations per subgroup, least.
    pub subgroup_min_size: u32,
    /// Invocations per subgroup, most.
    pub subgroup_max_size: u32,
    /// Whether shaders may use subgroup operations; direkt's do not.
    pub subgroup_operations: bool,
}

impl Diagnosis {
    /// Whether direkt can render on it.
    pub fn is_fit(&self) -> bool {
        self.driver.as_ref().is_ok_and(|d| d.faults().is_empty())
    }

    /// One sentence.
    pub fn verdict(&self) -> String {
        let facts = match &self.driver {
            Err(message) => return format!("unfit: {message}"),
            Ok(facts) => facts,
        };
        let faults = facts.faults();
        if !faults.is_empty() {
            format!("unfit: {}", faults.join("; "))
        } else if facts.loop_budget.is_unlimited() {
            "fit".to_owned()
        } else {
            "fit: the driver ends long loops without a word, which direkt notices and makes up for; \
             a newer driver is faster"
                .to_owned()
        }
    }
}

/// Examines every adapter whose name or driver contains `wanted`.
pub fn examine(wanted: Option<&str>) -> Vec<Diagnosis> {
    let all = adapters();
    let chosen = all
        .iter()
        .filter(|a| wanted.is_none_or(|w| super::context::matches(a, w)));
    chosen.map(examine_adapter).collect()
}

fn examine_adapter(adapter: &wgpu::Adapter) -> Diagnosis {
    let limits = adapter.limits();
    let info = adapter.get_info();
    Diagnosis {
        adapter: AdapterFacts::of(&info),
        limits: LimitFacts {
            max_storage_buffer_binding_size: limits.max_storage_buffer_binding_size,
            max_buffer_size: limits.max_buffer_size,
            max_texture_dimension_2d: limits.max_texture_dimension_2d,
            max_storage_buffers_per_shader_stage: limits.max_storage_buffers_per_shader_stage,
            subgroup_min_size: info.subgroup_min_size,
            subgroup_max_size: info.subgroup_max_size,
            subgroup_operations: adapter.features().contains(wgpu::Features::SUBGROUP),
        },
        driver: Context::open(adapter)
            .and_then(|context| DriverFacts::of(&context))
            .map_err(|e| e.to_string()),
    }
}
