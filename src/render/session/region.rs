//! A part of the image whose pixels share buffers.

use crate::effects::Effect;
use crate::gpu::kernel::{PassBuffers, RegionBindings, SceneKernel};
use crate::gpu::layout::{Dispatch, Frame, GroupMean, PixelState, TILE_PIXELS};
use crate::gpu::{Context, GpuBuffer};
use crate::render::prepare::Prepared;

/// Pixels whose states share one buffer.
#[derive(Debug)]
pub(super) struct Region {
    pub(super) first_tile: u32,
    pub(super) tiles: u32,
    pub(super) pixels: GpuBuffer<PixelState>,
    pub(super) staging: GpuBuffer<PixelState>,
    /// The means of their groups of lights, and where these are read from.
    pub(super) light_groups: Option<[GpuBuffer<GroupMean>; 2]>,
    pub(super) bindings: RegionBindings,
}

impl Region {
    /// `tiles` tiles from `first_tile` on, with `groups` groups of lights.
    pub(super) fn new(
        device: &wgpu::Device,
        kernel: &SceneKernel,
        (frame, dispatch, unfinished): (&GpuBuffer<Frame>, &GpuBuffer<Dispatch>, &GpuBuffer<u32>),
        (first_tile, tiles): (u32, u32),
        groups: u32,
    ) -> Self {
        let count = (tiles * TILE_PIXELS) as usize;
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
        Self {
            first_tile,
            tiles,
            bindings: kernel.bind_region(device, &pass),
            light_groups,
            pixels,
            staging: GpuBuffer::zeroed(device, "direct.pixels.staging", count, read),
        }
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
    u32::try_from(most / of_tile).unwrap_or(u32::MAX).max(1)
}
