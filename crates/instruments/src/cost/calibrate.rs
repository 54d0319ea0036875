//! Do images know their own error? Many seeds, each image's reported error beside its actual one.
//!
//! The truth is the mean x̄ of the K images with the most samples of one estimator. With x_k one of
//! them, |x_k − x̄|²·K/(K − 1) has the expectation of x_k's squared error; with x another image, |x −
//! x̄|² less the mean's own squared error does. relMSE's denominators come from x̄.
//!
//! Stopping at a target error stops rather where the error happens to be told too small. What this
//! does to the reported error and to the image itself is measured by as many renders that stop by
//! themselves, with other seeds.

mod truth;

use super::Progress;
use super::estimator::{self, Estimator};
use super::interrupted::Interrupted;
use super::runner::{Runner, Seeds, prepare};
use direkt::error::Error;
use direkt::low_level::gpu::Context;
use direkt::low_level::prepare::SceneData;
use direkt::low_level::render::{ErrorGoal, Film, ImageError, StatedError};
use direkt::low_level::stats::moments::Moments;
use direkt::scene::{ErrorMetric, Scene};
use serde::Serialize;
use std::sync::Arc;
use truth::Truth;

/// Samples of an image that stops by itself at the most, in multiples of those that its target was
/// made for.
const LONGEST: u64 = 64;

/// What to calibrate.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// The estimators.
    pub estimators: Vec<Estimator>,
    /// Images of each.
    pub images: u32,
    /// Samples per pixel of the images, of each number as many images.
    pub samples: Vec<u64>,
    /// All seeds are derived from it.
    pub seed: u32,
}

/// A value with its standard error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// Its standard error.
    pub standard_error: f64,
}

/// How the errors that images report compare with their actual ones.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Calibration {
    /// The scene's file.
    pub scene: String,
    /// The estimator.
    #[serde(flatten)]
    pub estimator: Estimator,
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Samples per pixel.
    pub samples: u64,
    /// Images.
    pub images: u32,
    /// In terms of NMSE.
    pub nmse: Reported,
    /// In terms of relMSE.
    pub rel_mse: Reported,
    /// Renders that stopped by themselves at an NMSE.
    pub stopped: Stopped,
}

/// How reported errors compare with actual ones in one metric.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Reported {
    /// Mean of the actual error.
    pub actual: f64,
    /// Mean of the reported over mean of the actual error.
    pub ratio: Estimate,
    /// Fraction of the images that say that they can tell their error.
    pub told: Estimate,
    /// Of those the fraction whose actual error lies in the reported interval of 95 % confidence.
    pub coverage: Estimate,
    /// Images that report less than half their actual error.
    pub too_small: u32,
    /// Those of them that say that they can tell it.
    pub too_small_and_told: u32,
}

/// What stopping at a target does.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Stopped {
    /// The target: √NMSE.
    pub target: f64,
    /// Fraction of the images that reached it, with 64 times the samples at the most; all else is
    /// about these.
    pub reached: Estimate,
    /// Mean number of samples per pixel at which they stopped.
    pub samples: f64,
    /// Mean of the reported over mean of the actual error when they stopped.
    pub ratio: Estimate,
    /// Fraction of the images whose actual error was below the target.
    pub below_target: Estimate,
    /// Images whose actual error was above twice the target.
    pub above_twice: u32,
    /// Per channel (mean of the image − its mean without stopping) / its mean without stopping.
    pub bias_of_mean: [Estimate; 3],
}

/// Calibrates `estimators` on `scene`; those that are finished when `stop` asks to end.
///
/// # Errors
/// An estimator finds no light, or the driver fails.
pub fn calibrate(
    context: &Context,
    scene: &Scene,
    settings: &Settings,
    progress: Progress<'_>,
    stop: &dyn Fn() -> bool,
) -> Result<Vec<Calibration>, Error> {
    let mut calibrations = Vec::new();
    let data = Arc::new(SceneData::new(scene.clone()));
    for &estimator in &settings.estimators {
        let prepared = prepare(scene, &data, estimator)?;
        if let Some(reason) = estimator::why_not(estimator.settings.strategy, &prepared.emitters) {
            let source = scene.source.display();
            return Err(Error::Usage(format!("{source}: {estimator}: {reason}")));
        }
        progress(&format!("compiling {estimator}"), 0.0);
        let mut runner = Runner::new(context, prepared, scene.film, estimator, None)?;
        match one(scene, &mut runner, settings, progress, stop) {
            Ok(found) => calibrations.extend(found),
            Err(Interrupted::Stopped) => break,
            Err(Interrupted::Failed(error)) => return Err(error),
        }
    }
    Ok(calibrations)
}

