//! Small kernels that tell what a driver does.

use crate::error::GpuError;
use crate::gpu::Context;
use crate::gpu::buffer::GpuBuffer;
use crate::gpu::shader::{self, KernelConstants};

/// A compiled kernel with the buffers it reads and writes.
#[derive(Debug)]
pub(crate) struct Probe<'a> {
    context: &'a Context,
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
    questions: GpuBuffer<u32>,
    answers: GpuBuffer<u32>,
    staging: GpuBuffer<u32>,
}

impl<'a> Probe<'a> {
    /// Compiles the entry point of module `kernel::{name}`, which has the same name: it reads
    /// `inputs` words in its binding 1, where there are any, and writes `outputs` words in its
    /// binding 0, which begin as zeros.
    ///
    /// # Errors
    /// The kernel does not compile or the driver fails.
    pub(crate) fn new(
        context: &'a Context,
        name: &str,
        inputs: usize,
        outputs: usize,
    ) -> Result<Self, GpuError> {
        let wgsl = shader::link(&format!("kernel::{name}"), [], &KernelConstants::default())?;
        let device = &context.device;
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        let answers: GpuBuffer<u32> = GpuBuffer::zeroed(device, "probe.answers", outputs, usage);
        let read = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let staging: GpuBuffer<u32> = GpuBuffer::zeroed(device, "probe.staging", outputs, read);
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
        let questions: GpuBuffer<u32> =
            GpuBuffer::zeroed(device, "probe.questions", inputs.max(1), usage);
        let (pipeline, group) = context.checked(|| {
            let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(name),
                source: wgpu::ShaderSource::Wgsl(wgsl.as_str().into()),
            });
            let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(name),
                layout: None,
                module: &module,
                entry_point: Some(name),
                compilation_options: Default::default(),
                cache: None,
            });
            let buffers = [&answers, &questions];
            let bound = if inputs > 0 { 2 } else { 1 };
            let entries = (0..).zip(&buffers[..bound]);
            let entries = entries.map(|(binding, buffer)| wgpu::BindGroupEntry {
                binding,
                resource: buffer.binding(),
            });
            let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some(name),
                layout: &pipeline.get_bind_group_layout(0),
                entries: &entries.collect::<Vec<_>>(),
            });
            (pipeline, group)
        })?;
        Ok(Self {
            context,
            pipeline,
            group,
            questions,
            answers,
            staging,
        })
    }

    /// Runs it on `inputs` and returns the answers.
    ///
    /// # Errors
    /// The driver fails.
    pub(crate) fn run(&self, inputs: &[u32], workgroups: [u32; 2]) -> Result<Vec<u32>, GpuError> {
        let context = self.context;
        context.checked(|| {
            if !inputs.is_empty() {
                let bytes = bytemuck::cast_slice(inputs);
                context.queue.write_buffer(self.questions.raw(), 0, bytes);
            }
            let mut encoder = context.device.create_command_encoder(&Default::default());
            {
                let mut pass = encoder.begin_compute_pass(&Default::default());
                pass.set_pipeline(&self.pipeline);
                pass.set_bind_group(0, &self.group, &[]);
                pass.dispatch_workgroups(workgroups[0], workgroups[1], 1);
            }
            let (from, to, bytes) = (&self.answers, &self.staging, self.answers.bytes());
            encoder.copy_buffer_to_buffer(from.raw(), 0, to.raw(), 0, bytes);
            context.queue.submit([encoder.finish()]);
        })?;
        context.read(self.staging.raw(), bytemuck::pod_collect_to_vec)
    }
}

/// Compiles the [`Probe`] `name` and runs it once.
///
/// # Errors
/// The kernel does not compile or the driver fails.
pub(crate) fn probe(
    context: &Context,
    name: &str,
    inputs: &[u32],
    outputs: usize,
    workgroups: [u32; 2],
) -> Result<Vec<u32>, GpuError> {
    Probe::new(context, name, inputs.len(), outputs)?.run(inputs, workgroups)
}
