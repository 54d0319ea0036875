//! Student's t-test for means whose variance is estimated from the samples.
//!
//! Exact for normal samples. For others the distribution of t approaches Student's as the number of
//! samples grows, the slower the heavier the tails are; where these are heavy use
//! [`symmetric`](super::symmetric).

use super::moments::Moments;
use super::two_sided_normal;
use statrs::function::beta::beta_reg;

/// The result of a t-test.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TTest {
    /// The difference in its estimated standard deviations; infinite when that is zero and the
    /// difference is not.
    pub t: f64,
    /// Degrees of freedom; Welch's are not a whole number.
    pub degrees_of_freedom: f64,
    /// Probability of a |t| at least as large when the means are equal.
    pub p_value: f64,
}

impl TTest {
    fn new(difference: f64, variance: f64, degrees_of_freedom: f64) -> Self {
        let same = difference.abs() <= 0.0;
        let t = if same {
            0.0
        } else {
            difference / variance.sqrt()
        };
        Self {
            t,
            degrees_of_freedom,
            p_value: two_sided_student(t, degrees_of_freedom),
        }
    }
}

/// Tests, on both sides, whether the samples' mean is `expected`. `None` below two samples.
pub fn one_sample(samples: &Moments, expected: f64) -> Option<TTest> {
    let variance = samples.variance_of_mean()?;
    Some(TTest::new(
        samples.mean - expected,
        variance,
        samples.count as f64 - 1.0,
    ))
}

/// Tests, on both sides, whether two independent samples have the same mean; their variances may
/// differ (Welch 1947, degrees of freedom after Satterthwaite 1946). `None` below two samples in
/// either.
pub fn welch(a: &Moments, b: &Moments) -> Option<TTest> {
    let (va, vb) = (a.variance_of_mean()?, b.variance_of_mean()?);
    let variance = va + vb;
    // Shares, because the squares of small variances would underflow.
    let (sa, sb) = (va / variance, vb / variance);
    let freedom = if variance > 0.0 {
        1.0 / (sa * sa / (a.count as f64 - 1.0) + sb * sb / (b.count as f64 - 1.0))
    } else {
        (a.count + b.count) as f64 - 2.0
    };
    Some(TTest::new(a.mean - b.mean, variance, freedom))
}

/// Degrees of freedom above which an expansion replaces the continued fraction, which then
/// converges too slowly.
const EXPANSION_FROM: f64 = 500.0;

/// P(|T| ≥ |t|) for T of Student's distribution with ν degrees of freedom; 0 when `t` is not a
/// number.
fn two_sided_student(t: f64, nu: f64) -> f64 {
    if t.is_nan() {
        return 0.0;
    }
    let ratio = t * t / nu;
    if ratio.is_infinite() {
        return 0.0;
    }
    if nu < EXPANSION_FROM {
        // I_x(ν/2, 1/2) with x = ν/(ν + t²) (Abramowitz & Stegun 26.7.1).
        return beta_reg(nu / 2.0, 0.5, 1.0 / (1.0 + ratio));
    }
    // Hill 1970, algorithm 395: the normal deviate of the same probability, in powers of 1/(48(ν −
    // ½)²).
    let a = nu - 0.5;
    let b = 48.0 * a * a;
    let y = a * ratio.ln_1p();
    let tail = (((-0.4 * y - 3.3) * y - 24.0) * y - 85.5) / (0.8 * y * y + 100.0 + b);
    two_sided_normal(((tail + y + 3.0) / b + 1.0) * y.sqrt())
}

#[cfg(test)]
mod tests {
    use super::super::testing::{Stream, assert_rejects_at_its_rate};
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn p_values_are_those_of_the_closed_forms() {
        for t in [0.01_f64, 0.5, 1.0, 2.0, 4.0] {
            // Cauchy's distribution.
            let cauchy = 1.0 - t.atan() / FRAC_PI_2;
            assert!((two_sided_student(t, 1.0) - cauchy).abs() < 1e-12);
            // Abramowitz & Stegun 26.7.4, for even degrees of freedom.
            for nu in [2_u32, 4, 10, 120, 480] {
                let cos2 = 1.0 / (1.0 + t * t / f64::from(nu));
                let (mut term, mut sum) = (1.0, 0.0);
                for k in 0..nu / 2 {
                    sum += term;
                    term *= cos2 * f64::from(2 * k + 1) / f64::from(2 * k + 2);
                }
                let p = 1.0 - (1.0 - cos2).sqrt() * sum;
                let student = two_sided_student(t, f64::from(nu));
                assert!((student - p).abs() < 1e-11, "{t} {nu}: {student} {p}");
            }
        }
        assert!(two_sided_student(0.0, 7.0) >= 1.0);
    }

    #[test]
    fn the_expansion_joins_the_fraction() {
        for t in [0.1, 1.0, 3.0, 5.0, 8.0] {
            let below = two_sided_student(t, EXPANSION_FROM * (1.0 - 1e-12));
            let above = two_sided_student(t, EXPANSION_FROM);
            assert!((below - above).abs() < 1e-8 * below, "{t}: {below} {above}");
            let many = two_sided_student(t, 1e12);
            assert!((many / two_sided_normal(t) - 1.0).abs() < 1e-8, "{t}");
        }
    }

    #[test]
    fn it_rejects_at_its_rate() {
        assert_rejects_at_its_rate(0.0, |stream| {
            let samples: Moments = (0..5).map(|_| 2.0 + stream.normal()).collect();
            one_sample(&samples, 2.0).unwrap().p_value
        });
        // Satterthwaite's degrees of freedom are an approximation, good to 10 % of the level here.
        assert_rejects_at_its_rate(20.0, |stream| {
            let a: Moments = (0..30).map(|_| stream.normal()).collect();
            let b: Moments = (0..20).map(|_| 3.0 * stream.normal()).collect();
            welch(&a, &b).unwrap().p_value
        });
    }

    #[test]
    fn a_two_percent_effect_is_rejected() {
        // 2 % of uniform numbers' mean are 35 standard deviations of a million's mean, 24 of a
        // difference's.
        let mut stream = Stream::new(4);
        let mut draw =
            |scale: f64| -> Moments { (0..1_000_000).map(|_| scale * stream.uniform()).collect() };
        let (a, b, c) = (draw(1.0), draw(1.02), draw(1.0));
        assert!(one_sample(&b, 0.5).unwrap().p_value < 1e-6);
        assert!(welch(&a, &b).unwrap().p_value < 1e-6);
        assert!(one_sample(&a, 0.5).unwrap().p_value > 1e-6);
        assert!(welch(&a, &c).unwrap().p_value > 1e-6);
    }

    #[test]
    fn constant_samples_are_compared_exactly() {
        let constant = |x: f64| -> Moments { [x, x, x].into_iter().collect() };
        let one = constant(1.0);
        assert!(one_sample(&one, 1.0).unwrap().p_value >= 1.0);
        assert!(one_sample(&one, 1.5).unwrap().p_value <= 0.0);
        assert!(welch(&one, &constant(1.0)).unwrap().p_value >= 1.0);
        assert!(welch(&one, &constant(2.0)).unwrap().p_value <= 0.0);
        assert!(welch(&one, &Moments::default()).is_none());
    }
}
