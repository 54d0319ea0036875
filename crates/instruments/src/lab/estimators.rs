//! Estimators of every class, with measured bias and variance at growing n.
//!
//! ```text
//!     unbiased      E θ̂ₙ = θ for every n          consistent    θ̂ₙ → θ in probability as n → ∞
//! ```
//!
//! Neither implies the other: the first sample alone is unbiased and never gets better; 1/mean is
//! biased and converges; a fixed grid's error stays whatever n is; importance sampling by a density
//! with too light tails is unbiased and converges, but slower than n^(−1/2), because its variance
//! is infinite.
//!
//! Where it is not said otherwise, a sample is Y = 4x, x uniform on [0, 4], and θ = ∫₀⁴ x dx = 8.
//! Exact values are in [`super::estimators_exact`].

use super::bench::Bench;
use super::estimators_exact::{self as exact, Moments2};
use super::layout::{LabBlock, LabRun};
use super::plot::{Mark, Plot, Series};
use super::report::{Cell, Check, Report, Table, short};
use super::{BLOCK, CONFIDENCE_95, Settings, slope};
use direkt::error::GpuError;
use direkt::low_level::gpu::Context;
use direkt::low_level::stats::moments::Moments;

/// Numbers of samples of an estimate.
pub const SAMPLES: [u32; 4] = [4, 16, 64, 256];

/// What can be said of an estimator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Class {
    /// Unbiased for every n, and converging.
    UnbiasedConsistent,
    /// Unbiased for every n, but not converging.
    UnbiasedInconsistent,
    /// Biased, by less and less.
    BiasedConsistent,
    /// Biased for ever.
    BiasedInconsistent,
    /// Unbiased, of infinite variance.
    InfiniteVariance,
}

impl Class {
    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Self::UnbiasedConsistent => "unbiased, consistent",
            Self::UnbiasedInconsistent => "unbiased, inconsistent",
            Self::BiasedConsistent => "biased, consistent",
            Self::BiasedInconsistent => "biased, inconsistent",
            Self::InfiniteVariance => "unbiased, infinite variance",
        }
    }
}

/// An estimator.
#[derive(Debug, Clone, Copy)]
pub struct Estimator {
    /// What it is.
    pub name: &'static str,
    /// Number in `shaders/lab/estimators.wesl`.
    pub variant: u32,
    /// Its class.
    pub class: Class,
    /// What it estimates.
    pub target: f64,
    /// Exact mean and variance of the estimate from n samples; the variance is infinite where it
    /// is.
    pub moments: fn(u32) -> Moments2,
    /// Fewest samples from which the estimate has a fourth moment, which the tests of mean and
    /// variance rest on.
    pub tested_from: u32,
    /// Why it belongs to its class.
    pub why: &'static str,
}

/// All of them.
pub const ESTIMATORS: [Estimator; 12] = [
    Estimator {
        name: "mean of Y",
        variant: 0,
        class: Class::UnbiasedConsistent,
        target: 8.0,
        moments: exact::mean,
        tested_from: 1,
        why: "the mean of n independent values of mean θ has mean θ and variance V/n",
    },
    Estimator {
        name: "importance sampling, p = (x + 2)/16",
        variant: 2,
        class: Class::UnbiasedConsistent,
        target: 8.0,
        moments: exact::importance,
        tested_from: 1,
        why: "E[x/p(x)] = ∫ x dx wherever p > 0, and a p like the integrand lowers V",
    },
    Estimator {
        name: "first Y only",
        variant: 1,
        class: Class::UnbiasedInconsistent,
        target: 8.0,
        moments: exact::first,
        tested_from: 1,
        why: "its mean is θ, but more samples change nothing: the variance stays V",
    },
    Estimator {
        name: "1/mean of Y, for 1/θ",
        variant: 3,
        class: Class::BiasedConsistent,
        target: 0.125,
        moments: exact::reciprocal,
        tested_from: 5,
        why: "1/y is convex, so E[1/mean] > 1/θ (Jensen), by V/(nθ³) to first order",
    },
    Estimator {
        name: "self-normalised, p = (6 − x)/16",
        variant: 4,
        class: Class::BiasedConsistent,
        target: 8.0,
        moments: exact::normalised,
        tested_from: 1,
        why: "4·Σ(x/p)/Σ(1/p) is a ratio of unbiased sums, whose mean is not the ratio of the means; off by O(1/n)",
    },
    Estimator {
        name: "largest x, for the upper end 4",
        variant: 5,
        class: Class::BiasedConsistent,
        target: 4.0,
        moments: exact::maximum,
        tested_from: 1,
        why: "always below 4, by 4/(n + 1) on average; variance O(1/n²)",
    },
    Estimator {
        name: "spread Σ(Y − mean)²/n, for V[Y] = 64/3",
        variant: 6,
        class: Class::BiasedConsistent,
        target: 64.0 / 3.0,
        moments: exact::spread,
        tested_from: 1,
        why: "the mean was fitted to the same samples: (n − 1)/n of V (Bessel)",
    },
    Estimator {
        name: "mean of Y clamped to 12",
        variant: 7,
        class: Class::BiasedInconsistent,
        target: 8.0,
        moments: exact::clamped,
        tested_from: 1,
        why: "what is cut off, E[(Y − 12)⁺] = 1/2, never comes back: fireflies removed, energy lost",
    },
    Estimator {
        name: "center: one fixed point, for ∫ x² = 64/3",
        variant: 8,
        class: Class::BiasedInconsistent,
        target: 64.0 / 3.0,
        moments: exact::center,
        tested_from: 1,
        why: "the midpoint rule with one panel, however often it is asked: no noise, all bias",
    },
    Estimator {
        name: "grid: four fixed points, for ∫ x² = 64/3",
        variant: 9,
        class: Class::BiasedInconsistent,
        target: 64.0 / 3.0,
        moments: exact::grid,
        tested_from: 1,
        why: "a fixed rule errs by (b − a)³f″/(24·4²) = 1/3 for ever: banding instead of noise",
    },
    Estimator {
        name: "x uniform on [0, 3] only",
        variant: 10,
        class: Class::BiasedInconsistent,
        target: 8.0,
        moments: exact::part,
        tested_from: 1,
        why: "p = 0 where the integrand is not: 3.5 of the integral is never seen",
    },
    Estimator {
        name: "too light tails: ∫ e^−x by p = 3e^−3x",
        variant: 11,
        class: Class::InfiniteVariance,
        target: 1.0,
        moments: exact::light_tail,
        tested_from: u32::MAX,
        why: "∫ f²/p = ∫ e^x/3 = ∞: rare samples of any size; the measured variance depends on luck and grows",
    },
];

