//! Straight lines through the logarithms of errors.

use super::interval::{Interval, student_95};
use serde::Serialize;

/// A point to fit: the standard error is that of y.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FitPoint {
    /// Logarithm of samples or of seconds.
    pub x: f64,
    /// Logarithm of the error.
    pub y: f64,
    /// Standard error of `y`.
    pub sigma: f64,
}

/// y = y₀ + slope·(x − x₀), x₀ and y₀ the weighted means, by weighted least squares.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// dy/dx.
    pub slope: f64,
    /// Standard error of the slope.
    pub slope_error: f64,
    x: f64,
    y: f64,
    y_error: f64,
    /// Points beyond the two that a line needs.
    freedom: usize,
}

/// A slope and how well it is known.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Slope {
    /// d ln(error) / d ln(x).
    pub value: f64,
    /// Its standard error.
    pub standard_error: f64,
}

/// Standard errors below this count as this much: no timer and no f32 is better.
const LEAST_SIGMA: f64 = 1e-4;

impl Line {
    /// The line through `points`; `None` below two different x.
    ///
    /// Weights are 1/σ². The standard errors follow from σ, and where the points scatter about the
    /// line more than σ says (a curve is no line), they grow with the scatter: by √(χ²/(n − 2))
    /// (Birge 1932).
    pub fn fit(points: &[FitPoint]) -> Option<Self> {
        let weight = |p: &FitPoint| p.sigma.max(LEAST_SIGMA).powi(-2);
        let sum =
            |f: &dyn Fn(&FitPoint) -> f64| points.iter().map(|p| weight(p) * f(p)).sum::<f64>();
        let total = sum(&|_| 1.0);
        let (x, y) = (sum(&|p| p.x) / total, sum(&|p| p.y) / total);
        let sxx = sum(&|p| (p.x - x).powi(2));
        if points.len() < 2 || sxx.is_nan() || sxx <= 0.0 {
            return None;
        }
        let slope = sum(&|p| (p.x - x) * (p.y - y)) / sxx;
        let freedom = points.len() - 2;
        let chi2 = sum(&|p| (p.y - y - slope * (p.x - x)).powi(2));
        let scatter = if freedom > 0 {
            (chi2 / freedom as f64).sqrt().max(1.0)
        } else {
            1.0
        };
        Some(Self {
            slope,
            slope_error: scatter / sxx.sqrt(),
            x,
            y,
            y_error: scatter / total.sqrt(),
            freedom,
        })
    }

    /// The slope alone.
    pub fn slope(&self) -> Slope {
        Slope {
            value: self.slope,
            standard_error: self.slope_error,
        }
    }

    /// e^x where the line reaches the logarithm `y`, with its interval to first order; `None` where
    /// the line does not fall by more than two standard errors of its slope: then nothing tells
    /// when.
    pub fn reaches(&self, y: f64) -> Option<Interval> {
        if self.slope + 2.0 * self.slope_error >= 0.0 {
            return None;
        }
        let distance = (y - self.y) / self.slope;
        let error = self.y_error.hypot(self.slope_error * distance) / -self.slope;
        let value = (self.x + distance).exp();
        let factor = (error * student_95(self.freedom.max(1) as f64)).exp();
        Some(Interval {
            value,
            low: value / factor,
            high: value * factor,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use direkt::low_level::stats::testing::Stream;

    fn points(y: impl Fn(f64) -> f64, sigma: f64) -> Vec<FitPoint> {
        let point = |i: i32| {
            let x = f64::from(i) * 2.0_f64.ln();
            FitPoint { x, y: y(x), sigma }
        };
        (0..8).map(point).collect()
    }

    #[test]
    fn a_line_is_found_and_its_error_is_that_of_its_points() {
        let line = Line::fit(&points(|x| 0.5 - x, 0.02)).expect("eight points");
        assert!((line.slope + 1.0).abs() < 1e-12);
        // Var = σ²/Σ(x − x̄)² with Σ = 42·ln²2.
        let expected = 0.02 / (42.0_f64.sqrt() * 2.0_f64.ln());
        assert!((line.slope_error / expected - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_curve_has_a_larger_error_than_its_points() {
        let straight = Line::fit(&points(|x| -x, 0.001)).expect("eight points");
        let curve = Line::fit(&points(|x| -x - 0.1 * x * x, 0.001)).expect("eight points");
        assert!(curve.slope_error > 20.0 * straight.slope_error);
    }

    /// Slopes of synthetic errors with normal logarithms are within 1.96 standard errors as often
    /// as they should be.
    #[test]
    fn standard_errors_cover() {
        let mut stream = Stream::new(17);
        let experiments = 4000;
        let mut covered = 0;
        for _ in 0..experiments {
            let mut points = points(|x| -1.5 * x, 0.1);
            for p in &mut points {
                p.y += p.sigma * stream.normal();
            }
            let line = Line::fit(&points).expect("eight points");
            covered += u32::from((line.slope + 1.5).abs() < 1.96 * line.slope_error);
        }
        // At least 95 %, because the scatter only ever adds; four standard deviations of the count
        // are 55.
        assert!(covered >= 3745, "{covered} of {experiments}");
    }

    #[test]
    fn the_target_is_reached_where_the_line_says() {
        let line = Line::fit(&points(|x| -2.0 * x, 0.01)).expect("eight points");
        let at = line.reaches(-8.0).expect("it falls");
        assert!((at.value / 4.0_f64.exp() - 1.0).abs() < 1e-9);
        assert!(at.low < at.value && at.high > at.value);
        let far = line.reaches(-30.0).expect("it falls");
        assert!(
            far.relative_half() > at.relative_half(),
            "farther is less sure"
        );
        let rising = Line::fit(&points(|x| x, 0.01)).expect("eight points");
        assert!(rising.reaches(-1.0).is_none());
        let vague = Line::fit(&points(|x| -0.1 * x, 1.0)).expect("eight points");
        assert!(vague.reaches(-1.0).is_none(), "it may as well rise");
    }

    #[test]
    fn one_point_is_no_line() {
        assert!(Line::fit(&points(|x| x, 0.1)[..1]).is_none());
        assert!(Line::fit(&[]).is_none());
    }
}
