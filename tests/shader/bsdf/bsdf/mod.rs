//! `shaders/bsdf/bsdf.wesl`.

use crate::support::rounding::U;
use crate::support::shader::{Answers, Function, draw};
use direkt::low_level::gpu::Context;
use direkt::low_level::gpu::layout::{
    COMPENSATED_BIT, FRESNEL_CONDUCTOR, FRESNEL_CONSTANT, FRESNEL_DIELECTRIC, FRESNEL_SCHLICK,
};
use direkt::scene::material::{BsdfParameters, Fresnel, SpecularLobe};
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
        specular: m.specular.map(|s| {
            let fresnel = match s.fresnel {
                Fresnel::Constant(reflectance) => Fresnel::Constant(v(reflectance)),
                Fresnel::Schlick { f0, f90 } => Fresnel::Schlick { f0: v(f0), f90 },
                Fresnel::Dielectric { ior } => Fresnel::Dielectric { ior },
                Fresnel::Conductor { eta, k } => Fresnel::Conductor {
                    eta: v(eta),
                    k: v(k),
                },
            };
            SpecularLobe {
                compensated: s.compensated,
                alpha: f64::from(s.alpha as f32),
                ..SpecularLobe::new(fresnel, 1.0)
            }
        }),
        transmission: None,
        unlit: false,
    }
}

fn lobe(diffuse: DVec3, fresnel: Fresnel, alpha: f64) -> BsdfParameters {
    rounded(BsdfParameters {
        diffuse,
        specular: Some(SpecularLobe::new(fresnel, alpha)),
        transmission: None,
        unlit: false,
    })
}

fn conductor(f0: DVec3, alpha: f64) -> BsdfParameters {
    lobe(DVec3::ZERO, Fresnel::Schlick { f0, f90: 1.0 }, alpha)
}

/// Gold, with Fresnel's equations.
fn metal(alpha: f64) -> BsdfParameters {
    let (eta, k) = direkt::scene::metals::Metal::Gold.index();
    lobe(DVec3::ZERO, Fresnel::Conductor { eta, k }, alpha)
}

/// A base under glass, with Fresnel's equations.
fn coated(diffuse: f64, alpha: f64) -> BsdfParameters {
    lobe(
        DVec3::splat(diffuse),
        Fresnel::Dielectric { ior: 1.5 },
        alpha,
    )
}

/// With the energy that its lobe leaves out.
fn compensated(mut m: BsdfParameters) -> BsdfParameters {
    m.specular = m.specular.map(|s| SpecularLobe {
        compensated: true,
        ..s
    });
    m
}

fn plastic(diffuse: f64, f0: f64, alpha: f64) -> BsdfParameters {
    let fresnel = Fresnel::Schlick {
        f0: DVec3::splat(f0),
        f90: 1.0,
    };
    lobe(DVec3::new(diffuse, 0.5 * diffuse, 0.0), fresnel, alpha)
}

fn diffuse(albedo: f64) -> BsdfParameters {
    rounded(BsdfParameters {
        diffuse: DVec3::splat(albedo),
        specular: None,
        transmission: None,
        unlit: false,
    })
}

/// Input words of a material.
const WORDS: usize = 16;

/// Reads them: what the shaders' `Material` holds.
const MATERIAL: &str =
    "let m = Material(in_vec3f(0u), in_vec3f(3u), in_f32(6u), in_f32(7u), in_vec3f(8u),
    u32(in_f32(11u)), vec3f(0.0), in_f32(12u), in_vec3f(13u));";

/// The features that every material needs, and those with the energy that lobes leave out.
const FEATURES: &[&str] = &["GLOSSY", "EXACT_DIELECTRIC", "EXACT_CONDUCTOR"];
const COMPENSATED: &[&str] = &[
    "GLOSSY",
    "EXACT_DIELECTRIC",
    "EXACT_CONDUCTOR",
    "ENERGY_COMPENSATION",
];

fn material_words(m: &BsdfParameters) -> Vec<f64> {
    let none = SpecularLobe::new(
        Fresnel::Schlick {
            f0: DVec3::ZERO,
            f90: 0.0,
        },
        0.0,
    );
    let lobe = m.specular.unwrap_or(none);
    let (kind, f0, f90, k, ior) = match lobe.fresnel {
        Fresnel::Constant(f) => (FRESNEL_CONSTANT, f, 0.0, DVec3::ZERO, 1.0),
        Fresnel::Schlick { f0, f90 } => (FRESNEL_SCHLICK, f0, f90, DVec3::ZERO, 1.0),
        Fresnel::Dielectric { ior } => (FRESNEL_DIELECTRIC, DVec3::ZERO, 0.0, DVec3::ZERO, ior),
        Fresnel::Conductor { eta, k } => (FRESNEL_CONDUCTOR, eta, 0.0, k, 1.0),
    };
    let flag = if lobe.compensated { COMPENSATED_BIT } else { 0 };
    let words = [
        &m.diffuse.to_array()[..],
        &f0.to_array(),
        &[lobe.alpha, f90],
        &k.to_array(),
        &[f64::from(kind | flag), ior],
        &lobe.average.to_array(),
    ];
    words.concat()
}

/// The same as an expression.
fn material_expression(m: &BsdfParameters) -> String {
    let w = material_words(m);
    format!(
        "Material(vec3f({:?}, {:?}, {:?}), vec3f({:?}, {:?}, {:?}), {:?}, {:?}, vec3f({:?}, {:?}, {:?}), {}u, vec3f(0.0),
         {:?}, vec3f({:?}, {:?}, {:?}))",
        w[0], w[1], w[2], w[3], w[4], w[5], w[6], w[7], w[8], w[9], w[10], w[11] as u32, w[12], w[13], w[14], w[15]
    )
}

/// Relative error of the GGX lobe: 128 roundings of its functions, and D's sensitivity 2/α to the
/// angle of h, which is known to 2 roundings over |ω_i + ω_o| and 16 of the normalisation. Twice
/// for second order.
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
        metal(0.01),
        metal(0.3),
        coated(0.6, 0.1),
        coated(1.0, 1.0),
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
        features: if m.specular.is_some_and(|s| s.compensated) {
            COMPENSATED
        } else {
            FEATURES
        },
    };
    draw(context, &function, 1 << 20)
}
