//! The energy that a rough metal's GGX lobe leaves out; see `shaders/bsdf/compensation.wesl`.

use crate::scene::material::{Fresnel, SpecularLobe};
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;

/// Narrower lobes are left as they are.
pub const MIN_COMPENSATED_ALPHA: f64 = 1.0 / 128.0;

/// Coefficients of the powers of α, for each power of t.
const DEFICIT: [[f64; 4]; 5] = [
    [-0.0785, 0.0678, 2.5218, -0.046],
    [3.0124, -1.1348, -2.2279, -9.2564],
    [-12.8367, 5.8535, 8.0787, 39.5404],
    [23.8494, -10.3997, -13.5206, -68.7035],
    [-14.1119, 4.7011, 22.3821, 34.571],
];

/// 1 − E, t(1 − t) Σ c_ij tⁱ αʲ with t = μ/(μ + α/2).
pub fn ggx_albedo_deficit(cos_theta: f64, alpha: f64) -> f64 {
    let t = cos_theta / (cos_theta + 0.5 * alpha);
    let terms = DEFICIT.iter().zip(0..).flat_map(|(row, i)| {
        let of_alpha = row.iter().zip(0..);
        of_alpha.map(move |(c, j)| c * t.powi(i) * alpha.powi(j))
    });
    (t * (1.0 - t) * terms.sum::<f64>()).max(0.0)
}

/// 1 − Ē.
pub fn ggx_average_deficit(alpha: f64) -> f64 {
    let (a2, a3, a4) = (alpha.powi(2), alpha.powi(3), alpha.powi(4));
    (2.7939 * a2 + 11.4781 * a3 - 2.4819 * a4) / (1.0 + 3.4727 * alpha + 15.369 * a2)
}

/// F_ms; 0 where `lobe` is not compensated.
pub fn compensation_fresnel(lobe: &SpecularLobe) -> DVec3 {
    let coat = matches!(lobe.fresnel, Fresnel::Dielectric { .. });
    if !lobe.compensated || coat || lobe.alpha < MIN_COMPENSATED_ALPHA {
        return DVec3::ZERO;
    }
    let deficit = ggx_average_deficit(lobe.alpha);
    // Light that meets n + 1 facets in all: the sum of F̄ⁿ⁺¹ Ē (1 − Ē)ⁿ⁻¹ from n = 1.
    lobe.average * lobe.average * (1.0 - deficit) / (DVec3::ONE - lobe.average * deficit)
}

/// The part of light from everywhere that the lobe adds in the direction with cosine `cos_o`.
pub fn compensation_albedo(lobe: &SpecularLobe, cos_o: f64) -> DVec3 {
    compensation_fresnel(lobe) * ggx_albedo_deficit(cos_o, lobe.alpha)
}

/// f_r.
pub fn eval_compensation(lobe: &SpecularLobe, cos_i: f64, cos_o: f64) -> DVec3 {
    let directions = ggx_albedo_deficit(cos_i, lobe.alpha) * ggx_albedo_deficit(cos_o, lobe.alpha);
    compensation_fresnel(lobe) * (directions * FRAC_1_PI / ggx_average_deficit(lobe.alpha))
}
