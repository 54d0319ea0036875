//! `shaders/light/rectangle.wesl`.

mod solid_angle;

use crate::support::random::Random;
use crate::support::rounding::{U, assert_integrates_to_one, assert_near};
use crate::support::shader::{Function, call, draw, words};
use crate::support::{context, edge_points, histogram, statistics};
use direkt::low_level::reference::BrokenTwin;
use direkt::low_level::reference::light::rectangle::{pdf_rectangle_area, sample_rectangle_area};
use glam::DVec2;

/// The map is the identity: bit for bit the twin's, and its own inverse.
#[test]
fn rectangle_area_samples_are_the_twins() {
    let context = context();
    let points = edge_points();
    let inputs: Vec<f64> = points.iter().flat_map(|u| u.to_array()).collect();
    let function = Function {
        imports: "import package::light::rectangle::sample_rectangle_area;",
        body: "out_vec2f(0u, sample_rectangle_area(in_vec2f(0u)));",
        inputs: 2,
        outputs: 2,
        features: &[],
    };
    let answers = call(context, &function, &words(&inputs));
    for (u, p) in points.iter().zip(answers.vec2(0)) {
        assert_eq!(p, sample_rectangle_area(*u), "{}", context.adapter.name);
        assert_eq!(p, *u);
    }
}

#[test]
fn rectangle_area_density_integrates_to_one() {
    let context = context();
    let function = Function {
        imports: "import package::light::rectangle::pdf_rectangle_area;",
        body: "out_f32(0u, pdf_rectangle_area(in_f32(0u)).value);",
        inputs: 1,
        outputs: 1,
        features: &[],
    };
    let mut random = Random::new(2);
    let edges: Vec<_> = (0..64).map(|_| random.edges()).collect();
    let areas: Vec<f64> = edges.iter().map(|(u, v)| u.cross(*v).length()).collect();
    let answers = call(context, &function, &words(&areas));
    for (((u, v), area), pdf) in edges.iter().zip(&areas).zip(answers.f64(0)) {
        // The area is rounded to f32 and divided by: U + 5 U.
        let expected = pdf_rectangle_area(*area).0;
        assert_near(pdf, expected, 6.0 * U * expected, format!("area {area}"));
        let element = |_, _| u.cross(*v).length();
        assert_integrates_to_one(pdf, element, 7.0 * U, format!("edges {u} {v}"));
    }
}

#[test]
fn rectangle_area_samples_match_pdf() {
    let context = context();
    let function = Function {
        imports: "import package::light::rectangle::sample_rectangle_area;
                  import package::core::rng::{pcg4d, to_unit_2d};",
        body: "out_vec2f(0u, sample_rectangle_area(to_unit_2d(pcg4d(vec4u(item, 4u, 5u, 6u)).xy)));",
        inputs: 0,
        outputs: 2,
        features: &[],
    };
    let samples: Vec<DVec2> = draw(context, &function, 1 << 20).vec2(0).collect();
    let pdf = |_: DVec2| pdf_rectangle_area(1.0).0;
    let test =
        |pdf: &dyn Fn(DVec2) -> f64| histogram::p_value(&samples, DVec2::ZERO, DVec2::ONE, pdf);
    let what = format!("sample_rectangle_area, seed 6, {}", context.adapter.name);
    statistics::accept(test(&pdf), &what);
    statistics::reject_broken(&what, |twin| match twin {
        BrokenTwin::PdfScaled => Some(test(&|p| 1.02 * pdf(p))),
        // Uniform per solid angle from a point one edge's length above the centre: ∝ cosθ/d²,
        // normalised by the square's solid angle 4·asin(1/5).
        BrokenTwin::WrongMeasure => Some(test(&|p| {
            let squared = 1.0 + (p - DVec2::splat(0.5)).length_squared();
            squared.powf(-1.5) / (4.0 * 0.2_f64.asin())
        })),
        // The others are about surfaces that reflect, and about choosing among lights and
        // strategies.
        BrokenTwin::SwappedSinCos
        | BrokenTwin::LightLeftOut
        | BrokenTwin::MisWeights
        | BrokenTwin::RaysForgotten
        | BrokenTwin::OpaqueShadows
        | BrokenTwin::ExtraCosine => None,
    });
}
