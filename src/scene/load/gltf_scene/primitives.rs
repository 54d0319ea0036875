//! Meshes: triangles of primitives, instanced by nodes.

use super::accessors::{self, RESTART};
use super::colors;
use super::coordinates::CoordinateSets;
use super::document::Document;
use super::instances::{self, Place};
use super::morph::{self, Weights};
use super::nodes::Placed;
use super::skins::{self, Skins};
use crate::error::InputError;
use crate::scene::load::room::Room;
use crate::scene::load::transform;
use crate::scene::{Geometry, Mesh};
use glam::{DAffine3, DVec4};
use gltf::json;
use gltf::json::accessor::Type;
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;
use std::borrow::Cow;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::rc::Rc;

/// Most vertices and triangles of all instances together, as each takes memory of its own.
const MAX_SIZE: usize = 1 << 27;

/// A primitive of a mesh, placed by a node.
pub(super) struct Instance {
    /// `Lenses_low (mesh 5)`.
    pub(super) name: String,
    /// Triangles in world space.
    pub(super) mesh: Mesh,
    /// Index of its material in the file; `None` is glTF's default material.
    pub(super) material: Option<usize>,
    /// Its texture coordinates.
    pub(super) sets: CoordinateSets,
    /// `meshes[5].primitives[0]`, for messages.
    pub(super) field: String,
}

/// Reads primitives, each once however often it is instanced.
pub(super) struct Primitives<'a> {
    document: &'a Document,
    decoded: HashMap<(usize, usize), Option<Mesh>>,
    skins: Skins<'a>,
}

impl<'a> Primitives<'a> {
    /// Those that the nodes `placed` show. Refuses files whose nodes multiply their meshes into
    /// more than a machine holds, before that is done.
    pub(super) fn new(
        document: &'a Document,
        placed: &[Placed],
        room: &Room,
    ) -> Result<Self, InputError> {
        take_room(document, placed, room)?;
        let mut primitives = Self {
            document,
            decoded: HashMap::new(),
            skins: Skins::new(document, placed),
        };
        primitives.check_size(placed)?;
        Ok(primitives)
    }

    fn check_size(&mut self, placed: &[Placed]) -> Result<(), InputError> {
        let document = self.document;
        let mut sizes = HashMap::new();
        let mut total: usize = 0;
        for node in placed {
            let Some((index, mesh)) = mesh_of(document, node)? else {
                continue;
            };
            let size = match sizes.get(&index) {
                Some(&known) => known,
                None => {
                    let mut size: usize = 0;
                    for (number, primitive) in mesh.primitives.iter().enumerate() {
                        let decoded = self.decode(index, number, primitive)?;
                        let numbers = decoded.map_or(0, |m| m.positions.len() + m.triangles.len());
                        size = size.saturating_add(1 + numbers);
                    }
                    sizes.insert(index, size);
                    size
                }
            };
            let times = usize::try_from(instances::count(document, node.index));
            let all = size.saturating_mul(times.unwrap_or(usize::MAX));
            total = total.saturating_add(all);
            if total > MAX_SIZE {
                return Err(document.error(
                    format!("nodes[{}].mesh", node.index),
                    format!("the nodes up to here make more than {MAX_SIZE} vertices and triangles of their meshes"),
                    "fewer instances",
                ));
            }
        }
        Ok(())
    }

    /// The primitives of a node's mesh, moved to the world and then by `placement`.
    pub(super) fn of_node(
        &mut self,
        node: &Placed,
        placement: &DAffine3,
        warnings: &mut Vec<String>,
    ) -> Result<Vec<Instance>, InputError> {
        let document = self.document;
        let Some((mesh_index, mesh)) = mesh_of(document, node)? else {
            return Ok(Vec::new());
        };
        let label = document.root.nodes[node.index]
            .name
            .as_ref()
            .or(mesh.name.as_ref())
            .map_or_else(|| format!("node {}", node.index), Clone::clone);
        let pose = Pose {
            weights: morph::weights(document, node.index, mesh_index)?,
            joints: self.skins.of_node(node.index)?,
            mirrored: transform::mirrors(&node.to_world),
        };
        let places = if pose.joints.is_some() {
            instances::place_skinned(document, node, placement, &label, warnings)?
        } else {
            instances::place(document, node, placement, &label, warnings)?
        };
        let mut instances = Vec::new();
        for (number, primitive) in mesh.primitives.iter().enumerate() {
            let field = format!("meshes[{mesh_index}].primitives[{number}]");
            let Some(base) = self.decode(mesh_index, number, primitive)? else {
                continue;
            };
            let posed = pose.of(document, primitive, &field, base)?;
            let part = if mesh.primitives.len() > 1 {
                format!(", primitive {number}")
            } else {
                String::new()
            };
            for Place { suffix, to_world } in &places {
                let moved = transform::apply(to_world, Geometry::Mesh((*posed).clone()));
                let Geometry::Mesh(moved) = moved else {
                    unreachable!("a transformed mesh is a mesh")
                };
                instances.push(Instance {
                    name: format!("{label} (mesh {mesh_index}{part}{suffix})"),
                    mesh: moved,
                    material: primitive.material.map(|m| m.value()),
                    sets: CoordinateSets::of(document, primitive),
                    field: field.clone(),
                });
            }
        }
        Ok(instances)
    }

