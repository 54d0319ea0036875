//! Points on spheres: uniform over their area, or over the cone in which a point outside sees them.

use crate::reference::core::frame::{frame_from_normal, to_world};
use crate::reference::core::math::sin_cos_two_pi;
use crate::reference::core::pdf::{PdfArea, PdfSolidAngle};
use glam::{DVec2, DVec3};

/// A uniformly distributed unit vector (Archimedes: z is uniform).
pub fn sample_sphere_area(u: DVec2) -> DVec3 {
    let r = 2.0 * (u.x * (1.0 - u.x)).sqrt();
    let sc = sin_cos_two_pi(u.y);
    DVec3::new(r * sc.y, r * sc.x, 1.0 - 2.0 * u.x)
}

/// Density of [`sample_sphere_area`] on a sphere of area `area`.
pub fn pdf_sphere_area(area: f64) -> PdfArea {
    PdfArea(1.0 / area)
}

/// 1 − cosθ of the cone in which a sphere with the squared sine `sin_squared` = (r/d)² < 1 is seen.
/// The solid angle is 2π times this.
pub fn cone_height(sin_squared: f64) -> f64 {
    sin_squared / (1.0 + (1.0 - sin_squared).sqrt())
}

/// A unit direction, uniform over the cone of height `k` around the unit vector `axis`, and its 1 −
/// cosθ.
pub fn sample_cone(axis: DVec3, k: f64, u: DVec2) -> (DVec3, f64) {
    let height = u.x * k;
    let r = (height * (2.0 - height)).sqrt();
    let sc = sin_cos_two_pi(u.y);
    let local = DVec3::new(r * sc.y, r * sc.x, 1.0 - height);
    (to_world(&frame_from_normal(axis), local), height)
}

/// Density of [`sample_cone`].
pub fn pdf_cone(k: f64) -> PdfSolidAngle {
    PdfSolidAngle(1.0 / (std::f64::consts::TAU * k))
}

/// How far a squared distance may be off, relative to it, from the square of the radius: nearer, a
/// point counts as on the sphere.
const ON_SPHERE: f64 = 1e-6;

/// Whether `x` is within a sphere or on it.
pub fn within_sphere(center: DVec3, radius: f64, x: DVec3) -> bool {
    (center - x).length_squared() <= radius * radius * (1.0 + ON_SPHERE)
}

/// Distance from `x`, within a sphere or on it, to the sphere in the unit direction `wi`; 0 where
/// `x` is on it and `wi` leads out.
pub fn distance_within_sphere(center: DVec3, radius: f64, x: DVec3, wi: DVec3) -> f64 {
    let (to_center, r2) = (center - x, radius * radius);
    let along = to_center.dot(wi);
    if along <= 0.0 && to_center.length_squared() > r2 * (1.0 - ON_SPHERE) {
        return 0.0;
    }
    let off = (to_center - along * wi).length_squared();
    along + (r2 - off).max(0.0).sqrt()
}
