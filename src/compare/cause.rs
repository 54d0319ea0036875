//! Why a sample differs, as far as its conditions tell.

use crate::reference::{Sample, Shadow};

/// Cosines below this lose more than three digits of f32's seven.
const GRAZING: f64 = 1e-3;
/// Lobes below this width do.
const NARROW: f64 = 0.1;

/// A sentence on the likeliest cause of a difference; `flip` where rays met something else.
pub(super) fn cause(sample: &Sample, flip: bool) -> String {
    if flip {
        return "a ray passes an edge, or starts on one, within the rounding of f32".to_owned();
    }
    let c = &sample.conditions;
    let by_light = sample.path.shadow == Shadow::Clear;
    let cosines = [
        (by_light, c.light_cos_light, "the light that was sampled is seen edge-on"),
        (by_light, c.light_cos_surface, "the sampled light lies at the surface's horizon"),
        (!by_light, c.bsdf_cos_light, "the light that the BSDF-sampled ray met is seen edge-on"),
        (!by_light, c.bsdf_cos_surface, "the BSDF-sampled ray leaves along the surface"),
    ];
    let grazing = cosines
        .iter()
        .filter(|(applies, cosine, _)| *applies && cosine.abs() < GRAZING)
        .min_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
    match (grazing, c.alpha) {
        (Some((_, cosine, what)), _) => {
            format!("{what} (cosine {cosine:.1e}), and f32 cannot resolve the angle")
        }
        (None, Some(alpha)) if alpha < NARROW => {
            format!("a GGX lobe of width α = {alpha} amplifies the rounding of directions")
        }
        _ => "neither a grazing angle nor a narrow lobe explains it".to_owned(),
    }
}
