//! How directions are chosen at a point: the histogram of a sampler beside its density.
//!
//! Both come from the twin, in f64. Cells are equal in solid angle: azimuth to the right, the
//! cosine to the shading normal upwards.

use direkt::low_level::effects::Effect;
use direkt::low_level::emitters::{Emitter, Selection};
use direkt::low_level::reference::bsdf::bsdf::{Hemisphere, eval_bsdf, pdf_hemisphere};
use direkt::low_level::reference::core::frame::{to_local, to_world};
use direkt::low_level::reference::core::pdf::PdfDiscrete;
use direkt::low_level::reference::core::ray::{Hit, Ray};
use direkt::low_level::reference::core::rng::{pcg4d, to_unit, to_unit_2d};
use direkt::low_level::reference::kernel::direct::{choose_direction, hemisphere};
use direkt::low_level::reference::light::alias_table::Choice;
use direkt::low_level::reference::light::area_light::pdf_area_light;
use direkt::low_level::reference::light::environment::{environment_radiance, pdf_environment};
use direkt::low_level::reference::light::light::{
    choose_light, emitted_radiance, sample_chosen_light,
};
use direkt::low_level::reference::light::sample::LightSample;
use direkt::low_level::reference::light::sphere::sample_sphere_area;
use direkt::low_level::reference::light::sun::{is_in_sun, pdf_sun, suns};
use direkt::low_level::reference::light::tree::choose_tree_light;
use direkt::low_level::reference::scene::fetch::World;
use direkt::low_level::reference::scene::surface::{Surface, surface_at};
use direkt::low_level::reference::scene::trace::intersect_primitive;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Cells along azimuth and cosine.
pub const CELLS: [usize; 2] = [64, 32];
/// Samples that are counted.
const SAMPLES: u32 = 1 << 17;
/// Points of a cell, along each side, at which the density is taken.
const POINTS: usize = 8;
/// Lights at most whose densities are added up.
const MAX_LIGHTS: usize = 64;

/// How one sampler chooses directions.
#[derive(Debug, Clone, PartialEq)]
pub struct Density {
    /// What is sampled.
    pub sampler: &'static str,
    /// Probability of each cell, row by row from the pole along the normal.
    pub expected: Vec<f64>,
    /// Part of the samples in each cell.
    pub observed: Vec<f64>,
}

/// The samplers at work at a surface.
pub fn densities(world: &World<'_>, s: &Surface) -> Vec<Density> {
    let effects = &world.prepared.effects;
    let by_direction = hemisphere(world.prepared);
    let mut all = Vec::new();
    if by_direction.is_some() || effects.contains(Effect::SampleBsdf) {
        all.push(Density {
            sampler: "directions",
            expected: expected(|wi| pdf_direction(s, by_direction, wi)),
            observed: observed(|i| sample_direction(s, by_direction, i)),
        });
    }
    let lights = world.prepared.emitters.lights.len();
    if effects.contains(Effect::SampleLights) && (1..=MAX_LIGHTS).contains(&lights) {
        let own = own_turns(world);
        all.push(Density {
            sampler: "lights",
            expected: expected(|wi| pdf_lights(world, &own, s, to_world(&s.frame, wi))),
            observed: observed(|i| {
                let wi = sample_lights(world, &own, s, i)?;
                Some(to_local(&s.frame, wi))
            }),
        });
    }
    all
}

/// Random words of sample `i`.
fn words(i: u32, group: u32) -> [u32; 4] {
    pcg4d([i, group, 0x5eed, 7])
}

fn cell(wi: DVec3) -> usize {
    let [columns, rows] = CELLS;
    let at = |part: f64, count: usize| ((part * count as f64) as usize).min(count - 1);
    let azimuth = (wi.y.atan2(wi.x) / TAU).rem_euclid(1.0);
    at(0.5 * (1.0 - wi.z), rows) * columns + at(azimuth, columns)
}

