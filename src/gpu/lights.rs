//! Lights as the GPU reads them: the formats of `shaders/scene/fetch.wesl` and of what lights are chosen by.

use super::layout::{
    LIGHT_DIRECTIONAL, LIGHT_DISK, LIGHT_ENVIRONMENT, LIGHT_GROUP_SHIFT, LIGHT_POINT,
    LIGHT_RECTANGLE, LIGHT_SPHERE, LIGHT_SPOT, LIGHT_TRIANGLE, SKEWED_BIT, TWO_SIDED_BIT,
};
use super::scene_buffers::{Word, bits, word};
use crate::accel::PrimitiveGeometry;
use crate::emitters::{Emitter, Selection};
use crate::render::Prepared;
use crate::scene::Light;
use crate::scene::alias_table::AliasTable;
use glam::DVec3;

/// See `SceneBuffers::light_choice`.
pub(super) fn choice_words(prepared: &Prepared) -> Vec<Word> {
    let samples = |index| prepared.light_samples(index);
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

/// Four words per light.
pub(super) fn light_words(prepared: &Prepared) -> Vec<Word> {
    let tree = prepared.emitters.selection.as_ref();
    let tree = tree.and_then(Selection::tree);
    let trail = |index: usize| tree.map_or(0, |tree| tree.trails[index]);
    let words = prepared
        .emitters
        .lights
        .iter()
        .enumerate()
        .flat_map(|(index, emitter)| {
            let samples = bits(prepared.light_samples(index));
            let mut words = match *emitter {
                Emitter::Area {
                    primitive,
                    radiance,
                    two_sided,
                } => area_light(
                    &prepared.primitives[primitive as usize].geometry,
                    radiance,
                    two_sided,
                    [samples, trail(index)],
                ),
                Emitter::Delta(light) => delta_light(&light, samples),
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
    words.collect()
}

fn area_light(
    geometry: &PrimitiveGeometry,
    radiance: DVec3,
    two_sided: bool,
    [samples, trail]: [u32; 2],
) -> [Word; 4] {
    let flag = |set: bool, bit: u32| if set { bit } else { 0 };
    let flags = flag(two_sided, TWO_SIDED_BIT) | flag(geometry.is_skewed(), SKEWED_BIT);
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
    };
    [
        word(a, kind | flags),
        word(u, samples),
        word(v, bits(geometry.area())),
        word(radiance, trail),
    ]
}

/// Largest reciprocal of a spot's falloff range: equal angles make a step.
const SPOT_STEP: f64 = 1_048_576.0;

fn delta_light(light: &Light, samples: u32) -> [Word; 4] {
    match *light {
        Light::Point {
            position,
            intensity,
        } => [
            word(position, LIGHT_POINT),
            word(DVec3::ZERO, samples),
            [0; 4],
            word(intensity, 0),
        ],
        Light::Spot {
            position,
            direction,
            intensity,
            inner_angle,
            outer_angle,
        } => {
            let (inner, outer) = (inner_angle.cos(), outer_angle.cos());
            let inv_range = (1.0 / (inner - outer).max(1.0 / SPOT_STEP)).min(SPOT_STEP);
            [
                word(position, LIGHT_SPOT),
                word(direction, samples),
                word(DVec3::new(outer, inv_range, 0.0), 0),
                word(intensity, 0),
            ]
        }
        Light::Directional {
            direction,
            irradiance,
        } => [
            word(-direction, LIGHT_DIRECTIONAL),
            word(DVec3::ZERO, samples),
            [0; 4],
            word(irradiance, 0),
        ],
    }
}

/// Threshold, alias, and `density` of the index itself and of its alias.
pub(super) fn alias_words(table: &AliasTable, density: impl Fn(usize) -> f64) -> Vec<Word> {
    let words = table.entries.iter().enumerate().map(|(i, e)| {
        let p = |i: usize| bits(density(i));
        [e.threshold, e.alias, p(i), p(e.alias as usize)]
    });
    words.collect()
}
