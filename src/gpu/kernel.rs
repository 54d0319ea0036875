//! Kernels: a pipeline, its layout and one typed way to run it.

use super::buffer::GpuBuffer;
use super::context::Context;
use super::gpu_scene::GpuScene;
use super::layout::{Dispatch, Frame, GroupMean, PixelState};
use super::scene_buffers::SceneBuffers;
use super::shader::{self, KernelConstants};
use super::specialize::SpecializedScene;
use crate::accel::parts::PARTS;
use crate::effects::{Effect, Effects};
use crate::error::GpuError;
use std::sync::Arc;

/// A kernel over a scene: a pipeline and the layouts of its bind groups. Group 0 holds the frame, a
/// region's pixels and what changes per dispatch, group 1 the scene, group 2 whatever else the
/// kernel reads and writes.
#[derive(Debug, Clone)]
pub struct SceneKernel {
    pipeline: wgpu::ComputePipeline,
    pass_layout: wgpu::BindGroupLayout,
    scene_layout: wgpu::BindGroupLayout,
    scene_bindings: Vec<u32>,
    has_light_groups: bool,
    extra_layout: Option<wgpu::BindGroupLayout>,
    label: &'static str,
    wgsl: String,
}

/// Which kernel to link.
#[derive(Debug, Clone, Copy)]
pub struct KernelDescriptor<'a> {
    /// Prefix of the labels, and name of the entry point.
    pub name: &'static str,
    /// Module of the entry point, `kernel::direct`.
    pub module: &'a str,
    /// Text of that module, where it is not one of `shaders/` (test kernels).
    pub source: Option<&'a str>,
    /// WESL features beside those of the effects.
    pub features: &'a [&'static str],
    /// Bindings of group 2.
    pub extra_bindings: &'a [wgpu::BindingType],
}

/// The direct-lighting kernel, `shaders/kernel/direct.wesl`.
pub const DIRECT: KernelDescriptor<'static> = KernelDescriptor {
    name: "direct",
    module: "kernel::direct",
    source: None,
    features: &[],
    extra_bindings: &[READ],
};

/// The kernel that writes out single samples, `shaders/kernel/record.wesl`.
pub const RECORD: KernelDescriptor<'static> = KernelDescriptor {
    name: "record",
    module: "kernel::record",
    source: None,
    features: &["RECORD"],
    extra_bindings: &[READ_WRITE],
};

/// The kernel that sums what a denoiser asks for, `shaders/kernel/features.wesl`.
pub const FEATURES: KernelDescriptor<'static> = KernelDescriptor {
    name: "features",
    module: "kernel::features",
    source: None,
    features: &["FEATURES"],
    extra_bindings: &[READ_WRITE],
};

/// The kernel that finds the surface in the middle of each pixel, `shaders/kernel/gbuffer.wesl`.
pub const GBUFFER: KernelDescriptor<'static> = KernelDescriptor {
    name: "gbuffer",
    module: "kernel::gbuffer",
    source: None,
    features: &[],
    extra_bindings: &[READ_WRITE],
};

/// The buffers of group 0.
#[derive(Debug, Clone, Copy)]
pub struct PassBuffers<'a> {
    /// What stays the same for a render.
    pub frame: &'a GpuBuffer<Frame>,
    /// What changes per dispatch.
    pub dispatch: &'a GpuBuffer<Dispatch>,
    /// The pixels of a region.
    pub pixels: &'a GpuBuffer<PixelState>,
    /// Whether a pixel did not reach its target.
    pub unfinished: &'a GpuBuffer<u32>,
    /// Their groups of lights; kernels without these leave it out.
    pub light_groups: Option<&'a GpuBuffer<GroupMean>>,
}

/// Bind group 0: the frame, a region's pixels, and what changes per dispatch.
#[derive(Debug)]
pub struct RegionBindings(wgpu::BindGroup);

/// Bind group 1: the scene.
#[derive(Debug)]
pub struct SceneBindings {
    group: wgpu::BindGroup,
    /// So that the device holds it for those who come later.
    _scene: Arc<GpuScene>,
}

/// Bind group 2: what only this kernel has.
#[derive(Debug)]
pub struct ExtraBindings(wgpu::BindGroup);

