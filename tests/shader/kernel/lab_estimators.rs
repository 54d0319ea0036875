//! `shaders/kernel/lab_estimators.wesl`: bias and variance of every estimator.

use crate::support::context;
use crate::support::statistics::{accept, reject};
use direkt_instruments::lab::Settings;
use direkt_instruments::lab::bench::Bench;
use direkt_instruments::lab::estimators::{Class, ESTIMATORS, checks, draw, light_tail_checks};

const SETTINGS: Settings = Settings {
    samples: 1 << 20,
    seed: 57,
    density_scale: 1.0,
};

#[test]
fn bias_and_variance_are_exact() {
    let context = context();
    let bench = Bench::new(context, "lab_estimators").unwrap();
    for estimator in &ESTIMATORS {
        for samples in [8, 128] {
            let estimates = draw(&bench, &SETTINGS, estimator, samples, 20_000).unwrap();
            let all = checks(estimator, samples, &estimates);
            assert_eq!(all.is_empty(), estimator.class == Class::InfiniteVariance);
            for check in all {
                accept(check.p_value, &format!("{check:?}, seed 57"));
            }
            let scaled: Vec<f64> = estimates.iter().map(|e| 1.02 * e).collect();
            if samples == 128
                && estimator.class != Class::InfiniteVariance
                && estimator.variant != 1
            {
                let p = checks(estimator, samples, &scaled)[0].p_value;
                reject(p, &format!("{}, 2 % too large", estimator.name));
            }
        }
    }
}

#[test]
fn the_heavy_tailed_sample_has_its_distribution() {
    let context = context();
    let bench = Bench::new(context, "lab_estimators").unwrap();
    let tail = &ESTIMATORS[ESTIMATORS.len() - 1];
    let samples = draw(&bench, &SETTINGS, tail, 1, 1 << 20).unwrap();
    for check in light_tail_checks(&samples) {
        accept(check.p_value, &format!("{check:?}, seed 57"));
    }
    let scaled: Vec<f64> = samples.iter().map(|w| 1.02 * w).collect();
    for check in light_tail_checks(&scaled) {
        reject(check.p_value, &format!("{check:?}, 2 % too large"));
    }
}
