//! `shaders/light/disk.wesl`.

use crate::support::shader::{Function, call, draw, words};
use crate::support::{context, edge_points, histogram, statistics};
use direkt::reference::BrokenTwin;
use direkt::reference::light::disk::{pdf_disk_area, sample_disk_area};
use glam::DVec2;
use std::f64::consts::PI;

const SAMPLE: Function<'_> = Function {
    imports: "import package::light::disk::sample_disk_area;",
    body: "out_vec2f(0u, sample_disk_area(in_vec2f(0u)));",
    inputs: 2,
    outputs: 2,
    features: &[],
};

/// A point of the unit square goes where the twin puts it: rounding moves it by a few units of 2⁻²⁴.
#[test]
fn disk_area_samples_are_the_twins() {
    let context = context();
    let points = edge_points();
    let inputs: Vec<f64> = points.iter().flat_map(|u| u.to_array()).collect();
    let answers = call(&context, &SAMPLE, &words(&inputs));
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

#[test]
fn disk_area_samples_match_pdf() {
    let context = context();
    let answers = draw(
        &context,
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
    for row in direkt::reference::broken::BROKEN_TWINS {
        let broken = match row.twin {
            BrokenTwin::PdfScaled => test(&|p| 1.02 * pdf(p)),
            // Uniform in radius and angle: the density per area is 1/(2πr).
            BrokenTwin::WrongMeasure => test(&|p| 0.5 * pdf(p) / p.length().max(1e-9)),
            _ => continue,
        };
        statistics::reject(broken, &format!("{what}, {}", row.name));
    }
}
