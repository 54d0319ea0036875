//! Single samples, as the kernel computes them.

use super::context::Context;
use super::kernel::RECORD;
use super::layout::{Dispatch, SampleRecord};
use super::program::POISON;
use super::tiles::TileProgram;
use crate::error::GpuError;
use crate::prepare::Prepared;
use crate::scene::FilmSize;

/// Writes out samples of a render, one per pixel at a time, with what their rays met.
#[derive(Debug)]
pub struct Recorder<'a> {
    program: TileProgram<'a, SampleRecord>,
    /// Radiance that the kernel has as 1.
    unit: f32,
    film: FilmSize,
}

impl<'a> Recorder<'a> {
    /// Compiles the recording kernel and uploads the scene.
    ///
    /// # Errors
    /// The kernel does not compile, or the scene is too large for the adapter.
    pub fn new(
        context: &'a Context,
        prepared: &Prepared,
        film: FilmSize,
        seed: u32,
    ) -> Result<Self, GpuError> {
        let program = TileProgram::new(context, prepared, film, seed, &RECORD)?;
        Ok(Self {
            program,
            unit: prepared.emitters.unit as f32,
            film,
        })
    }

    fn in_world_units(&self, record: &SampleRecord) -> SampleRecord {
        let scaled = |radiance: [f32; 3]| radiance.map(|x| self.unit * x);
        SampleRecord {
            radiance: scaled(record.radiance),
            by_light: scaled(record.by_light),
            by_bsdf: scaled(record.by_bsdf),
            ..*record
        }
    }

    /// Sample `index` of every pixel, row by row.
    ///
    /// # Errors
    /// The driver fails, or leaves a sample unfinished.
    pub fn samples(&self, index: u64) -> Result<Vec<SampleRecord>, GpuError> {
        let mut out = vec![SampleRecord::default(); self.film.pixels()];
        let mut unwritten = 0;
        let parameters = Dispatch {
            block_start: [index as u32, (index >> 32) as u32],
            ..Dispatch::default()
        };
        self.program.run(&parameters, |pixel, record| {
            unwritten += usize::from(record.bsdf_primitive == POISON);
            out[pixel] = self.in_world_units(record);
        })?;
        if unwritten > 0 {
            return Err(self.program.unfinished(unwritten));
        }
        Ok(out)
    }
}
