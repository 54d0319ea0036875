//! What all estimators of a scene read: geometry and images, uploaded once per device.

use super::context::Context;
use super::environment::{map_of, texels};
use super::layout::{
    ATTRIBUTE_BITS, HAS_COLORS, HAS_NORMALS, HAS_OPACITY, HAS_TANGENTS, HAS_UVS, KIND_DISK,
    KIND_ELLIPSOID, KIND_RECTANGLE, KIND_SPHERE, KIND_TRIANGLE, MATERIAL_SHIFT, NONE,
    ONE_SIDED_BIT,
};
use super::parts::{Parts, largest_part};
use super::scene_buffers::{Word, check_size, word};
use super::textures::TextureArrays;
use crate::accel::parts::PRIMITIVE_WORDS;
use crate::accel::{Attributed, Node, Primitive, PrimitiveGeometry};
use crate::emitters::Emitter;
use crate::error::GpuError;
use crate::prepare::{Prepared, SceneData};
use crate::scene::Scene;
use glam::DVec3;
use std::sync::{Arc, Mutex, PoisonError, Weak};

/// Geometry and images of a scene; record formats are those of `shaders/scene/fetch.wesl`.
#[derive(Debug)]
pub struct GpuScene {
    /// Inner nodes of the BVH.
    pub nodes: Parts<Node>,
    /// Three words per primitive.
    pub primitives: Parts<Word>,
    /// Words of [`Attributes`](crate::accel::Attributes).
    pub attributes: Parts<[f32; 4]>,
    /// Textures of materials and lights.
    pub textures: TextureArrays,
    /// Radiance of the environment map; a black texel where there is none.
    pub environment: wgpu::TextureView,
}

/// The scenes that a device holds, as long as somebody renders them.
#[derive(Debug, Default)]
pub(super) struct GpuScenes(Mutex<Vec<(Weak<SceneData>, Weak<GpuScene>)>>);

impl GpuScenes {
    /// The scene of `prepared`: uploaded now, unless the device holds it already.
    pub(super) fn get(
        &self,
        context: &Context,
        prepared: &Prepared,
    ) -> Result<Arc<GpuScene>, GpuError> {
        let mut held = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        held.retain(|(_, scene)| scene.strong_count() > 0);
        let data = Arc::downgrade(&prepared.data);
        let known = held.iter().find(|(of, _)| of.ptr_eq(&data));
        if let Some(scene) = known.and_then(|(_, scene)| scene.upgrade()) {
            return Ok(scene);
        }
        let scene = Arc::new(GpuScene::new(context, prepared)?);
        held.push((data, Arc::downgrade(&scene)));
        Ok(scene)
    }
}

impl GpuScene {
    /// Uploads the scene of `prepared`: its geometry, with the numbers of its lights, which are the
    /// same for all estimators.
    fn new(context: &Context, prepared: &Prepared) -> Result<Self, GpuError> {
        check_bindings(context, &prepared.data)?;
        check_attributes(context, &prepared.data)?;
        let SceneData {
            scene,
            attributes,
            bvh,
            split,
            ..
        } = &*prepared.data;
        let primitives = primitive_words(prepared);
        let attributes = attributes.words.as_slice();
        let of_nodes = split.map(|s| s.nodes);
        let of_primitives = split.map(|s| PRIMITIVE_WORDS * s.primitives);
        let of_attributes = split.map(|s| s.words);
        for (what, bytes) in [
            ("the BVH's nodes", largest_part(&bvh.nodes, of_nodes)),
            ("the primitives", largest_part(&primitives, of_primitives)),
            (
                "the vertex normals, texture coordinates and colours",
                largest_part(attributes, of_attributes),
            ),
        ] {
            check_size(context, what, bytes)?;
        }
        let textures = TextureArrays::new(context, scene)?;
        let environment = texels(context, map_of(scene))?;
        let device = &context.device;
        context.checked(|| Self {
            nodes: Parts::storage(device, "scene.nodes", &bvh.nodes, of_nodes),
            primitives: Parts::storage(device, "scene.primitives", &primitives, of_primitives),
            attributes: Parts::storage(device, "scene.attributes", attributes, of_attributes),
            textures,
            environment,
        })
    }
}

