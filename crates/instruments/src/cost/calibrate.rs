//! Do images know their own error? Many seeds, each image's reported error beside its actual one.
//!
//! The truth is the mean of all the images of one estimator: with x_k one of K images and x̄ their
//! mean, (x_k − x̄)²·K/(K − 1) has the expectation of x_k's squared error. relMSE's denominators
//! come from x̄.
//!
//! Stopping at a target error stops rather where the error happens to be told too small. What this
//! does to the reported error and to the image itself is measured by as many renders that stop by
//! themselves, with other seeds.

use super::Progress;
use super::estimator::{self, Estimator};
use super::interrupted::Interrupted;
use super::reference::Reference;
use super::runner::{Runner, Seeds, prepare};
use direkt::error::Error;
use direkt::low_level::gpu::Context;
use direkt::low_level::prepare::SceneData;
use direkt::low_level::render::{ErrorGoal, Film, RelMse};
use direkt::low_level::stats::moments::Moments;
use direkt::scene::Scene;
use serde::Serialize;
use std::sync::Arc;

/// What to calibrate.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// The estimators.
    pub estimators: Vec<Estimator>,
    /// Images of each.
    pub images: u32,
    /// Samples per pixel of each image.
    pub samples: u64,
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
    /// Mean of the actual relMSE.
    pub actual: f64,
    /// Mean of the reported over mean of the actual relMSE.
    pub ratio: Estimate,
    /// Fraction of the images whose actual relMSE lies in the reported interval of 95 % confidence.
    pub coverage: Estimate,
    /// Renders that stopped by themselves.
    pub stopped: Stopped,
}

/// What stopping at a target does.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Stopped {
    /// The target: a relative error, √relMSE.
    pub target: f64,
    /// Mean number of samples per pixel at which images stopped.
    pub samples: f64,
    /// Mean of the reported over mean of the actual relMSE when they stopped.
    pub ratio: Estimate,
    /// Fraction of the images whose actual error was below the target.
    pub below_target: Estimate,
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
            Ok(calibration) => calibrations.push(calibration),
            Err(Interrupted::Stopped) => break,
            Err(Interrupted::Failed(error)) => return Err(error),
        }
    }
    Ok(calibrations)
}

/// An image with what it reports.
struct Image {
    mean: Vec<[f32; 3]>,
    reported: RelMse,
}

fn one(
    scene: &Scene,
    runner: &mut Runner<'_>,
    settings: &Settings,
    progress: Progress<'_>,
    stop: &dyn Fn() -> bool,
) -> Result<Calibration, Interrupted> {
    let estimator = runner.estimator;
    let mut seeds = Seeds::new(settings.seed);
    let images = f64::from(settings.images);
    let mut tell = |what: &str, done: usize, half: f64| {
        let part = 0.5 * (half + done as f64 / images);
        progress(&format!("{estimator}: {what}"), part);
    };
    let unknown = || {
        let source = scene.source.display();
        Error::Usage(format!(
            "{source}: {estimator}: the image is black and has no relative error"
        ))
    };
    let mut fixed = Vec::new();
    for done in 0..settings.images as usize {
        tell("images", done, 0.0);
        let film = runner.run(seeds.draw(), settings.samples, stop)?.film;
        fixed.push(image(&film).ok_or_else(unknown)?);
    }
    let truth = Truth::new(&fixed);
    let actual: Vec<f64> = fixed.iter().map(|i| truth.of_member(&i.mean)).collect();
    let reported: Vec<f64> = fixed.iter().map(|i| i.reported.rel_mse).collect();
    let inside = fixed.iter().zip(&actual);
    let inside = inside
        .map(|(i, actual)| i.reported.rel_mse_low <= *actual && *actual <= i.reported.rel_mse_high);
    let coverage = fraction(inside);

    let goal = ErrorGoal::new(actual.iter().sum::<f64>().sqrt() / images.sqrt());
    let (mut stopped, mut samples) = (Vec::new(), Moments::default());
    for done in 0..settings.images as usize {
        tell("images that stop by themselves", done, 1.0);
        let run = runner.run_to(seeds.draw(), goal, stop)?;
        samples.push(run.samples as f64);
        stopped.push(image(&run.film).ok_or_else(unknown)?);
    }
    Ok(Calibration {
        scene: scene.source.display().to_string(),
        estimator,
        width: scene.film.width,
        height: scene.film.height,
        samples: settings.samples,
        images: settings.images,
        actual: actual.iter().sum::<f64>() / images,
        ratio: ratio(&reported, &actual),
        coverage,
        stopped: of_stopped(&stopped, &fixed, &truth, goal, samples.mean),
    })
}

fn image(film: &Film) -> Option<Image> {
    Some(Image {
        mean: film
            .pixels
            .iter()
            .map(|p| p.mean.map(|m| m as f32))
            .collect(),
        reported: film.error()?,
    })
}

