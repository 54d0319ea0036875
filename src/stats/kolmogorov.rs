//! Kolmogorov and Smirnov's test of z-scores against the standard normal distribution.
//!
//! A variance that is reported too small or too large, which no single z-test shows, shows here.

use statrs::function::erf::erfc;
use std::f64::consts::SQRT_2;

/// The result of the test.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kolmogorov {
    /// Largest distance between the scores' distribution function and the normal one.
    pub distance: f64,
    /// Probability of a distance at least as large when the scores are independent and standard
    /// normal.
    pub p_value: f64,
}

/// Tests whether independent `scores` are standard normal. `None` below 8 scores, where the p-value
/// would be off.
///
/// A score that is not a number gives distance 1 and p-value 0.
pub fn normality_test(scores: &[f64]) -> Option<Kolmogorov> {
    if scores.len() < 8 {
        return None;
    }
    if scores.iter().any(|z| z.is_nan()) {
        return Some(Kolmogorov {
            distance: 1.0,
            p_value: 0.0,
        });
    }
    let mut sorted = scores.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len() as f64;
    let distance = sorted
        .iter()
        .enumerate()
        .map(|(i, z)| {
            let normal = 0.5 * erfc(-z / SQRT_2);
            (normal - i as f64 / n).max((i as f64 + 1.0) / n - normal)
        })
        .fold(0.0, f64::max);
    // Stephens 1970: with this factor Kolmogorov's limit holds for few scores already.
    let root = n.sqrt();
    Some(Kolmogorov {
        distance,
        p_value: limit_tail((root + 0.12 + 0.11 / root) * distance),
    })
}

/// Kolmogorov's limit P(√n·D ≥ x) = 2 Σ_k (−1)^(k−1) exp(−2k²x²).
fn limit_tail(x: f64) -> f64 {
    // Below, the probability is 1 up to 1e-8 and the series converges slowly.
    if x < 0.27 {
        return 1.0;
    }
    let terms = (1..=20).map(|k| {
        let term = (-2.0 * f64::from(k * k) * x * x).exp();
        if k % 2 == 1 { term } else { -term }
    });
    (2.0 * terms.sum::<f64>()).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::super::testing::{Stream, assert_rejects_at_its_rate};
    use super::*;

    #[test]
    fn the_limit_is_that_of_the_tables() {
        // Smirnov 1948: 1.3581 at 5 %, 1.6276 at 1 %.
        assert!((limit_tail(1.3581) - 0.05).abs() < 1e-5);
        assert!((limit_tail(1.6276) - 0.01).abs() < 1e-5);
        assert!((limit_tail(0.27) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn it_rejects_at_its_rate() {
        // Stephens's factor is good to 5 % of the level: 10 rejections.
        assert_rejects_at_its_rate(10.0, |stream| {
            let scores: Vec<f64> = (0..40).map(|_| stream.normal()).collect();
            normality_test(&scores).unwrap().p_value
        });
    }

    #[test]
    fn wrong_scales_and_centres_are_rejected() {
        // A spread of 1.05 moves the distribution by 0.012, a centre of 0.02 by 0.008, at most; for
        // 10⁶ scores p is about 2·exp(−2·10⁶·0.008²) = 1e-55.
        let mut stream = Stream::new(8);
        let scores: Vec<f64> = (0..1_000_000).map(|_| stream.normal()).collect();
        let p = |scale: f64, centre: f64| {
            let moved: Vec<f64> = scores.iter().map(|z| scale * z + centre).collect();
            normality_test(&moved).unwrap().p_value
        };
        assert!(p(1.0, 0.0) > 1e-6);
        assert!(p(1.05, 0.0) < 1e-6);
        assert!(p(1.0, 0.02) < 1e-6);
    }

    #[test]
    fn extremes_are_handled() {
        assert!(normality_test(&[0.0; 7]).is_none());
        let mut scores = [0.1; 9];
        scores[4] = f64::NAN;
        assert!(normality_test(&scores).unwrap().p_value <= 0.0);
        assert!(normality_test(&[f64::INFINITY; 9]).unwrap().p_value < 1e-6);
    }
}
