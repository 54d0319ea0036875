//! From the GPU to the film.

use super::{RayCounts, Region, Session};
use crate::error::GpuError;
use crate::gpu::layout::{PixelState, TILE, TILE_PIXELS, lane_pixel};
use crate::render::film::Film;

impl Session<'_> {
    /// The image so far, with the open block merged into it, and the rays traced for it.
    ///
    /// # Errors
    /// The driver fails.
    pub fn snapshot(&self) -> Result<(Film, RayCounts), GpuError> {
        let mut film = self.film.clone();
        let mut rays = self.rays;
        for region in &self.regions {
            self.read_states(region, |states| {
                merge_region(&mut film, &mut rays, region.first_tile, states, self.merged);
            })?;
        }
        Ok((film, rays))
    }

    /// Hands the states of a region's pixels to `read`.
    pub(super) fn read_states(
        &self,
        region: &Region,
        mut read: impl FnMut(&[PixelState]),
    ) -> Result<(), GpuError> {
        self.context.checked(|| {
            let device = &self.context.device;
            let mut encoder = device.create_command_encoder(&Default::default());
            let (from, to) = (region.pixels.raw(), region.staging.raw());
            encoder.copy_buffer_to_buffer(from, 0, to, 0, region.pixels.bytes());
            self.context.queue.submit([encoder.finish()]);
        })?;
        self.context.read(region.staging.raw(), |bytes| {
            read(bytemuck::cast_slice(bytes));
        })
    }
}

/// Merges the states of a region's tiles into the film.
fn merge_region(
    film: &mut Film,
    rays: &mut RayCounts,
    first_tile: u32,
    states: &[PixelState],
    block_start: u64,
) {
    let size = film.size;
    let tiles_per_row = size.width.div_ceil(TILE);
    for (i, state) in states.iter().enumerate() {
        let i = i as u32;
        let tile = first_tile + i / TILE_PIXELS;
        let (dx, dy) = lane_pixel(i % TILE_PIXELS);
        let x = tile % tiles_per_row * TILE + dx;
        let y = tile / tiles_per_row * TILE + dy;
        if x >= size.width || y >= size.height {
            continue;
        }
        film.pixels[y as usize * size.width as usize + x as usize].merge(state);
        film.ledger.enter(state, x, y, block_start);
        rays.camera += u64::from(state.samples + state.dropped);
        rays.shadow += u64::from(state.shadow_rays);
        rays.bsdf += u64::from(state.bsdf_rays);
    }
}
