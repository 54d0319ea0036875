//! Experiments of a lecture on Monte Carlo integration, in one dimension and a few: drawn on the
//! GPU, by `shaders/kernel/lab_*.wesl`, and held against exact values in f64.
//!
//! | experiment | what it shows |
//! |---|---|
//! | [`importance`] | ∫₀⁴ x dx by four densities: measured, exact and printed variance |
//! | [`pi`] | π by rejection and by averaging, with their efficiencies |
//! | [`sampling`] | inversion against rejection, and the alias table: χ² and cost |
//! | [`quadrature`] | rules against random and low-discrepancy points in 1 to 6 dimensions: orders |
//! | [`estimators`] | unbiased, biased, consistent or neither, of infinite variance: bias and variance |
//!
//! Each declares its [`report::Check`]s before it draws; they are one family of tests whose level
//! is [`FAMILY_LEVEL`](direkt::low_level::stats::sidak::FAMILY_LEVEL).

pub mod bench;
pub mod densities;
pub mod estimators;
pub mod estimators_exact;
pub mod importance;
pub mod integral;
pub mod layout;
pub mod pi;
pub mod plot;
pub mod quadrature;
pub mod report;
pub mod rules;
pub mod sampling;

use direkt::error::GpuError;
use direkt::low_level::gpu::Context;
use direkt::low_level::reference::exact::cubature::{Tolerance, integrate};
use direkt::low_level::stats::moments::Moments;
use glam::DVec3;
use layout::LabBlock;
use report::Report;

/// The experiments.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Experiment {
    /// ∫₀⁴ x dx by importance sampling
    Importance,
    /// π by rejection and by averaging
    Pi,
    /// Inversion, rejection, alias table
    Sampling,
    /// Quadrature rules against Monte Carlo and quasi-Monte Carlo
    Quadrature,
    /// Bias, variance and consistency of estimators
    Estimators,
}

impl Experiment {
    /// All of them, in the order of the lecture.
    pub const ALL: [Self; 5] = [
        Self::Importance,
        Self::Pi,
        Self::Sampling,
        Self::Quadrature,
        Self::Estimators,
    ];
}

/// How an experiment is run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Samples per row of a table, about; a multiple of [`BLOCK`] is taken.
    pub samples: u32,
    /// Seed of the random numbers.
    pub seed: u32,
    /// What every density is multiplied by where samples are divided by it (and quadrature weights
    /// divided by): 1. Anything else is a mistake that the checks have to find.
    pub density_scale: f64,
}

/// Samples that one invocation accumulates in f32.
pub const BLOCK: u32 = 256;
/// Fewest samples: 256 blocks, so that means of blocks are normal enough for their tests.
pub const MIN_SAMPLES: u32 = 1 << 16;
/// Most samples: counters of 32 bits have room for more, memory has not.
pub const MAX_SAMPLES: u32 = 1 << 28;

impl Default for Settings {
    fn default() -> Self {
        Self {
            samples: 1 << 20,
            seed: 0,
            density_scale: 1.0,
        }
    }
}

impl Settings {
    /// Says what would be right where a setting is not.
    ///
    /// # Errors
    /// The number of samples is out of range.
    pub fn validate(&self) -> Result<(), String> {
        if (MIN_SAMPLES..=MAX_SAMPLES).contains(&self.samples) {
            return Ok(());
        }
        Err(format!(
            "{} samples: from {MIN_SAMPLES} to {MAX_SAMPLES} are possible; with fewer the tests could not be trusted",
            self.samples
        ))
    }

    /// Blocks of [`BLOCK`] samples.
    pub fn blocks(&self) -> u32 {
        self.samples.div_ceil(BLOCK)
    }
}

/// Runs one experiment.
///
/// # Errors
/// A kernel does not compile, or the driver fails.
pub fn run(
    context: &Context,
    experiment: Experiment,
    settings: &Settings,
) -> Result<Report, GpuError> {
    match experiment {
        Experiment::Importance => importance::run(context, settings),
        Experiment::Pi => pi::run(context, settings),
        Experiment::Sampling => sampling::run(context, settings),
        Experiment::Quadrature => quadrature::run(context, settings),
        Experiment::Estimators => estimators::run(context, settings),
    }
}

/// Half the width of a 95 % interval, in standard deviations.
const CONFIDENCE_95: f64 = 1.959_963_984_540_054;

/// ∫ f over [low, high] to twelve digits.
fn integral(f: impl Fn(f64) -> f64, low: f64, high: f64) -> f64 {
    let of_x = |x: f64, _: f64| DVec3::splat(f(x));
    integrate(of_x, &[low, high], &[0.0, 1.0], Tolerance::relative(1e-12))
        .value
        .x
}

/// Slope of ln y over ln x by least squares.
fn slope(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let logs = || points.iter().map(|p| (p.0.ln(), p.1.ln()));
    let (mx, my) = logs().fold((0.0, 0.0), |(a, b), (x, y)| (a + x / n, b + y / n));
    let (xy, xx) = logs().fold((0.0, 0.0), |(a, b), (x, y)| {
        (a + (x - mx) * (y - my), b + (x - mx) * (x - mx))
    });
    xy / xx
}

/// Root mean squared error of the mean of n samples, over all disjoint runs of n that the blocks
/// have, for n = 256, 512, 1024, … as long as there are 16 runs.
fn rms_errors(blocks: &[LabBlock], truth: f64) -> Vec<(f64, f64)> {
    let mut out = Vec::new();
    let mut size = 1;
    while blocks.len() / size >= 16 {
        let runs = blocks.chunks_exact(size).map(layout::merged);
        let squares: Moments = runs.map(|m| (m.mean - truth).powi(2)).collect();
        out.push(((size as u32 * BLOCK).into(), squares.mean.sqrt()));
        size *= 2;
    }
    out
}

/// The points (n, σ/√n) of the theory beside [`rms_errors`].
fn expected_errors(measured: &[(f64, f64)], variance: f64) -> Vec<(f64, f64)> {
    let points = measured.iter();
    points.map(|p| (p.0, (variance / p.0).sqrt())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_are_exponents() {
        let points: Vec<(f64, f64)> = [1.0, 2.0, 4.0, 9.0]
            .map(|n: f64| (n, 3.0 * n.powf(-1.5)))
            .to_vec();
        assert!((slope(&points) + 1.5).abs() < 1e-12);
    }

    #[test]
    fn integrals_are_those_of_the_closed_forms() {
        assert!((integral(f64::exp, 0.0, 1.0) - (1_f64.exp() - 1.0)).abs() < 1e-12);
        assert!((integral(|x| x, 0.0, 4.0) - 8.0).abs() < 1e-12);
    }

    #[test]
    fn runs_are_disjoint_and_enough() {
        let block = |mean| LabBlock {
            mean,
            m2: 0.0,
            samples: BLOCK,
            tries: 0,
        };
        let blocks: Vec<LabBlock> = (0..32)
            .map(|i| block(if i % 2 == 0 { 1.0 } else { 3.0 }))
            .collect();
        let errors = rms_errors(&blocks, 2.0);
        assert_eq!(errors, vec![(256.0, 1.0), (512.0, 0.0)]);
    }

    #[test]
    fn too_few_samples_are_refused_with_what_would_be_right() {
        let with = |samples| Settings {
            samples,
            ..Settings::default()
        };
        assert!(with(0).validate().unwrap_err().contains("from 65536 to"));
        assert!(with(MIN_SAMPLES).validate().is_ok());
        assert!(with(MAX_SAMPLES + 1).validate().is_err());
    }
}
