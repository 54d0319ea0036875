//! Geometry, in world space and f64.

use super::ids::MaterialId;
use super::texture::TextureUse;
use glam::{DMat3, DVec2, DVec3, DVec4, Vec4};

/// A surface of the scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// Where it came from, for messages: `shapes[3]`, `shapes[2]: lens (mesh 4)`.
    pub name: String,
    /// Its geometry.
    pub geometry: Geometry,
    /// How it scatters.
    pub material: MaterialId,
    /// What it emits.
    pub emission: Option<Emission>,
}

/// Geometry in world space. The front is the side that the normal points to.
#[derive(Debug, Clone, PartialEq)]
pub enum Geometry {
    /// The parallelogram `corner + s·u + t·v`, s and t in [0, 1]; its normal is `u × v`.
    Rectangle {
        /// One corner.
        corner: DVec3,
        /// Edge from the corner.
        u: DVec3,
        /// Other edge from the corner.
        v: DVec3,
    },
    /// The disk (or ellipse) `center + s·u + t·v`, s² + t² ≤ 1; its normal is `u × v`.
    Disk {
        /// Centre.
        center: DVec3,
        /// Half axis.
        u: DVec3,
        /// Other half axis.
        v: DVec3,
    },
    /// A sphere; its normal points outwards.
    Sphere {
        /// Centre.
        center: DVec3,
        /// Radius, above 0.
        radius: f64,
    },
    /// The ellipsoid `center + axes·p`, |p| ≤ 1; its normal points outwards.
    Ellipsoid {
        /// Centre.
        center: DVec3,
        /// An invertible map; its columns need not be orthogonal.
        axes: DMat3,
    },
    /// A triangle mesh; a triangle's normal is `(b − a) × (c − a)`.
    Mesh(Mesh),
}

impl Shape {
    /// The field that it came from: `shapes[3]` of `shapes[3]: lens (mesh 4)`.
    pub fn field(&self) -> &str {
        let end = self.name.find([':', ' ']).unwrap_or(self.name.len());
        &self.name[..end]
    }
}

impl Geometry {
    /// Largest magnitude of a coordinate of what it is given by.
    pub fn farthest(&self) -> f64 {
        let of_points = |points: &[DVec3]| {
            let coordinates = points.iter().map(|p| p.abs().max_element());
            coordinates.fold(0.0, f64::max)
        };
        match self {
            Self::Rectangle { corner: p, u, v } | Self::Disk { center: p, u, v } => {
                of_points(&[*p, *u, *v])
            }
            Self::Sphere { center, radius } => of_points(&[*center]).max(*radius),
            Self::Ellipsoid { center, axes } => {
                of_points(&[*center, axes.x_axis, axes.y_axis, axes.z_axis])
            }
            Self::Mesh(mesh) => of_points(&mesh.positions),
        }
    }

    /// Primitives that it consists of.
    pub fn primitives(&self) -> u64 {
        match self {
            Self::Rectangle { .. }
            | Self::Disk { .. }
            | Self::Sphere { .. }
            | Self::Ellipsoid { .. } => 1,
            Self::Mesh(mesh) => mesh.triangles.len() as u64,
        }
    }
}

/// An indexed triangle mesh. Every index is below `positions.len()`, and no triangle has zero area.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    /// Vertex positions.
    pub positions: Vec<DVec3>,
    /// Three vertex indices per triangle, counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// Shading normals, one per position, or none: then the triangles are flat. Not necessarily of
    /// unit length.
    pub normals: Vec<DVec3>,
    /// Texture coordinates, one per position, or none; (0, 0) is the upper left corner of an image.
    pub uvs: Vec<DVec2>,
    /// Further texture coordinates, likewise, for textures that are read with them.
    pub second_uvs: Vec<DVec2>,
    /// Vertex colours, one per position, or none: linear factors in [0, 1] on the reflectance or
    /// base colour (red, green, blue) and on the opacity (alpha). Interpolated over triangles.
    pub colors: Vec<Vec4>,
    /// Directions in which u of a normal map grows, one per position, or none: then the texture
    /// coordinates give them. The fourth number, 1 or −1, is that of n × t along which v falls
    /// (glTF 2.0, section 3.7.2.1).
    pub tangents: Vec<DVec4>,
}

impl Mesh {
    /// The axis-parallel box around its triangles; `None` where there is none.
    pub fn bounds(&self) -> Option<(DVec3, DVec3)> {
        let corners = self.triangles.iter().flatten();
        let corners = corners.map(|&i| self.positions[i as usize]);
        corners.fold(None, |bounds, p| {
            let (low, high) = bounds.unwrap_or((p, p));
            Some((low.min(p), high.max(p)))
        })
    }
}

/// What a surface emits, the same in all directions of its emitting sides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Emission {
    /// Radiance per channel (W·sr⁻¹·m⁻²; from glTF: nit).
    pub radiance: DVec3,
    /// Factor on it that varies over the surface.
    pub texture: Option<TextureUse>,
    /// Whether the back emits as well.
    pub two_sided: bool,
}
