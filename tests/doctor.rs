//! What the driver does to a shader.

use crate::support::context;
use crate::support::hard_cases::{Measured, survive, survive_by_driver};
use direkt::low_level::gpu::doctor::arithmetic::arithmetic;
use direkt::low_level::gpu::doctor::examine;
use direkt::low_level::gpu::doctor::loads::loads;
use direkt::low_level::gpu::doctor::loops::loop_budget;
use direkt::low_level::gpu::doctor::precision::sweep;
use direkt::low_level::gpu::shader::{KernelConstants, link};

#[test]
fn every_canary_counts_and_only_known_drivers_cut_loops() {
    let context = context();
    let budget = loop_budget(context).unwrap();
    for canary in &budget.canaries {
        assert!(
            canary.ran > 0 && canary.ran <= canary.expected,
            "{}: {canary:?}",
            context.adapter.name
        );
    }
    // Mesa 22's lavapipe ends all loops of an invocation after 65,535 iterations; nothing else is
    // known to.
    let old_lavapipe = context.adapter.software && context.adapter.driver.contains("Mesa 22.");
    assert_eq!(
        budget.is_unlimited(),
        !old_lavapipe,
        "{:?}: {budget:?}",
        context.adapter
    );
}

/// HARD CASES P1.
#[test]
fn bits_tell_what_comparisons_do_not() {
    let context = context();
    let found = arithmetic(context).unwrap();
    survive(
        context,
        Measured {
            entry: "P1",
            case: "16 numbers, among them NaNs of either sign, quiet and signalling",
            figure: "misread as a number of another kind",
            bound: 0.0,
            textbook: "x < −3.4e38 || x > 3.4e38",
            naive: f64::from(found.passed_by_range),
            ours: f64::from(found.misclassified),
        },
    );
    survive_by_driver(
        context,
        Measured {
            entry: "P1",
            case: "the same",
            figure: "misread as a number of another kind",
            bound: 0.0,
            textbook: "x != x, |x| > 3.4e38",
            naive: f64::from(found.misclassified_by_comparison),
            ours: f64::from(found.misclassified),
        },
    );
}

/// HARD CASES P3.
#[test]
fn elementary_functions_are_as_accurate_as_promised() {
    let context = context();
    let found = sweep(context).unwrap();
    for p in &found {
        assert!(
            p.is_within() || !p.needed,
            "{}: {p:?}",
            context.adapter.driver
        );
    }
    let error = |name: &str| {
        let function = found.iter().find(|p| p.function == name);
        function.unwrap().absolute
    };
    for theirs in ["acos", "atan2"] {
        survive(
            context,
            Measured {
                entry: "P3",
                case: "angles at 2¹⁶ arguments",
                figure: "largest absolute error",
                bound: 7e-7,
                textbook: &format!("the driver's {theirs}"),
                naive: error(theirs),
                ours: error("direkt's angle_of"),
            },
        );
    }
}

/// HARD CASES L4: a shader that asks for subgroups does not compile everywhere; direkt's ask for
/// none.
#[test]
fn no_shader_needs_subgroups() {
    let context = context();
    let config = KernelConstants::default();
    let wgsl = link("kernel::loop_canary", [], &config).unwrap();
    let asking = format!("enable subgroups;\n{wgsl}");
    let compiles = context.checked(|| {
        context
            .device
            .create_shader_module(wgpu::ShaderModuleDescriptor {
                label: None,
                source: wgpu::ShaderSource::Wgsl(asking.into()),
            })
    });
    let shaders = include_dir::include_dir!("$CARGO_MANIFEST_DIR/../../shaders");
    let asks = |file: &include_dir::File<'_>| {
        let text = file.contents_utf8().unwrap();
        text.contains("subgroup")
    };
    let of_folder = |d: &include_dir::Dir<'_>| d.files().filter(|f| asks(f)).count();
    let ours: usize = shaders.dirs().map(of_folder).sum();
    survive_by_driver(
        context,
        Measured {
            entry: "L4",
            case: "a device without the feature for subgroups",
            figure: "shaders that do not compile",
            bound: 0.0,
            textbook: "enable subgroups",
            naive: f64::from(u8::from(compiles.is_err())),
            ours: ours as f64,
        },
    );
}

#[test]
fn an_adapter_that_does_not_exist_is_not_examined() {
    assert!(examine(Some("no adapter has this name")).is_empty());
    assert!(!examine(None).is_empty());
}

#[test]
fn loads_take_time() {
    let context = context();
    let found = loads(context).unwrap();
    let times = [found.own_nanoseconds, found.shared_nanoseconds];
    // A thousandth of a nanosecond is a trillion a second.
    assert!(
        times.iter().all(|t| (1e-5..1e4).contains(t)),
        "{:?}: {found:?}",
        context.adapter
    );
}
