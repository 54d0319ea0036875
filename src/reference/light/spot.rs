//! Spot lights.

use super::sample::LightSample;
use crate::reference::core::pdf::PdfDiscrete;
use crate::scene::SpotLight;
use glam::DVec3;

/// Largest reciprocal of the falloff's range: equal angles make a step.
const STEP: f64 = 1_048_576.0;

/// Factor on the intensity at angle θ from the axis (KHR_lights_punctual):
/// saturate((cosθ − cos outer) / (cos inner − cos outer))².
pub fn spot_falloff(cos_theta: f64, cos_inner: f64, cos_outer: f64) -> f64 {
    let range = (cos_inner - cos_outer).max(1.0 / STEP);
    let f = ((cos_theta - cos_outer) / range).clamp(0.0, 1.0);
    f * f
}

/// Light from the only direction: falloff · I / d².
pub fn sample_spot_light(light: &SpotLight, choice: PdfDiscrete, x: DVec3) -> LightSample {
    let (inner, outer) = (light.inner_angle.cos(), light.outer_angle.cos());
    LightSample::from_point(light.position, choice, x, |wi| {
        light.intensity * spot_falloff(-wi.dot(light.direction), inner, outer)
    })
}
