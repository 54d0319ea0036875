//! `shaders/kernel/sample_record.wesl`.

use crate::support::context;
use crate::support::shader::{Function, draw};
use direkt::low_level::gpu::layout::{NONE, NOT_TRACED, SampleRecord};
use direkt::scene::shadow_rays::MAX_LIGHT_SAMPLES;
use glam::DVec3;

const WRITE: &str = "out_vec3f(0u, recorded.radiance); out_u32(3u, recorded.shadow);
    out_vec3f(4u, recorded.by_light); out_u32(7u, recorded.camera_primitive);
    out_vec3f(8u, recorded.by_bsdf); out_u32(11u, recorded.bsdf_primitive);";

fn record(steps: &str) -> ([DVec3; 3], [u32; 3]) {
    let function = Function {
        imports: "import package::kernel::sample_record::{
            record_bsdf_hit, record_camera_hit, record_parts, record_shadow, record_way, recorded, start_record};",
        body: &format!("{steps} {WRITE}"),
        outputs: 12,
        features: &["RECORD"],
        ..Function::default()
    };
    let answers = draw(context(), &function, 1);
    (
        [0, 4, 8].map(|word| answers.vec3(word).next().unwrap()),
        [3, 7, 11].map(|word| answers.u32(word).next().unwrap()),
    )
}

#[test]
fn a_record_begins_with_nothing_traced() {
    let (radiance, met) = record("record_shadow(true); start_record();");
    assert_eq!(radiance, [DVec3::ZERO; 3]);
    assert_eq!(met, [0, NONE, NOT_TRACED]);
}

#[test]
fn each_step_notes_its_own_part() {
    let (radiance, met) = record(
        "start_record(); record_camera_hit(0u, 5u); record_shadow(false); record_bsdf_hit(7u);
         record_parts(vec3f(1.0, 2.0, 3.0), vec3f(4.0, 5.0, 6.0));",
    );
    let parts = [
        DVec3::ZERO,
        DVec3::new(1.0, 2.0, 3.0),
        DVec3::new(4.0, 5.0, 6.0),
    ];
    assert_eq!(radiance, parts);
    assert_eq!(rays(met[0]), [1, 1]);
    assert_eq!(met[1..], [5, 7]);
    let (_, met) = record("start_record(); record_shadow(true);");
    assert_eq!(rays(met[0]), [1, 0]);
    assert_eq!(met[1..], [NONE, NOT_TRACED]);
}

/// The first primitive is noted as it is; with those that follow and the ways between, all is told
/// apart.
#[test]
fn further_camera_rays_make_a_hash() {
    let met = |steps: &str| record(&format!("start_record(); {steps}")).1[1];
    let first = "record_camera_hit(0u, 5u);";
    assert_eq!(met(first), 5);
    assert_eq!(met("record_camera_hit(0u, 5u); record_way(0u);"), 5);
    let twin = (5 ^ (1_u32 << 30))
        .wrapping_mul(0x9e37_79b1)
        .wrapping_add(7);
    let both = |way: u32, second: u32| {
        met(&format!(
            "{first} record_way({way}u); record_camera_hit(1u, {second}u);"
        ))
    };
    assert_eq!(both(1, 7), twin);
    let others = [both(2, 7), both(1, 8), both(2, 8), both(1, NONE)];
    assert!(!others.contains(&twin), "{others:?}");
}

/// As many shadow rays as a camera ray may have.
#[test]
fn shadow_rays_are_counted() {
    let most = u32::try_from(MAX_LIGHT_SAMPLES).unwrap();
    for (traced, clear) in [(7, 3), (most, most), (most, 0), (most, 1)] {
        let steps = format!(
            "start_record();
             for (var i = 0u; i < {traced}u; i += 1u) {{ record_shadow(i >= {clear}u); }}"
        );
        let (_, met) = record(&steps);
        assert_eq!(rays(met[0]), [traced, clear]);
    }
}

/// Traced and clear.
fn rays(shadow: u32) -> [u32; 2] {
    let record = SampleRecord {
        shadow,
        ..SampleRecord::default()
    };
    [record.shadow_rays(), record.clear_shadow_rays()]
}
