//! Suns: disks of constant radiance infinitely far away.

use crate::scene::light::sun_radiance;
use glam::DVec3;

/// A sun.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sun {
    /// Unit direction towards its middle.
    pub towards: DVec3,
    /// Its radiance.
    pub radiance: DVec3,
    /// 1 − cosθ of the cone in which it is seen: the solid angle is 2π times this.
    pub height: f64,
}

impl Sun {
    /// The sun whose middle's light travels in `direction`.
    pub fn new(direction: DVec3, irradiance: DVec3, angular_radius: f64) -> Self {
        Self {
            towards: -direction,
            radiance: sun_radiance(irradiance, angular_radius),
            height: 2.0 * (0.5 * angular_radius).sin().powi(2),
        }
    }
}
