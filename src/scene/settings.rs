//! The `[render]` table: every setting also has a flag.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How directions are chosen (DESIGN: *strategy*). All estimate the same integral.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Hash,
    Default,
    Serialize,
    Deserialize,
    JsonSchema,
    clap::ValueEnum,
)]
#[serde(rename_all = "kebab-case")]
pub enum Strategy {
    /// Uniformly on the surface of a chosen light.
    LightArea,
    /// In proportion to the BSDF. Lights without a surface are sampled directly, as nothing else reaches them.
    Bsdf,
    /// Both, weighted by the power heuristic (Veach 1997, eq. 9.26, β = 2).
    #[default]
    MisPower,
}

/// How one of several lights is chosen.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Hash,
    Default,
    Serialize,
    Deserialize,
    JsonSchema,
    clap::ValueEnum,
)]
#[serde(rename_all = "kebab-case")]
pub enum LightSelection {
    /// All with the same probability.
    Uniform,
    /// In proportion to emitted power.
    #[default]
    Power,
}

/// How to render.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RenderSettings {
    /// How directions are chosen.
    pub strategy: Strategy,
    /// How one of several lights is chosen.
    pub light_selection: LightSelection,
    /// Samples per pixel, at least 1.
    pub spp: u64,
    /// Seconds of rendering after which it ends, even with fewer samples; none: `spp` alone decides.
    pub time: Option<f64>,
    /// Seed of the random numbers.
    pub seed: u32,
}

impl Default for RenderSettings {
    fn default() -> Self {
        Self {
            strategy: Strategy::default(),
            light_selection: LightSelection::default(),
            spp: 64,
            time: None,
            seed: 0,
        }
    }
}

impl std::fmt::Display for Strategy {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::LightArea => "light-area",
            Self::Bsdf => "bsdf",
            Self::MisPower => "mis-power",
        })
    }
}

impl std::fmt::Display for LightSelection {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Uniform => "uniform",
            Self::Power => "power",
        })
    }
}
