//! Single samples, as the kernel computes them.

use super::buffer::GpuBuffer;
use super::context::Context;
use super::kernel::{OwnBindings, RECORD};
use super::layout::{Dispatch, SampleRecord, TILE, TILE_PIXELS, lane_pixel};
use super::program::{POISON, SceneProgram};
use crate::error::GpuError;
use crate::render::Prepared;
use crate::scene::FilmSize;

/// Tiles of one dispatch at most: 2¹⁸ pixels, 12 MiB of records.
const MAX_TILES: u32 = 1 << 12;

/// Writes out samples of a render, one per pixel at a time, with what their rays met.
#[derive(Debug)]
pub struct Recorder<'a> {
    program: SceneProgram<'a>,
    records: GpuBuffer<SampleRecord>,
    staging: GpuBuffer<SampleRecord>,
    own: OwnBindings,
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
        let program = SceneProgram::new(context, prepared, film, seed, &RECORD)?;
        let device = &context.device;
        let count = (MAX_TILES.min(tiles(film)) * TILE_PIXELS) as usize;
        let storage = wgpu::BufferUsages::STORAGE
            | wgpu::BufferUsages::COPY_SRC
            | wgpu::BufferUsages::COPY_DST;
        let read = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        context.checked(|| {
            let records = GpuBuffer::zeroed(device, "record.records", count, storage);
            let own = program.kernel().bind_own(device, vec![records.binding()]);
            Self {
                staging: GpuBuffer::zeroed(device, "record.staging", count, read),
                records,
                own,
                program,
                film,
            }
        })
    }

    /// Sample `index` of every pixel, row by row.
    ///
    /// # Errors
    /// The driver fails, or leaves a sample unfinished.
    pub fn samples(&self, index: u64) -> Result<Vec<SampleRecord>, GpuError> {
        let mut out = vec![SampleRecord::default(); self.film.pixels()];
        let mut unwritten = 0;
        let tiles = tiles(self.film);
        for first_tile in (0..tiles).step_by(MAX_TILES as usize) {
            let count = MAX_TILES.min(tiles - first_tile);
            let parameters = Dispatch {
                block_start: [index as u32, (index >> 32) as u32],
                first_tile,
                ..Dispatch::default()
            };
            let buffers = (&self.records, &self.staging);
            self.program
                .run(&parameters, count, &self.own, buffers, |records| {
                    unwritten += self.sort(first_tile, count, records, &mut out);
                })?;
        }
        if unwritten > 0 {
            return Err(self.program.context().driver_error(format!(
                "the driver left {unwritten} samples unfinished; `direkt doctor` tells its loop budget"
            )));
        }
        Ok(out)
    }

    /// Moves records from tiles to rows; how many of them were never written.
    fn sort(
        &self,
        first_tile: u32,
        tiles: u32,
        records: &[SampleRecord],
        out: &mut [SampleRecord],
    ) -> usize {
        let FilmSize { width, height } = self.film;
        let tiles_per_row = width.div_ceil(TILE);
        let mut unwritten = 0;
        for (i, record) in (0..tiles * TILE_PIXELS).zip(records) {
            let tile = first_tile + i / TILE_PIXELS;
            let (dx, dy) = lane_pixel(i % TILE_PIXELS);
            let x = tile % tiles_per_row * TILE + dx;
            let y = tile / tiles_per_row * TILE + dy;
            if x < width && y < height {
                unwritten += usize::from(record.bsdf_primitive == POISON);
                out[y as usize * width as usize + x as usize] = *record;
            }
        }
        unwritten
    }
}

fn tiles(film: FilmSize) -> u32 {
    film.width.div_ceil(TILE) * film.height.div_ceil(TILE)
}
