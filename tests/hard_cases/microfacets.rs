//! GGX at grazing angles and where half vectors vanish, and light from below: HARD CASES B3, B4,
//! B6.

use crate::support::hard_cases::{Measured, survive};
use crate::support::random::direction;
use crate::support::rounding::U;
use crate::support::shader::{Answers, Function, call, words};
use crate::support::{context, edge_points, render, scene};
use glam::DVec3;

const IMPORTS: &str = "import package::bsdf::bsdf::{eval_bsdf, sample_bsdf};
    import package::scene::fetch::Material;
    fn textbook_d(cos_h: f32, alpha: f32) -> f32 {
        let d = cos_h * cos_h * (alpha * alpha - 1.0) + 1.0;
        return alpha * alpha / (3.14159265 * d * d);
    }
    fn textbook_lambda(cosine: f32, alpha: f32) -> f32 {
        return 0.5 * (sqrt(1.0 + alpha * alpha * (1.0 - cosine * cosine) / (cosine * cosine)) - 1.0);
    }
    // G₂|ω_o·h|/(cosθ_o cosθ_h), for normals with the density D cosθ_h.
    fn textbook_weight(wo: vec3f, alpha: f32, u: vec2f) -> f32 {
        let tan2 = alpha * alpha * u.x / (1.0 - u.x);
        let cos_h = 1.0 / sqrt(1.0 + tan2);
        let across = sqrt(tan2) * cos_h * vec2f(cos(6.28318531 * u.y), sin(6.28318531 * u.y));
        let h = vec3f(across, cos_h);
        let wi = 2.0 * dot(wo, h) * h - wo;
        let g = 1.0 / (1.0 + textbook_lambda(wi.z, alpha) + textbook_lambda(wo.z, alpha));
        return select(0.0, g * dot(wo, h) / (wo.z * h.z), wi.z > 0.0 && dot(wo, h) > 0.0);
    }
    fn textbook_f(wi: vec3f, wo: vec3f, alpha: f32) -> f32 {
        let h = normalize(wi + wo);
        let g = 1.0 / (1.0 + textbook_lambda(wi.z, alpha) + textbook_lambda(wo.z, alpha));
        return textbook_d(h.z, alpha) * g / (4.0 * wi.z * wo.z);
    }";

const ALPHAS: [f64; 4] = [1e-4, 1e-3, 0.1, 1.0];

/// A white conductor's weights F·G2/G1 are in [0, 1], up to the lobe's error in numerator and
/// denominator alike.
#[test]
fn weights_at_grazing_angles_are_between_0_and_1() {
    let context = context();
    let function = Function {
        imports: IMPORTS,
        body: "let alpha = in_f32(3u); let wo = in_vec3f(0u);
               let s = sample_bsdf(Material(vec3f(0.0), vec3f(1.0), alpha, 1.0, vec3f(0.0), 0u, vec3f(0.0), 1.0, vec3f(0.0)), wo, 0.0, in_vec2f(4u));
               out_f32(0u, s.weight.x);
               out_f32(1u, textbook_weight(wo, alpha, in_vec2f(4u)));",
        inputs: 6,
        outputs: 2,
        features: &["GLOSSY"],
    };
    let wo = direction(89.99, 0.7);
    let points = edge_points();
    let inputs: Vec<f64> = ALPHAS
        .iter()
        .flat_map(|&alpha| points.iter().map(move |u| (alpha, u)))
        .flat_map(|(alpha, u)| [wo.x, wo.y, wo.z, alpha, u.x, u.y])
        .collect();
    let answers = call(context, &function, &words(&inputs));
    let range = 0.0..=1.0 + 128.0 * U;
    let outside = |word| answers.f64(word).filter(|w| !range.contains(w)).count() as f64;
    survive(
        context,
        Measured {
            entry: "B3",
            case: "at 89.99°, α of 10⁻⁴, 10⁻³, 0.1 and 1",
            figure: "weights that are not in [0, 1]",
            bound: 0.0,
            textbook: "normals with the density D cosθ (Walter et al. 2007)",
            naive: outside(1),
            ours: outside(0),
        },
    );
}

