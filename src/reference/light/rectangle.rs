//! Points on parallelograms: uniform over their area, as coordinates (s, t) with the point corner +
//! s·u + t·v, or uniform over the solid angle in which a point sees them.

use super::triangle::{SphericalTriangle, sample_triangle_solid_angle, spherical_triangle};
use crate::reference::core::frame::{ShadingFrame, to_world};
use crate::reference::core::pdf::PdfArea;
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// The square is the parallelogram.
pub fn sample_rectangle_area(u: DVec2) -> DVec2 {
    u
}

/// Density of [`sample_rectangle_area`] on a parallelogram of area `area`.
pub fn pdf_rectangle_area(area: f64) -> PdfArea {
    PdfArea(1.0 / area)
}

/// Heights below this are rounding: the point lies in the rectangle's plane and sees nothing of it.
pub const MIN_HEIGHT: f64 = 1e-12;

/// A rectangle seen from a point: in a frame along its edges with the point at the origin, x × y at
/// height z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SphericalRectangle {
    /// x is the axis along which the rectangle is nearer to the point's foot, or covers it; z
    /// points to its plane.
    pub frame: ShadingFrame,
    /// Whether x is the direction of edge v.
    pub turned: bool,
    /// Ends along x.
    pub x: DVec2,
    /// Ends along y.
    pub y: DVec2,
    /// Distance of its plane.
    pub z: f64,
    /// Interior angles where the edges x = x₁ (γ₀, γ₁) and x = x₀ (γ₂, γ₃) begin and end.
    angles: [f64; 4],
    /// Their sum less 2π; 0 in the rectangle's plane.
    pub solid_angle: f64,
}

/// A direction into a rectangle, and the coordinates (s, t) of the point there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RectangleSample {
    /// Unit direction.
    pub wi: DVec3,
    /// Coordinates of the point.
    pub st: DVec2,
}

/// The rectangle with corner `a` and edges `u` ⊥ `v` seen from `x`.
///
/// Solid angle = γ₀ + γ₁ + γ₂ + γ₃ − 2π, with the interior angles between the planes through
/// neighbouring edges (Girard).
pub fn spherical_rectangle(x: DVec3, a: DVec3, u: DVec3, v: DVec3) -> SphericalRectangle {
    let (along_u, along_v) = (u.normalize(), v.normalize());
    let corner = a - x;
    let normal = along_u.cross(along_v);
    let normal = if corner.dot(normal) > 0.0 {
        normal
    } else {
        -normal
    };
    let range = |axis: DVec3, edge: DVec3| {
        let low = corner.dot(axis);
        DVec2::new(low, low + edge.length())
    };
    let away = |range: DVec2| range.x.max(-range.y).max(0.0);
    let (on_u, on_v) = (range(along_u, u), range(along_v, v));
    let turned = away(on_u) > away(on_v);
    let (frame, x, y) = if turned {
        (frame(along_v, along_u, normal), on_v, on_u)
    } else {
        (frame(along_u, along_v, normal), on_u, on_v)
    };
    let z = corner.dot(normal);
    let angles = interior_angles(x, y, z);
    let solid_angle = if z > MIN_HEIGHT {
        angles.iter().sum::<f64>() - TAU
    } else {
        0.0
    };
    SphericalRectangle {
        frame,
        turned,
        x,
        y,
        z,
        angles,
        solid_angle,
    }
}

fn frame(x: DVec3, y: DVec3, z: DVec3) -> ShadingFrame {
    ShadingFrame { x, y, z }
}

/// γ₀ between the edges y = y₀ and x = x₁, and so on around the rectangle.
fn interior_angles(x: DVec2, y: DVec2, z: f64) -> [f64; 4] {
    let corners = [(x.x, y.x), (x.y, y.x), (x.y, y.y), (x.x, y.y)];
    let corners = corners.map(|(x, y)| DVec3::new(x, y, -z));
    let normal = |i: usize| corners[i].cross(corners[(i + 1) % 4]);
    std::array::from_fn(|i| {
        let (n, next) = (normal(i), normal((i + 1) % 4));
        n.cross(next).length().atan2(-n.dot(next))
    })
}

/// A direction into the rectangle, uniform over its solid angle, and the point there (Ureña,
/// Fajardo & King 2013, "An Area-Preserving Parametrization for Spherical Rectangles").
pub fn sample_rectangle_solid_angle(r: &SphericalRectangle, u: DVec2) -> RectangleSample {
    // The paper has the plane at z₀ < 0, and b₀, b₁ for the heights of the normals of the edges
    // along x.
    let (x, y, z0) = (r.x, r.y, -r.z);
    let b0 = -y.x / y.x.hypot(z0);
    let b1 = y.y / y.y.hypot(z0);
    let k = TAU - r.angles[2] - r.angles[3];
    let (sin, cos) = (u.x * r.solid_angle + k).sin_cos();
    let fu = (cos * b0 - b1) / sin;
    let cu = (1.0 / fu.hypot(b0)).copysign(fu).clamp(-1.0, 1.0);
    let xu = (-cu * z0 / (1.0 - cu * cu).max(f64::MIN_POSITIVE).sqrt()).clamp(x.x, x.y);
    let d = xu.hypot(z0);
    let h = [y.x, y.y].map(|y| y / y.hypot(d));
    let hv = h[0] + u.y * (h[1] - h[0]);
    let yv = (hv * d / (1.0 - hv * hv).max(f64::MIN_POSITIVE).sqrt()).clamp(y.x, y.y);
    let s = (xu - x.x) / (x.y - x.x);
    let t = (yv - y.x) / (y.y - y.x);
    RectangleSample {
        wi: to_world(&r.frame, DVec3::new(xu, yv, r.z)).normalize(),
        st: if r.turned {
            DVec2::new(t, s)
        } else {
            DVec2::new(s, t)
        },
    }
}

/// A parallelogram seen from a point: two triangles that share the diagonal from its corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SphericalParallelogram {
    /// On the side of edge u.
    pub first: SphericalTriangle,
    /// On the side of edge v.
    pub second: SphericalTriangle,
    /// Of both.
    pub solid_angle: f64,
}

/// The parallelogram with corner `a` and edges `u`, `v` seen from `x`.
pub fn spherical_parallelogram(x: DVec3, a: DVec3, u: DVec3, v: DVec3) -> SphericalParallelogram {
    let first = spherical_triangle(x, a, u, u + v);
    let second = spherical_triangle(x, a, u + v, v);
    SphericalParallelogram {
        first,
        second,
        solid_angle: first.solid_angle + second.solid_angle,
    }
}

/// A unit direction into the parallelogram, uniform over its solid angle: u.x turns about the
/// corner.
pub fn sample_parallelogram_solid_angle(p: &SphericalParallelogram, u: DVec2) -> DVec3 {
    let part = u.x * p.solid_angle;
    if part < p.first.solid_angle {
        sample_triangle_solid_angle(&p.first, part, u.y)
    } else {
        sample_triangle_solid_angle(&p.second, part - p.first.solid_angle, u.y)
    }
}
