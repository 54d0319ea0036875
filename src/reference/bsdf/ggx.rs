//! GGX microfacets; see `shaders/bsdf/ggx.wesl`. Densities are written as the papers have them.

use crate::reference::core::math::sin_cos_two_pi;
use crate::reference::core::pdf::PdfSolidAngle;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// D(h) = α² / (π ((n·h)²(α² − 1) + 1)²) (Walter et al. 2007, eq. 33), with 1 − (n·h)² from the
/// tangential components.
pub fn ggx_distribution(h: DVec3, alpha: f64) -> f64 {
    let a2 = alpha * alpha;
    let s = h.x * h.x + h.y * h.y + a2 * h.z * h.z;
    a2 / (PI * s * s)
}

/// Smith's Λ (Heitz 2014, eq. 72).
pub fn ggx_lambda(w: DVec3, alpha: f64) -> f64 {
    let tan2 = (w.x * w.x + w.y * w.y) / (w.z * w.z);
    0.5 * ((1.0 + alpha * alpha * tan2).sqrt() - 1.0)
}

/// G2 / (4 cosθ_i cosθ_o) with height-correlated G2 = 1 / (1 + Λ_i + Λ_o) (Heitz 2014, eq. 99).
pub fn ggx_visibility(wi: DVec3, wo: DVec3, alpha: f64) -> f64 {
    let g2 = 1.0 / (1.0 + ggx_lambda(wi, alpha) + ggx_lambda(wo, alpha));
    g2 / (4.0 * wi.z * wo.z)
}

/// A microfacet normal with the density of visible normals (Dupuy & Benyoub 2023, "Sampling Visible
/// GGX Normals with Spherical Caps").
pub fn sample_ggx_visible_normal(wo: DVec3, alpha: f64, u: DVec2) -> DVec3 {
    let stretched = DVec3::new(alpha * wo.x, alpha * wo.y, wo.z).normalize();
    let z = (1.0 - u.y) * (1.0 + stretched.z) - stretched.z;
    let r = (1.0 - z * z).clamp(0.0, 1.0).sqrt();
    let sc = sin_cos_two_pi(u.x);
    let cap = DVec3::new(r * sc.y, r * sc.x, z) + stretched;
    DVec3::new(alpha * cap.x, alpha * cap.y, cap.z.max(1e-7)).normalize()
}

/// Density of the reflection of `wo` about a visible normal `h`: D·G1(ω_o) / (4 cosθ_o) (Heitz
/// 2018, eq. 17).
pub fn pdf_ggx(wo: DVec3, h: DVec3, alpha: f64) -> PdfSolidAngle {
    let g1 = 1.0 / (1.0 + ggx_lambda(wo, alpha));
    PdfSolidAngle(ggx_distribution(h, alpha) * g1 / (4.0 * wo.z))
}

/// f_r without Fresnel: D·G2 / (4 cosθ_i cosθ_o).
pub fn eval_ggx(wi: DVec3, wo: DVec3, h: DVec3, alpha: f64) -> f64 {
    ggx_distribution(h, alpha) * ggx_visibility(wi, wo, alpha)
}
