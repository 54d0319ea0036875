//! Ellipsoids as lights: the image M·p + center of the unit sphere |p| = 1.

use super::area_light::MIN_SOLID_ANGLE;
use super::rectangle::{SphericalRectangle, sample_rectangle_solid_angle, spherical_rectangle};
use super::sphere::{cone_height, sample_cone};
use crate::accel::PrimitiveGeometry;
use crate::reference::core::frame::frame_from_normal;
use crate::reference::core::math::max_abs;
use crate::reference::core::pdf::PdfArea;
use crate::reference::scene::surface::OFFSET;
use crate::scene::ellipsoid::PrincipalAxes;
use glam::{DMat3, DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// An ellipsoid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ellipsoid {
    /// Centre.
    pub center: DVec3,
    /// Half axes as columns: the map M.
    pub axes: DMat3,
    /// Length of the longest.
    pub longest: f64,
}

impl Ellipsoid {
    /// That of `geometry`; `None` of another kind.
    pub fn of(geometry: &PrimitiveGeometry) -> Option<Self> {
        let PrimitiveGeometry::Ellipsoid {
            center,
            radii,
            rodrigues,
        } = *geometry
        else {
            return None;
        };
        Some(Self {
            center,
            axes: PrincipalAxes { radii, rodrigues }.axes(),
            longest: radii.max_element(),
        })
    }

    /// That of `geometry`, a sphere as well; `None` of a planar one.
    pub fn or_sphere(geometry: &PrimitiveGeometry) -> Option<Self> {
        match *geometry {
            PrimitiveGeometry::Sphere { center, radius } => Some(Self {
                center,
                axes: DMat3::from_diagonal(DVec3::splat(radius)),
                longest: radius,
            }),
            _ => Self::of(geometry),
        }
    }

    /// Size of its coordinates.
    pub fn extent(&self) -> f64 {
        max_abs(self.center) + self.longest
    }

    /// A length at most as large as the radii of curvature at the point `position` of the surface:
    /// 1/|∂n/∂x| is at least c² |M⁻ᵀp|, c the shortest half axis.
    pub fn curvature_radius(&self, position: DVec3) -> f64 {
        let p = (self.axes.inverse() * (position - self.center)).normalize();
        let lengths = [0, 1, 2].map(|i| self.axes.col(i).length());
        let shortest = lengths.into_iter().fold(f64::INFINITY, f64::min);
        shortest * shortest * self.apply_transposed_inverse(p).length()
    }

    /// The image of the unit sphere's point `p`.
    pub fn point(&self, p: DVec3) -> DVec3 {
        self.center + self.axes * p
    }

    fn apply_transposed_inverse(&self, p: DVec3) -> DVec3 {
        self.axes.inverse().transpose() * p
    }
}

/// Density of the image of a uniformly distributed point `p` of the unit sphere: areas are
/// stretched by |det M| |M⁻ᵀp|.
pub fn pdf_ellipsoid_area(e: &Ellipsoid, p: DVec3) -> PdfArea {
    let stretch = e.axes.determinant().abs() * e.apply_transposed_inverse(p).length();
    PdfArea(1.0 / (4.0 * PI * stretch))
}

/// An ellipsoid as a point sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EllipsoidView {
    /// The ellipsoid.
    pub ellipsoid: Ellipsoid,
    /// The point.
    pub x: DVec3,
    /// From it to the centre, in the sphere's space.
    pub to_center: DVec3,
    /// Whether it is within or on the ellipsoid.
    pub within: bool,
    /// Whether it is on it, as far as f32 tells.
    pub on_surface: bool,
    /// Whether the cone in which it is seen is so narrow that it is sampled as a cone.
    pub narrow: bool,
}

/// How much the distance of the outline's points may vary, relative to it and squared, where the
/// cone is sampled as a cone.
const NARROW: f64 = 0.1;

/// Points nearer to the surface than rays leave it count as on it.
pub fn view_ellipsoid(ellipsoid: Ellipsoid, x: DVec3) -> EllipsoidView {
    let to_sphere = ellipsoid.axes.inverse();
    let to_center = to_sphere * (ellipsoid.center - x);
    let squared = to_center.length_squared();
    let principal = DVec3::from_array([0, 1, 2].map(|i| ellipsoid.axes.col(i).length()));
    let off = 2.0 * OFFSET * ellipsoid.extent() * max_abs(to_center / principal);
    let [u, v] = conjugate_axes(&ellipsoid, to_center);
    // The outline, larger by a factor that its distance has as well.
    let to_middle = (1.0 - 1.0 / squared).max(0.0).sqrt() * (ellipsoid.center - x);
    let size = u.length_squared() + v.length_squared();
    let along = to_middle.dot(u).powi(2) + to_middle.dot(v).powi(2);
    let middle = to_middle.length_squared();
    EllipsoidView {
        ellipsoid,
        x,
        to_center,
        within: squared - 1.0 <= off,
        on_surface: (squared - 1.0).abs() <= off,
        narrow: size <= middle && along <= NARROW * middle * middle,
    }
}

