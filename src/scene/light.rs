//! Lights without a surface, and the environment.

use glam::{DMat3, DVec3};
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::PI;

/// A light without a surface: only light sampling can reach it, but for suns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Light {
    /// Radiates equally from a point.
    Point {
        /// Where it is.
        position: DVec3,
        /// Radiant intensity per channel (W·sr⁻¹; from glTF: candela).
        intensity: DVec3,
    },
    /// A point light restricted to a cone, with KHR_lights_punctual's falloff:
    /// `intensity · saturate((cosθ − cos outer) / (cos inner − cos outer))²`; a step where both angles are equal.
    Spot {
        /// Where it is.
        position: DVec3,
        /// Unit axis of the cone, away from the light.
        direction: DVec3,
        /// Radiant intensity on the axis (W·sr⁻¹; from glTF: candela).
        intensity: DVec3,
        /// Half angle of full intensity in radians, in [0, outer].
        inner_angle: f64,
        /// Half angle beyond which there is none, in (0, π/2].
        outer_angle: f64,
    },
    /// Infinitely far away.
    Directional {
        /// Unit direction in which the light travels.
        direction: DVec3,
        /// Irradiance on a surface that faces it (W·m⁻²; from glTF: lux).
        irradiance: DVec3,
    },
    /// Infinitely far away, and a disk of constant radiance in the sky.
    Sun {
        /// Unit direction in which the light of its middle travels.
        direction: DVec3,
        /// Irradiance on a surface that faces it (W·m⁻²).
        irradiance: DVec3,
        /// Half the angle under which it is seen, in radians, in [[`MIN_SUN`], π/2].
        angular_radius: f64,
    },
}

impl Light {
    /// Its intensity (point, spot) or irradiance (directional, sun).
    pub fn strength_mut(&mut self) -> &mut DVec3 {
        match self {
            Self::Point { intensity, .. } | Self::Spot { intensity, .. } => intensity,
            Self::Directional { irradiance, .. } | Self::Sun { irradiance, .. } => irradiance,
        }
    }
}

/// Smallest angular radius of a sun, in radians: f32 still resolves directions within it.
pub const MIN_SUN: f64 = 0.0005 * PI / 180.0;

/// The radiance whose integral over the cone, with the cosine at a surface that faces it, is `irradiance`: the cone's
/// projected solid angle is π sin²θ.
pub fn sun_radiance(irradiance: DVec3, angular_radius: f64) -> DVec3 {
    irradiance / (PI * angular_radius.sin().powi(2))
}

/// Light from everywhere that no surface covers.
#[derive(Debug, Clone, PartialEq)]
pub struct Environment {
    /// Where the radiance comes from.
    pub radiance: EnvironmentRadiance,
    /// Rotation from the map's space to world space. In the map's space +y is up (row 0 of the image), and the
    /// image's centre column lies in direction −z.
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
/// Column `x` (from 0 to `width`) lies at azimuth `φ = 2π·x/width`, direction `(−sin φ·sin θ, cos θ, cos φ·sin θ)`,
/// with `θ = π·y/height`.
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
