//! The same random numbers through GPU and twin: every sample must be the same, up to f32's
//! rounding.
//!
//! A sample's *difference* is |GPU − twin| / √(v² + 0.01·m²) in the worst channel, with v the
//! larger of the two and m the mean of the image over pixels and channels: the same floor under
//! small values as that of relMSE. It is there because rounding moves the point that a camera ray
//! meets by about 2⁻²³ of the scene: a sample whose cosine at the light is 10⁻⁵ then has a relative
//! error of 10⁻² in f32, however it is computed, and adds next to nothing to its pixel. How
//! differences are distributed relative to the sample alone is reported as well. Fractions are of
//! the samples that carry light: black ones agree too easily.

use super::per_pixel::Accumulator as Means;
use super::{cause, flip, radiance};
use direkt::low_level::gpu::layout::SampleRecord;
use direkt::low_level::reference::{Sample, Twin};
use direkt::scene::FilmSize;
use glam::{DVec2, DVec3};
use serde::Serialize;

/// Most that a sample may differ.
pub const TOLERANCE: f64 = 1e-3;
/// Largest fraction of samples that may differ by more than [`TOLERANCE`] and by more than rounding
/// the camera ray explains: narrow lobes and grazing angles amplify rounding without a bound,
/// wherever it comes in.
pub const MAX_BEYOND: f64 = 1e-3;
/// Largest fraction of samples whose rays may meet something else on the GPU: those that pass an
/// edge within rounding. A sample of several shadow rays, or of several camera rays, counts as so
/// many.
pub const MAX_FLIPS: f64 = 1e-4;
/// Angle by which f32 turns a camera ray: four roundings of a direction, 2⁻²⁴ each.
const RAY_ROUNDING: f64 = 4.0 / 16_777_216.0;
/// What rounding does after the camera ray is at most so many times what turning the ray does.
const FURTHER_ROUNDING: f64 = 4.0;
/// Where a larger fraction of the samples differs it is not for rounding, and the twin is not asked
/// again.
const ASKED_AGAIN: f64 = 0.1;
/// Differences relative to the sample alone below this are counted, not kept.
const SUSPECT: f64 = 1e-5;
/// Decades of the histogram: 10⁻⁸ and less, …, 10⁻¹ and more.
const DECADES: usize = 8;

/// Which ray met something else.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Flip {
    /// The camera ray.
    Camera,
    /// So many shadow rays.
    Shadow(u32),
    /// The BSDF-sampled ray.
    Bsdf,
}

/// Rays that met something else.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Flips {
    /// Camera rays.
    pub camera: u64,
    /// Shadow rays.
    pub shadow: u64,
    /// BSDF-sampled rays.
    pub bsdf: u64,
}

impl Flips {
    fn count<'a>(suspects: impl Iterator<Item = &'a Suspect>) -> Self {
        let mut flips = Self::default();
        for suspect in suspects {
            match suspect.flip {
                None => {}
                Some(Flip::Camera) => flips.camera += 1,
                Some(Flip::Shadow(rays)) => flips.shadow += u64::from(rays),
                Some(Flip::Bsdf) => flips.bsdf += 1,
            }
        }
        flips
    }

    fn total(self) -> u64 {
        self.camera + self.shadow + self.bsdf
    }
}

/// A sample that differs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WorstSample {
    /// Column of its pixel.
    pub x: u32,
    /// Row of its pixel.
    pub y: u32,
    /// Its index.
    pub sample: u64,
    /// By how much.
    pub difference: f64,
    /// Radiance on the GPU.
    pub gpu: [f64; 3],
    /// Radiance of the twin.
    pub reference: [f64; 3],
    /// Why.
    pub cause: String,
}

/// How samples compare.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PerSample {
    /// Samples compared.
    pub samples: u64,
    /// Rays that met something else.
    pub flips: Flips,
    /// They over the samples, those of several shadow or camera rays counted so many times.
    pub flip_rate: f64,
    /// The samples none of whose rays did and that are not black on both sides.
    pub lit: u64,
    /// Fraction of the lit samples that differ by at most 10⁻⁴.
    pub within_1e_4: f64,
    /// By at most 10⁻³.
    pub within_1e_3: f64,
    /// Fraction of the lit samples that differ by more, and by more than the reference does when
    /// its camera ray is turned as far as f32 rounds it: fine textures and normal maps, narrow
    /// lobes and grazing angles amplify that.
    pub unexplained: f64,
    /// Fractions of the lit samples' differences relative to the sample alone: exactly 0 first,
    /// then by decade, from below 10⁻⁸ to 10⁻¹ and more.
    pub histogram: Vec<f64>,
    /// GPU samples that were not finite.
    pub not_finite: u64,
    /// The sample that differs most.
    pub worst: Option<WorstSample>,
    /// A sample whose rays met something else, the one with the largest difference.
    pub worst_flip: Option<WorstSample>,
}

impl PerSample {
    /// Whether they agree.
    pub fn agrees(&self) -> bool {
        self.not_finite == 0 && self.flip_rate <= MAX_FLIPS && self.unexplained <= MAX_BEYOND
    }
}

/// A sample that has to be looked at again when the image's mean is known.
#[derive(Debug, Clone, Copy)]
struct Suspect {
    pixel: u32,
    index: u64,
    gpu: DVec3,
    twin: DVec3,
    flip: Option<Flip>,
}

impl Suspect {
    /// Whether rays met something else. Shadow rays that did but changed nothing to speak of did
    /// not: a light at the very horizon is lit by rounding alone, and adds nothing.
    fn is_flip(&self, floor: f64) -> bool {
        match self.flip {
            None => false,
            Some(Flip::Shadow(_)) => self.difference(floor) > TOLERANCE,
            Some(Flip::Camera | Flip::Bsdf) => true,
        }
    }

