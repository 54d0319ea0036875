//! What is told of an estimator: time per sample, slopes, efficiency, time to a target, rank.

use super::error::MeasuredError;
use super::fit::{FitPoint, Line, Slope};
use super::interval::{Interval, NORMAL_95, student_95};
use direkt::low_level::stats::moments::Moments;
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

/// Times over those of runs beside them, in pairs, at the largest number of samples: the ratio of
/// their means, with how the logarithms of the ratios scatter there and at the three numbers
/// before, whose runs are not much shorter.
pub fn time_ratio(times: &[Vec<f64>], others: &[Vec<f64>]) -> Interval {
    let pairs = times.iter().zip(others);
    let of_count = |(a, b): (&Vec<f64>, &Vec<f64>)| -> Vec<f64> {
        a.iter().zip(b).map(|(a, b)| a / b).collect()
    };
    let ratios: Vec<_> = pairs.map(of_count).collect();
    let (spread, freedom) = time_spread(&ratios[ratios.len().saturating_sub(4)..]);
    let sum = |times: &[Vec<f64>]| times.last().map_or(0.0, |last| last.iter().sum::<f64>());
    let count = ratios.last().map_or(0, Vec::len).max(1) as f64;
    let value = sum(times) / sum(others);
    let factor = (student_95(freedom) * spread / count.sqrt()).exp();
    Interval {
        value,
        low: value / factor,
        high: value * factor,
    }
}

impl Point {
    /// A point of `seconds` per run, whose logarithms have the standard deviation `spread.0` by
    /// `spread.1` degrees of freedom.
    pub fn new(samples: u64, seconds: &[f64], spread: (f64, f64), error: MeasuredError) -> Self {
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

    /// When `target` is reached; `None` where the error does not fall, or where the time is not
    /// known to a factor of ten.
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
    /// 1 plus the number of estimators that are better: whose whole interval lies above this one's,
    /// or the interval of whose ratio to it, where times were measured in pairs, above 1.
    pub rank: usize,
    /// Indices of those that are neither better nor worse.
    pub ties: Vec<usize>,
}

/// Ranks efficiencies. `ratio` of two indices is their ratio where it is known better than from the
/// two intervals.
pub fn ranks(
    efficiencies: &[Interval],
    ratio: impl Fn(usize, usize) -> Option<Interval>,
) -> Vec<Rank> {
    let better = |i: usize, j: usize| {
        ratio(i, j).map_or(efficiencies[i].low > efficiencies[j].high, |r| r.low > 1.0)
    };
    let all = 0..efficiencies.len();
    let rank = |i: usize| Rank {
        rank: 1 + all.clone().filter(|&j| better(j, i)).count(),
        ties: all
            .clone()
            .filter(|&j| j != i && !better(i, j) && !better(j, i))
            .collect(),
    };
    all.clone().map(rank).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(rel_mse: f64, half: f64) -> MeasuredError {
        let interval = Interval::around(rel_mse, half);
        MeasuredError {
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
        let all = [around(10.0), around(11.5), around(20.0), around(1.0)];
        let found = ranks(&all, |_, _| None);
        let of = |i: usize| (found[i].rank, found[i].ties.as_slice());
        assert_eq!(of(0), (2, [1].as_slice()));
        assert_eq!(of(1), (2, [0].as_slice()));
        assert_eq!(of(2), (1, [].as_slice()));
        assert_eq!(of(3), (4, [].as_slice()));
    }

    #[test]
    fn ratios_in_pairs_break_ties() {
        let all = [10.0, 9.0, 9.5].map(|value| Interval::around(value, 2.0));
        let ratio = |i: usize, j: usize| match (i, j) {
            (0, 1) => Some(Interval::around(1.1, 0.05)),
            (1, 0) => Some(Interval::around(0.9, 0.05)),
            _ => None,
        };
        let found = ranks(&all, ratio);
        let of = |i: usize| (found[i].rank, found[i].ties.as_slice());
        assert_eq!(of(0), (1, [2].as_slice()));
        assert_eq!(of(1), (2, [2].as_slice()));
        assert_eq!(of(2), (1, [0, 1].as_slice()));
    }

    /// Times that scatter together have ratios that do not.
    #[test]
    fn times_are_compared_in_pairs() {
        let others = [vec![9.0, 1.0], vec![1.0, 2.0], vec![2.0, 6.0, 7.0]];
        let times = others
            .clone()
            .map(|t| t.iter().map(|t| 1.25 * t).collect::<Vec<_>>());
        let exact = time_ratio(&times, &others);
        assert!((exact.value - 1.25).abs() < 1e-12 && exact.high - exact.low < 1e-12);

        let logarithms = [vec![-0.1, 0.1], vec![0.0, 0.0], vec![-0.1, 0.1]];
        let times = logarithms.map(|l| l.iter().map(|l: &f64| l.exp()).collect::<Vec<_>>());
        let others = [(); 3].map(|()| vec![1.0; 2]);
        let scattered = time_ratio(&times, &others);
        // Variance (0.02 + 0 + 0.02)/3, two pairs, Student's quantile of three degrees of freedom
        // 3.1824.
        let expected = 3.182_4 * (0.04_f64 / 3.0 / 2.0).sqrt();
        assert!(((scattered.high / scattered.value).ln() - expected).abs() < 1e-4);
        assert!((scattered.value - 0.1_f64.cosh()).abs() < 1e-12);
    }
}
