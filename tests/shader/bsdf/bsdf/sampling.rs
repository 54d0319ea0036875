//! Densities and albedos of sampled directions.

use super::{coated, compensated, conductor, diffuse, drawn, metal, plastic};
use crate::support::hard_cases::{Measured, survive};
use crate::support::random::direction;
use crate::support::rounding::U;
use crate::support::{context, histogram, statistics};
use direkt::low_level::reference::BrokenTwin;
use direkt::low_level::reference::broken::BROKEN_TWINS;
use direkt::low_level::reference::bsdf::bsdf::{eval_bsdf, specular_share};
use direkt::low_level::reference::bsdf::ggx::pdf_ggx;
use direkt::low_level::reference::exact::cubature::{Tolerance, integrate};
use direkt::low_level::reference::exact::ggx::directional_albedo;
use direkt::low_level::stats::moments::Moments;
use direkt::low_level::stats::z_test::z_test;
use direkt::scene::material::BsdfParameters;
use glam::DVec3;

/// Density of sampled directions over the whole sphere. Below the horizon are the reflections about
/// visible normals that fail: the specular share of the GGX density there, which is above zero
/// where the half vector is upright.
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
        (metal(0.3), 60.0),
        (coated(0.6, 0.3), 60.0),
        (compensated(conductor(DVec3::ONE, 1.0)), 30.0),
        (compensated(metal(0.5)), 75.0),
    ]
}

#[test]
fn bsdf_samples_match_pdf() {
    let context = context();
    for (seed, (m, degrees)) in (130..).zip(sampled_cases()) {
        let wo = direction(degrees, 0.7);
        let samples: Vec<DVec3> = drawn(context, &m, wo, seed).vec3(0).collect();
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
                BrokenTwin::LightLeftOut
                | BrokenTwin::MisWeights
                | BrokenTwin::RaysForgotten
                | BrokenTwin::OpaqueShadows => {
                    continue;
                }
            };
            statistics::reject(broken, &format!("{what}, {}", row.name));
        }
    }
}

/// Over the upper hemisphere and the failures below it. In polar coordinates around the normal the
/// integrand jumps only where z = −cosθ_o.
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

/// The mean of f_r cosθ/pdf, failures included, is the directional albedo; weights are at most 1.
#[test]
fn sampled_weights_have_the_exact_albedo() {
    let context = context();
    let mut seed = 139;
    let [mut all, mut again] = [0.0_f64; 2];
    for alpha in [1.0, 0.5, 0.25, 0.1, 0.01] {
        for degrees in [0.0_f64, 45.0, 60.0, 80.0, 89.0] {
            seed += 1;
            let m = conductor(DVec3::ONE, alpha);
            let wo = direction(degrees, 0.7);
            let answers = drawn(context, &m, wo, seed);
            let samples: Vec<(f64, f64)> = answers.f64(3).zip(answers.f64(2)).collect();
            let exact = directional_albedo(alpha, degrees.to_radians().cos()).total();
            // Numerator and denominator share D; what is left takes 64 roundings, here as one bias
            // of all samples. Those of wo move the albedo by its slope, at most tanθ times the
            // angle.
            let allowance = (64.0 + 2.0 * degrees.to_radians().tan()) * U;
            let p_value = |values: &mut dyn Iterator<Item = f64>| {
                let m: Moments = values.collect();
                z_test(m.mean, exact, m.variance_of_mean().unwrap(), allowance).p_value
            };
            let what = format!(
                "albedo, alpha {alpha}, {degrees} degrees, seed {seed}, {}",
                context.adapter.name
            );
            statistics::accept(p_value(&mut samples.iter().map(|s| s.0)), &what);
            let off = |values: &mut dyn Iterator<Item = f64>| {
                let m: Moments = values.collect();
                let beyond = (m.mean - exact).abs() - allowance.max(5e-6) * exact;
                beyond.max(0.0) / m.variance_of_mean().unwrap().sqrt()
            };
            all = all.max(off(&mut samples.iter().map(|s| s.0)));
            let above = samples.iter().filter(|s| s.1 > 0.0);
            again = again.max(off(&mut above.map(|s| s.0)));
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
                    // Of a mirror along its normal the cosine is 1. The weight does not know the
                    // direction that a swap makes of it, and there is no light and no other
                    // strategy.
                    BrokenTwin::ExtraCosine
                    | BrokenTwin::SwappedSinCos
                    | BrokenTwin::LightLeftOut
                    | BrokenTwin::MisWeights
                    | BrokenTwin::RaysForgotten
                    | BrokenTwin::OpaqueShadows => continue,
                };
                statistics::reject(broken, &format!("{what}, {}", row.name));
            }
        }
    }
    survive(
        context,
        Measured {
            entry: "B2",
            case: "albedo at α of 0.01 to 1 and angles up to 89°, 2²⁰ samples each",
            figure: "standard errors off the exact value",
            bound: 4.5,
            textbook: "directions below the surface drawn again",
            naive: again,
            ours: all,
        },
    );
}

/// The furnace: every weight of a white Lambert surface is 1, whatever the number, but for those at
/// the horizon.
#[test]
fn a_white_lambert_surface_keeps_all_light() {
    let context = context();
    let answers = drawn(context, &diffuse(1.0), direction(60.0, 0.7), 18);
    let mut lost = 0;
    for (wi, weight) in answers.vec3(0).zip(answers.vec3(3)) {
        lost += usize::from(wi.z <= 0.0);
        assert!(
            wi.z <= 0.0 || (weight - DVec3::ONE).abs().max_element() <= 16.0 * U,
            "{}: {wi} {weight}",
            context.adapter.name
        );
    }
    // z = 0 where 1 − r² rounds to 0: less than 2⁻²² of the disk.
    assert!(lost <= 4, "{lost} samples at the horizon");
}
