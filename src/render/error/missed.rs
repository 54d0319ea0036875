//! Small lights that samples may not have met as often as they should.
//!
//! With the chance p of a sample to meet light of the radiance X, that light adds pX²/n to the
//! variance of a pixel's mean, but an image whose samples have not met it shows nothing of that. Its
//! squared error is then (pX)² or np times as much. Near misses, of which there are many more, tell
//! both pX² and p, pixel by pixel (`shaders/kernel/near_misses.wesl`).

use crate::render::film::Film;
use std::collections::BTreeMap;

/// Expected hits in an image below which images of a thousand times as many samples are not likely to
/// show the light either: what they state is without it.
const UNLIKELY: f64 = 0.001;
/// Expected hits from which on the image shows what they add.
const MANY: f64 = 20.0;
/// Expected hits of which an image hardly ever shows none, if they are right: with a probability of
/// e⁻⁵. Rays nearly meet lights also where no mirror would show them.
const SURE: f64 = 5.0;

/// What near misses tell about pixels whose samples meet light of about the same radiance.
#[derive(Debug, Clone, Default)]
struct Kind {
    /// Expected hits.
    hits: f64,
    /// The pixels, and what the light adds to the sum of their channels' variances.
    pixels: Vec<(usize, f64)>,
}

/// What near misses tell about a film.
#[derive(Debug, Clone)]
pub(super) struct MissedLight(Vec<Kind>);

impl MissedLight {
    pub(super) fn of(film: &Film) -> Self {
        let mut kinds: BTreeMap<i32, Kind> = BTreeMap::new();
        for (i, pixel) in film.pixels.iter().enumerate() {
            let square = pixel.expected_squares / pixel.expected_hits;
            if square > 0.0 && square.is_finite() {
                let kind = kinds.entry(square.log10().floor() as i32).or_default();
                let n = pixel.samples as f64;
                kind.hits += pixel.expected_hits;
                kind.pixels.push((i, pixel.expected_squares / (n * n)));
            }
        }
        let unsure = |kind: &Kind| kind.hits >= UNLIKELY && kind.hits <= MANY;
        Self(kinds.into_values().filter(unsure).collect())
    }

    /// What such light adds to the squared error of an image, which states `value`; its pixels count with
    /// their `weights`.
    pub(super) fn sum(&self, value: f64, weight: impl Fn(usize) -> f64) -> f64 {
        let kinds = self.0.iter().map(|kind| {
            let pixels = kind.pixels.iter();
            let variance: f64 = pixels.map(|&(i, variance)| weight(i) * variance).sum();
            let of_one = variance / kind.hits;
            if kind.hits > SURE && value < 0.5 * of_one {
                return 0.0;
            }
            variance * kind.hits.min(1.0)
        });
        kinds.sum()
    }
}
