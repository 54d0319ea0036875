//! Directional lights.

use super::{Fault, Light, LightKind, LightRecord, SunLight, check_direction, direction};
use crate::scene::rgb::Rgb;
use glam::DVec3;
use schemars::JsonSchema;
use serde::Deserialize;

/// `LIGHT_DIRECTIONAL` of `shaders/light/directional.wesl`.
pub const LIGHT_DIRECTIONAL: u32 = 6;

/// A light infinitely far away.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DirectionalLight {
    /// Unit direction in which the light travels.
    pub direction: DVec3,
    /// Irradiance on a surface that faces it, per channel (W·m⁻²; from glTF: lux).
    pub irradiance: DVec3,
}

/// A directional light.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct DirectionalTable {
    /// The direction in which the light travels.
    direction: [f64; 3],
    /// Irradiance on a surface that faces it, not negative.
    irradiance: Rgb,
    /// The angle in degrees under which it is seen, 0.001 to 180: a disk in the sky (the sun:
    /// 0.53); 0 is a point.
    #[serde(default)]
    angular_diameter: f64,
}

impl DirectionalTable {
    pub(super) fn light(&self) -> Result<Light, Fault> {
        let direction = direction(self.direction)?;
        let irradiance = self.irradiance.into();
        if self.angular_diameter == 0.0 {
            return Ok(Light::Directional(DirectionalLight {
                direction,
                irradiance,
            }));
        }
        Ok(Light::Sun(SunLight {
            direction,
            irradiance,
            angular_radius: 0.5 * self.angular_diameter.to_radians(),
        }))
    }
}

impl LightKind for DirectionalLight {
    fn name(&self) -> &'static str {
        "directional"
    }

    fn position_and_strength(&mut self) -> (Option<&mut DVec3>, &mut DVec3) {
        (None, &mut self.irradiance)
    }

    fn check(&self) -> Result<(), Fault> {
        check_direction(self.direction)
    }

    fn record(&self) -> LightRecord {
        LightRecord {
            kind: LIGHT_DIRECTIONAL,
            vectors: [-self.direction, DVec3::ZERO, DVec3::ZERO],
            radiance: self.irradiance,
        }
    }
}
