//! Values with 95 % confidence intervals.

use serde::Serialize;
use statrs::distribution::{ContinuousCDF, FisherSnedecor, Normal, StudentsT};

/// The two-sided 95 % quantile of the normal distribution.
pub const NORMAL_95: f64 = 1.959_963_984_540_054;

/// The two-sided 95 % quantile of Student's distribution; that of the normal one where the degrees
/// of freedom are many, infinite where there are none.
pub fn student_95(degrees_of_freedom: f64) -> f64 {
    student(degrees_of_freedom, 0.95)
}

/// The same quantile for any confidence in (0, 1).
pub fn student(degrees_of_freedom: f64, confidence: f64) -> f64 {
    let below = 0.5 * (1.0 + confidence);
    if degrees_of_freedom > 1e4 {
        return Normal::standard().inverse_cdf(below);
    }
    StudentsT::new(0.0, 1.0, degrees_of_freedom).map_or(f64::INFINITY, |t| t.inverse_cdf(below))
}

/// The quantile of Fisher's F distribution below which a ratio lies with the probability `below`:
/// that of two means of squares of normal numbers, of which the upper has `upper` degrees of freedom
/// and the lower `lower`.
pub fn fisher(upper: f64, lower: f64, below: f64) -> f64 {
    const MANY: f64 = 1e4;
    if upper.min(lower) > MANY {
        // Nearly normal in its logarithm.
        let deviation = (2.0 / upper + 2.0 / lower).sqrt();
        return (deviation * Normal::standard().inverse_cdf(below)).exp();
    }
    let lower = lower.min(1e6);
    FisherSnedecor::new(upper, lower).map_or(f64::INFINITY, |f| f.inverse_cdf(below))
}

/// A value that cannot be negative, with its 95 % confidence interval.
///
/// The value itself may be: where what was subtracted from it was more than what is left.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Interval {
    /// The estimate.
    pub value: f64,
    /// Lower end, not below 0.
    pub low: f64,
    /// Upper end; infinite (in JSON `null`) where the data do not bound it.
    pub high: f64,
}

impl Interval {
    /// `value ± half`.
    pub fn around(value: f64, half: f64) -> Self {
        Self {
            value,
            low: (value - half).max(0.0),
            high: (value + half).max(0.0),
        }
    }

    /// A positive value with a standard error's `half`, its ends at the same distance as
    /// logarithms: what is never negative and skewed to large values does not end below zero, and
    /// its upper end is that of `value ± half`.
    pub fn positive(value: f64, half: f64) -> Self {
        if value <= 0.0 {
            return Self::around(value, half);
        }
        let factor = 1.0 + half / value;
        Self {
            value,
            low: value / factor,
            high: value * factor,
        }
    }

    /// Less another value, which is known to `half`; the distances of the ends are added in
    /// quadrature.
    pub fn less(&self, other: f64, half: f64) -> Self {
        let value = self.value - other;
        Self {
            value,
            low: (value - (self.value - self.low).hypot(half)).max(0.0),
            high: (value + (self.high - self.value).hypot(half)).max(0.0),
        }
    }

    /// A value that is known.
    pub fn exactly(value: f64) -> Self {
        Self::around(value, 0.0)
    }

    /// The same in another unit; `factor` is positive.
    pub fn scaled(&self, factor: f64) -> Self {
        Self {
            value: factor * self.value,
            low: factor * self.low,
            high: factor * self.high,
        }
    }

    /// Whether the two have a value in common.
    pub fn overlaps(&self, other: &Self) -> bool {
        self.low <= other.high && other.low <= self.high
    }

    /// Whether the interval excludes zero, so that its logarithm means something.
    pub fn is_positive(&self) -> bool {
        self.value > 0.0 && self.low > 0.0
    }

    /// Distance of the upper end over the value.
    pub fn relative_half(&self) -> f64 {
        (self.high - self.value) / self.value
    }

