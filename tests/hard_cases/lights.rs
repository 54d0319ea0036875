//! Spheres from within, lights without extent, poles of environment maps: HARD CASES S6, S7, S8.

use super::worst;
use crate::support::hard_cases::{Measured, survive};
use crate::support::random::rounded;
use crate::support::shader::{Function, call, call_in, draw, words};
use crate::support::{context, edge_points, floor_pixel, point_light, prepared_for, shape};
use direkt::low_level::gpu::Context;
use direkt::low_level::prepare::Prepared;
use direkt::scene::environment::Interpolation;
use direkt::scene::{
    DirectionalLight, Environment, EnvironmentMap, EnvironmentRadiance, Geometry, Light,
    LightSelection, Strategy,
};
use glam::{DMat3, DVec3};
use std::f64::consts::PI;

fn failures(values: impl Iterator<Item = f64>) -> f64 {
    values.filter(|x| !x.is_finite()).count() as f64
}

/// Samples of the irradiance by a two-sided sphere of radius 2 and radiance 1, at places that are
/// given by the distance from its centre in radii, on a line, and the normal.
fn sphere_samples(
    context: &Context,
    places: &[(f64, DVec3)],
    features: &[&'static str],
) -> Vec<f64> {
    let function = Function {
        imports: "import package::core::frame::frame_from_normal;
            import package::core::pdf::ExpectedSamples;
            import package::light::area_light::sample_area_light;
            import package::scene::fetch::{LIGHT_SPHERE, Light};",
        body: "let light = Light(
                   vec3f(0.25, -0.5, 1.0), LIGHT_SPHERE, true, false, vec3f(2.0, 0.0, 0.0), ExpectedSamples(1.0), vec3f(0.0),
                   50.2654825, vec3f(1.0));
               let frame = frame_from_normal(in_vec3f(3u));
               let s = sample_area_light(light, ExpectedSamples(1.0), in_vec3f(0u), frame, in_vec2f(6u));
               out_f32(0u, s.radiance_over_pdf.x * max(dot(s.wi, frame.z), 0.0));",
        inputs: 8,
        outputs: 1,
        features,
    };
    let center = DVec3::new(0.25, -0.5, 1.0);
    let middle = |i: u32| (f64::from(i) + 0.5) / 64.0;
    let mut inputs = Vec::new();
    for (distance, normal) in places {
        let x = rounded(center + 2.0 * distance * OUTWARDS);
        for i in 0..64 * 64 {
            let u = [middle(i % 64), middle(i / 64)];
            inputs.extend(x.to_array().into_iter().chain(normal.to_array()).chain(u));
        }
    }
    call(context, &function, &words(&inputs)).f64(0).collect()
}

const OUTWARDS: DVec3 = DVec3::new(0.48, -0.6, 0.64);

/// At the centre, at 0.999 of the radius with normals inwards, outwards and across, and on the
/// sphere with the normal inwards: whatever is above the surface is the sphere, E = πL.
#[test]
fn within_a_sphere_that_shines_every_sample_is_the_irradiance() {
    let context = context();
    let across = OUTWARDS.any_orthonormal_vector();
    let places = [
        (0.0, across),
        (0.999, OUTWARDS),
        (0.999, -OUTWARDS),
        (0.999, across),
        (1.0, -OUTWARDS),
    ];
    let largest_error = |features: &[&'static str]| {
        let samples = sphere_samples(context, &places, features);
        worst(samples.into_iter().map(|e| (e / PI - 1.0).abs()))
    };
    survive(
        context,
        Measured {
            entry: "S6",
            case: "at the centre, at 0.999 of the radius and on a sphere that shines inwards",
            figure: "largest relative error of a sample of the irradiance",
            bound: 1e-5,
            textbook: "points of the sphere's area",
            naive: largest_error(&["LIGHT_SPHERES"]),
            ours: largest_error(&["LIGHT_SPHERES", "LIGHT_SOLID_ANGLE"]),
        },
    );
    // Outside on the sphere itself, none of it is above the surface.
    let outside = sphere_samples(
        context,
        &[(1.0, OUTWARDS)],
        &["LIGHT_SPHERES", "LIGHT_SOLID_ANGLE"],
    );
    assert!(outside.iter().all(|&e| e == 0.0));
}

