//! Small kernels that tell what a driver does.

use crate::error::GpuError;
use crate::gpu::Context;
use crate::gpu::buffer::GpuBuffer;
use crate::gpu::shader::{self, KernelConstants};

/// Runs the entry point of module `kernel::{name}`, which has the same name: `inputs` are the words
/// of its binding 1, where there are any, and the answer those of its binding 0, `outputs` words
/// that begin as zeros.
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
    let wgsl = shader::link(&format!("kernel::{name}"), [], &KernelConstants::default())?;
    let device = &context.device;
    let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
    let answers: GpuBuffer<u32> = GpuBuffer::zeroed(device, "probe.answers", outputs, usage);
    let read = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
    let staging: GpuBuffer<u32> = GpuBuffer::zeroed(device, "probe.staging", outputs, read);
    let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
    let questions: GpuBuffer<u32> =
        GpuBuffer::zeroed(device, "probe.questions", inputs.len().max(1), usage);
    context.checked(|| {
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
        let mut entries = vec![wgpu::BindGroupEntry {
            binding: 0,
            resource: answers.binding(),
        }];
        if !inputs.is_empty() {
            let bytes = bytemuck::cast_slice(inputs);
            context.queue.write_buffer(questions.raw(), 0, bytes);
            entries.push(wgpu::BindGroupEntry {
                binding: 1,
                resource: questions.binding(),
            });
        }
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(name),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        let mut encoder = device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups(workgroups[0], workgroups[1], 1);
        }
        let bytes = answers.bytes();
        encoder.copy_buffer_to_buffer(answers.raw(), 0, staging.raw(), 0, bytes);
        context.queue.submit([encoder.finish()]);
    })?;
    context.read(staging.raw(), bytemuck::pod_collect_to_vec)
}
