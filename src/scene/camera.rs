//! The pinhole camera.

use glam::DVec3;

/// A pinhole camera: an eye, an orthonormal frame and a vertical field of view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Centre of projection, world space.
    pub eye: DVec3,
    /// Unit vector to the right of the image.
    pub right: DVec3,
    /// Unit vector to the top of the image.
    pub up: DVec3,
    /// Unit viewing direction; `right × up = −forward`.
    pub forward: DVec3,
    /// Full vertical field of view in radians, in (0, π).
    pub fov_y: f64,
}

impl Camera {
    /// A camera at `eye` that looks at `target`.
    ///
    /// Where `up` is parallel to the viewing direction, the axis that is least parallel to it takes
    /// its place, so that a straight-down view is well defined.
    /// `None` when `eye` and `target` coincide or anything is not finite.
    pub fn look_at(eye: DVec3, target: DVec3, up: DVec3, fov_y: f64) -> Option<Self> {
        let forward = (target - eye).try_normalize()?;
        let right = forward
            .cross(up)
            .try_normalize()
            .filter(|_| forward.cross(up).length() > 1e-9 * up.length())
            .or_else(|| forward.cross(least_parallel_axis(forward)).try_normalize())?;
        let up = right.cross(forward);
        let camera = Self {
            eye,
            right,
            up,
            forward,
            fov_y,
        };
        (eye.is_finite() && fov_y.is_finite()).then_some(camera)
    }
}

fn least_parallel_axis(v: DVec3) -> DVec3 {
    let a = v.abs();
    if a.x <= a.y && a.x <= a.z {
        DVec3::X
    } else if a.y <= a.z {
        DVec3::Y
    } else {
        DVec3::Z
    }
}

/// Number of pixels of the image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FilmSize {
    /// Pixels per row, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
}

impl FilmSize {
    /// Longest side that is accepted.
    pub const MAX_SIDE: u32 = 32_768;

    /// Number of pixels.
    pub fn pixels(self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Width over height.
    pub fn aspect(self) -> f64 {
        f64::from(self.width) / f64::from(self.height)
    }
}

impl Default for FilmSize {
    fn default() -> Self {
        Self {
            width: 512,
            height: 512,
        }
    }
}
