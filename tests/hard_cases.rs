//! `docs/hard-cases.md` and what it is made of.

mod accumulation;
mod cameras;
mod corner;
mod device;
mod extreme;
pub(crate) mod extreme_scenes;
mod hierarchy;
mod horizon;
mod input;
mod irradiance;
mod lights;
mod meshes;
mod microfacets;
mod moved;
mod ray_ends;
mod samplers;
mod solid_angles;
mod weights;

use crate::support::hard_cases::HardCase;
use crate::support::hard_cases::document::{missing, page, results, text_of};

#[test]
fn the_page_is_made_of_the_results_and_they_are_complete() {
    let results = results();
    assert!(results.len() >= 2, "results of two drivers at least");
    for of_driver in &results {
        let missing = missing(of_driver.cases.iter());
        assert!(missing.is_empty(), "{}: {missing:?}", of_driver.driver);
        for case in &of_driver.cases {
            assert!(case.ours <= case.bound, "{}: {case:?}", of_driver.driver);
            let fails = |c: &HardCase| c.naive.is_none_or(|n| n > c.bound);
            let same = |c: &&HardCase| c.case == case.case && c.figure == case.figure;
            let mut everywhere = results.iter().flat_map(|r| &r.cases).filter(same);
            assert!(
                fails(case) || case.by_driver && everywhere.any(fails),
                "{}: {case:?}",
                of_driver.driver
            );
        }
    }
    let written = std::fs::read_to_string(page()).unwrap();
    assert_eq!(written, text_of(&results), "docs/hard-cases.md");
}

/// The largest of errors; NaN where one is not finite.
pub(crate) fn worst(errors: impl Iterator<Item = f64>) -> f64 {
    errors.fold(0.0, |worst: f64, x| {
        if (worst + x).is_finite() {
            worst.max(x)
        } else {
            f64::NAN
        }
    })
}
