//! `shaders/kernel/light_groups.wesl`; its images are in `tests/render/light_groups.rs`.

use crate::support::shader::{Function, call_in};
use crate::support::{context, prepared, scene};
use direkt::scene::{Aov, Scene};
use glam::DVec3;

fn grouped() -> Scene {
    let mut scene = scene("scenes/tests/light_groups.toml");
    scene.render.aovs = [Aov::LightGroups].into_iter().collect();
    scene
}

const IMPORTS: &str = "import package::kernel::light_groups::{
    accumulate_light_groups, add_emitted, add_reflected, group_of_light, group_throughput, start_light_groups};
    import package::scene::bindings::light_group_means;";

/// Means over samples of what was added; a sample that is taken again, or dropped, counts once or
/// not at all.
#[test]
fn means_take_each_sample_once() {
    let function = Function {
        imports: IMPORTS,
        body: "start_light_groups();
               add_emitted(1u, vec3f(1.0, 2.0, 3.0));
               group_throughput = vec3f(0.5);
               add_reflected(1u, vec3f(2.0));
               add_reflected(3u, vec3f(8.0));
               accumulate_light_groups(0u, 1u, vec3f(6.0));
               accumulate_light_groups(0u, 1u, vec3f(6.0));
               start_light_groups();
               add_emitted(3u, vec3f(6.0));
               accumulate_light_groups(0u, 2u, vec3f(in_f32(0u)));
               accumulate_light_groups(0u, 2u, vec3f(6.0));
               out_vec3f(0u, bitcast<vec3f>(light_group_means[0].xyz));
               out_vec3f(3u, bitcast<vec3f>(light_group_means[1].xyz));
               out_vec3f(6u, bitcast<vec3f>(light_group_means[3].xyz));
               out_u32(9u, light_group_means[3].w);",
        inputs: 1,
        outputs: 10,
        ..Function::default()
    };
    for dropped in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let prepared = prepared(grouped());
        let answers = call_in(context(), &prepared, &function, &[dropped.to_bits()], 1);
        let word = |i| answers.vec3(i).next().unwrap();
        assert_eq!(word(0), DVec3::ZERO);
        assert_eq!(word(3), DVec3::new(1.0, 1.5, 2.0));
        assert_eq!(word(6), DVec3::splat(5.0));
        assert_eq!(answers.u32(9).next().unwrap(), 2);
    }
}

/// Every light has the group that the scene gives it.
#[test]
fn lights_know_their_groups() {
    let prepared = prepared(grouped());
    let lights = prepared.emitters.lights.len();
    let function = Function {
        imports: IMPORTS,
        body: "out_u32(0u, group_of_light(item));",
        outputs: 1,
        ..Function::default()
    };
    let answers = call_in(context(), &prepared, &function, &[], lights);
    let expected = (0..lights).map(|light| prepared.emitters.groups.of_light(light));
    let found: Vec<u32> = answers.u32(0).collect();
    assert_eq!(found, expected.collect::<Vec<_>>());
    assert_eq!(found, [0, 1, 3, 2]);
}
