//! What triangles carry beside their geometry: vertex normals, texture coordinates, vertex colours
//! and tangents.
//!
//! Held as the words that the GPU reads (`shaders/scene/attributes.wesl`), so that its twin in f64
//! interpolates the same numbers.

use super::octahedral::octahedral;
use super::{Primitive, PrimitiveGeometry};
use crate::scene::texture::{disk_uv, rectangle_uv};
use crate::scene::{Geometry, Material, Mesh, Scene};
use glam::{DVec2, DVec3, DVec4, Vec4};

/// Words of a triangle's normals and texture coordinates, where it has either.
pub const NORMAL_AND_UV_WORDS: usize = 3;
/// Words of a triangle's colours, where it has them.
pub const COLOR_WORDS: usize = 3;
/// Words of a triangle's tangents, where it has them.
pub const TANGENT_WORDS: usize = 3;

/// Which attributes a primitive has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Attributed {
    /// Index of its first word in [`Attributes::words`], where it is a triangle that has any.
    pub word: u32,
    /// Vertex normals that are not its own.
    pub normals: bool,
    /// Texture coordinates that its material reads.
    pub uvs: bool,
    /// Vertex colours that are not all white and opaque.
    pub colors: bool,
    /// Tangents for its normal map other than those that the texture coordinates give.
    pub tangents: bool,
    /// A second set of texture coordinates that its material reads, beside the first.
    pub second_uvs: bool,
    /// An opacity that is not 1 everywhere.
    pub opacity: bool,
}

impl Attributed {
    fn color_word(&self) -> usize {
        let before = if self.normals || self.uvs {
            NORMAL_AND_UV_WORDS
        } else {
            0
        };
        self.word as usize + before
    }

    fn tangent_word(&self) -> usize {
        self.color_word() + if self.colors { COLOR_WORDS } else { 0 }
    }

    fn second_uv_word(&self) -> usize {
        self.tangent_word() + if self.tangents { TANGENT_WORDS } else { 0 }
    }
}

/// The attributes of all primitives.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Attributes {
    /// Per triangle that has any: three words of its normals (octahedrally encoded) and texture
    /// coordinates, where it has either, then one word for the colour of each vertex, where it has
    /// colours, one for the tangent of each, where it has tangents, and two of further texture
    /// coordinates.
    pub words: Vec<[f32; 4]>,
    /// Per primitive.
    pub of_primitive: Vec<Attributed>,
}

/// Cosine beyond which vertex normals count as the triangle's own: what rounding makes of parallel
/// ones.
const FLAT: f64 = 1.0 - 1e-12;

impl Attributes {
    /// Those that `primitives` of `scene` have and need.
    pub fn new(scene: &Scene, primitives: &[Primitive]) -> Self {
        let mut attributes = Self::default();
        for primitive in primitives {
            let attributed = attributes.add(scene, primitive);
            attributes.of_primitive.push(attributed);
        }
        attributes
    }

    /// Octahedrally encoded normals at the vertices of the triangle `of`, which has them.
    pub fn normals(&self, of: &Attributed) -> [[f32; 2]; 3] {
        let first = of.word as usize;
        let ([ax, ay, bx, by], [cx, cy, ..]) = (self.words[first], self.words[first + 1]);
        [[ax, ay], [bx, by], [cx, cy]]
    }

    /// Texture coordinates at the vertices of the triangle `of`, which has them.
    pub fn uvs(&self, of: &Attributed) -> [[f32; 2]; 3] {
        let first = of.word as usize;
        let ([.., ax, ay], [bx, by, cx, cy]) = (self.words[first + 1], self.words[first + 2]);
        [[ax, ay], [bx, by], [cx, cy]]
    }

    /// Colours at the vertices of the triangle `of`, which has them: linear red, green, blue, and
    /// alpha.
    pub fn colors(&self, of: &Attributed) -> [[f32; 4]; 3] {
        let first = of.color_word();
        [0, 1, 2].map(|corner| self.words[first + corner])
    }

    /// Unit tangents at the vertices of the triangle `of`, which has them, each with its sense.
    pub fn tangents(&self, of: &Attributed) -> [[f32; 4]; 3] {
        let first = of.tangent_word();
        [0, 1, 2].map(|corner| self.words[first + corner])
    }

