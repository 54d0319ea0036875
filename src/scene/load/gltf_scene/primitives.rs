//! Meshes: triangles of primitives, instanced by nodes.

use super::document::Document;
use super::nodes::Placed;
use super::{accessors, transform_error};
use crate::error::InputError;
use crate::scene::load::transform;
use crate::scene::{Geometry, Mesh};
use glam::{DAffine3, DMat3, DVec3};
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;
use std::collections::HashMap;

/// A primitive of a mesh, placed by a node.
pub(super) struct Instance {
    /// `Lenses_low (mesh 5)`.
    pub(super) name: String,
    /// Triangles in world space.
    pub(super) mesh: Mesh,
    /// Index of its material in the file; `None` is glTF's default material.
    pub(super) material: Option<usize>,
    /// `meshes[5].primitives[0]`, for messages.
    pub(super) field: String,
}

/// Reads primitives, each once however often it is instanced.
pub(super) struct Primitives<'a> {
    document: &'a Document,
    decoded: HashMap<(usize, usize), Option<Mesh>>,
}

impl<'a> Primitives<'a> {
    pub(super) fn new(document: &'a Document) -> Self {
        Self {
            document,
            decoded: HashMap::new(),
        }
    }

    /// The primitives of a node's mesh, moved to the world and then by `placement`. A node with scale 0 is hidden.
    pub(super) fn of_node(
        &mut self,
        node: &Placed,
        placement: &DAffine3,
        warnings: &mut Vec<String>,
    ) -> Result<Vec<Instance>, InputError> {
        let document = self.document;
        let json = &document.root.nodes[node.index];
        let Some(mesh_index) = json.mesh.map(|m| m.value()) else {
            return Ok(Vec::new());
        };
        let field = || format!("nodes[{}].mesh", node.index);
        let mesh = document.get(&document.root.meshes, mesh_index, "mesh", field)?;
        let label = json
            .name
            .as_ref()
            .or(mesh.name.as_ref())
            .map_or_else(|| format!("node {}", node.index), Clone::clone);
        if node.to_world.matrix3 == DMat3::ZERO {
            warnings.push(format!(
                "{}: {label} is hidden by a scale of 0",
                document.file_name()
            ));
            return Ok(Vec::new());
        }
        let to_world = *placement * node.to_world;
        transform::check(&to_world).map_err(|p| transform_error(document, node, &p))?;
        let mut instances = Vec::new();
        for (number, primitive) in mesh.primitives.iter().enumerate() {
            let Some(triangles) = self.decode(mesh_index, number, primitive)? else {
                continue;
            };
            let moved = transform::apply(&to_world, Geometry::Mesh(triangles))
                .map_err(|p| transform_error(document, node, &p))?;
            let Geometry::Mesh(moved) = moved else {
                unreachable!("a transformed mesh is a mesh")
            };
            let part = if mesh.primitives.len() > 1 {
                format!(", primitive {number}")
            } else {
                String::new()
            };
            instances.push(Instance {
                name: format!("{label} (mesh {mesh_index}{part})"),
                mesh: moved,
                material: primitive.material.map(|m| m.value()),
                field: format!("meshes[{mesh_index}].primitives[{number}]"),
            });
        }
        Ok(instances)
    }

    /// The triangles of a primitive in its mesh's space; `None` for points and lines.
    fn decode(
        &mut self,
        mesh: usize,
        number: usize,
        primitive: &Primitive,
    ) -> Result<Option<Mesh>, InputError> {
        if let Some(known) = self.decoded.get(&(mesh, number)) {
            return Ok(known.clone());
        }
        let field = format!("meshes[{mesh}].primitives[{number}]");
        let decoded = match triangle_mode(self.document, primitive, &field)? {
            Some(mode) => Some(triangles(self.document, primitive, mode, &field)?),
            None => None,
        };
        self.decoded.insert((mesh, number), decoded.clone());
        Ok(decoded)
    }
}

/// The mode when it is one of triangles.
pub(super) fn triangle_mode(
    document: &Document,
    primitive: &Primitive,
    field: &str,
) -> Result<Option<Mode>, InputError> {
    match primitive.mode {
        Checked::Valid(mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) => {
            Ok(Some(mode))
        }
        Checked::Valid(_) => Ok(None),
        Checked::Invalid => Err(document.error(format!("{field}.mode"), "is unknown", "0 to 6")),
    }
}

fn triangles(
    document: &Document,
    primitive: &Primitive,
    mode: Mode,
    field: &str,
) -> Result<Mesh, InputError> {
    let accessor = primitive
        .attributes
        .get(&Checked::Valid(Semantic::Positions))
        .ok_or_else(|| {
            document.error(
                format!("{field}.attributes"),
                "has no POSITION",
                "vertex positions",
            )
        })?;
    let positions: Vec<DVec3> = accessors::positions(
        document,
        accessor.value(),
        &format!("{field}.attributes.POSITION"),
    )?;
    let indices_field = format!("{field}.indices");
    let corners = match primitive.indices {
        Some(a) => accessors::indices(document, a.value(), &indices_field, positions.len())?,
        None => {
            let count = u32::try_from(positions.len())
                .map_err(|_| document.error(field, "has more than 2³² vertices", "fewer"))?;
            (0..count).collect()
        }
    };
    if mode == Mode::Triangles && corners.len() % 3 != 0 {
        return Err(document.error(
            if primitive.indices.is_some() {
                &indices_field
            } else {
                field
            },
            format!("{} corners do not make triangles", corners.len()),
            "a multiple of 3",
        ));
    }
    Ok(Mesh {
        triangles: assemble(&corners, mode),
        positions,
    })
}

/// Triangles from corners (glTF 2.0, section 3.7.2.1).
fn assemble(corners: &[u32], mode: Mode) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => corners
            .windows(3)
            .enumerate()
            .map(|(i, w)| {
                if i % 2 == 0 {
                    [w[0], w[1], w[2]]
                } else {
                    [w[0], w[2], w[1]]
                }
            })
            .collect(),
        Mode::TriangleFan => corners
            .windows(2)
            .skip(1)
            .map(|w| [w[0], w[1], corners[0]])
            .collect(),
        _ => corners
            .chunks_exact(3)
            .map(|c| [c[0], c[1], c[2]])
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_keep_their_winding() {
        let corners = [10, 11, 12, 13];
        assert_eq!(
            assemble(&corners, Mode::TriangleStrip),
            [[10, 11, 12], [11, 13, 12]]
        );
        assert_eq!(
            assemble(&corners, Mode::TriangleFan),
            [[11, 12, 10], [12, 13, 10]]
        );
        assert_eq!(assemble(&corners[..3], Mode::Triangles), [[10, 11, 12]]);
        assert!(assemble(&[], Mode::TriangleFan).is_empty());
    }
}
