//! The scene as the GPU reads it.

use super::buffer::GpuBuffer;
use super::context::Context;
use super::environment::EnvironmentBuffers;
use super::layout::{
    ATTRIBUTE_BITS, EMISSION_MASK, FILTER_WORDS, Frame, HAS_COLORS, HAS_NORMALS, HAS_OPACITY,
    HAS_TANGENTS, HAS_UVS, KIND_DISK, KIND_ELLIPSOID, KIND_RECTANGLE, KIND_SPHERE, KIND_TRIANGLE,
    MATERIAL_SHIFT, NONE, ONE_SIDED_BIT, TILE,
};
use super::lights::{choice_words, emission_cell_words, first_emission_word, light_words};
use super::materials::{MaterialWords, material_words};
use super::parts::{Parts, largest_part};
use super::textures::{TextureArrays, atlases};
use crate::accel::parts::PRIMITIVE_WORDS;
use crate::accel::{Attributed, Node, Primitive, PrimitiveGeometry};
use crate::emitters::{Emitter, Selection};
use crate::error::GpuError;
use crate::render::Prepared;
use crate::scene::filter::FilterTable;
use crate::scene::light::Interpolation;
use crate::scene::{EnvironmentRadiance, FilmSize, Scene};
use glam::DVec3;

/// One 16-byte word of a record.
pub(super) type Word = [u32; 4];

/// The scene's buffers; record formats are those of `shaders/scene/fetch.wesl`.
#[derive(Debug)]
pub struct SceneBuffers {
    /// Inner nodes of the BVH.
    pub nodes: Parts<Node>,
    /// Three words per primitive.
    pub primitives: Parts<Word>,
    /// [`MATERIAL_WORDS`](super::layout::MATERIAL_WORDS) words per material, and those of textures.
    pub materials: GpuBuffer<Word>,
    /// [`LIGHT_WORDS`](super::layout::LIGHT_WORDS) words per light, and those of maps of emission.
    pub lights: GpuBuffer<Word>,
    /// What lights are chosen by: an alias table, one word per light; or a light tree, three words per node and one per
    /// light outside of it.
    pub light_choice: GpuBuffer<Word>,
    /// The environment map; a texel where there is none.
    pub environment: EnvironmentBuffers,
    /// Words of [`Attributes`](crate::accel::Attributes).
    pub attributes: Parts<[f32; 4]>,
    /// Textures of materials and lights.
    pub textures: TextureArrays,
    /// One word per cell of the maps of emission.
    pub emission_cells: GpuBuffer<Word>,
}

impl SceneBuffers {
    /// Uploads a scene.
    ///
    /// # Errors
    /// A buffer or the environment map is larger than the adapter binds, or memory runs out.
    pub fn new(context: &Context, prepared: &Prepared) -> Result<Self, GpuError> {
        check_maps(context, prepared)?;
        check_bindings(context, prepared)?;
        let split = prepared.split;
        let primitives = primitive_words(prepared);
        let attributes = prepared.attributes.words.as_slice();
        check_attributes(context, prepared)?;
        let textures = TextureArrays::new(context, &prepared.scene)?;
        let places = [&textures.colors.atlas, &textures.data.atlas];
        let MaterialWords {
            words: materials,
            emission,
        } = material_words(&prepared.scene, places);
        let lights = light_words(prepared, &emission);
        let cells = emission_cell_words(prepared);
        let choice = choice_words(prepared);
        let bytes = |words: &[Word]| size_of_val(words) as u64;
        for (what, bytes) in [
            (
                "the BVH's nodes",
                largest_part(&prepared.bvh.nodes, split.map(|s| s.nodes)),
            ),
            (
                "the primitives",
                largest_part(&primitives, split.map(|s| PRIMITIVE_WORDS * s.primitives)),
            ),
            (
                "the vertex normals, texture coordinates and colours",
                largest_part(attributes, split.map(|s| s.words)),
            ),
            ("the materials", bytes(&materials)),
            ("the lights", bytes(&lights)),
            ("what lights are chosen by", bytes(&choice)),
            (
                "what points on textured lights are chosen by",
                bytes(&cells),
            ),
        ] {
            check_size(context, what, bytes)?;
        }
        let radiance = prepared.scene.environment.as_ref().map(|e| &e.radiance);
        let environment = match (radiance, &prepared.emitters.environment) {
            (Some(EnvironmentRadiance::Map(map)), Some(grid)) => {
                EnvironmentBuffers::new(context, map, grid)?
            }
            _ => EnvironmentBuffers::none(context)?,
        };
        let device = &context.device;
        context.checked(|| Self {
            nodes: Parts::storage(
                device,
                "scene.nodes",
                &prepared.bvh.nodes,
                split.map(|s| s.nodes),
            ),
            primitives: Parts::storage(
                device,
                "scene.primitives",
                &primitives,
                split.map(|s| PRIMITIVE_WORDS * s.primitives),
            ),
            materials: GpuBuffer::storage(device, "scene.materials", &materials),
            lights: GpuBuffer::storage(device, "scene.lights", &lights),
            light_choice: GpuBuffer::storage(device, "scene.light_choice", &choice),
            environment,
            attributes: Parts::storage(
                device,
                "scene.attributes",
                attributes,
                split.map(|s| s.words),
            ),
            textures,
            emission_cells: GpuBuffer::storage(device, "scene.emission_cells", &cells),
        })
    }
}

