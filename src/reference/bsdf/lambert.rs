//! Ideal diffuse reflection, in the local frame: f_r = albedo / π.

use crate::reference::core::math::sin_cos_two_pi;
use crate::reference::core::pdf::PdfSolidAngle;
use crate::reference::light::disk::sample_disk_area;
use glam::{DVec2, DVec3};
use std::f64::consts::FRAC_1_PI;

/// A direction with density cosθ/π (Malley's method).
pub fn sample_lambert(u: DVec2) -> DVec3 {
    let p = sample_disk_area(u);
    p.extend((1.0 - p.length_squared()).max(0.0).sqrt())
}

/// A direction with density 1/2π.
pub fn sample_uniform_hemisphere(u: DVec2) -> DVec3 {
    let sc = sin_cos_two_pi(u.y);
    let r = (u.x * (2.0 - u.x)).sqrt();
    DVec3::new(r * sc.y, r * sc.x, 1.0 - u.x)
}

/// Density of [`sample_lambert`] at cosine `cos_i`; 0 below the horizon.
pub fn pdf_lambert(cos_i: f64) -> PdfSolidAngle {
    PdfSolidAngle(cos_i.max(0.0) * FRAC_1_PI)
}

/// f_r.
pub fn eval_lambert(albedo: DVec3) -> DVec3 {
    albedo * FRAC_1_PI
}
