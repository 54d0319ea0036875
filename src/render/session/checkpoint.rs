//! Where a render stands: what another device needs to go on with it, bit for bit as if nothing had happened.

use super::{RayCounts, Session};
use crate::error::GpuError;
use crate::gpu::layout::{GroupMean, PixelState};
use crate::render::film::Film;
use std::time::{Duration, Instant};

/// How much work a lost device may cost.
const INTERVAL: Duration = Duration::from_secs(10);

/// Where a render stood.
#[derive(Debug, Clone)]
pub struct Checkpoint {
    /// Merged blocks.
    film: Film,
    /// Rays of merged blocks.
    rays: RayCounts,
    /// Samples per pixel in merged blocks.
    merged: u64,
    /// The open block.
    block: Saved,
}

impl Checkpoint {
    /// Samples per pixel.
    pub fn samples(&self) -> u64 {
        self.merged + u64::from(self.block.position)
    }
}

/// The open block as the host knows it.
#[derive(Debug, Clone)]
pub(super) struct Saved {
    /// Position in the block.
    pub position: u32,
    /// The pixels' states, region by region; none at the beginning of a block.
    pub states: Vec<Vec<PixelState>>,
    /// The means of their groups of lights.
    pub light_groups: Vec<Vec<GroupMean>>,
    at: Instant,
}

impl Saved {
    /// The block at `position`, as of now.
    pub fn at(
        position: u32,
        states: Vec<Vec<PixelState>>,
        light_groups: Vec<Vec<GroupMean>>,
    ) -> Self {
        Self {
            position,
            states,
            light_groups,
            at: Instant::now(),
        }
    }

    /// Whether it is time to save again.
    pub fn is_due(&self) -> bool {
        self.at.elapsed() >= INTERVAL
    }
}

impl Default for Saved {
    fn default() -> Self {
        Self::at(0, Vec::new(), Vec::new())
    }
}

impl Session<'_> {
    /// Keeps the open block's states on the host, so that losing the device loses no more than what comes after.
    ///
    /// # Errors
    /// The driver fails.
    pub fn save(&mut self) -> Result<(), GpuError> {
        let mut states = Vec::with_capacity(self.regions.len());
        let mut groups = Vec::with_capacity(self.regions.len());
        for region in &self.regions {
            self.read_states(region, |of_region| states.push(of_region.to_vec()))?;
            groups.push(self.read_groups(region)?);
        }
        self.saved = Saved::at(self.position, states, groups);
        Ok(())
    }

    /// Where the render stood when it was last saved, or when the last full block was merged.
    pub fn into_checkpoint(self) -> Checkpoint {
        Checkpoint {
            film: self.film,
            rays: self.rays,
            merged: self.merged,
            block: self.saved,
        }
    }

    /// Goes on from `checkpoint`, of a session with the same scene, settings, size and seed.
    ///
    /// # Errors
    /// The driver fails.
    pub fn resume(&mut self, checkpoint: Checkpoint) -> Result<(), GpuError> {
        let Checkpoint {
            film,
            rays,
            merged,
            block,
        } = checkpoint;
        assert_eq!(film.size, self.film.size, "a checkpoint of another image");
        self.context.checked(|| {
            for (region, states) in self.regions.iter().zip(&block.states) {
                let bytes = bytemuck::cast_slice(states);
                self.context
                    .queue
                    .write_buffer(region.pixels.raw(), 0, bytes);
            }
            for (region, groups) in self.regions.iter().zip(&block.light_groups) {
                if let Some([buffer, _]) = &region.light_groups {
                    let bytes = bytemuck::cast_slice(groups);
                    self.context.queue.write_buffer(buffer.raw(), 0, bytes);
                }
            }
        })?;
        (self.film, self.rays, self.merged) = (film, rays, merged);
        self.position = block.position;
        self.saved = block;
        Ok(())
    }
}
