//! What one estimator reads of a scene.

use super::buffer::GpuBuffer;
use super::context::Context;
use super::environment::{alias, map_of};
use super::gpu_scene::GpuScene;
use super::layout::EMISSION_MASK;
use super::lights::{choice_words, emission_cell_words, light_words};
use super::materials::{MaterialWords, material_words};
use super::textures::atlases;
use crate::accel::Node;
use crate::accel::parts::PRIMITIVE_WORDS;
use crate::error::GpuError;
use crate::prepare::Prepared;
use glam::DVec3;
use std::sync::Arc;

/// One 16-byte word of a record.
pub(super) type Word = [u32; 4];

/// The scene's buffers; record formats are those of `shaders/scene/fetch.wesl`.
#[derive(Debug)]
pub struct SceneBuffers {
    /// Geometry and images, which other estimators share.
    pub scene: Arc<GpuScene>,
    /// [`MATERIAL_WORDS`](super::layout::MATERIAL_WORDS) words per material, and those of textures.
    pub materials: GpuBuffer<Word>,
    /// [`LIGHT_WORDS`](super::layout::LIGHT_WORDS) words per light, and those of maps of emission.
    pub lights: GpuBuffer<Word>,
    /// What lights are chosen by: an alias table, one word per light; or a light tree, three words
    /// per node and one per light outside of it.
    pub light_choice: GpuBuffer<Word>,
    /// What directions towards the environment map are chosen by: one word per cell of its sampling
    /// grid.
    pub environment_alias: GpuBuffer<Word>,
    /// One word per cell of the maps of emission.
    pub emission_cells: GpuBuffer<Word>,
}

impl SceneBuffers {
    /// Uploads what `prepared` needs; of geometry and images what the device does not hold.
    ///
    /// # Errors
    /// A buffer or the environment map is larger than the adapter binds, or memory runs out.
    pub fn new(context: &Context, prepared: &Prepared) -> Result<Self, GpuError> {
        check_maps(context, prepared)?;
        let scene = context.scenes.get(context, prepared)?;
        let places = [&scene.textures.colors.atlas, &scene.textures.data.atlas];
        let MaterialWords {
            words: materials,
            emission,
        } = material_words(prepared, places);
        let lights = light_words(prepared, &emission);
        let cells = emission_cell_words(prepared);
        let choice = choice_words(prepared);
        for (what, words) in [
            ("the materials", &materials),
            ("the lights", &lights),
            ("what lights are chosen by", &choice),
            ("what points on textured lights are chosen by", &cells),
        ] {
            check_size(context, what, size_of_val(words.as_slice()) as u64)?;
        }
        let device = &context.device;
        context.checked(|| Self {
            scene,
            materials: GpuBuffer::storage(device, "scene.materials", &materials),
            lights: GpuBuffer::storage(device, "scene.lights", &lights),
            light_choice: GpuBuffer::storage(device, "scene.light_choice", &choice),
            environment_alias: alias(device, prepared.emitters.environment.as_ref()),
            emission_cells: GpuBuffer::storage(device, "scene.emission_cells", &cells),
        })
    }

    /// Labels and bytes of all that [`new`](Self::new) makes for `prepared` on a device that holds
    /// nothing of it.
    pub fn sizes(prepared: &Prepared) -> Vec<(&'static str, u64)> {
        let words = |count: usize| (count.max(1) * size_of::<Word>()) as u64;
        let nodes = prepared.data.bvh.nodes.len().max(1) * size_of::<Node>();
        let scene = &prepared.data.scene;
        let [colors, data] = atlases(scene);
        let materials = material_words(prepared, [&colors, &data]);
        let lights = light_words(prepared, &materials.emission).len();
        let attributes = prepared.data.attributes.words.len();
        let mut sizes = vec![
            ("scene.nodes", nodes as u64),
            (
                "scene.primitives",
                words(PRIMITIVE_WORDS * prepared.data.primitives.len()),
            ),
            ("scene.materials", words(materials.words.len())),
            ("scene.lights", words(lights)),
            ("scene.light_choice", words(choice_words(prepared).len())),
            ("scene.attributes", words(attributes)),
            ("scene.color_textures", colors.bytes(scene)),
            ("scene.data_textures", data.bytes(scene)),
            (
                "scene.emission_cells",
                words(emission_cell_words(prepared).len()),
            ),
        ];
        let grid = prepared.emitters.environment.as_ref();
        let cells = grid.map_or(0, |grid| grid.table.entries.len());
        let texels = map_of(scene).map_or(0, |map| map.texels.len());
        sizes.push(("scene.environment_alias", words(cells)));
        sizes.push(("scene.environment", words(texels)));
        sizes
    }
}

fn check_maps(context: &Context, prepared: &Prepared) -> Result<(), GpuError> {
    let (needed, limit) = (prepared.emitters.maps.len() as u64, EMISSION_MASK.into());
    if needed <= limit {
        return Ok(());
    }
    Err(GpuError::TooMany {
        what: "triangles that emit a texture".to_owned(),
        needed,
        limit,
        adapter: context.adapter.name.clone(),
    })
}

pub(super) fn check_size(context: &Context, what: &str, needed: u64) -> Result<(), GpuError> {
    let limit = context
        .limits
        .max_storage_buffer_binding_size
        .min(context.limits.max_buffer_size);
    if needed <= limit {
        return Ok(());
    }
    Err(GpuError::TooLarge {
        what: what.to_owned(),
        needed,
        limit,
        adapter: context.adapter.name.clone(),
    })
}

/// A vector and one more component, as f32 bits.
pub(super) fn word(v: DVec3, w: u32) -> Word {
    let [x, y, z] = v.as_vec3().to_array().map(f32::to_bits);
    [x, y, z, w]
}

/// f64 to the bits of an f32.
pub(super) fn bits(x: f64) -> u32 {
    (x as f32).to_bits()
}
