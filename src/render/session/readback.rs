//! From the GPU to the film.

use super::{RayCounts, Region, Session};
use crate::error::GpuError;
use crate::gpu::GpuBuffer;
use crate::gpu::layout::{GroupMean, PixelState, TILE, TILE_PIXELS, lane_pixel};
use crate::render::film::Film;
use bytemuck::Pod;

impl Session<'_> {
    /// The image so far, with the open block merged into it, and the rays traced for it.
    ///
    /// # Errors
    /// The driver fails.
    pub fn snapshot(&self) -> Result<(Film, RayCounts), GpuError> {
        let mut film = self.film.clone();
        let mut rays = self.rays;
        for region in &self.regions {
            let groups = self.read_groups(region)?;
            self.read_states(region, |states| {
                let region = (region.first_tile, self.merged);
                merge_region(&mut film, &mut rays, region, states, &groups);
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
        self.copy(&region.pixels, &region.staging)?;
        self.context.read(region.staging.raw(), |bytes| {
            read(bytemuck::cast_slice(bytes));
        })
    }

    /// The means of a region's groups of lights, pixel by pixel; none where they are not kept apart.
    pub(super) fn read_groups(&self, region: &Region) -> Result<Vec<GroupMean>, GpuError> {
        let Some([groups, staging]) = &region.light_groups else {
            return Ok(Vec::new());
        };
        self.copy(groups, staging)?;
        let to_vec = |bytes: &[u8]| bytemuck::cast_slice(bytes).to_vec();
        self.context.read(staging.raw(), to_vec)
    }

    fn copy<T: Pod>(&self, from: &GpuBuffer<T>, to: &GpuBuffer<T>) -> Result<(), GpuError> {
        self.context.checked(|| {
            let device = &self.context.device;
            let mut encoder = device.create_command_encoder(&Default::default());
            encoder.copy_buffer_to_buffer(from.raw(), 0, to.raw(), 0, from.bytes());
            self.context.queue.submit([encoder.finish()]);
        })
    }
}

/// Merges the states of a region's tiles, and the means of their groups of lights, into the film.
fn merge_region(
    film: &mut Film,
    rays: &mut RayCounts,
    (first_tile, block_start): (u32, u64),
    states: &[PixelState],
    groups: &[GroupMean],
) {
    let size = film.size;
    let tiles_per_row = size.width.div_ceil(TILE);
    let per_pixel = film.light_groups.len();
    for (slot, state) in states.iter().enumerate() {
        let i = slot as u32;
        let tile = first_tile + i / TILE_PIXELS;
        let (dx, dy) = lane_pixel(i % TILE_PIXELS);
        let x = tile % tiles_per_row * TILE + dx;
        let y = tile / tiles_per_row * TILE + dy;
        if x >= size.width || y >= size.height {
            continue;
        }
        let pixel = y as usize * size.width as usize + x as usize;
        let of_pixel = &groups[slot * per_pixel..][..per_pixel];
        film.merge(pixel, state, of_pixel);
        film.ledger.enter(state, x, y, block_start);
        rays.camera += u64::from(state.samples + state.dropped);
        rays.shadow += u64::from(state.shadow_rays);
        rays.bsdf += u64::from(state.bsdf_rays);
    }
}
