//! `shaders/lab/circle.wesl`.

use crate::support::shader::{Function, call, words};
use crate::support::{context, edge_points};

#[test]
fn hits_and_heights_are_those_of_f64() {
    let function = Function {
        imports: "import package::lab::circle::{circle_hit, circle_height};",
        body: "out_f32(0u, circle_hit(in_vec2f(0u)));
               out_f32(1u, circle_height(in_f32(0u)));",
        inputs: 2,
        outputs: 2,
        features: &[],
    };
    let points = edge_points();
    let items: Vec<f64> = points.iter().flat_map(|p| [p.x, p.y]).collect();
    let answers = call(context(), &function, &words(&items));
    for (p, (hit, height)) in points.iter().zip(answers.f64(0).zip(answers.f64(1))) {
        let square = p.length_squared();
        // Within rounding of the circle either answer is right.
        if (square - 1.0).abs() > 1e-6 {
            assert_eq!(hit, if square < 1.0 { 4.0 } else { 0.0 }, "{p}");
        }
        let due = 4.0 * ((1.0 - p.x) * (1.0 + p.x)).sqrt();
        assert!((height - due).abs() <= 1e-6 * due, "{p}: {height} {due}");
    }
}
