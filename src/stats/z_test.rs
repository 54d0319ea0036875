//! Test of a mean whose variance is known.

use super::two_sided_normal;

/// The result of a z-test.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ZTest {
    /// Excess of the difference over the allowance in standard deviations of the mean, with the
    /// difference's sign; infinite when the variance is zero and there is an excess.
    pub z: f64,
    /// Probability of a |z| at least as large when the mean is right.
    pub p_value: f64,
}

/// Tests, on both sides, whether `mean` estimates `expected`.
///
/// `variance_of_mean` is the known variance of one sample divided by their number: an estimated one
/// hides rare bright samples. `allowance` is the absolute error that the rounding of single
/// precision may add; the difference is reduced by it first, at most to zero. Without variance any
/// excess has p-value 0. A difference that is not a number has p-value 0 as well.
pub fn z_test(mean: f64, expected: f64, variance_of_mean: f64, allowance: f64) -> ZTest {
    debug_assert!(variance_of_mean >= 0.0 && allowance >= 0.0);
    let difference = mean - expected;
    if difference.is_nan() {
        return ZTest {
            z: f64::NAN,
            p_value: 0.0,
        };
    }
    let excess = (difference.abs() - allowance).max(0.0);
    if excess <= 0.0 {
        return ZTest {
            z: 0.0,
            p_value: 1.0,
        };
    }
    let z = (excess / variance_of_mean.sqrt()).copysign(difference);
    ZTest {
        z,
        p_value: two_sided_normal(z),
    }
}

#[cfg(test)]
mod tests {
    use super::super::moments::Moments;
    use super::super::testing::{Stream, assert_rejects_at_its_rate};
    use super::*;

    #[test]
    fn p_values_are_those_of_the_tables() {
        // Two-sided normal quantiles (Abramowitz & Stegun, table 26.6).
        for (z, p) in [
            (1.959_963_984_540_054, 0.05),
            (2.575_829_303_548_901, 0.01),
            (4.891_638_475_698_89, 1e-6),
        ] {
            let result = z_test(3.0 - z * 0.1, 3.0, 0.01, 0.0);
            assert!((result.p_value - p).abs() < 1e-9 * p, "{z} {result:?}");
            assert!(result.z < 0.0);
        }
    }

    #[test]
    fn it_rejects_at_its_rate() {
        // The mean of 50 uniform numbers has excess kurtosis κ = −1.2/50. Edgeworth's expansion
        // moves the tail by 2φ(z)(z³ − 3z)κ/24 = −2.7e-4 at z = 2.576, which is 5.4 of 20,000.
        assert_rejects_at_its_rate(6.0, |stream| {
            let mean: Moments = (0..50).map(|_| stream.uniform()).collect();
            z_test(mean.mean, 0.5, 1.0 / 12.0 / 50.0, 0.0).p_value
        });
    }

    #[test]
    fn a_two_percent_effect_is_rejected() {
        // Uniform numbers: relative standard deviation 0.577, so 2 % are 35 standard deviations of
        // a million's mean.
        let mut stream = Stream::new(3);
        let mean: Moments = (0..1_000_000).map(|_| stream.uniform()).collect();
        let variance = 1.0 / 12.0 / 1e6;
        assert!(z_test(1.02 * mean.mean, 0.5, variance, 5e-6).p_value < 1e-6);
        assert!(z_test(mean.mean, 0.5, variance, 5e-6).p_value > 1e-6);
    }

    #[test]
    fn without_variance_only_the_allowance_is_allowed() {
        let p = |mean, allowance| z_test(mean, 1.0, 0.0, allowance).p_value;
        assert!(p(1.0, 0.0) >= 1.0);
        assert!(p(1.001, 0.0) <= 0.0);
        assert!(p(1.001, 0.002) >= 1.0);
        assert!(p(1.003, 0.002) <= 0.0);
        assert!(p(f64::NAN, 1.0) <= 0.0);
        assert!(p(f64::INFINITY, 1.0) <= 0.0);
    }

    #[test]
    fn the_allowance_shortens_the_difference() {
        let with = z_test(1.5, 1.0, 0.01, 0.2);
        let without = z_test(1.3, 1.0, 0.01, 0.0);
        assert!((with.z - without.z).abs() < 1e-12);
    }
}