/// Estimates from `samples` samples each on the GPU, one per replicate.
///
/// # Errors
/// The driver fails.
pub fn draw(
    bench: &Bench<'_>,
    settings: &Settings,
    estimator: &Estimator,
    samples: u32,
    replicates: u32,
) -> Result<Vec<f64>, GpuError> {
    let run = LabRun {
        variant: estimator.variant,
        items: replicates,
        samples,
        seed: settings.seed,
        stream: estimator.variant * 1024 + samples,
        constants: [settings.density_scale as f32, 0.0, 0.0, 0.0],
        ..LabRun::default()
    };
    let blocks: Vec<LabBlock> = bench.run(&run, &[])?.blocks;
    Ok(blocks.iter().map(|b| f64::from(b.mean)).collect())
}

/// Checks of mean and variance of estimates from `samples` samples, where they have the moments for
/// it.
pub fn checks(estimator: &Estimator, samples: u32, estimates: &[f64]) -> Vec<Check> {
    if samples < estimator.tested_from {
        return Vec::new();
    }
    let due = (estimator.moments)(samples);
    let found: Moments = estimates.iter().copied().collect();
    let n = found.count as f64;
    let what = format!("{}, n = {samples}", estimator.name);
    // Running means of up to 256 numbers in f32 err by less than as many roundings.
    let allowance = f64::from(BLOCK) * 0.5 * f64::from(f32::EPSILON);
    let mean = Check::mean(
        format!("mean of {what}"),
        found.mean,
        due.mean,
        due.variance / n,
        allowance * due.mean,
    );
    let variance = found.variance().unwrap_or(f64::NAN);
    let check = if due.variance > 0.0 {
        let fourth: Moments = estimates.iter().map(|e| (e - found.mean).powi(4)).collect();
        let kurtosis = fourth.mean / (variance * variance);
        let name = format!("variance of {what}");
        Check::variance(name, variance, due.variance, (kurtosis, n), 1e-4)
    } else {
        Check::exact(format!("variance of {what}"), variance, 0.0, 0.0)
    };
    vec![mean, check]
}

/// Checks of the estimator of infinite variance, by what does have moments: how often a sample is
/// at most 1, and the mean of samples clamped to 10.
pub fn light_tail_checks(samples: &[f64]) -> [Check; 2] {
    let n = samples.len() as f64;
    let below = samples.iter().filter(|&&w| w <= 1.0).count() as f64 / n;
    let clamped: Moments = samples.iter().map(|w| w.min(10.0)).collect();
    let p = exact::light_tail_below_one();
    let due = exact::light_tail_clamped();
    [
        Check::mean(
            "too light tails: samples at most 1",
            below,
            p,
            p * (1.0 - p) / n,
            0.0,
        ),
        Check::mean(
            "too light tails: mean of samples clamped to 10",
            clamped.mean,
            due.mean,
            due.variance / n,
            1e-5,
        ),
    ]
}

