//! `shaders/core/pdf.wesl`.

use crate::support::context;
use crate::support::hard_cases::{Measured, survive};
use crate::support::random::Random;
use crate::support::rounding::{U, assert_near};
use crate::support::shader::{Function, call, words};
use direkt::low_level::reference::BrokenTwin;
use direkt::low_level::reference::core::pdf::{
    PdfArea, PdfDiscrete, PdfSolidAngle, area_to_solid_angle, chosen, power_heuristic,
};

/// A product and a quotient, 6 U, and the guard 1e-12 rounded; the probability of a choice is one
/// product.
#[test]
fn densities_are_converted_like_the_twins() {
    let context = context();
    let function = Function {
        imports: "import package::core::pdf::{
                      ExpectedSamples, PdfArea, PdfSolidAngle, area_to_solid_angle, of_samples
                  };",
        body: "out_f32(0u, area_to_solid_angle(PdfArea(in_f32(0u)), in_f32(1u), in_f32(2u)).value);
               out_f32(1u, of_samples(ExpectedSamples(in_f32(3u)), PdfSolidAngle(in_f32(0u))).value);",
        inputs: 4,
        outputs: 2,
        features: &[],
    };
    let mut random = Random::new(17);
    let grazing = [1e-30, 1e-13, 1e-12, 1e-8, 1.0].map(|c| f64::from(c as f32));
    let mut cases: Vec<[f64; 4]> = grazing.map(|c| [2.0, 0.25, c, 0.0]).to_vec();
    cases.extend((0..20_000).map(|_| {
        let pdf = random.magnitude(1e-9, 1e9);
        let distance_squared = random.magnitude(1e-12, 1e12);
        [pdf, distance_squared, random.uniform(), random.uniform()]
    }));
    let inputs: Vec<f64> = cases.iter().flatten().copied().collect();
    let answers = call(context, &function, &words(&inputs));
    let results = answers.f64(0).zip(answers.f64(1));
    for (&[pdf, distance_squared, cos, choice], (there, with_choice)) in cases.iter().zip(results) {
        let what = format!(
            "{}: {pdf} {distance_squared} {cos} {choice}",
            context.adapter.name
        );
        let expected = area_to_solid_angle(PdfArea(pdf), distance_squared, cos).0;
        assert_near(there, expected, 7.0 * U * expected, &what);
        let expected = chosen(PdfDiscrete(choice), PdfSolidAngle(pdf)).0;
        assert_near(with_choice, expected, U * expected, &what);
    }
}

/// HARD CASES M1. The ratio r is off by 5 U, r² by 11 U; 1/(1 + r²) by r²/(1 + r²) ≤ ½ of that, a
/// sum and a quotient: 12 U, and its product with r² by 24 U. Squares below 2⁻¹²⁶ may be flushed to
/// zero.
#[test]
fn power_heuristic_is_the_twins_at_every_magnitude() {
    let context = context();
    let function = Function {
        imports: "import package::core::pdf::{PdfSolidAngle, power_heuristic};",
        body: "let a = PdfSolidAngle(in_f32(0u));
               let b = PdfSolidAngle(in_f32(1u));
               out_f32(0u, power_heuristic(a, b));
               out_f32(1u, power_heuristic(b, a));
               let squares = vec2f(a.value * a.value, b.value * b.value);
               out_vec2f(2u, squares / (squares.x + squares.y));",
        inputs: 2,
        outputs: 4,
        features: &[],
    };
    let mut random = Random::new(18);
    let mut cases = vec![
        [0.0, 0.0],
        [0.0, 1.0],
        [0.0, 1e-30],
        [0.0, 1e30],
        [1e-25, 1e30],
    ];
    for exponent in -25..=30 {
        let x = 10_f64.powi(exponent);
        cases.push([x, x]);
    }
    cases.extend(
        (0..50_000).map(|_| [random.magnitude(1e-25, 1e30), random.magnitude(1e-25, 1e30)]),
    );
    cases.extend((0..50_000).map(|_| {
        let a = random.magnitude(1e-25, 1e30);
        [a, a * random.magnitude(0.1, 10.0)]
    }));
    let cases: Vec<[f64; 2]> = cases
        .iter()
        .map(|c| c.map(|x| f64::from(x as f32)))
        .collect();
    let inputs: Vec<f64> = cases.iter().flatten().copied().collect();
    let answers = call(context, &function, &words(&inputs));
    let sum_is_one = |a: f64, b: f64| (a + b - 1.0).abs() <= 1e-6;
    for (&[a, b], (of_a, of_b)) in cases.iter().zip(answers.f64(0).zip(answers.f64(1))) {
        let what = format!("{}: {a} {b}", context.adapter.name);
        for (weight, a, b) in [(of_a, a, b), (of_b, b, a)] {
            let expected = power_heuristic(PdfSolidAngle(a), PdfSolidAngle(b));
            let flushed = (-126_f64).exp2();
            assert_near(weight, expected, 24.0 * U * expected + flushed, &what);
        }
        if a == 0.0 && b == 0.0 {
            assert_eq!((of_a, of_b), (0.0, 0.0), "{what}");
            continue;
        }
        assert!(sum_is_one(of_a, of_b), "{what}: {of_a} + {of_b}");
        let broken = |w| BrokenTwin::weight(Some(BrokenTwin::MisWeights), w);
        assert!(!sum_is_one(broken(of_a), broken(of_b)), "{what}");
        if a == b {
            assert_near(of_a, 0.5, 6.0 * U, &what);
        }
    }
    let wrong = |word| {
        let pairs = cases.iter().zip(answers.vec2(word));
        let pairs = pairs.filter(|(case, w)| **case != [0.0; 2] && !sum_is_one(w.x, w.y));
        pairs.count() as f64
    };
    survive(
        context,
        Measured {
            entry: "M1",
            case: "100,060 pairs of densities from 10⁻²⁵ to 10³⁰",
            figure: "pairs whose weights do not sum to 1",
            bound: 0.0,
            textbook: "a²/(a² + b²)",
            naive: wrong(2),
            ours: wrong(0),
        },
    );
}
