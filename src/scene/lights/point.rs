//! Point lights.

use super::{Fault, Light, LightKind, LightRecord};
use crate::scene::rgb::Rgb;
use glam::DVec3;
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::PI;

/// `LIGHT_POINT` of `shaders/light/point.wesl`.
pub const LIGHT_POINT: u32 = 4;

/// A light that radiates equally from a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointLight {
    /// Where it is.
    pub position: DVec3,
    /// Radiant intensity per channel (W·sr⁻¹; from glTF: candela).
    pub intensity: DVec3,
}

/// A point light.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct PointTable {
    /// Where it is.
    position: [f64; 3],
    /// Radiant intensity, not negative.
    intensity: Rgb,
}

impl PointTable {
    pub(super) fn light(&self) -> Result<Light, Fault> {
        Ok(Light::Point(PointLight {
            position: DVec3::from_array(self.position),
            intensity: self.intensity.into(),
        }))
    }
}

impl LightKind for PointLight {
    fn name(&self) -> &'static str {
        "point"
    }

    fn position_and_strength(&mut self) -> (Option<&mut DVec3>, &mut DVec3) {
        (Some(&mut self.position), &mut self.intensity)
    }

    fn check(&self) -> Result<(), Fault> {
        Ok(())
    }

    fn power_of_strength(&self, _: f64) -> f64 {
        4.0 * PI
    }

    fn record(&self) -> LightRecord {
        LightRecord {
            kind: LIGHT_POINT,
            vectors: [self.position, DVec3::ZERO, DVec3::ZERO],
            radiance: self.intensity,
        }
    }
}
