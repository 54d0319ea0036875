//! What denoisers and compositors ask for, as the kernels compute it.

use super::context::Context;
use super::kernel::{FEATURES, GBUFFER};
use super::layout::{Dispatch, FeatureSums, SurfaceRecord};
use super::program::POISON;
use super::tiles::TileProgram;
use crate::error::GpuError;
use crate::prepare::Prepared;
use crate::scene::FilmSize;

/// Samples of one dispatch at most.
const BATCH: u32 = 8;

/// Sums of features over samples of each pixel, in f64.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Features {
    /// Albedo where camera paths end.
    pub albedo: [f64; 3],
    /// Unit shading normal there, world space.
    pub normal: [f64; 3],
}

impl Features {
    fn add(&mut self, sums: &FeatureSums) {
        for c in 0..3 {
            self.albedo[c] += f64::from(sums.albedo[c]);
            self.normal[c] += f64::from(sums.normal[c]);
        }
    }

    fn scaled(self, factor: f64) -> Self {
        Self {
            albedo: self.albedo.map(|x| x * factor),
            normal: self.normal.map(|x| x * factor),
        }
    }
}

/// Means over the first `samples` samples of every pixel, row by row.
///
/// # Errors
/// The scene is too large for the adapter, or the driver fails or leaves a sample unfinished.
pub fn features(
    context: &Context,
    prepared: &Prepared,
    (film, seed): (FilmSize, u32),
    samples: u64,
) -> Result<Vec<Features>, GpuError> {
    let program = TileProgram::<FeatureSums>::new(context, prepared, film, seed, &FEATURES)?;
    let mut means = vec![Features::default(); film.pixels()];
    let mut batch = BATCH;
    let mut first = 0;
    let mut sums = vec![FeatureSums::default(); film.pixels()];
    while first < samples {
        let count = u64::from(batch).min(samples - first) as u32;
        let parameters = Dispatch {
            block_start: [first as u32, (first >> 32) as u32],
            target_position: count,
            ..Dispatch::default()
        };
        let mut unfinished = 0;
        program.run(&parameters, |pixel, of_pixel| {
            unfinished += usize::from(of_pixel.samples != count);
            sums[pixel] = *of_pixel;
        })?;
        if unfinished == 0 {
            for (mean, sums) in means.iter_mut().zip(&sums) {
                mean.add(sums);
            }
            first += u64::from(count);
        } else if batch > 1 {
            // The driver ends loops early: one sample at a time.
            batch = 1;
        } else {
            return Err(program.unfinished(unfinished));
        }
    }
    let mean = |sum: Features| sum.scaled(1.0 / samples.max(1) as f64);
    Ok(means.into_iter().map(mean).collect())
}

/// The surface in the middle of every pixel, row by row.
///
/// # Errors
/// The scene is too large for the adapter, or the driver fails or leaves a pixel unfinished.
pub fn surfaces(
    context: &Context,
    prepared: &Prepared,
    (film, seed): (FilmSize, u32),
) -> Result<Vec<SurfaceRecord>, GpuError> {
    let program = TileProgram::<SurfaceRecord>::new(context, prepared, film, seed, &GBUFFER)?;
    let mut out = vec![SurfaceRecord::default(); film.pixels()];
    let mut unfinished = 0;
    program.run(&Dispatch::default(), |pixel, record| {
        unfinished += usize::from(record.primitive == POISON);
        out[pixel] = *record;
    })?;
    if unfinished > 0 {
        return Err(program.unfinished(unfinished));
    }
    Ok(out)
}