    /// Second texture coordinates at the vertices of the triangle `of`, which has them.
    pub fn second_uvs(&self, of: &Attributed) -> [[f32; 2]; 3] {
        let first = of.second_uv_word();
        let ([ax, ay, bx, by], [cx, cy, ..]) = (self.words[first], self.words[first + 1]);
        [[ax, ay], [bx, by], [cx, cy]]
    }

    fn add(&mut self, scene: &Scene, primitive: &Primitive) -> Attributed {
        let material = &scene.materials[primitive.material.index()];
        let coordinates = TriangleUvs::new(scene, primitive, material);
        let none = Attributed::default();
        let (mut attributed, alpha) = match primitive.geometry {
            PrimitiveGeometry::Sphere { .. } | PrimitiveGeometry::Ellipsoid { .. } => (none, 1.0),
            PrimitiveGeometry::Rectangle { .. } | PrimitiveGeometry::Disk { .. } => {
                let uvs = coordinates.first.is_some();
                (Attributed { uvs, ..none }, 1.0)
            }
            PrimitiveGeometry::Triangle { u, v, .. } => {
                match &scene.shapes[primitive.shape.index()].geometry {
                    Geometry::Mesh(mesh) => {
                        let corners = mesh.triangles[primitive.part as usize];
                        self.add_triangle(mesh, corners, [u, v], coordinates)
                    }
                    _ => (none, 1.0),
                }
            }
        };
        let opacity = &material.opacity;
        let textured = attributed.uvs && opacity.texture.is_some();
        attributed.opacity = textured || alpha < 1.0 || opacity.untextured() < 1.0;
        attributed
    }

    /// Adds the words of a triangle whose edges are `edges`. Returns its least vertex alpha as
    /// well.
    fn add_triangle(
        &mut self,
        mesh: &Mesh,
        corners: [u32; 3],
        edges: [DVec3; 2],
        TriangleUvs {
            first: uvs,
            second: second_uvs,
            of_normal_map,
        }: TriangleUvs,
    ) -> (Attributed, f32) {
        let corners = corners.map(|i| i as usize);
        let own = edges[0].cross(edges[1]).normalize();
        let tangents = of_normal_map.and_then(|uvs| vertex_tangents(mesh, corners, edges, &uvs));
        let normals = vertex_normals(mesh, corners, own);
        let colors = vertex_colors(mesh, corners);
        let any = normals.is_some() || uvs.is_some() || colors.is_some();
        let attributed = Attributed {
            word: if any { self.words.len() as u32 } else { 0 },
            normals: normals.is_some(),
            uvs: uvs.is_some(),
            colors: colors.is_some(),
            tangents: tangents.is_some(),
            second_uvs: second_uvs.is_some(),
            opacity: false,
        };
        if normals.is_some() || uvs.is_some() {
            let normals = normals.unwrap_or_default();
            let [a, b, c] = normals.map(|n| octahedral(n).as_vec2().to_array());
            let [d, e, f] = rounded(uvs.unwrap_or_default());
            self.words.extend([word(a, b), word(c, d), word(e, f)]);
        }
        let colors = colors.into_iter().flatten();
        self.words.extend(colors.clone().map(|c| c.to_array()));
        let tangents = tangents.into_iter().flatten();
        self.words.extend(tangents.map(|t| t.to_array()));
        if let Some(uvs) = second_uvs {
            let [a, b, c] = rounded(uvs);
            self.words.extend([word(a, b), word(c, [0.0; 2])]);
        }
        (attributed, colors.fold(1.0, |least, c| c.w.min(least)))
    }
}

fn word([x, y]: [f32; 2], [z, w]: [f32; 2]) -> [f32; 4] {
    [x, y, z, w]
}

fn rounded(uvs: [DVec2; 3]) -> [[f32; 2]; 3] {
    uvs.map(|uv| uv.as_vec2().to_array())
}

/// The texture coordinates that a primitive's material reads.
#[derive(Default)]
struct TriangleUvs {
    first: Option<[DVec2; 3]>,
    second: Option<[DVec2; 3]>,
    /// Those of the two that its normal map is read with.
    of_normal_map: Option<[DVec2; 3]>,
}

