//! The GGX microfacet BRDF with height-correlated shadowing, and its directional albedo.
//!
//! Directions are unit vectors in a local frame whose normal is +z.

use super::cubature::{Tolerance, integrate};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI};

/// D(h), the density of microfacet normals, in 1/sr: α²/(π((hx² + hy²) + α²hz²)²) with |h| = 1
/// (Walter et al. 2007, equation 33). Without cancellation for small α. 0 below the surface.
pub fn distribution(h: DVec3, alpha: f64) -> f64 {
    if h.z <= 0.0 {
        return 0.0;
    }
    let a2 = alpha * alpha;
    let t = h.x * h.x + h.y * h.y + a2 * h.z * h.z;
    a2 / (PI * t * t)
}

/// G₂/(4 cosθ_o cosθ_i) with height-correlated Smith shadowing (Heitz 2014, equation 99), finite at
/// grazing angles: ½/(μ_o√(μ_i² + α²(1 − μ_i²)) + μ_i√(μ_o² + α²(1 − μ_o²))), μ the cosines.
pub fn visibility(wo: DVec3, wi: DVec3, alpha: f64) -> f64 {
    let root = |w: DVec3| (w.z * w.z + alpha * alpha * (w.x * w.x + w.y * w.y)).sqrt();
    0.5 / (wo.z * root(wi) + wi.z * root(wo))
}

/// A GGX lobe with Schlick's Fresnel term.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lobe {
    /// Width α in (0, 1].
    pub alpha: f64,
    /// Reflectance at normal incidence.
    pub f0: DVec3,
}

impl Lobe {
    /// f_r(wo, wi) in 1/sr: D·G₂·F/(4 cosθ_o cosθ_i), F = F₀ + (1 − F₀)(1 − wo·h)⁵. 0 unless both
    /// are above the surface.
    pub fn eval(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        let Some((weight, fifth)) = unit_lobe(wo, wi, self.alpha) else {
            return DVec3::ZERO;
        };
        (self.f0 + (DVec3::ONE - self.f0) * fifth) * weight
    }
}

/// f_r for F = 1, and (1 − wo·h)⁵.
fn unit_lobe(wo: DVec3, wi: DVec3, alpha: f64) -> Option<(f64, f64)> {
    if wo.z <= 0.0 || wi.z <= 0.0 {
        return None;
    }
    let h = (wo + wi).normalize();
    let weight = distribution(h, alpha) * visibility(wo, wi, alpha);
    Some((weight, (1.0 - wo.dot(h)).max(0.0).powi(5)))
}

/// Directional albedo E(F₀) = ∫ f_r cosθ_i dω_i = F₀·`scale` + `bias` with Schlick's Fresnel term.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Albedo {
    /// Factor of F₀.
    pub scale: f64,
    /// What is left for F₀ = 0.
    pub bias: f64,
}

impl Albedo {
    /// E for F = 1: what single scattering keeps of the energy.
    pub fn total(&self) -> f64 {
        self.scale + self.bias
    }
}

/// Directional albedo of a GGX lobe of width `alpha` for an outgoing direction with cosine `cos_o`
/// in (0, 1], by cubature with an error below 1e-11.
pub fn directional_albedo(alpha: f64, cos_o: f64) -> Albedo {
    let sin_o = ((1.0 - cos_o) * (1.0 + cos_o)).sqrt();
    let wo = DVec3::new(sin_o, 0.0, cos_o);
    let theta_o = sin_o.atan2(cos_o);
    // φ from the mirror direction; both halves are alike.
    let f = |theta: f64, phi: f64| {
        let (sin, cos) = theta.sin_cos();
        let wi = DVec3::new(-sin * phi.cos(), sin * phi.sin(), cos);
        let Some((weight, fifth)) = unit_lobe(wo, wi, alpha) else {
            return DVec3::ZERO;
        };
        DVec3::new(1.0 - fifth, fifth, 0.0) * (2.0 * weight * cos * sin)
    };
    let tolerance = Tolerance {
        absolute: 1e-11,
        relative: 0.0,
    };
    let found = integrate(f, &[0.0, theta_o, FRAC_PI_2], &[0.0, PI], tolerance);
    Albedo {
        scale: found.value.x,
        bias: found.value.y,
    }
}

/// Directional albedo for α = 1 and F = 1: E(μ) = 1 − μ ln(1 + 1/μ), μ = `cos_o` in (0, 1].
pub fn rough_albedo(cos_o: f64) -> f64 {
    1.0 - cos_o * (1.0 / cos_o).ln_1p()
}

/// Average over the hemisphere of [`rough_albedo`], 2∫E(μ)μ dμ = 4/3·(1 − ln 2).
pub fn rough_average_albedo() -> f64 {
    4.0 / 3.0 * (1.0 - std::f64::consts::LN_2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_cover_the_surface_once() {
        for alpha in [1.0, 0.3, 0.01] {
            let f = |theta: f64, _: f64| {
                let h = DVec3::new(theta.sin(), 0.0, theta.cos());
                DVec3::splat(2.0 * PI * distribution(h, alpha) * h.x * h.z)
            };
            let found = integrate(
                f,
                &[0.0, FRAC_PI_2],
                &[0.0, 1.0],
                Tolerance::relative(1e-12),
            );
            assert!((found.value.x - 1.0).abs() < 1e-12, "{alpha}");
        }
    }

    #[test]
    fn the_lobe_is_reciprocal() {
        let lobe = Lobe {
            alpha: 0.2,
            f0: DVec3::new(0.04, 0.5, 1.0),
        };
        let (a, b) = (
            DVec3::new(0.6, 0.1, 0.3).normalize(),
            DVec3::new(-0.9, 0.2, 0.01).normalize(),
        );
        assert!((lobe.eval(a, b) - lobe.eval(b, a)).length() < 1e-15);
        assert_eq!(lobe.eval(a, -b), DVec3::ZERO);
    }

    #[test]
    fn the_average_is_the_integral() {
        let f = |mu: f64, _: f64| DVec3::splat(2.0 * mu * rough_albedo(mu));
        let found = integrate(f, &[0.0, 1.0], &[0.0, 1.0], Tolerance::relative(1e-12));
        assert!((found.value.x - rough_average_albedo()).abs() < 1e-12);
    }
}
