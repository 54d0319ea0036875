//! What is told of an estimator: time per sample, slopes, efficiency, time to a target, rank.

use super::error::ImageError;
use super::fit::{FitPoint, Line, Slope};
use super::interval::{Interval, NORMAL_95, student_95};
use crate::stats::moments::Moments;
use serde::Serialize;

/// The images of one estimator at one number of samples.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Point {
    /// Samples per pixel.
    pub samples: u64,
    /// Independent images.
    pub replicates: u32,
    /// Mean seconds of rendering one.
    pub seconds: Interval,
    /// Mean squared error.
    pub mse: Interval,
    /// Relative mean squared error.
    pub rel_mse: Interval,
    /// 1/(relMSE · seconds).
    pub efficiency: Interval,
}

/// When a target error is reached.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Reached {
    /// The relative mean squared error asked for.
    pub target: f64,
    /// Seconds of rendering, along the line through the measured errors.
    pub seconds: Interval,
    /// Samples per pixel, likewise.
    pub samples: Interval,
    /// Whether it lies beyond what was measured.
    pub extrapolated: bool,
}

/// The lines through an estimator's errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lines {
    samples: Line,
    time: Line,
    /// First and last measured error that the lines go through.
    range: (f64, f64),
}

/// Times of runs, which scatter alike in relation to their length.
pub fn time_spread(groups: &[Vec<f64>]) -> (f64, f64) {
    let (mut m2, mut freedom) = (0.0, 0.0);
    for group in groups {
        let logarithms: Moments = group.iter().map(|t| t.ln()).collect();
        m2 += logarithms.m2;
        freedom += (logarithms.count as f64 - 1.0).max(0.0);
    }
    ((m2 / f64::max(freedom, 1.0)).sqrt(), freedom)
}

impl Point {
    /// A point of `seconds` per run, whose logarithms have the standard deviation `spread.0` by `spread.1` degrees of
    /// freedom.
    pub fn new(samples: u64, seconds: &[f64], spread: (f64, f64), error: ImageError) -> Self {
        let n = seconds.len() as f64;
        let mean = seconds.iter().sum::<f64>() / n;
        let factor = (student_95(spread.1) * spread.0 / n.sqrt()).exp();
        let seconds_interval = Interval {
            value: mean,
            low: mean / factor,
            high: mean * factor,
        };
        Self {
            samples,
            replicates: seconds.len() as u32,
            efficiency: Interval::inverse_product(&error.rel_mse, &seconds_interval),
            seconds: seconds_interval,
            mse: error.mse,
            rel_mse: error.rel_mse,
        }
    }

    /// Whether a line may go through it: its error is known to within a factor of two.
    pub fn is_known(&self) -> bool {
        self.rel_mse.is_positive() && self.rel_mse.relative_half() < 1.0
    }
}

impl Lines {
    /// The lines through those of `points` that are known; `None` where fewer than two are.
    pub fn new(points: &[Point]) -> Option<Self> {
        let known: Vec<&Point> = points.iter().filter(|p| p.is_known()).collect();
        let fit = |x: &dyn Fn(&Point) -> f64| {
            let point = |p: &&Point| FitPoint {
                x: x(p).ln(),
                y: p.rel_mse.value.ln(),
                sigma: p.rel_mse.relative_half().ln_1p() / NORMAL_95,
            };
            Line::fit(&known.iter().map(point).collect::<Vec<_>>())
        };
        let (first, last) = (known.first()?, known.last()?);
        Some(Self {
            samples: fit(&|p| p.samples as f64)?,
            time: fit(&|p| p.seconds.value)?,
            range: (first.rel_mse.value, last.rel_mse.value),
        })
    }

    /// d ln relMSE / d ln samples.
    pub fn slope_samples(&self) -> Slope {
        self.samples.slope()
    }

    /// d ln relMSE / d ln seconds.
    pub fn slope_time(&self) -> Slope {
        self.time.slope()
    }

    /// When `target` is reached; `None` where the error does not fall, or where the time is not known to a factor of ten.
    pub fn reach(&self, target: f64) -> Option<Reached> {
        let reached = self.reach_by_line(target)?;
        (reached.seconds.high < 10.0 * reached.seconds.value).then_some(reached)
    }

