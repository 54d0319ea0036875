//! What a smooth surface reflects; see `shaders/bsdf/fresnel.wesl`. The equations are written in
//! their textbook forms, with complex numbers where the index of refraction is one.

use crate::reference::exact::fresnel::dielectric_reflectance;
use crate::scene::material::Fresnel;
use glam::{DVec2, DVec3};

/// F = F0 + (F90 − F0)(1 − cosθ)⁵ (Schlick 1994).
pub fn fresnel_schlick(f0: DVec3, f90: f64, cos_theta: f64) -> DVec3 {
    f0 + (DVec3::splat(f90) - f0) * (1.0 - cos_theta).clamp(0.0, 1.0).powi(5)
}

/// What the boundary of a dielectric does with light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interface {
    /// The part that is reflected.
    pub reflectance: f64,
    /// η cosθ_t of what is refracted; 0 in total reflection.
    pub eta_cos_t: f64,
}

/// Fresnel's equations for the relative index of refraction `eta` = n_t/n_i.
pub fn fresnel_dielectric(cos_i: f64, eta: f64) -> Interface {
    // η² − sin²θ, with the sine from the cosine by a product.
    let squared = (eta - 1.0) * (eta + 1.0) + cos_i * cos_i;
    Interface {
        reflectance: dielectric_reflectance(cos_i, eta),
        eta_cos_t: squared.max(0.0).sqrt(),
    }
}

fn product(a: DVec2, b: DVec2) -> DVec2 {
    DVec2::new(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x)
}

fn square_root(z: DVec2) -> DVec2 {
    let (sin, cos) = (0.5 * z.y.atan2(z.x)).sin_cos();
    z.length().sqrt() * DVec2::new(cos, sin)
}

/// Fresnel's amplitudes (c − n_t)/(c + n_t) and (n²c − n_t)/(n²c + n_t) with complex n = η + ik,
/// n_t = √(n² − sin²θ), squared and averaged.
pub fn fresnel_conductor(cos_i: f64, eta: DVec3, k: DVec3) -> DVec3 {
    let in_channel = |c: usize| {
        let n = DVec2::new(eta[c], k[c]);
        let squared = product(n, n);
        let sin2 = DVec2::new((1.0 - cos_i) * (1.0 + cos_i), 0.0);
        let transmitted = square_root(squared - sin2);
        let reflected = |incident: DVec2| {
            let sum = (incident + transmitted).length_squared();
            (incident - transmitted).length_squared() / sum.max(f64::MIN_POSITIVE)
        };
        0.5 * (reflected(DVec2::new(cos_i, 0.0)) + reflected(squared * cos_i))
    };
    DVec3::from_array(std::array::from_fn(in_channel))
}

/// Reflectance of facets, seen from outside.
pub fn fresnel(kind: &Fresnel, cos_theta: f64) -> DVec3 {
    match *kind {
        Fresnel::Constant(reflectance) => reflectance,
        Fresnel::Schlick { f0, f90 } => fresnel_schlick(f0, f90, cos_theta),
        Fresnel::Dielectric { ior } => DVec3::splat(fresnel_dielectric(cos_theta, ior).reflectance),
        Fresnel::Conductor { eta, k } => fresnel_conductor(cos_theta, eta, k),
    }
}
