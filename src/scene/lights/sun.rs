//! Suns.

use super::{Fault, LightKind, LightRecord, check_direction, require};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI};

/// `LIGHT_SUN` of `shaders/light/sun.wesl`.
pub const LIGHT_SUN: u32 = 8;

/// Smallest angular radius of a sun, in radians: f32 still resolves directions within it.
pub const MIN_SUN: f64 = 0.0005 * PI / 180.0;

/// A disk of constant radiance, infinitely far away.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SunLight {
    /// Unit direction in which the light of its middle travels.
    pub direction: DVec3,
    /// Irradiance on a surface that faces it, per channel (W·m⁻²).
    pub irradiance: DVec3,
    /// Half the angle under which it is seen, in radians, in [[`MIN_SUN`], π/2].
    pub angular_radius: f64,
}

impl SunLight {
    /// The radiance whose integral over the cone, with the cosine at a surface that faces it, is
    /// the irradiance: the cone's projected solid angle is π sin²θ.
    pub fn radiance(&self) -> DVec3 {
        self.irradiance / (PI * self.angular_radius.sin().powi(2))
    }

    /// The solid angle in which it is seen.
    pub fn solid_angle(&self) -> f64 {
        2.0 * PI * self.height()
    }

    /// 1 − cosθ of the cone in which it is seen: the solid angle is 2π times this.
    fn height(&self) -> f64 {
        2.0 * (0.5 * self.angular_radius).sin().powi(2)
    }
}

impl LightKind for SunLight {
    fn name(&self) -> &'static str {
        "sun"
    }

    fn position_and_strength(&mut self) -> (Option<&mut DVec3>, &mut DVec3) {
        (None, &mut self.irradiance)
    }

    fn radiance(&self) -> Option<DVec3> {
        Some(Self::radiance(self))
    }

    fn check(&self) -> Result<(), Fault> {
        check_direction(self.direction)?;
        let diameter = 2.0 * self.angular_radius.to_degrees();
        require(
            // Converting degrees to radians and back rounds.
            (MIN_SUN * (1.0 - 1e-12)..=FRAC_PI_2).contains(&self.angular_radius),
            "angular_diameter",
            || format!("is {diameter}"),
            "0, or 0.001 to 180 degrees",
        )
    }

    fn record(&self) -> LightRecord {
        LightRecord {
            kind: LIGHT_SUN,
            vectors: [
                -self.direction,
                DVec3::ZERO,
                DVec3::new(self.height(), 0.0, 0.0),
            ],
            radiance: Self::radiance(self),
        }
    }
}
