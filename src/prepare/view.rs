//! What a camera sees: where the film shows what, and how large.

use super::SceneData;
use super::near_plane::is_distant;
use crate::scene::{Camera, FilmSize};
use glam::{DVec2, DVec3};

/// What a camera sees, normalised space.
pub(super) struct View {
    pub(super) camera: Camera,
    /// Pixels per unit of the plane at distance 1, or where the camera is orthographic, of any.
    pub(super) scale: f64,
    pub(super) size: DVec2,
    /// How far from its middle a pixel's filter reaches, in pixels.
    pub(super) reach: f64,
    /// Whether small lights are left to chance: of a camera whose rays are parallel, or begin before
    /// the eye because that is far away.
    pub(super) leaves_small_lights: bool,
    /// How far from the eye anything is at most; 1 where rays are parallel.
    farthest: f64,
}

impl View {
    pub(super) fn new(camera: &Camera, size: FilmSize, data: &SceneData) -> Self {
        let distant = is_distant(&data.normalization, camera);
        let camera = data.normalization.camera(camera);
        let height = f64::from(size.height);
        Self {
            scale: 0.5 * height / camera.half_height(),
            leaves_small_lights: camera.is_orthographic() || distant,
            farthest: if camera.is_orthographic() {
                1.0
            } else {
                camera.eye.length() + data.normalization.reach
            },
            camera,
            size: DVec2::new(f64::from(size.width), height),
            reach: data.scene.filter.radius,
        }
    }

    /// How wide a pixel is at the distance of what is farthest away, with what the lens adds to it, and the
    /// same at distance 1.
    pub(super) fn pixel_widths(&self) -> [f64; 2] {
        let lens = self.camera.lens;
        let blur = if self.camera.is_orthographic() {
            0.0
        } else {
            2.0 * lens.radius / lens.focus_distance
        };
        let width = 1.0 / self.scale + blur;
        [width * self.farthest, width]
    }

    /// Whether the film shows what is infinitely far away in the unit direction `direction`; true where rays
    /// are parallel.
    pub(super) fn shows_direction(&self, direction: DVec3) -> bool {
        self.camera.is_orthographic()
            || direction.dot(self.camera.forward) > 0.0
                && (self.scale * self.project(direction))
                    .abs()
                    .cmple(0.5 * self.size)
                    .all()
    }

    /// The box on the film, in pixels, that holds the middles of all pixels that may show something
    /// within `outline`.
    pub(super) fn bounds(&self, outline: &Outline) -> (DVec2, DVec2) {
        let Outline {
            to_middle,
            radius,
            corners,
        } = *outline;
        let depth = to_middle.dot(self.camera.forward);
        let (nearest, farthest) = (depth - radius, depth + radius);
        let (low, high) = match corners.map(|c| c.map(|c| self.project(c))) {
            Some(seen) => (
                seen.into_iter().fold(seen[0], DVec2::min),
                seen.into_iter().fold(seen[0], DVec2::max),
            ),
            None => {
                let length = self.stretch(to_middle) / self.depth_that_counts(nearest);
                let (middle, extent) = (self.project(to_middle), DVec2::splat(length * radius));
                (middle - extent, middle + extent)
            }
        };
        let blur = self.scale * self.blur(nearest).max(self.blur(farthest));
        let around = DVec2::splat(blur + self.reach);
        let middle = 0.5 * self.size;
        (
            self.scale * low + middle - around,
            self.scale * high + middle + around,
        )
    }

    /// The depth by which lengths shrink: 1 where the camera is orthographic.
    pub(super) fn depth_that_counts(&self, depth: f64) -> f64 {
        if self.camera.is_orthographic() {
            1.0
        } else {
            depth
        }
    }

    /// Where the film shows what is at `p` from the eye, over the plane at distance 1, from its middle
    /// to the right and down.
    pub(super) fn project(&self, p: DVec3) -> DVec2 {
        let across = DVec2::new(p.dot(self.camera.right), -p.dot(self.camera.up));
        across / self.depth_that_counts(p.dot(self.camera.forward))
    }

    /// One over the squared cosine at the axis of the direction to `p`: lengths are so much larger on
    /// the film than in the middle, at the same depth. 1 where the camera is orthographic.
    pub(super) fn stretch(&self, p: DVec3) -> f64 {
        if self.camera.is_orthographic() {
            1.0
        } else {
            1.0 + self.project(p).length_squared()
        }
    }

    /// Of the way to `p`, by which solid angles are less than areas: 1 where the camera is orthographic.
    pub(super) fn squared_distance(&self, p: DVec3) -> f64 {
        if self.camera.is_orthographic() {
            1.0
        } else {
            p.length_squared()
        }
    }

    /// Radius of the circle of confusion at `depth`, over the plane at distance 1.
    pub(super) fn blur(&self, depth: f64) -> f64 {
        let lens = self.camera.lens;
        lens.radius * (1.0 - depth / lens.focus_distance).abs() / self.depth_that_counts(depth)
    }
}

/// What a light lies in, seen from the eye.
pub(super) struct Outline {
    /// Middle of a sphere.
    pub(super) to_middle: DVec3,
    pub(super) radius: f64,
    /// Corners of a shape that it lies in, where it is planar.
    pub(super) corners: Option<[DVec3; 4]>,
}
