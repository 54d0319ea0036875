//! Where a render stands: what another device needs to go on with it, bit for bit as if nothing had
//! happened.

use super::progress::Progress;
use super::readback::{Block, slots};
use super::{RayCounts, Session};
use crate::error::GpuError;
use crate::render::film::Film;
use bytemuck::Zeroable;
use std::time::{Duration, Instant};

/// How much work a lost device may cost.
const INTERVAL: Duration = Duration::from_secs(10);

/// Where a render stood.
#[derive(Debug, Clone)]
pub struct Checkpoint {
    /// Merged blocks.
    film: Film,
    /// The image by which samples are shared out, as long as it is the best there is.
    pilot: Option<Film>,
    /// Rays of merged blocks.
    rays: RayCounts,
    /// Open blocks.
    saved: Saved,
}

impl Checkpoint {
    /// Samples per pixel, on average where they differ.
    pub fn samples(&self) -> u64 {
        self.saved.progress.samples()
    }
}

/// The open blocks as the host knows them.
#[derive(Debug, Clone)]
pub(super) struct Saved {
    pub progress: Progress,
    /// All rows of each region; none at the beginning of a block.
    pub blocks: Vec<Block>,
    at: Instant,
}

impl Saved {
    /// No open blocks, as of now.
    pub(crate) fn none(progress: Progress) -> Self {
        Self {
            progress,
            blocks: Vec::new(),
            at: Instant::now(),
        }
    }

    /// Whether it is time to save again.
    pub(crate) fn is_due(&self) -> bool {
        self.at.elapsed() >= INTERVAL
    }

    /// Forgets `block`, of the region `index`, which has been merged.
    pub(crate) fn forget(&mut self, index: usize, block: &Block) {
        if let Some(saved) = self.blocks.get_mut(index) {
            let states = slots(&block.rows(), 1);
            let per_pixel = block.light_groups.len() / block.states.len().max(1);
            let groups = slots(&block.rows(), per_pixel);
            saved.states[states].fill(Zeroable::zeroed());
            saved.light_groups[groups].fill(Zeroable::zeroed());
        }
    }
}

impl Session<'_> {
    /// Keeps the open blocks' states on the host, so that losing the device loses no more than what
    /// comes after.
    ///
    /// # Errors
    /// The driver fails.
    pub fn save(&mut self) -> Result<(), GpuError> {
        let mut saved = Saved::none(self.progress.clone());
        for region in &self.regions {
            saved
                .blocks
                .push(self.read_rows(region, region.all_rows())?);
        }
        self.saved = saved;
        Ok(())
    }

    /// Where the render stood when it was last saved, or when the last full block was merged.
    pub fn into_checkpoint(self) -> Checkpoint {
        Checkpoint {
            film: self.film,
            pilot: self.pilot,
            rays: self.rays,
            saved: self.saved,
        }
    }

    /// Goes on from `checkpoint`, of a session with the same scene, settings, size and seed.
    ///
    /// # Errors
    /// The driver fails.
    pub fn resume(&mut self, checkpoint: Checkpoint) -> Result<(), GpuError> {
        let Checkpoint {
            film,
            pilot,
            rays,
            saved,
        } = checkpoint;
        assert_eq!(film.size, self.film.size, "a checkpoint of another image");
        self.context.checked(|| {
            let queue = &self.context.queue;
            for (region, block) in self.regions.iter().zip(&saved.blocks) {
                let states = bytemuck::cast_slice(&block.states);
                queue.write_buffer(region.pixels.raw(), 0, states);
                if let Some([groups, _]) = &region.light_groups {
                    let means = bytemuck::cast_slice(&block.light_groups);
                    queue.write_buffer(groups.raw(), 0, means);
                }
            }
        })?;
        self.progress = saved.progress.clone();
        if let Some(rays) = self.progress.shadow_rays {
            self.set_shadow_rays(rays)?;
        }
        self.sort_pixels()?;
        (self.film, self.pilot) = (film, pilot);
        (self.rays, self.saved) = (rays, saved);
        Ok(())
    }
}
