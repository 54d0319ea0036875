//! A render in progress.
//!
//! The image is cut into regions whose pixel states fit one binding, regions into 8 × 8 tiles. A *pass* takes every
//! pixel a few samples further, in dispatches sized by feedback so that each stays short. Samples are accumulated in
//! blocks of 256 in f32 on the GPU; a full block is merged into the f64 film. Where a pass is cut does not
//! change the image: a pixel's state goes on exactly from where it stood.

pub(super) mod checkpoint;
mod readback;
mod region;

use super::film::Film;
use super::prepare::{Patterns, Prepared};
use crate::error::GpuError;
use crate::gpu::kernel::{DIRECT, SceneBindings, SceneKernel};
use crate::gpu::layout::{BLOCK_SAMPLES, Dispatch, Frame, TILE, TILE_PIXELS};
use crate::gpu::scene_buffers::{self, SceneBuffers};
use crate::gpu::shader::Config;
use crate::gpu::{Context, GpuBuffer};
use crate::scene::FilmSize;
use checkpoint::Saved;
use region::{Region, light_groups, most_tiles};
use std::time::{Duration, Instant};

/// Tiles of a region at most: 2²⁰ pixels, 48 MiB of states.
const REGION_TILES: u32 = 1 << 14;
/// Workgroups of one dispatch at most (WebGPU's default limit).
const MAX_WORKGROUPS: u32 = 65_535;
/// How long a dispatch should take on a GPU whose watchdog ends long ones.
const HARDWARE_DISPATCH: Duration = Duration::from_millis(80);
/// How long it should take in software, where only the progress display waits for it.
const SOFTWARE_DISPATCH: Duration = Duration::from_millis(250);
/// Pixel-samples of the first dispatch, before anything has been measured, where each takes one shadow ray.
const FIRST_BUDGET: u64 = 1 << 15;
/// Dispatches without a finished pixel after which a scene counts as too deep for the driver's loops.
const MAX_RETRIES: u32 = 4096;

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
    saved: Saved,
    /// Seconds that linking and compiling the kernel took, the driver's part included.
    pub compile_seconds: f64,
    /// Dispatches so far.
    pub dispatches: u64,
}

impl<'a> Session<'a> {
    /// Compiles the kernel and uploads the scene.
    ///
    /// # Errors
    /// The scene is too large for the adapter, the kernel does not compile, or the driver fails.
    pub fn new(
        context: &'a Context,
        prepared: &Prepared,
        film: FilmSize,
        seed: u32,
    ) -> Result<Self, GpuError> {
        Self::in_regions(context, prepared, film, seed, REGION_TILES)
    }

    /// The same, compiled anew even where the driver kept what it compiled before: `stamp` is one that no other had, and not 0.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn compiled_anew(
        context: &'a Context,
        prepared: &Prepared,
        film: FilmSize,
        seed: u32,
        stamp: u32,
    ) -> Result<Self, GpuError> {
        Self::build(context, prepared, film, seed, (REGION_TILES, stamp))
    }

    /// The same with `region_tiles` tiles at most in one region, which does not change the image.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn in_regions(
        context: &'a Context,
        prepared: &Prepared,
        film: FilmSize,
        seed: u32,
        region_tiles: u32,
    ) -> Result<Self, GpuError> {
        let stamp = Config::default().stamp;
        Self::build(context, prepared, film, seed, (region_tiles, stamp))
    }

    fn build(
        context: &'a Context,
        prepared: &Prepared,
        film: FilmSize,
        seed: u32,
        (region_tiles, stamp): (u32, u32),
    ) -> Result<Self, GpuError> {
        let buffers = SceneBuffers::new(context, prepared)?;
        let compile_start = Instant::now();
        let config = Config {
            stamp,
            ..Config::of(prepared)
        };
        let kernel = SceneKernel::new(context, &DIRECT, &prepared.effects, config)?;
        let device = &context.device;
        let uniform = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let frame: GpuBuffer<Frame> = GpuBuffer::zeroed(device, "direct.frame", 1, uniform);
        let frame_data = scene_buffers::frame(prepared, film, seed, &buffers);
        context
            .queue
            .write_buffer(frame.raw(), 0, bytemuck::bytes_of(&frame_data));
        let dispatch = GpuBuffer::zeroed(device, "direct.dispatch", 1, uniform);
        let unfinished = GpuBuffer::zeroed(
            device,
            "direct.unfinished",
            1,
            wgpu::BufferUsages::STORAGE
                | wgpu::BufferUsages::COPY_SRC
                | wgpu::BufferUsages::COPY_DST,
        );
        let read = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let groups = light_groups(prepared);
        let region_tiles = region_tiles.min(most_tiles(context, groups));
        let regions = context.checked(|| {
            let tiles = film.width.div_ceil(TILE) * film.height.div_ceil(TILE);
            let firsts = (0..tiles).step_by(region_tiles as usize);
            let shared = (&frame, &dispatch, &unfinished);
            let regions = firsts.map(|first_tile| {
                let tiles = region_tiles.min(tiles - first_tile);
                Region::new(device, &kernel, shared, (first_tile, tiles), groups)
            });
            regions.collect()
        })?;
        let mut session = Self {
            context,
            scene: kernel.bind_scene(device, &buffers),
            kernel,
            frame,
            frame_data,
            dispatch,
            unfinished,
            unfinished_staging: GpuBuffer::zeroed(device, "direct.unfinished.staging", 1, read),
            regions,
            film: Film::new(film, prepared.scene.render.sampler)
                .with_light_groups(prepared.emitters.groups.names.len()),
            rays: RayCounts::default(),
            merged: 0,
            position: 0,
            budget: first_budget(prepared),
            saved: Saved::default(),
            compile_seconds: 0.0,
            dispatches: 0,
        };
        session.warm_up()?;
        session.compile_seconds = compile_start.elapsed().as_secs_f64();
        Ok(session)
    }

    /// Dispatches a tile without samples: some drivers compile at the first dispatch, not before.
    fn warm_up(&self) -> Result<(), GpuError> {
        let nothing = Dispatch {
            fresh: 1,
            ..Dispatch::default()
        };
        self.submit(&self.regions[0], &nothing, 1)?;
        Ok(())
    }

    /// Begins again without compiling anew: with other random numbers, of a sampler with other `patterns`. What was
    /// rendered is forgotten, how long a dispatch takes is not.
    ///
    /// # Errors
    /// The driver fails.
    pub fn restart(&mut self, seed: u32, patterns: Patterns) -> Result<(), GpuError> {
        self.frame_data.seed = seed;
        self.frame_data.pattern = patterns.pixel;
        self.frame_data.light_pattern = patterns.light;
        let bytes = bytemuck::bytes_of(&self.frame_data);
        let queue = &self.context.queue;
        self.context
            .checked(|| queue.write_buffer(self.frame.raw(), 0, bytes))?;
        self.close_block()?;
        self.merged = 0;
        self.rays = RayCounts::default();
        self.film = Film::new(self.film.size, self.film.sampler)
            .with_light_groups(self.film.light_groups.len());
        Ok(())
    }

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
            ..Dispatch::default()
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
        let target = if self.context.adapter.software {
            SOFTWARE_DISPATCH
        } else {
            HARDWARE_DISPATCH
        };
        let fit = done as f64 * target.as_secs_f64() / elapsed.as_secs_f64().max(1e-6);
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

/// Pixel-samples of the first dispatch.
fn first_budget(prepared: &Prepared) -> u64 {
    let rays = prepared.most_light_samples().max(1.0);
    ((FIRST_BUDGET as f64 / rays) as u64).max(u64::from(TILE_PIXELS))
}