impl TriangleUvs {
    /// All that `material`, which `primitive` has, reads, or none: where one set is missing no
    /// texture is read.
    fn new(scene: &Scene, primitive: &Primitive, material: &Material) -> Self {
        let textured = material.texture_uses().next().is_some();
        let twofold = material.reads_second_uvs();
        let read = |wanted: bool, second| {
            let uvs = wanted.then(|| texture_coordinates(scene, primitive, second));
            uvs.flatten()
        };
        let (first, second) = (read(textured, false), read(twofold, true));
        if first.is_none() || second.is_some() != twofold {
            return Self::default();
        }
        let normal_map = material.textures.normal.as_ref();
        Self {
            first,
            second,
            of_normal_map: normal_map.and_then(|map| {
                if map.texture.second_uvs {
                    second
                } else {
                    first
                }
            }),
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

/// Cosine beyond which tangents are those that texture coordinates give: an angle of 10⁻⁴.
const SAME_TANGENT: f64 = 1.0 - 5e-9;

/// Unit tangents, where there are any and not all of them are what the texture coordinates `uvs`
/// give (glTF 2.0, section 3.7.2.1). Without vertex normals they do not count.
fn vertex_tangents(
    mesh: &Mesh,
    corners: [usize; 3],
    [u, v]: [DVec3; 2],
    uvs: &[DVec2; 3],
) -> Option<[Vec4; 3]> {
    if mesh.tangents.is_empty() || mesh.normals.is_empty() {
        return None;
    }
    let unit = |i: usize| {
        let tangent = mesh.tangents[i];
        Some(
            tangent
                .truncate()
                .try_normalize()?
                .extend(tangent.w.signum()),
        )
    };
    let [Some(a), Some(b), Some(c)] = corners.map(unit) else {
        return None;
    };
    let (du, dv) = (uvs[1] - uvs[0], uvs[2] - uvs[0]);
    let side = du.perp_dot(dv).signum();
    let along_u = side * (u * dv.y - v * du.y);
    let own = u.cross(v).normalize();
    let same = |corner: usize, tangent: DVec4| {
        let normal = mesh.normals[corner].try_normalize().unwrap_or(own);
        let normal = normal * normal.dot(own).signum();
        let across = |t: DVec3| (t - normal * normal.dot(t)).normalize_or_zero();
        let cosine = across(along_u).dot(across(tangent.truncate()));
        cosine > SAME_TANGENT && tangent.w * side < 0.0
    };
    let all_same = corners.into_iter().zip([a, b, c]).all(|(i, t)| same(i, t));
    (!all_same).then(|| [a, b, c].map(|t| t.as_vec4()))
}

/// Vertex colours, where there are any and not all of them are white and opaque.
fn vertex_colors(mesh: &Mesh, corners: [usize; 3]) -> Option<[Vec4; 3]> {
    if mesh.colors.is_empty() {
        return None;
    }
    let colors = corners.map(|i| mesh.colors[i]);
    colors.iter().any(|c| *c != Vec4::ONE).then_some(colors)
}

/// Texture coordinates at a primitive's points a, a + u and a + v, those of the second set where
/// `second`; `None` where it has none.
pub fn texture_coordinates(
    scene: &Scene,
    primitive: &Primitive,
    second: bool,
) -> Option<[DVec2; 3]> {
    let corners = [DVec2::ZERO, DVec2::X, DVec2::Y];
    match primitive.geometry {
        PrimitiveGeometry::Rectangle { .. } => (!second).then(|| corners.map(rectangle_uv)),
        PrimitiveGeometry::Disk { .. } => (!second).then(|| corners.map(disk_uv)),
        PrimitiveGeometry::Sphere { .. } | PrimitiveGeometry::Ellipsoid { .. } => None,
        PrimitiveGeometry::Triangle { .. } => {
            let Geometry::Mesh(mesh) = &scene.shapes[primitive.shape.index()].geometry else {
                return None;
            };
            let all = if second { &mesh.second_uvs } else { &mesh.uvs };
            if all.is_empty() {
                return None;
            }
            let corners = mesh.triangles[primitive.part as usize];
            let uvs = corners.map(|i| all[i as usize]);
            uvs.iter().all(|uv| uv.is_finite()).then_some(uvs)
        }
    }
}