fn of_stopped(
    stopped: &[Image],
    fixed: &[Image],
    truth: &Truth,
    goal: ErrorGoal,
    samples: f64,
) -> Stopped {
    let actual: Vec<f64> = stopped.iter().map(|i| truth.of_other(&i.mean)).collect();
    let reported: Vec<f64> = stopped.iter().map(|i| i.reported.rel_mse).collect();
    let target = goal.relative * goal.relative;
    let means = |images: &[Image], c: usize| -> Moments {
        let mean =
            |i: &Image| i.mean.iter().map(|m| f64::from(m[c])).sum::<f64>() / i.mean.len() as f64;
        images.iter().map(mean).collect()
    };
    let bias = |c: usize| {
        let (stopped, fixed) = (means(stopped, c), means(fixed, c));
        let variance = |m: &Moments| m.variance_of_mean().unwrap_or(0.0);
        Estimate {
            value: stopped.mean / fixed.mean - 1.0,
            standard_error: (variance(&stopped) + variance(&fixed)).sqrt() / fixed.mean,
        }
    };
    Stopped {
        target: goal.relative,
        samples,
        ratio: ratio(&reported, &actual),
        below_target: fraction(actual.iter().map(|a| *a <= target)),
        bias_of_mean: [bias(0), bias(1), bias(2)],
    }
}

/// The mean of all images.
struct Truth {
    reference: Reference,
    images: f64,
}

impl Truth {
    fn new(images: &[Image]) -> Self {
        let mut mean = vec![[0.0; 3]; images[0].mean.len()];
        let part = 1.0 / images.len() as f64;
        for image in images {
            for (mean, value) in mean.iter_mut().zip(&image.mean) {
                for c in 0..3 {
                    mean[c] += f64::from(value[c]) * part;
                }
            }
        }
        Self {
            reference: Reference::exact(mean),
            images: images.len() as f64,
        }
    }

    /// relMSE against the mean.
    fn against(&self, image: &[[f32; 3]]) -> f64 {
        let pixels = self.reference.mean.iter().zip(image);
        let terms = pixels.flat_map(|(truth, x)| {
            let term = |c: usize| {
                let off = f64::from(x[c]) - truth[c];
                off * off * self.reference.weight(truth[c])
            };
            [0, 1, 2].map(term)
        });
        terms.sum::<f64>() / (3 * image.len()) as f64
    }

    /// relMSE of one of the images that the mean is made of.
    fn of_member(&self, image: &[[f32; 3]]) -> f64 {
        self.against(image) * self.images / (self.images - 1.0)
    }

    /// relMSE of another image, with as many samples: the mean's own error, one K-th of it, is
    /// taken off.
    fn of_other(&self, image: &[[f32; 3]]) -> f64 {
        self.against(image) * self.images / (self.images + 1.0)
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
    use direkt::low_level::stats::testing::Stream;

    /// Images of a ramp with normal errors of 10 %.
    fn images(count: usize) -> Vec<Image> {
        let mut stream = Stream::new(9);
        let reported = RelMse {
            rel_mse: 0.01,
            rel_mse_low: 0.0,
            rel_mse_high: 1.0,
            confidence: 0.95,
        };
        let mut pixel = |i: usize| [0; 3].map(|_| (ramp(i) * (1.0 + 0.1 * stream.normal())) as f32);
        (0..count)
            .map(|_| Image {
                mean: (0..1000).map(&mut pixel).collect(),
                reported,
            })
            .collect()
    }

    fn ramp(i: usize) -> f64 {
        0.5 + i as f64 / 1000.0
    }

    #[test]
    fn the_mean_of_all_images_stands_for_the_truth() {
        let all = images(12);
        let (of_truth, other) = all.split_at(8);
        let truth = Truth::new(of_truth);
        // relMSE = 0.01 · mean of r²/(r² + 0.01·mean(r)²); 3000 squares of normal numbers, eight
        // images: 1 % is two sigma.
        let due = (0..1000).map(|i| ramp(i).powi(2) / (ramp(i).powi(2) + 0.01));
        let due = 0.01 * due.sum::<f64>() / 1000.0;
        let of = |error: &dyn Fn(&[[f32; 3]]) -> f64, images: &[Image]| {
            let sum: f64 = images.iter().map(|i| error(&i.mean)).sum();
            sum / images.len() as f64 / due
        };
        let members = of(&|i| truth.of_member(i), of_truth);
        assert!((members - 1.0).abs() < 0.05, "{members}");
        let others = of(&|i| truth.of_other(i), other);
        assert!((others - 1.0).abs() < 0.05, "{others}");
        let unscaled = of(&|i| truth.against(i), of_truth);
        assert!(
            unscaled < 0.92,
            "an eighth of its own error is in the mean: {unscaled}"
        );
    }

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
