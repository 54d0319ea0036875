//! What a set of lights is known by: where it is, which way it shines, and how much.

use crate::accel::PrimitiveGeometry;
use crate::emitters::luminance;
use crate::scene::Light;
use glam::{DQuat, DVec3};
use std::f64::consts::{FRAC_PI_2, PI};

/// A cone of directions, the bound on normals or axes of lights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cone {
    /// Unit axis.
    pub axis: DVec3,
    /// Largest angle from the axis, at most π.
    pub angle: f64,
}

impl Cone {
    /// All directions.
    pub const SPHERE: Self = Self {
        axis: DVec3::Z,
        angle: PI,
    };

    /// The smallest cone around both (Conty Estevez & Kulla 2018, section 4.2).
    pub fn union(self, other: Self) -> Self {
        let (wide, narrow) = if self.angle >= other.angle {
            (self, other)
        } else {
            (other, self)
        };
        let cross = wide.axis.cross(narrow.axis);
        let between = cross.length().atan2(wide.axis.dot(narrow.axis));
        if (between + narrow.angle).min(PI) <= wide.angle {
            return wide;
        }
        let angle = 0.5 * (wide.angle + between + narrow.angle);
        let Some(turn) = cross.try_normalize().filter(|_| angle < PI) else {
            return Self::SPHERE;
        };
        let axis = DQuat::from_axis_angle(turn, angle - wide.angle) * wide.axis;
        Self {
            axis: axis.normalize(),
            angle,
        }
    }
}

/// Bounds of lights (Conty Estevez & Kulla 2018, section 4; pbrt-4's `LightBounds`). Normalised
/// space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightBounds {
    /// Lower corner of the box around them.
    pub low: DVec3,
    /// Upper corner.
    pub high: DVec3,
    /// Sum of their radiant intensities (luminance), each in the direction in which it is largest:
    /// what arrives at a point from a lamp of any kind is that over d². pbrt-4 takes 4π times as
    /// much of point lights.
    pub intensity: f64,
    /// Their normals, or the axes around which they shine with full intensity: θ_o is its angle.
    pub normals: Cone,
    /// θ_e: how far from a normal they emit, at most π/2.
    pub emission: f64,
    /// Whether any of them emits on both sides.
    pub two_sided: bool,
}

impl LightBounds {
    /// Those of both.
    pub fn union(self, other: Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            intensity: self.intensity + other.intensity,
            normals: self.normals.union(other.normals),
            emission: self.emission.max(other.emission),
            two_sided: self.two_sided || other.two_sided,
        }
    }

    /// Centre of the box.
    pub fn centre(&self) -> DVec3 {
        0.5 * (self.low + self.high)
    }

    /// Cost of a child in the surface-area-orientation heuristic: intensity times the box's surface
    /// times M_Ω = 2π (1 − cosθ_o) + π/2 (2 θ_w sinθ_o − cos(θ_o − 2θ_w) − 2 θ_o sinθ_o + cosθ_o),
    /// θ_w = min(θ_o + θ_e, π) (Conty Estevez & Kulla 2018, eq. 1).
    pub fn cost(&self) -> f64 {
        let o = self.normals.angle;
        let w = (o + self.emission).min(PI);
        let (sin, cos) = o.sin_cos();
        let within = 2.0 * PI * (1.0 - cos);
        let fringe = 2.0 * w * sin - (o - 2.0 * w).cos() - 2.0 * o * sin + cos;
        let size = self.high - self.low;
        let surface = 2.0 * (size.x * size.y + size.y * size.z + size.z * size.x);
        self.intensity * (within + FRAC_PI_2 * fringe) * surface
    }
}

/// One light of a tree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TreeLight {
    /// Its index among the emitters.
    pub index: u32,
    /// Its bounds.
    pub bounds: LightBounds,
    /// Points whose spheres of `radius` cover it.
    points: [DVec3; 4],
    radius: f64,
}

