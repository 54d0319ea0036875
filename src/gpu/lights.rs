//! Lights as the GPU reads them: the formats of `shaders/scene/fetch.wesl` and of what lights are
//! chosen by.

use super::layout::{
    EMISSION_SHIFT, EMISSION_WORDS, LIGHT_DISK, LIGHT_ENVIRONMENT, LIGHT_GROUP_SHIFT,
    LIGHT_RECTANGLE, LIGHT_SPHERE, LIGHT_TRIANGLE, LIGHT_WORDS, NONE, SKEWED_BIT, TWO_SIDED_BIT,
};
use super::scene_buffers::{Word, bits, word};
use crate::accel::PrimitiveGeometry;
use crate::effects::Effect;
use crate::emitters::{EmissionMap, Emitter, Selection};
use crate::prepare::Prepared;
use crate::scene::Light;
use crate::scene::alias_table::AliasTable;
use glam::DVec3;

/// See `SceneBuffers::light_choice`.
pub(super) fn choice_words(prepared: &Prepared) -> Vec<Word> {
    let samples = |index| prepared.emitters.probability(index);
    match &prepared.emitters.selection {
        Some(Selection::One(table)) => alias_words(table, samples),
        Some(Selection::Tree(tree)) => {
            let outside = tree.infinite.iter().map(|&index| [index, 0, 0, 0]);
            let nodes = tree.nodes.iter().copied().flatten();
            nodes.chain(outside).collect()
        }
        Some(Selection::All(_)) | None => Vec::new(),
    }
}

/// [`LIGHT_WORDS`] per light; behind them, where lights have an opacity, the primitive of each that
/// has one; then [`EMISSION_WORDS`] per map of emission. `textures` tells per shape at which word
/// of the materials the texture of its emission begins.
pub(super) fn light_words(prepared: &Prepared, textures: &[u32]) -> Vec<Word> {
    let tree = prepared.emitters.selection.as_ref();
    let tree = tree.and_then(Selection::tree);
    let trail = |index: usize| tree.map_or(0, |tree| tree.trails[index]);
    let per_unit = 1.0 / prepared.emitters.unit;
    let lights = prepared.emitters.lights.iter().enumerate();
    let words = lights.flat_map(|(index, emitter)| {
        let samples = bits(samples_per_ray(prepared, index));
        let mut words = match *emitter {
            Emitter::Area {
                primitive,
                radiance,
                two_sided,
                map,
            } => {
                let mut words = area_light(
                    &prepared.data.primitives[primitive as usize].geometry,
                    radiance * per_unit,
                    two_sided,
                    [samples, trail(index)],
                );
                words[0][3] |= map.map_or(0, |map| map + 1) << EMISSION_SHIFT;
                words
            }
            Emitter::Delta(light) => surfaceless_light(light, per_unit, samples),
            Emitter::Sun(sun) => surfaceless_light(Light::Sun(sun), per_unit, samples),
            Emitter::Environment => [
                [0, 0, 0, LIGHT_ENVIRONMENT],
                [0, 0, 0, samples],
                [0; 4],
                [0; 4],
            ],
        };
        words[0][3] |= prepared.emitters.groups.of_light(index) << LIGHT_GROUP_SHIFT;
        words
    });
    let opacities = prepared.effects.contains(Effect::AlphaLights);
    let primitives = prepared.emitters.lights.iter().filter(|_| opacities);
    let primitives = primitives.map(|emitter| match emitter {
        Emitter::Area { primitive, .. }
            if prepared.data.attributes.of_primitive[*primitive as usize].opacity =>
        {
            [*primitive, 0, 0, 0]
        }
        _ => [NONE, 0, 0, 0],
    });
    let maps = prepared.emitters.maps.iter();
    let maps = maps.flat_map(|map| emission_words(map, textures[map.shape.index()]));
    words.chain(primitives).chain(maps).collect()
}

/// See `LightRecord.samples_per_ray`.
fn samples_per_ray(prepared: &Prepared, index: usize) -> f64 {
    let samples = prepared.emitters.probability(index);
    if prepared.emitters.takes_one(index) {
        -samples
    } else {
        samples
    }
}

/// The word of the lights at which the maps of emission begin.
pub(super) fn first_emission_word(prepared: &Prepared) -> u32 {
    let opacities = prepared.effects.contains(Effect::AlphaLights);
    (LIGHT_WORDS + u32::from(opacities)) * prepared.emitters.lights.len() as u32
}

fn emission_words(map: &EmissionMap, texture: u32) -> [Word; EMISSION_WORDS as usize] {
    let [a, b, c] = map.uvs.map(|uv| uv.map(f32::to_bits));
    [
        [a[0], a[1], b[0], b[1]],
        [c[0], c[1], texture, map.first_cell],
        [map.grid[0], map.grid[1], 0, 0],
    ]
}

/// One word per cell of the maps of emission.
pub(super) fn emission_cell_words(prepared: &Prepared) -> Vec<Word> {
    let maps = prepared.emitters.maps.iter();
    let words = maps.flat_map(|m| alias_words(&m.table, |cell| m.table.probability[cell]));
    words.collect()
}

fn area_light(
    geometry: &PrimitiveGeometry,
    radiance: DVec3,
    two_sided: bool,
    [samples, trail]: [u32; 2],
) -> [Word; 4] {
    let flag = |set: bool, bit: u32| if set { bit } else { 0 };
    let ellipsoid = matches!(geometry, PrimitiveGeometry::Ellipsoid { .. });
    let skewed = geometry.is_skewed() || ellipsoid;
    let flags = flag(two_sided, TWO_SIDED_BIT) | flag(skewed, SKEWED_BIT);
    let (kind, a, u, v) = match *geometry {
        PrimitiveGeometry::Triangle { a, u, v } => (LIGHT_TRIANGLE, a, u, v),
        PrimitiveGeometry::Rectangle { a, u, v } => (LIGHT_RECTANGLE, a, u, v),
        PrimitiveGeometry::Disk { a, u, v } => (LIGHT_DISK, a, u, v),
        PrimitiveGeometry::Sphere { center, radius } => (
            LIGHT_SPHERE,
            center,
            DVec3::new(radius, 0.0, 0.0),
            DVec3::ZERO,
        ),
        PrimitiveGeometry::Ellipsoid {
            center,
            radii,
            rodrigues,
        } => (LIGHT_SPHERE, center, radii, rodrigues),
    };
    [
        word(a, kind | flags),
        word(u, samples),
        word(v, bits(geometry.area())),
        word(radiance, trail),
    ]
}

fn surfaceless_light(mut light: Light, per_unit: f64, samples: u32) -> [Word; 4] {
    *light.strength_mut() *= per_unit;
    let record = light.record();
    let [a, u, v] = record.vectors;
    [
        word(a, record.kind),
        word(u, samples),
        word(v, 0),
        word(record.radiance, 0),
    ]
}

/// Threshold, alias, and `density` of the index itself and of its alias.
pub(super) fn alias_words(table: &AliasTable, density: impl Fn(usize) -> f64) -> Vec<Word> {
    let words = table.entries.iter().enumerate().map(|(i, e)| {
        let p = |i: usize| bits(density(i));
        [e.threshold, e.alias, p(i), p(e.alias as usize)]
    });
    words.collect()
}
