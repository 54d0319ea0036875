//! Kernels: a pipeline, its layout and one typed way to run it.

use super::buffer::GpuBuffer;
use super::context::Context;
use super::layout::{Dispatch, Frame, PixelState};
use super::scene_buffers::SceneBuffers;
use super::shader::{self, Config};
use crate::effects::{Effect, Effects};
use crate::error::GpuError;

/// The direct-lighting kernel (`shaders/kernel/direct.wesl`), specialised to a set of effects.
#[derive(Debug)]
pub struct DirectKernel {
    pipeline: wgpu::ComputePipeline,
    pass_layout: wgpu::BindGroupLayout,
    scene_layout: wgpu::BindGroupLayout,
    wgsl: String,
}

/// Bind group 0: the frame, a region's pixels, and what changes per dispatch.
#[derive(Debug)]
pub struct RegionBindings(wgpu::BindGroup);

/// Bind group 1: the scene.
#[derive(Debug)]
pub struct SceneBindings(wgpu::BindGroup);

const READ: wgpu::BindingType = wgpu::BindingType::Buffer {
    ty: wgpu::BufferBindingType::Storage { read_only: true },
    has_dynamic_offset: false,
    min_binding_size: None,
};
const READ_WRITE: wgpu::BindingType = wgpu::BindingType::Buffer {
    ty: wgpu::BufferBindingType::Storage { read_only: false },
    has_dynamic_offset: false,
    min_binding_size: None,
};
const UNIFORM: wgpu::BindingType = wgpu::BindingType::Buffer {
    ty: wgpu::BufferBindingType::Uniform,
    has_dynamic_offset: false,
    min_binding_size: None,
};
const TEXELS: wgpu::BindingType = wgpu::BindingType::Texture {
    sample_type: wgpu::TextureSampleType::Float { filterable: false },
    view_dimension: wgpu::TextureViewDimension::D2,
    multisampled: false,
};

fn layout(
    device: &wgpu::Device,
    label: &str,
    types: &[wgpu::BindingType],
) -> wgpu::BindGroupLayout {
    let entries: Vec<_> = types
        .iter()
        .enumerate()
        .map(|(binding, ty)| wgpu::BindGroupLayoutEntry {
            binding: binding as u32,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: *ty,
            count: None,
        })
        .collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some(label),
        entries: &entries,
    })
}

fn bind(
    device: &wgpu::Device,
    label: &str,
    layout: &wgpu::BindGroupLayout,
    resources: Vec<wgpu::BindingResource<'_>>,
) -> wgpu::BindGroup {
    let entries: Vec<_> = resources
        .into_iter()
        .enumerate()
        .map(|(binding, resource)| wgpu::BindGroupEntry {
            binding: binding as u32,
            resource,
        })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some(label),
        layout,
        entries: &entries,
    })
}

impl DirectKernel {
    /// Links and compiles the kernel.
    ///
    /// # Errors
    /// The shader does not link, or the driver refuses it.
    pub fn new(context: &Context, effects: &Effects, config: Config) -> Result<Self, GpuError> {
        let entry = "kernel::direct";
        let wgsl = shader::link(entry, effects.features(), config)?;
        let device = &context.device;
        let pass_layout = layout(
            device,
            "direct.pass",
            &[UNIFORM, UNIFORM, READ_WRITE, READ_WRITE],
        );
        let mut scene_types = vec![READ; 5];
        if effects.contains(Effect::EnvironmentMap) {
            scene_types.extend([READ, TEXELS]);
        }
        let scene_layout = layout(device, "direct.scene", &scene_types);
        let pipeline = context
            .checked(|| {
                let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
                    label: Some("direct"),
                    source: wgpu::ShaderSource::Wgsl(wgsl.as_str().into()),
                });
                let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                    label: Some("direct"),
                    bind_group_layouts: &[Some(&pass_layout), Some(&scene_layout)],
                    immediate_size: 0,
                });
                device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                    label: Some("direct.sample"),
                    layout: Some(&layout),
                    module: &module,
                    entry_point: Some("direct"),
                    compilation_options: Default::default(),
                    cache: None,
                })
            })
            .map_err(|e| GpuError::Shader {
                entry: entry.to_owned(),
                message: e.to_string(),
            })?;
        Ok(Self {
            pipeline,
            pass_layout,
            scene_layout,
            wgsl,
        })
    }

    /// The WGSL that was compiled.
    pub fn wgsl(&self) -> &str {
        &self.wgsl
    }

    /// Binds the buffers of one region of the image.
    pub fn bind_region(
        &self,
        device: &wgpu::Device,
        frame: &GpuBuffer<Frame>,
        dispatch: &GpuBuffer<Dispatch>,
        pixels: &GpuBuffer<PixelState>,
        unfinished: &GpuBuffer<u32>,
    ) -> RegionBindings {
        let resources = vec![
            frame.binding(),
            dispatch.binding(),
            pixels.binding(),
            unfinished.binding(),
        ];
        RegionBindings(bind(device, "direct.pass", &self.pass_layout, resources))
    }

    /// Binds the scene.
    pub fn bind_scene(&self, device: &wgpu::Device, scene: &SceneBuffers) -> SceneBindings {
        let mut resources = vec![
            scene.nodes.binding(),
            scene.primitives.binding(),
            scene.materials.binding(),
            scene.lights.binding(),
            scene.light_alias.binding(),
        ];
        if let Some(environment) = &scene.environment {
            resources.push(environment.alias.binding());
            resources.push(wgpu::BindingResource::TextureView(&environment.texels));
        }
        SceneBindings(bind(device, "direct.scene", &self.scene_layout, resources))
    }

    /// Records one dispatch of `tiles` workgroups.
    pub fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        region: &RegionBindings,
        scene: &SceneBindings,
        tiles: u32,
    ) {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("direct.sample"),
            timestamp_writes: None,
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &region.0, &[]);
        pass.set_bind_group(1, &scene.0, &[]);
        pass.dispatch_workgroups(tiles, 1, 1);
    }
}
