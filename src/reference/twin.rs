//! The twin: every sample of an image, in f64, on all cores.

use super::broken::BrokenTwin;
use super::kernel::direct::Direct;
use super::kernel::sample::Sample;
use crate::effects::{Effect, Effects};
use crate::render::Prepared;
use crate::scene::FilmSize;
use rayon::prelude::*;

/// Every effect that the reference simulates. A render that calls for another one is refused, never compared without
/// it.
pub const SUPPORTED: &[Effect] = &[
    Effect::Geometry,
    Effect::Triangles,
    Effect::Rectangles,
    Effect::Disks,
    Effect::Spheres,
    Effect::OneSided,
    Effect::Glossy,
    Effect::SmoothNormals,
    Effect::ColorTexture,
    Effect::RoughnessTexture,
    Effect::NormalMap,
    Effect::Specular,
    Effect::Refraction,
    Effect::ExactDielectric,
    Effect::ExactConductor,
    Effect::EnergyCompensation,
    Effect::AreaLights,
    Effect::PlanarLights,
    Effect::TriangleLights,
    Effect::DiskLights,
    Effect::SkewedLights,
    Effect::SphereLights,
    Effect::PointLights,
    Effect::DirectionalLights,
    Effect::Environment,
    Effect::EnvironmentMap,
    Effect::EnvironmentLinear,
    Effect::LightChoice,
    Effect::LightTree,
    Effect::AllLights,
    Effect::ShadowRays,
    Effect::CenterPattern,
    Effect::GridPattern,
    Effect::StratifiedPattern,
    Effect::SampleLights,
    Effect::SampleBsdf,
    Effect::UniformHemisphere,
    Effect::CosineHemisphere,
    Effect::SolidAngleLights,
    Effect::ProjectedLights,
    Effect::BalanceHeuristic,
    Effect::StratifiedSampler,
    Effect::SobolSampler,
    Effect::BlueNoiseSampler,
    Effect::DepthOfField,
    Effect::Orthographic,
    Effect::PixelFilter,
];

/// The scene calls for an effect that the reference does not simulate.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("the reference does not simulate `{}` ({reason}), so the scene cannot be compared", effect.name())]
pub struct UnsupportedEffect {
    /// The effect.
    pub effect: Effect,
    /// Why the scene calls for it.
    pub reason: String,
}

/// Finds the first of `effects` that is not among `supported`.
///
/// # Errors
/// There is one.
pub fn check_supported(effects: &Effects, supported: &[Effect]) -> Result<(), UnsupportedEffect> {
    match effects.iter().find(|(e, _)| !supported.contains(e)) {
        None => Ok(()),
        Some((effect, reason)) => Err(UnsupportedEffect {
            effect,
            reason: reason.to_owned(),
        }),
    }
}

/// The estimator in f64.
#[derive(Debug)]
pub struct Twin<'a> {
    direct: Direct<'a>,
    size: FilmSize,
}

impl<'a> Twin<'a> {
    /// The twin of a render of `prepared` at `size` pixels with `seed`; `broken` gives it one mistake.
    ///
    /// # Errors
    /// The scene calls for an effect that the reference lacks.
    pub fn new(
        prepared: &'a Prepared,
        size: FilmSize,
        seed: u32,
        broken: Option<BrokenTwin>,
    ) -> Result<Self, UnsupportedEffect> {
        check_supported(&prepared.effects, SUPPORTED)?;
        let direct = Direct::new(prepared, size, seed, broken);
        Ok(Self { direct, size })
    }

    /// The estimator of a single sample.
    pub fn direct(&self) -> &Direct<'a> {
        &self.direct
    }

    /// The twin with other random numbers.
    #[must_use]
    pub fn with_seed(self, seed: u32) -> Self {
        Self {
            direct: self.direct.with_seed(seed),
            ..self
        }
    }

    /// Sample `index` of every pixel, row by row.
    pub fn samples(&self, index: u64) -> Vec<Sample> {
        let width = self.size.width;
        let pixels = 0..self.size.pixels() as u32;
        pixels
            .into_par_iter()
            .map(|p| self.direct.sample_radiance(p % width, p / width, index))
            .collect()
    }
}
