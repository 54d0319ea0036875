//! `shaders/light/triangle.wesl`.

mod solid_angle;

use crate::support::random::Random;
use crate::support::rounding::{U, assert_integrates_to_one, assert_near};
use crate::support::shader::{Function, call, draw, words};
use crate::support::{context, edge_points, histogram, statistics};
use direkt::low_level::reference::BrokenTwin;
use direkt::low_level::reference::light::triangle::{
    invert_triangle_area as invert, pdf_triangle_area, sample_triangle_area,
};
use glam::DVec2;

/// Halving is exact; the difference of two numbers below 1 is rounded once.
#[test]
fn triangle_area_samples_are_the_twins() {
    let context = context();
    let points = edge_points();
    let inputs: Vec<f64> = points.iter().flat_map(|u| u.to_array()).collect();
    let function = Function {
        imports: "import package::light::triangle::{invert_triangle_area, sample_triangle_area};",
        body: "let st = sample_triangle_area(in_vec2f(0u));
               out_vec2f(0u, st);
               out_vec2f(2u, invert_triangle_area(st));",
        inputs: 2,
        outputs: 4,
        features: &[],
    };
    let answers = call(context, &function, &words(&inputs));
    for ((u, p), inverse) in points.iter().zip(answers.vec2(0)).zip(answers.vec2(2)) {
        let expected = sample_triangle_area(*u);
        assert!(
            (p - expected).abs().max_element() <= U,
            "{}: {u} goes to {p}, not {expected}",
            context.adapter.name
        );
        let inside = p.min_element() >= 0.0 && p.x + p.y <= 1.0;
        assert!(inside, "{u} leaves the triangle");
        for back in [invert(p), inverse] {
            assert!(
                (back - *u).abs().max_element() <= U,
                "{u} comes back as {back}"
            );
        }
    }
}

#[test]
fn triangle_area_density_integrates_to_one() {
    let context = context();
    let function = Function {
        imports: "import package::light::triangle::pdf_triangle_area;",
        body: "out_f32(0u, pdf_triangle_area(in_f32(0u)).value);",
        inputs: 1,
        outputs: 1,
        features: &[],
    };
    let mut random = Random::new(3);
    let edges: Vec<_> = (0..64).map(|_| random.edges()).collect();
    let areas: Vec<f64> = edges
        .iter()
        .map(|(u, v)| 0.5 * u.cross(*v).length())
        .collect();
    let answers = call(context, &function, &words(&areas));
    for (((u, v), area), pdf) in edges.iter().zip(&areas).zip(answers.f64(0)) {
        // The area is rounded to f32 and divided by: U + 5 U.
        let expected = pdf_triangle_area(*area).0;
        assert_near(pdf, expected, 6.0 * U * expected, format!("area {area}"));
        // The square's point (x, y) goes to s = x, t = (1 − x)·y.
        let element = |x: f64, _| (1.0 - x) * u.cross(*v).length();
        assert_integrates_to_one(pdf, element, 7.0 * U, format!("edges {u} {v}"));
    }
}

#[test]
fn triangle_area_samples_match_pdf() {
    let context = context();
    let function = Function {
        imports: "import package::light::triangle::sample_triangle_area;
                  import package::core::rng::{pcg4d, to_unit_2d};",
        body: "out_vec2f(0u, sample_triangle_area(to_unit_2d(pcg4d(vec4u(item, 7u, 8u, 9u)).xy)));",
        inputs: 0,
        outputs: 2,
        features: &[],
    };
    let samples: Vec<DVec2> = draw(context, &function, 1 << 20).vec2(0).collect();
    let inside = |p: DVec2, density: f64| if p.x + p.y <= 1.0 { density } else { 0.0 };
    let pdf = |p: DVec2| inside(p, pdf_triangle_area(0.5).0);
    let test =
        |pdf: &dyn Fn(DVec2) -> f64| histogram::p_value(&samples, DVec2::ZERO, DVec2::ONE, pdf);
    let what = format!("sample_triangle_area, seed 9, {}", context.adapter.name);
    statistics::accept(test(&pdf), &what);
    statistics::reject_broken(&what, |twin| match twin {
        BrokenTwin::PdfScaled => Some(test(&|p| 1.02 * pdf(p))),
        // Uniform in s and in t/(1 − s): the density per area is 1/(1 − s).
        BrokenTwin::WrongMeasure => Some(test(&|p| inside(p, 1.0 / (1.0 - p.x).max(1e-9)))),
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
