//! `shaders/bsdf/ggx.wesl`.

use crate::hard_cases::worst;
use crate::support::hard_cases::{Measured, survive};
use crate::support::random::{direction, rounded};
use crate::support::rounding::{U, close};
use crate::support::shader::{Function, call, draw, words};
use crate::support::{context, edge_points, histogram, statistics};
use direkt::low_level::reference::BrokenTwin;
use direkt::low_level::reference::broken::BROKEN_TWINS;
use direkt::low_level::reference::bsdf::ggx::{
    eval_ggx, ggx_distribution, ggx_lambda, ggx_visibility, pdf_ggx, sample_ggx_visible_normal,
};
use direkt::low_level::stats::moments::Moments;
use direkt::low_level::stats::z_test::z_test;
use glam::{DVec2, DVec3};

const ALPHAS: [f64; 6] = [1e-4, 1e-3, 0.01, 0.1, 0.5, 1.0];
const DEGREES: [f64; 7] = [0.0, 30.0, 60.0, 80.0, 89.0, 89.9, 89.99];

fn f32_of(x: f64) -> f64 {
    f64::from(x as f32)
}

/// Every function is a chain of sums of positive terms, products, quotients (2.5 ulp) and roots
/// (4.5 ulp, as WGSL has them). The longest, D·V, takes 27 roundings for D and 22 for V; 64 are
/// allowed.
#[test]
fn ggx_values_are_the_twins() {
    let context = context();
    let mut cases = Vec::new();
    for alpha in ALPHAS {
        for i in DEGREES {
            for o in DEGREES {
                for azimuth in [0.0, 2.0, std::f64::consts::PI] {
                    let (wi, wo) = (direction(i, 0.7 + azimuth), direction(o, 0.7));
                    cases.push((wi, wo, rounded((wi + wo).normalize()), f32_of(alpha)));
                }
            }
        }
    }
    let function = Function {
        imports: "import package::bsdf::ggx::{
                      eval_ggx, ggx_distribution, ggx_lambda_sum, ggx_visibility, pdf_ggx};",
        body: "let wi = in_vec3f(0u); let wo = in_vec3f(3u); let h = in_vec3f(6u); let alpha = in_f32(9u);
               out_f32(0u, ggx_distribution(h, alpha));
               out_f32(1u, ggx_lambda_sum(wo, alpha));
               out_f32(2u, ggx_visibility(wi, wo, alpha));
               out_f32(3u, pdf_ggx(wo, h, alpha).value);
               out_f32(4u, eval_ggx(wi, wo, h, alpha));",
        inputs: 10,
        outputs: 5,
        features: &[],
    };
    let inputs = cases.iter().flat_map(|(wi, wo, h, alpha)| {
        let vectors = [*wi, *wo, *h];
        let components: Vec<f64> = vectors.iter().flat_map(DVec3::to_array).collect();
        components.into_iter().chain([*alpha])
    });
    let answers = call(context, &function, &words(&inputs.collect::<Vec<_>>()));
    for (item, &(wi, wo, h, alpha)) in cases.iter().enumerate() {
        let expected = [
            ggx_distribution(h, alpha),
            2.0 * wo.z * (1.0 + ggx_lambda(wo, alpha)),
            ggx_visibility(wi, wo, alpha),
            pdf_ggx(wo, h, alpha).0,
            eval_ggx(wi, wo, h, alpha),
        ];
        for (word, expected) in expected.into_iter().enumerate() {
            let found = answers.f64(word).nth(item).unwrap();
            assert!(
                found.is_finite() && found >= 0.0 && close(found, expected, 64.0),
                "{}: word {word} at {wi} {wo}, alpha {alpha}: {found}, not {expected}",
                context.adapter.name
            );
        }
    }
}

