//! Shapes as primitives in normalised space.

use crate::scene::ellipsoid::{self, PrincipalAxes, half_extent};
use crate::scene::normalize::{Normalization, disk_half_extent};
use crate::scene::{Geometry, MaterialId, Scene, ShapeId};
use glam::DVec3;

/// The smallest unit that a ray can hit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Primitive {
    /// Its geometry, normalised space.
    pub geometry: PrimitiveGeometry,
    /// How it scatters.
    pub material: MaterialId,
    /// The shape that it is a part of.
    pub shape: ShapeId,
    /// Which of a mesh's triangles it is; 0 of other shapes.
    pub part: u32,
}

/// Geometry of a primitive. A planar one holds the points `a + s·u + t·v`; its normal is `u × v`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PrimitiveGeometry {
    /// s, t ≥ 0, s + t ≤ 1.
    Triangle {
        /// First vertex.
        a: DVec3,
        /// Second vertex minus the first.
        u: DVec3,
        /// Third vertex minus the first.
        v: DVec3,
    },
    /// s, t in [0, 1].
    Rectangle {
        /// Corner.
        a: DVec3,
        /// Edge.
        u: DVec3,
        /// Edge.
        v: DVec3,
    },
    /// s² + t² ≤ 1.
    Disk {
        /// Centre.
        a: DVec3,
        /// Half axis.
        u: DVec3,
        /// Half axis.
        v: DVec3,
    },
    /// A sphere.
    Sphere {
        /// Centre.
        center: DVec3,
        /// Radius.
        radius: f64,
    },
    /// An ellipsoid: center + R (radii ∘ p), |p| ≤ 1.
    Ellipsoid {
        /// Centre.
        center: DVec3,
        /// Lengths of its half axes.
        radii: DVec3,
        /// Rodrigues vector of the rotation R.
        rodrigues: DVec3,
    },
}

impl PrimitiveGeometry {
    /// Surface area.
    pub fn area(&self) -> f64 {
        match *self {
            Self::Sphere { radius, .. } => 4.0 * std::f64::consts::PI * radius * radius,
            Self::Ellipsoid { radii, .. } => ellipsoid::surface(radii),
            _ => self.vector_area().map_or(0.0, DVec3::length),
        }
    }

    /// Its normal times its area; `None` where it is not planar.
    pub fn vector_area(&self) -> Option<DVec3> {
        match *self {
            Self::Triangle { u, v, .. } => Some(0.5 * u.cross(v)),
            Self::Rectangle { u, v, .. } => Some(u.cross(v)),
            Self::Disk { u, v, .. } => Some(std::f64::consts::PI * u.cross(v)),
            Self::Sphere { .. } | Self::Ellipsoid { .. } => None,
        }
    }

    /// Middle and radius of a sphere around it.
    pub fn bounding_sphere(&self) -> (DVec3, f64) {
        match *self {
            Self::Sphere { center, radius } => (center, radius),
            Self::Ellipsoid { center, radii, .. } => (center, radii.max_element()),
            Self::Triangle { .. } | Self::Rectangle { .. } | Self::Disk { .. } => {
                let (low, high) = self.bounds();
                (0.5 * (low + high), 0.5 * (high - low).length())
            }
        }
    }

    /// Whether it is a parallelogram whose edges are not orthogonal, or an ellipse whose half axes
    /// are not: by more than what writing them with seven digits turns them.
    pub fn is_skewed(&self) -> bool {
        match *self {
            Self::Rectangle { u, v, .. } | Self::Disk { u, v, .. } => {
                u.dot(v).abs() > 1e-6 * u.length() * v.length()
            }
            Self::Triangle { .. } | Self::Sphere { .. } | Self::Ellipsoid { .. } => false,
        }
    }

    /// Corners of the axis-parallel box around it.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        match *self {
            Self::Triangle { a, u, v } => {
                let (b, c) = (a + u, a + v);
                (a.min(b).min(c), a.max(b).max(c))
            }
            Self::Rectangle { a, u, v } => {
                let (b, c, d) = (a + u, a + v, a + u + v);
                (a.min(b).min(c).min(d), a.max(b).max(c).max(d))
            }
            Self::Disk { a, u, v } => {
                let half = disk_half_extent(u, v);
                (a - half, a + half)
            }
            Self::Sphere { center, radius } => {
                (center - DVec3::splat(radius), center + DVec3::splat(radius))
            }
            Self::Ellipsoid {
                center,
                radii,
                rodrigues,
            } => {
                let half = half_extent(PrincipalAxes { radii, rodrigues }.axes());
                (center - half, center + half)
            }
        }
    }
}

/// All primitives of a scene that a ray can meet, in the order of its shapes and their triangles.
pub fn primitives(scene: &Scene, normalization: &Normalization) -> Vec<Primitive> {
    let mut out = Vec::new();
    for (index, shape) in scene.shapes.iter().enumerate() {
        if scene.materials[shape.material.index()]
            .opacity
            .is_never_met()
        {
            continue;
        }
        let mut part = 0;
        let mut push = |geometry| {
            out.push(Primitive {
                geometry,
                material: shape.material,
                shape: ShapeId(index as u32),
                part,
            });
            part += 1;
        };
        match &shape.geometry {
            Geometry::Rectangle { corner, u, v } => push(PrimitiveGeometry::Rectangle {
                a: normalization.point(*corner),
                u: normalization.vector(*u),
                v: normalization.vector(*v),
            }),
            Geometry::Disk { center, u, v } => push(PrimitiveGeometry::Disk {
                a: normalization.point(*center),
                u: normalization.vector(*u),
                v: normalization.vector(*v),
            }),
            Geometry::Sphere { center, radius } => push(PrimitiveGeometry::Sphere {
                center: normalization.point(*center),
                radius: normalization.length(*radius),
            }),
            Geometry::Ellipsoid { center, axes } => {
                let PrincipalAxes { radii, rodrigues } = PrincipalAxes::of(*axes);
                push(PrimitiveGeometry::Ellipsoid {
                    center: normalization.point(*center),
                    radii: normalization.vector(radii),
                    rodrigues,
                });
            }
            Geometry::Mesh(mesh) => {
                for t in &mesh.triangles {
                    let [a, b, c] = t.map(|i| normalization.point(mesh.positions[i as usize]));
                    push(PrimitiveGeometry::Triangle {
                        a,
                        u: b - a,
                        v: c - a,
                    });
                }
            }
        }
    }
    out
}
