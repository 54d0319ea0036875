//! `docs/hard-cases.md` and what it is made of.

mod accumulation;
mod corner;
mod hierarchy;
mod horizon;
mod input;
mod meshes;
mod moved;
mod ray_ends;

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
            assert!(
                case.naive.is_none_or(|n| n > case.bound),
                "{}: {case:?}",
                of_driver.driver
            );
        }
    }
    let written = std::fs::read_to_string(page()).unwrap();
    assert_eq!(written, text_of(&results), "docs/hard-cases.md");
}