/// ω_i = −ω_o but for heights down to 10⁻³⁰: of both the sum's tangential part is 0.
fn opposite(context: &direkt::low_level::gpu::Context) -> Answers {
    let function = Function {
        imports: IMPORTS,
        body: "let wi = in_vec3f(0u); let wo = vec3f(-wi.xy, wi.z); let alpha = in_f32(3u);
               let value = eval_bsdf(Material(vec3f(0.0), vec3f(1.0), alpha, 1.0, vec3f(0.0), 0u, vec3f(0.0), 1.0, vec3f(0.0)), wi, wo);
               out_f32(0u, value.f_cos.x);
               out_f32(1u, value.pdf.value);
               out_f32(2u, textbook_f(wi, wo, alpha) * wi.z);",
        inputs: 4,
        outputs: 3,
        features: &["GLOSSY"],
    };
    let heights = [
        1e-30, 1e-25, 1e-20, 1e-15, 1e-10, 1e-8, 1e-7, 1e-6, 1e-4, 0.1,
    ];
    let inputs: Vec<f64> = heights
        .iter()
        .flat_map(|&z: &f64| ALPHAS.map(|alpha| (z, alpha)))
        .flat_map(|(z, alpha)| {
            let w = DVec3::new(0.6, -0.8, z).normalize();
            [w.x, w.y, w.z, alpha]
        })
        .collect();
    call(context, &function, &words(&inputs))
}

#[test]
fn half_vectors_that_vanish_reflect_nothing() {
    let context = context();
    let answers = opposite(context);
    let broken = |word| {
        let values = answers.f64(word);
        values.filter(|x| !(x.is_finite() && *x >= 0.0)).count() as f64
    };
    survive(
        context,
        Measured {
            entry: "B4",
            case: "opposite directions, 10⁻³⁰ to 0.1 above the surface",
            figure: "values that are not finite",
            bound: 0.0,
            textbook: "h = (ω_i + ω_o)/|ω_i + ω_o|",
            naive: broken(2),
            ours: broken(0) + broken(1),
        },
    );
}

/// Surfaces have flat normals, so that the frame's horizon is the surface's.
#[test]
fn light_from_below_the_surface_is_not_reflected() {
    let context = context();
    let function = Function {
        imports: IMPORTS,
        body: "let m = Material(vec3f(in_f32(7u)), vec3f(0.04), in_f32(6u), 1.0, vec3f(0.0), 0u, vec3f(0.0), 1.0, vec3f(0.0));
               out_vec3f(0u, eval_bsdf(m, in_vec3f(0u), in_vec3f(3u)).f_cos);
               out_f32(3u, in_f32(7u) / 3.14159265 * abs(in_f32(2u)));",
        inputs: 8,
        outputs: 4,
        features: &["GLOSSY"],
    };
    let mut inputs = Vec::new();
    for degrees in [90.0 + 1e-5, 90.5, 91.0, 95.0, 100.0] {
        for (alpha, albedo) in [(0.0, 0.5), (0.1, 0.5), (1.0, 0.5)] {
            let (wi, wo) = (direction(degrees, 0.7), direction(30.0, 2.0));
            assert!(wi.z < 0.0);
            inputs.extend([wi.x, wi.y, wi.z, wo.x, wo.y, wo.z, alpha, albedo]);
        }
    }
    let answers = call(context, &function, &words(&inputs));
    survive(
        context,
        Measured {
            entry: "B6",
            case: "light from up to 10° below a flat surface",
            figure: "largest reflected share of the radiance, f_r·cosθ",
            bound: 0.0,
            textbook: "|n·ω_i| in place of n·ω_i",
            naive: answers.f64(3).fold(0.0, f64::max),
            ours: answers.vec3(0).map(|f| f.max_element()).fold(0.0, f64::max),
        },
    );
}

/// The floor's vertex normals lean 30° towards a light 10° below it: cos 70° of the shading normal
/// is light that leaks.
#[test]
fn light_does_not_leak_through_shading_normals() {
    let context = context();
    let scene = scene("scenes/tests/smooth_normals_from_below.toml");
    let irradiance = 10.0;
    let film = render(context, scene);
    let leaked = film.pixels[0].mean[0];
    let (sin, cos) = 10_f64.to_radians().sin_cos();
    let shading_normal = DVec3::new(0.5, 0.0, 0.75_f64.sqrt());
    survive(
        context,
        Measured {
            entry: "B6",
            case: "light 10° below a surface whose shading normal leans 30° towards it",
            figure: "radiance per ρE/π",
            bound: 0.0,
            textbook: "the cosine of the shading normal alone",
            naive: shading_normal.dot(DVec3::new(cos, 0.0, -sin)),
            ours: leaked / (0.5 * irradiance / std::f64::consts::PI),
        },
    );
}
