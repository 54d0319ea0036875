//! Directional lights.

use super::sample::{FAR, LightSample};
use crate::reference::core::pdf::PdfDiscrete;
use crate::scene::DirectionalLight;
use glam::DVec3;

/// Light from the only direction.
pub fn sample_directional_light(
    light: &DirectionalLight,
    choice: PdfDiscrete,
    x: DVec3,
) -> LightSample {
    let wi = -light.direction;
    LightSample::delta(wi, x + wi * FAR, light.irradiance / choice.0)
}
