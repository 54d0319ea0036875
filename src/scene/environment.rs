//! Light from everywhere.

use glam::{DMat3, DVec3};
use schemars::JsonSchema;
use serde::Deserialize;

/// Light from everywhere that no surface covers.
#[derive(Debug, Clone, PartialEq)]
pub struct Environment {
    /// Where the radiance comes from.
    pub radiance: EnvironmentRadiance,
    /// Rotation from the map's space to world space. In the map's space +y is up (row 0 of the
    /// image), and the image's centre column lies in direction −z.
    pub rotation: DMat3,
    /// Factor on the radiance.
    pub scale: f64,
}

/// Radiance of the environment.
#[derive(Debug, Clone, PartialEq)]
pub enum EnvironmentRadiance {
    /// The same in every direction.
    Constant(DVec3),
    /// A latitude-longitude map.
    Map(EnvironmentMap),
}

/// A latitude-longitude map of radiance, row 0 at the zenith (+y).
///
/// Column `x` (from 0 to `width`) lies at azimuth `φ = 2π·x/width`, direction `(−sin φ·sin θ, cos
/// θ, cos φ·sin θ)`, with `θ = π·y/height`.
#[derive(Debug, Clone, PartialEq)]
pub struct EnvironmentMap {
    /// Name of the file, for messages.
    pub source: String,
    /// Texels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Linear RGB radiance, row by row; finite and not negative.
    pub texels: Vec<[f32; 3]>,
    /// What lies between texel centres.
    pub interpolation: Interpolation,
}

/// What an image holds between the centres of its texels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Interpolation {
    /// The value of the texel: the image is constant in each.
    Nearest,
    /// A blend of the four nearest texels; columns wrap around, rows end at the poles.
    #[default]
    Linear,
}
