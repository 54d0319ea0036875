//! `shaders/kernel/lab_discrete.wesl`: χ² of all four ways to sample a discrete distribution.

use crate::support::context;
use crate::support::statistics::{accept, reject};
use direkt::low_level::stats::chi2::{Totals, chi2_test};
use direkt::low_level::stats::z_test::z_test;
use direkt_instruments::lab::Settings;
use direkt_instruments::lab::bench::Bench;
use direkt_instruments::lab::densities::Discrete;
use direkt_instruments::lab::sampling::draw_discrete;

#[test]
fn indices_and_steps_follow_their_distribution_and_no_other() {
    let context = context();
    let bench = Bench::new(context, "lab_discrete").unwrap();
    let settings = Settings {
        seed: 55,
        ..Settings::default()
    };
    for distribution in Discrete::all() {
        for variant in 0..4 {
            let blocks = draw_discrete(&bench, &settings, &distribution, variant).unwrap();
            let n = blocks.len() as f64;
            let mut counts = vec![0; distribution.probability.len()];
            for block in &blocks {
                counts[block.mean as usize] += 1;
            }
            let p = |probability: &[f64]| {
                let expected: Vec<f64> = probability.iter().map(|p| n * p).collect();
                let test = chi2_test(&counts, &expected, Totals::Tied);
                test.unwrap().p_value
            };
            let what = format!("{}, variant {variant}, seed 55", distribution.name);
            accept(p(&distribution.probability), &what);
            // 2 % of the likeliest outcome moved to the last one.
            let mut moved = distribution.probability.clone();
            let likeliest = (0..moved.len())
                .max_by(|&a, &b| moved[a].total_cmp(&moved[b]))
                .unwrap();
            let part = 0.02 * moved[likeliest];
            moved[likeliest] -= part;
            *moved.last_mut().unwrap() += part;
            reject(p(&moved), &what);
            let due = distribution.steps(variant as usize);
            let steps = blocks.iter().map(|b| f64::from(b.tries)).sum::<f64>() / n;
            let variance = (due.square - due.mean * due.mean).max(0.0) / n;
            accept(z_test(steps, due.mean, variance, 1e-9).p_value, &what);
        }
    }
}
