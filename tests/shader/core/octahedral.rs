//! `shaders/core/octahedral.wesl`.

use crate::support::context;
use crate::support::random::Random;
use crate::support::rounding::{U, assert_all_near};
use crate::support::shader::{Function, call, words};
use direkt::low_level::accel::octahedral::octahedral;
use direkt::low_level::reference::core::octahedral::from_octahedral;
use glam::{DVec2, DVec3};

/// 1 − |x| − |y| rounds twice, and folding by it twice more.
#[test]
fn vectors_are_the_twins() {
    let context = context();
    let function = Function {
        imports: "import package::core::octahedral::from_octahedral;",
        body: "out_vec3f(0u, from_octahedral(in_vec2f(0u)));",
        inputs: 2,
        outputs: 3,
        features: &[],
    };
    let mut random = Random::new(61);
    let mut normals: Vec<DVec3> = (0..100_000).map(|_| random.direction()).collect();
    normals.extend([
        DVec3::X,
        DVec3::Y,
        DVec3::Z,
        -DVec3::X,
        -DVec3::Y,
        -DVec3::Z,
    ]);
    let encoded: Vec<DVec2> = normals
        .iter()
        .map(|n| octahedral(*n).as_vec2().as_dvec2())
        .collect();
    let inputs: Vec<f64> = encoded.iter().flat_map(|p| p.to_array()).collect();
    let answers = call(context, &function, &words(&inputs));
    for ((p, n), got) in encoded.iter().zip(&normals).zip(answers.vec3(0)) {
        let what = format!("{}: {n}", context.adapter.name);
        assert_all_near(got, from_octahedral(*p), 4.0 * U, &what);
        assert!(got.normalize().distance(*n) < 8.0 * U, "{what}: {got}");
    }
}
