//! `shaders/bsdf/specular.wesl`.

use crate::support::random::direction;
use crate::support::rounding::U;
use crate::support::shader::{Answers, Function, call, draw, words};
use crate::support::{context, statistics};
use direkt::low_level::gpu::layout::{
    FRESNEL_CONSTANT, FRESNEL_DIELECTRIC, FRESNEL_SCHLICK, THIN_BIT,
};
use direkt::low_level::reference::bsdf::specular::{Way, sample_specular};
use direkt::low_level::stats::moments::Moments;
use direkt::low_level::stats::z_test::z_test;
use direkt::scene::Bsdf;
use direkt::scene::material::{BsdfParameters, DielectricLayer, Fresnel};
use glam::DVec3;

const FEATURES: &[&str] = &["SPECULAR", "REFRACTION", "EXACT_DIELECTRIC", "GLOSSY"];
const IMPORTS: &str = "import package::bsdf::specular::sample_specular;
    import package::core::rng::{pcg4d, to_unit};
    import package::scene::fetch::Material;";

fn rgb(x: f64) -> DVec3 {
    DVec3::new(x, 0.5 * x, 0.25 * x)
}

fn materials() -> Vec<BsdfParameters> {
    let glass = |ior: f64, thin: bool| Bsdf::Dielectric {
        ior,
        transmittance: rgb(1.0),
        thin,
    };
    let coat = |alpha: f64| Bsdf::Plastic {
        reflectance: rgb(0.75),
        ior: 1.5,
        alpha,
    };
    let layered = Bsdf::MetallicRoughness {
        base_color: rgb(0.5),
        metallic: 0.0,
        roughness: 0.5,
        layer: DielectricLayer {
            transmission: 0.5,
            thin: false,
            ..DielectricLayer::default()
        },
    };
    let varnish = Bsdf::MetallicRoughness {
        base_color: rgb(1.0),
        metallic: 0.5,
        roughness: 0.0,
        layer: DielectricLayer::default(),
    };
    [
        Bsdf::Mirror {
            reflectance: rgb(1.0),
        },
        Bsdf::Conductor {
            reflectance: rgb(0.5),
            alpha: 0.5e-4,
        },
        glass(1.5, false),
        glass(1.5, true),
        glass(1.0, false),
        glass(0.75, false),
        coat(0.0),
        coat(0.25),
        layered,
        varnish,
        Bsdf::Lambert {
            reflectance: rgb(0.5),
        },
    ]
    .map(|bsdf| bsdf.parameters())
    .to_vec()
}

fn material_words(m: &BsdfParameters) -> Vec<f64> {
    let fresnel = m.specular.map(|s| s.fresnel);
    let (kind, f0, f90) = match fresnel {
        Some(Fresnel::Constant(f)) => (FRESNEL_CONSTANT, f, 0.0),
        Some(Fresnel::Schlick { f0, f90 }) => (FRESNEL_SCHLICK, f0, f90),
        Some(Fresnel::Dielectric { .. }) => (FRESNEL_DIELECTRIC, DVec3::ZERO, 0.0),
        _ => (FRESNEL_SCHLICK, DVec3::ZERO, 0.0),
    };
    let ior = match fresnel {
        Some(Fresnel::Dielectric { ior }) => ior,
        _ => 1.0,
    };
    let thin = m.transmission.is_some_and(|t| t.thin);
    let through = m.transmission.map_or(DVec3::ZERO, |t| t.transmittance);
    let words = [
        &m.diffuse.to_array()[..],
        &f0.to_array(),
        &[m.specular.map_or(0.0, |s| s.alpha), f90],
        &[f64::from(kind | if thin { THIN_BIT } else { 0 })],
        &through.to_array(),
        &[ior],
    ];
    words.concat()
}

const MATERIAL: &str =
    "let m = Material(in_vec3f(0u), in_vec3f(3u), in_f32(6u), in_f32(7u), vec3f(0.0),
    u32(in_f32(8u)), in_vec3f(9u), in_f32(12u), vec3f(0.0));";

fn way(found: u32) -> Way {
    [Way::Lit, Way::Reflected, Way::Transmitted][found as usize]
}

/// Directions, ways and weights; at numbers that are not so near a way's end that rounding decides.
#[test]
fn ways_are_the_twins() {
    let body = format!(
        "{MATERIAL}
         let s = sample_specular(m, in_vec3f(13u), in_f32(16u) > 0.0, in_f32(17u));
         out_vec3f(0u, s.wi); out_vec3f(3u, s.weight); out_u32(6u, s.way);"
    );
    let function = Function {
        imports: IMPORTS,
        body: &body,
        inputs: 18,
        outputs: 7,
        features: FEATURES,
    };
    let mut cases = Vec::new();
    for m in materials() {
        for degrees in [0.0, 30.0, 41.0, 42.5, 60.0, 85.0, 89.9] {
            for front in [1.0, 0.0] {
                for u in [0.0, 0.01, 0.1, 0.3, 0.55, 0.8, 1.0 - U] {
                    cases.push((m, direction(degrees, 0.7), front, f64::from(u as f32)));
                }
            }
        }
    }
    let inputs: Vec<f64> = cases
        .iter()
        .flat_map(|(m, wo, front, u)| {
            [material_words(m), wo.to_array().into(), vec![*front, *u]].concat()
        })
        .collect();
    let answers = call(context(), &function, &words(&inputs));
    let found = answers.vec3(0).zip(answers.vec3(3).zip(answers.u32(6)));
    let mut seen = [0; 3];
    for ((m, wo, front, u), (wi, (weight, found))) in cases.iter().zip(found) {
        let expected = sample_specular(m, *wo, *front > 0.0, *u);
        let near = |du: f64| sample_specular(m, *wo, *front > 0.0, (u + du).clamp(0.0, 1.0 - U));
        if near(1e-5).way != near(-1e-5).way {
            continue;
        }
        let what = format!("{m:?}, {wo}, front {front}, number {u}");
        assert_eq!(way(found), expected.way, "{what}");
        seen[found as usize] += 1;
        // Where c² + η² − 1 is 0.006 at least the refracted cosine is known to 1e-5.
        assert!(
            (wi - expected.wi).length() < 1e-5,
            "{what}: {wi}, not {}",
            expected.wi
        );
        let off = (weight - expected.weight).abs();
        assert!(
            off.cmple(3e-5 * expected.weight).all(),
            "{what}: {weight}, not {}",
            expected.weight
        );
    }
    assert!(seen.iter().all(|&n| n > 100), "{seen:?}");
}

