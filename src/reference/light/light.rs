//! Light sampling: choose a light, then a direction towards it.

use super::alias_table::{Choice, alias_choice};
use super::area_light::{
    LightSample, area_light, no_light, sample_area_light, sample_textured_light,
};
use super::emission::{emission_factor, emission_map, sample_emission};
use super::environment::{
    bilinear_texels, map_from_direction, pdf_environment_cell, sample_environment_cell,
};
use super::sphere::{pdf_cone, sample_cone, sample_sphere_area};
use super::spot::spot_falloff;
use super::sun::suns_radiance;
use crate::emitters::{Emitter, Sun};
use crate::reference::core::frame::ShadingFrame;
use crate::reference::core::pdf::{PdfArea, PdfDiscrete, PdfSolidAngle, chosen};
use crate::reference::scene::fetch::World;
use crate::scene::light::Interpolation;
use crate::scene::{Environment, EnvironmentMap, EnvironmentRadiance, Light};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// Length beyond everything in the normalised scene.
const FAR: f64 = 4.0;

/// The light that the random word `u` selects by a table; `None` where there is none.
pub fn choose_light(world: &World<'_>, u: u32) -> Option<Choice> {
    let selection = world.prepared.emitters.selection.as_ref()?;
    Some(alias_choice(u, selection.table()?))
}

/// The number of samples of a light that has its own, with `rays` shadow rays: without extent one.
pub fn own_samples(world: &World<'_>, light: u32, rays: u32) -> u32 {
    match world.prepared.emitters.lights[light as usize] {
        Emitter::Delta(_) => 1,
        Emitter::Area { .. } | Emitter::Sun(_) | Emitter::Environment => rays,
    }
}

/// A light without a surface, seen from `x`.
fn delta_light_sample(light: &Light, choice: PdfDiscrete, x: DVec3) -> LightSample {
    let from_point = |position: DVec3, intensity: &dyn Fn(DVec3) -> DVec3| {
        let d = position - x;
        let Some(wi) = d.try_normalize() else {
            return no_light();
        };
        LightSample {
            wi,
            target_point: position,
            radiance_over_pdf: intensity(wi) / (d.length_squared() * choice.0),
            pdf: PdfSolidAngle(0.0),
            pdf_on_light: None,
            cos_light: 1.0,
            delta: true,
        }
    };
    match *light {
        Light::Point {
            position,
            intensity,
        } => from_point(position, &|_| intensity),
        Light::Spot {
            position,
            direction,
            intensity,
            inner_angle,
            outer_angle,
        } => from_point(position, &|wi| {
            let cos_theta = -wi.dot(direction);
            intensity * spot_falloff(cos_theta, inner_angle.cos(), outer_angle.cos())
        }),
        Light::Directional {
            direction,
            irradiance,
        } => LightSample {
            wi: -direction,
            target_point: x - direction * FAR,
            radiance_over_pdf: irradiance / choice.0,
            pdf: PdfSolidAngle(0.0),
            pdf_on_light: None,
            cos_light: 1.0,
            delta: true,
        },
        Light::Sun { .. } => unreachable!("suns are emitters of their own"),
    }
}

/// A direction into a sun, uniform over its solid angle.
pub fn sample_sun(sun: &Sun, choice: PdfDiscrete, x: DVec3, u: DVec2) -> LightSample {
    let (wi, _) = sample_cone(sun.towards, sun.height, u);
    let pdf = chosen(choice, pdf_cone(sun.height));
    LightSample {
        wi,
        target_point: x + wi * FAR,
        radiance_over_pdf: sun.radiance / pdf.0,
        pdf,
        pdf_on_light: None,
        cos_light: 1.0,
        delta: false,
    }
}

/// Radiance that arrives from infinitely far in the unit direction `direction`.
pub fn distant_radiance(world: &World<'_>, direction: DVec3) -> DVec3 {
    environment_radiance(world, direction) + suns_radiance(world, direction)
}

/// A sample of the chosen light from `x`, on a surface with the frame `frame`. `u` is the point on the light, `texel` a
/// random word.
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
        Emitter::Delta(light) => delta_light_sample(light, probability, x),
        Emitter::Sun(sun) => sample_sun(sun, probability, x, u),
        Emitter::Environment => sample_environment(world, probability, x, u, texel),
    };
    if !world.shines(choice.index as usize) {
        sample.radiance_over_pdf = DVec3::ZERO;
    }
    sample
}

/// Radiance that the surface of a light emits at its coordinates `st` towards a viewer on its front or back.
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

fn environment<'a>(world: &World<'a>) -> &'a Environment {
    let environment = world.prepared.data.scene.environment.as_ref();
    environment.expect("only a scene with an environment asks for it")
}

fn texel(map: &EnvironmentMap, column: u32, row: u32) -> DVec3 {
    let rgb = map.texels[row as usize * map.width as usize + column as usize];
    DVec3::from_array(rgb.map(f64::from))
}