/// The integral of `pdf` over each cell.
fn expected(pdf: impl Fn(DVec3) -> f64 + Sync) -> Vec<f64> {
    let [columns, rows] = CELLS;
    let solid_angle = 2.0 * TAU / (columns * rows) as f64;
    let cells = (0..columns * rows).into_par_iter().map(|cell| {
        let (column, row) = (cell % columns, cell / columns);
        let points = (0..POINTS * POINTS).map(|point| {
            let inside = |i: usize| (i as f64 + 0.5) / POINTS as f64;
            let azimuth = (column as f64 + inside(point % POINTS)) / columns as f64;
            let height = (row as f64 + inside(point / POINTS)) / rows as f64;
            pdf(sample_sphere_area(DVec2::new(height, azimuth)))
        });
        points.sum::<f64>() / (POINTS * POINTS) as f64 * solid_angle
    });
    cells.collect()
}

/// The part of the samples that `sample` puts into each cell; what is none is in no cell.
fn observed(sample: impl Fn(u32) -> Option<DVec3> + Sync) -> Vec<f64> {
    let found: Vec<_> = (0..SAMPLES)
        .into_par_iter()
        .filter_map(|i| sample(i).map(cell))
        .collect();
    let mut parts = vec![0.0; CELLS[0] * CELLS[1]];
    for cell in found {
        parts[cell] += 1.0 / f64::from(SAMPLES);
    }
    parts
}

fn sample_direction(s: &Surface, how: Option<Hemisphere>, i: u32) -> Option<DVec3> {
    let [x, y, lobe, _] = words(i, 1);
    let sample = choose_direction(s, how, to_unit(lobe), to_unit_2d(x, y));
    (sample.pdf.0 > 0.0).then_some(sample.wi)
}

fn pdf_direction(s: &Surface, how: Option<Hemisphere>, wi: DVec3) -> f64 {
    match how {
        _ if wi.z <= 0.0 => 0.0,
        Some(how) => pdf_hemisphere(how, wi.z).0,
        None => eval_bsdf(&s.material, wi, s.wo).pdf.0,
    }
}

/// The lights that have their turns where none is chosen.
fn own_turns(world: &World<'_>) -> Vec<u32> {
    match &world.prepared.emitters.selection {
        Some(Selection::All(sampled)) => {
            let lights = (0..).zip(sampled).filter(|(_, sampled)| **sampled);
            lights.map(|(index, _)| index).collect()
        }
        _ => Vec::new(),
    }
}

/// Of all light samples that light comes from, one.
fn sample_lights(world: &World<'_>, own: &[u32], s: &Surface, i: u32) -> Option<DVec3> {
    let ([choice, x, y, texel], tree) = (words(i, 2), words(i, 3));
    let chosen = match &world.prepared.emitters.selection {
        Some(Selection::Tree(of)) => {
            choose_tree_light(of, choice, tree, s.position, s.frame.z).choice
        }
        Some(Selection::All(_)) => {
            let index = *own.get(i as usize % own.len().max(1))?;
            let probability = PdfDiscrete(1.0);
            Some(Choice { index, probability })
        }
        _ => choose_light(world, choice),
    };
    let u = to_unit_2d(x, y);
    let place = (s.position, &s.frame);
    let LightSample {
        wi,
        radiance_over_pdf,
        delta,
        ..
    } = sample_chosen_light(world, chosen?, place, u, texel);
    (!delta && radiance_over_pdf.max_element() > 0.0).then_some(wi)
}

