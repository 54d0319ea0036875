//! `shaders/bsdf/bsdf.wesl`.

use super::ggx::sample_bound;
use crate::support::rounding::{UNIT, close, direction, numbers};
use crate::support::shader::{Answers, Function, call, draw, words};
use crate::support::{context, edge_points, histogram, statistics};
use direkt::gpu::Context;
use direkt::reference::BrokenTwin;
use direkt::reference::broken::BROKEN_TWINS;
use direkt::reference::bsdf::bsdf::{eval_bsdf, sample_bsdf, specular_share};
use direkt::reference::bsdf::ggx::pdf_ggx;
use direkt::reference::exact::cubature::{Tolerance, integrate};
use direkt::reference::exact::ggx::directional_albedo;
use direkt::scene::material::{BsdfParameters, SpecularLobe};
use direkt::stats::moments::Moments;
use direkt::stats::z_test::z_test;
use glam::{DVec2, DVec3};

const IMPORTS: &str = "import package::bsdf::bsdf::{eval_bsdf, sample_bsdf, specular_share};
    import package::core::rng::{pcg4d, to_unit, to_unit_2d};
    import package::scene::fetch::Material;";

fn rounded(m: BsdfParameters) -> BsdfParameters {
    let v = crate::support::rounding::rounded;
    BsdfParameters {
        diffuse: v(m.diffuse),
        specular: m.specular.map(|s| SpecularLobe {
            f0: v(s.f0),
            alpha: f64::from(s.alpha as f32),
        }),
    }
}

fn conductor(f0: DVec3, alpha: f64) -> BsdfParameters {
    rounded(BsdfParameters {
        diffuse: DVec3::ZERO,
        specular: Some(SpecularLobe { f0, alpha }),
    })
}

fn plastic(diffuse: f64, f0: f64, alpha: f64) -> BsdfParameters {
    rounded(BsdfParameters {
        diffuse: DVec3::new(diffuse, 0.5 * diffuse, 0.0),
        specular: Some(SpecularLobe {
            f0: DVec3::splat(f0),
            alpha,
        }),
    })
}

fn diffuse(albedo: f64) -> BsdfParameters {
    rounded(BsdfParameters {
        diffuse: DVec3::splat(albedo),
        specular: None,
    })
}

/// Seven input words: what the shaders' `Material` holds.
fn material_words(m: &BsdfParameters) -> Vec<f64> {
    let (f0, alpha) = m.specular.map_or((DVec3::ZERO, 0.0), |s| (s.f0, s.alpha));
    [m.diffuse.to_array(), f0.to_array()]
        .concat()
        .into_iter()
        .chain([alpha])
        .collect()
}

/// The same as an expression.
fn material_expression(m: &BsdfParameters) -> String {
    let w = material_words(m);
    format!(
        "Material(vec3f({:?}, {:?}, {:?}), vec3f({:?}, {:?}, {:?}), {:?})",
        w[0], w[1], w[2], w[3], w[4], w[5], w[6]
    )
}

/// Relative error of the GGX lobe: 128 roundings of its functions, and D's sensitivity 2/α to the angle of h, which is
/// known to 2 roundings over |ω_i + ω_o| and 16 of the normalisation. Twice for second order.
fn lobe_error(alpha: f64, wi: DVec3, wo: DVec3) -> f64 {
    let half_vector = (2.0 / (wi + wo).length() + 16.0) * UNIT;
    128.0 * UNIT + 4.0 / alpha * half_vector
}

fn materials() -> Vec<BsdfParameters> {
    vec![
        diffuse(0.8),
        conductor(DVec3::new(1.0, 0.5, 0.04), 1e-4),
        conductor(DVec3::new(1.0, 0.5, 0.04), 0.01),
        conductor(DVec3::new(1.0, 0.5, 0.04), 1.0),
        plastic(0.6, 0.04, 0.1),
        plastic(0.6, 0.04, 0.5),
    ]
}

