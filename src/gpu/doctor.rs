//! Is an adapter fit to be trusted? What its driver does to a shader, found out by running one.

use super::buffer::GpuBuffer;
use super::context::{AdapterFacts, Context, adapters};
use super::shader::{self, Config};
use crate::error::GpuError;
use serde::Serialize;

/// What was found out about an adapter.
#[derive(Debug, Clone, Serialize)]
pub struct Diagnosis {
    /// Which one.
    pub adapter: AdapterFacts,
    /// What it offers.
    pub limits: LimitFacts,
    /// Whether loops run to their end; the error when that could not be found out.
    pub loop_budget: Result<LoopBudget, String>,
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
}

/// Loops that a driver may end early: Mesa's lavapipe before version 23 ends all loops of an invocation after 65,535
/// iterations in total and says nothing.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct LoopBudget {
    /// What each test loop did.
    pub canaries: Vec<LoopCanary>,
}

/// One test loop.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct LoopCanary {
    /// How it is nested.
    pub shape: &'static str,
    /// Iterations of the innermost body that were asked for.
    pub expected: u32,
    /// Iterations that ran.
    pub ran: u32,
}

impl LoopBudget {
    /// Whether every loop ran to its end.
    pub fn is_unlimited(&self) -> bool {
        self.canaries.iter().all(|c| c.ran == c.expected)
    }
}

impl Diagnosis {
    /// Whether direkt can render on it.
    pub fn is_fit(&self) -> bool {
        self.loop_budget.is_ok()
    }

    /// One sentence.
    pub fn verdict(&self) -> String {
        match &self.loop_budget {
            Err(message) => format!("unfit: {message}"),
            Ok(budget) if budget.is_unlimited() => "fit".to_owned(),
            Ok(_) => "fit: the driver ends long loops without a word, which direkt notices and makes up for; \
                      a newer driver is faster"
                .to_owned(),
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
        },
        loop_budget: Context::open(adapter)
            .and_then(|context| loop_budget(&context))
            .map_err(|e| e.to_string()),
    }
}

/// Runs the test loops of `shaders/kernel/loop_canary.wesl`.
///
/// # Errors
/// The kernel does not compile or the driver fails.
pub fn loop_budget(context: &Context) -> Result<LoopBudget, GpuError> {
    const EXPECTED: [(&str, u32); 2] = [("70,000", 70_000), ("200 × 1,000", 200_000)];
    let wgsl = shader::link("kernel::loop_canary", [], Config { stack_depth: 4 })?;
    let device = &context.device;
    let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
    let counts: GpuBuffer<[u32; 4]> = GpuBuffer::zeroed(device, "canary.counts", 1, usage);
    let read = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
    let staging: GpuBuffer<[u32; 4]> = GpuBuffer::zeroed(device, "canary.staging", 1, read);
    context.checked(|| {
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("loop_canary"),
            source: wgpu::ShaderSource::Wgsl(wgsl.as_str().into()),
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("loop_canary"),
            layout: None,
            module: &module,
            entry_point: Some("loop_canary"),
            compilation_options: Default::default(),
            cache: None,
        });
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("loop_canary"),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: counts.binding(),
            }],
        });
        let mut encoder = device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups(EXPECTED.len() as u32, 1, 1);
        }
        encoder.copy_buffer_to_buffer(counts.raw(), 0, staging.raw(), 0, 16);
        context.queue.submit([encoder.finish()]);
    })?;
    let ran: [u32; 4] = context.read(staging.raw(), bytemuck::pod_read_unaligned)?;
    let canaries = EXPECTED
        .iter()
        .zip(ran)
        .map(|(&(shape, expected), ran)| LoopCanary {
            shape,
            expected,
            ran,
        });
    Ok(LoopBudget {
        canaries: canaries.collect(),
    })
}