/// HARD CASES B1: D at tanθ/α = 0, ½, 1, 3 is 1/(πα²cos⁴θ(1 + t²)²).
#[test]
fn the_distribution_does_not_cancel() {
    let context = context();
    let function = Function {
        imports: "import package::bsdf::ggx::ggx_distribution;",
        body: "out_f32(0u, ggx_distribution(in_vec3f(0u), in_f32(3u)));
               let c = in_f32(2u); let a2 = in_f32(3u) * in_f32(3u);
               let d = c * c * (a2 - 1.0) + 1.0;
               out_f32(1u, a2 / (3.14159265 * d * d));",
        inputs: 4,
        outputs: 2,
        features: &[],
    };
    let cases = ALPHAS.iter().flat_map(|&alpha| {
        [0.0, 0.5, 1.0, 3.0].map(|t: f64| {
            let cos = (1.0 + (t * alpha).powi(2)).sqrt().recip();
            let exact = 1.0 / (std::f64::consts::PI * (alpha * cos * cos * (1.0 + t * t)).powi(2));
            ([t * alpha * cos, 0.0, cos, alpha], exact)
        })
    });
    let (inputs, exact): (Vec<[f64; 4]>, Vec<f64>) = cases.unzip();
    let answers = call(context, &function, &words(inputs.as_flattened()));
    for (alpha, case) in [(1e-3, "α = 10⁻³"), (1e-4, "α = 10⁻⁴")] {
        let off = |word| {
            let of_alpha = answers.f64(word).zip(&exact).zip(&inputs);
            let of_alpha = of_alpha.filter(|(_, input)| input[3] == alpha);
            worst(of_alpha.map(|((found, exact), _)| (found / exact - 1.0).abs()))
        };
        survive(
            context,
            Measured {
                entry: "B1",
                case: &format!("{case}, normals with tanθ/α of 0, ½, 1 and 3"),
                figure: "relative error of the distribution",
                bound: 1e-5,
                textbook: "α²/(π((n·h)²(α² − 1) + 1)²)",
                naive: off(1),
                ours: off(0),
            },
        );
    }
    for ((found, exact), input) in answers.f64(0).zip(exact).zip(inputs) {
        assert!((found / exact - 1.0).abs() < 1e-5, "{input:?}: {found}");
    }
}

const SAMPLE: Function<'_> = Function {
    imports: "import package::bsdf::ggx::sample_ggx_visible_normal;",
    body: "out_vec3f(0u, sample_ggx_visible_normal(in_vec3f(0u), in_f32(3u), in_vec2f(4u)));",
    inputs: 6,
    outputs: 3,
    features: &[],
};

/// The cap's point (x, y, z) is computed to δz = 40 roundings (normalisation 16, sums and products)
/// and, across, to δr + 24 roundings, where the root r = √(1 − z²) turns δz into min(q/r, √q) with
/// q = 2δz + 2 roundings. Scaling by α leaves an angle of at most (A·δz + 2L·αδr)/L², with A = α|x,
/// y| and L² = A² + z². Twice that for second order.
pub(super) fn sample_bound(wo: DVec3, alpha: f64, u: DVec2) -> f64 {
    let stretched = DVec3::new(alpha * wo.x, alpha * wo.y, wo.z).normalize();
    let z = (1.0 - u.y) * (1.0 + stretched.z) - stretched.z;
    let r = (1.0 - z * z).max(0.0).sqrt();
    let delta_z = 40.0 * U;
    let q = 2.0 * delta_z + 2.0 * U;
    let delta_r = (q / r.max(1e-9)).min(q.sqrt()) + 24.0 * U;
    let sc = direkt::low_level::reference::core::math::sin_cos_two_pi(u.x);
    let across = DVec2::new(r * sc.y, r * sc.x) + stretched.truncate();
    let (a, z) = (alpha * across.length(), (z + stretched.z).max(1e-7));
    let squared = a * a + z * z;
    let angle = (a * delta_z + 2.0 * squared.sqrt() * alpha * delta_r) / squared;
    2.0 * angle + 32.0 * U
}