    fn reach_by_line(&self, target: f64) -> Option<Reached> {
        Some(Reached {
            target,
            seconds: self.time.reaches(target.ln())?,
            samples: self.samples.reaches(target.ln())?,
            extrapolated: !(self.range.1..=self.range.0).contains(&target),
        })
    }
}

/// The place of an estimator among all.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Rank {
    /// 1 plus the number of estimators whose whole interval lies above this one's.
    pub rank: usize,
    /// Indices of those whose intervals overlap with this one's.
    pub ties: Vec<usize>,
}

/// Ranks efficiencies.
pub fn ranks(efficiencies: &[Interval]) -> Vec<Rank> {
    let rank = |(i, e): (usize, &Interval)| Rank {
        rank: 1 + efficiencies.iter().filter(|o| o.low > e.high).count(),
        ties: (0..efficiencies.len())
            .filter(|&j| j != i && e.overlaps(&efficiencies[j]))
            .collect(),
    };
    efficiencies.iter().enumerate().map(rank).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(rel_mse: f64, half: f64) -> ImageError {
        let interval = Interval::around(rel_mse, half);
        ImageError {
            mse: interval,
            rel_mse: interval,
        }
    }

    /// Errors 8·n^slope after 0.01·n seconds.
    fn points(slope: f64) -> Vec<Point> {
        let point = |k: i32| {
            let n = 2.0_f64.powi(k);
            let e = 8.0 * n.powf(slope);
            Point::new(
                n as u64,
                &[0.01 * n, 0.01 * n],
                (0.01, 8.0),
                error(e, 0.05 * e),
            )
        };
        (0..6).map(point).collect()
    }

    #[test]
    fn efficiency_is_the_inverse_of_error_times_time() {
        let point = Point::new(4, &[1.5, 2.5], (0.0, 4.0), error(0.01, 0.002));
        assert!((point.seconds.value - 2.0).abs() < 1e-12);
        assert!((point.efficiency.value - 50.0).abs() < 1e-9);
        assert!((point.efficiency.low - 1.0 / (0.012 * 2.0)).abs() < 1e-9);
        assert!((point.efficiency.high - 1.0 / (0.008 * 2.0)).abs() < 1e-9);
    }

    #[test]
    fn slopes_are_found_against_samples_and_time() {
        for slope in [-1.0, -1.5] {
            let lines = Lines::new(&points(slope)).expect("six points");
            assert!((lines.slope_samples().value - slope).abs() < 1e-9);
            assert!((lines.slope_time().value - slope).abs() < 1e-9);
            assert!(lines.slope_samples().standard_error > 0.0);
        }
    }

    #[test]
    fn targets_are_reached_inside_or_beyond() {
        let lines = Lines::new(&points(-1.0)).expect("six points");
        let inside = lines.reach(1.0).expect("it falls");
        assert!((inside.samples.value - 8.0).abs() < 1e-9 && !inside.extrapolated);
        assert!((inside.seconds.value - 0.08).abs() < 1e-9);
        let beyond = lines.reach(1e-3).expect("it falls");
        assert!((beyond.samples.value - 8000.0).abs() < 1e-5 && beyond.extrapolated);
    }

    #[test]
    fn points_below_the_noise_are_left_out() {
        let mut points = points(-1.0);
        for point in &mut points[1..] {
            point.rel_mse = Interval::around(-0.1, 0.2);
        }
        assert!(Lines::new(&points).is_none());
    }

    #[test]
    fn times_are_pooled() {
        let groups = [vec![1.0, 1.0], vec![2.0, 2.0 * 0.2_f64.exp()], vec![3.0]];
        let (spread, freedom) = time_spread(&groups);
        assert!((freedom - 2.0).abs() < 1e-12);
        assert!((spread - (0.02_f64 / 2.0).sqrt()).abs() < 1e-9, "{spread}");
    }

    #[test]
    fn overlapping_estimators_are_ties() {
        let around = |value: f64| Interval::around(value, 1.0);
        let found = ranks(&[around(10.0), around(11.5), around(20.0), around(1.0)]);
        let of = |i: usize| (found[i].rank, found[i].ties.as_slice());
        assert_eq!(of(0), (2, [1].as_slice()));
        assert_eq!(of(1), (2, [0].as_slice()));
        assert_eq!(of(2), (1, [].as_slice()));
        assert_eq!(of(3), (4, [].as_slice()));
    }
}
