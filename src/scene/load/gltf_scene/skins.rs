//! Skins at rest: vertices that follow the joints of a skeleton as its nodes stand (glTF 2.0,
//! section 3.7.3).

use super::document::Document;
use super::nodes::{self, Placed};
use super::{accessors, primitives::same_count};
use crate::error::InputError;
use crate::scene::Mesh;
use crate::scene::load::transform;
use glam::{DAffine3, DMat3, DMat4, DVec3};
use gltf::json::accessor::Type;
use gltf::json::mesh::{Primitive, Semantic};
use gltf::json::validation::Checked;
use std::collections::HashMap;
use std::rc::Rc;

/// The joints of a file's skins, each skin's worked out once.
pub(super) struct Skins<'a> {
    document: &'a Document,
    /// Where nodes stand in the world: those of the scene, and those above joints outside of it.
    to_world: HashMap<usize, DAffine3>,
    matrices: HashMap<usize, Rc<Vec<DAffine3>>>,
}

impl<'a> Skins<'a> {
    pub(super) fn new(document: &'a Document, placed: &[Placed]) -> Self {
        Self {
            document,
            to_world: placed.iter().map(|n| (n.index, n.to_world)).collect(),
            matrices: HashMap::new(),
        }
    }

    /// The joints of the skin of node `node`: what takes a vertex from the space of the mesh to the
    /// world.
    pub(super) fn of_node(&mut self, node: usize) -> Result<Option<Rc<Vec<DAffine3>>>, InputError> {
        let document = self.document;
        let Some(index) = document.root.nodes[node].skin.map(|s| s.value()) else {
            return Ok(None);
        };
        if let Some(known) = self.matrices.get(&index) {
            return Ok(Some(Rc::clone(known)));
        }
        let field = || format!("nodes[{node}].skin");
        let skin = document.get(&document.root.skins, index, "skin", field)?;
        let inverse_binds = self.inverse_binds(index, skin.joints.len())?;
        let mut matrices = Vec::with_capacity(skin.joints.len());
        for (place, (joint, inverse_bind)) in skin.joints.iter().zip(inverse_binds).enumerate() {
            let field = || format!("skins[{index}].joints[{place}]");
            matrices.push(self.joint(joint.value(), field)? * inverse_bind);
        }
        let matrices = Rc::new(matrices);
        self.matrices.insert(index, Rc::clone(&matrices));
        Ok(Some(matrices))
    }

    /// One for each of the skin's joints; the identity where the file says none.
    fn inverse_binds(&self, skin: usize, joints: usize) -> Result<Vec<DAffine3>, InputError> {
        let document = self.document;
        let Some(accessor) = document.root.skins[skin].inverse_bind_matrices else {
            return Ok(vec![DAffine3::IDENTITY; joints]);
        };
        let field = format!("skins[{skin}].inverseBindMatrices");
        let all = accessors::numbers(document, accessor.value(), &field, Type::Mat4)?;
        if all.len() < joints {
            let problem = format!("has {} elements", all.len());
            let expected = format!("one for each of the {joints} joints");
            return Err(document.error(field, problem, expected));
        }
        let affine = |m: &[f64; 16]| DAffine3::from_mat4(DMat4::from_cols_array(m));
        Ok(all.iter().map(affine).collect())
    }

    /// Where joint `index` stands in the world. Joints outside of the scene stand where their own
    /// parents put them.
    fn joint(
        &mut self,
        index: usize,
        field: impl FnOnce() -> String,
    ) -> Result<DAffine3, InputError> {
        let document = self.document;
        document.get(&document.root.nodes, index, "node", field)?;
        if !self.to_world.contains_key(&index) {
            for (node, to_world) in nodes::above(document, index)? {
                self.to_world.entry(node).or_insert(to_world);
            }
        }
        Ok(self.to_world[&index])
    }
}

/// Moves the vertices of `mesh`, made of the primitive `field`, to where the joints put them in the
/// world.
///
/// `mirrored` is whether the mesh's node mirrors space: that alone turns the winding (section
/// 3.7.4).
pub(super) fn pose(
    document: &Document,
    primitive: &Primitive,
    field: &str,
    joints: &[DAffine3],
    mirrored: bool,
    mesh: &mut Mesh,
) -> Result<(), InputError> {
    let mut blended = vec![Blend::NONE; mesh.positions.len()];
    let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic));
    let mut set = 0;
    while let Some(accessor) = attribute(Semantic::Joints(set)) {
        let of_joints = format!("{field}.attributes.JOINTS_{set}");
        let of_weights = format!("{field}.attributes.WEIGHTS_{set}");
        let indices = accessors::joints(document, accessor.value(), &of_joints)?;
        same_count(document, &of_joints, indices.len(), blended.len())?;
        let Some(accessor) = attribute(Semantic::Weights(set)) else {
            return Err(document.error(of_weights, "is missing", "weights beside the joints"));
        };
        let weights: Vec<[f64; 4]> =
            accessors::numbers(document, accessor.value(), &of_weights, Type::Vec4)?;
        same_count(document, &of_weights, weights.len(), blended.len())?;
        for (blend, (indices, weights)) in blended.iter_mut().zip(indices.iter().zip(weights)) {
            for (&joint, weight) in indices.iter().zip(weights).filter(|(_, w)| *w != 0.0) {
                let matrix = joints.get(joint as usize).ok_or_else(|| {
                    document.error(
                        &of_joints,
                        format!("joint {joint} is out of range"),
                        format!("an index of the skin's {} joints", joints.len()),
                    )
                })?;
                blend.add(weight, matrix);
            }
        }
        set += 1;
    }
    if set == 0 {
        let field = format!("{field}.attributes");
        let problem = "has no JOINTS_0, and a node shows it with a skin";
        return Err(document.error(field, problem, "the joints that each vertex follows"));
    }
    for (position, blend) in mesh.positions.iter_mut().zip(&blended) {
        *position = blend.affine().transform_point3(*position);
    }
    for (normal, blend) in mesh.normals.iter_mut().zip(&blended) {
        *normal = transform::normal_matrix(&blend.affine().matrix3) * *normal;
    }
    for (tangent, blend) in mesh.tangents.iter_mut().zip(&blended) {
        transform::turn_tangents(&blend.affine().matrix3, std::slice::from_mut(tangent));
    }
    if mirrored {
        for triangle in &mut mesh.triangles {
            triangle.swap(1, 2);
        }
    }
    Ok(())
}

/// The weighted sum of a vertex's joints.
#[derive(Clone)]
struct Blend {
    weight: f64,
    matrix: DMat3,
    translation: DVec3,
}

impl Blend {
    const NONE: Self = Self {
        weight: 0.0,
        matrix: DMat3::ZERO,
        translation: DVec3::ZERO,
    };

    fn add(&mut self, weight: f64, joint: &DAffine3) {
        self.weight += weight;
        self.matrix += weight * joint.matrix3;
        self.translation += weight * joint.translation;
    }

    /// Weights are rounded and their sum is not exactly 1; a vertex that follows nothing stays.
    fn affine(&self) -> DAffine3 {
        if self.weight <= 0.0 {
            return DAffine3::IDENTITY;
        }
        let factor = 1.0 / self.weight;
        DAffine3 {
            matrix3: factor * self.matrix,
            translation: factor * self.translation,
        }
    }
}
