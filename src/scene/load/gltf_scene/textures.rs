//! Textures: images with their samplers and KHR_texture_transform.

use super::document::Document;
use crate::error::InputError;
use crate::scene::environment::Interpolation;
use crate::scene::load::texture::{Meaning, Textures};
use crate::scene::{TextureUse, Wrap};
use glam::{DAffine2, DMat2, DVec2};
use gltf::json;
use gltf::json::extensions::material::PbrSpecularGlossiness;
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
    /// Whether these are the second ones of the mesh.
    pub(super) second_uvs: bool,
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
            second_uvs: false,
            transform,
        }
    }

    pub(super) fn of_info(slot: &'static str, info: &json::texture::Info) -> Self {
        let extensions = info.extensions.as_ref();
        let transform = extensions.and_then(|e| e.texture_transform.clone());
        Self::new(slot, info.index.value(), info.tex_coord, transform)
    }

    /// The texture of what `material` emits, where it emits.
    pub(super) fn of_emission(material: &json::Material) -> Option<Self> {
        if is_unlit(material) {
            return None;
        }
        let emits = material.emissive_factor.0.iter().any(|&c| c > 0.0);
        let texture = material.emissive_texture.as_ref().filter(|_| emits);
        texture.map(|i| Self::of_info("emissiveTexture", i))
    }

    /// All that are read.
    pub(super) fn all(material: &json::Material) -> impl Iterator<Item = Self> {
        let emission = Self::of_emission(material);
        let glossiness = Self::of_specular_glossiness(material);
        Self::of_material(material)
            .into_iter()
            .chain([glossiness, emission])
            .flatten()
    }

    /// The texture of F₀ and glossiness.
    pub(super) fn of_specular_glossiness(material: &json::Material) -> Option<Self> {
        let info = specular_glossiness(material)?
            .specular_glossiness_texture
            .as_ref()?;
        let slot = "extensions.KHR_materials_pbrSpecularGlossiness.specularGlossinessTexture";
        Some(Self::of_info(slot, info))
    }

    /// Those of how `material` scatters: colour, metallic and roughness, normal map.
    pub(super) fn of_material(material: &json::Material) -> [Option<Self>; 3] {
        let pbr = &material.pbr_metallic_roughness;
        if is_unlit(material) {
            let color = pbr.base_color_texture.as_ref();
            return [
                color.map(|i| Self::of_info("baseColorTexture", i)),
                None,
                None,
            ];
        }
        let color = pbr.base_color_texture.as_ref();
        let rough = pbr.metallic_roughness_texture.as_ref();
        let normal = material.normal_texture.as_ref().map(|n| {
            let extensions = n.extensions.as_ref();
            let value = extensions.and_then(|e| e.others.get("KHR_texture_transform"));
            let transform = value.and_then(|v| serde_json::from_value(v.clone()).ok());
            Self::new("normalTexture", n.index.value(), n.tex_coord, transform)
        });
        if let Some(glossy) = specular_glossiness(material) {
            let slot = "extensions.KHR_materials_pbrSpecularGlossiness.diffuseTexture";
            let diffuse = glossy.diffuse_texture.as_ref();
            return [diffuse.map(|i| Self::of_info(slot, i)), None, normal];
        }
        [
            color.map(|i| Self::of_info("baseColorTexture", i)),
            rough.map(|i| Self::of_info("metallicRoughnessTexture", i)),
            normal,
        ]
    }
}

/// Whether `material` shows its colour whatever lights there are.
pub(super) fn is_unlit(material: &json::Material) -> bool {
    let extensions = material.extensions.as_ref();
    extensions.is_some_and(|e| e.unlit.is_some())
}

/// The model that `material` has in place of metallic and roughness, unless it is unlit.
pub(super) fn specular_glossiness(material: &json::Material) -> Option<&PbrSpecularGlossiness> {
    let extensions = material.extensions.as_ref();
    let glossy = extensions.and_then(|e| e.pbr_specular_glossiness.as_ref());
    glossy.filter(|_| !is_unlit(material))
}

/// Extensions that give a texture another image, of which the first is read.
const IMAGES: [(&str, bool); 3] = [
    ("EXT_texture_webp", true),
    ("KHR_texture_basisu", false),
    ("MSFT_texture_dds", false),
];

/// The image of texture `index`, and the field that names it. `None` where it has none that is
/// read: then the texture is undefined (glTF 2.0, section 5.29.2).
fn source(
    index: usize,
    texture: &json::Texture,
    textures: &mut Textures,
    file: &str,
) -> Option<(usize, String)> {
    let extensions = texture.extensions.as_ref();
    let of = |name: &str| extensions.and_then(|e| e.others.get(name));
    for (name, _) in IMAGES.into_iter().filter(|(_, is_read)| *is_read) {
        let image = of(name).and_then(|e| e.get("source")?.as_u64());
        if let Some(image) = image {
            let field = format!("textures[{index}].extensions.{name}.source");
            return Some((usize::try_from(image).unwrap_or(usize::MAX), field));
        }
    }
    // What the crate reads where the field is missing.
    const NONE: usize = u32::MAX as usize;
    let image = texture.source.value();
    if image != NONE {
        return Some((image, format!("textures[{index}].source")));
    }
    let known = IMAGES.map(|(name, _)| name);
    let named = known.into_iter().find(|name| of(name).is_some());
    let other = extensions.and_then(|e| e.others.keys().next());
    let why = match named.or(other.map(String::as_str)) {
        Some(name) => format!("its image is that of the extension {name}, which is not supported"),
        None => "it has no image".to_owned(),
    };
    textures.warn(format!(
        "{file}: textures[{index}] is left out, factors are used: {why}"
    ));
    None
}

/// The texture that `named`, of the material `material`, says; `None` where it has no image that is
/// read.
pub(super) fn texture_use(
    document: &Document,
    named: &Named,
    material: &str,
    meaning: Meaning,
    textures: &mut Textures,
) -> Result<Option<TextureUse>, InputError> {
    let root = &document.root;
    let texture = document.get(&root.textures, named.texture, "texture", || {
        format!("{material}.{}.index", named.slot)
    })?;
    let field = format!("textures[{}]", named.texture);
    let file = document.file_name();
    let Some((image, source)) = source(named.texture, texture, textures, &file) else {
        return Ok(None);
    };
    let json = document.get(&root.images, image, "image", || source)?;
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
    Ok(Some(TextureUse {
        texture: id,
        transform,
        wrap,
        interpolation,
        second_uvs: named.second_uvs,
    }))
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

/// KHR_texture_transform: scale, then rotation, then offset. The specification's listing turns the
/// wrong way; its text and the sample model turn counter-clockwise with v pointing down
/// (KhronosGroup/glTF#1563).
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