impl SceneBuffers {
    /// Labels and bytes of all that [`new`](Self::new) makes for `prepared`.
    pub fn sizes(prepared: &Prepared) -> Vec<(&'static str, u64)> {
        let words = |count: usize| (count.max(1) * size_of::<Word>()) as u64;
        let nodes = prepared.bvh.nodes.len().max(1) * size_of::<Node>();
        let scene = &prepared.scene;
        let [colors, data] = atlases(scene);
        let materials = material_words(scene, [&colors, &data]);
        let lights = light_words(prepared, &materials.emission).len();
        let attributes = prepared.attributes.words.len();
        let mut sizes = vec![
            ("scene.nodes", nodes as u64),
            (
                "scene.primitives",
                words(PRIMITIVE_WORDS * prepared.primitives.len()),
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
        let radiance = prepared.scene.environment.as_ref().map(|e| &e.radiance);
        let (cells, texels) = match (radiance, &prepared.emitters.environment) {
            (Some(EnvironmentRadiance::Map(map)), Some(grid)) => {
                (grid.table.entries.len(), map.texels.len())
            }
            _ => (0, 0),
        };
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

/// Storage buffers of a kernel over split geometry: those of groups 0 and 2, and of the scene.
pub(super) const BINDINGS_OF_SPLIT: u32 = 28;

fn check_bindings(context: &Context, prepared: &Prepared) -> Result<(), GpuError> {
    let limit = context.limits.max_storage_buffers_per_shader_stage;
    if prepared.split.is_none() || limit >= BINDINGS_OF_SPLIT {
        return Ok(());
    }
    Err(GpuError::TooMany {
        what: format!("buffers for {} primitives", prepared.primitives.len()),
        needed: BINDINGS_OF_SPLIT.into(),
        limit: limit.into(),
        adapter: context.adapter.name.clone(),
    })
}

/// A primitive holds the index of its first word in 32 bits, less those of its flags.
fn check_attributes(context: &Context, prepared: &Prepared) -> Result<(), GpuError> {
    let needed = prepared.attributes.words.len() as u64;
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

fn check_size(context: &Context, what: &str, needed: u64) -> Result<(), GpuError> {
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

fn primitive_words(prepared: &Prepared) -> Vec<Word> {
    let mut light_of = vec![NONE; prepared.primitives.len()];
    for (light, emitter) in prepared.emitters.lights.iter().enumerate() {
        if let Emitter::Area { primitive, .. } = emitter {
            light_of[*primitive as usize] = light as u32;
        }
    }
    let attributes = prepared.attributes.of_primitive.iter();
    let words = prepared.primitives.iter().zip(&light_of).zip(attributes);
    words
        .flat_map(|((p, &light), a)| one_primitive(&prepared.scene, p, light, a))
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

/// Two ends of cells per word.
fn filter_words(table: &FilterTable) -> [[f32; 4]; FILTER_WORDS] {
    std::array::from_fn(|word| {
        let knot = |i: usize| table.knots.get(i).copied().unwrap_or([1.0, 0.0]);
        let ([a, b], [c, d]) = (knot(2 * word), knot(2 * word + 1));
        [a, b, c, d]
    })
}

/// The uniform that stays the same for a render; `environment_grid` are the cells of the environment's sampling grid.
pub fn frame(prepared: &Prepared, film: FilmSize, seed: u32, environment_grid: [u32; 2]) -> Frame {
    let camera = prepared.normalization.camera(&prepared.scene.camera);
    let half_height = camera.half_height();
    let f3 = |v: DVec3| v.as_vec3().to_array();
    let filter = prepared.scene.filter.table();
    let patterns = prepared.patterns();
    let shadow_grid = prepared.shadow_grid();
    let near_plane = prepared.near_plane();
    let mut frame = Frame {
        eye: f3(camera.eye + near_plane * camera.forward),
        width: film.width,
        right: f3(camera.right * (half_height * film.aspect())),
        height: film.height,
        up: f3(camera.up * half_height),
        seed,
        forward: f3(camera.forward),
        tiles_per_row: film.width.div_ceil(TILE),
        grid_origin: prepared.bvh.grid.origin.to_array(),
        root: prepared.bvh.root,
        grid_scale: prepared.bvh.grid.scale.to_array(),
        light_count: prepared.emitters.lights.len() as u32,
        far: (4.0 * prepared.normalization.reach) as f32,
        pattern: patterns.pixel,
        light_pattern: patterns.light,
        shadow_rays: shadow_grid.rays,
        shadow_columns: shadow_grid.columns,
        shadow_steps: shadow_grid.steps,
        max_specular_depth: prepared.scene.render.max_specular_depth,
        filter_cell: filter.cell_width,
        orthographic: u32::from(camera.is_orthographic()),
        lens_right: f3(camera.right * camera.lens.radius),
        inverse_focus_distance: if camera.lens.radius > 0.0 {
            (1.0 / camera.lens.focus_distance) as f32
        } else {
            0.0
        },
        lens_up: f3(camera.up * camera.lens.radius),
        near_plane: near_plane as f32,
        near_lens: if camera.lens.radius > 0.0 {
            (1.0 - near_plane / camera.lens.focus_distance) as f32
        } else {
            1.0
        },
        logarithmic_grid: u32::from(prepared.bvh.grid.logarithmic),
        filter_knots: filter_words(&filter),
        ..Frame::default()
    };
    for (words, &[x, y, z]) in frame.light_boxes.iter_mut().zip(&prepared.light_boxes) {
        *words = [x, y, z, 0];
    }
    let (first_sun, suns) = prepared.emitters.suns();
    frame.first_sun = first_sun as u32;
    frame.suns = suns as u32;
    frame.first_emission = first_emission_word(prepared);
    let tree = prepared.emitters.selection.as_ref();
    if let Some(tree) = tree.and_then(Selection::tree) {
        frame.light_grid_origin = tree.grid.origin;
        frame.light_grid_step = tree.grid.step;
        frame.tree_nodes = tree.nodes.len() as u32;
        frame.infinite_lights = tree.infinite.len() as u32;
    }
    if let Some(environment) = &prepared.scene.environment {
        let to_map = environment.rotation.transpose();
        let per_unit = 1.0 / prepared.emitters.unit;
        let row = |i: usize| f3(to_map.row(i));
        [
            frame.environment_x,
            frame.environment_y,
            frame.environment_z,
        ] = [row(0), row(1), row(2)];
        let index = prepared
            .emitters
            .lights
            .iter()
            .position(|l| *l == Emitter::Environment);
        frame.environment_selection = index.map_or(0.0, |i| prepared.light_samples(i)) as f32;
        match &environment.radiance {
            EnvironmentRadiance::Constant(radiance) => {
                frame.environment_radiance = f3(*radiance * environment.scale * per_unit);
            }
            EnvironmentRadiance::Map(map) => {
                frame.environment_radiance = [(environment.scale * per_unit) as f32; 3];
                [frame.environment_width, frame.environment_height] = [map.width, map.height];
                frame.environment_linear = u32::from(map.interpolation == Interpolation::Linear);
            }
        }
    }
    frame.environment_grid = environment_grid;
    frame
}