    /// 1/(a·b) of two independent positive values. The distances of the ends are added in
    /// quadrature, as logarithms: each side of the result comes from the opposite sides of `a` and
    /// `b`. Where one of these reaches zero, nothing bounds the result from above.
    pub fn inverse_product(a: &Self, b: &Self) -> Self {
        let down = (a.high / a.value).ln().hypot((b.high / b.value).ln());
        let up = (a.value / a.low).ln().hypot((b.value / b.low).ln());
        let value = 1.0 / (a.value * b.value);
        if a.value > 0.0 && b.value > 0.0 {
            return Self {
                value,
                low: value * (-down).exp(),
                high: value * up.exp(),
            };
        }
        Self {
            value: f64::INFINITY,
            low: 1.0 / (a.high * b.high),
            high: f64::INFINITY,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_tables() {
        for (freedom, quantile) in [(1.0, 12.706_2), (4.0, 2.776_4), (30.0, 2.042_3)] {
            assert!((student_95(freedom) - quantile).abs() < 1e-4, "{freedom}");
        }
        assert!((student_95(1e6) - NORMAL_95).abs() < 1e-5);
        assert!(student_95(0.0).is_infinite());
        assert!((student(f64::INFINITY, 0.99) - 2.575_829).abs() < 1e-5);
        assert!((student(4.0, 0.9) - 2.131_8).abs() < 1e-4);
        for (upper, lower, quantile) in [(10.0, 10.0, 3.716_8), (4.0, 20.0, 3.514_7)] {
            assert!((fisher(upper, lower, 0.975) - quantile).abs() < 1e-3);
            assert!((fisher(lower, upper, 0.025) * quantile - 1.0).abs() < 1e-3);
        }
        // Both sides of where the distribution counts as normal.
        let [few, many] = [9999.0, 10_001.0].map(|nu| fisher(nu, nu, 0.975));
        assert!((few / many - 1.0).abs() < 1e-4, "{few} {many}");
    }

    #[test]
    fn efficiencies_take_both_errors() {
        let error = Interval {
            value: 2.0,
            low: 1.0,
            high: 4.0,
        };
        let alone = Interval::inverse_product(&error, &Interval::exactly(5.0));
        assert!((alone.value - 0.1).abs() < 1e-12);
        assert!((alone.low - 0.05).abs() < 1e-12 && (alone.high - 0.2).abs() < 1e-12);
        let both = Interval::inverse_product(&error, &error);
        assert!((both.low - 0.25 * (-(2.0_f64.ln() * 2.0_f64.sqrt())).exp()).abs() < 1e-12);
        assert!(both.low < 0.25 && both.high > 0.25);
    }

    #[test]
    fn an_error_that_reaches_zero_bounds_nothing_from_above() {
        let error = Interval::around(1.0, 2.0);
        let efficiency = Interval::inverse_product(&error, &Interval::exactly(1.0));
        assert!(efficiency.high.is_infinite() && efficiency.low > 0.3);
        let below =
            Interval::inverse_product(&Interval::around(-0.5, 1.0), &Interval::exactly(1.0));
        assert!(below.value.is_infinite() && (below.low - 2.0).abs() < 1e-12);
    }

    #[test]
    fn positive_values_stay_positive() {
        let vague = Interval::positive(1.0, 9.0);
        assert!((vague.low - 0.1).abs() < 1e-12 && (vague.high - 10.0).abs() < 1e-12);
        let sharp = Interval::positive(1.0, 1e-3);
        assert!((sharp.low - 0.999).abs() < 1e-5);
        let less = vague.less(0.5, 0.0);
        assert!((less.value - 0.5).abs() < 1e-12 && less.low <= 0.0 && less.high > 9.0);
    }

    #[test]
    fn intervals_that_touch_overlap() {
        let a = Interval::around(1.0, 0.5);
        assert!(a.overlaps(&Interval::around(2.0, 0.5)));
        assert!(!a.overlaps(&Interval::around(2.1, 0.5)));
    }
}
