//! From the GPU to the film.

use super::checkpoint::Saved;
use super::progress::Progress;
use super::{RayCounts, Region, Session};
use crate::error::GpuError;
use crate::gpu::GpuBuffer;
use crate::gpu::layout::{GroupMean, PixelState, TILE_PIXELS};
use crate::render::film::Film;
use bytemuck::Pod;
use std::ops::Range;

/// States of successive rows of pixels, and the means of their groups of lights.
#[derive(Debug, Clone)]
pub(super) struct Block {
    pub first_row: u32,
    pub states: Vec<PixelState>,
    pub light_groups: Vec<GroupMean>,
}

impl Session<'_> {
    /// The image so far, with the open blocks merged into it, and the rays traced for it.
    ///
    /// # Errors
    /// The driver fails.
    pub fn snapshot(&self) -> Result<(Film, RayCounts), GpuError> {
        let mut film = self.film.clone();
        let mut rays = self.rays;
        for region in &self.regions {
            let block = self.read_rows(region, region.all_rows())?;
            merge(&mut film, &mut rays, &self.progress, (region, &block));
        }
        Ok((self.best(film, &self.progress), rays))
    }

    /// The image as the host knows it without the device, and the rays traced for it: merged
    /// blocks, and open ones where they were last saved.
    pub fn safe_image(&self) -> (Film, RayCounts) {
        let (mut film, mut rays) = (self.film.clone(), self.rays);
        for (region, block) in self.regions.iter().zip(&self.saved.blocks) {
            merge(&mut film, &mut rays, &self.saved.progress, (region, block));
        }
        (self.best(film, &self.saved.progress), rays)
    }

    /// `film`, or the pilot's image where it is better than one that has come as far as `progress`;
    /// what was dropped is that of both.
    fn best(&self, film: Film, progress: &Progress) -> Film {
        match &self.pilot {
            Some(pilot) if progress.shows_pilot() => Film {
                ledger: film.ledger,
                ..pilot.clone()
            },
            _ => film,
        }
    }

    /// Merges the blocks of the classes whose blocks are full into the film, and opens their next
    /// ones.
    pub(super) fn merge_full(&mut self) -> Result<(), GpuError> {
        let classes = self.progress.classes.iter().enumerate();
        let full = classes.filter(|(_, class)| class.is_full());
        let full: Vec<_> = full.map(|(class, _)| class).collect();
        if full.is_empty() {
            return Ok(());
        }
        let mut blocks = Vec::new();
        for (index, region) in self.regions.iter().enumerate() {
            let rows = full.iter().map(|class| region.rows[*class].clone());
            for rows in joined(rows) {
                blocks.push((index, self.read_rows(region, rows)?));
            }
        }
        // What the host knows changes at once, so that a device that is lost takes nothing with it.
        for (region, block) in &blocks {
            let of_region = (&self.regions[*region], block);
            merge(&mut self.film, &mut self.rays, &self.progress, of_region);
        }
        for &class in &full {
            self.progress.classes[class].open_block();
            self.saved.progress.classes[class] = self.progress.classes[class];
        }
        for (region, block) in &blocks {
            self.saved.forget(*region, block);
        }
        let blocks = blocks.iter();
        self.clear(blocks.map(|(region, block)| (&self.regions[*region], block.rows())))
    }

    /// Forgets the open blocks.
    pub(super) fn clear_all(&mut self) -> Result<(), GpuError> {
        self.saved = Saved::none(self.progress.clone());
        let regions = self.regions.iter();
        self.clear(regions.map(|region| (region, region.all_rows())))
    }

    pub(super) fn clear<'r>(
        &self,
        blocks: impl Iterator<Item = (&'r Region, Range<u32>)>,
    ) -> Result<(), GpuError> {
        self.context.checked(|| {
            let device = &self.context.device;
            let mut encoder = device.create_command_encoder(&Default::default());
            for (region, rows) in blocks.filter(|(_, rows)| !rows.is_empty()) {
                region.pixels.clear(&mut encoder, slots(&rows, 1));
                if let Some([groups, _]) = &region.light_groups {
                    groups.clear(&mut encoder, slots(&rows, self.film.light_groups.len()));
                }
            }
            self.context.queue.submit([encoder.finish()]);
        })
    }

    /// The states of a region's `rows`.
    pub(super) fn read_rows(&self, region: &Region, rows: Range<u32>) -> Result<Block, GpuError> {
        let light_groups = match &region.light_groups {
            Some([groups, staging]) => {
                self.read(groups, staging, slots(&rows, self.film.light_groups.len()))?
            }
            None => Vec::new(),
        };
        Ok(Block {
            first_row: rows.start,
            states: self.read(&region.pixels, &region.staging, slots(&rows, 1))?,
            light_groups,
        })
    }

    fn read<T: Pod>(
        &self,
        buffer: &GpuBuffer<T>,
        staging: &GpuBuffer<T>,
        range: Range<usize>,
    ) -> Result<Vec<T>, GpuError> {
        if range.is_empty() {
            return Ok(Vec::new());
        }
        let size = size_of::<T>() as u64;
        let (start, bytes) = (range.start as u64 * size, range.len() as u64 * size);
        self.context.checked(|| {
            let device = &self.context.device;
            let mut encoder = device.create_command_encoder(&Default::default());
            encoder.copy_buffer_to_buffer(buffer.raw(), start, staging.raw(), 0, bytes);
            self.context.queue.submit([encoder.finish()]);
        })?;
        let to_vec = |bytes: &[u8]| bytemuck::cast_slice(bytes).to_vec();
        self.context.read_first(staging.raw(), bytes, to_vec)
    }
}

