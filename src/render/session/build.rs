//! Sessions: made, and begun again.

use super::checkpoint::Saved;
use super::progress::Progress;
use super::region::{Region, light_groups, most_tiles};
use super::{RayCounts, Session};
use crate::effects::Effect;
use crate::error::GpuError;
use crate::gpu::kernel::{DIRECT, SceneKernel};
use crate::gpu::layout::{RowTask, TILE, TILE_PIXELS};
use crate::gpu::shader::KernelConstants;
use crate::gpu::{Context, GpuBuffer, SceneBuffers, frame_of};
use crate::prepare::Prepared;
use crate::render::film::Film;
use crate::render::memory;
use crate::scene::{FilmSize, ShadowRays};
use std::time::{Duration, Instant};

/// Tiles of a region at most: 2²⁰ pixels, 48 MiB of states.
const REGION_TILES: u32 = 1 << 14;
/// How long a dispatch should take on a GPU whose watchdog ends long ones.
const HARDWARE_DISPATCH: Duration = Duration::from_millis(80);
/// How long it should take in software, where only the progress display waits for it.
const SOFTWARE_DISPATCH: Duration = Duration::from_millis(250);
/// Pixel-samples of the first dispatch, before anything has been measured, where each takes one
/// shadow ray.
const FIRST_BUDGET: u64 = 1 << 15;

/// What two sessions of one scene may differ in.
struct Build {
    region_tiles: u32,
    stamp: u32,
}

impl Default for Build {
    fn default() -> Self {
        Self {
            region_tiles: REGION_TILES,
            stamp: KernelConstants::default().stamp,
        }
    }
}

impl<'a> Session<'a> {
    /// Compiles the kernel, unless the device has it already, and uploads the scene.
    ///
    /// # Errors
    /// The scene is too large for the adapter, the kernel does not compile, or the driver fails.
    pub fn new(
        context: &'a Context,
        prepared: &Prepared,
        film: FilmSize,
        seed: u32,
    ) -> Result<Self, GpuError> {
        Self::build(context, prepared, film, seed, Build::default())
    }