#[test]
fn bsdf_values_are_the_twins() {
    let context = context();
    let degrees = [0.0, 30.0, 60.0, 80.0, 89.0, 89.99, 90.5];
    let mut cases = Vec::new();
    for m in materials() {
        for i in degrees {
            for o in degrees {
                for azimuth in [0.0, 2.0, std::f64::consts::PI] {
                    cases.push((m, direction(i, 0.7 + azimuth), direction(o, 0.7)));
                }
            }
        }
    }
    let function = Function {
        imports: IMPORTS,
        body: "let m = Material(in_vec3f(0u), in_vec3f(3u), in_f32(6u));
               let value = eval_bsdf(m, in_vec3f(7u), in_vec3f(10u));
               out_vec3f(0u, value.f_cos);
               out_f32(3u, value.pdf.value);
               out_f32(4u, specular_share(m, max(in_f32(12u), 0.0)));",
        inputs: 13,
        outputs: 5,
        features: &["GLOSSY"],
    };
    let inputs: Vec<f64> = cases
        .iter()
        .flat_map(|(m, wi, wo)| {
            [
                material_words(m),
                wi.to_array().into(),
                wo.to_array().into(),
            ]
        })
        .flatten()
        .collect();
    let answers = call(&context, &function, &words(&inputs));
    let found = answers.vec3(0).zip(answers.f64(3).zip(answers.f64(4)));
    for ((m, wi, wo), (f_cos, (pdf, share))) in cases.iter().zip(found) {
        let what = format!("{}: {m:?} {wi} {wo}", context.adapter.name);
        let expected = eval_bsdf(m, *wi, *wo);
        assert!(
            f_cos.is_finite() && pdf.is_finite(),
            "{what}: {f_cos} {pdf}"
        );
        assert!(f_cos.min_element() >= 0.0 && pdf >= 0.0, "{what}");
        let error = m
            .specular
            .map_or(16.0 * UNIT, |s| lobe_error(s.alpha, *wi, *wo));
        // 1 − F of the diffuse lobe is known absolutely.
        let absolute = 32.0 * UNIT * wi.z.max(0.0);
        let off = (f_cos - expected.f_cos).abs();
        assert!(
            off.cmple(error * expected.f_cos + absolute * m.diffuse)
                .all(),
            "{what}: {f_cos}, not {}: {error:.1e}",
            expected.f_cos
        );
        assert!(
            (pdf - expected.pdf.0).abs() <= error * expected.pdf.0,
            "{what}: {pdf}, not {:?}",
            expected.pdf
        );
        if let Some(lobe) = &m.specular {
            let expected = specular_share(m.diffuse, lobe, wo.z.max(0.0));
            assert!(
                close(share, expected, 64.0),
                "{what}: {share}, not {expected}"
            );
        }
    }
}

/// Directions that leave the horizon, and weights: with F ≤ 1 a conductor's weight F·G2/G1 and a Lambert's albedo are in
/// [0, 1], up to the error of the lobe in numerator and denominator alike (64 roundings).
#[test]
fn bsdf_samples_are_finite_and_in_range() {
    let context = context();
    let function = Function {
        imports: IMPORTS,
        body: "let m = Material(in_vec3f(0u), in_vec3f(3u), in_f32(6u));
               let s = sample_bsdf(m, in_vec3f(7u), in_f32(10u), in_vec2f(11u));
               out_vec3f(0u, s.wi);
               out_vec3f(3u, s.weight);
               out_f32(6u, s.pdf.value);",
        inputs: 13,
        outputs: 7,
        features: &["GLOSSY"],
    };
    let mut cases = Vec::new();
    let points = edge_points();
    for m in materials() {
        for degrees in [0.0, 45.0, 80.0, 89.9, 89.99] {
            for (i, u) in points.iter().enumerate() {
                let lobe = [0.0, 0.25, 0.75, 1.0 - UNIT][i % 4];
                cases.push((m, direction(degrees, 0.7), lobe, *u));
            }
        }
    }
    let inputs: Vec<f64> = cases
        .iter()
        .flat_map(|(m, wo, lobe, u)| {
            [
                material_words(m),
                wo.to_array().into(),
                vec![*lobe, u.x, u.y],
            ]
        })
        .flatten()
        .collect();
    let answers = call(&context, &function, &words(&inputs));
    let found = answers.vec3(0).zip(answers.vec3(3).zip(answers.f64(6)));
    for ((m, wo, lobe, u), (wi, (weight, pdf))) in cases.iter().zip(found) {
        let what = format!("{}: {m:?} {wo} {lobe} {u}", context.adapter.name);
        assert!((wi.length() - 1.0).abs() < 1e-5, "{what}: {wi}");
        assert!(
            weight.is_finite() && pdf.is_finite() && pdf >= 0.0,
            "{what}"
        );
        assert!(weight.min_element() >= 0.0, "{what}: {weight}");
        if wi.z <= 0.0 {
            assert_eq!((weight, pdf), (DVec3::ZERO, 0.0), "{what}");
        }
        if m.diffuse == DVec3::ZERO || m.specular.is_none() {
            assert!(
                weight.max_element() <= 1.0 + 128.0 * UNIT,
                "{what}: {weight}"
            );
        }
        let expected = sample_bsdf(m, *wo, *lobe, *u);
        match &m.specular {
            // |δω_i| ≤ 4|δh|, and 8 roundings.
            Some(lobe) if expected.specular => {
                let bound = 4.0 * sample_bound(*wo, lobe.alpha, *u) + 8.0 * UNIT;
                assert!(
                    (wi - expected.wi).length() <= bound,
                    "{what}: {wi}, not {}",
                    expected.wi
                );
            }
            // The bounds of `sample_lambert`.
            _ => {
                let off = (wi - expected.wi).truncate().length();
                let off_z = (wi.z * wi.z - expected.wi.z * expected.wi.z).abs();
                assert!(
                    off < 4e-7 && off_z < 2e-6,
                    "{what}: {wi}, not {}",
                    expected.wi
                );
            }
        }
    }
}

