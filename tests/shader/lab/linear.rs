//! `shaders/lab/linear.wesl`.

use crate::support::context;
use crate::support::shader::{Function, call, words};
use direkt_instruments::lab::importance::ROWS;

/// The distribution function of the sample is the number it was made from, also at the ends.
#[test]
fn samples_invert_the_distribution_function() {
    let function = Function {
        imports: "import package::lab::linear::{sample_linear, pdf_linear};",
        body: "let x = sample_linear(in_f32(0u), in_vec2f(1u));
               out_f32(0u, x);
               out_f32(1u, pdf_linear(x, in_vec2f(1u)));",
        inputs: 3,
        outputs: 2,
        features: &[],
    };
    let tiny = (-24_f64).exp2();
    let numbers: Vec<f64> = [tiny, 1e-3, 1.0 - tiny, 1.0]
        .into_iter()
        .chain((1..100).map(|i| f64::from(i) / 100.0))
        .map(|u| f64::from(u as f32))
        .collect();
    for row in ROWS {
        let (a, b) = (row.density.constant, row.density.slope);
        let items: Vec<f64> = numbers.iter().flat_map(|&u| [u, a, b]).collect();
        let answers = call(context(), &function, &words(&items));
        for ((x, pdf), u) in answers.f64(0).zip(answers.f64(1)).zip(&numbers) {
            assert!((0.0..=4.0).contains(&x), "{} {u}: {x}", row.name);
            let below = a * x + 0.5 * b * x * x;
            assert!((below - u).abs() < 1e-6, "{} {u}: {below}", row.name);
            assert!((pdf - (a + b * x)).abs() < 1e-7);
            assert!(
                pdf > 0.0,
                "{} {u}: a sample divides by its density",
                row.name
            );
        }
    }
}