impl Block {
    pub(crate) fn rows(&self) -> Range<u32> {
        self.first_row..self.first_row + self.states.len() as u32 / TILE_PIXELS
    }
}

/// Elements of `rows` in a buffer with `per_pixel` of them for each pixel.
pub(super) fn slots(rows: &Range<u32>, per_pixel: usize) -> Range<usize> {
    let of_row = TILE_PIXELS as usize * per_pixel;
    rows.start as usize * of_row..rows.end as usize * of_row
}

/// `ranges` that follow each other, without empty ones; those without a gap between them are one.
fn joined(ranges: impl Iterator<Item = Range<u32>>) -> Vec<Range<u32>> {
    let mut joined: Vec<Range<u32>> = Vec::new();
    for range in ranges.filter(|range| !range.is_empty()) {
        match joined.last_mut() {
            Some(last) if last.end == range.start => last.end = range.end,
            _ => joined.push(range),
        }
    }
    joined
}

/// Merges a block of a region into `film`.
fn merge(
    film: &mut Film,
    rays: &mut RayCounts,
    progress: &Progress,
    (region, block): (&Region, &Block),
) {
    let per_pixel = film.light_groups.len();
    let first = slots(&block.rows(), 1).start;
    for (i, state) in block.states.iter().enumerate() {
        let Some((x, y)) = region.pixel(first + i) else {
            continue;
        };
        let pixel = film.size.index((x, y));
        film.merge(
            pixel,
            state,
            &block.light_groups[i * per_pixel..][..per_pixel],
        );
        let class = progress.classes[progress.class_of(pixel)];
        let block_start = progress.first_sample() + class.merged;
        film.ledger.enter(state, x, y, block_start);
        rays.camera += u64::from(state.samples + state.dropped);
        rays.shadow += u64::from(state.shadow_rays);
        rays.bsdf += u64::from(state.bsdf_rays);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_without_a_gap_are_one() {
        let ranges = [0..0, 0..2, 2..2, 2..5, 5..5, 7..8, 9..9];
        assert_eq!(joined(ranges.into_iter()), [0..5, 7..8]);
        assert!(joined(std::iter::empty()).is_empty());
    }
}