fn drawn(context: &Context, m: &BsdfParameters, wo: DVec3, seed: u32) -> Answers {
    let body = format!(
        "let words = pcg4d(vec4u(item, 13u, 14u, {seed}u));
         let wo = vec3f({:?}, {:?}, {:?});
         let s = sample_bsdf({}, wo, to_unit(words.z), to_unit_2d(words.xy));
         out_vec3f(0u, s.wi);
         out_vec3f(3u, s.weight);",
        wo.x,
        wo.y,
        wo.z,
        material_expression(m)
    );
    let function = Function {
        imports: IMPORTS,
        body: &body,
        inputs: 0,
        outputs: 6,
        features: &["GLOSSY"],
    };
    draw(context, &function, 1 << 20)
}

/// Density of sampled directions over the whole sphere. Below the horizon are the reflections about visible normals
/// that fail: the specular share of the GGX density there, which is above zero where the half vector is upright.
fn sphere_pdf(m: &BsdfParameters, wo: DVec3, wi: DVec3) -> f64 {
    if wi.z > 0.0 {
        return eval_bsdf(m, wi, wo).pdf.0;
    }
    match (&m.specular, (wi + wo).try_normalize()) {
        (Some(lobe), Some(h)) if h.z > 0.0 => {
            specular_share(m.diffuse, lobe, wo.z) * pdf_ggx(wo, h, lobe.alpha).0
        }
        _ => 0.0,
    }
}

fn sampled_cases() -> Vec<(BsdfParameters, f64)> {
    vec![
        (conductor(DVec3::ONE, 1.0), 0.0),
        (conductor(DVec3::ONE, 1.0), 80.0),
        (conductor(DVec3::ONE, 0.3), 60.0),
        (conductor(DVec3::ONE, 0.3), 89.9),
        (plastic(0.6, 0.04, 0.25), 30.0),
        (plastic(0.6, 0.04, 0.5), 85.0),
        (diffuse(1.0), 45.0),
    ]
}

