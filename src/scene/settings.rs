//! The `[render]` table: every setting also has a flag.

use super::aov::{Aov, Aovs};
use super::choice::choice;
use super::sampler::Sampler;
use super::shadow_rays::ShadowPattern;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

choice! {
    /// How directions are chosen (DESIGN: *strategy*). All estimate the same integral.
    pub enum Strategy {
        /// Uniformly over the hemisphere. With this and the next two, lights without a surface are sampled directly, as
        /// nothing else reaches them.
        UniformHemisphere,
        /// In proportion to the cosine.
        CosineHemisphere,
        /// In proportion to the BSDF.
        Bsdf,
        /// Uniformly on the surface of a chosen light.
        LightArea,
        /// Uniformly over the solid angle in which a chosen light is seen.
        LightSolidAngle,
        /// Uniformly over that solid angle projected onto the surface; for spheres and disks as `light-solid-angle`.
        LightProjectedSolidAngle,
        /// By lights and by the BSDF, weighted by the balance heuristic (Veach 1997, eq. 9.11).
        MisBalance,
        /// By lights and by the BSDF, weighted by the power heuristic (Veach 1997, eq. 9.26, β = 2).
        #[default]
        MisPower,
    }
}

impl Strategy {
    /// Whether lights with a surface and the environment are sampled.
    pub fn samples_lights(self) -> bool {
        match self {
            Self::UniformHemisphere | Self::CosineHemisphere | Self::Bsdf => false,
            Self::LightArea
            | Self::LightSolidAngle
            | Self::LightProjectedSolidAngle
            | Self::MisBalance
            | Self::MisPower => true,
        }
    }

    /// Whether directions are chosen without regard to lights.
    pub fn samples_directions(self) -> bool {
        match self {
            Self::LightArea | Self::LightSolidAngle | Self::LightProjectedSolidAngle => false,
            Self::UniformHemisphere
            | Self::CosineHemisphere
            | Self::Bsdf
            | Self::MisBalance
            | Self::MisPower => true,
        }
    }

    /// Whether both are done, and weighted so that each may leave out what the other finds.
    pub fn is_mis(self) -> bool {
        self.samples_lights() && self.samples_directions()
    }
}

choice! {
    /// How a point of a light with a surface is chosen by the strategies `mis-balance` and `mis-power`.
    pub enum LightSampling {
        /// Uniformly over its area.
        Area,
        /// Uniformly over the solid angle in which it is seen.
        #[default]
        SolidAngle,
        /// Uniformly over that solid angle projected onto the surface; spheres and disks over their solid angle.
        ProjectedSolidAngle,
    }
}

choice! {
    /// How one of several lights is chosen.
    pub enum LightSelection {
        /// All with the same probability.
        Uniform,
        /// In proportion to emitted power.
        #[default]
        Power,
        /// In proportion to an estimate of what a light may contribute to the surface, by a tree over the lights (Conty
        /// Estevez & Kulla 2018): for many lights.
        Tree,
        /// None is chosen: every light gets shadow rays of its own.
        All,
    }
}

/// Largest `max_specular_depth`.
pub const MAX_SPECULAR_DEPTH: u32 = 64;

/// How to render.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RenderSettings {
    /// How directions are chosen.
    pub strategy: Strategy,
    /// How one of several lights is chosen.
    pub light_selection: LightSelection,
    /// How a point of a chosen light is chosen, where the strategy does not say.
    pub light_sampling: LightSampling,
    /// Whether the strategies `mis-balance` and `mis-power` sample of an environment map only what is brighter than its mean,
    /// and leave the rest to BSDF sampling (Karlík et al. 2019). Less noise under a sun in a broad sky; more where the sun
    /// is hidden and only the sky shines. The other strategies do not depend on it.
    pub mis_compensation: bool,
    /// Shadow rays per camera ray where lights are sampled, 1 to 1024; with light selection `all` per light.
    #[schemars(range(min = 1, max = 1024))]
    pub shadow_rays: u32,
    /// Where on the lights the points of a camera ray's shadow rays lie.
    pub shadow_pattern: ShadowPattern,
    /// Whether light counts that rough metals reflect after it has met several of their facets (Kulla & Conty 2017). Without,
    /// as in glTF's model and in most renderers' GGX, a white metal of width 1 loses up to 69 % of the light.
    pub energy_compensation: bool,
    /// Mirrors and panes of glass, one behind the other, in which direct lighting is seen, 0 to 64: what lies deeper is
    /// black. A closed body of glass is two of them, and each reflection in its inside one more.
    #[schemars(range(min = 0, max = 64))]
    pub max_specular_depth: u32,
    /// How random numbers are made.
    pub sampler: Sampler,
    /// Samples per pixel, at least 1.
    pub spp: u64,
    /// Whether pixels take more samples where the error is large and fewer where it is small, `spp` on the average. The first 16
    /// are the same for all and say where that is.
    pub adaptive: bool,
    /// Seconds of rendering after which it ends, even with fewer samples; none: `spp` alone decides.
    pub time: Option<f64>,
    /// Relative error of the image, √relMSE, at which it ends; none: other settings decide.
    pub error: Option<f64>,
    /// Confidence with which the image's error has to be below `error`, between 0 and 1.
    pub confidence: f64,
    /// Seed of the random numbers.
    pub seed: u32,
    /// Images beside radiance, which an EXR holds as further channels.
    #[schemars(with = "Vec<Aov>")]
    pub aovs: Aovs,
}

impl Default for RenderSettings {
    fn default() -> Self {
        Self {
            strategy: Strategy::default(),
            light_selection: LightSelection::default(),
            light_sampling: LightSampling::default(),
            mis_compensation: false,
            shadow_rays: 1,
            shadow_pattern: ShadowPattern::default(),
            energy_compensation: false,
            max_specular_depth: 8,
            sampler: Sampler::default(),
            spp: 64,
            adaptive: false,
            time: None,
            error: None,
            confidence: 0.95,
            seed: 0,
            aovs: Aovs::default(),
        }
    }
}
