//! Uniform points on spheres.

use crate::reference::core::math::sin_cos_two_pi;
use crate::reference::core::pdf::PdfArea;
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
