//! Suns; see `shaders/light/sun.wesl`.

use super::sphere::pdf_cone;
use crate::emitters::{Emitter, Sun};
use crate::reference::core::pdf::{PdfDiscrete, PdfSolidAngle, chosen};
use crate::reference::scene::fetch::World;
use glam::DVec3;

/// The suns of the scene that shine, with the probabilities that light selection chooses them.
pub fn suns(world: &World<'_>) -> impl Iterator<Item = (Sun, PdfDiscrete)> {
    let emitters = &world.prepared.emitters;
    let lights = emitters.lights.iter().enumerate();
    lights.filter_map(|(index, light)| match light {
        Emitter::Sun(sun) if world.shines(index) => {
            Some((*sun, PdfDiscrete(emitters.probability(index))))
        }
        _ => None,
    })
}

/// Whether the sun lies in the unit direction `world`.
pub fn is_in_sun(sun: &Sun, world: DVec3) -> bool {
    (world - sun.towards).length_squared() <= 2.0 * sun.height
}

/// Angle between the unit direction `world` and the sun's edge.
pub fn sun_margin(sun: &Sun, world: DVec3) -> f64 {
    let half_angle = |chord_squared: f64| (0.5 * chord_squared.sqrt()).min(1.0).asin();
    let from_middle = half_angle((world - sun.towards).length_squared());
    2.0 * (from_middle - half_angle(2.0 * sun.height)).abs()
}

/// Density with which light sampling chooses a direction within the sun, light selection included.
pub fn pdf_sun(sun: &Sun, selection: PdfDiscrete) -> PdfSolidAngle {
    chosen(selection, pdf_cone(sun.height))
}

/// Radiance of all suns that lie in the unit direction `direction`.
pub fn suns_radiance(world: &World<'_>, direction: DVec3) -> DVec3 {
    let suns = suns(world).filter(|(sun, _)| is_in_sun(sun, direction));
    suns.map(|(sun, _)| sun.radiance).sum()
}
