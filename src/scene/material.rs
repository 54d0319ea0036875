//! Surfaces: a BSDF, and whether its back exists.

use super::texture::{MaterialTextures, TexturedFactors};
use glam::DVec3;

/// How a surface scatters light.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// The name in the scene file.
    pub name: String,
    /// The scattering function.
    pub bsdf: Bsdf,
    /// With `false` the back of the surface does not exist: rays pass through it (back-face culling, glTF's
    /// `doubleSided = false`). With `true` both sides scatter alike.
    pub double_sided: bool,
    /// What varies over the surface.
    pub textures: MaterialTextures,
}

/// The scattering functions of a scene file. All reflect only.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bsdf {
    /// Ideal diffuse reflection: `f_r = reflectance / π`.
    Lambert {
        /// Albedo, each channel in [0, 1].
        reflectance: DVec3,
    },
    /// A rough conductor: GGX microfacets with Schlick's Fresnel.
    Conductor {
        /// Reflectance at normal incidence (F₀), each channel in [0, 1].
        reflectance: DVec3,
        /// GGX width α in (0, 1].
        alpha: f64,
    },
    /// glTF 2.0's metallic-roughness model (specification, appendix B).
    MetallicRoughness {
        /// Base colour, linear RGB, each channel in [0, 1].
        base_color: DVec3,
        /// 0 dielectric … 1 metal.
        metallic: f64,
        /// Perceptual roughness in [0, 1]; α = roughness².
        roughness: f64,
    },
}

/// What every BSDF comes down to: `f_r = (1 − F) diffuse/π + F·D·V` with GGX `D`, height-correlated Smith `V`
/// and Schlick's `F` between `f0` and 1. Without `specular` only `diffuse/π` remains.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BsdfParameters {
    /// Albedo of the diffuse lobe.
    pub diffuse: DVec3,
    /// The microfacet lobe, where there is one.
    pub specular: Option<SpecularLobe>,
}

/// Parameters of the GGX lobe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpecularLobe {
    /// Reflectance at normal incidence.
    pub f0: DVec3,
    /// GGX width.
    pub alpha: f64,
}

impl Bsdf {
    /// Smallest GGX width that is simulated; a smaller one is raised to it, with a warning.
    pub const MIN_ALPHA: f64 = 1e-4;
    /// Reflectance of a dielectric with index of refraction 1.5 at normal incidence.
    pub const DIELECTRIC_F0: f64 = 0.04;

    /// This BSDF where its material's textures say `factors`.
    pub fn textured(self, factors: &TexturedFactors) -> Self {
        match self {
            Self::Lambert { reflectance } => Self::Lambert {
                reflectance: reflectance * factors.color,
            },
            Self::Conductor { reflectance, alpha } => Self::Conductor {
                reflectance: reflectance * factors.color,
                alpha,
            },
            Self::MetallicRoughness {
                base_color,
                metallic,
                roughness,
            } => Self::MetallicRoughness {
                base_color: base_color * factors.color,
                metallic: metallic * factors.metallic,
                roughness: roughness * factors.roughness,
            },
        }
    }

    /// The lobes this BSDF comes down to.
    pub fn parameters(&self) -> BsdfParameters {
        match *self {
            Self::Lambert { reflectance } => BsdfParameters {
                diffuse: reflectance,
                specular: None,
            },
            Self::Conductor { reflectance, alpha } => BsdfParameters {
                diffuse: DVec3::ZERO,
                specular: Some(SpecularLobe {
                    f0: reflectance,
                    alpha: alpha.max(Self::MIN_ALPHA),
                }),
            },
            Self::MetallicRoughness {
                base_color,
                metallic,
                roughness,
            } => BsdfParameters {
                diffuse: base_color * (1.0 - metallic),
                specular: Some(SpecularLobe {
                    f0: DVec3::splat(Self::DIELECTRIC_F0).lerp(base_color, metallic),
                    alpha: (roughness * roughness).max(Self::MIN_ALPHA),
                }),
            },
        }
    }
}
