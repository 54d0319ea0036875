//! Spot lights.

use super::{Fault, Light, LightKind, LightRecord, Spread, check_direction, direction, require};
use crate::scene::rgb::Rgb;
use glam::DVec3;
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::{FRAC_PI_2, PI};

/// `LIGHT_SPOT` of `shaders/light/spot.wesl`.
pub const LIGHT_SPOT: u32 = 5;

/// Largest reciprocal of a spot's falloff range: equal angles make a step.
const STEP: f64 = 1_048_576.0;

/// A point light restricted to a cone, with KHR_lights_punctual's falloff:
/// `intensity · saturate((cosθ − cos outer) / (cos inner − cos outer))²`; a step where both angles
/// are equal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpotLight {
    /// Where it is.
    pub position: DVec3,
    /// Unit axis of the cone, away from the light.
    pub direction: DVec3,
    /// Radiant intensity on the axis per channel (W·sr⁻¹; from glTF: candela).
    pub intensity: DVec3,
    /// Half angle of full intensity in radians, in [0, outer].
    pub inner_angle: f64,
    /// Half angle beyond which there is none, in (0, π/2].
    pub outer_angle: f64,
}

/// A spot light: `direction` or `target`.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SpotTable {
    /// Where it is.
    position: [f64; 3],
    /// Axis of the cone, away from the light.
    direction: Option<[f64; 3]>,
    /// A point on the axis, instead of `direction`.
    target: Option<[f64; 3]>,
    /// Radiant intensity on the axis, not negative.
    intensity: Rgb,
    /// Half angle of full intensity in degrees, from 0 to `outer`; 0 when left out.
    #[serde(default)]
    inner: f64,
    /// Half angle beyond which there is none, in degrees, above 0 and up to 90; 45 when left out.
    #[serde(default = "forty_five")]
    outer: f64,
}

fn forty_five() -> f64 {
    45.0
}

impl SpotTable {
    pub(super) fn light(&self) -> Result<Light, Fault> {
        let position = DVec3::from_array(self.position);
        let direction = match (self.direction, self.target) {
            (Some(given), None) => direction(given)?,
            (None, Some(target)) => {
                let towards = (DVec3::from_array(target) - position).try_normalize();
                towards.ok_or_else(|| {
                    let problem = format!("is the light's position, {target:?}");
                    Fault::new("target", problem, "a point that it shines at")
                })?
            }
            _ => {
                let problem = "the direction is given twice or not at all";
                return Err(Fault::new("", problem, "`direction` or `target`"));
            }
        };
        Ok(Light::Spot(SpotLight {
            position,
            direction,
            intensity: self.intensity.into(),
            inner_angle: self.inner.to_radians(),
            outer_angle: self.outer.to_radians(),
        }))
    }
}

impl LightKind for SpotLight {
    fn name(&self) -> &'static str {
        "spot"
    }

    fn position_and_strength(&mut self) -> (Option<&mut DVec3>, &mut DVec3) {
        (Some(&mut self.position), &mut self.intensity)
    }

    fn check(&self) -> Result<(), Fault> {
        check_direction(self.direction)?;
        require(
            self.outer_angle > 0.0 && self.outer_angle <= FRAC_PI_2,
            "outer",
            || format!("is {}", self.outer_angle.to_degrees()),
            "a half angle above 0 and up to 90 degrees",
        )?;
        require(
            (0.0..=self.outer_angle).contains(&self.inner_angle),
            "inner",
            || format!("is {}", self.inner_angle.to_degrees()),
            "a half angle from 0 to `outer`",
        )
    }

    fn power_of_strength(&self, _: f64) -> f64 {
        let (inner, outer) = (self.inner_angle.cos(), self.outer_angle.cos());
        2.0 * PI * ((1.0 - inner) + (inner - outer) / 3.0)
    }

    fn spread(&self) -> Option<Spread> {
        Some(Spread {
            axis: self.direction,
            full_angle: self.inner_angle,
            falloff_angle: self.outer_angle - self.inner_angle,
        })
    }

    fn record(&self) -> LightRecord {
        let (inner, outer) = (self.inner_angle.cos(), self.outer_angle.cos());
        let per_range = (1.0 / (inner - outer).max(1.0 / STEP)).min(STEP);
        LightRecord {
            kind: LIGHT_SPOT,
            vectors: [
                self.position,
                self.direction,
                DVec3::new(outer, per_range, 0.0),
            ],
            radiance: self.intensity,
        }
    }
}
