//! Values and samples, one by one.

use super::{
    COMPENSATED, FEATURES, IMPORTS, MATERIAL, WORDS, compensated, lobe_error, material_words,
    materials, plastic,
};
use crate::hard_cases::worst;
use crate::shader::bsdf::ggx::sample_bound;
use crate::support::hard_cases::{Measured, survive};
use crate::support::random::{direction, numbers};
use crate::support::rounding::{U, close};
use crate::support::shader::{Function, call, words};
use crate::support::{context, edge_points};
use direkt::low_level::reference::bsdf::bsdf::{eval_bsdf, sample_bsdf, specular_share};
use direkt::low_level::reference::bsdf::compensation::{
    compensation_fresnel, ggx_albedo_deficit, ggx_average_deficit,
};
use direkt::scene::material::{BsdfParameters, SpecularLobe};
use glam::{DVec2, DVec3};

#[test]
fn bsdf_values_are_the_twins() {
    values_are_the_twins(materials(), FEATURES);
}

#[test]
fn compensated_values_are_the_twins() {
    let all = materials().into_iter().map(compensated).collect();
    values_are_the_twins(all, COMPENSATED);
}

fn values_are_the_twins(materials: Vec<BsdfParameters>, features: &'static [&'static str]) {
    let context = context();
    let degrees = [0.0, 30.0, 60.0, 80.0, 89.0, 89.99, 90.5];
    let mut cases = Vec::new();
    for m in materials {
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
        body: &format!(
            "{MATERIAL}
               let value = eval_bsdf(m, in_vec3f(16u), in_vec3f(19u));
               out_vec3f(0u, value.f_cos);
               out_f32(3u, value.pdf.value);
               out_f32(4u, specular_share(m, max(in_f32(21u), 0.0)));"
        ),
        inputs: WORDS + 6,
        outputs: 5,
        features,
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
    let answers = call(context, &function, &words(&inputs));
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
            .map_or(16.0 * U, |s| lobe_error(s.alpha, *wi, *wo));
        // 1 − F of the diffuse lobe is known absolutely; under a coat it is one of two factors. The
        // deficits of the compensation are sums of terms of up to 69.
        let absolute = 64.0 * U * wi.z.max(0.0);
        let of_lobe = m
            .specular
            .map_or(DVec3::ZERO, |s| compensation_error(&s, wi.z, wo.z));
        let off = (f_cos - expected.f_cos).abs();
        assert!(
            off.cmple(error * expected.f_cos + absolute * m.diffuse + of_lobe)
                .all(),
            "{what}: {f_cos}, not {}: {error:.1e}",
            expected.f_cos
        );
        // The share, which mixes the densities, has the compensation's error.
        let share_error = 4e-5 * f64::from(u32::from(m.specular.is_some_and(|s| s.compensated)));
        assert!(
            (pdf - expected.pdf.0).abs() <= (error + 64.0 * share_error) * expected.pdf.0,
            "{what}: {pdf}, not {:?}",
            expected.pdf
        );
        if let Some(lobe) = &m.specular {
            let expected = specular_share(m.diffuse, lobe, wo.z.max(0.0));
            assert!(
                close(share, expected, 64.0) || (share - expected).abs() <= share_error,
                "{what}: {share}, not {expected}"
            );
        }
    }
}

/// Absolute error of the compensation's f_r cosθ: 2⁻²⁴ of the terms of a deficit, which add up to
/// 280 at most and have up to 12 roundings, times t(1 − t) ≤ 1/4, times the other deficit over π(1
/// − Ē).
fn compensation_error(lobe: &SpecularLobe, cos_i: f64, cos_o: f64) -> DVec3 {
    if cos_i <= 0.0 || cos_o <= 0.0 {
        return DVec3::ZERO;
    }
    let deficits = ggx_albedo_deficit(cos_i, lobe.alpha) + ggx_albedo_deficit(cos_o, lobe.alpha);
    let scale = deficits / (std::f64::consts::PI * ggx_average_deficit(lobe.alpha));
    compensation_fresnel(lobe) * (12.0 * 280.0 * 0.25 * U * scale * cos_i)
}

