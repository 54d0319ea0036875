//! Runs a kernel of the lab: any number of items, cut into dispatches, each item's block poisoned
//! before.

use super::layout::{LabBlock, LabRun};
use direkt::error::GpuError;
use direkt::low_level::gpu::kernel::{READ, READ_WRITE};
use direkt::low_level::gpu::program::POISON;
use direkt::low_level::gpu::shader::{self, KernelConstants};
use direkt::low_level::gpu::{Context, GpuBuffer};
use std::time::Instant;

/// Most items of a dispatch: 65,535 workgroups of 64 invocations are what every adapter takes.
const MAX_ITEMS: u32 = 65_535 * 64;
/// Samples of a dispatch, about: a tenth of a second on two cores, far less on a GPU.
const DISPATCH_SAMPLES: u32 = 1 << 22;

/// A kernel of the lab, compiled.
#[derive(Debug)]
pub struct Bench<'a> {
    context: &'a Context,
    name: &'static str,
    pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
}

/// What a run gave.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// A block per item.
    pub blocks: Vec<LabBlock>,
    /// Time from submitting to reading back, in seconds.
    pub seconds: f64,
}

impl<'a> Bench<'a> {
    /// Compiles `shaders/kernel/NAME.wesl`, whose entry point has that name.
    ///
    /// # Errors
    /// The kernel does not link, or the driver refuses it.
    pub fn new(context: &'a Context, name: &'static str) -> Result<Self, GpuError> {
        let module = format!("kernel::{name}");
        let wgsl = shader::link(&module, [], &KernelConstants::default())?;
        let device = &context.device;
        let uniform = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let entries: Vec<_> = [uniform, READ, READ_WRITE]
            .into_iter()
            .zip(0..)
            .map(|(ty, binding)| wgpu::BindGroupLayoutEntry {
                binding,
                visibility: wgpu::ShaderStages::COMPUTE,
                ty,
                count: None,
            })
            .collect();
        let compiled = context.checked(|| {
            let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some(name),
                entries: &entries,
            });
            let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(name),
                bind_group_layouts: &[Some(&layout)],
                immediate_size: 0,
            });
            let shader = device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(name),
                source: wgpu::ShaderSource::Wgsl(wgsl.as_str().into()),
            });
            let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(name),
                layout: Some(&pipeline_layout),
                module: &shader,
                entry_point: Some(name),
                compilation_options: Default::default(),
                cache: None,
            });
            (pipeline, layout)
        });
        let (pipeline, layout) = compiled.map_err(|e| GpuError::Shader {
            entry: module,
            message: e.to_string(),
        })?;
        Ok(Self {
            context,
            name,
            pipeline,
            layout,
        })
    }

    /// Runs `run.items` items, however many dispatches that takes; `table` is what the kernel calls
    /// `lab_table`.
    ///
    /// # Errors
    /// The driver fails, or left an item out.
    pub fn run(&self, run: &LabRun, table: &[[u32; 4]]) -> Result<Outcome, GpuError> {
        let step = (DISPATCH_SAMPLES / run.samples.max(1)).clamp(1, MAX_ITEMS);
        let table = GpuBuffer::storage(&self.context.device, "lab.table", table);
        let start = Instant::now();
        let mut blocks = Vec::with_capacity(run.items as usize);
        let mut done = 0;
        while done < run.items {
            let items = step.min(run.items - done);
            let part = LabRun {
                items,
                first_item: run.first_item + done,
                ..*run
            };
            blocks.extend(self.dispatch(&part, &table)?);
            done += items;
        }
        Ok(Outcome {
            blocks,
            seconds: start.elapsed().as_secs_f64(),
        })
    }

    fn dispatch(
        &self,
        run: &LabRun,
        table: &GpuBuffer<[u32; 4]>,
    ) -> Result<Vec<LabBlock>, GpuError> {
        use wgpu::BufferUsages as Usage;
        let context = self.context;
        let device = &context.device;
        let length = run.items as usize;
        let staging: GpuBuffer<LabBlock> = context.checked(|| {
            let uniform = Usage::UNIFORM | Usage::COPY_DST;
            let storage = Usage::STORAGE | Usage::COPY_SRC | Usage::COPY_DST;
            let read = Usage::MAP_READ | Usage::COPY_DST;
            let parameters: GpuBuffer<LabRun> = GpuBuffer::zeroed(device, "lab.run", 1, uniform);
            let output: GpuBuffer<LabBlock> =
                GpuBuffer::zeroed(device, "lab.blocks", length, storage);
            let staging = GpuBuffer::zeroed(device, "lab.staging", length, read);
            let poison = vec![POISON; length * size_of::<LabBlock>() / size_of::<u32>()];
            let queue = &context.queue;
            queue.write_buffer(parameters.raw(), 0, bytemuck::bytes_of(run));
            queue.write_buffer(output.raw(), 0, bytemuck::cast_slice(&poison));
            let bound = [&parameters.raw(), &table.raw(), &output.raw()];
            let entries: Vec<_> = bound
                .iter()
                .zip(0..)
                .map(|(buffer, binding)| wgpu::BindGroupEntry {
                    binding,
                    resource: buffer.as_entire_binding(),
                })
                .collect();
            let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some(self.name),
                layout: &self.layout,
                entries: &entries,
            });
            let mut encoder = device.create_command_encoder(&Default::default());
            {
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                    label: Some(self.name),
                    timestamp_writes: None,
                });
                pass.set_pipeline(&self.pipeline);
                pass.set_bind_group(0, &group, &[]);
                pass.dispatch_workgroups(run.items.div_ceil(64), 1, 1);
            }
            encoder.copy_buffer_to_buffer(output.raw(), 0, staging.raw(), 0, output.bytes());
            queue.submit([encoder.finish()]);
            staging
        })?;
        let blocks: Vec<LabBlock> =
            context.read(staging.raw(), |bytes| bytemuck::cast_slice(bytes).to_vec())?;
        match blocks.iter().position(|b| b.samples == POISON) {
            Some(i) => Err(context.driver_error(format!(
                "{}: item {} of {} was not written",
                self.name, i, run.items
            ))),
            None => Ok(blocks),
        }
    }
}
