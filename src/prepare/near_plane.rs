//! Where the rays of a distant camera begin.
//!
//! Directions in f32 are off by 2⁻²⁴: a thousand sizes of the scene away from it, where they lead
//! is off by 2⁻¹⁴ of its size, and at a million the image is lost. The rays of such a camera begin
//! on a plane across its view, before all that it sees; where on the plane is computed from the
//! film, not from directions.

use super::Prepared;
use crate::accel::Primitive;
use crate::scene::normalize::Normalization;
use crate::scene::{Camera, FilmSize};
use glam::DVec3;

/// Distance of the eye from the centre, over the radius of what is rendered, beyond which a camera
/// is distant.
const DISTANT: f64 = 1024.0;
/// What the image is taken for: twice as wide and high, so that every pixel filter lies within.
const WIDER: f64 = 2.0;
/// The plane lies this part of its distance before what is seen.
const MARGIN: f64 = 1.0 / 65_536.0;

impl Prepared {
    /// Distance from the eye, along the viewing direction, of the plane on which camera rays begin,
    /// normalised space; 0 where that is the eye's.
    pub fn near_plane(&self) -> f64 {
        let camera = self.data.normalization.camera(&self.camera);
        if !is_distant(&self.data.normalization, &self.camera) {
            return 0.0;
        }
        let view = Frustum::new(camera, self.film);
        let depths = self.data.primitives.iter().filter_map(|p| view.depth(p));
        let depth = depths.fold(f64::INFINITY, f64::min);
        if depth.is_finite() {
            (depth * (1.0 - MARGIN)).max(0.0)
        } else {
            0.0
        }
    }
}

/// Whether rays of `camera` begin nearer than its eye.
pub fn is_distant(normalization: &Normalization, camera: &Camera) -> bool {
    normalization.point(camera.eye).length() > DISTANT * normalization.radius
}

/// What a camera may see.
struct Frustum {
    camera: Camera,
    /// Half the image's width and height, as [`Camera::half_height`].
    half: [f64; 2],
}

impl Frustum {
    fn new(camera: Camera, film: FilmSize) -> Self {
        let half = WIDER * camera.half_height();
        Self {
            half: [half * film.aspect(), half],
            camera,
        }
    }

    /// The smallest depth of the box around `primitive`, which may be negative; `None` where the
    /// camera does not see it.
    fn depth(&self, primitive: &Primitive) -> Option<f64> {
        let (low, high) = primitive.geometry.bounds();
        let middle = 0.5 * (low + high) - self.camera.eye;
        let half = 0.5 * (high - low);
        // Half the extent of the box along a vector.
        let extent = |v: DVec3| v.abs().dot(half);
        let depth = middle.dot(self.camera.forward);
        let farthest = depth + extent(self.camera.forward);
        if farthest <= 0.0 {
            return None;
        }
        let lens = self.camera.lens;
        let blur = lens.radius * (1.0 + farthest / lens.focus_distance);
        let axes = [self.camera.right, self.camera.up];
        let seen = axes.into_iter().zip(self.half).all(|(axis, half)| {
            let across = if self.camera.is_orthographic() {
                half
            } else {
                half * farthest
            };
            middle.dot(axis).abs() - extent(axis) <= across + blur
        });
        seen.then(|| depth - extent(self.camera.forward))
    }
}
