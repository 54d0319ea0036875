//! `shaders/light/spot.wesl`.

use crate::support::context;
use crate::support::random::Random;
use crate::support::rounding::{U, assert_near};
use crate::support::shader::{Function, call, words};
use direkt::low_level::reference::light::spot::spot_falloff;

const FALLOFF: Function<'_> = Function {
    imports: "import package::light::spot::spot_falloff;",
    body: "out_f32(0u, spot_falloff(in_f32(0u), in_f32(1u), in_f32(2u)));",
    inputs: 3,
    outputs: 1,
    features: &[],
};

/// The argument of the square is off by a relative 3 U (a difference, the stored reciprocal and a
/// product), its square by 7 U; where the argument is 1 or more, so is the rounded one but for
/// that.
#[test]
fn spot_falloff_is_the_twins() {
    let context = context();
    let mut random = Random::new(5);
    let mut cases = Vec::new();
    for _ in 0..20_000 {
        let outer = random.between(-1.0, 1.0);
        let inner = f64::from((outer + random.magnitude(1e-6, 2.0)).min(1.0) as f32);
        if inner > outer {
            // At, just beside and between the cones, and anywhere.
            let cosines = [
                outer,
                outer - U,
                outer + U,
                inner,
                inner - U,
                random.between(outer, inner),
                random.between(-1.0, 1.0),
            ];
            cases.extend(cosines.map(|c| [f64::from(c as f32), inner, outer]));
        }
    }
    let inputs: Vec<f64> = cases
        .iter()
        .flat_map(|&[cos, inner, outer]| [cos, outer, 1.0 / (inner - outer).max((-20_f64).exp2())])
        .collect();
    let answers = call(context, &FALLOFF, &words(&inputs));
    for ([cos, inner, outer], f) in cases.iter().zip(answers.f64(0)) {
        let expected = spot_falloff(*cos, *inner, *outer);
        let what = format!(
            "{}: {cos} between {inner} and {outer}",
            context.adapter.name
        );
        assert_near(f, expected, 7.0 * U * expected, &what);
        assert!((0.0..=1.0).contains(&f), "{what}");
    }
}

/// HARD CASES S7: equal angles make a step, wide 2⁻²⁰ in the cosine.
#[test]
fn equal_angles_of_a_spot_make_a_step() {
    let context = context();
    let step = 20_f64.exp2();
    let cosines = [-1.0, -0.25, 0.0, 0.5, f64::from(0.75_f32.sqrt())];
    let inputs: Vec<f64> = cosines
        .iter()
        .flat_map(|&outer| {
            let beside = [-1.0, outer, outer + 1.0 / step, 1.0];
            beside.map(|cos| [cos, outer, step])
        })
        .flatten()
        .collect();
    let answers: Vec<f64> = call(context, &FALLOFF, &words(&inputs)).f64(0).collect();
    for (outer, f) in cosines.iter().zip(answers.chunks_exact(4)) {
        assert_eq!(f, [0.0, 0.0, 1.0, 1.0], "outer cosine {outer}");
    }
}
