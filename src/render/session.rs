//! A render in progress.
//!
//! The image is cut into regions whose pixel states fit one binding, regions into 8 × 8 tiles. A *pass* takes every
//! pixel a few samples further, in dispatches sized by feedback so that each stays short. Samples are accumulated in
//! blocks of 256 in f32 on the GPU; a full block is merged into the f64 film. Where a pass is cut does not
//! change the image: a pixel's state goes on exactly from where it stood.

mod build;
pub(super) mod checkpoint;
mod readback;
mod region;

use super::film::Film;
use crate::error::GpuError;
use crate::gpu::kernel::{SceneBindings, SceneKernel};
use crate::gpu::layout::{BLOCK_SAMPLES, Dispatch, Frame, TILE_PIXELS};
use crate::gpu::{Context, GpuBuffer};
use checkpoint::Saved;
use region::Region;
use std::time::{Duration, Instant};

/// Workgroups of one dispatch at most (WebGPU's default limit).
const MAX_WORKGROUPS: u32 = 65_535;
/// Dispatches without a finished pixel after which a scene counts as too deep for the driver's loops.
const MAX_RETRIES: u32 = 4096;

/// Distances between the tiles of successive workgroups on a driver in software, of which the first that is coprime to the
/// number of tiles is taken. Such a driver hands each of its threads a row of workgroups: with neighbouring tiles some threads would
/// have the dear part of the image, and the others would wait for them.
const SOFTWARE_STRIDES: [u32; 3] = [17, 19, 23];

/// Rays traced.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
pub struct RayCounts {
    /// From the camera.
    pub camera: u64,
    /// Towards lights.
    pub shadow: u64,
    /// In BSDF-sampled directions.
    pub bsdf: u64,
}

impl RayCounts {
    /// All of them.
    pub fn total(self) -> u64 {
        self.camera + self.shadow + self.bsdf
    }
}

/// Why a pass ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StopReason {
    /// Every pixel has the samples that were asked for.
    Done,
    /// The caller asked to stop; pixels may differ in their number of samples.
    Interrupted,
}

/// A render in progress.
#[derive(Debug)]
pub struct Session<'a> {
    context: &'a Context,
    kernel: SceneKernel,
    scene: SceneBindings,
    frame: GpuBuffer<Frame>,
    frame_data: Frame,
    dispatch: GpuBuffer<Dispatch>,
    unfinished: GpuBuffer<u32>,
    unfinished_staging: GpuBuffer<u32>,
    regions: Vec<Region>,
    film: Film,
    rays: RayCounts,
    /// Samples per pixel in merged blocks.
    merged: u64,
    /// Position in the open block that every pixel has reached.
    position: u32,
    budget: u64,
    /// How long a dispatch should take.
    dispatch_time: Duration,
    saved: Saved,
    /// Seconds that linking and compiling the kernel took, the driver's part included.
    pub compile_seconds: f64,
    /// Dispatches so far.
    pub dispatches: u64,
}

impl<'a> Session<'a> {
    /// The WGSL that renders.
    pub fn wgsl(&self) -> &str {
        self.kernel.wgsl()
    }

    /// Samples that every pixel has.
    pub fn samples(&self) -> u64 {
        self.merged + u64::from(self.position)
    }

    /// Samples per pixel that the next pass should take so that it lasts about one dispatch, at least 1.
    pub fn pass_samples(&self, remaining: u64) -> u64 {
        let pixels = self.film.size.pixels() as u64;
        let in_block = u64::from(BLOCK_SAMPLES - self.position);
        (self.budget / pixels).clamp(1, remaining.min(in_block).max(1))
    }

    /// Takes every pixel `samples` further, at most to the end of the open block. `stop` is asked between dispatches.
    ///
    /// # Errors
    /// The driver fails, or ends the scene's traversal loops so early that no sample can be finished.
    pub fn pass(
        &mut self,
        samples: u64,
        mut stop: impl FnMut() -> bool,
    ) -> Result<StopReason, GpuError> {
        let target = (u64::from(self.position) + samples).min(u64::from(BLOCK_SAMPLES)) as u32;
        for region in 0..self.regions.len() {
            let tiles = self.regions[region].tiles;
            let mut tile = 0;
            while tile < tiles {
                if stop() {
                    return Ok(StopReason::Interrupted);
                }
                let step = u64::from(target - self.position);
                let fit = self.budget / (u64::from(TILE_PIXELS) * step);
                let count = (fit.max(1).min(u64::from(MAX_WORKGROUPS)) as u32).min(tiles - tile);
                self.dispatch_tiles(region, tile, count, target)?;
                tile += count;
            }
        }
        self.position = target;
        if self.position == BLOCK_SAMPLES {
            (self.film, self.rays) = self.snapshot()?;
            self.close_block()?;
        } else if self.saved.is_due() {
            self.save()?;
        }
        Ok(StopReason::Done)
    }