#[test]
fn spots_without_a_penumbra_are_a_step() {
    let context = context();
    let function = Function {
        imports: "import package::light::spot::spot_falloff;",
        body: "out_f32(0u, spot_falloff(in_f32(0u), in_f32(1u), 1048576.0));
               out_f32(1u, (in_f32(0u) - in_f32(1u)) / (in_f32(2u) - in_f32(1u)));",
        inputs: 3,
        outputs: 2,
        features: &[],
    };
    let edge = f64::from(30_f64.to_radians().cos() as f32);
    let cosines = [-1.0, 0.0, edge - 1e-3, edge, edge + 1e-5, 0.95, 1.0];
    let inputs: Vec<f64> = cosines.iter().flat_map(|&c| [c, edge, edge]).collect();
    let answers = call(context, &function, &words(&inputs));
    let wrong = answers.f64(0).zip(cosines);
    let wrong = wrong.filter(|&(f, c)| f != f64::from(u8::from(c > edge)));
    survive(
        context,
        Measured {
            entry: "S7",
            case: "a spot whose cones are both of 30°, in seven directions",
            figure: "falloffs that are neither 1 inside nor 0 outside",
            bound: 0.0,
            textbook: "(cosθ − cos outer)/(cos inner − cos outer)",
            naive: failures(answers.f64(1)),
            ours: wrong.count() as f64,
        },
    );
}

#[test]
fn the_centre_of_a_disk_is_a_point() {
    let context = context();
    let function = Function {
        imports: "import package::light::disk::sample_disk_area;
            fn concentric(u: vec2f) -> vec2f {
                let p = 2.0 * u - vec2f(1.0);
                let wide = abs(p.x) > abs(p.y);
                let r = select(p.y, p.x, wide);
                let q = 0.785398163 * select(p.x / p.y, p.y / p.x, wide);
                let angle = select(1.57079633 - q, q, wide);
                return r * vec2f(cos(angle), sin(angle));
            }",
        body: "let ours = sample_disk_area(in_vec2f(0u)); let theirs = concentric(in_vec2f(0u));
               out_f32(0u, ours.x + ours.y);
               out_f32(1u, theirs.x + theirs.y);",
        inputs: 2,
        outputs: 2,
        features: &[],
    };
    let inputs: Vec<f64> = edge_points().iter().flat_map(|u| u.to_array()).collect();
    let answers = call(context, &function, &words(&inputs));
    survive(
        context,
        Measured {
            entry: "S7",
            case: "points of a disk, its centre (½, ½) among them",
            figure: "points that are not finite",
            bound: 0.0,
            textbook: "concentric map (Shirley & Chiu)",
            naive: failures(answers.f64(1)),
            ours: failures(answers.f64(0)),
        },
    );
}

#[test]
fn a_point_light_on_the_surface_gives_nothing() {
    let context = context();
    let mut scene = floor_pixel();
    scene.lights = vec![point_light(DVec3::new(0.3, 0.4, 0.0), 3.0)];
    let prepared = prepared_for(scene, Strategy::LightArea, LightSelection::Uniform);
    let function = Function {
        imports: "import package::core::frame::frame_from_normal;
            import package::core::pdf::ExpectedSamples;
            import package::light::sample::LightChoice;
            import package::light::light::sample_chosen_light;
            import package::scene::fetch::fetch_light;",
        body: "let light = fetch_light(0u);
               let x = light.a + bitcast<vec3f>(vec3u(item));
               let frame = frame_from_normal(vec3f(0.0, 0.0, 1.0));
               let s = sample_chosen_light(LightChoice(0u, ExpectedSamples(1.0)), x, frame, vec2f(0.5), 0u);
               out_f32(0u, s.radiance_over_pdf.x * s.wi.z);
               let d = light.a - x;
               out_f32(1u, light.radiance.x * normalize(d).z / dot(d, d));",
        inputs: 0,
        outputs: 2,
        features: &[],
    };
    let answers = call_in(context, &prepared, &function, &[], 16);
    survive(
        context,
        Measured {
            entry: "S7",
            case: "16 points less than 10⁻⁴⁰ from a point light",
            figure: "irradiances that are not finite",
            bound: 0.0,
            textbook: "I·cosθ/d²",
            naive: failures(answers.f64(1)),
            ours: failures(answers.f64(0)),
        },
    );
}

/// A square at this height, far above a floor, between it and a directional light.
fn roof(height: f64) -> Prepared {
    let mut scene = floor_pixel();
    let square = Geometry::Rectangle {
        corner: DVec3::new(-height, -height, height),
        u: DVec3::X * (2.0 * height),
        v: DVec3::Y * (2.0 * height),
    };
    scene.shapes.push(shape("roof", square));
    scene.lights = vec![Light::Directional(DirectionalLight {
        direction: -DVec3::Z,
        irradiance: DVec3::ONE,
    })];
    prepared_for(scene, Strategy::LightArea, LightSelection::Uniform)
}