/// Radiance of `map` at image coordinates in [0, 1]².
fn map_radiance(map: &EnvironmentMap, image: DVec2) -> DVec3 {
    let position = image * DVec2::new(f64::from(map.width), f64::from(map.height));
    match map.interpolation {
        Interpolation::Linear => {
            let n = bilinear_texels(position, [map.width, map.height]);
            let top = texel(map, n.left, n.top).lerp(texel(map, n.right, n.top), n.blend.x);
            let left = texel(map, n.left, n.bottom);
            let bottom = left.lerp(texel(map, n.right, n.bottom), n.blend.x);
            top.lerp(bottom, n.blend.y)
        }
        Interpolation::Nearest => texel(
            map,
            (position.x as u32).min(map.width - 1),
            (position.y as u32).min(map.height - 1),
        ),
    }
}

/// Radiance that arrives from the environment in the unit direction `direction`; 0 where there is none.
pub fn environment_radiance(world: &World<'_>, direction: DVec3) -> DVec3 {
    let Some(environment) = &world.prepared.data.scene.environment else {
        return DVec3::ZERO;
    };
    if !environment_light(world).is_none_or(|index| world.shines(index)) {
        return DVec3::ZERO;
    }
    let to_map = environment.rotation.transpose();
    environment.scale
        * match &environment.radiance {
            EnvironmentRadiance::Constant(radiance) => *radiance,
            EnvironmentRadiance::Map(map) => {
                map_radiance(map, map_from_direction(to_map * direction))
            }
        }
}

/// Probability that light selection chooses the environment.
fn environment_selection(world: &World<'_>) -> PdfDiscrete {
    let probability = |i| world.prepared.emitters.probability(i);
    PdfDiscrete(environment_light(world).map_or(0.0, probability))
}

/// The environment's place among the lights.
fn environment_light(world: &World<'_>) -> Option<usize> {
    let mut lights = world.prepared.emitters.lights.iter();
    lights.position(|l| *l == Emitter::Environment)
}

/// The cell of the environment's sampling grid in the unit direction `direction`, and its probability; `None` where the
/// environment has no map.
fn environment_cell(world: &World<'_>, direction: DVec3) -> Option<([u32; 2], PdfDiscrete)> {
    let grid = world.prepared.emitters.environment.as_ref()?;
    let [width, height] = grid.size;
    let image = map_from_direction(environment(world).rotation.transpose() * direction);
    let column = ((image.x * f64::from(width)) as u32).min(width - 1);
    let row = ((image.y * f64::from(height)) as u32).min(height - 1);
    let p = grid.table.probability[row as usize * width as usize + column as usize];
    Some(([column, row], PdfDiscrete(p)))
}

/// Angle between `direction` and the edge of its cell of the environment's sampling grid; π where there is no map.
pub fn environment_cell_margin(world: &World<'_>, direction: DVec3) -> f64 {
    let Some(grid) = &world.prepared.emitters.environment else {
        return PI;
    };
    let image = map_from_direction(environment(world).rotation.transpose() * direction);
    let cells = DVec2::new(f64::from(grid.size[0]), f64::from(grid.size[1]));
    let margin = (image * cells - (image * cells).round()).abs() / cells;
    let sin_polar = (PI * image.y).sin();
    f64::min(margin.x * 2.0 * PI * sin_polar, margin.y * PI)
}

/// Density of a cell with probability `p` on the unit square of the environment's image.
fn pdf_on_image(p: PdfDiscrete, [width, height]: [u32; 2]) -> PdfArea {
    PdfArea(p.0 * f64::from(width) * f64::from(height))
}

/// Density of [`sample_environment`] in the unit direction `direction`: probability of the environment, density on its
/// image, and per solid angle with light selection included.
pub fn pdf_environment(
    world: &World<'_>,
    direction: DVec3,
) -> (PdfDiscrete, Option<PdfArea>, PdfSolidAngle) {
    let selection = environment_selection(world);
    let grid = world.prepared.emitters.environment.as_ref();
    let (on_image, pdf) = match (grid, environment_cell(world, direction)) {
        (Some(grid), Some((cell, p))) => (
            Some(pdf_on_image(p, grid.size)),
            pdf_environment_cell(p, cell[1], grid.size),
        ),
        _ => (Some(PdfArea(1.0)), PdfSolidAngle(1.0 / (4.0 * PI))),
    };
    (selection, on_image, chosen(selection, pdf))
}

/// A direction towards the environment, in proportion to the luminance of its map.
pub fn sample_environment(
    world: &World<'_>,
    selection: PdfDiscrete,
    x: DVec3,
    u: DVec2,
    texel: u32,
) -> LightSample {
    let (direction, on_image, pdf) = match &world.prepared.emitters.environment {
        Some(grid) => {
            let choice = alias_choice(texel, &grid.table);
            let cell = [choice.index % grid.size[0], choice.index / grid.size[0]];
            (
                environment(world).rotation * sample_environment_cell(cell, grid.size, u),
                Some(pdf_on_image(choice.probability, grid.size)),
                pdf_environment_cell(choice.probability, cell[1], grid.size),
            )
        }
        None => (
            sample_sphere_area(u),
            Some(PdfArea(1.0)),
            PdfSolidAngle(1.0 / (4.0 * PI)),
        ),
    };
    let pdf = chosen(selection, pdf);
    LightSample {
        wi: direction,
        target_point: x + direction * FAR,
        radiance_over_pdf: environment_radiance(world, direction) / pdf.0.max(1e-30),
        pdf,
        pdf_on_light: on_image,
        cos_light: 1.0,
        delta: false,
    }
}