/// Directions that leave the horizon, and weights: with F ≤ 1 a conductor's weight F·G2/G1 and a
/// Lambert's albedo are in [0, 1], up to the error of the lobe in numerator and denominator alike
/// (64 roundings).
#[test]
fn bsdf_samples_are_finite_and_in_range() {
    let context = context();
    let function = Function {
        imports: IMPORTS,
        body: &format!(
            "{MATERIAL}
               let s = sample_bsdf(m, in_vec3f(16u), in_f32(19u), in_vec2f(20u));
               out_vec3f(0u, s.wi);
               out_vec3f(3u, s.weight);
               out_f32(6u, s.pdf.value);"
        ),
        inputs: WORDS + 6,
        outputs: 7,
        features: FEATURES,
    };
    let mut cases = Vec::new();
    let points = edge_points();
    for m in materials() {
        for degrees in [0.0, 45.0, 80.0, 89.9, 89.99] {
            for (i, u) in points.iter().enumerate() {
                let lobe = [0.0, 0.25, 0.75, 1.0 - U][i % 4];
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
    let answers = call(context, &function, &words(&inputs));
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
            assert!(weight.max_element() <= 1.0 + 128.0 * U, "{what}: {weight}");
        }
        let expected = sample_bsdf(m, *wo, *lobe, *u);
        match &m.specular {
            // |δω_i| ≤ 4|δh|, and 8 roundings.
            Some(lobe) if expected.specular => {
                let bound = 4.0 * sample_bound(*wo, lobe.alpha, *u) + 8.0 * U;
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

#[test]
fn the_bsdf_is_reciprocal() {
    let context = context();
    let imports = format!(
        "{IMPORTS}
         import package::bsdf::ggx::eval_ggx;
         fn one_sided(m: Material, wi: vec3f, wo: vec3f) -> f32 {{
             return eval_ggx(wi, vec3f(wo.xy, abs(wo.z) + 1e-5), normalize(wi + wo), max(m.alpha, 1e-4));
         }}"
    );
    let function = Function {
        imports: &imports,
        body: &format!(
            "{MATERIAL}
               let a = in_vec3f(16u); let b = in_vec3f(19u);
               out_vec3f(0u, eval_bsdf(m, a, b).f_cos / a.z);
               out_vec3f(3u, eval_bsdf(m, b, a).f_cos / b.z);
               out_vec2f(6u, vec2f(one_sided(m, a, b), one_sided(m, b, a)));"
        ),
        inputs: WORDS + 6,
        outputs: 8,
        features: COMPENSATED,
    };
    let random = |item: u32, stream: u32| {
        let [u, v, choice, _] = numbers(item, stream, 16);
        let degrees = if choice < 0.25 { 89.9 } else { 89.9 * u };
        direction(degrees, std::f64::consts::TAU * v)
    };
    // At 89.9° and opposite up to 10⁻³, where half vectors are short.
    let opposite = |item: u32| {
        let [azimuth, off, ..] = numbers(item, 2, 16);
        let turns = [0.0, std::f64::consts::PI + 1e-3 * (off - 0.5)];
        turns.map(|turn| direction(89.9, std::f64::consts::TAU * azimuth + turn))
    };
    let all: Vec<_> = materials().into_iter().map(compensated).collect();
    let cases: Vec<_> = (0..10_000)
        .map(|i| {
            let [a, b] = match i % 8 {
                0 => opposite(i),
                _ => [random(i, 0), random(i, 1)],
            };
            (all[(i / 8) as usize % all.len()], a, b)
        })
        .collect();
    let inputs: Vec<f64> = cases
        .iter()
        .flat_map(|(m, a, b)| [material_words(m), a.to_array().into(), b.to_array().into()])
        .flatten()
        .collect();
    let answers = call(context, &function, &words(&inputs));
    let differing = |ab: f64, ba: f64| (ab - ba).abs() / ab.max(1e-30);
    let ours = answers.vec3(0).zip(answers.vec3(3));
    survive(
        context,
        Measured {
            entry: "B5",
            case: "10⁴ pairs of directions, many of them at 89.9° and opposite",
            figure: "relative difference of f(a, b) and f(b, a)",
            bound: 1e-5,
            textbook: "|n·v| + 10⁻⁵ for the viewer (Karis 2013)",
            naive: worst(answers.vec2(6).map(|f| differing(f.x, f.y))),
            ours: worst(ours.map(|(ab, ba)| differing(ab.x, ba.x))),
        },
    );
    for ((m, a, b), (ab, ba)) in cases.iter().zip(answers.vec3(0).zip(answers.vec3(3))) {
        assert!(
            (ab - ba).abs().cmple(1e-5 * ab).all(),
            "{}: {m:?} {a} {b}: {ab} {ba}",
            context.adapter.name
        );
    }
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
        body: &format!(
            "{MATERIAL}
               out_vec3f(0u, sample_bsdf(m, in_vec3f(16u), in_f32(19u), in_vec2f(20u)).wi);"
        ),
        inputs: WORDS + 6,
        outputs: 3,
        features: FEATURES,
    };
    let u = DVec2::new(0.375, 0.625);
    let lobes = [0.0, share - 64.0 * U, share + 64.0 * U, 1.0 - U];
    let inputs: Vec<f64> = lobes
        .iter()
        .flat_map(|l| [material_words(&m), wo.to_array().into(), vec![*l, u.x, u.y]])
        .flatten()
        .collect();
    let answers = call(context, &function, &words(&inputs));
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