/// Runs the experiment.
///
/// # Errors
/// The kernel does not compile, or the driver fails.
pub fn run(context: &Context, settings: &Settings) -> Result<Report, GpuError> {
    let bench = Bench::new(context, "lab_estimators")?;
    let mut report = Report::new(
        "estimators",
        "bias, variance and consistency: estimators of every class",
    );
    let heads = [
        "estimator",
        "4",
        "16",
        "64",
        "256",
        "exact, 4",
        "exact, 256",
    ];
    let mut classes = Table::new("classes", &["estimator", "class", "θ"]);
    let mut biases = Table::new(
        "measured bias at n = 4, 16, 64, 256; ± is half a 95 % interval at 256",
        &[&heads[..], &["±"]].concat(),
    );
    let mut variances = Table::new(
        "measured variance at n = 4, 16, 64, 256, and the exponent of n with which it falls",
        &[&heads[..], &["order"]].concat(),
    );
    for (i, estimator) in ESTIMATORS.iter().enumerate() {
        let mut found: Vec<Moments> = Vec::new();
        for samples in SAMPLES {
            let estimates = draw(&bench, settings, estimator, samples, settings.blocks())?;
            report.checks.extend(checks(estimator, samples, &estimates));
            found.push(estimates.into_iter().collect());
        }
        classes.push(vec![
            Cell::text(estimator.name),
            Cell::text(estimator.class.name()),
            Cell::short(estimator.target, 5),
        ]);
        biases.push(bias_row(estimator, &found));
        variances.push(variance_row(estimator, &found));
        add_plots(&mut report.plots, estimator, &found, i);
        report
            .notes
            .push(format!("{}: {}", estimator.name, estimator.why));
    }
    let tail = &ESTIMATORS[ESTIMATORS.len() - 1];
    let single = draw(&bench, settings, tail, 1, settings.samples.min(1 << 22))?;
    report.checks.extend(light_tail_checks(&single));
    report.tables.extend([classes, biases, variances]);
    Ok(report)
}

fn bias_row(estimator: &Estimator, found: &[Moments]) -> Vec<Cell> {
    let mut row = vec![Cell::text(estimator.name)];
    let signed = |value: f64| {
        let sign = if value > 0.0 { "+" } else { "" };
        Cell::shown(value, format!("{sign}{}", short(value, 2)))
    };
    row.extend(found.iter().map(|m| signed(m.mean - estimator.target)));
    let due = |n| signed((estimator.moments)(n).mean - estimator.target);
    row.extend([due(SAMPLES[0]), due(SAMPLES[3])]);
    let variance = found[3].variance_of_mean().unwrap_or(0.0);
    row.push(Cell::short(CONFIDENCE_95 * variance.sqrt(), 2));
    row
}

fn variance_row(estimator: &Estimator, found: &[Moments]) -> Vec<Cell> {
    let mut row = vec![Cell::text(estimator.name)];
    let measured: Vec<f64> = found.iter().map(|m| m.variance().unwrap_or(0.0)).collect();
    row.extend(measured.iter().map(|&v| Cell::short(v, 3)));
    for n in [SAMPLES[0], SAMPLES[3]] {
        let due = (estimator.moments)(n).variance;
        row.push(if due.is_finite() {
            Cell::short(due, 3)
        } else {
            Cell::text("∞")
        });
    }
    let points: Vec<(f64, f64)> = SAMPLES
        .iter()
        .map(|&n| f64::from(n))
        .zip(measured)
        .collect();
    row.push(if points.iter().all(|p| p.1 > 0.0) {
        Cell::fixed(slope(&points), 2)
    } else {
        Cell::Empty
    });
    row
}

fn add_plots(plots: &mut Vec<Plot>, estimator: &Estimator, found: &[Moments], colour: usize) {
    let plot = |file: &str, title: &str, axis: &str| Plot {
        file: file.to_owned(),
        title: title.to_owned(),
        axes: ["samples n".to_owned(), axis.to_owned()],
        logarithmic: true,
        series: Vec::new(),
    };
    if plots.is_empty() {
        plots.push(plot(
            "estimators-error",
            "RMS error of estimators over samples",
            "RMS error / |θ|",
        ));
    }
    let error = |m: &Moments| {
        let bias = m.mean - estimator.target;
        (bias * bias + m.variance().unwrap_or(0.0)).sqrt() / estimator.target
    };
    let points = SAMPLES.iter().zip(found);
    plots[0].series.push(Series {
        name: short_name(estimator.name).to_owned(),
        points: points.map(|(&n, m)| (f64::from(n), error(m))).collect(),
        mark: match estimator.class {
            Class::BiasedInconsistent | Class::UnbiasedInconsistent => Mark::Dashed,
            _ => Mark::Dots,
        },
        colour,
    });
}

/// A name without its density and what it estimates.
fn short_name(name: &str) -> &str {
    let ends = [", p = ", ", for ", ": "].iter();
    let end = ends.filter_map(|end| name.find(end)).min();
    &name[..end.unwrap_or(name.len())]
}
