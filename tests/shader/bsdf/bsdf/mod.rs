//! `shaders/bsdf/bsdf.wesl`.

use crate::support::rounding::U;
use crate::support::shader::{Answers, Function, draw};
use direkt::gpu::Context;
use direkt::scene::material::{BsdfParameters, SpecularLobe};
use glam::DVec3;

mod sampling;
mod values;

const IMPORTS: &str = "import package::bsdf::bsdf::{eval_bsdf, sample_bsdf, specular_share};
    import package::core::rng::{pcg4d, to_unit, to_unit_2d};
    import package::scene::fetch::Material;";

fn rounded(m: BsdfParameters) -> BsdfParameters {
    let v = crate::support::random::rounded;
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
    let half_vector = (2.0 / (wi + wo).length() + 16.0) * U;
    128.0 * U + 4.0 / alpha * half_vector
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
