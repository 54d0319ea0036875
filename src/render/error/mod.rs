//! How right an image is, told by the image itself.
//!
//! Every pixel has two independent *replicates* A and B, the samples with even and with odd
//! indices: two randomisations of the sampler's pattern, each with its own seed. With a and b the
//! replicates' errors, the image (A + B)/2 has the error (a + b)/2, and half the replicates'
//! difference is (a − b)/2. Their squares differ by
//!
//! ```text
//!     ((a + b)/2)² − ((a − b)/2)² = a·b
//! ```
//!
//! a product of two independent numbers whose means are zero. So whatever the sampler and however
//! heavy the tails of its samples, the squared half differences estimate the squared error of *this*
//! image without bias. Of samples that are drawn each by itself each is a replicate, and their
//! scatter does the same with less noise. How far chance takes the one from the other is told by
//! [`chance`].

mod chance;
mod denominators;
mod doubt;
mod evidence;
mod missed;
mod relative;
mod standard_error;

use super::film::Film;
use crate::scene::ErrorMetric;
use crate::stats::interval::{Interval, student};
use chance::SquaredError;
pub use doubt::Doubt;
use evidence::Evidence;
use missed::MissedLight;
use relative::relative;
use serde::ser::{Serialize, SerializeMap, Serializer};
pub use standard_error::tile_sums;

/// Confidence of the interval that is reported unless another is asked for.
pub const CONFIDENCE: f64 = 0.95;
/// What the upper end of an interval of 95 % confidence is at most, in multiples of the error, where
/// the error counts as told.
const TOLD: f64 = 2.5;
/// What small lights may add at most, in multiples of the error that the image shows, where it counts
/// as told.
const MISSED: f64 = 1.5;

/// An error that an image states, in one metric.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StatedError {
    /// The estimate.
    pub value: f64,
    /// Lower end of the interval in which the actual error lies.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// Why the image cannot tell it: its estimate may be off by a factor, and the interval is no
    /// more than a hint. None where it can.
    pub doubt: Option<Doubt>,
}

impl StatedError {
    /// The square root, in percent, with the ends of its interval.
    pub fn percent(&self) -> [f64; 3] {
        [self.value, self.low, self.high].map(|e| 100.0 * e.sqrt())
    }
}

/// The error of an image against the truth, as the image itself states it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImageError {
    /// Mean squared error over the squared mean.
    pub nmse: StatedError,
    /// Relative mean squared error.
    pub rel_mse: StatedError,
    /// Probability with which each lies in its interval.
    pub confidence: f64,
}

impl ImageError {
    /// The error in `metric`.
    pub fn in_metric(&self, metric: ErrorMetric) -> &StatedError {
        match metric {
            ErrorMetric::Nmse => &self.nmse,
            ErrorMetric::RelMse => &self.rel_mse,
        }
    }
}

impl Serialize for ImageError {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        for (name, error) in [("nmse", self.nmse), ("rel_mse", self.rel_mse)] {
            map.serialize_entry(name, &error.value)?;
            map.serialize_entry(&format!("{name}_low"), &error.low)?;
            map.serialize_entry(&format!("{name}_high"), &error.high)?;
            let doubt = error.doubt.map(|doubt| doubt.to_string());
            map.serialize_entry(&format!("{name}_doubt"), &doubt)?;
        }
        map.serialize_entry("confidence", &self.confidence)?;
        map.end()
    }
}

impl Film {
    /// The image's error with intervals of 95 % confidence; see [`error_at`](Self::error_at).
    pub fn error(&self) -> Option<ImageError> {
        self.error_at(CONFIDENCE)
    }

    /// The same, unless `stop`, which is asked now and then, says that nobody waits for it any
    /// more: then `None`, soon.
    pub fn error_unless(&self, stop: impl Fn() -> bool) -> Option<ImageError> {
        self.look(CONFIDENCE, stop)
    }

    /// The image's error, each interval holding with the probability `confidence`; `None` while a
    /// pixel has not two samples, one of each replicate, or when the image is black.
    pub fn error_at(&self, confidence: f64) -> Option<ImageError> {
        self.look(confidence, || false)
    }

    fn look(&self, confidence: f64, stop: impl Fn() -> bool) -> Option<ImageError> {
        let mean = self.mean();
        let overall = (mean[0] + mean[1] + mean[2]) / 3.0;
        let squared_mean = overall * overall;
        let evidence = Evidence::of(self)?;
        if squared_mean <= 0.0 || stop() {
            return None;
        }
        let pixels = self.pixels.len() as f64;
        let of_mean = [1.0 / (3.0 * pixels * squared_mean); 3];
        let missed = MissedLight::of(self);
        let nmse = SquaredError::of(&evidence, |_| of_mean).stated(confidence);
        let errors = self.standard_error_of_mean()?;
        let of_channels = (errors[0] + errors[1] + errors[2]) / 3.0;
        let nmse = nmse.over_square(of_channels / overall, confidence);
        let nmse = nmse.beside(missed.sum(nmse.value, |_| of_mean[0]));
        if stop() {
            return None;
        }
        let rel_mse = relative(self, &evidence, &missed, (0.01 * squared_mean, confidence))?;
        let finite = nmse.value.is_finite() && rel_mse.value.is_finite();
        (finite && !stop()).then_some(ImageError {
            nmse,
            rel_mse,
            confidence,
        })
    }
}

impl StatedError {
    /// The same where the mean whose square it is divided by has the relative standard error `relative`.
    fn over_square(self, relative: f64, confidence: f64) -> Self {
        let ends = |confidence: f64| {
            let off = relative * student(f64::INFINITY, confidence);
            [(1.0 + off).powi(-2), (1.0 - off).max(0.0).powi(-2)]
        };
        let ([low, high], [_, usual]) = (ends(confidence), ends(CONFIDENCE));
        let unknown = || (usual > TOLD).then_some(Doubt::Mean(relative));
        Self {
            low: low * self.low,
            high: high * self.high,
            doubt: self.doubt.or_else(unknown),
            ..self
        }
    }

    /// The same where small lights should add `expected`, whether samples have met them or not.
    fn beside(self, expected: f64) -> Self {
        let times = expected / self.value.max(f64::MIN_POSITIVE);
        if times < MISSED {
            return self;
        }
        Self {
            high: self.high + expected,
            doubt: Some(Doubt::MissedLight(times)),
            ..self
        }
    }
}

impl SquaredError {
    /// As an image states it.
    fn stated(&self, confidence: f64) -> StatedError {
        let Interval { value, low, high } = self.interval(confidence);
        let usual = self.interval(CONFIDENCE);
        StatedError {
            value,
            low,
            high,
            doubt: (usual.high > TOLD * value).then(|| self.doubt()),
        }
    }
}

#[cfg(test)]
mod tests;
