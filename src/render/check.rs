//! Compares a film with the exact image that its scene states.
//!
//! A value v (one channel of a pixel, or of the image's mean) with standard error s agrees with the
//! exact value e when
//!
//! ```text
//!     |v − e| ≤ z·s + (2e-5 + tolerance)·e
//! ```
//!
//! where z bounds the family-wise false alarm over all values, with Student's t in place of the
//! normal distribution for a pixel to which adaptive sampling has given fewer than 64 samples, and
//! 2e-5 is what f32 loses in positions and in the offsets of rays. No sample is negative: where e =
//! 0, v has to be 0. Where nothing that varies was sampled, s is 0: an estimator that never meets
//! the light fails. No sample may have been dropped.

use super::film::Film;
use crate::error::Error;
use crate::scene::{Expect, ExpectedRadiance};
use crate::stats::interval::student;
use crate::stats::sidak::Family;

/// Samples per pixel below which the estimated standard error is not worth a check.
pub const MIN_SAMPLES: u64 = 64;

/// Relative difference that rounding in f32 explains.
const ROUNDING: f64 = 2e-5;

/// The bound in standard errors below which no value fails, however few are compared: a standard
/// error is itself an estimate, and samples are not normal.
const MIN_SIGMAS: f64 = 4.5;

/// How a film compares with what its scene expects.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Check {
    /// Whether every value agrees and no sample was dropped.
    pub passed: bool,
    /// Number of values compared.
    pub values: usize,
    /// The bound, in standard errors.
    pub bound_sigma: f64,
    /// The largest difference beyond rounding and tolerance, in standard errors; infinite (null in
    /// JSON) where a value that does not vary is off.
    pub worst_sigma: f64,
    /// Samples that were not finite.
    pub dropped: u64,
    /// The values that do not agree.
    pub failures: Vec<Failure>,
    /// Where the expected values come from.
    pub source: String,
}

/// A value that is not what it must be.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Failure {
    /// Column and row of the pixel; none for the mean of the image.
    pub pixel: Option<[u32; 2]>,
    /// 0 red, 1 green, 2 blue.
    pub channel: usize,
    /// What the render found.
    pub found: f64,
    /// What it must be.
    pub expected: f64,
    /// Standard error of `found`.
    pub standard_error: f64,
    /// Samples of the pixel; of the image's mean, those of a pixel on average.
    pub samples: u64,
    /// The largest difference that would have been accepted.
    pub bound: f64,
}

impl Check {
    /// Compares `film` with `expect`.
    ///
    /// # Errors
    /// [`Error::Usage`] when pixels have fewer than [`MIN_SAMPLES`] samples on average.
    ///
    /// # Panics
    /// When `expect` is about a film of another size, which a validated scene excludes.
    pub fn new(film: &Film, expect: &Expect) -> Result<Self, Error> {
        // Where samples were dropped, the check fails in any case.
        if film.ledger.dropped == 0 {
            require_samples(film.mean_samples())?;
        }
        let values = values(film, &expect.radiance);
        let bound_sigma = bound_sigma(values.len());
        let allowance = ROUNDING + expect.tolerance;
        let mut worst_sigma: f64 = 0.0;
        let mut failures = Vec::new();
        for mut value in values.iter().copied() {
            let allowed = allowance * value.expected;
            let difference = (value.found - value.expected).abs();
            let sigma = if value.expected > 0.0 {
                value.standard_error * widening(value.samples, values.len())
            } else {
                0.0
            };
            if difference > allowed {
                worst_sigma = worst_sigma.max((difference - allowed) / sigma);
            }
            value.bound = bound_sigma * sigma + allowed;
            if difference > value.bound {
                failures.push(value);
            }
        }
        Ok(Self {
            passed: failures.is_empty() && film.ledger.dropped == 0,
            values: values.len(),
            bound_sigma,
            worst_sigma,
            dropped: film.ledger.dropped,
            failures,
            source: expect.source.clone(),
        })
    }
}

