//! Materials as the GPU reads them: the formats of `shaders/scene/fetch.wesl`, `textured.wesl` and
//! `texture.wesl`.

use super::layout::{
    COMPENSATED_BIT, FRESNEL_CONDUCTOR, FRESNEL_CONSTANT, FRESNEL_DIELECTRIC, FRESNEL_SCHLICK,
    MATERIAL_WORDS, NEAREST_BIT, NONE, SECOND_UVS_BIT, TEXTURED_WORDS, THIN_BIT, UNLIT_BIT,
    WRAP_CLAMP, WRAP_MIRROR, WRAP_REPEAT,
};
use super::scene_buffers::{Word, bits, word};
use super::textures::Atlas;
use crate::prepare::Prepared;
use crate::scene::environment::Interpolation;
use crate::scene::material::{BsdfParameters, Fresnel};
use crate::scene::{Bsdf, Geometry, Material, Scene, TextureUse, Wrap};
use glam::DVec3;

/// In place of a roughness: a colour alone is multiplied.
const MODEL_COLOR: f64 = -1.0;
/// Glass of which a texture makes metal in parts.
const MODEL_MASK: f64 = -2.0;
/// The specular-glossiness model.
const MODEL_GLOSSINESS: f64 = -3.0;

/// Words of materials and textures.
pub(super) struct MaterialWords {
    /// [`MATERIAL_WORDS`] per material; behind them [`TEXTURED_WORDS`] per one that varies, and
    /// three per use of a texture.
    pub(super) words: Vec<Word>,
    /// Per shape, the word at which the texture of what it emits begins; [`NONE`] where it has
    /// none.
    pub(super) emission: Vec<u32>,
}

/// The materials of `prepared`. The atlases of colours and of other numbers tell where textures
/// lie.
pub(super) fn material_words(prepared: &Prepared, [colors, data]: [&Atlas; 2]) -> MaterialWords {
    let scene = &prepared.data.scene;
    let materials = scene.materials.iter();
    let mut words: Vec<Word> = materials
        .flat_map(|m| {
            one_material(
                &m.bsdf.parameters(),
                prepared.settings.estimator.energy_compensation,
            )
        })
        .collect();
    let colored = under_vertex_colors(scene);
    let varied = scene.materials.iter().enumerate();
    for (index, material) in varied.filter(|(i, m)| colored[*i] || has_more_words(m)) {
        let first = words.len() as u32;
        words[index * MATERIAL_WORDS as usize + MATERIAL_WORDS as usize - 1][3] = first;
        words.extend(textured_words(material));
        let mut add = |texture: Option<TextureUse>, atlas: &Atlas| match texture {
            None => NONE,
            Some(texture) => {
                let at = words.len() as u32;
                words.extend(texture_words(scene, &texture, atlas));
                at
            }
        };
        let maps = &material.textures;
        let normal = maps.normal.map(|map| map.texture);
        let scale = maps.normal.map_or(1.0, |map| map.scale);
        let indices = [
            add(maps.color, colors),
            add(maps.metallic_roughness, data),
            add(normal, data),
            bits(scale),
        ];
        let opacity = &material.opacity;
        // −1 stands for no cutoff.
        let cutoff = opacity.cutoff.unwrap_or(-1.0);
        let opacity = [
            bits(opacity.factor),
            bits(cutoff),
            add(opacity.texture, colors),
        ];
        if let Some(texture) = maps.specular_glossiness {
            words[first as usize + 1][3] = add(Some(texture), colors);
        }
        words[first as usize + 2] = indices;
        words[first as usize + 3][1..].copy_from_slice(&opacity);
    }
    let emission = scene.shapes.iter().map(|shape| {
        let Some(texture) = shape.emission.and_then(|e| e.texture) else {
            return NONE;
        };
        let at = words.len() as u32;
        words.extend(texture_words(scene, &texture, colors));
        at
    });
    let emission = emission.collect();
    MaterialWords { words, emission }
}

/// Per material, whether a mesh with vertex colours has it.
fn under_vertex_colors(scene: &Scene) -> Vec<bool> {
    let mut colored = vec![false; scene.materials.len()];
    for shape in &scene.shapes {
        if matches!(&shape.geometry, Geometry::Mesh(mesh) if !mesh.colors.is_empty()) {
            colored[shape.material.index()] = true;
        }
    }
    colored
}

fn has_more_words(material: &Material) -> bool {
    material.texture_uses().next().is_some() || material.opacity.untextured() < 1.0
}

