//! A direction towards a light, and what arrives from there.

use crate::reference::core::pdf::{PdfArea, PdfDiscrete, PdfSolidAngle};
use glam::DVec3;

/// Length beyond everything in the normalised scene.
pub const FAR: f64 = 4.0;

/// A direction towards a light, seen from a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightSample {
    /// Unit direction.
    pub wi: DVec3,
    /// Where the shadow ray ends: off the light, towards the point.
    pub target_point: DVec3,
    /// Radiance divided by the density of this sample, light selection included (for lights without
    /// extent: irradiance on a surface that faces the light, divided by the probability of the
    /// light); 0 where nothing arrives.
    pub radiance_over_pdf: DVec3,
    /// Density with which the sample was chosen, light selection included; 0 for lights without
    /// extent.
    pub pdf: PdfSolidAngle,
    /// Density of a uniform point on the light's surface, or with which one was chosen on the unit
    /// square of the environment's directions, without light selection; none for lights that have
    /// neither.
    pub pdf_on_light: Option<PdfArea>,
    /// Cosine at the light; 1 where it has no surface.
    pub cos_light: f64,
    /// Whether only light sampling can reach the light.
    pub delta: bool,
}

impl LightSample {
    /// A sample from which nothing arrives.
    pub const NONE: Self = Self {
        wi: DVec3::Z,
        target_point: DVec3::ZERO,
        radiance_over_pdf: DVec3::ZERO,
        pdf: PdfSolidAngle(0.0),
        pdf_on_light: None,
        cos_light: 1.0,
        delta: false,
    };

    /// Light from the only direction `wi` of a light without extent.
    pub fn delta(wi: DVec3, target_point: DVec3, radiance_over_pdf: DVec3) -> Self {
        Self {
            wi,
            target_point,
            radiance_over_pdf,
            delta: true,
            ..Self::NONE
        }
    }

    /// Light that arrives at `x` from the point `position`, chosen with the probability `choice`;
    /// `intensity` gives its radiant intensity by the direction from `x`.
    pub fn from_point(
        position: DVec3,
        choice: PdfDiscrete,
        x: DVec3,
        intensity: impl FnOnce(DVec3) -> DVec3,
    ) -> Self {
        let d = position - x;
        d.try_normalize().map_or(Self::NONE, |wi| {
            Self::delta(
                wi,
                position,
                intensity(wi) / (d.length_squared() * choice.0),
            )
        })
    }
}