#[test]
fn bsdf_samples_match_pdf() {
    let context = context();
    for (seed, (m, degrees)) in (130..).zip(sampled_cases()) {
        let wo = direction(degrees, 0.7);
        let samples: Vec<DVec3> = drawn(&context, &m, wo, seed).vec3(0).collect();
        let pdf = |wi: DVec3| sphere_pdf(&m, wo, wi);
        let what = format!(
            "sample_bsdf, {m:?}, {degrees} degrees, seed {seed}, {}",
            context.adapter.name
        );
        let test = |pdf: &dyn Fn(DVec3) -> f64| histogram::directions_p_value(&samples, pdf);
        statistics::accept(test(&pdf), &what);
        for row in BROKEN_TWINS {
            let broken = match row.twin {
                BrokenTwin::PdfScaled => test(&|w| 1.02 * pdf(w)),
                // The density of the normal taken for that of the direction, or that on the disk.
                BrokenTwin::WrongMeasure if m.specular.is_some() => {
                    test(&|w| pdf(w) * 2.0 * (wo.dot(w) + 1.0).max(0.0).sqrt())
                }
                BrokenTwin::WrongMeasure => test(&|w| pdf(w) / w.z.max(1e-9)),
                BrokenTwin::ExtraCosine => test(&|w| 1.5 * pdf(w) * w.z.max(0.0)),
                // It maps the cosine distribution onto itself.
                BrokenTwin::SwappedSinCos if m.specular.is_none() => continue,
                BrokenTwin::SwappedSinCos => {
                    let swapped: Vec<DVec3> = samples
                        .iter()
                        .map(|w| BrokenTwin::direction(Some(row.twin), *w))
                        .collect();
                    histogram::directions_p_value(&swapped, pdf)
                }
                // These are about choosing among lights and strategies.
                BrokenTwin::LightLeftOut | BrokenTwin::MisWeights => continue,
            };
            statistics::reject(broken, &format!("{what}, {}", row.name));
        }
    }
}

/// Over the upper hemisphere and the failures below it. In polar coordinates around the normal the integrand jumps
/// only where z = −cosθ_o.
#[test]
fn densities_integrate_to_one_with_the_failures() {
    for (m, degrees) in sampled_cases() {
        let wo = direction(degrees, 0.7);
        let at = |z: f64, phi: f64| {
            let r = (1.0 - z * z).max(0.0).sqrt();
            DVec3::splat(sphere_pdf(
                &m,
                wo,
                DVec3::new(r * phi.cos(), r * phi.sin(), z),
            ))
        };
        let tau = std::f64::consts::TAU;
        let tolerance = Tolerance {
            absolute: 1e-7,
            relative: 0.0,
        };
        let all = integrate(
            at,
            &[-1.0, -wo.z, 0.0, wo.z, 1.0],
            &[0.0, 0.7, 0.7 + 0.5 * tau, tau],
            tolerance,
        );
        // Inputs rounded to f32 are not quite unit vectors.
        assert!(
            (all.value.x - 1.0).abs() < 1e-6,
            "{m:?}, {degrees}: {all:?}"
        );
    }
}

#[test]
fn the_bsdf_is_reciprocal() {
    let context = context();
    let function = Function {
        imports: IMPORTS,
        body: "let m = Material(in_vec3f(0u), in_vec3f(3u), in_f32(6u));
               let a = in_vec3f(7u); let b = in_vec3f(10u);
               out_vec3f(0u, eval_bsdf(m, a, b).f_cos / a.z);
               out_vec3f(3u, eval_bsdf(m, b, a).f_cos / b.z);",
        inputs: 13,
        outputs: 6,
        features: &["GLOSSY"],
    };
    let random = |item: u32, stream: u32| {
        let [u, v, choice, _] = numbers(item, stream, 16);
        let degrees = if choice < 0.25 { 89.9 } else { 89.9 * u };
        direction(degrees, std::f64::consts::TAU * v)
    };
    let all = materials();
    let cases: Vec<_> = (0..10_000)
        .map(|i| (all[i as usize % all.len()], random(i, 0), random(i, 1)))
        .collect();
    let inputs: Vec<f64> = cases
        .iter()
        .flat_map(|(m, a, b)| [material_words(m), a.to_array().into(), b.to_array().into()])
        .flatten()
        .collect();
    let answers = call(&context, &function, &words(&inputs));
    for ((m, a, b), (ab, ba)) in cases.iter().zip(answers.vec3(0).zip(answers.vec3(3))) {
        assert!(
            (ab - ba).abs().cmple(1e-5 * ab).all(),
            "{}: {m:?} {a} {b}: {ab} {ba}",
            context.adapter.name
        );
    }
}