#[test]
fn visible_normals_are_the_twins() {
    let context = context();
    let points = edge_points();
    for alpha in ALPHAS.map(f32_of) {
        for degrees in DEGREES {
            let wo = direction(degrees, 0.7);
            let input = |u: &DVec2| [wo.x, wo.y, wo.z, alpha, u.x, u.y];
            let inputs: Vec<f64> = points.iter().flat_map(input).collect();
            let answers = call(context, &SAMPLE, &words(&inputs));
            for (u, h) in points.iter().zip(answers.vec3(0)) {
                let expected = sample_ggx_visible_normal(wo, alpha, *u);
                let bound = sample_bound(wo, alpha, *u);
                let off = (h - expected).length();
                assert!(
                    off <= bound && h.z > 0.0 && (h.length() - 1.0).abs() < 32.0 * U,
                    "{}: alpha {alpha}, {degrees} degrees: {u} goes to {h}, not {expected}: {off:.1e} > {bound:.1e}",
                    context.adapter.name
                );
            }
        }
    }
}

/// `w` with its tangential components scaled: by 1/α it leads to the configuration in which the
/// microsurface is a hemisphere.
fn stretch(w: DVec3, factor: f64) -> DVec3 {
    DVec3::new(factor * w.x, factor * w.y, w.z).normalize()
}

/// Density per solid angle of the reflection r of `wo` about the normal h, both in the
/// configuration where the microsurface is a hemisphere and r is uniform on a cap (Dupuy &
/// Benyoub): narrow lobes are resolved as well as wide ones. From `pdf_ggx`, by dω_i = 4(ω_o·h)
/// dω_h, dω_h = α²/|M n|³ dω_n with M = diag(α, α, 1), and dω_r = 4(s·n) dω_n.
fn cap_pdf(wo: DVec3, alpha: f64, r: DVec3) -> f64 {
    let s = stretch(wo, alpha);
    let Some(n) = (r + s).try_normalize().filter(|n| n.z > 0.0) else {
        return 0.0;
    };
    let m = DVec3::new(alpha * n.x, alpha * n.y, n.z);
    let h = m.normalize();
    let of_normal = pdf_ggx(wo, h, alpha).0 * 4.0 * wo.dot(h) * alpha * alpha / m.length().powi(3);
    of_normal / (4.0 * s.dot(n))
}

