//! Materials as the GPU reads them: the formats of `shaders/scene/fetch.wesl`, `textured.wesl` and `texture.wesl`.

use super::layout::{NEAREST_BIT, NONE, WRAP_CLAMP, WRAP_MIRROR, WRAP_REPEAT};
use super::scene_buffers::{Word, bits, word};
use super::textures::Atlas;
use crate::scene::light::Interpolation;
use crate::scene::{Bsdf, Material, Scene, TextureUse, Wrap};
use glam::DVec3;

/// Two words per material; behind them three per textured one, and three per use of a texture. `colors` and `data` tell
/// where textures lie.
pub(super) fn material_words(scene: &Scene, [colors, data]: [&Atlas; 2]) -> Vec<Word> {
    let mut words: Vec<Word> = Vec::new();
    for material in &scene.materials {
        let p = material.bsdf.parameters();
        let (f0, alpha) = p.specular.map_or((DVec3::ZERO, 0.0), |s| (s.f0, s.alpha));
        words.extend([word(p.diffuse, bits(alpha)), word(f0, NONE)]);
    }
    let textured = scene.materials.iter().enumerate();
    for (index, material) in textured.filter(|(_, m)| m.textures.any()) {
        let first = words.len() as u32;
        words[2 * index + 1][3] = first;
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
        words[first as usize + 2] = indices;
    }
    words
}

/// A material as a case of the metallic-roughness model: base colour and roughness, F₀ of the dielectric and metallic, and
/// room for the indices of its textures. The roughness of a Lambert material is −1: it has no microfacets.
fn textured_words(material: &Material) -> [Word; 3] {
    let (color, roughness, f0, metallic) = match material.bsdf {
        Bsdf::Lambert { reflectance } => (reflectance, -1.0, 0.0, 0.0),
        Bsdf::Conductor { reflectance, alpha } => (reflectance, alpha.sqrt(), 0.0, 1.0),
        Bsdf::MetallicRoughness {
            base_color,
            metallic,
            roughness,
        } => (base_color, roughness, Bsdf::DIELECTRIC_F0, metallic),
    };
    [
        word(color, bits(roughness)),
        word(DVec3::splat(f0), bits(metallic)),
        [0; 4],
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
    let modes = mode(used.wrap[0]) | mode(used.wrap[1]) << 2 | nearest;
    [
        word(row(0), pair([texture.width, texture.height])),
        word(row(1), pair(place.origin)),
        [place.layer, modes, 0, 0],
    ]
}
