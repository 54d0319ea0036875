//! A kernel with a scene bound to it, for one dispatch at a time.

use super::buffer::GpuBuffer;
use super::context::Context;
use super::frame::frame_of;
use super::kernel::{
    ExtraBindings, KernelDescriptor, PassBuffers, RegionBindings, SceneBindings, SceneKernel,
};
use super::layout::{Dispatch, Frame, PixelState, TILE_PIXELS};
use super::scene_buffers::SceneBuffers;
use super::shader::KernelConstants;
use crate::error::GpuError;
use crate::prepare::Prepared;
use crate::scene::FilmSize;

/// A word that no kernel writes; buffers are filled with it so that slots which were never written
/// are seen.
pub const POISON: u32 = 0x7fc0_dead;

/// A kernel with a scene bound to it.
#[derive(Debug)]
pub struct SceneProgram<'a> {
    context: &'a Context,
    kernel: SceneKernel,
    region: RegionBindings,
    scene: SceneBindings,
    dispatch: GpuBuffer<Dispatch>,
}

impl<'a> SceneProgram<'a> {
    /// Compiles `descriptor` for the effects of `prepared` and uploads the scene, for an image of
    /// `film` pixels. The bound pixel states are those of one tile.
    ///
    /// # Errors
    /// The kernel does not compile, or the scene is too large for the adapter.
    pub fn new(
        context: &'a Context,
        prepared: &Prepared,
        film: FilmSize,
        seed: u32,
        descriptor: &KernelDescriptor<'_>,
    ) -> Result<Self, GpuError> {
        let constants = KernelConstants::of(prepared);
        let kernel = context.kernel(descriptor, &prepared.effects, &constants)?;
        let buffers = SceneBuffers::new(context, prepared)?;
        let device = &context.device;
        let uniform = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let storage = wgpu::BufferUsages::STORAGE;
        context.checked(|| {
            let frame: GpuBuffer<Frame> = GpuBuffer::zeroed(device, "program.frame", 1, uniform);
            let data = frame_of(prepared, film, seed);
            let bytes = bytemuck::bytes_of(&data);
            context.queue.write_buffer(frame.raw(), 0, bytes);
            let dispatch = GpuBuffer::zeroed(device, "program.dispatch", 1, uniform);
            let pixels: GpuBuffer<PixelState> =
                GpuBuffer::zeroed(device, "program.pixels", TILE_PIXELS as usize, storage);
            let unfinished = GpuBuffer::zeroed(device, "program.unfinished", 1, storage);
            let groups = TILE_PIXELS as usize * constants.light_groups as usize;
            let groups = GpuBuffer::zeroed(device, "program.light_groups", groups, storage);
            let pass = PassBuffers {
                frame: &frame,
                dispatch: &dispatch,
                pixels: &pixels,
                unfinished: &unfinished,
                light_groups: Some(&groups),
            };
            Self {
                context,
                region: kernel.bind_region(device, &pass),
                scene: kernel.bind_scene(device, &buffers),
                kernel,
                dispatch,
            }
        })
    }

    /// The device.
    pub fn context(&self) -> &'a Context {
        self.context
    }

    /// The kernel.
    pub fn kernel(&self) -> &SceneKernel {
        &self.kernel
    }

    /// Fills `output` with [`POISON`], runs `workgroups` workgroups, and hands what then stands in
    /// `output` to `read`. `own` binds `output`, `staging` is as long.
    ///
    /// # Errors
    /// The driver fails.
    pub fn run<T: bytemuck::Pod, R>(
        &self,
        parameters: &Dispatch,
        workgroups: u32,
        extra: &ExtraBindings,
        (output, staging): (&GpuBuffer<T>, &GpuBuffer<T>),
        read: impl FnOnce(&[T]) -> R,
    ) -> Result<R, GpuError> {
        let context = self.context;
        let poison = vec![POISON; output.bytes() as usize / size_of::<u32>()];
        context.checked(|| {
            let queue = &context.queue;
            queue.write_buffer(output.raw(), 0, bytemuck::cast_slice(&poison));
            queue.write_buffer(self.dispatch.raw(), 0, bytemuck::bytes_of(parameters));
            let mut encoder = context.device.create_command_encoder(&Default::default());
            let (region, scene) = (&self.region, &self.scene);
            self.kernel
                .encode(&mut encoder, region, scene, Some(extra), workgroups);
            encoder.copy_buffer_to_buffer(output.raw(), 0, staging.raw(), 0, output.bytes());
            queue.submit([encoder.finish()]);
        })?;
        context.read(staging.raw(), |bytes| read(bytemuck::cast_slice(bytes)))
    }
}
