//! Test of paired differences that needs no variance and no light tails.
//!
//! When two samples have the same distribution and size, their paired differences d_i are
//! independent and symmetric about zero. Given all |d_i|, the signs are then fair coins, and the
//! self-normalised sum
//!
//! ```text
//!     t = Σ d_i / √(Σ d_i²),      P(|t| ≥ x) ≤ 2 exp(−x²/2)   for every such distribution
//! ```
//!
//! (Hoeffding 1963, theorem 2, applied to the signs; Efron 1969). A rare sample of any brightness
//! can thus raise no false alarm. The price is power: the bound is above the normal distribution's
//! tail by a factor x√(π/2).

/// The result of the test.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Symmetric {
    /// Σ d_i / √(Σ d_i²); 0 when all differences are zero. |t| ≤ √n by Cauchy and Schwarz.
    pub t: f64,
    /// Number of pairs.
    pub pairs: usize,
    /// Bound on the probability of a |t| at least as large, at most 1.
    pub p_value: f64,
}

/// Tests whether differences are symmetric about zero.
///
/// A difference that is not finite gives p-value 0. Zero differences count as pairs, but change
/// nothing.
pub fn symmetric_test(differences: &[f64]) -> Symmetric {
    let pairs = differences.len();
    let largest = differences.iter().fold(0.0_f64, |m, d| m.max(d.abs()));
    if !differences.iter().all(|d| d.is_finite()) {
        return Symmetric {
            t: f64::NAN,
            pairs,
            p_value: 0.0,
        };
    }
    // Scaled by the largest, so that no square overflows or vanishes.
    let (sum, squares) = differences
        .iter()
        .filter(|d| d.abs() > 0.0)
        .map(|d| d / largest)
        .fold((0.0, 0.0), |(s, q), d| (s + d, q + d * d));
    let t = if squares > 0.0 {
        sum / squares.sqrt()
    } else {
        0.0
    };
    Symmetric {
        t,
        pairs,
        p_value: (2.0 * (-t * t / 2.0).exp()).min(1.0),
    }
}

/// Fewest pairs with which [`symmetric_test`] can have a p-value below `level`, in (0, 1): because |t|
/// ≤ √n, the p-value is at least 2·exp(−n/2).
pub fn minimum_pairs(level: f64) -> usize {
    debug_assert!(level > 0.0 && level < 1.0);
    (2.0 * (2.0 / level).ln()).floor() as usize + 1
}

#[cfg(test)]
mod tests {
    use super::super::sidak::Family;
    use super::super::testing::{EXPERIMENTS, Stream};
    use super::*;
    use statrs::function::beta::beta_reg;

    /// How many of 20,000 experiments of 64 pairs have p < `level`.
    fn rejections(level: f64, mut difference: impl FnMut(&mut Stream) -> f64) -> f64 {
        let mut stream = Stream::new(5);
        (0..EXPERIMENTS)
            .filter(|_| {
                let pairs: Vec<f64> = (0..64).map(|_| difference(&mut stream)).collect();
                symmetric_test(&pairs).p_value < level
            })
            .count() as f64
    }

    /// Largest deviation of the number of rejections from its mean, at the level of
    /// `assert_rejects_at_its_rate`.
    fn bound(rate: f64) -> f64 {
        Family::new(10).z_bound() * (f64::from(EXPERIMENTS) * rate * (1.0 - rate)).sqrt()
    }

    #[test]
    fn it_rejects_no_more_than_its_level_for_any_tails() {
        let most = 200.0 + bound(0.01);
        assert!(rejections(0.01, Stream::normal) <= most);
        assert!(rejections(0.01, |s| (s.uniform() - 0.5).signum()) <= most);
        let cauchy = |s: &mut Stream| (std::f64::consts::PI * (s.uniform() - 0.5)).tan();
        assert!(rejections(0.01, cauchy) <= most);
        assert!(rejections(0.01, |s| cauchy(s).powi(5)) <= most);
    }

    #[test]
    fn it_rejects_normal_differences_at_their_own_rate() {
        // p < 10 % is t² > 2 ln 20, and t²/n of n normal differences is Beta(½, (n − 1)/2): it is a
        // squared cosine of the angle between a random and a fixed direction.
        let rate = beta_reg(31.5, 0.5, 1.0 - 2.0 * 20_f64.ln() / 64.0);
        let rejected = rejections(0.1, Stream::normal);
        let mean = f64::from(EXPERIMENTS) * rate;
        assert!((rejected - mean).abs() <= bound(rate), "{rejected} {mean}");
    }

    #[test]
    fn a_two_percent_effect_is_rejected() {
        // Differences of uniform numbers with means 0.5 and 0.51: √n·0.01/√(1/6) = 11 for 200,000
        // pairs; p = 1e-26.
        let mut stream = Stream::new(6);
        let mut draw = |scale: f64| -> Vec<f64> {
            (0..200_000)
                .map(|_| scale * stream.uniform() - stream.uniform())
                .collect()
        };
        assert!(symmetric_test(&draw(1.02)).p_value < 1e-6);
        assert!(symmetric_test(&draw(1.0)).p_value > 1e-6);
    }

    #[test]
    fn too_few_pairs_cannot_reject() {
        for level in [0.05, 1e-4, 1e-9] {
            let n = minimum_pairs(level);
            assert!(symmetric_test(&vec![1.0; n]).p_value < level);
            assert!(symmetric_test(&vec![1.0; n - 1]).p_value >= level);
        }
    }

    #[test]
    fn extremes_are_handled() {
        assert!(symmetric_test(&[]).p_value >= 1.0);
        assert!(symmetric_test(&[0.0, -0.0]).p_value >= 1.0);
        assert!(symmetric_test(&[f64::NAN, 1.0]).p_value <= 0.0);
        let tiny = symmetric_test(&[1e-300; 40]);
        let huge = symmetric_test(&[1e300; 40]);
        assert!((tiny.t - 40_f64.sqrt()).abs() < 1e-12 && (huge.t - tiny.t).abs() < 1e-12);
    }
}
