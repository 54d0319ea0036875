//! Point lights.

use super::sample::LightSample;
use crate::reference::core::pdf::PdfDiscrete;
use crate::scene::PointLight;
use glam::DVec3;

/// Light from the only direction: I / d².
pub fn sample_point_light(light: &PointLight, choice: PdfDiscrete, x: DVec3) -> LightSample {
    LightSample::from_point(light.position, choice, x, |_| light.intensity)
}
