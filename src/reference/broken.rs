//! Broken twins: the reference with one mistake of the kind that renderers ship. Every statistical
//! test and every part of `direkt compare` is run against them and has to reject them; a check that
//! accepts one checks nothing.

use super::core::pdf::{PdfArea, PdfDiscrete, PdfSolidAngle, chosen};
use super::scene::opacity::Crossings;
use crate::effects::Effect;
use crate::emitters::Emitter;
use crate::prepare::Prepared;
use glam::DVec3;

/// A mistake.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum BrokenTwin {
    /// Every sampling density is 2 % too large
    PdfScaled,
    /// Densities per area are taken for densities per solid angle
    WrongMeasure,
    /// Sine and cosine of the polar angle are swapped in a surface's local frame
    SwappedSinCos,
    /// Light selection never chooses the likeliest light, and no other light makes up for it
    LightLeftOut,
    /// The MIS weights of a direction sum to 0.98
    MisWeights,
    /// Reflected light is multiplied by the surface's cosine once more
    ExtraCosine,
    /// The MIS weights of BSDF samples take several shadow rays for one
    RaysForgotten,
    /// Shadow rays are stopped by every surface, whatever its opacity
    OpaqueShadows,
}

/// A row of the table.
#[derive(Debug, Clone, Copy)]
pub struct Row {
    /// The mistake.
    pub twin: BrokenTwin,
    /// Its name, as `--break` takes it.
    pub name: &'static str,
    /// What is wrong.
    pub description: &'static str,
    /// Whether a render of this scene runs the code with the mistake.
    pub applies: fn(&Prepared) -> bool,
}

/// The table of all broken twins.
pub const BROKEN_TWINS: &[Row] = &[
    Row {
        twin: BrokenTwin::PdfScaled,
        name: "pdf-scaled",
        description: "every sampling density is 2 % too large",
        applies: samples_anything,
    },
    Row {
        twin: BrokenTwin::WrongMeasure,
        name: "wrong-measure",
        description: "densities per area of lights, or of the unit square behind the environment, are taken for densities per solid angle",
        applies: |p| {
            let mut lights = p.emitters.lights.iter().enumerate();
            lights.any(|(i, light)| {
                let has_measure = !matches!(light, Emitter::Delta(_));
                has_measure && p.emitters.probability(i) > 0.0
            })
        },
    },
    Row {
        twin: BrokenTwin::SwappedSinCos,
        name: "swapped-sin-cos",
        description: "sine and cosine of the polar angle are swapped in a surface's local frame",
        applies: samples_anything,
    },
    Row {
        twin: BrokenTwin::LightLeftOut,
        name: "light-left-out",
        description: "light selection never chooses the likeliest light, and no other light makes up for it",
        applies: |p| p.effects.contains(Effect::SampleLights),
    },
    Row {
        twin: BrokenTwin::MisWeights,
        name: "mis-weights",
        description: "the MIS weights of a direction sum to 0.98",
        applies: |p| {
            p.effects.contains(Effect::SampleLights) && p.effects.contains(Effect::SampleBsdf)
        },
    },
    Row {
        twin: BrokenTwin::ExtraCosine,
        name: "extra-cosine",
        description: "reflected light is multiplied by the surface's cosine once more",
        applies: samples_anything,
    },
    Row {
        twin: BrokenTwin::RaysForgotten,
        name: "rays-forgotten",
        description: "the MIS weights of BSDF samples take several shadow rays for one",
        applies: |p| {
            let extended = |light: &Emitter| !matches!(light, Emitter::Delta(_));
            p.shadow_rays() > 1
                && p.effects.contains(Effect::SampleBsdf)
                && p.emitters.sampled().any(extended)
        },
    },
    Row {
        twin: BrokenTwin::OpaqueShadows,
        name: "opaque-shadows",
        description: "shadow rays are stopped by every surface, whatever its opacity",
        applies: |p| p.effects.contains(Effect::Alpha) && p.effects.contains(Effect::SampleLights),
    },
];

fn samples_anything(p: &Prepared) -> bool {
    p.effects.contains(Effect::SampleLights) || p.effects.contains(Effect::SampleBsdf)
}

impl BrokenTwin {
    /// Its row of the table.
    pub fn row(self) -> &'static Row {
        let row = BROKEN_TWINS.iter().find(|row| row.twin == self);
        row.expect("every broken twin is in the table")
    }
}

/// Where the mistakes are made. `None` is the honest twin: every method then returns what it is
/// given.
impl BrokenTwin {
    /// A sampling density.
    pub fn density(broken: Option<Self>, pdf: PdfSolidAngle) -> PdfSolidAngle {
        match broken {
            Some(Self::PdfScaled) => PdfSolidAngle(1.02 * pdf.0),
            _ => pdf,
        }
    }

    /// The density per solid angle of a point chosen with density `on_light` on a light.
    pub fn measure(
        broken: Option<Self>,
        choice: PdfDiscrete,
        on_light: Option<PdfArea>,
        right: PdfSolidAngle,
    ) -> PdfSolidAngle {
        match (broken, on_light) {
            (Some(Self::WrongMeasure), Some(pdf)) => chosen(choice, PdfSolidAngle(pdf.0)),
            _ => right,
        }
    }

    /// A direction in the local frame, between the frame and the BSDF. Directions below the horizon
    /// stay there.
    pub fn direction(broken: Option<Self>, w: DVec3) -> DVec3 {
        let sin = w.truncate().length();
        match broken {
            Some(Self::SwappedSinCos) if sin > 0.0 && w.z > 0.0 => {
                (w.truncate() * (w.z / sin)).extend(sin)
            }
            _ => w,
        }
    }

    /// A MIS weight.
    pub fn weight(broken: Option<Self>, weight: f64) -> f64 {
        match broken {
            Some(Self::MisWeights) => 0.98 * weight,
            _ => weight,
        }
    }

    /// Shadow rays in the MIS weight of a BSDF sample.
    pub fn rays(broken: Option<Self>, rays: u32) -> u32 {
        match broken {
            Some(Self::RaysForgotten) => 1,
            _ => rays,
        }
    }

    /// What decides which surfaces stop a shadow ray.
    pub fn crossings(broken: Option<Self>, crossings: Crossings) -> Crossings {
        match broken {
            Some(Self::OpaqueShadows) => Crossings::OPAQUE,
            _ => crossings,
        }
    }

    /// f_r · cosθ_i at cosine `cos_i`.
    pub fn f_cos(broken: Option<Self>, f_cos: DVec3, cos_i: f64) -> DVec3 {
        match broken {
            Some(Self::ExtraCosine) => f_cos * cos_i,
            _ => f_cos,
        }
    }
}
