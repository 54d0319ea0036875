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
/// How many decades of squared radiance away other hits may be for being of the same light: a lobe
/// shows it brighter in some pixels than in others.
const NEAR: u32 = 1;

/// What near misses tell about pixels whose samples meet light of about the same radiance.
#[derive(Debug, Clone, Default)]
struct Kind {
    /// Expected hits.
    hits: f64,
    /// The pixels, and what the light adds to the sum of their channels' variances.
    pixels: Vec<(usize, f64)>,
}

/// What near misses tell about a film, by the decade of the squared radiance of hits.
#[derive(Debug, Clone)]
pub(super) struct MissedLight(BTreeMap<i32, Kind>);

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
        Self(kinds)
    }

    /// What such light adds to the squared error of an image, which states `value`; its pixels count with
    /// their `weights`.
    pub(super) fn sum(&self, value: f64, weight: impl Fn(usize) -> f64) -> f64 {
        let kinds = self.0.iter().map(|(decade, kind)| {
            let pixels = kind.pixels.iter();
            let variance: f64 = pixels.map(|&(i, variance)| weight(i) * variance).sum();
            (*decade, kind.hits, variance)
        });
        let kinds: Vec<_> = kinds.collect();
        let is_unmet = |hits: f64, variance: f64| value < 0.5 * (variance / hits);
        let unmet_hits = |decade: i32| -> f64 {
            let near = kinds.iter().filter(|kind| kind.0.abs_diff(decade) <= NEAR);
            let unmet = near.filter(|(_, hits, variance)| is_unmet(*hits, *variance));
            unmet.map(|(_, hits, _)| hits).sum()
        };
        let missed = kinds.iter().map(|&(decade, hits, variance)| {
            let is_unsure = (UNLIKELY..=MANY).contains(&hits);
            if !is_unsure || (is_unmet(hits, variance) && unmet_hits(decade) > SURE) {
                return 0.0;
            }
            variance * hits.min(1.0)
        });
        missed.sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Pixel;
    use crate::scene::{FilmSize, Sampler};

    /// What is missed by an image that states `value` and expects so many hits of the squared
    /// radiances, each in a pixel of its own.
    fn missed(value: f64, hits: &[(f64, f64)]) -> f64 {
        let size = FilmSize {
            width: hits.len() as u32,
            height: 1,
        };
        let mut film = Film::new(size, Sampler::Sobol);
        for (pixel, (hits, square)) in film.pixels.iter_mut().zip(hits) {
            *pixel = Pixel {
                samples: 10,
                expected_hits: *hits,
                expected_squares: hits * square,
                ..Pixel::default()
            };
        }
        MissedLight::of(&film).sum(value, |_| 1.0)
    }

    /// Of six expected hits of one light an image shows one, if they are right, however a lobe spreads
    /// them over decades; what is far brighter or rarer is another light.
    #[test]
    fn hits_that_should_have_shown_are_no_hits() {
        let is = |found: f64, expected: f64| (found - expected).abs() < 1e-9 * expected.max(1e-9);
        let spread = [(2.0, 300.0), (2.0, 3e3), (2.0, 3e4)];
        assert!(is(missed(0.1, &spread[..1]), 6.0));
        assert!(is(missed(0.1, &[(6.0, 3e3)]), 0.0));
        // The middle one has six around it, the others four.
        assert!(is(missed(0.1, &spread), 6.0 + 600.0));
        let one_more = [(4.0, 300.0), (2.0, 3e3), (4.0, 3e4)];
        assert!(is(missed(0.1, &one_more), 0.0));
        // The image may have met the dim ones, and four hits are not enough.
        assert!(is(missed(20.0, &one_more), 12.0 + 60.0 + 1200.0));
        let other = [(6.0, 300.0), (0.01, 3e9)];
        assert!(is(missed(0.1, &other), 0.01 * 0.01 * 3e7));
    }
}
