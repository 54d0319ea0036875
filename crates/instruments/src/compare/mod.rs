//! The GPU estimator against the reference, on any scene.
//!
//! - [`per_sample`]: the same random numbers through both; the radiance of every sample, and what
//!   its rays met.
//! - [`accumulation`]: the film that a render gives against the mean of its recorded samples.
//! - [`per_pixel`]: other random numbers; is each pixel's mean the same?
//! - [`whole_image`]: is the image's mean the same?
//! - [`exact`]: where a scene allows it, the GPU's samples against exact direct lighting at the
//!   points that they see.

pub mod accumulation;
mod cause;
pub mod exact;
pub mod per_pixel;
pub mod per_sample;
pub mod whole_image;

use accumulation::Accumulation;
use direkt::error::GpuError;
use direkt::low_level::gpu::Context;
use direkt::low_level::gpu::layout::SampleRecord;
use direkt::low_level::gpu::recorder::Recorder;
use direkt::low_level::prepare::Prepared;
use direkt::low_level::reference::exact::scene::NotExact;
use direkt::low_level::reference::{BrokenTwin, Sample, Twin};
use direkt::low_level::render::Session;
use direkt::low_level::stats::sidak::{FAMILY_LEVEL, Family};
use direkt::low_level::stats::symmetric::minimum_pairs;
use direkt::scene::FilmSize;
use exact::Exact;
use glam::DVec3;
use per_pixel::PerPixel;
use per_sample::PerSample;
use serde::Serialize;
use whole_image::WholeImage;

/// What to compare.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Size of the image that is compared.
    pub film: FilmSize,
    /// Samples per pixel, at least [`minimum_samples`].
    pub samples: u64,
    /// Seed of the GPU, and of the twin where it is fed the same random numbers.
    pub seed: u32,
    /// The mistake that the twin makes.
    pub broken: Option<BrokenTwin>,
    /// Whether to compare with exact answers as well.
    pub exact: bool,
}

/// Pixels that a comparison takes unless told otherwise.
pub const DEFAULT_PIXELS: u32 = 1 << 14;

/// The film of at most [`DEFAULT_PIXELS`] pixels with the proportions of `film`.
pub fn default_film(film: FilmSize) -> FilmSize {
    let pixels = film.pixels() as f64;
    let factor = (f64::from(DEFAULT_PIXELS) / pixels).sqrt().min(1.0);
    let side = |n: u32| ((f64::from(n) * factor).floor() as u32).max(1);
    FilmSize {
        width: side(film.width),
        height: side(film.height),
    }
}

/// The tests of all pixels and channels.
fn pixel_family(film: FilmSize) -> Family {
    Family {
        level: FAMILY_LEVEL / 3.0,
        tests: 3 * film.pixels(),
    }
}

/// The tests of the image's mean.
const IMAGE_FAMILY: Family = Family {
    level: FAMILY_LEVEL / 3.0,
    tests: 3,
};

/// The tests of the samples' mean against exact answers.
const EXACT_FAMILY: Family = IMAGE_FAMILY;

/// Fewest samples per pixel with which a pixel of `film` can be found to differ.
pub fn minimum_samples(film: FilmSize) -> u64 {
    minimum_pairs(pixel_family(film).test_level()) as u64
}

