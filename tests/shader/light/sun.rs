//! `shaders/light/sun.wesl`, and light sampling of suns.

use crate::support::random::Random;
use crate::support::rounding::{U, close};
use crate::support::shader::{Function, call_in};
use crate::support::{context, floor_pixel, histogram, prepared_for, statistics};
use direkt::low_level::emitters::Emitter;
use direkt::low_level::prepare::Prepared;
use direkt::low_level::reference::BrokenTwin;
use direkt::low_level::reference::core::frame::{frame_from_normal, to_local};
use direkt::low_level::reference::core::pdf::PdfDiscrete;
use direkt::low_level::reference::light::sun::{
    pdf_sun, sample_sun, sun_height, sun_margin, suns, suns_radiance,
};
use direkt::low_level::reference::scene::fetch::World;
use direkt::scene::{Light, LightSelection, Strategy, SunLight};
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// The smallest sun there is, the sun, and two that overlap.
fn prepared() -> Prepared {
    let mut scene = floor_pixel();
    for (direction, degrees) in [
        (DVec3::new(0.3, -0.2, -1.0), 0.001),
        (DVec3::new(-0.4, 0.5, -0.8), 0.53),
        (DVec3::new(0.5, 0.5, -1.0), 20.0),
        (DVec3::new(0.6, 0.4, -1.0), 170.0),
    ] {
        scene.lights.push(Light::Sun(SunLight {
            direction: direction.normalize(),
            irradiance: DVec3::new(3.0, 2.0, 1.0),
            angular_radius: 0.5 * f64::to_radians(degrees),
        }));
    }
    prepared_for(scene, Strategy::MisPower, LightSelection::Uniform)
}

const IMPORTS: &str = "import package::core::frame::frame_from_normal;
    import package::light::sample::LightChoice;
    import package::core::pdf::ExpectedSamples;
    import package::light::light::sample_chosen_light;
    import package::light::sun::{pdf_sun, suns_radiance};
    import package::scene::fetch::fetch_light;";

/// Directions of a cone of height k are off by a few roundings of a unit vector; densities by few
/// of k.
#[test]
fn sun_samples_are_the_twins() {
    let context = context();
    let prepared = prepared();
    let world = World::new(&prepared);
    let function = Function {
        imports: IMPORTS,
        body: "let light = fetch_light(in_u32(0u));
               let facing = frame_from_normal(vec3f(0.0, 0.0, 1.0));
               let choice = LightChoice(in_u32(0u), light.expected_samples);
               let s = sample_chosen_light(choice, vec3f(0.0), facing, in_vec2f(1u), 0u);
               out_vec3f(0u, s.wi);
               out_f32(3u, s.pdf.value);
               out_f32(4u, pdf_sun(light).value);
               out_vec3f(5u, s.radiance_over_pdf);",
        inputs: 3,
        outputs: 8,
        features: &[],
    };
    let mut random = Random::new(71);
    let mut inputs = Vec::new();
    let mut items = Vec::new();
    for index in 0..4_u32 {
        for _ in 0..20_000 {
            let u = DVec2::new(random.uniform(), random.uniform()).as_vec2();
            inputs.extend([index, u.x.to_bits(), u.y.to_bits()]);
            items.push((index, u.as_dvec2()));
        }
    }
    let answers = call_in(context, &prepared, &function, &inputs, items.len());
    let found = answers.vec3(0).zip(answers.f64(3)).zip(answers.f64(4));
    for (((index, u), ((wi, pdf), evaluated)), over_pdf) in
        items.iter().zip(found).zip(answers.vec3(5))
    {
        let Emitter::Sun(sun) = prepared.emitters.lights[*index as usize] else {
            unreachable!("all lights are suns");
        };
        let selection = PdfDiscrete(prepared.emitters.probability(*index as usize));
        let twin = sample_sun(&sun, selection, DVec3::ZERO, *u);
        assert!(
            (wi - twin.wi).length() < 8.0 * U,
            "sun {index}, {u}: {wi}, not {}",
            twin.wi
        );
        for pdf in [pdf, evaluated] {
            assert!(
                close(pdf, twin.pdf.0, 8.0),
                "sun {index}: {pdf}, not {}",
                twin.pdf.0
            );
        }
        let expected = twin.radiance_over_pdf;
        assert!(
            (over_pdf - expected).abs().max_element() < 16.0 * U * expected.max_element(),
            "sun {index}: {over_pdf}, not {expected}"
        );
    }
    assert_eq!(suns(&world).count(), 4);
}

