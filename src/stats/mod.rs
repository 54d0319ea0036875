//! Tests of hypotheses that decide whether samples agree with what they should be.
//!
//! Every test returns a p-value: the probability, when the samples are right, of a result at least
//! as far off. A suite rejects when a p-value is below the level that a [`Family`](sidak::Family)
//! gives each of its tests, so that the whole suite raises a false alarm with probability
//! [`FAMILY_LEVEL`](sidak::FAMILY_LEVEL) only.
//!
//! | question | test |
//! |---|---|
//! | do counts follow a density? | [`chi2::chi2_test`] |
//! | is a mean right, its variance known? | [`z_test::z_test`] |
//! | is a mean right, its variance estimated? | [`t_test::one_sample`] |
//! | are two means equal? | [`t_test::welch`] |
//! | are two estimators of one integrand equal, however heavy their tails? | [`symmetric::symmetric_test`] |
//! | do many z-scores follow the normal distribution? | [`kolmogorov::normality_test`] |

pub mod chi2;
pub mod interval;
pub mod kolmogorov;
pub mod moments;
pub mod pairs;
pub mod sidak;
pub(crate) mod sums;
pub mod symmetric;
pub mod t_test;
pub mod z_test;

use statrs::function::erf::erfc;
use std::f64::consts::FRAC_1_SQRT_2;

/// P(|Z| ≥ |z|) for Z of the standard normal distribution.
fn two_sided_normal(z: f64) -> f64 {
    erfc(z.abs() * FRAC_1_SQRT_2)
}

/// P(Z ≤ z) for Z of the standard normal distribution.
pub fn normal_below(z: f64) -> f64 {
    0.5 * erfc(-z * FRAC_1_SQRT_2)
}

pub mod testing;