/// Refuses `samples` per pixel when they are too few for a check.
///
/// # Errors
/// [`Error::Usage`] below [`MIN_SAMPLES`].
pub fn require_samples(samples: u64) -> Result<(), Error> {
    if samples >= MIN_SAMPLES {
        return Ok(());
    }
    Err(Error::Usage(format!(
        "--check with {samples} samples per pixel: at least {MIN_SAMPLES} are needed, or the standard error is not known"
    )))
}

/// The values to compare, still without bounds.
fn values(film: &Film, expected: &ExpectedRadiance) -> Vec<Failure> {
    let value = |pixel, samples, found: [f64; 3], error: [f64; 3], expected: glam::DVec3| {
        (0..3).map(move |channel| Failure {
            pixel,
            samples,
            channel,
            found: found[channel],
            expected: expected[channel],
            standard_error: error[channel],
            bound: 0.0,
        })
    };
    // Below two samples, which only dropped ones leave, nothing is known.
    let unknown = [f64::INFINITY; 3];
    match expected {
        ExpectedRadiance::Mean(mean) => {
            let error = film.cautious_standard_error_of_mean().unwrap_or(unknown);
            value(None, film.mean_samples(), film.mean(), error, *mean).collect()
        }
        ExpectedRadiance::Pixels(pixels) => {
            assert_eq!(pixels.len(), film.pixels.len(), "one value per pixel");
            let width = film.size.width;
            let pixels = (0..).zip(film.pixels.iter().zip(pixels));
            let values = pixels.flat_map(|(i, (pixel, &expected))| {
                let variance = pixel.variance_of_mean().unwrap_or(unknown);
                let place = Some([i % width, i / width]);
                let error = variance.map(f64::sqrt);
                value(place, pixel.samples, pixel.mean, error, expected)
            });
            values.collect()
        }
    }
}

/// The standard errors that none of `values` right values exceeds, but with the probability of a
/// [`Family`]'s false alarm; at least [`MIN_SIGMAS`].
fn bound_sigma(values: usize) -> f64 {
    f64::max(Family::new(values.max(1)).z_bound(), MIN_SIGMAS)
}

