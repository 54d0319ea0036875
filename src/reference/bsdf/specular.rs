//! Surfaces in which a camera ray goes on; see `shaders/bsdf/specular.wesl`.

use super::fresnel::{fresnel, fresnel_dielectric};
use crate::reference::core::math::luminance;
use crate::scene::material::{BsdfParameters, Transmission};
use glam::DVec3;

/// What becomes of a camera ray.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    /// It ends: the surface is lit directly.
    Lit,
    /// It is reflected.
    Reflected,
    /// It passes through.
    Transmitted,
}

/// How a camera ray goes on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpecularSample {
    /// Unit direction: z ≥ 0 reflected, z ≤ 0 transmitted.
    pub wi: DVec3,
    /// What becomes of it.
    pub way: Way,
    /// Factor on what is seen there, over the probability of this way.
    pub weight: DVec3,
}

/// Light that passes through a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transmitted {
    /// The part of radiance that is reflected.
    pub reflectance: f64,
    /// Direction from which the rest comes; z ≤ 0.
    pub wi: DVec3,
    /// The rest's factor on radiance, n_o²/n_i².
    pub scale: f64,
}

/// What a dielectric shows in direction `wo`, seen from outside where `outside` is set.
pub fn transmit(t: &Transmission, wo: DVec3, outside: bool) -> Transmitted {
    if t.thin {
        let r = fresnel_dielectric(wo.z, t.ior).reflectance;
        // All orders of reflection in the pane, R + R(1 − R)² (1 + R² + R⁴ + …).
        let inside = if r < 1.0 {
            r * (1.0 - r).powi(2) / (1.0 - r * r)
        } else {
            0.0
        };
        return Transmitted {
            reflectance: r + inside,
            wi: -wo,
            scale: 1.0,
        };
    }
    let eta = if outside { t.ior } else { 1.0 / t.ior };
    let boundary = fresnel_dielectric(wo.z, eta);
    // Snell: sinθ_t = sinθ_i/η.
    Transmitted {
        reflectance: boundary.reflectance,
        wi: DVec3::new(-wo.x / eta, -wo.y / eta, -boundary.eta_cos_t / eta),
        scale: 1.0 / (eta * eta),
    }
}

/// Chooses how a ray goes on that met `m` from direction `wo`, from the front where `front` is set.
pub fn sample_specular(m: &BsdfParameters, wo: DVec3, front: bool, u: f64) -> SpecularSample {
    let mut reflectance = m
        .specular
        .map_or(DVec3::ZERO, |lobe| fresnel(&lobe.fresnel, wo.z));
    let passes = m
        .transmission
        .as_ref()
        .filter(|t| t.transmittance.max_element() > 0.0);
    let through = passes.map(|t| (transmit(t, wo, front), t.transmittance));
    let mut transmitted = DVec3::ZERO;
    if let Some((through, transmittance)) = through {
        reflectance = DVec3::splat(through.reflectance);
        transmitted = (1.0 - through.reflectance) * transmittance;
    }
    let mirror = m.specular.is_none_or(|lobe| lobe.alpha <= 0.0);
    let reflected = luminance(reflectance);
    let r = if mirror { reflected } else { 0.0 };
    let t = luminance(transmitted);
    let lit = luminance((DVec3::ONE - reflectance) * m.diffuse) + (reflected - r);
    let ends = |probability: f64| SpecularSample {
        wi: wo,
        way: Way::Lit,
        weight: DVec3::splat(1.0 / probability),
    };
    if r + t <= 0.0 {
        return ends(1.0);
    }
    let sum = r + t + lit;
    let choice = u * sum;
    match through {
        _ if choice < r || t + lit <= 0.0 => SpecularSample {
            wi: DVec3::new(-wo.x, -wo.y, wo.z),
            way: Way::Reflected,
            weight: reflectance * sum / r,
        },
        Some((through, _)) if choice < r + t || lit <= 0.0 => SpecularSample {
            wi: through.wi,
            way: Way::Transmitted,
            weight: transmitted * through.scale * sum / t,
        },
        _ => ends(lit / sum),
    }
}