/// What a comparison can fail with.
#[derive(Debug, thiserror::Error)]
pub enum CompareError {
    /// Exact answers were asked for, and the scene has none.
    #[error(transparent)]
    NotExact(#[from] NotExact),
    /// The GPU or its driver failed.
    #[error(transparent)]
    Gpu(#[from] GpuError),
}

/// The result of a comparison.
#[derive(Debug, Clone, Serialize)]
pub struct Comparison {
    /// Sample by sample.
    pub per_sample: PerSample,
    /// The film against its samples.
    pub accumulation: Accumulation,
    /// Pixel by pixel.
    pub per_pixel: PerPixel,
    /// The image's mean.
    pub whole_image: WholeImage,
    /// Against exact answers, where that was asked for.
    pub exact: Option<Exact>,
    /// Per pixel the GPU's mean, the twin's, and their t per channel.
    #[serde(skip)]
    pub pixels: Vec<PixelComparison>,
}

/// One pixel of a comparison.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelComparison {
    /// Mean of the GPU.
    pub gpu: DVec3,
    /// Mean of the twin with random numbers of its own.
    pub reference: DVec3,
    /// Self-normalised difference.
    pub t: [f64; 3],
}

impl Comparison {
    /// Whether everything agrees.
    pub fn agrees(&self) -> bool {
        self.per_sample.agrees()
            && self.accumulation.agrees()
            && self.per_pixel.agrees()
            && self.whole_image.agrees()
            && self.exact.as_ref().is_none_or(Exact::agrees)
    }
}

/// Compares `prepared` on `context` with the reference. `progress` is told after each sample index
/// how many of [`Settings::samples`] are done.
///
/// # Errors
/// The reference lacks an effect of the scene, the scene has no exact answers where they are asked
/// for, or the driver fails.
pub fn compare(
    context: &Context,
    prepared: &Prepared,
    settings: &Settings,
    mut progress: impl FnMut(u64),
) -> Result<Comparison, CompareError> {
    let Settings {
        film,
        samples,
        seed,
        broken,
        exact,
    } = *settings;
    let twin = Twin::new(prepared, film, seed, broken);
    let other = Twin::new(prepared, film, independent(seed), broken);
    let mut exact = exact
        .then(|| exact::Accumulator::new(&twin, film.width))
        .transpose()?;
    let recorder = Recorder::new(context, prepared, film, seed)?;
    let mut per_sample = per_sample::Accumulator::new(film);
    let mut means = per_pixel::Accumulator::new(film);
    let mut largest = vec![DVec3::ZERO; film.pixels()];
    for index in 0..samples {
        let gpu = recorder.samples(index)?;
        per_sample.add(index, &gpu, &twin.samples(index));
        means.add(&gpu, &other.samples(index));
        if let Some(exact) = &mut exact {
            exact.add(index, &gpu);
        }
        for (largest, gpu) in largest.iter_mut().zip(&gpu) {
            *largest = largest.max(radiance(gpu));
        }
        progress(index + 1);
    }
    let mut session = Session::new(context, prepared, film, seed)?;
    session.set_adaptive(false);
    session.fix_shadow_rays(prepared.shadow_rays());
    while session.samples() < samples {
        session.pass(session.pass_samples(samples - session.samples()), || false)?;
    }
    let (rendered, _) = session.snapshot()?;
    Ok(Comparison {
        per_sample: per_sample.finish(&twin, &means),
        accumulation: Accumulation::new(&rendered, &means, &largest),
        per_pixel: PerPixel::new(&means),
        whole_image: WholeImage::new(&means),
        exact: exact.map(exact::Accumulator::finish),
        pixels: means.pixels(),
    })
}

/// A seed whose random numbers have nothing to do with those of `seed`.
fn independent(seed: u32) -> u32 {
    seed ^ 0x5bd1_e995
}

/// Radiance of a record.
fn radiance(record: &SampleRecord) -> DVec3 {
    DVec3::from_array(record.radiance.map(f64::from))
}

/// Whether GPU and twin agree about what reached the surface: the same primitives, and light found
/// by as many shadow rays. Samples to which no light came agree, whether or not one of them traced
/// a shadow ray to find out.
fn flip(gpu: &SampleRecord, twin: &Sample) -> Option<per_sample::Flip> {
    use direkt::low_level::gpu::layout::{NONE, NOT_TRACED};
    use direkt::low_level::reference::BsdfRay;
    use per_sample::Flip;
    let bsdf = match twin.path.bsdf {
        BsdfRay::NotTraced => NOT_TRACED,
        BsdfRay::Missed => NONE,
        BsdfRay::Hit(primitive) => primitive,
    };
    let shadow = twin.path.shadow.clear.abs_diff(gpu.clear_shadow_rays());
    if twin.path.camera.unwrap_or(NONE) != gpu.camera_primitive {
        Some(Flip::Camera)
    } else if shadow > 0 {
        Some(Flip::Shadow(shadow))
    } else if bsdf != gpu.bsdf_primitive {
        Some(Flip::Bsdf)
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::per_sample::Flip;
    use super::*;
    use direkt::low_level::gpu::layout::{NONE, NOT_TRACED, SHADOW_CLEAR, SHADOW_TRACED};
    use direkt::low_level::reference::{BsdfRay, Path, Shadow};

    #[test]
    fn shadow_rays_flip_one_by_one() {
        let twin = Sample {
            path: Path {
                camera: Some(3),
                shadow: Shadow {
                    traced: 7,
                    clear: 4,
                },
                bsdf: BsdfRay::Missed,
                ..Path::default()
            },
            ..Sample::default()
        };
        let gpu = |traced: u32, clear: u32| SampleRecord {
            camera_primitive: 3,
            bsdf_primitive: NONE,
            shadow: traced * SHADOW_TRACED + clear * SHADOW_CLEAR,
            ..SampleRecord::default()
        };
        assert_eq!(flip(&gpu(7, 4), &twin), None);
        // To find out that nothing arrives takes a ray on one side, and none on the other.
        assert_eq!(flip(&gpu(9, 4), &twin), None);
        assert_eq!(flip(&gpu(7, 1), &twin), Some(Flip::Shadow(3)));
        let dark = SampleRecord {
            bsdf_primitive: NOT_TRACED,
            ..gpu(7, 4)
        };
        assert_eq!(flip(&dark, &twin), Some(Flip::Bsdf));
    }
}
