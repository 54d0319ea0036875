//! Light sampling: choose a light, then a direction towards it.

use super::alias_table::{Choice, alias_choice};
use super::area_light::{area_light, sample_area_light, sample_textured_light};
use super::directional::sample_directional_light;
use super::emission::{emission_factor, emission_map, sample_emission};
use super::environment::{environment_radiance, sample_environment};
use super::point::sample_point_light;
use super::sample::LightSample;
use super::spot::sample_spot_light;
use super::sun::{sample_sun, suns_radiance};
use crate::emitters::Emitter;
use crate::reference::core::frame::ShadingFrame;
use crate::reference::scene::fetch::World;
use crate::scene::Light;
use glam::{DVec2, DVec3};

/// The light that the random word `u` selects by a table; `None` where there is none.
pub fn choose_light(world: &World<'_>, u: u32) -> Option<Choice> {
    let selection = world.prepared.emitters.selection.as_ref()?;
    Some(alias_choice(u, selection.table()?))
}

/// The number of samples of a light that has its own, with `rays` shadow rays: without extent one.
pub fn samples_of_light(world: &World<'_>, light: u32, rays: u32) -> u32 {
    match world.prepared.emitters.lights[light as usize] {
        Emitter::Delta(_) => 1,
        Emitter::Area { .. } | Emitter::Sun(_) | Emitter::Environment => rays,
    }
}

/// Radiance that arrives from infinitely far in the unit direction `direction`, without the suns
/// `but`.
pub fn distant_radiance(world: &World<'_>, direction: DVec3, but: &[u32]) -> DVec3 {
    environment_radiance(world, direction) + suns_radiance(world, direction, but)
}

/// A sample of the chosen light from `x`, on a surface with the frame `frame`. `u` is the point on
/// the light, `texel` a random word.
pub fn sample_chosen_light(
    world: &World<'_>,
    choice: Choice,
    (x, frame): (DVec3, &ShadingFrame),
    u: DVec2,
    texel: u32,
) -> LightSample {
    let probability = choice.probability;
    let mut sample = match &world.prepared.emitters.lights[choice.index as usize] {
        Emitter::Area { .. } => {
            let light = area_light(world, choice.index);
            match emission_map(world, choice.index) {
                Some(map) => {
                    let (u, on_square) = sample_emission(map, u, texel);
                    sample_textured_light(world, &light, map, probability, x, (u, on_square))
                }
                None => sample_area_light(&light, probability, x, frame, u),
            }
        }
        Emitter::Delta(Light::Point(light)) => sample_point_light(light, probability, x),
        Emitter::Delta(Light::Spot(light)) => sample_spot_light(light, probability, x),
        Emitter::Delta(Light::Directional(light)) => {
            sample_directional_light(light, probability, x)
        }
        Emitter::Delta(Light::Sun(sun)) | Emitter::Sun(sun) => sample_sun(sun, probability, x, u),
        Emitter::Environment => sample_environment(world, probability, x, u, texel),
    };
    if !world.shines(choice.index as usize) {
        sample.radiance_over_pdf = DVec3::ZERO;
    }
    sample
}

/// Radiance that the surface of a light emits at its coordinates `st` towards a viewer on its front
/// or back.
pub fn emitted_radiance(world: &World<'_>, light: u32, front: bool, st: DVec2) -> DVec3 {
    let factor = match emission_map(world, light) {
        Some(map) => emission_factor(world, map, st),
        None => DVec3::ONE,
    };
    match world.prepared.emitters.lights[light as usize] {
        Emitter::Area {
            radiance,
            two_sided,
            ..
        } if (front || two_sided) && world.shines(light as usize) => radiance * factor,
        _ => DVec3::ZERO,
    }
}
