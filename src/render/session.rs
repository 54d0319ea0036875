//! A render in progress.
//!
//! The image is cut into regions whose pixel states fit one binding, regions into 8 × 8 tiles. A *pass*
//! takes every pixel a few samples further, in dispatches sized by feedback so that each stays
//! short. Samples are accumulated in blocks of 256 in f32 on the GPU; a full block is merged into
//! the f64 film. Where a pass is cut does not change the image: a pixel's state goes on exactly
//! from where it stood. With adaptive sampling pixels fall into classes, each with a number of
//! samples and a block of its own, once a pilot has told which.

mod build;
pub(super) mod checkpoint;
mod progress;
mod readback;
mod region;
mod shadow_rays;
mod tasks;

use super::adaptive::{Allocation, PILOT};
use super::film::Film;
use crate::error::GpuError;
use crate::gpu::kernel::{SceneBindings, SceneKernel};
use crate::gpu::layout::{BLOCK_SAMPLES, Dispatch, Frame, RowTask, TILE_PIXELS};
use crate::gpu::{Context, GpuBuffer};
use crate::scene::ShadowRays;
use checkpoint::Saved;
use progress::Progress;
use region::Region;
use std::time::{Duration, Instant};
use tasks::pixel_samples;

/// Dispatches without a finished pixel after which a scene counts as too deep for the driver's
/// loops.
const MAX_RETRIES: u64 = 4096;

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
    /// The image by which samples are shared out, as long as it is the best there is.
    pilot: Option<Film>,
    rays: RayCounts,
    /// Whether samples are shared out by where the error is.
    adaptive: bool,
    /// How many shadow rays the settings ask for, as far as a second differs from the first.
    asked_rays: ShadowRays,
    /// Samples per pixel that the sampler's patterns are made for.
    planned: u64,
    progress: Progress,
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

    /// Samples that every pixel of the image has; with adaptive sampling, what they have on average,
    /// rounded down.
    pub fn samples(&self) -> u64 {
        self.progress.samples()
    }

    /// Samples per pixel that the next pass should take so that it lasts about one dispatch, at
    /// least 1.
    pub fn pass_samples(&self, remaining: u64) -> u64 {
        let pixels = self.film.size.pixels() as u64;
        (self.budget / pixels).clamp(1, remaining.clamp(1, u64::from(BLOCK_SAMPLES)))
    }

    /// Index of the first sample after the pilot, once samples are shared out; else 0.
    pub fn first_sample(&self) -> u64 {
        self.progress.first_sample()
    }

    /// Takes every pixel `samples` further, at most to the end of the open block; with adaptive
    /// sampling, about so many on average. `stop` is asked between dispatches.
    ///
    /// # Errors
    /// The driver fails, or ends the scene's traversal loops so early that no sample can be
    /// finished.
    pub fn pass(
        &mut self,
        samples: u64,
        mut stop: impl FnMut() -> bool,
    ) -> Result<StopReason, GpuError> {
        self.choose_shadow_rays()?;
        let samples = self.share_out(samples)?;
        let targets = self.progress.targets(samples);
        loop {
            self.merge_full()?;
            let classes = self.progress.classes.iter().zip(&targets);
            let positions = classes.map(|(class, target)| class.position_towards(*target));
            let positions: Vec<_> = positions.collect();
            if self.progress.positions().eq(positions.iter().copied()) {
                break;
            }
            for region in 0..self.regions.len() {
                if self.bring(region, &positions, &mut stop)? == StopReason::Interrupted {
                    return Ok(StopReason::Interrupted);
                }
            }
            self.progress.reach(&positions);
        }
        if self.saved.is_due() {
            self.save()?;
        }
        Ok(StopReason::Done)
    }

    /// Takes the pixels of a region to their classes' `positions` in the open blocks.
    fn bring(
        &mut self,
        region: usize,
        positions: &[u32],
        stop: &mut impl FnMut() -> bool,
    ) -> Result<StopReason, GpuError> {
        let classes = (self.progress.classes.as_slice(), positions);
        let software = self.context.adapter.software;
        let first_sample = self.progress.first_sample();
        let region = &self.regions[region];
        let tasks = tasks::tasks(&region.rows, classes, first_sample, software);
        let rows: Vec<RowTask> = tasks.iter().map(|task| task.task).collect();
        let queue = &self.context.queue;
        self.context.checked(|| region.write_tasks(queue, &rows))?;
        let mut first = 0;
        while first < tasks.len() {
            if stop() {
                return Ok(StopReason::Interrupted);
            }
            let count = tasks::of_one_dispatch(&tasks[first..], self.budget);
            let done = pixel_samples(&tasks[first..][..count]);
            let start = Instant::now();
            self.dispatches += self.dispatch(region, first, count)?;
            self.budget = self.next_budget(done, start.elapsed());
            first += count;
        }
        Ok(StopReason::Done)
    }

    /// Dispatches `count` of a region's tasks from the `first` on until they are done. Returns how
    /// many dispatches that took.
    fn dispatch(&self, region: &Region, first: usize, count: usize) -> Result<u64, GpuError> {
        let parameters = Dispatch {
            first_task: region.first_word(first),
            ..Dispatch::default()
        };
        for dispatches in 1..=MAX_RETRIES {
            if self.submit(region, &parameters, count as u32)? {
                return Ok(dispatches);
            }
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
            let extra = Some(&region.extra);
            self.kernel
                .encode(&mut encoder, &region.bindings, &self.scene, extra, count);
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

    /// Pixel-samples that fit the time a dispatch should take, judging by one of `done` that took
    /// `elapsed`. A dispatch far below the budget is no evidence that the budget is too large.
    fn next_budget(&self, done: u64, elapsed: Duration) -> u64 {
        let fit = done as f64 * self.dispatch_time.as_secs_f64() / elapsed.as_secs_f64().max(1e-6);
        let largest = self.budget.max(done).saturating_mul(4);
        let next = (fit as u64).clamp(u64::from(TILE_PIXELS), largest);
        if 2 * done < self.budget && elapsed < self.dispatch_time {
            next.max(self.budget)
        } else {
            next
        }
    }

    /// The device.
    pub fn context(&self) -> &'a Context {
        self.context
    }

    /// Where sampling is adaptive and the pilot is over, shares the samples out. Returns how many
    /// of the next `samples` per pixel may be taken until that is to be done, all of them if it
    /// never is again.
    fn share_out(&mut self, samples: u64) -> Result<u64, GpuError> {
        // A lost device goes back to what was saved.
        if !self.saved.progress.shows_pilot() {
            self.pilot = None;
        }
        if !self.adaptive || self.progress.allocation.is_some() {
            return Ok(samples);
        }
        let taken = self.samples();
        if taken >= PILOT && taken.is_power_of_two() {
            let (pilot, rays) = self.snapshot()?;
            if let Some(allocation) = Allocation::after(&pilot, taken) {
                // What was dropped stays in the ledger.
                let ledger = pilot.ledger;
                self.film = Film {
                    ledger,
                    ..self.film.emptied()
                };
                (self.pilot, self.rays) = (Some(pilot), rays);
                self.progress.share_out(allocation);
                self.saved = Saved::none(self.progress.clone());
                // After they have got their order, which may take more rows than before.
                self.sort_pixels()?;
                self.clear_all()?;
                return Ok(samples);
            }
        }
        let end = (taken + 1).next_power_of_two().max(PILOT);
        Ok(samples.min(end - taken))
    }

    /// Gives the pixels their order.
    fn sort_pixels(&mut self) -> Result<(), GpuError> {
        let (context, size, progress) = (self.context, self.film.size, &self.progress);
        let regions = &mut self.regions;
        context.checked(|| {
            for region in regions {
                let class_of = |pixel| progress.class_of(size.index(pixel));
                region.sort(context, size, progress.classes.len(), class_of);
            }
        })
    }
}
