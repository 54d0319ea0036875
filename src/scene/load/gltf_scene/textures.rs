//! Textures: images with their samplers and KHR_texture_transform.

use super::document::Document;
use crate::error::InputError;
use crate::scene::light::Interpolation;
use crate::scene::load::texture::{Meaning, Textures};
use crate::scene::{TextureUse, Wrap};
use glam::{DAffine2, DMat2, DVec2};
use gltf::json;
use gltf::json::extensions::texture::TextureTransform;
use gltf::json::texture::{MagFilter, WrappingMode};
use gltf::json::validation::Checked;

/// What a material says about one of its textures.
pub(super) struct Named {
    /// Its name in the file, `normalTexture`.
    pub(super) slot: &'static str,
    /// Index of the texture.
    texture: usize,
    /// Index of the texture coordinates that it is read with.
    pub(super) coordinates: u32,
    transform: Option<TextureTransform>,
}

impl Named {
    fn new(
        slot: &'static str,
        texture: usize,
        coordinates: u32,
        transform: Option<TextureTransform>,
    ) -> Self {
        let own = transform.as_ref().and_then(|t| t.tex_coord);
        Self {
            slot,
            texture,
            coordinates: own.unwrap_or(coordinates),
            transform,
        }
    }

    fn of_info(slot: &'static str, info: &json::texture::Info) -> Self {
        let extensions = info.extensions.as_ref();
        let transform = extensions.and_then(|e| e.texture_transform.clone());
        Self::new(slot, info.index.value(), info.tex_coord, transform)
    }

    /// The texture of what `material` emits, where it emits.
    pub(super) fn of_emission(material: &json::Material) -> Option<Self> {
        let emits = material.emissive_factor.0.iter().any(|&c| c > 0.0);
        let texture = material.emissive_texture.as_ref().filter(|_| emits);
        texture.map(|i| Self::of_info("emissiveTexture", i))
    }

    /// All that are read.
    pub(super) fn all(material: &json::Material) -> impl Iterator<Item = Self> {
        let emission = Self::of_emission(material);
        Self::of_material(material)
            .into_iter()
            .chain([emission])
            .flatten()
    }

    /// Those of how `material` scatters: colour, metallic and roughness, normal map.
    pub(super) fn of_material(material: &json::Material) -> [Option<Self>; 3] {
        let pbr = &material.pbr_metallic_roughness;
        let color = pbr.base_color_texture.as_ref();
        let rough = pbr.metallic_roughness_texture.as_ref();
        let normal = material.normal_texture.as_ref().map(|n| {
            let extensions = n.extensions.as_ref();
            let value = extensions.and_then(|e| e.others.get("KHR_texture_transform"));
            let transform = value.and_then(|v| serde_json::from_value(v.clone()).ok());
            Self::new("normalTexture", n.index.value(), n.tex_coord, transform)
        });
        [
            color.map(|i| Self::of_info("baseColorTexture", i)),
            rough.map(|i| Self::of_info("metallicRoughnessTexture", i)),
            normal,
        ]
    }

    /// Index of the texture coordinates that the textures of `material` are read with: a mesh carries one.
    pub(super) fn coordinates_of(material: &json::Material) -> u32 {
        Self::all(material).next().map_or(0, |n| n.coordinates)
    }
}

/// The texture that `named`, of the material `material`, says.
pub(super) fn texture_use(
    document: &Document,
    named: &Named,
    material: &str,
    meaning: Meaning,
    textures: &mut Textures,
) -> Result<TextureUse, InputError> {
    let root = &document.root;
    let texture = document.get(&root.textures, named.texture, "texture", || {
        format!("{material}.{}.index", named.slot)
    })?;
    let field = format!("textures[{}]", named.texture);
    let image = texture.source.value();
    let json = document.get(&root.images, image, "image", || format!("{field}.source"))?;
    let id = textures.get(&document.image_name(image, json), None, meaning, || {
        document.image(image, json)
    })?;
    let (wrap, interpolation) = match texture.sampler {
        None => ([Wrap::Repeat; 2], Interpolation::Linear),
        Some(index) => {
            let field = || format!("{field}.sampler");
            sampling(document.get(&root.samplers, index.value(), "sampler", field)?)
        }
    };
    let transform = transform(named.transform.as_ref());
    if !transform.is_finite() {
        let field = format!("{material}.{}.extensions.KHR_texture_transform", named.slot);
        return Err(document.error(field, "is not finite", "finite numbers"));
    }
    Ok(TextureUse {
        texture: id,
        transform,
        wrap,
        interpolation,
    })
}

fn sampling(sampler: &json::texture::Sampler) -> ([Wrap; 2], Interpolation) {
    let wrap = |mode: Checked<WrappingMode>| match mode {
        Checked::Valid(WrappingMode::ClampToEdge) => Wrap::Clamp,
        Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::Mirror,
        _ => Wrap::Repeat,
    };
    let nearest = sampler.mag_filter == Some(Checked::Valid(MagFilter::Nearest));
    let interpolation = if nearest {
        Interpolation::Nearest
    } else {
        Interpolation::Linear
    };
    ([wrap(sampler.wrap_s), wrap(sampler.wrap_t)], interpolation)
}

/// KHR_texture_transform: scale, then rotation, then offset. The specification's listing turns the wrong way; its text and
/// the sample model turn counter-clockwise with v pointing down (KhronosGroup/glTF#1563).
fn transform(transform: Option<&TextureTransform>) -> DAffine2 {
    let Some(t) = transform else {
        return DAffine2::IDENTITY;
    };
    let (sin, cos) = f64::from(t.rotation.0).sin_cos();
    let turn = DMat2::from_cols(DVec2::new(cos, -sin), DVec2::new(sin, cos));
    let scale = DMat2::from_diagonal(DVec2::from_array(t.scale.0.map(f64::from)));
    let offset = DVec2::from_array(t.offset.0.map(f64::from));
    DAffine2::from_mat2_translation(turn * scale, offset)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn textures_are_scaled_then_turned_then_moved() {
        let json = r#"{"rotation": 1.5707963267948966, "scale": [2, 3], "offset": [0.5, 0.25]}"#;
        let parsed: TextureTransform = serde_json::from_str(json).unwrap();
        let transform = transform(Some(&parsed));
        for (uv, expected) in [
            (DVec2::ZERO, DVec2::new(0.5, 0.25)),
            (DVec2::X, DVec2::new(0.5, -1.75)),
            (DVec2::Y, DVec2::new(3.5, 0.25)),
        ] {
            let got = transform.transform_point2(uv);
            assert!(got.distance(expected) < 1e-6, "{uv}: {got}");
        }
    }
}
