//! The `textures` of a material.

use super::build::Context;
use super::format_materials::MaterialTable;
use super::format_textures::{TextureTable, TexturesTable};
use crate::error::InputError;
use crate::scene::load::files;
use crate::scene::load::texture::{Meaning, Textures};
use crate::scene::{MaterialTextures, NormalMap, Opacity, TextureUse};
use glam::{DAffine2, DVec2};

/// The textures of the material `name`, read.
pub(super) fn of_material(
    context: &Context,
    name: &str,
    table: &TexturesTable,
    textures: &mut Textures,
) -> Result<MaterialTextures, InputError> {
    let mut read = |table: Option<&TextureTable>, key: &str, meaning| {
        let Some(table) = table else { return Ok(None) };
        let field = format!("materials.{name}.textures.{key}");
        texture_use(context, table, &field, meaning, textures).map(Some)
    };
    let color = read(table.color.as_ref(), "color", Meaning::Color)?;
    let rough = table.metallic_roughness.as_ref();
    let metallic_roughness = read(rough, "metallic_roughness", Meaning::Data)?;
    let normal = read(table.normal.as_ref(), "normal", Meaning::Vector)?;
    if normal.is_none() && table.normal_scale.is_some() {
        return Err(context.error(
            format!("materials.{name}.textures.normal_scale"),
            "scales nothing: there is no normal map",
            "a normal map, `normal = { file = \"…\" }`",
        ));
    }
    Ok(MaterialTextures {
        color,
        metallic_roughness,
        specular_glossiness: None,
        normal: normal.map(|texture| NormalMap {
            texture,
            scale: table.normal_scale.unwrap_or(1.0),
        }),
    })
}

/// The opacity of the material `name`, its texture read.
pub(super) fn opacity(
    context: &Context,
    name: &str,
    table: &MaterialTable,
    textures: &mut Textures,
) -> Result<Opacity, InputError> {
    let field = format!("materials.{name}.textures.opacity");
    let texture = table.textures.opacity.as_ref();
    let texture = texture.map(|t| texture_use(context, t, &field, Meaning::Opacity, textures));
    let mut opacity = Opacity {
        factor: table.opacity,
        texture: texture.transpose()?,
        cutoff: table.alpha_cutoff,
    };
    textures.settle_cutoff(&mut opacity);
    Ok(opacity)
}

/// The texture that the table `field` names, read.
pub(super) fn texture_use(
    context: &Context,
    table: &TextureTable,
    field: &str,
    meaning: Meaning,
    textures: &mut Textures,
) -> Result<TextureUse, InputError> {
    let file = context
        .folders
        .resolve(&table.file, context.path, &format!("{field}.file"))?;
    Ok(TextureUse {
        texture: textures.get(&file, table.layer.as_deref(), meaning, || {
            files::read(&file)
        })?,
        transform: DAffine2::from_scale(DVec2::from_array(table.repeat)),
        wrap: table.wrap,
        interpolation: table.interpolation,
        second_uvs: false,
    })
}