    /// Brings `count` tiles of a region to `target`.
    fn dispatch_tiles(
        &mut self,
        region: usize,
        tile: u32,
        count: u32,
        target: u32,
    ) -> Result<(), GpuError> {
        let block_start = self.merged;
        let region = &self.regions[region];
        let mut parameters = Dispatch {
            block_start: [block_start as u32, (block_start >> 32) as u32],
            first_tile: region.first_tile + tile,
            region_tile: region.first_tile,
            target_position: target,
            fresh: u32::from(self.position == 0),
            tiles: count,
            stride: stride(self.context, count),
        };
        let start = Instant::now();
        for _ in 0..MAX_RETRIES {
            self.dispatches += 1;
            if self.submit(region, &parameters, count)? {
                let step = u64::from(target - self.position) * u64::from(count * TILE_PIXELS);
                self.budget = self.next_budget(step, start.elapsed());
                return Ok(());
            }
            parameters.fresh = 0;
        }
        Err(self.context.driver_error(
            "the driver ends loops so early that a sample cannot be finished; `direkt doctor` tells its loop budget",
        ))
    }

    /// Runs one dispatch and waits for it; whether every pixel reached its target.
    fn submit(&self, region: &Region, parameters: &Dispatch, count: u32) -> Result<bool, GpuError> {
        let context = self.context;
        context.checked(|| {
            let queue = &context.queue;
            queue.write_buffer(self.dispatch.raw(), 0, bytemuck::bytes_of(parameters));
            let mut encoder = context.device.create_command_encoder(&Default::default());
            encoder.clear_buffer(self.unfinished.raw(), 0, None);
            self.kernel
                .encode(&mut encoder, &region.bindings, &self.scene, None, count);
            encoder.copy_buffer_to_buffer(
                self.unfinished.raw(),
                0,
                self.unfinished_staging.raw(),
                0,
                4,
            );
            queue.submit([encoder.finish()]);
        })?;
        let unfinished = context.read(self.unfinished_staging.raw(), |bytes| {
            bytes.iter().any(|&b| b != 0)
        })?;
        Ok(!unfinished)
    }

    /// Pixel-samples that fit the time a dispatch should take, judging by one of `done` that took `elapsed`.
    fn next_budget(&self, done: u64, elapsed: Duration) -> u64 {
        let fit = done as f64 * self.dispatch_time.as_secs_f64() / elapsed.as_secs_f64().max(1e-6);
        let largest = self.budget.max(done).saturating_mul(4);
        (fit as u64).clamp(u64::from(TILE_PIXELS), largest)
    }

    /// The device.
    pub fn context(&self) -> &'a Context {
        self.context
    }

    /// Starts the next block: what was merged must not be merged again.
    fn close_block(&mut self) -> Result<(), GpuError> {
        self.merged += u64::from(self.position);
        self.position = 0;
        self.saved = Saved::default();
        self.context.checked(|| {
            let mut encoder = self
                .context
                .device
                .create_command_encoder(&Default::default());
            for region in &self.regions {
                encoder.clear_buffer(region.pixels.raw(), 0, None);
                if let Some([groups, _]) = &region.light_groups {
                    encoder.clear_buffer(groups.raw(), 0, None);
                }
            }
            self.context.queue.submit([encoder.finish()]);
        })
    }
}

/// How many tiles lie between those of successive workgroups of a dispatch of `tiles`.
fn stride(context: &Context, tiles: u32) -> u32 {
    let strides = SOFTWARE_STRIDES.into_iter();
    let coprime =
        strides.filter(|stride| context.adapter.software && !tiles.is_multiple_of(*stride));
    coprime.min().unwrap_or(1)
}