/// The mean of f_r cosθ/pdf, failures included, is the directional albedo; weights are at most 1.
#[test]
fn sampled_weights_have_the_exact_albedo() {
    let context = context();
    let mut seed = 139;
    for alpha in [1.0, 0.5, 0.25, 0.1, 0.01] {
        for degrees in [0.0_f64, 45.0, 60.0, 80.0, 89.0] {
            seed += 1;
            let m = conductor(DVec3::ONE, alpha);
            let wo = direction(degrees, 0.7);
            let answers = drawn(&context, &m, wo, seed);
            let samples: Vec<(f64, f64)> = answers.f64(3).zip(answers.f64(2)).collect();
            let exact = directional_albedo(alpha, degrees.to_radians().cos()).total();
            // Numerator and denominator share D; what is left takes 64 roundings, here as one bias of all samples. Those
            // of wo move the albedo by its slope, at most tanθ times the angle.
            let allowance = (64.0 + 2.0 * degrees.to_radians().tan()) * UNIT;
            let p_value = |values: &mut dyn Iterator<Item = f64>| {
                let m: Moments = values.collect();
                z_test(m.mean, exact, m.variance_of_mean().unwrap(), allowance).p_value
            };
            let what = format!(
                "albedo, alpha {alpha}, {degrees} degrees, seed {seed}, {}",
                context.adapter.name
            );
            statistics::accept(p_value(&mut samples.iter().map(|s| s.0)), &what);
            for row in BROKEN_TWINS {
                let broken = match row.twin {
                    BrokenTwin::PdfScaled => p_value(&mut samples.iter().map(|s| s.0 / 1.02)),
                    // f_r cosθ over the density of the normal: 1/(4 ω_o·h) too large.
                    BrokenTwin::WrongMeasure => {
                        let jacobian = 4.0 * wo.z.max(0.1);
                        p_value(&mut samples.iter().map(|s| s.0 / jacobian))
                    }
                    BrokenTwin::ExtraCosine if degrees > 0.0 || alpha > 0.05 => {
                        p_value(&mut samples.iter().map(|s| s.0 * s.1.max(0.0)))
                    }
                    // Of a mirror along its normal the cosine is 1. The weight does not know the direction that a swap
                    // makes of it, and there is no light and no other strategy.
                    BrokenTwin::ExtraCosine
                    | BrokenTwin::SwappedSinCos
                    | BrokenTwin::LightLeftOut
                    | BrokenTwin::MisWeights => continue,
                };
                statistics::reject(broken, &format!("{what}, {}", row.name));
            }
        }
    }
}

/// The furnace: every weight of a white Lambert surface is 1, whatever the number, but for those at the horizon.
#[test]
fn a_white_lambert_surface_keeps_all_light() {
    let context = context();
    let answers = drawn(&context, &diffuse(1.0), direction(60.0, 0.7), 18);
    let mut lost = 0;
    for (wi, weight) in answers.vec3(0).zip(answers.vec3(3)) {
        lost += usize::from(wi.z <= 0.0);
        assert!(
            wi.z <= 0.0 || (weight - DVec3::ONE).abs().max_element() <= 16.0 * UNIT,
            "{}: {wi} {weight}",
            context.adapter.name
        );
    }
    // z = 0 where 1 − r² rounds to 0: less than 2⁻²² of the disk.
    assert!(lost <= 4, "{lost} samples at the horizon");
}

/// The number that chooses the lobe does so at the share.
#[test]
fn the_lobe_is_chosen_at_its_share() {
    let context = context();
    let m = plastic(0.6, 0.04, 0.1);
    let wo = direction(50.0, 0.7);
    let share = specular_share(m.diffuse, m.specular.as_ref().unwrap(), wo.z);
    let function = Function {
        imports: IMPORTS,
        body: "let m = Material(in_vec3f(0u), in_vec3f(3u), in_f32(6u));
               out_vec3f(0u, sample_bsdf(m, in_vec3f(7u), in_f32(10u), in_vec2f(11u)).wi);",
        inputs: 13,
        outputs: 3,
        features: &["GLOSSY"],
    };
    let u = DVec2::new(0.375, 0.625);
    let lobes = [0.0, share - 64.0 * UNIT, share + 64.0 * UNIT, 1.0 - UNIT];
    let inputs: Vec<f64> = lobes
        .iter()
        .flat_map(|l| [material_words(&m), wo.to_array().into(), vec![*l, u.x, u.y]])
        .flatten()
        .collect();
    let answers = call(&context, &function, &words(&inputs));
    for (lobe, wi) in lobes.iter().zip(answers.vec3(0)) {
        let expected = sample_bsdf(&m, wo, *lobe, u);
        assert_eq!(expected.specular, *lobe < share);
        assert!(
            (wi - expected.wi).length() < 1e-5,
            "{lobe}: {wi}, not {}",
            expected.wi
        );
    }
}
