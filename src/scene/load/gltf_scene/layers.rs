//! Textures of the extensions about the dielectric: one of a single value is a factor; others are
//! left out, each by name.

use super::document::Document;
use super::textures::{Named, texture_use};
use crate::error::InputError;
use crate::scene::TextureUse;
use crate::scene::load::texture::{Meaning, Textures};
use crate::scene::material::DielectricLayer;
use gltf::json;

/// Multiplies the factors of `layer` by the textures of the material `name` that vary nothing, and
/// names the others.
pub(super) fn fold(
    document: &Document,
    json: &json::Material,
    name: &str,
    layer: &mut DielectricLayer,
    textures: &mut Textures,
) -> Result<(), InputError> {
    let Some(extensions) = &json.extensions else {
        return Ok(());
    };
    let transmission = extensions.transmission.as_ref();
    let specular = extensions.specular.as_ref();
    let mut read = |slot, info: Option<&json::texture::Info>, meaning| match info {
        Some(info) => texture_use(
            document,
            &Named::of_info(slot, info),
            name,
            meaning,
            textures,
        ),
        None => Ok(None),
    };
    let slots = [
        "extensions.KHR_materials_transmission.transmissionTexture",
        "extensions.KHR_materials_specular.specularTexture",
        "extensions.KHR_materials_specular.specularColorTexture",
    ];
    let passes = transmission.and_then(|t| t.transmission_texture.as_ref());
    let passes = read(slots[0], passes, Meaning::Data)?;
    let strength = specular.and_then(|s| s.specular_texture.as_ref());
    let strength = read(slots[1], strength, Meaning::Data)?;
    let color = specular.and_then(|s| s.specular_color_texture.as_ref());
    let color = read(slots[2], color, Meaning::Color)?;
    let constant = |used: TextureUse| textures.constant(used.texture);
    // Transmission stands in red, the factor on the reflectance in alpha.
    let passes = passes.map(|used| constant(used).map(|value| value.x));
    let strength = strength.map(|used| {
        let [least, most] = textures.alpha_range(used.texture);
        (least >= most).then_some(least)
    });
    let color = color.map(constant);
    if let Some(Some(factor)) = passes {
        layer.transmission *= factor;
    }
    if let Some(Some(factor)) = strength {
        layer.specular *= factor;
    }
    if let Some(Some(factor)) = color {
        layer.specular_color *= factor;
    }
    let varies = [
        passes == Some(None),
        strength == Some(None),
        color == Some(None),
    ];
    for (slot, _) in slots.into_iter().zip(varies).filter(|(_, varies)| *varies) {
        let file = document.file_name();
        textures.warn(format!(
            "{file}: {name}.{slot} varies and is ignored: its factor is used"
        ));
    }
    Ok(())
}