#[test]
fn visible_normals_match_pdf() {
    let context = context();
    for (seed, (alpha, degrees)) in (100_u32..).zip([
        (1.0, 0.0),
        (1.0, 60.0),
        (1.0, 89.99),
        (0.5, 45.0),
        (0.1, 80.0),
        (0.01, 89.0),
        (1e-4, 30.0),
        (1e-4, 89.99),
    ]) {
        let (alpha, wo) = (f32_of(alpha), direction(degrees, 0.7));
        let body = format!(
            "out_vec3f(0u, sample_ggx_visible_normal(
                 vec3f({:?}, {:?}, {:?}), {alpha:?}, to_unit_2d(pcg4d(vec4u(item, 7u, 8u, {seed}u)).xy)));",
            wo.x, wo.y, wo.z
        );
        let function = Function {
            imports: "import package::bsdf::ggx::sample_ggx_visible_normal;
                      import package::core::rng::{pcg4d, to_unit_2d};",
            body: &body,
            inputs: 0,
            outputs: 3,
            features: &[],
        };
        let s = stretch(wo, alpha);
        let reflect = |h: DVec3| {
            let n = stretch(h, 1.0 / alpha);
            2.0 * s.dot(n) * n - s
        };
        let samples: Vec<DVec3> = draw(context, &function, 1 << 20)
            .vec3(0)
            .map(reflect)
            .collect();
        let pdf = |r: DVec3| cap_pdf(wo, alpha, r);
        let what = format!(
            "sample_ggx_visible_normal, alpha {alpha}, {degrees} degrees, seed {seed}, {}",
            context.adapter.name
        );
        statistics::accept(histogram::directions_p_value(&samples, pdf), &what);
        for row in BROKEN_TWINS {
            let broken = match row.twin {
                BrokenTwin::PdfScaled => histogram::directions_p_value(&samples, |r| 1.02 * pdf(r)),
                // The density of the normal, taken for that of the reflected direction.
                BrokenTwin::WrongMeasure => histogram::directions_p_value(&samples, |r| {
                    pdf(r) * 4.0 * s.dot((r + s).normalize_or_zero())
                }),
                BrokenTwin::ExtraCosine => {
                    histogram::directions_p_value(&samples, |r| 2.0 * pdf(r) * r.z.abs())
                }
                BrokenTwin::SwappedSinCos => {
                    let swapped: Vec<DVec3> = samples
                        .iter()
                        .map(|r| BrokenTwin::direction(Some(row.twin), *r))
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

/// HARD CASES B2: ∫ D (ω_o·h)⁺ G1/cosθ_o dω_h = 1, that is, the density of visible normals.
/// Estimated over unstretched normals that are uniform on the hemisphere, where the integrand is
/// bounded.
#[test]
fn visible_normals_integrate_to_one() {
    let context = context();
    let cases = [
        (1.0, 0.0),
        (1.0, 80.0),
        (0.3, 60.0),
        (0.01, 45.0),
        (0.01, 89.9),
    ];
    for (seed, (alpha, degrees)) in (120_u32..).zip(cases) {
        let (alpha, wo) = (f32_of(alpha), direction(degrees, 0.7));
        let body = format!(
            "let wo = vec3f({:?}, {:?}, {:?});
             let s = sample_sphere_area(to_unit_2d(pcg4d(vec4u(item, 10u, 11u, {seed}u)).xy));
             let m = vec3f({alpha:?} * s.xy, max(abs(s.z), 1e-7));
             let h = normalize(m);
             let jacobian = {alpha:?} * {alpha:?} / (dot(m, m) * sqrt(dot(m, m)));
             let cos = max(dot(wo, h), 0.0);
             out_f32(0u, pdf_ggx(wo, h, {alpha:?}).value * 4.0 * cos * jacobian * TWO_PI);
             out_f32(1u, 4.0 * cos);
             out_f32(2u, h.z);",
            wo.x, wo.y, wo.z
        );
        let function = Function {
            imports: "import package::bsdf::ggx::pdf_ggx;
                      import package::core::constants::TWO_PI;
                      import package::core::rng::{pcg4d, to_unit_2d};
                      import package::light::sphere::sample_sphere_area;",
            body: &body,
            inputs: 0,
            outputs: 3,
            features: &[],
        };
        let answers = draw(context, &function, 1 << 20);
        let rows: Vec<(f64, f64, f64)> = answers
            .f64(0)
            .zip(answers.f64(1).zip(answers.f64(2)))
            .map(|(value, (jacobian, cos))| (value, jacobian, cos))
            .collect();
        // The bounds of the functions, as one bias of all samples: 128 roundings, and D's
        // sensitivity 2/α to the angle of h, known to 16.
        let allowance = (128.0 + 32.0 / alpha) * U;
        let p_value = |values: &mut dyn Iterator<Item = f64>| {
            let m: Moments = values.collect();
            z_test(m.mean, 1.0, m.variance_of_mean().unwrap(), allowance).p_value
        };
        let what = format!(
            "pdf_ggx, alpha {alpha}, {degrees} degrees, seed {seed}, {}",
            context.adapter.name
        );
        statistics::accept(p_value(&mut rows.iter().map(|r| r.0)), &what);
        for row in BROKEN_TWINS {
            let broken = match row.twin {
                BrokenTwin::PdfScaled => p_value(&mut rows.iter().map(|r| 1.02 * r.0)),
                BrokenTwin::WrongMeasure => p_value(&mut rows.iter().map(|r| r.0 / r.1.max(1e-9))),
                BrokenTwin::ExtraCosine => p_value(&mut rows.iter().map(|r| r.0 * r.2)),
                // No direction, no light and no strategy is chosen.
                BrokenTwin::SwappedSinCos
                | BrokenTwin::LightLeftOut
                | BrokenTwin::MisWeights
                | BrokenTwin::RaysForgotten
                | BrokenTwin::OpaqueShadows => {
                    continue;
                }
            };
            // At α = 0.01 normals are upright: their cosine is 1 up to 1e-4, as small as the error
            // of the mean.
            if row.twin != BrokenTwin::ExtraCosine || alpha > 0.1 {
                statistics::reject(broken, &format!("{what}, {}", row.name));
            }
        }
    }
}