fn one_material(p: &BsdfParameters, compensated: bool) -> [Word; MATERIAL_WORDS as usize] {
    let none = Fresnel::Schlick {
        f0: DVec3::ZERO,
        f90: 0.0,
    };
    let fresnel = p.specular.map_or(none, |s| s.fresnel);
    let (kind, f0, f90, k) = match fresnel {
        Fresnel::Constant(reflectance) => (FRESNEL_CONSTANT, reflectance, 0.0, DVec3::ZERO),
        Fresnel::Schlick { f0, f90 } => (FRESNEL_SCHLICK, f0, f90, DVec3::ZERO),
        Fresnel::Dielectric { .. } => (FRESNEL_DIELECTRIC, DVec3::ZERO, 0.0, DVec3::ZERO),
        Fresnel::Conductor { eta, k } => (FRESNEL_CONDUCTOR, eta, 0.0, k),
    };
    let ior = match (p.transmission, fresnel) {
        (Some(t), _) => t.ior,
        (None, Fresnel::Dielectric { ior }) => ior,
        (None, _) => 1.0,
    };
    let thin = p.transmission.is_some_and(|t| t.thin);
    let flag = |set: bool, bit: u32| if set { bit } else { 0 };
    let transmittance = p.transmission.map_or(DVec3::ZERO, |t| t.transmittance);
    [
        word(p.diffuse, bits(p.specular.map_or(0.0, |s| s.alpha))),
        word(f0, bits(f90)),
        word(
            k,
            kind | flag(thin, THIN_BIT)
                | flag(compensated, COMPENSATED_BIT)
                | flag(p.unlit, UNLIT_BIT),
        ),
        word(transmittance, bits(ior)),
        word(p.specular.map_or(DVec3::ZERO, |s| s.average), NONE),
    ]
}

/// What the textures of a material and vertex colours are factors on: base colour and roughness; F₀
/// of the dielectric and metallic; room for the indices of the textures; F₉₀ of the dielectric, and
/// room for the opacity. A conductor is a metal of the metallic-roughness model here. The roughness
/// of what is no case of it is one of `MODEL_…`: under `MODEL_COLOR` a colour alone counts, under
/// `MODEL_MASK` the roughness of the metal stands in place of F₉₀, and under `MODEL_GLOSSINESS`
/// diffuse colour, F₀, room for the index of the texture in place of metallic, and the glossiness
/// in place of F₉₀.
fn textured_words(material: &Material) -> [Word; TEXTURED_WORDS as usize] {
    let (color, roughness, f0, metallic, f90) = match material.bsdf {
        Bsdf::Conductor { reflectance, alpha } => {
            (reflectance, alpha.sqrt(), DVec3::ZERO, 1.0, 1.0)
        }
        Bsdf::MetallicRoughness {
            base_color,
            metallic,
            roughness,
            layer,
        } if layer.metal_mask => (base_color, MODEL_MASK, DVec3::ZERO, metallic, roughness),
        Bsdf::SpecularGlossiness {
            diffuse,
            specular,
            glossiness,
            ..
        } if material.textures.specular_glossiness.is_some() => {
            (diffuse, MODEL_GLOSSINESS, specular, 0.0, glossiness)
        }
        Bsdf::MetallicRoughness {
            base_color,
            metallic,
            roughness,
            layer,
        } if layer.transmission * (1.0 - metallic) <= 0.0 => {
            (base_color, roughness, layer.f0(), metallic, layer.specular)
        }
        _ => (DVec3::ONE, MODEL_COLOR, DVec3::ZERO, 0.0, 0.0),
    };
    [
        word(color, bits(roughness)),
        word(f0, bits(metallic)),
        [0; 4],
        word(DVec3::splat(f90), 0),
    ]
}

fn texture_words(scene: &Scene, used: &TextureUse, atlas: &Atlas) -> [Word; 3] {
    let texture = &scene.textures[used.texture.index()];
    let place = atlas.places[&used.texture];
    let row = |i: usize| {
        let m = used.transform.matrix2;
        DVec3::new(m.x_axis[i], m.y_axis[i], used.transform.translation[i])
    };
    let mode = |wrap: Wrap| match wrap {
        Wrap::Repeat => WRAP_REPEAT,
        Wrap::Mirror => WRAP_MIRROR,
        Wrap::Clamp => WRAP_CLAMP,
    };
    let nearest = match used.interpolation {
        Interpolation::Nearest => NEAREST_BIT,
        Interpolation::Linear => 0,
    };
    let pair = |[x, y]: [u32; 2]| x | y << 16;
    let second = if used.second_uvs { SECOND_UVS_BIT } else { 0 };
    let modes = mode(used.wrap[0]) | mode(used.wrap[1]) << 2 | nearest | second;
    [
        word(row(0), pair([texture.width, texture.height])),
        word(row(1), pair(place.origin)),
        [place.layer, modes, 0, 0],
    ]
}
