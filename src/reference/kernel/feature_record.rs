//! What the sample in progress shows a denoiser; see `shaders/kernel/feature_record.wesl`.

use crate::reference::bsdf::fresnel::fresnel;
use crate::reference::scene::surface::Surface;
use crate::scene::material::BsdfParameters;
use glam::DVec3;

/// Of the surface where the camera path ends; nothing where it meets none.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Features {
    /// Reflectance, times what mirrors and glass before it leave of it, in [0, 1].
    pub albedo: DVec3,
    /// Unit shading normal, world space, on the viewer's side.
    pub normal: DVec3,
}

/// Reflectance at normal incidence: what the specular lobe reflects, and the base and what passes
/// through of the rest.
pub fn albedo(m: &BsdfParameters) -> DVec3 {
    let f = m
        .specular
        .map_or(DVec3::ZERO, |lobe| fresnel(&lobe.fresnel, 1.0));
    let through = m.transmission.map_or(DVec3::ZERO, |t| t.transmittance);
    f + (DVec3::ONE - f) * (m.diffuse + through)
}

/// The features of the surface `s`; `throughput` is the factor of the surfaces before it.
pub fn record_features(s: &Surface, throughput: DVec3) -> Features {
    Features {
        albedo: (throughput * albedo(&s.material)).clamp(DVec3::ZERO, DVec3::ONE),
        normal: s.frame.z,
    }
}
