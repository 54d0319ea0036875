//! `shaders/light/disk.wesl`.

use crate::support::random::Random;
use crate::support::rounding::{U, assert_integrates_to_one, assert_near};
use crate::support::shader::{Function, call, draw, words};
use crate::support::{context, edge_points, histogram, statistics};
use direkt::low_level::reference::BrokenTwin;
use direkt::low_level::reference::light::disk::{
    invert_disk_area as invert, pdf_disk_area, sample_disk_area,
};
use glam::DVec2;
use std::f64::consts::{PI, TAU};

const SAMPLE: Function<'_> = Function {
    imports: "import package::light::disk::sample_disk_area;",
    body: "out_vec2f(0u, sample_disk_area(in_vec2f(0u)));",
    inputs: 2,
    outputs: 2,
    features: &[],
};

/// A point of the unit square goes where the twin puts it: rounding moves it by a few units of
/// 2⁻²⁴.
#[test]
fn disk_area_samples_are_the_twins() {
    let context = context();
    let points = edge_points();
    let inputs: Vec<f64> = points.iter().flat_map(|u| u.to_array()).collect();
    let answers = call(context, &SAMPLE, &words(&inputs));
    for (u, p) in points.iter().zip(answers.vec2(0)) {
        let expected = sample_disk_area(*u);
        let off = (p - expected).length();
        assert!(
            off < 4e-7,
            "{}: {u} goes to {p}, not {expected}",
            context.adapter.name
        );
        assert!(p.length() <= 1.0 + 1e-7, "{u} leaves the disk");
    }
}

/// The map stretches by 4/π at most, times ½ of the square's scale, and the samples are off by
/// 4e-7; where two wedges meet, the inverse is continuous.
#[test]
fn disk_area_samples_can_be_inverted() {
    let context = context();
    let points = edge_points();
    let inputs: Vec<f64> = points.iter().flat_map(|u| u.to_array()).collect();
    let answers = call(context, &SAMPLE, &words(&inputs));
    for (u, p) in points.iter().zip(answers.vec2(0)) {
        let back = invert(p);
        assert!((back - *u).length() < 8e-7, "{u} comes back as {back}");
    }
    let inverse = Function {
        imports: "import package::light::disk::invert_disk_area;",
        body: "out_vec2f(0u, invert_disk_area(in_vec2f(0u)));",
        ..SAMPLE
    };
    let on_disk: Vec<f64> = answers.vec2(0).flat_map(|p| p.to_array()).collect();
    let inverted = call(context, &inverse, &words(&on_disk));
    for (u, back) in points.iter().zip(inverted.vec2(0)) {
        assert!(
            (back - *u).length() < 1.2e-6,
            "{u} comes back as {back} on the GPU"
        );
    }
}

#[test]
fn disk_area_density_integrates_to_one() {
    let context = context();
    let function = Function {
        imports: "import package::light::disk::pdf_disk_area;",
        body: "out_f32(0u, pdf_disk_area(in_f32(0u)).value);",
        inputs: 1,
        outputs: 1,
        features: &[],
    };
    let mut random = Random::new(1);
    let axes: Vec<_> = (0..64).map(|_| random.edges()).collect();
    let areas: Vec<f64> = axes
        .iter()
        .map(|(u, v)| PI * u.cross(*v).length())
        .collect();
    let answers = call(context, &function, &words(&areas));
    for (((u, v), area), pdf) in axes.iter().zip(&areas).zip(answers.f64(0)) {
        // The area is rounded to f32 and divided by: U + 5 U.
        let expected = pdf_disk_area(*area).0;
        assert_near(pdf, expected, 6.0 * U * expected, format!("area {area}"));
        let element = |r: f64, _| TAU * r * u.cross(*v).length();
        assert_integrates_to_one(pdf, element, 7.0 * U, format!("axes {u} {v}"));
    }
}

#[test]
fn disk_area_samples_match_pdf() {
    let context = context();
    let answers = draw(
        context,
        &Function {
            imports: "import package::light::disk::sample_disk_area;
                      import package::core::rng::{pcg4d, to_unit_2d};",
            body: "out_vec2f(0u, sample_disk_area(to_unit_2d(pcg4d(vec4u(item, 1u, 2u, 3u)).xy)));",
            inputs: 0,
            outputs: 2,
            features: &[],
        },
        1 << 20,
    );
    let samples: Vec<DVec2> = answers.vec2(0).collect();
    let pdf = |p: DVec2| {
        if p.length_squared() <= 1.0 {
            pdf_disk_area(PI).0
        } else {
            0.0
        }
    };
    let test = |pdf: &dyn Fn(DVec2) -> f64| {
        histogram::p_value(&samples, DVec2::splat(-1.0), DVec2::splat(1.0), pdf)
    };
    let what = format!("sample_disk_area, seed 3, {}", context.adapter.name);
    statistics::accept(test(&pdf), &what);
    statistics::reject_broken(&what, |twin| match twin {
        BrokenTwin::PdfScaled => Some(test(&|p| 1.02 * pdf(p))),
        // Uniform in radius and angle: the density per area is 1/(2πr).
        BrokenTwin::WrongMeasure => Some(test(&|p| 0.5 * pdf(p) / p.length().max(1e-9))),
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
