//! Points on triangles: uniform over their area, as coordinates (s, t) with the point a + s·(b − a) +
//! t·(c − a), or uniform over the solid angle in which a point sees them.

use crate::reference::core::pdf::{PdfArea, PdfSolidAngle};
use glam::DVec3;

pub use crate::emitters::area_map::{
    square_to_triangle as sample_triangle_area, triangle_to_square as invert_triangle_area,
};

/// Density of [`sample_triangle_area`] on a triangle of area `area`.
pub fn pdf_triangle_area(area: f64) -> PdfArea {
    PdfArea(1.0 / area)
}

/// A triangle seen from a point: unit directions to its vertices, and the solid angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SphericalTriangle {
    /// Towards the first vertex A.
    pub a: DVec3,
    /// Towards the second, B.
    pub b: DVec3,
    /// Towards the third, C.
    pub c: DVec3,
    /// |A · (B × C)|.
    pub determinant: f64,
    /// Its solid angle; 0 in its plane.
    pub solid_angle: f64,
}

/// The triangle with vertex `a` and the edges `u` and `v` from there to the others, seen from `x`
/// (Van Oosterom & Strackee 1983).
pub fn spherical_triangle(x: DVec3, a: DVec3, u: DVec3, v: DVec3) -> SphericalTriangle {
    let to_a = a - x;
    let triple = to_a.dot(u.cross(v)).abs();
    let vertices = [to_a, to_a + u, to_a + v];
    let [a, b, c] = vertices.map(DVec3::normalize_or_zero);
    let lengths: f64 = vertices.iter().map(|p| p.length()).product();
    let determinant = if lengths > 0.0 { triple / lengths } else { 0.0 };
    let angle = 2.0 * determinant.atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a));
    SphericalTriangle {
        a,
        b,
        c,
        determinant,
        solid_angle: if determinant > 0.0 { angle } else { 0.0 },
    }
}

/// The unit direction into the triangle for which the triangle between A, B and the side from B to
/// the direction's arc has the solid angle `part`, and which divides the way from A at `u` (Arvo
/// 1995, "Stratified Sampling of Spherical Triangles"; without inverse trigonometric functions by
/// Peters 2021, "BRDF Importance Sampling for Polygonal Lights").
pub fn sample_triangle_solid_angle(t: &SphericalTriangle, part: f64, u: f64) -> DVec3 {
    let (sin, cos) = (0.5 * part).sin_cos();
    // The bisector of B and the end Q of the direction's arc.
    let along = t.b * (t.determinant * cos - (t.b.dot(t.c) + t.a.dot(t.c)) * sin)
        + t.c * ((1.0 + t.a.dot(t.b)) * sin);
    let bisector = along.normalize_or(t.b);
    let q = 2.0 * t.b.dot(bisector) * bisector - t.b;
    let k = 0.5 * (t.a - q).length_squared();
    let s = (u * (2.0 - u * k) / (2.0 - k)).sqrt();
    ((1.0 - u * k - s * (1.0 - k)) * t.a + s * q).normalize()
}

/// Density of [`sample_triangle_solid_angle`] over a solid angle.
pub fn pdf_uniform_solid_angle(solid_angle: f64) -> PdfSolidAngle {
    PdfSolidAngle(1.0 / solid_angle)
}
