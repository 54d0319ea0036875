//! Kernels that write one record per pixel.

use super::buffer::GpuBuffer;
use super::context::Context;
use super::kernel::{ExtraBindings, KernelDescriptor};
use super::layout::{Dispatch, TILE, TILE_PIXELS, lane_pixel};
use super::program::SceneProgram;
use crate::error::GpuError;
use crate::prepare::Prepared;
use crate::scene::FilmSize;
use bytemuck::Pod;

/// Tiles of one dispatch at most: 2¹⁸ pixels.
const MAX_TILES: u32 = 1 << 12;

/// A kernel that writes a `T` for every pixel, 64 per tile, with the scene bound to it.
#[derive(Debug)]
pub struct TileProgram<'a, T> {
    program: SceneProgram<'a>,
    output: GpuBuffer<T>,
    staging: GpuBuffer<T>,
    extra: ExtraBindings,
    film: FilmSize,
}

impl<'a, T: Pod> TileProgram<'a, T> {
    /// Compiles `descriptor` and uploads the scene.
    ///
    /// # Errors
    /// The kernel does not compile, or the scene is too large for the adapter.
    pub fn new(
        context: &'a Context,
        prepared: &Prepared,
        film: FilmSize,
        seed: u32,
        descriptor: &KernelDescriptor<'_>,
    ) -> Result<Self, GpuError> {
        let program = SceneProgram::new(context, prepared, film, seed, descriptor)?;
        let device = &context.device;
        let count = (MAX_TILES.min(tiles(film)) * TILE_PIXELS) as usize;
        let storage = wgpu::BufferUsages::STORAGE
            | wgpu::BufferUsages::COPY_SRC
            | wgpu::BufferUsages::COPY_DST;
        let read = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        context.checked(|| {
            let output = GpuBuffer::zeroed(device, "tiles.output", count, storage);
            let extra = program.kernel().bind_extra(device, vec![output.binding()]);
            Self {
                staging: GpuBuffer::zeroed(device, "tiles.staging", count, read),
                output,
                extra,
                program,
                film,
            }
        })
    }

    /// Runs the kernel with `parameters` on all tiles, and hands the place in the image, row by
    /// row, and the record of every pixel to `read`; a record that was not written is all
    /// [`POISON`](super::program::POISON).
    ///
    /// # Errors
    /// The driver fails.
    pub fn run(
        &self,
        parameters: &Dispatch,
        mut read: impl FnMut(usize, &T),
    ) -> Result<(), GpuError> {
        let FilmSize { width, height } = self.film;
        let tiles_per_row = width.div_ceil(TILE);
        let tiles = tiles(self.film);
        for first_tile in (0..tiles).step_by(MAX_TILES as usize) {
            let count = MAX_TILES.min(tiles - first_tile);
            let parameters = Dispatch {
                first_tile,
                ..*parameters
            };
            let buffers = (&self.output, &self.staging);
            self.program
                .run(&parameters, count, &self.extra, buffers, |records| {
                    for (i, record) in (0..count * TILE_PIXELS).zip(records) {
                        let tile = first_tile + i / TILE_PIXELS;
                        let (dx, dy) = lane_pixel(i % TILE_PIXELS);
                        let x = tile % tiles_per_row * TILE + dx;
                        let y = tile / tiles_per_row * TILE + dy;
                        if x < width && y < height {
                            read(y as usize * width as usize + x as usize, record);
                        }
                    }
                })?;
        }
        Ok(())
    }

    /// The error for `count` samples that were not written.
    pub fn unfinished(&self, count: usize) -> GpuError {
        self.program.context().driver_error(format!(
            "the driver left {count} samples unfinished; `direkt doctor` tells its loop budget"
        ))
    }
}

fn tiles(film: FilmSize) -> u32 {
    film.width.div_ceil(TILE) * film.height.div_ceil(TILE)
}
