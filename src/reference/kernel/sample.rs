//! What a sample found: see `shaders/kernel/sample_record.wesl`.

use super::feature_record::Features;
use glam::DVec3;

/// How the shadow rays of a sample ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Shadow {
    /// Those that were traced: where nothing could have arrived, none is.
    pub traced: u32,
    /// Those of them that met nothing.
    pub clear: u32,
}

/// How a BSDF-sampled ray ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum BsdfRay {
    /// None was traced: nothing could have arrived.
    #[default]
    NotTraced,
    /// It left the scene.
    Missed,
    /// It met a primitive.
    Hit(u32),
}

/// What the rays of one sample met.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Path {
    /// What the camera ray met; where it went on, a hash of all that it met.
    pub camera: Option<u32>,
    /// Rays with which it went on.
    pub further_rays: u32,
    /// The shadow rays.
    pub shadow: Shadow,
    /// The BSDF-sampled ray.
    pub bsdf: BsdfRay,
}

/// What makes a sample sensitive to rounding: cosines near zero and narrow lobes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conditions {
    /// Smallest cosine at the surface of the directions in which light sampling found light.
    pub light_cos_surface: f64,
    /// Smallest cosine there at the lights.
    pub light_cos_light: f64,
    /// Cosine at the surface of the direction chosen by BSDF sampling.
    pub bsdf_cos_surface: f64,
    /// Cosine at the light that it met.
    pub bsdf_cos_light: f64,
    /// Distance to that light over its radius of curvature where it is a sphere or an ellipsoid,
    /// else 0: an angle moves the cosine by so much over the cosine itself.
    pub bsdf_light_curvature: f64,
    /// GGX width of the surface.
    pub alpha: Option<f64>,
    /// Factor by which the specular surfaces before it have spread the camera ray's angle, at least 1.
    pub spread: f64,
    /// Angle by which rounding its vertices to f32 turns the surface's normal.
    pub normal_rounding: f64,
    /// Angle between the BSDF-sampled direction and the edge of its cell in the sampling grid of
    /// the environment, or of the textured light that it met.
    pub cell_margin: f64,
    /// Least distance of a random word from where a decision of the light tree changes, relative to
    /// the words it is one of.
    pub choice_margin: f64,
}

impl Default for Conditions {
    fn default() -> Self {
        Self {
            light_cos_surface: 1.0,
            light_cos_light: 1.0,
            bsdf_cos_surface: 1.0,
            bsdf_cos_light: 1.0,
            bsdf_light_curvature: 0.0,
            alpha: None,
            spread: 1.0,
            normal_rounding: 0.0,
            cell_margin: std::f64::consts::PI,
            choice_margin: 1.0,
        }
    }
}

impl Conditions {
    /// A direction in which light sampling found light.
    pub fn add_light(&mut self, cos_surface: f64, cos_light: f64) {
        self.light_cos_surface = self.light_cos_surface.min(cos_surface);
        self.light_cos_light = self.light_cos_light.min(cos_light);
    }
}

/// One sample of a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sample {
    /// Radiance.
    pub radiance: DVec3,
    /// The part of it that light sampling found.
    pub by_light: DVec3,
    /// The part that BSDF sampling found.
    pub by_bsdf: DVec3,
    /// What its rays met.
    pub path: Path,
    /// How sensitive it is to rounding.
    pub conditions: Conditions,
    /// What it shows a denoiser.
    pub features: Features,
}
