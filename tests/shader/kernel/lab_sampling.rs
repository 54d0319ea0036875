//! `shaders/kernel/lab_sampling.wesl`: χ² of both ways to sample every density.

use crate::support::context;
use crate::support::statistics::{accept, reject};
use direkt_instruments::lab::Settings;
use direkt_instruments::lab::bench::Bench;
use direkt_instruments::lab::densities::DENSITIES;
use direkt_instruments::lab::sampling::{CELLS, check_histogram, draw, histogram};

#[test]
fn samples_follow_their_density_and_no_other() {
    let context = context();
    let bench = Bench::new(context, "lab_sampling").unwrap();
    let settings = Settings {
        seed: 54,
        ..Settings::default()
    };
    for (i, density) in DENSITIES.iter().enumerate() {
        let edges = density.edges(CELLS);
        let [low, high] = density.interval;
        for variant in 0..2 {
            let blocks = draw(&bench, &settings, i, variant).unwrap();
            let counts = histogram(&blocks, &edges);
            let p = |cdf: &dyn Fn(f64) -> f64| {
                check_histogram(String::new(), &counts, &edges, cdf).p_value
            };
            let what = format!("{}, variant {variant}, seed 54", density.name);
            accept(p(&density.cdf), &what);
            // 2 % of the samples moved towards the uniform density.
            let mixed = |x: f64| 0.98 * (density.cdf)(x) + 0.02 * (x - low) / (high - low);
            reject(p(&mixed), &what);
        }
    }
}
