//! The environment: radiance, density and directions.

use super::{IMPORTS, directions, prepared, texel_error};
use crate::support::every_kind::{constant_environment, environment_map};
use crate::support::random::{numbers, rounded};
use crate::support::rounding::{U, close};
use crate::support::shader::{Function, call_in, words};
use crate::support::{context, histogram, statistics};
use direkt::low_level::emitters::Emitter;
use direkt::low_level::reference::BrokenTwin;
use direkt::low_level::reference::broken::BROKEN_TWINS;
use direkt::low_level::reference::light::environment::{
    environment_cell_margin, environment_radiance, map_from_direction, pdf_environment,
};
use direkt::low_level::reference::light::sphere::sample_sphere_area;
use direkt::low_level::reference::scene::fetch::World;
use direkt::scene::LightSampling;
use direkt::scene::environment::Interpolation;
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

#[test]
fn directions_towards_the_environment_match_pdf() {
    let context = context();
    for (seed, environment) in (80..).zip([
        constant_environment(),
        environment_map(Interpolation::Nearest),
        environment_map(Interpolation::Linear),
    ]) {
        let prepared = prepared(environment, LightSampling::Area);
        let world = World::new(&prepared);
        let lights = &prepared.emitters.lights;
        let index = lights
            .iter()
            .position(|l| *l == Emitter::Environment)
            .unwrap();
        let wis = directions(context, &prepared, index as u32, DVec3::ZERO, seed);
        let rotation = prepared.data.scene.environment.as_ref().unwrap().rotation;
        // In coordinates of the image, whose texels are the cells here: (31, 17).
        let samples: Vec<DVec2> = wis
            .iter()
            .map(|wi| map_from_direction(rotation.transpose() * *wi))
            .collect();
        let direction = |p: DVec2| {
            let (sin, cos) = (PI * p.y).sin_cos();
            let (sin_phi, cos_phi) = (TAU * p.x).sin_cos();
            rotation * DVec3::new(-sin_phi * sin, cos, cos_phi * sin)
        };
        // dω = 2π² sinθ du dv.
        let pdf = |p: DVec2, of: &dyn Fn(DVec3) -> f64| {
            of(direction(p)) * 2.0 * PI * PI * (PI * p.y).sin()
        };
        let (choice, _, _) = pdf_environment(&world, DVec3::Z);
        let right = |w: DVec3| pdf_environment(&world, w).2.0 / choice.0;
        let what = format!("environment, seed {seed}, {}", context.adapter.name);
        let test = |samples: &[DVec2], of: &dyn Fn(DVec3) -> f64| {
            histogram::p_value(samples, DVec2::ZERO, DVec2::ONE, |p| pdf(p, of))
        };
        statistics::accept(test(&samples, &right), &what);
        for row in BROKEN_TWINS {
            let broken = match row.twin {
                BrokenTwin::PdfScaled => test(&samples, &|w| 1.02 * right(w)),
                // Density on the image taken for that per solid angle; without a map there is none.
                BrokenTwin::WrongMeasure => {
                    if prepared.emitters.environment.is_none() {
                        continue;
                    }
                    test(&samples, &|w| pdf_environment(&world, w).1.unwrap().0)
                }
                BrokenTwin::ExtraCosine => test(&samples, &|w| 2.0 * right(w) * w.z.abs()),
                // One light alone is sampled, and no BSDF.
                BrokenTwin::LightLeftOut
                | BrokenTwin::SwappedSinCos
                | BrokenTwin::MisWeights
                | BrokenTwin::RaysForgotten
                | BrokenTwin::OpaqueShadows => {
                    continue;
                }
            };
            statistics::reject(broken, &format!("{what}, {}", row.name));
        }
    }
}

/// Radiance of both kinds of map and density in random directions, except at the edges of texels.
#[test]
fn the_environment_is_the_twins() {
    let context = context();
    for environment in [
        constant_environment(),
        environment_map(Interpolation::Nearest),
        environment_map(Interpolation::Linear),
    ] {
        let prepared = prepared(environment, LightSampling::Area);
        let world = World::new(&prepared);
        let function = Function {
            imports: IMPORTS,
            body: "let w = in_vec3f(0u);
                   out_vec3f(0u, environment_radiance(w));
                   out_f32(3u, pdf_environment(w).value);",
            inputs: 3,
            outputs: 4,
            features: &[],
        };
        let mut directions: Vec<DVec3> = (0..10_000)
            .map(|i| {
                let [a, b, ..] = numbers(i, 5, 43);
                rounded(sample_sphere_area(DVec2::new(a, b)))
            })
            .collect();
        directions.extend([
            DVec3::X,
            DVec3::Y,
            DVec3::Z,
            -DVec3::X,
            -DVec3::Y,
            -DVec3::Z,
        ]);
        let inputs: Vec<f64> = directions.iter().flat_map(DVec3::to_array).collect();
        let answers = call_in(
            context,
            &prepared,
            &function,
            &words(&inputs),
            directions.len(),
        );
        let angle = 16.0 * U;
        let linear = prepared
            .effects
            .contains(direkt::low_level::effects::Effect::EnvironmentLinear);
        for (w, (radiance, pdf)) in directions.iter().zip(answers.vec3(0).zip(answers.f64(3))) {
            assert!(radiance.is_finite() && pdf.is_finite());
            if environment_cell_margin(&world, *w) < angle {
                continue;
            }
            let expected = environment_radiance(&world, *w);
            let slope = if linear {
                texel_error(&world, *w, angle)
            } else {
                0.0
            };
            let off = (radiance - expected).abs();
            assert!(
                off.cmple(16.0 * U * expected + slope).all(),
                "{}: {radiance} from {w}, not {expected}",
                context.adapter.name
            );
            let expected = pdf_environment(&world, *w).2.0;
            assert!(close(pdf, expected, 64.0), "{pdf} at {w}, not {expected}");
        }
    }
}
