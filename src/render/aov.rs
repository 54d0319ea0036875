//! Images beside radiance that have rays of their own; `docs/aov.md` says what they hold.
//!
//! What a denoiser asks for is averaged along the camera paths of the image's first samples,
//! through mirrors and glass. What a compositor asks for is that of one ray per pixel, through the
//! middle of pixel and lens, and not averaged: a mean of positions or of numbers is that of no
//! surface.

use crate::error::GpuError;
use crate::gpu::Context;
use crate::gpu::features::{self, Features};
use crate::gpu::layout::{NONE, SurfaceRecord};
use crate::prepare::Prepared;
use crate::scene::{FilmSize, MaterialId, ShapeId};
use glam::DVec3;

/// Most samples that features are averaged over: their noise at edges is then an eighth of the
/// contrast there or less.
pub const FEATURE_SAMPLES: u64 = 64;

/// The surface in the middle of a pixel, world space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// Where it is, in the scene file's unit.
    pub position: DVec3,
    /// Distance from the plane through the eye, along the viewing direction, in the same unit.
    pub depth: f64,
    /// Unit geometric normal, on the viewer's side.
    pub normal: DVec3,
    /// The shape.
    pub shape: ShapeId,
    /// Its material.
    pub material: MaterialId,
}

/// What was asked for; images are row by row from the top.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct AovImages {
    /// Means of features.
    pub features: Option<Vec<Features>>,
    /// Samples that they were averaged over.
    pub feature_samples: u64,
    /// Surfaces; none where the ray meets nothing.
    pub surfaces: Option<Vec<Option<SurfacePoint>>>,
}

/// Renders the AOVs of `prepared` that have rays of their own, for an image that has `samples`
/// samples per pixel; none for one without.
///
/// # Errors
/// The scene is too large for the adapter, or the driver fails.
pub fn render_aovs(
    context: &Context,
    prepared: &Prepared,
    (film, seed): (FilmSize, u32),
    samples: u64,
) -> Result<AovImages, GpuError> {
    let aovs = prepared.settings.aovs;
    let mut images = AovImages::default();
    if samples == 0 {
        return Ok(images);
    }
    if aovs.has_features() {
        images.feature_samples = samples.min(FEATURE_SAMPLES);
        let samples = images.feature_samples;
        let features = features::features(context, prepared, (film, seed), samples)?;
        images.features = Some(features);
    }
    if aovs.has_gbuffer() {
        let records = features::surfaces(context, prepared, (film, seed))?;
        let points = records.iter().map(|record| surface_point(prepared, record));
        images.surfaces = Some(points.collect());
    }
    Ok(images)
}

/// A record in world space; `None` where nothing was met.
pub fn surface_point(prepared: &Prepared, record: &SurfaceRecord) -> Option<SurfacePoint> {
    if record.primitive == NONE {
        return None;
    }
    let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    let primitive = &prepared.data.primitives[record.primitive as usize];
    let position = prepared
        .data
        .normalization
        .point_in_world(vector(record.position));
    let camera = &prepared.camera;
    Some(SurfacePoint {
        position,
        depth: (position - camera.eye).dot(camera.forward),
        normal: vector(record.normal),
        shape: primitive.shape,
        material: primitive.material,
    })
}
