//! Suns; see `shaders/light/sun.wesl`.

use super::sample::{FAR, LightSample};
use super::sphere::{pdf_cone, sample_cone};
use crate::emitters::Emitter;
use crate::reference::core::pdf::{PdfDiscrete, PdfSolidAngle, chosen};
use crate::reference::scene::fetch::World;
use crate::scene::SunLight;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// The suns of the scene that shine, with their indices and the probabilities that light selection
/// chooses them.
pub fn suns(world: &World<'_>) -> impl Iterator<Item = (u32, SunLight, PdfDiscrete)> {
    let emitters = &world.prepared.emitters;
    let lights = emitters.lights.iter().enumerate();
    lights.filter_map(|(index, light)| match light {
        Emitter::Sun(sun) if world.shines(index) => {
            let probability = PdfDiscrete(emitters.probability(index));
            Some((index as u32, *sun, probability))
        }
        _ => None,
    })
}

/// 1 − cosθ of the cone in which the sun is seen.
pub fn sun_height(sun: &SunLight) -> f64 {
    2.0 * (0.5 * sun.angular_radius).sin().powi(2)
}

/// The sun's radiance: its irradiance over the projected solid angle π sin²θ of the cone.
pub fn sun_radiance(sun: &SunLight) -> DVec3 {
    sun.irradiance / (PI * sun.angular_radius.sin().powi(2))
}

/// Whether the sun lies in the unit direction `world`.
pub fn is_in_sun(sun: &SunLight, world: DVec3) -> bool {
    (world + sun.direction).length_squared() <= 2.0 * sun_height(sun)
}

/// Angle between the unit direction `world` and the sun's edge.
pub fn sun_margin(sun: &SunLight, world: DVec3) -> f64 {
    let half_angle = |chord_squared: f64| (0.5 * chord_squared.sqrt()).min(1.0).asin();
    let from_middle = half_angle((world + sun.direction).length_squared());
    2.0 * (from_middle - half_angle(2.0 * sun_height(sun))).abs()
}

/// Density with which light sampling chooses a direction within the sun, light selection included.
pub fn pdf_sun(sun: &SunLight, selection: PdfDiscrete) -> PdfSolidAngle {
    chosen(selection, pdf_cone(sun_height(sun)))
}

/// Radiance of all suns that lie in the unit direction `direction`, without those `but`.
pub fn suns_radiance(world: &World<'_>, direction: DVec3, but: &[u32]) -> DVec3 {
    let suns =
        suns(world).filter(|(index, sun, _)| is_in_sun(sun, direction) && !but.contains(index));
    suns.map(|(_, sun, _)| sun_radiance(&sun)).sum()
}

/// A direction into a sun, uniform over its solid angle.
pub fn sample_sun(sun: &SunLight, choice: PdfDiscrete, x: DVec3, u: DVec2) -> LightSample {
    let (wi, _) = sample_cone(-sun.direction, sun_height(sun), u);
    let pdf = chosen(choice, pdf_cone(sun_height(sun)));
    LightSample {
        wi,
        target_point: x + wi * FAR,
        radiance_over_pdf: sun_radiance(sun) / pdf.0,
        pdf,
        pdf_on_light: None,
        cos_light: 1.0,
        delta: false,
    }
}
