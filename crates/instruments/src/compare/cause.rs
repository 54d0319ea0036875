//! Why a sample differs, as far as its conditions tell.

use direkt::low_level::reference::Sample;

/// Differences below this need no reason: a few hundred roundings of an f32.
const UNREMARKABLE: f64 = 1e-4;
/// Angle by which rounding turns a direction, or the surface under a point, in the normalised
/// scene.
const ROUNDING: f64 = 5e-7;
/// How far rounding moves the decisions of a light tree, relative to the random words that are
/// left: the distance to a near light is known to 10⁻⁵, and of the words the first decisions leave
/// a part.
const CHOICE_ROUNDING: f64 = 1e-3;
/// A mechanism that predicts less than this part of a difference does not explain it: predictions
/// are rough.
const ROUGH: f64 = 1e-2;

/// A way in which rounding grows.
struct Mechanism {
    /// The relative difference that it can make.
    predicted: f64,
    /// In words.
    sentence: String,
}

/// A sentence on the likeliest cause of `difference`; `flip` where rays met something else.
pub(super) fn cause(sample: &Sample, difference: f64, flip: bool) -> String {
    if flip {
        return "a ray passes an edge, or starts on one, within the rounding of f32".to_owned();
    }
    if difference < UNREMARKABLE {
        return "rounding in f32".to_owned();
    }
    let largest = mechanisms(sample)
        .into_iter()
        .max_by(|a, b| a.predicted.total_cmp(&b.predicted))
        .filter(|m| m.predicted > ROUGH * difference);
    largest.map_or_else(
        || "neither a grazing angle, nor a narrow lobe, nor a cell's edge explains it".to_owned(),
        |m| m.sentence,
    )
}

fn mechanisms(sample: &Sample) -> Vec<Mechanism> {
    let c = &sample.conditions;
    let angle = (ROUNDING + c.normal_rounding) * c.spread;
    let mut found = Vec::new();
    let mut add = |at_light: f64, at_surface: f64, curvature: f64| {
        found.push(Mechanism {
            predicted: (ROUNDING / at_light.abs())
                .max(ROUNDING * curvature / (at_light * at_light)),
            sentence: format!("the light is seen edge-on (cosine {at_light:.1e})"),
        });
        found.push(Mechanism {
            predicted: angle / at_surface.abs(),
            sentence: format!("the light lies at the surface's horizon (cosine {at_surface:.1e})"),
        });
    };
    if sample.by_light.max_element() > 0.0 {
        add(c.light_cos_light, c.light_cos_surface, 0.0);
    }
    if sample.by_bsdf.max_element() > 0.0 {
        add(c.bsdf_cos_light, c.bsdf_cos_surface, c.bsdf_light_curvature);
    }
    if let Some(alpha) = c.alpha {
        found.push(Mechanism {
            // d ln D / dθ of GGX is largest near tanθ = α: about 2/α.
            predicted: 2.0 * angle / alpha,
            sentence: format!(
                "a GGX lobe of width α = {alpha} amplifies the rounding of directions"
            ),
        });
    }
    if c.choice_margin < CHOICE_ROUNDING {
        found.push(Mechanism {
            predicted: 1.0,
            sentence: format!(
                "the light tree chooses another light within rounding (a random word is {:.1e} of its range away)",
                c.choice_margin
            ),
        });
    }
    if c.spread > 1.0 {
        found.push(Mechanism {
            predicted: angle,
            sentence: format!(
                "curved mirrors and glass spread the rounding of directions {:.0} times",
                c.spread
            ),
        });
    }
    if c.cell_margin < 4.0 * angle {
        found.push(Mechanism {
            predicted: 1.0,
            sentence: "the direction crosses the edge of a sun, or of a cell of the sampling grid of the environment or of a textured light: the density jumps there".to_owned(),
        });
    }
    found
}
