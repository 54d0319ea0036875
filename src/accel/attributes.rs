//! What triangles carry beside their geometry: vertex normals and texture coordinates.
//!
//! Rounded here to what the GPU gets, so that its twin in f64 interpolates the same numbers.

use super::octahedral::octahedral;
use super::{Primitive, PrimitiveGeometry};
use crate::scene::texture::{disk_uv, rectangle_uv};
use crate::scene::{Geometry, Mesh, Scene};
use glam::{DVec2, DVec3};

/// What a triangle carries.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TriangleAttributes {
    /// Normals at its vertices, octahedrally encoded.
    pub normals: [[f32; 2]; 3],
    /// Texture coordinates at its vertices.
    pub uvs: [[f32; 2]; 3],
}

/// Which attributes a primitive has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Attributed {
    /// Its place in the list of attributes, where it is a triangle that has any.
    pub index: u32,
    /// Vertex normals that are not its own.
    pub normals: bool,
    /// Texture coordinates that its material reads.
    pub uvs: bool,
    /// An opacity that is not 1 everywhere.
    pub opacity: bool,
}

/// The attributes of all primitives.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Attributes {
    /// Those of triangles.
    pub triangles: Vec<TriangleAttributes>,
    /// Per primitive.
    pub of_primitive: Vec<Attributed>,
}

/// Cosine beyond which vertex normals count as the triangle's own: what rounding makes of parallel ones.
const FLAT: f64 = 1.0 - 1e-12;

impl Attributes {
    /// Those that `primitives` of `scene` have and need.
    pub fn new(scene: &Scene, primitives: &[Primitive]) -> Self {
        let mut attributes = Self::default();
        for primitive in primitives {
            let mut attributed = attributes.add(scene, primitive);
            let opacity = &scene.materials[primitive.material.index()].opacity;
            let varies = attributed.uvs && opacity.texture.is_some();
            attributed.opacity = varies || opacity.untextured() < 1.0;
            attributes.of_primitive.push(attributed);
        }
        attributes
    }

    fn add(&mut self, scene: &Scene, primitive: &Primitive) -> Attributed {
        let material = &scene.materials[primitive.material.index()];
        let textured = material.texture_uses().next().is_some();
        let none = Attributed::default();
        let (u, v) = match primitive.geometry {
            PrimitiveGeometry::Sphere { .. } => return none,
            PrimitiveGeometry::Rectangle { .. } | PrimitiveGeometry::Disk { .. } => {
                return Attributed {
                    uvs: textured,
                    ..none
                };
            }
            PrimitiveGeometry::Triangle { u, v, .. } => (u, v),
        };
        let Geometry::Mesh(mesh) = &scene.shapes[primitive.shape.index()].geometry else {
            return none;
        };
        let corners = mesh.triangles[primitive.part as usize].map(|i| i as usize);
        let normals = vertex_normals(mesh, corners, u.cross(v).normalize());
        let uvs = textured
            .then(|| texture_coordinates(scene, primitive))
            .flatten();
        if normals.is_none() && uvs.is_none() {
            return none;
        }
        self.triangles.push(TriangleAttributes {
            normals: normals
                .unwrap_or_default()
                .map(|n| octahedral(n).as_vec2().to_array()),
            uvs: uvs.unwrap_or_default().map(|uv| uv.as_vec2().to_array()),
        });
        Attributed {
            index: self.triangles.len() as u32 - 1,
            normals: normals.is_some(),
            uvs: uvs.is_some(),
            ..none
        }
    }
}

/// Unit vertex normals, where there are any and not all of them are the triangle's.
fn vertex_normals(mesh: &Mesh, corners: [usize; 3], own: DVec3) -> Option<[DVec3; 3]> {
    if mesh.normals.is_empty() {
        return None;
    }
    let normals = corners.map(|i| mesh.normals[i].try_normalize());
    let [Some(a), Some(b), Some(c)] = normals else {
        return None;
    };
    let flat = [a, b, c].iter().all(|n| n.dot(own) > FLAT);
    (!flat).then_some([a, b, c])
}

/// Texture coordinates at a primitive's points a, a + u and a + v; `None` where it has none.
pub fn texture_coordinates(scene: &Scene, primitive: &Primitive) -> Option<[DVec2; 3]> {
    let corners = [DVec2::ZERO, DVec2::X, DVec2::Y];
    match primitive.geometry {
        PrimitiveGeometry::Rectangle { .. } => Some(corners.map(rectangle_uv)),
        PrimitiveGeometry::Disk { .. } => Some(corners.map(disk_uv)),
        PrimitiveGeometry::Sphere { .. } => None,
        PrimitiveGeometry::Triangle { .. } => {
            let Geometry::Mesh(mesh) = &scene.shapes[primitive.shape.index()].geometry else {
                return None;
            };
            if mesh.uvs.is_empty() {
                return None;
            }
            let corners = mesh.triangles[primitive.part as usize];
            let uvs = corners.map(|i| mesh.uvs[i as usize]);
            uvs.iter().all(|uv| uv.is_finite()).then_some(uvs)
        }
    }
}
