//! `shaders/lab/estimators.wesl`: estimates of a few samples against the same in f64.

use crate::support::context;
use crate::support::shader::{Function, draw};
use direkt::low_level::reference::core::rng::{pcg4d, to_unit};

const COUNT: u32 = 12;

/// Value and weight as the papers write them.
fn sample(estimator: u32, index: u32, words: [u32; 4]) -> (f64, f64) {
    let u = 1.0 - to_unit(words[0]);
    match estimator {
        2 => {
            // x² + 4x = 32u.
            let x = (4.0 + 32.0 * u).sqrt() - 2.0;
            (x * 16.0 / (x + 2.0), 1.0)
        }
        4 => {
            // 12x − x² = 32u.
            let x = 6.0 - (36.0 - 32.0 * u).sqrt();
            let weight = 16.0 / (6.0 - x);
            (weight * x, weight)
        }
        5 => (4.0 * u, 1.0),
        7 => ((16.0 * u).min(12.0), 1.0),
        8 => (16.0, 1.0),
        9 => (4.0 * (f64::from(index % 4) + 0.5).powi(2), 1.0),
        10 => (9.0 * u, 1.0),
        11 => {
            let low = (f64::from(words[1]) + 0.5) / 4_294_967_296.0;
            let fine = (f64::from(words[0]) + low) / 4_294_967_296.0;
            (fine.powf(-2.0 / 3.0) / 3.0, 1.0)
        }
        _ => (16.0 * u, 1.0),
    }
}

fn estimate(estimator: u32, samples: &[(f64, f64)]) -> f64 {
    let n = samples.len() as f64;
    let mean = samples.iter().map(|s| s.0).sum::<f64>() / n;
    let weight = samples.iter().map(|s| s.1).sum::<f64>() / n;
    match estimator {
        1 => samples[0].0,
        3 => 1.0 / mean,
        4 => 4.0 * mean / weight,
        5 => samples.iter().map(|s| s.0).fold(0.0, f64::max),
        6 => samples.iter().map(|s| (s.0 - mean).powi(2)).sum::<f64>() / n,
        _ => mean,
    }
}

#[test]
fn estimates_are_those_of_f64() {
    let context = context();
    let function = Function {
        imports: "import package::core::rng::pcg4d;
                  import package::lab::estimators::{estimator_sample, empty_tally, push_sample, estimate};",
        body: "let estimator = item % 12u;
               var tally = empty_tally();
               for (var i = 0u; i < 20u; i++) {
                   let words = pcg4d(vec4u(item, i, 3u, 4u));
                   tally = push_sample(tally, estimator_sample(estimator, i, words.xy, 1.0));
               }
               out_f32(0u, estimate(estimator, tally));",
        inputs: 0,
        outputs: 1,
        features: &[],
    };
    let answers = draw(context, &function, 100 * COUNT as usize);
    for (found, item) in answers.f64(0).zip(0_u32..) {
        let estimator = item % COUNT;
        let samples: Vec<(f64, f64)> = (0..20)
            .map(|i| sample(estimator, i, pcg4d([item, i, 3, 4])))
            .collect();
        let due = estimate(estimator, &samples);
        // Twenty running means, and log2 and exp2 of a number whose logarithm is below 64.
        assert!(
            (found / due - 1.0).abs() < 2e-5,
            "{}: estimator {estimator}, item {item}: {found} {due}",
            context.adapter.name
        );
    }
}
