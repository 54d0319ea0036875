//! The BSDF of a material: a Lambert lobe under a GGX lobe, in the local frame.
//! f_r = (1 − F) diffuse/π + F·D·G2 / (4 cosθ_i cosθ_o).

use super::compensation::{compensation_albedo, eval_compensation};
use super::fresnel::fresnel;
use super::ggx::{eval_ggx, pdf_ggx, sample_ggx_visible_normal};
use super::lambert::{eval_lambert, pdf_lambert, sample_lambert, sample_uniform_hemisphere};
use crate::reference::core::math::luminance;
use crate::reference::core::pdf::PdfSolidAngle;
use crate::scene::material::{BsdfParameters, Fresnel, SpecularLobe};
use glam::{DVec2, DVec3};

/// Value and density for one pair of directions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BsdfValue {
    /// f_r · cosθ_i.
    pub f_cos: DVec3,
    /// Density with which [`sample_bsdf`] chooses this direction.
    pub pdf: PdfSolidAngle,
}

/// A sampled direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BsdfSample {
    /// Unit direction, local frame; z > 0 unless the sample failed.
    pub wi: DVec3,
    /// f_r · cosθ_i / pdf; 0 where the sample failed.
    pub weight: DVec3,
    /// Density.
    pub pdf: PdfSolidAngle,
    /// Whether the GGX lobe was chosen.
    pub specular: bool,
}

/// Probability of sampling the GGX lobe: its share of the reflected luminance, estimated at the
/// mirror direction.
pub fn specular_share(diffuse: DVec3, lobe: &SpecularLobe, cos_o: f64) -> f64 {
    let f = fresnel(&lobe.fresnel, cos_o);
    let s = luminance(f);
    let d = luminance((DVec3::ONE - f) * diffuse + compensation_albedo(lobe, cos_o));
    s / (s + d).max(1e-20)
}

/// The part of light that reaches what lies under `lobe` and comes out again.
pub fn under_lobe(lobe: &SpecularLobe, wi: DVec3, wo: DVec3) -> DVec3 {
    let passes = |cos: f64| DVec3::ONE - fresnel(&lobe.fresnel, cos);
    match lobe.fresnel {
        Fresnel::Dielectric { .. } => {
            let mean = (DVec3::ONE - lobe.average).max(DVec3::splat(1e-6));
            passes(wi.z) * passes(wo.z) / mean
        }
        _ => passes(0.5 * (wi + wo).length()),
    }
}

/// Value and density of the direction `wi` for the viewer `wo`.
pub fn eval_bsdf(m: &BsdfParameters, wi: DVec3, wo: DVec3) -> BsdfValue {
    if wi.z <= 0.0 || wo.z <= 0.0 {
        return BsdfValue {
            f_cos: DVec3::ZERO,
            pdf: PdfSolidAngle(0.0),
        };
    }
    let diffuse = eval_lambert(m.diffuse);
    let pdf_diffuse = pdf_lambert(wi.z);
    let half = (wi + wo).try_normalize();
    let (Some(lobe), Some(h)) = (&m.specular, half) else {
        return BsdfValue {
            f_cos: diffuse * wi.z,
            pdf: pdf_diffuse,
        };
    };
    let base = under_lobe(lobe, wi, wo) * diffuse;
    if lobe.alpha <= 0.0 {
        return BsdfValue {
            f_cos: base * wi.z,
            pdf: pdf_diffuse,
        };
    }
    let base = base + eval_compensation(lobe, wi.z, wo.z);
    let f = fresnel(&lobe.fresnel, 0.5 * (wi + wo).length());
    let share = specular_share(m.diffuse, lobe, wo.z);
    let pdf_specular = pdf_ggx(wo, h, lobe.alpha);
    BsdfValue {
        f_cos: (f * eval_ggx(wi, wo, h, lobe.alpha) + base) * wi.z,
        pdf: PdfSolidAngle((1.0 - share) * pdf_diffuse.0 + share * pdf_specular.0),
    }
}

/// `lobe` chooses the lobe, `u` the direction.
pub fn sample_bsdf(m: &BsdfParameters, wo: DVec3, lobe: f64, u: DVec2) -> BsdfSample {
    let mut wi = sample_lambert(u);
    let specular = m
        .specular
        .as_ref()
        .filter(|s| s.alpha > 0.0 && lobe < specular_share(m.diffuse, s, wo.z));
    if let Some(s) = specular {
        let h = sample_ggx_visible_normal(wo, s.alpha, u);
        wi = 2.0 * wo.dot(h) * h - wo;
    }
    let value = eval_bsdf(m, wi, wo);
    let weight = if value.pdf.0 > 0.0 {
        value.f_cos / value.pdf.0
    } else {
        DVec3::ZERO
    };
    BsdfSample {
        wi,
        weight,
        pdf: value.pdf,
        specular: specular.is_some(),
    }
}

/// Directions that are chosen without regard to the BSDF.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Hemisphere {
    /// Uniformly.
    Uniform,
    /// In proportion to the cosine.
    Cosine,
}

/// Density of [`sample_hemisphere`] at the cosine `cos` > 0.
pub fn pdf_hemisphere(how: Hemisphere, cos: f64) -> PdfSolidAngle {
    match how {
        Hemisphere::Uniform => PdfSolidAngle(1.0 / std::f64::consts::TAU),
        Hemisphere::Cosine => pdf_lambert(cos),
    }
}

/// A direction chosen without regard to the BSDF, with its value.
pub fn sample_hemisphere(m: &BsdfParameters, wo: DVec3, how: Hemisphere, u: DVec2) -> BsdfSample {
    let wi = match how {
        Hemisphere::Uniform => sample_uniform_hemisphere(u),
        Hemisphere::Cosine => sample_lambert(u),
    };
    let pdf = pdf_hemisphere(how, wi.z);
    BsdfSample {
        wi,
        weight: eval_bsdf(m, wi, wo).f_cos / pdf.0.max(1e-20),
        pdf,
        specular: false,
    }
}
