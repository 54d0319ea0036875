//! `shaders/bsdf/fresnel.wesl`.

use crate::support::context;
use crate::support::hard_cases::{Measured, survive};
use crate::support::random::Random;
use crate::support::rounding::U;
use crate::support::shader::{Function, call, words};
use direkt::low_level::reference::bsdf::fresnel::{
    fresnel_conductor, fresnel_dielectric, fresnel_schlick,
};
use direkt::low_level::reference::exact::fresnel::{brewster_angle, critical_angle};
use direkt::scene::metals::Metal;
use glam::DVec3;

const DIELECTRIC: Function<'_> = Function {
    imports: "import package::bsdf::fresnel::fresnel_dielectric;",
    body: "let i = fresnel_dielectric(in_f32(0u), in_f32(1u));
           out_f32(0u, i.reflectance); out_f32(1u, i.eta_cos_t);",
    inputs: 2,
    outputs: 2,
    features: &[],
};

fn f32_of(x: f64) -> f64 {
    f64::from(x as f32)
}

/// Both forms as functions of the same f32s. Rounding the index moves r_s and r_p by what it does
/// to η² − 1, and by 24 roundings of their own; near the critical angle it moves c² + η² − 1 by 4
/// roundings, and R by the root of that.
#[test]
fn dielectrics_reflect_as_the_twin() {
    let cosines = [
        0.0, 1e-7, 1e-3, 0.05, 0.3, 0.5, 0.7, 0.74, 0.75, 0.8, 0.99, 1.0,
    ];
    let etas = [
        1.0,
        1.000_001,
        1.001,
        1.33,
        1.5,
        2.4,
        100.0,
        1.0 / 1.000_001,
        0.75,
        1.0 / 1.5,
        0.1,
    ];
    let pairs = etas
        .iter()
        .flat_map(|&eta| cosines.map(|cos| [f32_of(cos), f32_of(eta)]));
    let inputs: Vec<f64> = pairs.flatten().collect();
    let answers = call(context(), &DIELECTRIC, &words(&inputs));
    for (input, (r, t)) in inputs.chunks(2).zip(answers.f64(0).zip(answers.f64(1))) {
        let expected = fresnel_dielectric(input[0], input[1]);
        let squared = expected.eta_cos_t * expected.eta_cos_t;
        let sensitivity = (16.0 * U / squared.max(16.0 * U)).sqrt().min(1.0);
        let bound = (48.0 * U + sensitivity) * expected.reflectance + 1e-30;
        assert!(
            (r - expected.reflectance).abs() <= bound && (0.0..=1.0).contains(&r),
            "{input:?}: {r}, not {}",
            expected.reflectance
        );
        let off = (t * t - squared).abs();
        assert!(off <= 32.0 * U * (1.0 + squared), "{input:?}: {t}");
    }
}

/// HARD CASES B4: equal indices reflect nothing and let pass straight; all but equal ones reflect
/// 2.5e-13·4 at 60°, of which the textbook's difference of cosines leaves nothing in f32. Values of
/// Fresnel's equations for glass beside it.
#[test]
fn equal_indices_reflect_nothing() {
    let cosine = |degrees: f64| degrees.to_radians().cos();
    let critical = critical_angle(1.0 / 1.5).unwrap().cos();
    let cases = [
        (cosine(60.0), 1.0, 0.0, 0.0),
        (0.0, 1.0, 0.0, 0.0),
        (cosine(60.0), 1.000_001, 0.0, 1e-9),
        (1.0, 1.5, 0.04, 1e-7),
        (cosine(60.0), 1.5, 0.089_186_712_802_212_8, 1e-6),
        (cosine(85.0), 1.5, 0.612_799_645_264_827, 1e-6),
        (
            brewster_angle(1.5).cos(),
            1.5,
            0.073_964_497_041_420_1,
            1e-6,
        ),
        (critical - 1e-4, 1.0 / 1.5, 1.0, 0.0),
        (0.1, 1.0 / 1.5, 1.0, 0.0),
    ];
    let inputs: Vec<f64> = cases.iter().flat_map(|c| [c.0, c.1]).collect();
    let answers = call(context(), &DIELECTRIC, &words(&inputs));
    for ((cos, eta, expected, bound), r) in cases.iter().zip(answers.f64(0)) {
        assert!(
            (r - expected).abs() <= *bound,
            "{eta} at {cos}: {r}, not {expected}"
        );
    }
    let passes = answers.f64(1).next().unwrap();
    assert!((passes - 0.5).abs() <= 2.0 * U, "{passes}");
    let nearly = answers.f64(0).nth(2).unwrap();
    let exact = fresnel_dielectric(f32_of(cosine(60.0)), f32_of(1.000_001)).reflectance;
    assert!((nearly / exact - 1.0).abs() < 1e-5, "{nearly}, not {exact}");
}