fn drawn(m: &BsdfParameters, degrees: f64, front: bool, seed: u32) -> Answers {
    let w = material_words(m);
    let wo = direction(degrees, 0.7);
    let body = format!(
        "let m = Material(vec3f({:?}, {:?}, {:?}), vec3f({:?}, {:?}, {:?}), {:?}, {:?}, vec3f(0.0), {}u,
             vec3f({:?}, {:?}, {:?}), {:?}, vec3f(0.0));
         let s = sample_specular(m, vec3f({:?}, {:?}, {:?}), {front}, to_unit(pcg4d(vec4u(item, 3u, 4u, {seed}u)).x));
         out_vec3f(0u, s.weight); out_u32(3u, s.way);",
        w[0], w[1], w[2], w[3], w[4], w[5], w[6], w[7], w[8] as u32, w[9], w[10], w[11], w[12], wo.x, wo.y, wo.z
    );
    let function = Function {
        imports: IMPORTS,
        body: &body,
        inputs: 0,
        outputs: 4,
        features: FEATURES,
    };
    draw(context(), &function, 1 << 18)
}

/// In the mean, what goes each way is what Fresnel's equations let go there: with the weight of a
/// way counted in its samples alone. Broken: radiance
/// that is scaled by η² once too often or too seldom.
#[test]
fn each_way_keeps_its_light() {
    let glass = Bsdf::Dielectric {
        ior: 1.5,
        transmittance: DVec3::ONE,
        thin: false,
    };
    let r: f64 = 0.089_186_712_802_212_8;
    let pane = 2.0 * r / (1.0 + r);
    let coat = Bsdf::Plastic {
        reflectance: DVec3::splat(0.5),
        ior: 1.5,
        alpha: 0.0,
    };
    let thin = Bsdf::Dielectric {
        ior: 1.5,
        transmittance: DVec3::splat(0.5),
        thin: true,
    };
    // Seen from inside at the angle of refraction, the reflectance is the same, and radiance grows
    // by η².
    let inside = (60.0_f64.to_radians().sin() / 1.5).asin().to_degrees();
    let cases = [
        (glass, 60.0, true, [0.0, r, (1.0 - r) / 2.25]),
        (glass, inside, false, [0.0, r, (1.0 - r) * 2.25]),
        (thin, 60.0, true, [0.0, pane, 0.5 * (1.0 - pane)]),
        (coat, 60.0, true, [1.0, r, 0.0]),
    ];
    for (seed, (bsdf, degrees, front, expected)) in (300..).zip(cases) {
        let answers = drawn(&bsdf.parameters(), degrees, front, seed);
        let samples: Vec<(f64, u32)> = answers.f64(0).zip(answers.u32(3)).collect();
        for (way, expected) in (0..3).zip(expected).filter(|(_, expected)| *expected > 0.0) {
            let p_value = |factor: f64| {
                let of_way = |s: &(f64, u32)| if s.1 == way { factor * s.0 } else { 0.0 };
                let m: Moments = samples.iter().map(of_way).collect();
                let variance = m.variance_of_mean().unwrap();
                z_test(m.mean, expected, variance, 1e-5 * expected).p_value
            };
            let what = format!("{bsdf:?}, {degrees} degrees, way {way}, seed {seed}");
            statistics::accept(p_value(1.0), &what);
            statistics::reject(p_value(2.25), &format!("{what}, η² left out"));
            statistics::reject(p_value(1.0 / 2.25), &format!("{what}, η² twice"));
        }
    }
}

/// Light that passes and light that is reflected are all light, from outside and from inside; and
/// what is refracted obeys Snell's law in both.
#[test]
fn the_twin_keeps_energy_and_snells_law() {
    for degrees in [0.0_f64, 20.0, 40.0, 60.0, 89.0] {
        for front in [true, false] {
            let m = Bsdf::Dielectric {
                ior: 1.5,
                transmittance: DVec3::ONE,
                thin: false,
            };
            let wo = direction(degrees, 0.7);
            let last = sample_specular(&m.parameters(), wo, front, 1.0 - U);
            let eta = if front { 1.5 } else { 1.0 / 1.5 };
            if last.way == Way::Reflected {
                assert!(!front && degrees > 41.0);
                assert!((last.weight.x - 1.0).abs() < 1e-12);
                continue;
            }
            // The weight of the chosen way is (1 − R)/η² over its probability 1 − R.
            assert!((last.weight.x * eta * eta - 1.0).abs() < 1e-12);
            let sine = last.wi.truncate().length();
            assert!((sine * eta - wo.truncate().length()).abs() < 1e-12);
            // Directions are rounded to f32.
            assert!((last.wi.length() - 1.0).abs() < 4.0 * U);
        }
    }
}
