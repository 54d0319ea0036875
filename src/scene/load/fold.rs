//! What varies nothing becomes a factor, and what textures make of glass.

use crate::scene::{Bsdf, Material, Shape, Texture, TextureUse};
use glam::DVec3;

/// Folds textures of one value and normal maps that are flat. Returns what is to be said.
pub(super) fn fold_constant(materials: &mut [Material], textures: &[Texture]) -> Vec<String> {
    let mut warnings = Vec::new();
    for material in materials {
        let maps = &mut material.textures;
        let constant = |u: &Option<TextureUse>| textures[u.as_ref()?.texture.index()].constant();
        if let Some(value) = constant(&maps.color) {
            material.bsdf.scale_color(value);
            maps.color = None;
        }
        if let Some(value) = constant(&maps.metallic_roughness) {
            material.bsdf.scale_metallic_roughness(value.z, value.y);
            maps.metallic_roughness = None;
        }
        // Half lies between 127 and 128: either is meant by it.
        let flat = |value: DVec3| {
            let off = value - DVec3::new(0.5, 0.5, 1.0);
            off.abs().max_element() <= 0.6 / 255.0
        };
        let normal = maps.normal.map(|map| map.texture);
        if constant(&normal).is_some_and(flat) {
            maps.normal = None;
        }
        fold_specular_glossiness(material, textures);
        warnings.extend(fold_glass(material, textures));
    }
    warnings
}

/// A specular-glossiness texture of one value becomes a factor.
fn fold_specular_glossiness(material: &mut Material, textures: &[Texture]) {
    let map = &mut material.textures.specular_glossiness;
    let texture = map.map(|used| &textures[used.texture.index()]);
    let constant = texture.and_then(|t| Some((t.constant()?, t.alpha_range())));
    if let Some((specular, [least, most])) = constant
        && least >= most
    {
        material.bsdf.scale_specular_glossiness(specular, least);
        *map = None;
    }
    if let Bsdf::SpecularGlossiness { textured, .. } = &mut material.bsdf {
        *textured = map.is_some();
    }
}

/// What metallic, whose texture varies or which is a factor, makes of glass: where something
/// passes, roughness does not count, and a point is metal or it is not.
fn fold_glass(material: &mut Material, textures: &[Texture]) -> Option<String> {
    let Bsdf::MetallicRoughness {
        metallic, layer, ..
    } = &mut material.bsdf
    else {
        return None;
    };
    if layer.transmission <= 0.0 {
        return None;
    }
    let map = &mut material.textures.metallic_roughness;
    let [least, most] = map.map_or([1.0; 2], |used| textures[used.texture.index()].range(2));
    let [least, most] = [least, most].map(|factor| factor * *metallic);
    let name = &material.name;
    if least >= most {
        if most < 1.0 {
            *metallic = most;
            *map = None;
        }
        let mixed = most > 0.0 && most < 1.0;
        return mixed.then(|| {
            format!("materials.{name}: metallic is {most:.3} beside transmission: the metal's part is left out")
        });
    }
    if most < 0.5 {
        *metallic = 0.0;
        *map = None;
        return Some(format!(
            "materials.{name}: metallic varies up to {most:.3} beside transmission: the metal's part is left out"
        ));
    }
    layer.metal_mask = true;
    Some(format!(
        "materials.{name}: metallic varies over glass: a point is metal where it is at least 0.5, and glass elsewhere"
    ))
}

/// The same for what shapes emit: a texture of one value becomes a factor on the radiance.
pub(super) fn fold_constant_emission(shapes: &mut [Shape], textures: &[Texture]) {
    let emissions = shapes.iter_mut().filter_map(|s| s.emission.as_mut());
    for emission in emissions {
        let texture = emission.texture.map(|u| &textures[u.texture.index()]);
        if let Some(value) = texture.and_then(Texture::constant) {
            emission.radiance *= value;
            emission.texture = None;
        }
    }
}