/// An image with what it reports.
struct Image {
    mean: Vec<[f32; 3]>,
    reported: ImageError,
}

impl Image {
    fn of(film: &Film) -> Option<Self> {
        let pixels = film.pixels.iter();
        Some(Self {
            mean: pixels.map(|p| p.mean.map(|m| m as f32)).collect(),
            reported: film.error()?,
        })
    }
}

/// All numbers of samples of one estimator.
fn one(
    scene: &Scene,
    runner: &mut Runner<'_>,
    settings: &Settings,
    progress: Progress<'_>,
    stop: &dyn Fn() -> bool,
) -> Result<Vec<Calibration>, Interrupted> {
    let estimator = runner.estimator;
    let mut seeds = Seeds::new(settings.seed);
    let parts = f64::from(2 * settings.images) * settings.samples.len() as f64;
    let mut done = 0.0;
    let mut tell = |what: &str| {
        progress(&format!("{estimator}: {what}"), done / parts);
        done += 1.0;
    };
    let mut samples = settings.samples.clone();
    samples.sort_unstable();
    let mut fixed: Vec<Vec<Image>> = Vec::new();
    for &samples in &samples {
        let mut images = Vec::new();
        for _ in 0..settings.images {
            tell("images");
            let film = runner.run(seeds.draw(), samples, stop)?.film;
            images.push(Image::of(&film).ok_or_else(|| black(scene, estimator))?);
        }
        fixed.push(images);
    }
    let Some(truth) = fixed.last().map(|images| Truth::new(images)) else {
        return Ok(Vec::new());
    };
    let mut calibrations = Vec::new();
    for (i, (&samples, images)) in samples.iter().zip(&fixed).enumerate() {
        let is_truth = i + 1 == fixed.len();
        let actual = |metric| -> Vec<f64> {
            let errors = images.iter().map(|image| {
                if is_truth {
                    truth.of_member(&image.mean, metric)
                } else {
                    truth.of_other(&image.mean, metric)
                }
            });
            errors.collect()
        };
        let reported = |metric| reported(images, metric, &actual(metric));
        let nmse = reported(ErrorMetric::Nmse);
        let goal = ErrorGoal::new(ErrorMetric::Nmse, nmse.actual.sqrt());
        let mut stopped = StoppedImages::default();
        for _ in 0..settings.images {
            tell("images that stop by themselves");
            let run = runner.run_to(seeds.draw(), goal, LONGEST * samples, stop)?;
            if let Some(run) = run {
                stopped.samples.push(run.samples as f64);
                let image = Image::of(&run.film).ok_or_else(|| black(scene, estimator))?;
                stopped.images.push(image);
            }
        }
        calibrations.push(Calibration {
            scene: scene.source.display().to_string(),
            estimator,
            width: scene.film.width,
            height: scene.film.height,
            samples,
            images: settings.images,
            rel_mse: reported(ErrorMetric::RelMse),
            nmse,
            stopped: stopped.judge(images, &truth, goal),
        });
    }
    Ok(calibrations)
}

fn black(scene: &Scene, estimator: Estimator) -> Error {
    let source = scene.source.display();
    Error::Usage(format!(
        "{source}: {estimator}: the image is black and has no relative error"
    ))
}

/// What `images` report in `metric` beside their `actual` errors.
fn reported(images: &[Image], metric: ErrorMetric, actual: &[f64]) -> Reported {
    let stated: Vec<&StatedError> = images
        .iter()
        .map(|image| image.reported.in_metric(metric))
        .collect();
    let values: Vec<f64> = stated.iter().map(|e| e.value).collect();
    let told = |e: &StatedError| e.doubt.is_none();
    let pairs = || stated.iter().zip(actual);
    let inside = pairs().filter(|(e, _)| told(e));
    let inside = inside.map(|(e, actual)| e.low <= *actual && *actual <= e.high);
    let too_small = || pairs().filter(|(e, actual)| e.value < 0.5 * **actual);
    Reported {
        actual: actual.iter().sum::<f64>() / actual.len() as f64,
        ratio: ratio(&values, actual),
        told: fraction(stated.iter().map(|e| told(e))),
        coverage: fraction(inside),
        too_small: too_small().count() as u32,
        too_small_and_told: too_small().filter(|(e, _)| told(e)).count() as u32,
    }
}

