//! Morph targets at rest: the base shape plus their displacements, each times its weight (glTF 2.0,
//! section 3.7.2.2).

use super::document::Document;
use super::{accessors, primitives::same_count};
use crate::error::InputError;
use crate::scene::Mesh;
use glam::DVec3;
use gltf::json::mesh::Primitive;

/// Weights of a mesh's morph targets, and the field that says them.
pub(super) struct Weights {
    values: Vec<f64>,
    field: String,
}

/// The weights of mesh `mesh` in node `node`: the node's own, else the mesh's; `None` where nothing
/// is displaced.
pub(super) fn weights(
    document: &Document,
    node: usize,
    mesh: usize,
) -> Result<Option<Weights>, InputError> {
    let of_node = document.root.nodes[node].weights.as_ref();
    let of_mesh = document.root.meshes[mesh].weights.as_ref();
    let (values, field) = match (of_node, of_mesh) {
        (Some(weights), _) => (weights, format!("nodes[{node}].weights")),
        (None, Some(weights)) => (weights, format!("meshes[{mesh}].weights")),
        (None, None) => return Ok(None),
    };
    if let Some(place) = values.iter().position(|w| !w.is_finite()) {
        let field = format!("{field}[{place}]");
        let problem = format!("is {}", values[place]);
        return Err(document.error(field, problem, "a finite number"));
    }
    let values: Vec<f64> = values.iter().copied().map(f64::from).collect();
    let displaces = values.iter().any(|&w| w != 0.0);
    Ok(displaces.then_some(Weights { values, field }))
}

/// Displaces the vertices of `mesh`, made of the primitive `field`.
pub(super) fn displace(
    document: &Document,
    primitive: &Primitive,
    field: &str,
    weights: &Weights,
    mesh: &mut Mesh,
) -> Result<(), InputError> {
    let targets = primitive.targets.as_deref().unwrap_or_default();
    if targets.is_empty() {
        return Ok(());
    }
    if targets.len() != weights.values.len() {
        return Err(document.error(
            &weights.field,
            format!("has {} elements", weights.values.len()),
            format!("one for each of the {} targets of {field}", targets.len()),
        ));
    }
    for (number, (target, &weight)) in targets.iter().zip(&weights.values).enumerate() {
        if weight == 0.0 {
            continue;
        }
        let add = |index: usize, semantic: &str, to: &mut [DVec3]| {
            let field = format!("{field}.targets[{number}].{semantic}");
            let deltas = accessors::vectors(document, index, &field)?;
            same_count(document, &field, deltas.len(), to.len())?;
            for (value, delta) in to.iter_mut().zip(deltas) {
                *value += weight * delta;
            }
            Ok(())
        };
        if let Some(index) = target.positions {
            add(index.value(), "POSITION", &mut mesh.positions)?;
        }
        if let Some(index) = target.normals.filter(|_| !mesh.normals.is_empty()) {
            add(index.value(), "NORMAL", &mut mesh.normals)?;
        }
        if let Some(index) = target.tangents.filter(|_| !mesh.tangents.is_empty()) {
            let mut directions: Vec<DVec3> = mesh.tangents.iter().map(|t| t.truncate()).collect();
            add(index.value(), "TANGENT", &mut directions)?;
            for (tangent, direction) in mesh.tangents.iter_mut().zip(directions) {
                *tangent = direction.extend(tangent.w);
            }
        }
    }
    Ok(())
}
