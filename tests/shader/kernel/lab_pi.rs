//! `shaders/kernel/lab_pi.wesl`.

use crate::support::context;
use crate::support::statistics::{accept, reject};
use direkt::low_level::stats::z_test::z_test;
use direkt_instruments::lab::Settings;
use direkt_instruments::lab::bench::Bench;
use direkt_instruments::lab::layout::merged;
use direkt_instruments::lab::pi::{draw, methods};
use std::f64::consts::PI;

#[test]
fn both_ways_estimate_pi_with_their_variance() {
    let context = context();
    let bench = Bench::new(context, "lab_pi").unwrap();
    let settings = Settings {
        seed: 52,
        ..Settings::default()
    };
    for (method, variant) in methods().iter().zip(0..) {
        let found = merged(&draw(&bench, &settings, variant).unwrap().blocks);
        let variance = method.variance / found.count as f64;
        let p = |mean: f64, expected| z_test(mean, expected, variance, 1e-5).p_value;
        accept(p(found.mean, PI), &format!("{}, seed 52", method.name));
        reject(
            p(1.02 * found.mean, PI),
            &format!("{}, 2 % more", method.name),
        );
    }
}

#[test]
fn points_kept_took_the_attempts_of_a_geometric_distribution() {
    let context = context();
    let bench = Bench::new(context, "lab_pi").unwrap();
    let settings = Settings {
        seed: 53,
        ..Settings::default()
    };
    let blocks = draw(&bench, &settings, 2).unwrap().blocks;
    let tries: u64 = blocks.iter().map(|b| u64::from(b.tries)).sum();
    let n = merged(&blocks).count as f64;
    let p = PI / 4.0;
    let variance = (1.0 - p) / (p * p) / n;
    let test = |expected| z_test(tries as f64 / n, expected, variance, 0.0).p_value;
    accept(test(4.0 / PI), "attempts per point, seed 53");
    reject(test(1.02 * 4.0 / PI), "attempts per point, 2 % more");
}
