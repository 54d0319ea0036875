//! Vertex colours.

use super::accessors;
use super::document::Document;
use super::primitives::same_count;
use crate::error::InputError;
use crate::scene::load::vertex_colors;
use glam::Vec4;
use gltf::json::material::AlphaMode;
use gltf::json::mesh::{Primitive, Semantic};
use gltf::json::validation::Checked;

/// COLOR_0 of `primitive`, whose `count` vertices have the attributes that the field `attributes`
/// names; empty where it changes nothing.
pub(super) fn of_primitive(
    document: &Document,
    primitive: &Primitive,
    attributes: &str,
    count: usize,
) -> Result<Vec<Vec4>, InputError> {
    let semantic = Checked::Valid(Semantic::Colors(0));
    let Some(index) = primitive.attributes.get(&semantic) else {
        return Ok(Vec::new());
    };
    let field = format!("{attributes}.COLOR_0");
    let mut colors = accessors::colors(document, index.value(), &field)?;
    same_count(document, &field, colors.len(), count)?;
    if is_opaque(document, primitive) {
        colors.iter_mut().for_each(|color| color.w = 1.0);
    }
    Ok(vertex_colors::unless_white(colors))
}

/// Whether alpha is not read of `primitive`: of its material's base colour neither.
fn is_opaque(document: &Document, primitive: &Primitive) -> bool {
    let index = primitive.material.map(|m| m.value());
    let material = index.and_then(|i| document.root.materials.get(i));
    let mode = material.map(|m| m.alpha_mode);
    !matches!(
        mode,
        Some(Checked::Valid(AlphaMode::Mask | AlphaMode::Blend))
    )
}