    /// The triangles of a primitive in its mesh's space; `None` for one that is not rendered.
    fn decode(
        &mut self,
        mesh: usize,
        number: usize,
        primitive: &Primitive,
    ) -> Result<Option<&Mesh>, InputError> {
        let slot = match self.decoded.entry((mesh, number)) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(slot) => {
                let field = format!("meshes[{mesh}].primitives[{number}]");
                let decoded = match triangle_mode(self.document, primitive, &field)? {
                    Some(mode) => triangles(self.document, primitive, mode, &field)?,
                    None => None,
                };
                slot.insert(decoded)
            }
        };
        Ok(slot.as_ref())
    }
}

/// Takes room for the triangles that the accessors of the meshes of `placed` promise.
fn take_room(document: &Document, placed: &[Placed], room: &Room) -> Result<(), InputError> {
    for node in placed {
        let Some((_, mesh)) = mesh_of(document, node)? else {
            continue;
        };
        let promised = mesh
            .primitives
            .iter()
            .map(|p| promised_triangles(document, p));
        let promised = promised.fold(0, u64::saturating_add);
        let all = promised.saturating_mul(instances::count(document, node.index));
        room.take(document.path(), &format!("nodes[{}].mesh", node.index), all)?;
    }
    Ok(())
}

/// The triangles that the accessors of `primitive` promise; 0 for strips and fans, which may end at
/// every vertex.
fn promised_triangles(document: &Document, primitive: &Primitive) -> u64 {
    if primitive.mode != Checked::Valid(Mode::Triangles) {
        return 0;
    }
    let positions = primitive
        .attributes
        .get(&Checked::Valid(Semantic::Positions));
    let corners = primitive.indices.as_ref().or(positions);
    let accessor = corners.and_then(|index| document.root.accessors.get(index.value()));
    accessor.map_or(0, |accessor| accessor.count.0 / 3)
}

/// How a node poses the primitives of its mesh.
struct Pose {
    weights: Option<Weights>,
    joints: Option<Rc<Vec<DAffine3>>>,
    /// Whether the node mirrors space.
    mirrored: bool,
}

impl Pose {
    /// The primitive `field`, which is `base` without a pose: in the space of the mesh, or in the
    /// world where it has a skin.
    fn of<'a>(
        &self,
        document: &Document,
        primitive: &Primitive,
        field: &str,
        base: &'a Mesh,
    ) -> Result<Cow<'a, Mesh>, InputError> {
        let mut posed = Cow::Borrowed(base);
        if let Some(weights) = &self.weights {
            morph::displace(document, primitive, field, weights, posed.to_mut())?;
        }
        if let Some(joints) = &self.joints {
            let mirrored = self.mirrored;
            skins::pose(document, primitive, field, joints, mirrored, posed.to_mut())?;
        }
        Ok(posed)
    }
}