/// Storage buffers of a kernel over split geometry: those of groups 0 and 2, and of the scene.
pub(super) const BINDINGS_OF_SPLIT: u32 = 28;

fn check_bindings(context: &Context, data: &SceneData) -> Result<(), GpuError> {
    let limit = context.limits.max_storage_buffers_per_shader_stage;
    if data.split.is_none() || limit >= BINDINGS_OF_SPLIT {
        return Ok(());
    }
    Err(GpuError::TooMany {
        what: format!("buffers for {} primitives", data.primitives.len()),
        needed: BINDINGS_OF_SPLIT.into(),
        limit: limit.into(),
        adapter: context.adapter.name.clone(),
    })
}

/// A primitive holds the index of its first word in 32 bits, less those of its flags.
fn check_attributes(context: &Context, data: &SceneData) -> Result<(), GpuError> {
    let needed = data.attributes.words.len() as u64;
    let limit = 1 << (u32::BITS - ATTRIBUTE_BITS);
    if needed <= limit {
        return Ok(());
    }
    Err(GpuError::TooMany {
        what: "words of vertex normals, texture coordinates and colours".to_owned(),
        needed,
        limit,
        adapter: context.adapter.name.clone(),
    })
}

/// Three words per primitive: see `shaders/scene/fetch.wesl`.
pub(super) fn primitive_words(prepared: &Prepared) -> Vec<Word> {
    let mut light_of = vec![NONE; prepared.data.primitives.len()];
    for (light, emitter) in prepared.emitters.lights.iter().enumerate() {
        if let Emitter::Area { primitive, .. } = emitter {
            light_of[*primitive as usize] = light as u32;
        }
    }
    let attributes = prepared.data.attributes.of_primitive.iter();
    let words = prepared
        .data
        .primitives
        .iter()
        .zip(&light_of)
        .zip(attributes);
    words
        .flat_map(|((p, &light), a)| one_primitive(&prepared.data.scene, p, light, a))
        .collect()
}

fn one_primitive(
    scene: &Scene,
    p: &Primitive,
    light: u32,
    attributed: &Attributed,
) -> [Word; PRIMITIVE_WORDS] {
    let flag = |set: bool, bit: u32| if set { bit } else { 0 };
    let has = flag(attributed.normals, HAS_NORMALS)
        | flag(attributed.uvs, HAS_UVS)
        | flag(attributed.opacity, HAS_OPACITY)
        | flag(attributed.colors, HAS_COLORS)
        | flag(attributed.tangents, HAS_TANGENTS);
    let attributes = attributed.word << ATTRIBUTE_BITS | has;
    let one_sided = !scene.materials[p.material.index()].double_sided;
    let side = if one_sided { ONE_SIDED_BIT } else { 0 };
    let head = |kind: u32| kind | side | p.material.0 << MATERIAL_SHIFT;
    let planar = |kind: u32, a: DVec3, u: DVec3, v: DVec3| {
        [
            word(a, head(kind)),
            word(a + u, light),
            word(a + v, attributes),
        ]
    };
    match p.geometry {
        PrimitiveGeometry::Triangle { a, u, v } => planar(KIND_TRIANGLE, a, u, v),
        PrimitiveGeometry::Rectangle { a, u, v } => planar(KIND_RECTANGLE, a, u, v),
        PrimitiveGeometry::Disk { a, u, v } => planar(KIND_DISK, a, u, v),
        PrimitiveGeometry::Sphere { center, radius } => [
            word(center, head(KIND_SPHERE)),
            word(DVec3::new(radius, 0.0, 0.0), light),
            [0, 0, 0, attributes],
        ],
        PrimitiveGeometry::Ellipsoid {
            center,
            radii,
            rodrigues,
        } => [
            word(center, head(KIND_ELLIPSOID)),
            word(radii, light),
            word(rodrigues, attributes),
        ],
    }
}
