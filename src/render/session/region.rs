//! A part of the image whose pixels share buffers.

use crate::effects::Effect;
use crate::gpu::kernel::{ExtraBindings, PassBuffers, RegionBindings, SceneKernel};
use crate::gpu::layout::{
    Dispatch, Frame, GroupMean, PixelState, RowTask, TILE, TILE_PIXELS, lane_pixel,
};
use crate::gpu::{Context, GpuBuffer};
use crate::prepare::Prepared;
use crate::render::adaptive::CLASSES;
use crate::scene::FilmSize;
use std::ops::Range;

/// Pixels of a row: those of one workgroup.
const ROW: usize = TILE_PIXELS as usize;
/// Words of a task.
const TASK: usize = size_of::<RowTask>() / size_of::<u32>();
/// Beyond the last pixel of a row, `NONE` in the kernel.
const NONE: u32 = u32::MAX;

/// Pixels whose states share one buffer.
#[derive(Debug)]
pub(super) struct Region {
    first_tile: u32,
    tiles: u32,
    pub(super) pixels: GpuBuffer<PixelState>,
    pub(super) staging: GpuBuffer<PixelState>,
    /// The means of their groups of lights, and where these are read from.
    pub(super) light_groups: Option<[GpuBuffer<GroupMean>; 2]>,
    pub(super) bindings: RegionBindings,
    pub(super) extra: ExtraBindings,
    /// The pixels as x + 2¹⁶·y in the order of their states, class by class, in rows of 64.
    order: Vec<u32>,
    /// The same on the device, and behind it the tasks of the next dispatches.
    schedule: GpuBuffer<u32>,
    /// Rows of each class.
    pub(super) rows: Vec<Range<u32>>,
}

impl Region {
    /// `tiles` tiles from `first_tile` on, with `groups` groups of lights; its pixels have no order
    /// yet.
    pub(super) fn new(
        device: &wgpu::Device,
        kernel: &SceneKernel,
        (frame, dispatch, unfinished): (&GpuBuffer<Frame>, &GpuBuffer<Dispatch>, &GpuBuffer<u32>),
        (first_tile, tiles): (u32, u32),
        groups: u32,
    ) -> Self {
        // Each class may fill up its last row.
        let count = tiles as usize * ROW + CLASSES * ROW;
        let read = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let usage = wgpu::BufferUsages::STORAGE
            | wgpu::BufferUsages::COPY_SRC
            | wgpu::BufferUsages::COPY_DST;
        let pixels = GpuBuffer::zeroed(device, "direct.pixels", count, usage);
        let light_groups = (groups > 0).then(|| {
            let means = count * groups as usize;
            [
                GpuBuffer::zeroed(device, "direct.light_groups", means, usage),
                GpuBuffer::zeroed(device, "direct.light_groups.staging", means, read),
            ]
        });
        let pass = PassBuffers {
            frame,
            dispatch,
            pixels: &pixels,
            unfinished,
            light_groups: light_groups.as_ref().map(|[groups, _]| groups),
        };
        let words = count + count / ROW * TASK;
        let schedule = GpuBuffer::zeroed(device, "direct.schedule", words, usage);
        Self {
            first_tile,
            tiles,
            bindings: kernel.bind_region(device, &pass),
            extra: kernel.bind_extra(device, vec![schedule.binding()]),
            order: Vec::new(),
            schedule,
            rows: Vec::new(),
            light_groups,
            pixels,
            staging: GpuBuffer::zeroed(device, "direct.pixels.staging", count, read),
        }
    }

    /// All rows.
    pub(super) fn all_rows(&self) -> Range<u32> {
        0..(self.order.len() / ROW) as u32
    }

    /// Column and row of the pixel whose state is number `slot`; `None` where a row is filled up.
    pub(super) fn pixel(&self, slot: usize) -> Option<(u32, u32)> {
        let packed = self.order[slot];
        (packed != NONE).then_some((packed & 0xffff, packed >> 16))
    }

    /// Hands `tasks` to the next dispatches.
    pub(super) fn write_tasks(&self, queue: &wgpu::Queue, tasks: &[RowTask]) {
        let behind_pixels = size_of_val(self.order.as_slice()) as u64;
        let bytes = bytemuck::cast_slice(tasks);
        queue.write_buffer(self.schedule.raw(), behind_pixels, bytes);
    }

    /// Where task number `task` begins in the schedule.
    pub(super) fn first_word(&self, task: usize) -> u32 {
        (self.order.len() + task * TASK) as u32
    }

    /// Sorts the pixels of an image of `size` into `classes` classes. Their states are not moved.
    pub(super) fn sort(
        &mut self,
        context: &Context,
        size: FilmSize,
        classes: usize,
        class_of: impl Fn((u32, u32)) -> usize,
    ) {
        let mut sorted = vec![Vec::new(); classes];
        let tiles_per_row = size.width.div_ceil(TILE);
        for tile in self.first_tile..self.first_tile + self.tiles {
            let corner = (tile % tiles_per_row * TILE, tile / tiles_per_row * TILE);
            for (dx, dy) in (0..TILE_PIXELS).map(lane_pixel) {
                let (x, y) = (corner.0 + dx, corner.1 + dy);
                if x < size.width && y < size.height {
                    sorted[class_of((x, y))].push(x | (y << 16));
                }
            }
        }
        self.order.clear();
        self.rows.clear();
        for mut pixels in sorted {
            pixels.resize(pixels.len().next_multiple_of(ROW), NONE);
            let first = self.order.len() / ROW;
            let rows = pixels.len() / ROW;
            self.order.append(&mut pixels);
            self.rows.push(first as u32..(first + rows) as u32);
        }
        let bytes = bytemuck::cast_slice(&self.order);
        context.queue.write_buffer(self.schedule.raw(), 0, bytes);
    }
}

/// Groups of lights that the kernel keeps apart.
pub(super) fn light_groups(prepared: &Prepared) -> u32 {
    if prepared.effects.contains(Effect::LightGroups) {
        prepared.emitters.groups.count()
    } else {
        0
    }
}

/// Tiles of a region at most, so that the means of `groups` groups of lights fit one binding.
pub(super) fn most_tiles(context: &Context, groups: u32) -> u32 {
    if groups == 0 {
        return u32::MAX;
    }
    let limits = &context.limits;
    let most = limits
        .max_storage_buffer_binding_size
        .min(limits.max_buffer_size);
    let of_tile = u64::from(TILE_PIXELS) * u64::from(groups) * size_of::<GroupMean>() as u64;
    let rows = u32::try_from(most / of_tile).unwrap_or(u32::MAX);
    rows.saturating_sub(CLASSES as u32).max(1)
}