/// Uniform over the solid angle: in azimuth, and in 1 − cosθ up to the cone's.
#[test]
fn sun_samples_follow_their_density() {
    const DRAWN: usize = 1 << 20;
    let context = context();
    let prepared = prepared();
    let function = Function {
        imports: IMPORTS,
        body:
            "let light = fetch_light(in_u32(0u));
               let facing = frame_from_normal(vec3f(0.0, 0.0, 1.0));
               let choice = LightChoice(in_u32(0u), light.expected_samples);
               out_vec3f(0u, sample_chosen_light(choice, vec3f(0.0), facing, in_vec2f(1u), 0u).wi);",
        inputs: 3,
        outputs: 3,
        features: &[],
    };
    // Of the first, f32 cannot tell enough directions apart.
    for index in 1..4_u32 {
        let Emitter::Sun(sun) = prepared.emitters.lights[index as usize] else {
            unreachable!("all lights are suns");
        };
        let mut random = Random::new(72 + index);
        let mut uniform = || (random.uniform() as f32).to_bits();
        let inputs: Vec<u32> = (0..DRAWN)
            .flat_map(|_| [index, uniform(), uniform()])
            .collect();
        let answers = call_in(context, &prepared, &function, &inputs, DRAWN);
        let around = frame_from_normal(-sun.direction);
        let samples: Vec<DVec2> = answers
            .vec3(0)
            .map(|wi| {
                let local = to_local(&around, wi);
                let height = 0.5 * (wi + sun.direction).length_squared();
                // Rounding puts the outermost beyond the edge.
                DVec2::new(local.y.atan2(local.x), (height / sun_height(&sun)).min(1.0))
            })
            .collect();
        let low = DVec2::new(-PI, 0.0);
        let high = DVec2::new(PI, 1.0);
        let per_cell = |pdf: f64| {
            let density = pdf * sun_height(&sun);
            histogram::p_value(&samples, low, high, |_| density)
        };
        let pdf = pdf_sun(&sun, PdfDiscrete(1.0)).0;
        let what = format!("sun {index}, {}", context.adapter.name);
        statistics::accept(per_cell(pdf), &what);
        statistics::reject_broken(&what, |twin| match twin {
            BrokenTwin::PdfScaled => Some(per_cell(1.02 * pdf)),
            // Per area of the disk in the sky, seen face on.
            BrokenTwin::WrongMeasure if index == 3 => {
                let flat = |p: DVec2| {
                    (1.0 - p.y * sun_height(&sun)) / (TAU * (1.0 - 0.5 * sun_height(&sun)))
                };
                Some(histogram::p_value(&samples, low, high, flat))
            }
            _ => None,
        });
    }
}

/// A direction is in a sun or not, but for those within rounding of its edge.
#[test]
fn suns_shine_where_they_are() {
    let context = context();
    let prepared = prepared();
    let world = World::new(&prepared);
    let function = Function {
        imports: IMPORTS,
        body: "out_vec3f(0u, suns_radiance(in_vec3f(0u), 0u));",
        inputs: 3,
        outputs: 3,
        features: &[],
    };
    let mut random = Random::new(73);
    let mut directions: Vec<DVec3> = (0..20_000).map(|_| random.direction()).collect();
    for (_, sun, _) in suns(&world) {
        let size = sun_height(&sun).sqrt();
        directions.extend((0..20_000).map(|_| {
            let off = random.direction() * random.between(0.0, 3.0 * size);
            (off - sun.direction).normalize()
        }));
    }
    let directions: Vec<DVec3> = directions.iter().map(|d| d.as_vec3().as_dvec3()).collect();
    let inputs: Vec<u32> = directions
        .iter()
        .flat_map(|d| d.as_vec3().to_array().map(f32::to_bits))
        .collect();
    let answers = call_in(context, &prepared, &function, &inputs, directions.len());
    let mut compared = 0;
    for (direction, found) in directions.iter().zip(answers.vec3(0)) {
        let margin = suns(&world).map(|(_, sun, _)| sun_margin(&sun, *direction));
        if margin.fold(PI, f64::min) > 4.0 * U {
            compared += 1;
            let expected = suns_radiance(&world, *direction, &[]);
            assert!(
                (found - expected).abs().max_element() <= 8.0 * U * expected.max_element(),
                "{direction}: {found}, not {expected}"
            );
        }
    }
    assert!(compared > 99_000, "{compared} of {}", directions.len());
}