/// A storage buffer that is read.
pub const READ: wgpu::BindingType = wgpu::BindingType::Buffer {
    ty: wgpu::BufferBindingType::Storage { read_only: true },
    has_dynamic_offset: false,
    min_binding_size: None,
};
/// A storage buffer that is written.
pub const READ_WRITE: wgpu::BindingType = wgpu::BindingType::Buffer {
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

const LAYERS: wgpu::BindingType = wgpu::BindingType::Texture {
    sample_type: wgpu::TextureSampleType::Float { filterable: false },
    view_dimension: wgpu::TextureViewDimension::D2Array,
    multisampled: false,
};

/// Parts of an array beside the first.
const FURTHER: u32 = PARTS as u32 - 1;
/// First binding of the further parts of the nodes.
const NODE_PARTS: u32 = 11;
/// The same of the primitives.
const PRIMITIVE_PARTS: u32 = NODE_PARTS + FURTHER;
/// The same of the attributes.
const ATTRIBUTE_PARTS: u32 = PRIMITIVE_PARTS + FURTHER;

/// The bindings of group 1 that a kernel with `effects` has, over geometry that is split or not;
/// see `shaders/scene/bindings.wesl`.
fn scene_types(effects: &Effects, split: bool) -> Vec<(u32, wgpu::BindingType)> {
    let any = |of: &[Effect]| of.iter().any(|e| effects.contains(*e));
    let mut types = numbered(&[READ; 5]);
    if any(&[Effect::EnvironmentMap]) {
        types.extend([(5, READ), (6, TEXELS)]);
    }
    let data = [Effect::RoughnessTexture, Effect::NormalMap];
    let colors = [
        Effect::ColorTexture,
        Effect::GlossinessTexture,
        Effect::AlphaTexture,
    ];
    let of_vertices = [Effect::SmoothNormals, Effect::VertexColors];
    let attributes = any(&data) || any(&colors) || any(&of_vertices);
    if attributes {
        types.push((7, READ));
    }
    if split {
        let end = if attributes {
            ATTRIBUTE_PARTS + FURTHER
        } else {
            ATTRIBUTE_PARTS
        };
        types.extend((NODE_PARTS..end).map(|binding| (binding, READ)));
    }
    if any(&colors) || any(&[Effect::EmissiveTexture]) {
        types.push((8, LAYERS));
    }
    if any(&data) {
        types.push((9, LAYERS));
    }
    if any(&[Effect::EmissiveTexture]) {
        types.push((10, READ));
    }
    types
}

fn numbered(types: &[wgpu::BindingType]) -> Vec<(u32, wgpu::BindingType)> {
    (0..).zip(types.iter().copied()).collect()
}

fn layout(
    device: &wgpu::Device,
    label: &str,
    types: &[(u32, wgpu::BindingType)],
) -> wgpu::BindGroupLayout {
    let entries: Vec<_> = types
        .iter()
        .map(|(binding, ty)| wgpu::BindGroupLayoutEntry {
            binding: *binding,
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

fn bind<'a>(
    device: &wgpu::Device,
    label: &str,
    layout: &wgpu::BindGroupLayout,
    resources: impl IntoIterator<Item = (u32, wgpu::BindingResource<'a>)>,
) -> wgpu::BindGroup {
    let resources = resources.into_iter();
    let entries: Vec<_> = resources
        .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some(label),
        layout,
        entries: &entries,
    })
}

impl SceneKernel {
    /// Links and compiles `descriptor` for `effects`.
    ///
    /// # Errors
    /// The shader does not link, or the driver refuses it.
    pub fn new(
        context: &Context,
        descriptor: &KernelDescriptor<'_>,
        effects: &Effects,
        constants: &KernelConstants,
    ) -> Result<Self, GpuError> {
        let wgsl = Self::link(descriptor, effects, constants)?;
        Self::compile(context, descriptor, (effects, constants), wgsl)
    }

    /// The WGSL of `descriptor` for `effects`.
    ///
    /// # Errors
    /// The shader does not link.
    pub fn link(
        descriptor: &KernelDescriptor<'_>,
        effects: &Effects,
        constants: &KernelConstants,
    ) -> Result<String, GpuError> {
        let further = descriptor.features.iter().map(|f| (*f, true));
        let split = ("SPLIT_GEOMETRY", constants.split.is_some());
        let specialized = SpecializedScene::features(constants.specialized.as_ref());
        let features = effects.features().chain(further).chain([split]);
        let features = features.chain(specialized);
        shader::link_with(descriptor.module, descriptor.source, features, constants)
    }

    /// Compiles what [`link`](Self::link) made for `effects` and `config`.
    ///
    /// # Errors
    /// The driver refuses it.
    pub fn compile(
        context: &Context,
        descriptor: &KernelDescriptor<'_>,
        (effects, constants): (&Effects, &KernelConstants),
        wgsl: String,
    ) -> Result<Self, GpuError> {
        let device = &context.device;
        let name = descriptor.name;
        let has_light_groups = effects.contains(Effect::LightGroups);
        let mut pass_types = vec![UNIFORM, UNIFORM, READ_WRITE, READ_WRITE];
        pass_types.extend(has_light_groups.then_some(READ_WRITE));
        let pass_layout = layout(device, &format!("{name}.pass"), &numbered(&pass_types));
        let scene_types = scene_types(effects, constants.split.is_some());
        let scene_layout = layout(device, &format!("{name}.scene"), &scene_types);
        let extra_layout = (!descriptor.extra_bindings.is_empty()).then(|| {
            layout(
                device,
                &format!("{name}.extra"),
                &numbered(descriptor.extra_bindings),
            )
        });
        let mut groups = vec![Some(&pass_layout), Some(&scene_layout)];
        groups.extend(extra_layout.as_ref().map(Some));
        let pipeline = context
            .checked(|| {
                let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
                    label: Some(name),
                    source: wgpu::ShaderSource::Wgsl(wgsl.as_str().into()),
                });
                let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                    label: Some(name),
                    bind_group_layouts: &groups,
                    immediate_size: 0,
                });
                device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                    label: Some(name),
                    layout: Some(&layout),
                    module: &module,
                    entry_point: Some(name),
                    compilation_options: Default::default(),
                    cache: None,
                })
            })
            .map_err(|e| GpuError::Shader {
                entry: descriptor.module.to_owned(),
                message: e.to_string(),
            })?;
        Ok(Self {
            pipeline,
            pass_layout,
            scene_layout,
            scene_bindings: scene_types
                .into_iter()
                .map(|(binding, _)| binding)
                .collect(),
            has_light_groups,
            extra_layout,
            label: name,
            wgsl,
        })
    }

    /// The WGSL that was compiled.
    pub fn wgsl(&self) -> &str {
        &self.wgsl
    }

    /// Binds the buffers of one region of the image.
    pub fn bind_region(&self, device: &wgpu::Device, buffers: &PassBuffers<'_>) -> RegionBindings {
        let groups = buffers.light_groups.filter(|_| self.has_light_groups);
        let resources = [
            buffers.frame.binding(),
            buffers.dispatch.binding(),
            buffers.pixels.binding(),
            buffers.unfinished.binding(),
        ];
        let resources = resources.into_iter().chain(groups.map(GpuBuffer::binding));
        let resources = (0..).zip(resources);
        RegionBindings(bind(device, self.label, &self.pass_layout, resources))
    }

    /// Binds the scene.
    pub fn bind_scene(&self, device: &wgpu::Device, buffers: &SceneBuffers) -> SceneBindings {
        let scene = &buffers.scene;
        let resources = [
            scene.nodes.binding(0),
            scene.primitives.binding(0),
            buffers.materials.binding(),
            buffers.lights.binding(),
            buffers.light_choice.binding(),
        ];
        let texture = wgpu::BindingResource::TextureView;
        let mut resources: Vec<_> = (0..).zip(resources).collect();
        resources.extend([
            (5, buffers.environment_alias.binding()),
            (6, texture(&scene.environment)),
            (7, scene.attributes.binding(0)),
            (8, texture(&scene.textures.colors.view)),
            (9, texture(&scene.textures.data.view)),
            (10, buffers.emission_cells.binding()),
        ]);
        for part in 1..PARTS {
            let binding = |first: u32| first + part as u32 - 1;
            resources.extend([
                (binding(NODE_PARTS), scene.nodes.binding(part)),
                (binding(PRIMITIVE_PARTS), scene.primitives.binding(part)),
                (binding(ATTRIBUTE_PARTS), scene.attributes.binding(part)),
            ]);
        }
        resources.retain(|(binding, _)| self.scene_bindings.contains(binding));
        SceneBindings {
            group: bind(device, self.label, &self.scene_layout, resources),
            _scene: Arc::clone(scene),
        }
    }

    /// Binds group 2.
    ///
    /// # Panics
    /// The kernel has none.
    pub fn bind_extra(
        &self,
        device: &wgpu::Device,
        resources: Vec<wgpu::BindingResource<'_>>,
    ) -> ExtraBindings {
        let layout = self.extra_layout.as_ref();
        let layout = layout.expect("only kernels with bindings of their own bind them");
        ExtraBindings(bind(device, self.label, layout, (0..).zip(resources)))
    }

    /// Records one dispatch of `workgroups` workgroups.
    pub fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        region: &RegionBindings,
        scene: &SceneBindings,
        extra: Option<&ExtraBindings>,
        workgroups: u32,
    ) {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some(self.label),
            timestamp_writes: None,
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &region.0, &[]);
        pass.set_bind_group(1, &scene.group, &[]);
        if let Some(extra) = extra {
            pass.set_bind_group(2, &extra.0, &[]);
        }
        pass.dispatch_workgroups(workgroups, 1, 1);
    }
}