/// HARD CASES B4: what all but equal indices reflect, to three digits.
#[test]
fn all_but_equal_indices_reflect_what_they_should() {
    let context = context();
    let function = Function {
        imports: "import package::bsdf::fresnel::fresnel_dielectric;
            fn textbook(cos_i: f32, eta: f32) -> f32 {
                let sin_t = sqrt(1.0 - cos_i * cos_i) / eta;
                let cos_t = sqrt(1.0 - sin_t * sin_t);
                let s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
                let p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
                return 0.5 * (s * s + p * p);
            }",
        body: "out_f32(0u, fresnel_dielectric(in_f32(0u), in_f32(1u)).reflectance);
               out_f32(1u, textbook(in_f32(0u), in_f32(1u)));",
        inputs: 2,
        outputs: 2,
        features: &[],
    };
    let cosines: Vec<f64> = (1..=9).map(|i| f32_of(0.1 * f64::from(i))).collect();
    let eta = f32_of(1.000_001);
    let inputs: Vec<f64> = cosines.iter().flat_map(|cos| [*cos, eta]).collect();
    let answers = call(context, &function, &words(&inputs));
    let worst = |output: usize| {
        let found = answers.f64(output).zip(&cosines);
        let off = found.map(|(r, cos)| (r / fresnel_dielectric(*cos, eta).reflectance - 1.0).abs());
        off.fold(0.0, f64::max)
    };
    survive(
        context,
        Measured {
            entry: "B4",
            case: "the boundary of media whose indices differ by 1e-6",
            figure: "relative error of the reflectance",
            bound: 1e-3,
            textbook: "(cosθ_i − η cosθ_t)/(cosθ_i + η cosθ_t), squared",
            naive: worst(1),
            ours: worst(0),
        },
    );
}

/// The formula in real numbers against the one in complex numbers; the loss 1 − R is known to 64
/// roundings.
#[test]
fn conductors_reflect_as_the_twin() {
    let function = Function {
        imports: "import package::bsdf::fresnel::{fresnel_conductor, fresnel_schlick};",
        body: "out_vec3f(0u, fresnel_conductor(in_f32(0u), in_vec3f(1u), in_vec3f(4u)));
               out_vec3f(3u, fresnel_schlick(in_vec3f(1u), in_f32(4u), in_f32(0u)));",
        inputs: 7,
        outputs: 6,
        features: &[],
    };
    let mut random = Random::new(11);
    let mut cases: Vec<(f64, DVec3, DVec3)> = Vec::new();
    for cos in [0.0, 1e-6, 0.01, 0.1, 0.5, 0.9, 1.0] {
        for metal in [Metal::Copper, Metal::Gold, Metal::Silver] {
            let (eta, k) = metal.index();
            cases.push((cos, eta, k));
        }
        for _ in 0..32 {
            let mut index = || DVec3::from_array([(); 3].map(|()| random.magnitude(0.01, 30.0)));
            cases.push((cos, index(), index()));
        }
        cases.push((cos, DVec3::splat(1.5), DVec3::ZERO));
    }
    let inputs: Vec<f64> = cases
        .iter()
        .flat_map(|(cos, eta, k)| [vec![*cos], eta.to_array().into(), k.to_array().into()])
        .flatten()
        .collect();
    let answers = call(context(), &function, &words(&inputs));
    let found = answers.vec3(0).zip(answers.vec3(3));
    for ((cos, eta, k), (r, schlick)) in cases.iter().zip(found) {
        let rounded = |v: DVec3| DVec3::from_array(v.to_array().map(f32_of));
        let (cos, eta, k) = (f32_of(*cos), rounded(*eta), rounded(*k));
        let expected = fresnel_conductor(cos, eta, k);
        assert!(
            (r - expected).abs().max_element() <= 64.0 * U && r.max_element() <= 1.0 + 4.0 * U,
            "{cos} {eta} {k}: {r}, not {expected}"
        );
        let expected = fresnel_schlick(eta, k.x, cos);
        let bound = 16.0 * U * (eta.abs() + DVec3::splat(k.x));
        assert!(
            ((schlick - expected).abs().cmple(bound)).all(),
            "{schlick}, not {expected}"
        );
    }
}