impl TreeLight {
    /// A surface that emits radiance of the luminance `radiance`.
    pub fn area(index: u32, geometry: &PrimitiveGeometry, radiance: f64, two_sided: bool) -> Self {
        let (low, high) = geometry.bounds();
        let (points, radius) = match *geometry {
            PrimitiveGeometry::Triangle { a, u, v } => ([a, a + u, a + v, a], 0.0),
            PrimitiveGeometry::Rectangle { a, u, v } => ([a, a + u, a + v, a + u + v], 0.0),
            PrimitiveGeometry::Disk { a, u, v } if geometry.is_skewed() => {
                ([a; 4], u.length().hypot(v.length()))
            }
            PrimitiveGeometry::Disk { a, u, v } => ([a; 4], u.length().max(v.length())),
            PrimitiveGeometry::Sphere { center, radius } => ([center; 4], radius),
            PrimitiveGeometry::Ellipsoid { center, radii, .. } => {
                ([center; 4], radii.max_element())
            }
        };
        let (normals, seen) = match *geometry {
            PrimitiveGeometry::Triangle { u, v, .. }
            | PrimitiveGeometry::Rectangle { u, v, .. }
            | PrimitiveGeometry::Disk { u, v, .. } => {
                let normal = u.cross(v).normalize_or(DVec3::Z);
                let normals = Cone {
                    axis: normal,
                    angle: 0.0,
                };
                (normals, geometry.area())
            }
            PrimitiveGeometry::Sphere { .. } => (Cone::SPHERE, 0.25 * geometry.area()),
            // Along its shortest axis an ellipsoid looks largest.
            PrimitiveGeometry::Ellipsoid { radii, .. } => {
                let seen = PI * radii.element_product() / radii.min_element();
                (Cone::SPHERE, seen)
            }
        };
        let bounds = LightBounds {
            low,
            high,
            intensity: radiance * seen,
            normals,
            emission: FRAC_PI_2,
            two_sided,
        };
        Self {
            index,
            bounds,
            points,
            radius,
        }
    }

    /// A light without a surface; `None` for one that is infinitely far away.
    pub fn delta(index: u32, light: &Light) -> Option<Self> {
        let position = light.position()?;
        let (normals, emission) = match light.spread() {
            Some(spread) => {
                let normals = Cone {
                    axis: spread.axis,
                    angle: spread.full_angle,
                };
                (normals, spread.falloff_angle)
            }
            None => (Cone::SPHERE, FRAC_PI_2),
        };
        let bounds = LightBounds {
            low: position,
            high: position,
            intensity: luminance(light.strength()),
            normals,
            emission,
            two_sided: false,
        };
        Some(Self {
            index,
            bounds,
            points: [position; 4],
            radius: 0.0,
        })
    }

    /// A point of it, for tests: of two coordinates in [0, 1].
    #[cfg(test)]
    pub(super) fn some_point(&self, [s, t]: [f64; 2]) -> DVec3 {
        let [a, b, c, d] = self.points;
        let (s, t) = if s + t > 1.0 && d == a {
            (1.0 - s, 1.0 - t)
        } else {
            (s, t)
        };
        let on_hull = a + s * (b - a) + t * (c - a);
        let angle = std::f64::consts::TAU * t;
        let around = self.bounds.normals.axis.any_orthonormal_pair();
        let shortest = 0.5 * (self.bounds.high - self.bounds.low).length() / 3_f64.sqrt();
        let radius = self.radius.min(shortest) * s;
        on_hull + radius * (angle.cos() * around.0 + angle.sin() * around.1)
    }

    /// Distance of its farthest point from `centre`, or more.
    pub fn reach(&self, centre: DVec3) -> f64 {
        let distances = self.points.map(|p| p.distance(centre));
        distances.into_iter().fold(0.0, f64::max) + self.radius
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cone(axis: DVec3, angle: f64) -> Cone {
        Cone {
            axis: axis.normalize(),
            angle,
        }
    }

    fn angle_between(a: DVec3, b: DVec3) -> f64 {
        a.cross(b).length().atan2(a.dot(b))
    }

    #[test]
    fn the_union_of_cones_touches_both() {
        let a = cone(DVec3::Z, 0.2);
        let b = cone(DVec3::X, 0.3);
        let both = a.union(b);
        assert!((both.angle - 0.5 * (0.2 + FRAC_PI_2 + 0.3)).abs() < 1e-12);
        for c in [a, b] {
            let farthest = angle_between(both.axis, c.axis) + c.angle;
            assert!((farthest - both.angle).abs() < 1e-12, "{c:?}");
        }
    }

    #[test]
    fn a_cone_within_another_adds_nothing() {
        let wide = cone(DVec3::new(0.1, 0.2, 1.0), 1.0);
        let narrow = cone(DVec3::new(0.2, 0.0, 1.0), 0.1);
        assert_eq!(wide.union(narrow), wide);
        assert_eq!(narrow.union(wide), wide);
        assert_eq!(wide.union(Cone::SPHERE), Cone::SPHERE);
        assert_eq!(
            cone(DVec3::Z, 0.0).union(cone(DVec3::NEG_Z, 0.0)),
            Cone::SPHERE
        );
    }

    /// Of a flat light M_Ω is π, of one that emits over the sphere 4π.
    #[test]
    fn the_measure_of_orientation_is_the_papers() {
        let mut bounds = LightBounds {
            low: DVec3::ZERO,
            high: DVec3::ONE,
            intensity: 2.0,
            normals: cone(DVec3::Z, 0.0),
            emission: FRAC_PI_2,
            two_sided: false,
        };
        assert!((bounds.cost() - 2.0 * PI * 6.0).abs() < 1e-12);
        bounds.normals = Cone::SPHERE;
        assert!((bounds.cost() - 2.0 * 4.0 * PI * 6.0).abs() < 1e-12);
    }
}
