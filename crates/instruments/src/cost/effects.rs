//! What an estimator is compiled with: the effects that the scene calls for, and further ones.
//!
//! Unneeded effects change no bit of an image, so that the error at equal samples
//! is equal and what differs is time. Both are measured: estimators that differ in nothing else
//! have the same random numbers, and their images are compared.

use super::interval::Interval;
use direkt::low_level::effects::{Effect, Effects};
use direkt::low_level::render::{Film, Pixel};
use serde::{Serialize, Serializer};

/// Effects that an estimator is compiled with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Compiled {
    /// Those that the scene calls for.
    #[default]
    CalledFor,
    /// Also this one.
    With(Effect),
    /// Also all others but ways of sampling.
    WithEverything,
}

impl Compiled {
    /// The keyword of [`WithEverything`](Self::WithEverything).
    pub const EVERYTHING: &'static str = "everything";

    /// Its name in JSON and CSV.
    pub fn key(self) -> &'static str {
        match self {
            Self::CalledFor => "called-for",
            Self::With(effect) => effect.name(),
            Self::WithEverything => Self::EVERYTHING,
        }
    }

    /// The effects that are compiled in beside `called_for`.
    pub fn without_need(self, called_for: &Effects) -> Vec<Effect> {
        let effects = match &self {
            Self::CalledFor => &[],
            Self::With(effect) => std::slice::from_ref(effect),
            Self::WithEverything => Effect::ALL,
        };
        let effects = effects.iter().copied();
        effects.filter(|e| called_for.can_force(*e)).collect()
    }

    /// Why it is no other than [`CalledFor`](Self::CalledFor) where `called_for` are called for;
    /// none where it is.
    pub fn why_not(self, called_for: &Effects) -> Option<String> {
        if self == Self::CalledFor || !self.without_need(called_for).is_empty() {
            return None;
        }
        let reason = |effect| called_for.iter().find(|(e, _)| *e == effect);
        Some(match self {
            Self::With(effect) => match reason(effect) {
                Some((_, reason)) => format!("the scene calls for it anyway: {reason}"),
                None => "it is a way of sampling, which changes the image's noise".to_owned(),
            },
            _ => "the scene calls for everything".to_owned(),
        })
    }
}

/// `called for`, `+ everything`, or `+` and the effect.
impl std::fmt::Display for Compiled {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::CalledFor => f.write_str("called for"),
            _ => write!(f, "+ {}", self.key()),
        }
    }
}

impl Serialize for Compiled {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.key())
    }
}

/// What unneeded effects cost, against the same estimator with what the
/// scene calls for.
#[derive(Debug, Clone, Serialize)]
pub struct WithoutNeed {
    /// Index of that estimator.
    pub against: usize,
    /// The effects.
    pub effects: Vec<&'static str>,
    /// Whether the images are the same.
    #[serde(flatten)]
    pub agreement: Agreement,
    /// Time over its time, at the largest count.
    pub time_ratio: Interval,
    /// Efficiency over its efficiency: 1/`time_ratio`, the errors being equal; none where the
    /// images differ.
    pub efficiency_ratio: Option<Interval>,
    /// Compile time over its compile time; each was compiled once.
    pub compile_ratio: f64,
}

impl WithoutNeed {
    /// Whether the times cannot be told apart.
    pub fn is_tie(&self) -> bool {
        (self.time_ratio.low..=self.time_ratio.high).contains(&1.0)
    }
}

/// How images with the same random numbers compare.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Agreement {
    /// Pairs of images that were compared.
    pub images: u64,
    /// Pairs of pixels in all of them.
    pub pixels: u64,
    /// How many of these differ in some bit of mean, spread, or number of samples.
    pub pixels_differ: u64,
}

impl Agreement {
    /// Compares a pair of images of the same size.
    pub fn add(&mut self, a: &Film, b: &Film) {
        let pairs = a.pixels.iter().zip(&b.pixels);
        let differ = pairs.filter(|(a, b)| bits(a) != bits(b)).count();
        self.images += 1;
        self.pixels += a.pixels.len() as u64;
        self.pixels_differ += differ as u64;
    }

    /// Whether all bits of all pixels were the same.
    pub fn is_exact(&self) -> bool {
        self.pixels_differ == 0
    }
}

fn bits(pixel: &Pixel) -> ([u64; 2], [[u64; 3]; 4]) {
    let values = [pixel.mean, pixel.m2, pixel.second_mean, pixel.second_m2];
    let counts = [pixel.samples, pixel.second_samples];
    (counts, values.map(|v| v.map(f64::to_bits)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use direkt::scene::{FilmSize, Sampler};

    #[test]
    fn what_is_called_for_is_not_compiled_in_without_need() {
        let mut called_for = Effects::default();
        called_for.call_for(Effect::Spheres, || "a sphere".to_owned());
        let count = |compiled: Compiled| compiled.without_need(&called_for).len();
        assert_eq!(count(Compiled::CalledFor), 0);
        assert_eq!(count(Compiled::With(Effect::Disks)), 1);
        assert_eq!(count(Compiled::With(Effect::Spheres)), 0);
        let can_be = Effect::ALL.iter().filter(|e| e.can_be_forced()).count();
        assert_eq!(count(Compiled::WithEverything), can_be - 1);

        let why_not = |compiled: Compiled| compiled.why_not(&called_for);
        let anyway = "the scene calls for it anyway: a sphere".to_owned();
        assert_eq!(why_not(Compiled::With(Effect::Spheres)), Some(anyway));
        assert_eq!(why_not(Compiled::With(Effect::Disks)), None);
        assert_eq!(why_not(Compiled::CalledFor), None);
        let sampling = why_not(Compiled::With(Effect::SobolSampler));
        assert!(sampling.is_some_and(|reason| reason.contains("way of sampling")));
    }

    #[test]
    fn a_bit_is_a_difference() {
        let size = FilmSize {
            width: 3,
            height: 2,
        };
        let a = Film::new(size, Sampler::Sobol);
        let mut b = a.clone();
        let mut agreement = Agreement::default();
        agreement.add(&a, &b);
        assert!(agreement.is_exact());
        b.pixels[4].mean[1] = -0.0;
        b.pixels[5].m2[2] = f64::from_bits(1);
        agreement.add(&a, &b);
        let expected = Agreement {
            images: 2,
            pixels: 12,
            pixels_differ: 2,
        };
        assert_eq!(agreement, expected);
    }
}