    /// The same, compiled anew even where the driver kept what it compiled before: `stamp` is one
    /// that no other had, and not 0.
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
        let build = Build {
            stamp,
            ..Build::default()
        };
        Self::build(context, prepared, film, seed, build)
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
        let build = Build {
            region_tiles,
            ..Build::default()
        };
        Self::build(context, prepared, film, seed, build)
    }

    fn build(
        context: &'a Context,
        prepared: &Prepared,
        film: FilmSize,
        seed: u32,
        build: Build,
    ) -> Result<Self, GpuError> {
        memory::check(context, prepared, film)?;
        let buffers = SceneBuffers::new(context, prepared)?;
        let compile_start = Instant::now();
        let constants = KernelConstants {
            stamp: build.stamp,
            ..KernelConstants::of(prepared)
        };
        let kernel = if build.stamp == KernelConstants::default().stamp {
            context.kernel(&DIRECT, &prepared.effects, &constants)
        } else {
            SceneKernel::new(context, &DIRECT, &prepared.effects, &constants)
        }?;
        let device = &context.device;
        let uniform = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let unfinished = wgpu::BufferUsages::STORAGE
            | wgpu::BufferUsages::COPY_SRC
            | wgpu::BufferUsages::COPY_DST;
        let read = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let mut session = Self {
            context,
            scene: kernel.bind_scene(device, &buffers),
            kernel,
            frame: GpuBuffer::zeroed(device, "direct.frame", 1, uniform),
            frame_data: frame_of(prepared, film, seed),
            dispatch: GpuBuffer::zeroed(device, "direct.dispatch", 1, uniform),
            unfinished: GpuBuffer::zeroed(device, "direct.unfinished", 1, unfinished),
            unfinished_staging: GpuBuffer::zeroed(device, "direct.unfinished.staging", 1, read),
            regions: Vec::new(),
            film: new_film(prepared, film),
            pilot: None,
            rays: RayCounts::default(),
            adaptive: prepared.settings.estimator.adaptive,
            asked_rays: asked_rays(prepared),
            planned: prepared.settings.stop.spp,
            progress: Progress::default(),
            budget: first_budget(prepared),
            dispatch_time: dispatch_time(context),
            saved: Saved::none(Progress::default()),
            compile_seconds: 0.0,
            dispatches: 0,
        };
        session.write_frame()?;
        session.make_regions(prepared, build.region_tiles)?;
        session.warm_up()?;
        session.compile_seconds = compile_start.elapsed().as_secs_f64();
        Ok(session)
    }

    fn make_regions(&mut self, prepared: &Prepared, most: u32) -> Result<(), GpuError> {
        let groups = light_groups(prepared);
        let most = most.min(most_tiles(self.context, groups));
        let size = self.film.size;
        let tiles = size.width.div_ceil(TILE) * size.height.div_ceil(TILE);
        let firsts = (0..tiles).step_by(most as usize);
        let shared = (&self.frame, &self.dispatch, &self.unfinished);
        let device = &self.context.device;
        self.regions = self.context.checked(|| {
            let regions = firsts.map(|first_tile| {
                let place = (first_tile, most.min(tiles - first_tile));
                Region::new(device, &self.kernel, shared, place, groups)
            });
            regions.collect()
        })?;
        self.sort_pixels()
    }

    /// Dispatches a tile without samples: some drivers compile at the first dispatch, not before.
    fn warm_up(&self) -> Result<(), GpuError> {
        let region = &self.regions[0];
        let queue = &self.context.queue;
        self.context
            .checked(|| region.write_tasks(queue, &[RowTask::default()]))?;
        self.dispatch(region, 0, 1)?;
        Ok(())
    }

    pub(super) fn write_frame(&self) -> Result<(), GpuError> {
        let bytes = bytemuck::bytes_of(&self.frame_data);
        let queue = &self.context.queue;
        self.context
            .checked(|| queue.write_buffer(self.frame.raw(), 0, bytes))
    }

    /// Begins again without compiling anew: with other random numbers, whose patterns are made for
    /// `planned` samples per pixel. What was rendered is forgotten, how long a dispatch takes is
    /// not.
    ///
    /// # Errors
    /// The driver fails.
    pub fn restart(&mut self, seed: u32, planned: u64) -> Result<(), GpuError> {
        self.frame_data.seed = seed;
        self.planned = planned;
        self.set_shadow_rays(self.asked_rays.least())?;
        self.progress.shadow_rays = None;
        self.forget()
    }

    /// Begins again with another camera or another size of the image, without compiling anew.
    /// `prepared` is what the session was made of but for its camera, which calls for the same
    /// effects. There are as many shadow rays as before.
    ///
    /// # Errors
    /// The driver fails.
    pub fn reframe(&mut self, prepared: &Prepared, film: FilmSize) -> Result<(), GpuError> {
        let rays = self.shadow_rays();
        self.frame_data = frame_of(prepared, film, self.frame_data.seed);
        if film != self.film.size {
            self.film = new_film(prepared, film);
            self.progress = Progress::with_shadow_rays(self.progress.shadow_rays);
            self.make_regions(prepared, REGION_TILES)?;
        }
        self.set_shadow_rays(rays)?;
        self.forget()
    }

    fn forget(&mut self) -> Result<(), GpuError> {
        self.rays = RayCounts::default();
        self.film = self.film.emptied();
        self.pilot = None;
        let was_shared_out = self.progress.allocation.is_some();
        self.progress = Progress::with_shadow_rays(self.progress.shadow_rays);
        if was_shared_out {
            self.sort_pixels()?;
        }
        self.clear_all()
    }

    /// Whether samples are shared out by where the error is, as long as they have not been.
    pub fn set_adaptive(&mut self, adaptive: bool) {
        self.adaptive = adaptive;
    }

    /// Takes `rays` shadow rays per camera ray, with light selection `all` per light, whatever pixels
    /// would tell; of a scene in which a second differs from the first.
    pub fn fix_shadow_rays(&mut self, rays: u32) {
        self.asked_rays = ShadowRays::Number(rays);
    }

    /// Lets dispatches last about `time`: shorter ones cost some speed, but the caller is asked
    /// sooner whether to stop.
    pub fn set_dispatch_time(&mut self, time: Duration) {
        self.dispatch_time = time;
    }
}

/// Shadow rays that `prepared` asks for, as far as a second differs from the first.
fn asked_rays(prepared: &Prepared) -> ShadowRays {
    if prepared.effects.contains(Effect::ShadowRays) {
        prepared.settings.estimator.shadow_rays
    } else {
        ShadowRays::Number(1)
    }
}

fn new_film(prepared: &Prepared, size: FilmSize) -> Film {
    let groups = prepared.emitters.groups.names.len();
    Film::new(size, prepared.settings.estimator.sampler)
        .with_light_groups(groups)
        .in_units_of(prepared.emitters.unit)
}

/// How long a dispatch should take where nobody says otherwise.
fn dispatch_time(context: &Context) -> Duration {
    if context.adapter.software {
        SOFTWARE_DISPATCH
    } else {
        HARDWARE_DISPATCH
    }
}

/// Pixel-samples of the first dispatch.
fn first_budget(prepared: &Prepared) -> u64 {
    let rays = prepared.most_light_samples().max(1.0);
    ((FIRST_BUDGET as f64 / rays) as u64).max(u64::from(TILE_PIXELS))
}
