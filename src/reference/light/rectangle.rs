//! Points on parallelograms: uniform over their area, as coordinates (s, t) with the point corner + s·u + t·v, or uniform
//! over the solid angle in which a point sees them.

use super::triangle::{SphericalTriangle, sample_triangle_solid_angle, spherical_triangle};
use crate::reference::core::pdf::PdfArea;
use glam::{DVec2, DVec3};

/// The square is the parallelogram.
pub fn sample_rectangle_area(u: DVec2) -> DVec2 {
    u
}

/// Density of [`sample_rectangle_area`] on a parallelogram of area `area`.
pub fn pdf_rectangle_area(area: f64) -> PdfArea {
    PdfArea(1.0 / area)
}

/// A parallelogram seen from a point: two triangles that share the diagonal from its corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SphericalRectangle {
    /// On the side of edge u.
    pub first: SphericalTriangle,
    /// On the side of edge v.
    pub second: SphericalTriangle,
    /// Of both.
    pub solid_angle: f64,
}

/// The parallelogram with corner `a` and edges `u`, `v` seen from `x`.
pub fn spherical_rectangle(x: DVec3, a: DVec3, u: DVec3, v: DVec3) -> SphericalRectangle {
    let first = spherical_triangle(x, a + u, a, a + u + v);
    let second = spherical_triangle(x, a + u + v, a, a + v);
    SphericalRectangle {
        first,
        second,
        solid_angle: first.solid_angle + second.solid_angle,
    }
}

/// A unit direction into the parallelogram, uniform over its solid angle: u.x turns about the corner.
pub fn sample_rectangle_solid_angle(r: &SphericalRectangle, u: DVec2) -> DVec3 {
    let part = u.x * r.solid_angle;
    if part < r.first.solid_angle {
        sample_triangle_solid_angle(&r.first, part, u.y)
    } else {
        sample_triangle_solid_angle(&r.second, part - r.first.solid_angle, u.y)
    }
}
