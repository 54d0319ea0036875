//! `shaders/bsdf/lambert.wesl`.

use crate::support::shader::{Function, call, draw, words};
use crate::support::{context, edge_points, histogram, statistics};
use direkt::low_level::reference::BrokenTwin;
use direkt::low_level::reference::broken::BROKEN_TWINS;
use direkt::low_level::reference::bsdf::lambert::{eval_lambert, pdf_lambert, sample_lambert};
use glam::DVec3;

/// Near the horizon z = √(1 − r²) amplifies the rounding of r: there z² is compared.
#[test]
fn lambert_samples_are_the_twins() {
    let context = context();
    let points = edge_points();
    let inputs: Vec<f64> = points.iter().flat_map(|u| u.to_array()).collect();
    let function = Function {
        imports: "import package::bsdf::lambert::sample_lambert;",
        body: "out_vec3f(0u, sample_lambert(in_vec2f(0u)));",
        inputs: 2,
        outputs: 3,
        features: &[],
    };
    let answers = call(context, &function, &words(&inputs));
    for (u, w) in points.iter().zip(answers.vec3(0)) {
        let expected = sample_lambert(*u);
        let off = (w - expected).truncate().length();
        let off_z = (w.z * w.z - expected.z * expected.z).abs();
        assert!(
            off < 4e-7 && off_z < 2e-6 && w.z >= 0.0,
            "{}: {u} goes to {w}, not {expected}",
            context.adapter.name
        );
    }
}

#[test]
fn lambert_densities_and_values_are_the_twins() {
    let context = context();
    let cosines = [-1.0, -1e-7, 0.0, 1e-7, 0.25, 0.5, 1.0];
    let function = Function {
        imports: "import package::bsdf::lambert::{eval_lambert, pdf_lambert};",
        body: "out_f32(0u, pdf_lambert(in_f32(0u)).value);
               out_vec3f(1u, eval_lambert(vec3f(0.0, 0.5, 1.0)));",
        inputs: 1,
        outputs: 4,
        features: &[],
    };
    let answers = call(context, &function, &words(&cosines));
    let value = eval_lambert(DVec3::new(0.0, 0.5, 1.0));
    for ((cosine, pdf), f) in cosines.iter().zip(answers.f64(0)).zip(answers.vec3(1)) {
        let expected = pdf_lambert(f64::from(*cosine as f32)).0;
        assert!(
            (pdf - expected).abs() <= 2e-7 * expected,
            "cosine {cosine}: {pdf}"
        );
        assert!((f - value).length() < 2e-7);
    }
}

#[test]
fn lambert_samples_match_pdf() {
    let context = context();
    let function = Function {
        imports: "import package::bsdf::lambert::sample_lambert;
                  import package::core::rng::{pcg4d, to_unit_2d};",
        body: "out_vec3f(0u, sample_lambert(to_unit_2d(pcg4d(vec4u(item, 4u, 5u, 6u)).xy)));",
        inputs: 0,
        outputs: 3,
        features: &[],
    };
    let answers = draw(context, &function, 1 << 20);
    let samples: Vec<DVec3> = answers.vec3(0).collect();
    let pdf = |w: DVec3| pdf_lambert(w.z).0;
    let what = format!("sample_lambert, seed 6, {}", context.adapter.name);
    let honest = histogram::directions_p_value(&samples, pdf);
    statistics::accept(honest, &what);
    for row in BROKEN_TWINS {
        let broken = match row.twin {
            BrokenTwin::PdfScaled => histogram::directions_p_value(&samples, |w| 1.02 * pdf(w)),
            // Density per unit area of the disk under the hemisphere.
            BrokenTwin::WrongMeasure => {
                histogram::directions_p_value(&samples, |w| pdf(w) / w.z.max(1e-9))
            }
            BrokenTwin::ExtraCosine => {
                histogram::directions_p_value(&samples, |w| 1.5 * pdf(w) * w.z)
            }
            // Swapping sine and cosine maps the cosine distribution onto itself, and the others are
            // about choosing among lights and strategies.
            BrokenTwin::SwappedSinCos
            | BrokenTwin::LightLeftOut
            | BrokenTwin::MisWeights
            | BrokenTwin::RaysForgotten
            | BrokenTwin::OpaqueShadows => {
                continue;
            }
        };
        statistics::reject(broken, &format!("{what}, {}", row.name));
    }
}
