//! `shaders/bsdf/compensation.wesl`.

use crate::support::context;
use crate::support::rounding::U;
use crate::support::shader::{Function, call, words};
use direkt::low_level::reference::bsdf::compensation::{
    compensation_albedo, compensation_fresnel, eval_compensation, ggx_albedo_deficit,
    ggx_average_deficit,
};
use direkt::low_level::reference::exact::cubature::{Tolerance, integrate};
use direkt::low_level::reference::exact::ggx::{directional_albedo, rough_average_albedo};
use direkt::scene::material::{Fresnel, SpecularLobe};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, TAU};

const ALPHAS: [f64; 10] = [0.01, 0.02, 0.05, 0.08, 0.15, 0.3, 0.5, 0.7, 0.85, 1.0];
const COSINES: [f64; 8] = [0.005, 0.02, 0.07, 0.15, 0.3, 0.5, 0.8, 1.0];

fn white(alpha: f64) -> SpecularLobe {
    let fresnel = Fresnel::Schlick {
        f0: DVec3::ONE,
        f90: 1.0,
    };
    SpecularLobe {
        compensated: true,
        ..SpecularLobe::new(fresnel, alpha)
    }
}

#[test]
fn the_fits_are_near_the_quadrature() {
    for alpha in ALPHAS {
        for cos in COSINES {
            let exact = 1.0 - directional_albedo(alpha, cos).total();
            let off = ggx_albedo_deficit(cos, alpha) - exact;
            assert!(off.abs() < 0.0035, "{alpha}, {cos}: {off}");
        }
    }
    let exact = 1.0 - rough_average_albedo();
    assert!((ggx_average_deficit(1.0) / exact - 1.0).abs() < 0.01);
}

/// The furnace: the GGX lobe's exact albedo and the added lobe's are 1 within a hundredth. Without
/// it up to 69 % are missing.
#[test]
fn a_white_metal_keeps_all_light() {
    let mut least = 1.0_f64;
    for alpha in ALPHAS {
        let lobe = white(alpha);
        for cos_o in COSINES {
            let added = |theta: f64, _: f64| {
                let (sin, cos) = theta.sin_cos();
                eval_compensation(&lobe, cos, cos_o) * (TAU * cos * sin)
            };
            // The lobe's own peak lies at a cosine of about α.
            let places = [0.0, (0.5 * alpha).acos(), FRAC_PI_2];
            let tolerance = Tolerance {
                absolute: 1e-7,
                relative: 0.0,
            };
            let added = integrate(added, &places, &[0.0, 1.0], tolerance).value.x;
            let single = directional_albedo(alpha, cos_o).total();
            least = least.min(single);
            let all = single + added;
            assert!((all - 1.0).abs() < 0.01, "{alpha}, {cos_o}: {all}");
            assert!((added - compensation_albedo(&lobe, cos_o).x).abs() < 0.0065);
        }
    }
    assert!(least < 0.32, "{least}");
}

#[test]
fn a_lobe_that_is_not_compensated_adds_nothing() {
    let narrow = white(0.0078);
    let mut coat = white(0.5);
    coat.fresnel = Fresnel::Dielectric { ior: 1.5 };
    let mut without = white(0.5);
    without.compensated = false;
    for lobe in [narrow, coat, without] {
        assert_eq!(compensation_fresnel(&lobe), DVec3::ZERO);
    }
    assert_eq!(eval_compensation(&narrow, 0.1, 0.2), DVec3::ZERO);
}

/// The terms of a deficit add up to 280 at most, and take 12 roundings; the average has 16, as its
/// denominator.
#[test]
fn the_fits_are_the_twins() {
    let function = Function {
        imports: "import package::bsdf::compensation::{
                      compensation_albedo, compensation_fresnel, eval_compensation, ggx_albedo_deficit, ggx_average_deficit};
                  import package::scene::fetch::{COMPENSATED_BIT, Material};",
        body: "let alpha = in_f32(0u);
               let m = Material(vec3f(0.0), vec3f(1.0, 0.5, 0.25), alpha, 1.0, vec3f(0.0), COMPENSATED_BIT, vec3f(0.0), 1.0, vec3f(0.0));
               out_f32(0u, ggx_albedo_deficit(in_f32(1u), alpha));
               out_f32(1u, ggx_average_deficit(alpha));
               out_vec3f(2u, compensation_fresnel(m));
               out_vec3f(5u, compensation_albedo(m, in_f32(1u)));
               out_vec3f(8u, eval_compensation(m, in_f32(1u), in_f32(2u)));
               out_vec3f(11u, eval_compensation(m, in_f32(2u), in_f32(1u)));",
        inputs: 3,
        outputs: 14,
        features: &["ENERGY_COMPENSATION", "GLOSSY"],
    };
    let triples = ALPHAS.iter().flat_map(|&alpha| {
        COSINES
            .iter()
            .flat_map(move |&a| COSINES.map(move |b| [alpha, a, b]))
    });
    let inputs: Vec<f64> = triples.flatten().map(|x| f64::from(x as f32)).collect();
    let answers = call(context(), &function, &words(&inputs));
    for (i, input) in inputs.chunks(3).enumerate() {
        let [alpha, a, b] = [input[0], input[1], input[2]];
        let fresnel = Fresnel::Schlick {
            f0: DVec3::new(1.0, 0.5, 0.25),
            f90: 1.0,
        };
        let lobe = SpecularLobe {
            compensated: true,
            ..SpecularLobe::new(fresnel, alpha)
        };
        let at = |word: usize| answers.f64(word).nth(i).unwrap();
        let at3 = |word: usize| answers.vec3(word).nth(i).unwrap();
        let deficit = 12.0 * 280.0 * 0.25 * U;
        let expected = ggx_albedo_deficit(a, alpha);
        assert!((at(0) - expected).abs() <= deficit, "{input:?}: {}", at(0));
        let average = ggx_average_deficit(alpha);
        assert!(
            (at(1) / average - 1.0).abs() <= 16.0 * U,
            "{input:?}: {}",
            at(1)
        );
        let f = compensation_fresnel(&lobe);
        assert!((at3(2) - f).abs().cmple(64.0 * U * f).all(), "{input:?}");
        let albedo = compensation_albedo(&lobe, a);
        assert!(
            (at3(5) - albedo).abs().max_element() <= 2.0 * deficit,
            "{input:?}"
        );
        let value = eval_compensation(&lobe, a, b);
        let both = expected + ggx_albedo_deficit(b, alpha);
        let bound = deficit * both / (std::f64::consts::PI * average) + 64.0 * U * value.x;
        assert!(
            (at3(8) - value).abs().max_element() <= bound,
            "{input:?}: {}",
            at3(8)
        );
        // Reciprocal to the last bit but one.
        assert!(
            (at3(8) - at3(11)).abs().cmple(4.0 * U * at3(8)).all(),
            "{input:?}"
        );
    }
}