#[test]
fn nothing_is_too_far_to_hide_a_directional_light() {
    let context = context();
    let function = Function {
        imports: "import package::core::frame::frame_from_normal;
            import package::core::pdf::ExpectedSamples;
            import package::core::ray::Ray;
            import package::light::sample::LightChoice;
            import package::light::light::sample_chosen_light;
            import package::scene::trace::any_hit;",
        body: "let x = in_vec3f(0u);
               let frame = frame_from_normal(vec3f(0.0, 0.0, 1.0));
               let s = sample_chosen_light(LightChoice(0u, ExpectedSamples(1.0)), x, frame, vec2f(0.5), 0u);
               out_bool(0u, any_hit(Ray(x, s.target_point - x), 1.0));
               out_bool(1u, any_hit(Ray(x, s.wi), in_f32(3u)));",
        inputs: 4,
        outputs: 2,
        features: &[],
    };
    let mut missed = [0.0; 2];
    for height in [1e2, 1e4, 1e6] {
        let prepared = roof(height);
        let normalization = &prepared.data.normalization;
        let above_floor = normalization.point(DVec3::Z * 0.1 * height);
        let inputs = [
            above_floor.to_array().to_vec(),
            vec![normalization.length(1000.0)],
        ]
        .concat();
        let answers = call_in(context, &prepared, &function, &words(&inputs), 1);
        for (word, missed) in missed.iter_mut().enumerate() {
            *missed += answers
                .u32(word)
                .map(|hit| 1.0 - f64::from(hit))
                .sum::<f64>();
        }
    }
    survive(
        context,
        Measured {
            entry: "S7",
            case: "a directional light above roofs at heights of 10², 10⁴ and 10⁶",
            figure: "roofs that let it through",
            bound: 0.0,
            textbook: "shadow rays of 1000 units",
            naive: missed[1],
            ours: missed[0],
        },
    );
}

/// A map of one radiance, as a map: every sample over its density is 4π times that, the first row's
/// among them and at the very pole. The textbook's texel is chosen by sinθ of its centre, and its
/// density is over sinθ of the sample.
#[test]
fn every_sample_of_a_constant_map_is_the_same() {
    let context = context();
    let (width, height) = (16, 8);
    let mut scene = floor_pixel();
    scene.environment = Some(Environment {
        radiance: EnvironmentRadiance::Map(EnvironmentMap {
            source: "constant".to_owned(),
            width,
            height,
            texels: vec![[2.0; 3]; (width * height) as usize],
            interpolation: Interpolation::Nearest,
        }),
        rotation: DMat3::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 0.7),
        scale: 1.0,
    });
    let prepared = prepared_for(scene, Strategy::LightArea, LightSelection::Uniform);
    let sum: f64 = (0..height)
        .map(|j| (PI * (f64::from(j) + 0.5) / f64::from(height)).sin())
        .sum();
    let body = format!(
        "var heights = vec4f(0.0, 5.9604645e-8, 0.5, 0.99999994);
         let v = heights[item % 4u];
         let s = sample_environment(ExpectedSamples(1.0), vec3f(0.0), vec2f(0.25, v), (item / 4u) << 25u);
         out_f32(0u, s.radiance_over_pdf.x);
         out_f32(1u, 2.0 / pdf_environment(s.wi).value);
         let row = f32((item / 4u) / {width}u);
         let chosen = sin(PI * (row + 0.5) / {height}.0) / ({width}.0 * {sum:?});
         let theta = PI * (row + v) / {height}.0;
         let pdf = chosen * {width}.0 * {height}.0 / (2.0 * PI * PI * sin(theta));
         out_f32(2u, 2.0 / pdf);"
    );
    let function = Function {
        imports: "import package::core::constants::PI;
            import package::core::pdf::ExpectedSamples;
            import package::light::environment::{pdf_environment, sample_environment};",
        body: &body,
        inputs: 0,
        outputs: 3,
        features: &[],
    };
    let answers = call_in(
        context,
        &prepared,
        &function,
        &[],
        (4 * width * height) as usize,
    );
    let off = |word| worst(answers.f64(word).map(|x| (x / (8.0 * PI) - 1.0).abs()));
    let naive = off(2);
    for (word, case) in [
        (0, "samples of a constant map, at its pole among them"),
        (
            1,
            "densities of directions from a constant map, from its pole among them",
        ),
    ] {
        survive(
            context,
            Measured {
                entry: "S8",
                case,
                figure: "relative error of radiance over density",
                bound: 1e-5,
                textbook: "density P·W·H/(2π² sinθ)",
                naive,
                ours: off(word),
            },
        );
    }
    // The pole itself is met.
    let at_pole = draw(
        context,
        &Function {
            imports: "import package::light::environment::sample_environment_cell;",
            body: "out_vec3f(0u, sample_environment_cell(vec2u(item, 0u), vec2u(16u, 8u), vec2f(0.25, 0.0)));",
            inputs: 0,
            outputs: 3,
            features: &[],
        },
        16,
    );
    assert!(at_pole.vec3(0).all(|d| d == DVec3::Y));
}