    fn difference(&self, floor: f64) -> f64 {
        difference(self.gpu, self.twin, floor)
    }
}

/// Counts while samples come.
#[derive(Debug)]
pub struct Accumulator {
    film: FilmSize,
    samples: u64,
    /// Shadow rays of all samples beyond the first of each, and camera rays.
    further_rays: u64,
    histogram: [u64; DECADES + 2],
    lit: u64,
    not_finite: u64,
    suspects: Vec<Suspect>,
}

impl Accumulator {
    /// Nothing counted yet.
    pub fn new(film: FilmSize) -> Self {
        Self {
            film,
            samples: 0,
            further_rays: 0,
            histogram: [0; DECADES + 2],
            lit: 0,
            not_finite: 0,
            suspects: Vec::new(),
        }
    }

    /// Adds sample `index` of every pixel.
    pub fn add(&mut self, index: u64, gpu: &[SampleRecord], twin: &[Sample]) {
        for (pixel, (record, sample)) in gpu.iter().zip(twin).enumerate() {
            self.samples += 1;
            let rays = sample.path.shadow.traced.saturating_sub(1) + sample.path.further_rays;
            self.further_rays += u64::from(rays);
            let suspect = Suspect {
                pixel: pixel as u32,
                index,
                gpu: radiance(record),
                twin: sample.radiance,
                flip: flip(record, sample),
            };
            if !suspect.gpu.is_finite() {
                self.not_finite += 1;
                continue;
            }
            if suspect.flip.is_some() {
                self.suspects.push(suspect);
                continue;
            }
            if suspect.gpu.max(suspect.twin).max_element() <= 0.0 {
                continue;
            }
            self.lit += 1;
            let alone = difference(suspect.gpu, suspect.twin, 0.0);
            self.histogram[decade(alone)] += 1;
            if alone > SUSPECT {
                self.suspects.push(suspect);
            }
        }
    }

    /// The result; `means` tells the image's mean.
    pub fn finish(self, twin: &Twin<'_>, means: &Means) -> PerSample {
        let floor = 0.1 * means.reference_mean().element_sum() / 3.0;
        let differs = |s: &Suspect| s.difference(floor);
        let flips = Flips::count(self.suspects.iter().filter(|s| s.is_flip(floor)));
        let lit = self.lit.max(1) as f64;
        let same_rays = || self.suspects.iter().filter(|s| !s.is_flip(floor));
        let within =
            |bound: f64| 1.0 - same_rays().filter(|s| differs(s) > bound).count() as f64 / lit;
        let beyond: Vec<_> = same_rays().filter(|s| differs(s) > TOLERANCE).collect();
        let unexplained = if beyond.len() as f64 > ASKED_AGAIN * lit {
            beyond.len()
        } else {
            let explained =
                |s: &&&Suspect| differs(s) <= FURTHER_ROUNDING * self.rounding_of(s, twin, floor);
            beyond.len() - beyond.iter().filter(explained).count()
        };
        let unexplained = unexplained as f64 / lit;
        let worst = |flip: bool| {
            let worst = self
                .suspects
                .iter()
                .filter(|s| s.is_flip(floor) == flip)
                .max_by(|a, b| differs(a).total_cmp(&differs(b)))?;
            let (x, y) = (worst.pixel % self.film.width, worst.pixel / self.film.width);
            let sample = twin.direct().sample_radiance(x, y, worst.index);
            Some(WorstSample {
                x,
                y,
                sample: worst.index,
                difference: differs(worst),
                gpu: worst.gpu.to_array(),
                reference: worst.twin.to_array(),
                cause: cause::cause(&sample, differs(worst), flip),
            })
        };
        PerSample {
            samples: self.samples,
            flips,
            flip_rate: flips.total() as f64 / (self.samples + self.further_rays).max(1) as f64,
            lit: self.lit,
            within_1e_4: within(1e-4),
            within_1e_3: within(TOLERANCE),
            unexplained,
            histogram: self.histogram.map(|n| n as f64 / lit).to_vec(),
            not_finite: self.not_finite,
            worst: worst(false),
            worst_flip: worst(true),
        }
    }
}

impl Accumulator {
    /// What turning a suspect's camera ray as far as f32 rounds it makes its twin differ, at most.
    fn rounding_of(&self, suspect: &Suspect, twin: &Twin<'_>, floor: f64) -> f64 {
        let pixel = (
            suspect.pixel % self.film.width,
            suspect.pixel / self.film.width,
        );
        let turns = [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y];
        let turned = turns.map(|turn| {
            let sample = twin
                .direct()
                .turned_sample(pixel, suspect.index, RAY_ROUNDING * turn);
            difference(sample.radiance, suspect.twin, floor)
        });
        turned.into_iter().fold(0.0, f64::max)
    }
}

/// The difference of `a` and `b` in the worst channel, relative to √(v² + `floor`²).
fn difference(a: DVec3, b: DVec3, floor: f64) -> f64 {
    let in_channel = |c: usize| {
        let v = a[c].abs().max(b[c].abs());
        (a[c] - b[c]).abs() / v.hypot(floor).max(f64::MIN_POSITIVE)
    };
    (0..3).map(in_channel).fold(0.0, f64::max)
}

fn decade(difference: f64) -> usize {
    if difference <= 0.0 {
        return 0;
    }
    let decade = difference.log10().floor() + DECADES as f64 + 2.0;
    decade.clamp(1.0, DECADES as f64 + 1.0) as usize
}