/// The density of light samples, of all lights that shine from the unit direction `wi`, together.
fn pdf_lights(world: &World<'_>, own: &[u32], s: &Surface, wi: DVec3) -> f64 {
    let place = (s.position, &s.frame);
    let ray = Ray {
        origin: s.position,
        direction: wi,
    };
    let emitters = &world.prepared.emitters;
    let of_light = |(index, emitter): (usize, &Emitter)| {
        let light = index as u32;
        match *emitter {
            Emitter::Area { primitive, .. } if s.own_light != Some(light) => {
                let geometry = &world.primitives[primitive as usize];
                let Some((t, st)) = intersect_primitive(&ray, geometry, f64::INFINITY) else {
                    return 0.0;
                };
                let hit = Hit { t, primitive, st };
                let y = surface_at(world, &ray, &hit, -wi);
                if emitted_radiance(world, light, y.front, st).max_element() <= 0.0 {
                    return 0.0;
                }
                pdf_area_light(world, light, place, wi, (t * t, y.cos_o, st)).0
            }
            Emitter::Environment if environment_radiance(world, wi).max_element() > 0.0 => {
                pdf_environment(world, wi).2.0
            }
            _ => 0.0,
        }
    };
    let lights: f64 = emitters.lights.iter().enumerate().map(of_light).sum();
    let suns = suns(world).filter(|(_, sun, _)| is_in_sun(sun, wi));
    let all = lights + suns.map(|(_, sun, p)| pdf_sun(&sun, p).0).sum::<f64>();
    match &emitters.selection {
        // Each light has its turn.
        Some(Selection::All(_)) => all / own.len().max(1) as f64,
        _ => all,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example;
    use direkt::low_level::prepare::Prepared;
    use direkt::low_level::reference::scene::opacity::Crossings;
    use direkt::low_level::reference::scene::trace::closest_hit;
    use direkt::scene::Strategy;
    use direkt::scene::load::{LoadOptions, load};

    /// On Cornell's back wall. What differs is the noise of the counts, √(2/π · cells/samples) ≤
    /// 0.07, and the few points of the cells that a light's edge passes through.
    #[test]
    fn histograms_are_those_of_the_densities() {
        for strategy in [
            Strategy::MisPower,
            Strategy::UniformHemisphere,
            Strategy::LightArea,
        ] {
            let options = LoadOptions::default();
            let mut scene = load(&example("cornell"), &options).expect("Cornell");
            scene.render.estimator.strategy = strategy;
            let prepared = Prepared::of(scene);
            let world = World::new(&prepared);
            let ray = Ray {
                origin: prepared.data.normalization.point(DVec3::new(0.1, 0.5, 0.0)),
                direction: DVec3::new(0.02, 0.05, -1.0).normalize(),
            };
            let hit = closest_hit(&world, &ray, Crossings::OPAQUE);
            let s = surface_at(&world, &ray, &hit.expect("the back wall"), -ray.direction);
            let found = densities(&world, &s);
            assert_eq!(found.len(), if strategy.is_mis() { 2 } else { 1 });
            for density in found {
                let total: f64 = density.expected.iter().sum();
                assert!(
                    (total - 1.0).abs() < 0.03,
                    "{strategy}, {}: {total}",
                    density.sampler
                );
                let pairs = density.observed.iter().zip(&density.expected);
                let differ: f64 = pairs.map(|(o, e)| (o - e).abs()).sum();
                assert!(differ < 0.1, "{strategy}, {}: {differ}", density.sampler);
                let shifted = density.observed.iter().skip(3).zip(&density.expected);
                let shifted: f64 = shifted.map(|(o, e)| (o - e).abs()).sum();
                let flat =
                    strategy == Strategy::UniformHemisphere || density.sampler == "directions";
                assert!(
                    flat || shifted > 0.5,
                    "turned aside it does not fit: {shifted}"
                );
            }
        }
    }

    #[test]
    fn cells_hold_their_directions() {
        for i in 0..CELLS[0] * CELLS[1] {
            let (column, row) = (i % CELLS[0], i / CELLS[0]);
            let azimuth = (column as f64 + 0.5) / CELLS[0] as f64;
            let height = (row as f64 + 0.5) / CELLS[1] as f64;
            assert_eq!(cell(sample_sphere_area(DVec2::new(height, azimuth))), i);
        }
        assert_eq!(cell(DVec3::Z), 0);
    }
}