/// How many times wider the bound of a value of `samples` samples is, one of `values`, as its
/// standard error is itself an estimate: with few samples the difference in standard errors has
/// Student's t-distribution (Student 1908, "The Probable Error of a Mean").
fn widening(samples: u64, values: usize) -> f64 {
    if !(2..MIN_SAMPLES).contains(&samples) {
        return 1.0;
    }
    let level = Family::new(values.max(1)).test_level();
    let bound = student((samples - 1) as f64, 1.0 - level);
    f64::max(bound / bound_sigma(values), 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::layout::PixelState;
    use crate::scene::{FilmSize, Sampler};
    use glam::DVec3;

    /// Two pixels of `samples` samples each with the mean 1 and the standard error 0.01 in every
    /// channel.
    fn film(samples: u32) -> Film {
        let size = FilmSize {
            width: 2,
            height: 1,
        };
        let mut film = Film::new(size, Sampler::Independent);
        let m2 = 1e-4 * samples as f32 * (samples - 1) as f32;
        for pixel in &mut film.pixels {
            pixel.merge(&PixelState {
                samples,
                mean: [1.0; 3],
                m2: [m2; 3],
                ..PixelState::default()
            });
        }
        film
    }

    fn expect(radiance: ExpectedRadiance, tolerance: f64) -> Expect {
        Expect {
            radiance,
            source: "test".to_owned(),
            tolerance,
        }
    }

    fn mean(value: f64, tolerance: f64) -> Expect {
        expect(ExpectedRadiance::Mean(DVec3::splat(value)), tolerance)
    }

    fn check(film: &Film, expect: &Expect) -> Check {
        Check::new(film, expect).expect("there are enough samples")
    }

    #[test]
    fn the_bound_is_sidaks_and_not_below_the_least() {
        assert!((bound_sigma(1) - 4.5).abs() <= 0.0);
        // Φ⁻¹(1 − p/2) with p = 1 − (1 − 1e-4)^(1/values).
        for (values, exact) in [(300, 5.103_5), (3_000_000, 6.631_0)] {
            let bound = bound_sigma(values);
            assert!((bound - exact).abs() < 1e-4, "{values}: {bound}");
        }
        assert!((bound_sigma(0) - 4.5).abs() <= 0.0, "a film without values");
    }

    #[test]
    fn the_mean_has_the_images_standard_error() {
        // 0.01/√2 times 4.5 is 0.0318.
        let film = film(256);
        assert!(check(&film, &mean(1.0312, 0.0)).passed);
        let off = check(&film, &mean(1.0325, 0.0));
        assert!(!off.passed && off.failures.len() == 3);
        assert_eq!((off.failures[1].pixel, off.failures[1].channel), (None, 1));
        assert!((off.worst_sigma - 4.59).abs() < 0.01, "{}", off.worst_sigma);
        assert!(check(&film, &mean(1.0325, 1e-3)).passed, "the tolerance");
    }

    #[test]
    fn pixels_are_compared_one_by_one() {
        let film = film(256);
        let pixels = vec![DVec3::ONE, DVec3::new(1.0, 1.04, 1.05)];
        let off = check(&film, &expect(ExpectedRadiance::Pixels(pixels), 0.0));
        assert_eq!((off.values, off.failures.len()), (6, 1));
        let failure = off.failures[0];
        assert_eq!((failure.pixel, failure.channel), (Some([1, 0]), 2));
    }

    /// An estimator that never meets the light has the variance 0.
    #[test]
    fn a_value_that_does_not_vary_has_to_be_right() {
        let mut film = film(256);
        for pixel in &mut film.pixels {
            pixel.mean = [0.0; 3];
            pixel.m2 = [0.0; 3];
        }
        assert!(check(&film, &mean(0.0, 0.0)).passed);
        let off = check(&film, &mean(1e-3, 0.0));
        assert!(!off.passed && off.worst_sigma.is_infinite());
    }

    /// However large its standard error is: a sample that is not 0 is a leak.
    #[test]
    fn nothing_has_to_be_exactly_nothing() {
        let mut film = film(256);
        for pixel in &mut film.pixels {
            pixel.mean = [1e-3, 0.0, 0.0];
        }
        let off = check(&film, &mean(0.0, 0.0));
        assert!(!off.passed && off.worst_sigma.is_infinite());
        assert_eq!(off.failures.len(), 1);
    }

    /// As adaptive sampling leaves them: few samples where the noise is small.
    #[test]
    fn few_samples_of_a_pixel_widen_its_bound() {
        // F(t) = 1 − 1.66667e-5 at 1 and 3 degrees of freedom, by the closed forms of F.
        for (samples, quantile) in [(2, 19_097.96), (4, 40.414_8)] {
            let found = widening(samples, 3) * bound_sigma(3);
            assert!((found / quantile - 1.0).abs() < 1e-5, "{samples}: {found}");
        }
        let of = |samples| widening(samples, 3072);
        assert!(of(16) > of(32) && of(32) > of(63) && of(63) > 1.0);
        assert!((of(64) - 1.0).abs() <= 0.0);
        let mut film = film(256);
        film.pixels[1].samples = 16;
        film.pixels[1].m2 = [1e-4 * 16.0 * 15.0; 3];
        let at = |value: f64| ExpectedRadiance::Pixels(vec![DVec3::ONE, DVec3::splat(value)]);
        // At 15 degrees of freedom and six values the bound is 6.211 standard errors.
        assert!(check(&film, &expect(at(1.062), 0.0)).passed);
        assert!(!check(&film, &expect(at(1.0623), 0.0)).passed);
        assert!(
            check(&film, &mean(1.0, 0.0)).passed,
            "the mean has them all"
        );
    }

    #[test]
    fn dropped_and_missing_samples_do_not_pass() {
        let mut film = film(63);
        assert!(Check::new(&film, &mean(1.0, 0.0)).is_err());
        film.ledger.dropped = 1;
        let check = check(&film, &mean(1.0, 0.0));
        assert!(!check.passed && check.failures.is_empty());
    }
}