/// The mesh that a node shows, with its index.
fn mesh_of<'a>(
    document: &'a Document,
    node: &Placed,
) -> Result<Option<(usize, &'a json::Mesh)>, InputError> {
    let index = document.root.nodes[node.index].mesh.map(|m| m.value());
    let Some(index) = index.filter(|_| node.visible) else {
        return Ok(None);
    };
    let field = || format!("nodes[{}].mesh", node.index);
    let mesh = document.get(&document.root.meshes, index, "mesh", field)?;
    Ok(Some((index, mesh)))
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

/// The triangles of a primitive; `None` where it has no POSITION, which glTF has skipped (section
/// 3.7.2.1).
fn triangles(
    document: &Document,
    primitive: &Primitive,
    mode: Mode,
    field: &str,
) -> Result<Option<Mesh>, InputError> {
    let attributes = format!("{field}.attributes");
    let accessor = |semantic| {
        let found = primitive.attributes.get(&Checked::Valid(semantic));
        found.map(|accessor| accessor.value())
    };
    let Some(index) = accessor(Semantic::Positions) else {
        return Ok(None);
    };
    let positions = accessors::vectors(document, index, &format!("{attributes}.POSITION"))?;
    let count = positions.len();
    let mut normals = Vec::new();
    if let Some(index) = accessor(Semantic::Normals) {
        let field = format!("{attributes}.NORMAL");
        normals = accessors::vectors(document, index, &field)?;
        same_count(document, &field, normals.len(), count)?;
    }
    let mut tangents = Vec::new();
    if let Some(index) = accessor(Semantic::Tangents) {
        let field = format!("{attributes}.TANGENT");
        let all: Vec<[f64; 4]> = accessors::numbers(document, index, &field, Type::Vec4)?;
        same_count(document, &field, all.len(), count)?;
        tangents = all.into_iter().map(DVec4::from_array).collect();
    }
    let coordinates = |set: Option<u32>| {
        let found = set.and_then(|set| Some((set, accessor(Semantic::TexCoords(set))?)));
        let Some((set, index)) = found else {
            return Ok(Vec::new());
        };
        let field = format!("{attributes}.TEXCOORD_{set}");
        let uvs = accessors::coordinates(document, index, &field)?;
        same_count(document, &field, uvs.len(), count)?;
        Ok(uvs)
    };
    let sets = CoordinateSets::of(document, primitive);
    let (uvs, second_uvs) = (coordinates(Some(sets.first))?, coordinates(sets.second)?);
    Ok(Some(Mesh {
        triangles: faces(document, primitive, mode, field, count)?,
        positions,
        normals,
        uvs,
        second_uvs,
        colors: colors::of_primitive(document, primitive, &attributes, count)?,
        tangents,
    }))
}

/// The vertices of the triangles of a primitive with `count` vertices.
fn faces(
    document: &Document,
    primitive: &Primitive,
    mode: Mode,
    field: &str,
    count: usize,
) -> Result<Vec<[u32; 3]>, InputError> {
    if let Some(mesh) = document.draco.of_primitive(document, primitive)? {
        let corners = &mesh.corners;
        if let Some(outside) = corners.iter().find(|&&corner| corner as usize >= count) {
            let problem = format!("vertex {outside} of Draco's mesh is out of range");
            let expected = format!("an index into the {count} vertices");
            return Err(document.error(field, problem, expected));
        }
        // It is made of triangles, whatever the primitive's mode.
        return Ok(assemble(corners, Mode::Triangles));
    }
    let indices_field = format!("{field}.indices");
    let restarts = mode != Mode::Triangles;
    let corners = match primitive.indices {
        Some(a) => accessors::indices(document, a.value(), &indices_field, count, restarts)?,
        None => {
            let count = u32::try_from(count)
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
    Ok(assemble(&corners, mode))
}

/// Refuses an attribute whose count is another than that of the positions.
pub(super) fn same_count(
    document: &Document,
    field: &str,
    found: usize,
    positions: usize,
) -> Result<(), InputError> {
    if found == positions {
        return Ok(());
    }
    let problem = format!("has {found} elements");
    Err(document.error(field, problem, format!("as many as POSITION, {positions}")))
}

/// Triangles from corners (glTF 2.0, section 3.7.2.1). Strips and fans end and begin anew at
/// [`RESTART`].
fn assemble(corners: &[u32], mode: Mode) -> Vec<[u32; 3]> {
    let runs = || corners.split(|&corner| corner == RESTART);
    match mode {
        Mode::TriangleStrip => runs()
            .flat_map(|run| run.windows(3).enumerate())
            .map(|(i, w)| {
                if i % 2 == 0 {
                    [w[0], w[1], w[2]]
                } else {
                    [w[0], w[2], w[1]]
                }
            })
            .collect(),
        Mode::TriangleFan => runs()
            .flat_map(|run| run.windows(2).skip(1).map(|w| [w[0], w[1], run[0]]))
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
        let restarted = [10, 11, 12, 13, RESTART, RESTART, 7, 8, RESTART, 1, 2, 3];
        assert_eq!(
            assemble(&restarted, Mode::TriangleStrip),
            [[10, 11, 12], [11, 13, 12], [1, 2, 3]]
        );
        assert_eq!(
            assemble(&restarted, Mode::TriangleFan),
            [[11, 12, 10], [12, 13, 10], [2, 3, 1]]
        );
    }
}