/// Images of two orthogonal unit vectors across the sphere's direction: conjugate half axes of the
/// ellipsoid's section through its centre parallel to its outline.
pub fn conjugate_axes(e: &Ellipsoid, to_center: DVec3) -> [DVec3; 2] {
    let frame = frame_from_normal(to_center.normalize_or(DVec3::Z));
    [e.axes * frame.x, e.axes * frame.y]
}

impl EllipsoidView {
    /// 1 − cosθ of the cone in the sphere's space.
    fn height(&self) -> f64 {
        cone_height(1.0 / self.to_center.length_squared())
    }

    /// One over the density, in the unit direction `wi`, of directions d that are uniform over the
    /// cone in the sphere's space, and are then mapped by M: dω' = |det M|/|M d|³ dω.
    fn inverse_cone_density(&self, wi: DVec3) -> f64 {
        let axes = self.ellipsoid.axes;
        let d = (axes.inverse() * wi).normalize();
        TAU * self.height() * axes.determinant().abs() / (axes * d).length().powi(3)
    }

    /// The rectangle around the outline, along its axes.
    fn rectangle_around(&self) -> SphericalRectangle {
        let e = &self.ellipsoid;
        let squared = self.to_center.length_squared();
        let [u, v] = conjugate_axes(e, self.to_center);
        let (difference, product) = (u.length_squared() - v.length_squared(), 2.0 * u.dot(v));
        let (mut sin, mut cos) = (0.5 * product.atan2(difference)).sin_cos();
        if difference < 0.0 && product < 0.0 {
            // The same axis, seen the other way.
            (sin, cos) = (-sin, -cos);
        }
        let along = (cos * u + sin * v).normalize();
        let normal = e.apply_transposed_inverse(self.to_center).normalize();
        let across = normal.cross(along);
        let part = 1.0 - 1.0 / squared;
        let half = |direction: DVec3| part.sqrt() * u.dot(direction).hypot(v.dot(direction));
        let slack = 1e-6 * (half(along) + half(across));
        let [along, across] = [along, across].map(|d| (half(d) + slack) * d);
        let center = part * (e.center - self.x);
        spherical_rectangle(
            DVec3::ZERO,
            center - along - across,
            2.0 * along,
            2.0 * across,
        )
    }

    /// One over the density with which light sampling chooses the unit direction `wi`; `None` where
    /// it samples the area. The point must be outside.
    pub fn inverse_direction_density(&self, wi: DVec3) -> Option<f64> {
        if self.narrow {
            let middle = (self.ellipsoid.center - self.x).normalize();
            let sampled = self.inverse_cone_density(middle) >= MIN_SOLID_ANGLE;
            return sampled.then(|| self.inverse_cone_density(wi));
        }
        Some(self.rectangle_around().solid_angle).filter(|&angle| angle >= MIN_SOLID_ANGLE)
    }

    /// A unit direction towards the ellipsoid; beside it where it is not narrow and the rectangle
    /// around was met alone.
    pub fn sample_direction(&self, u: DVec2) -> DVec3 {
        if self.narrow {
            let d = sample_cone(self.to_center.normalize(), self.height(), u).0;
            return (self.ellipsoid.axes * d).normalize();
        }
        sample_rectangle_solid_angle(&self.rectangle_around(), u).wi
    }

    /// The unit sphere's point at which the ray in the unit direction `wi` meets the ellipsoid:
    /// from outside where it enters, from within where it leaves; `None` where it misses, or leads
    /// out of the surface. On the border of the narrow cone rounding decides, so that it is met.
    pub fn point_in_direction(&self, wi: DVec3) -> Option<DVec3> {
        let d = (self.ellipsoid.axes.inverse() * wi).normalize();
        let along = self.to_center.dot(d);
        if self.on_surface && self.to_center.dot(self.ellipsoid.axes.inverse() * wi) <= 0.0 {
            return None;
        }
        let closest = self.to_center - along * d;
        let square = 1.0 - closest.length_squared();
        if square < 0.0 && !self.narrow {
            return None;
        }
        let half = square.max(0.0).sqrt();
        let side = if self.within { 1.0 } else { -1.0 };
        Some((side * half * d - closest).normalize())
    }
}