/// Images that stopped by themselves.
#[derive(Default)]
struct StoppedImages {
    images: Vec<Image>,
    samples: Moments,
}

impl StoppedImages {
    /// What they are beside the images of a `fixed` number of samples, of which there are as many
    /// as should have stopped.
    fn judge(&self, fixed: &[Image], truth: &Truth, goal: ErrorGoal) -> Stopped {
        let images = &self.images;
        let errors = |metric| images.iter().map(move |i| truth.of_other(&i.mean, metric));
        let actual: Vec<f64> = errors(goal.metric).collect();
        let reported = images.iter().map(|i| i.reported.in_metric(goal.metric));
        let reported: Vec<f64> = reported.map(|e| e.value).collect();
        let target = goal.relative * goal.relative;
        let reached = (0..fixed.len()).map(|i| i < images.len());
        Stopped {
            target: goal.relative,
            reached: fraction(reached),
            samples: self.samples.mean,
            ratio: ratio(&reported, &actual),
            below_target: fraction(actual.iter().map(|a| *a <= target)),
            above_twice: actual.iter().filter(|a| **a > 4.0 * target).count() as u32,
            bias_of_mean: [0, 1, 2].map(|c| bias(images, fixed, c)),
        }
    }
}

/// How far the mean of channel `c` of `stopped` images is from that of `fixed` ones.
fn bias(stopped: &[Image], fixed: &[Image], c: usize) -> Estimate {
    let means = |images: &[Image]| -> Moments {
        let mean =
            |i: &Image| i.mean.iter().map(|m| f64::from(m[c])).sum::<f64>() / i.mean.len() as f64;
        images.iter().map(mean).collect()
    };
    let (stopped, fixed) = (means(stopped), means(fixed));
    let variance = |m: &Moments| m.variance_of_mean().unwrap_or(0.0);
    Estimate {
        value: stopped.mean / fixed.mean - 1.0,
        standard_error: (variance(&stopped) + variance(&fixed)).sqrt() / fixed.mean,
    }
}

/// Σa/Σb with its standard error by linearisation.
fn ratio(a: &[f64], b: &[f64]) -> Estimate {
    let n = a.len() as f64;
    let (sum_a, sum_b) = (a.iter().sum::<f64>(), b.iter().sum::<f64>());
    let value = sum_a / sum_b;
    let residuals = a.iter().zip(b).map(|(a, b)| (a - value * b).powi(2));
    Estimate {
        value,
        standard_error: (residuals.sum::<f64>() * n / (n - 1.0)).sqrt() / sum_b,
    }
}

fn fraction(hits: impl Iterator<Item = bool>) -> Estimate {
    let (mut all, mut n) = (0.0_f64, 0.0_f64);
    for hit in hits {
        n += 1.0;
        all += f64::from(u8::from(hit));
    }
    let value = all / n;
    Estimate {
        value,
        standard_error: (value * (1.0 - value) / n).sqrt(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_and_fractions_know_their_errors() {
        let exact = ratio(&[1.0, 2.0, 3.0], &[2.0, 4.0, 6.0]);
        assert!((exact.value - 0.5).abs() < 1e-12 && exact.standard_error < 1e-12);
        let scattered = ratio(&[1.0, 3.0], &[2.0, 2.0]);
        assert!((scattered.value - 1.0).abs() < 1e-12);
        // Residuals −1 and 1: √(2·2/1)/4.
        assert!((scattered.standard_error - 0.5).abs() < 1e-12);
        let three_of_four = fraction([true, true, false, true].into_iter());
        assert!((three_of_four.value - 0.75).abs() < 1e-12);
        assert!((three_of_four.standard_error - (0.1875_f64 / 4.0).sqrt()).abs() < 1e-12);
    }
}
