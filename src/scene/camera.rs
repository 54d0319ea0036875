//! Cameras: perspective and orthographic, each with a pinhole or a thin lens.

use glam::DVec3;

/// A camera: an eye, an orthonormal frame, a projection and a lens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Centre of the lens, world space; of an orthographic camera, the middle of the plane that its
    /// rays start on.
    pub eye: DVec3,
    /// Unit vector to the right of the image.
    pub right: DVec3,
    /// Unit vector to the top of the image.
    pub up: DVec3,
    /// Unit viewing direction; `right × up = −forward`.
    pub forward: DVec3,
    /// How points of the scene come to lie on the image.
    pub projection: Projection,
    /// What the rays of one point of the image start from.
    pub lens: Lens,
}

/// How points of the scene come to lie on the image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Projection {
    /// Through the eye.
    Perspective {
        /// Full vertical field of view in radians, in (0, π).
        fov_y: f64,
    },
    /// Along the viewing direction.
    Orthographic {
        /// Height of what is seen, world space; positive.
        height: f64,
    },
}

/// A thin lens around the eye, across the viewing direction (Potmesil & Chakravarty 1981, "A Lens
/// and Aperture Camera Model for Synthetic Image Generation"; Pharr et al. 2016, §6.2.3).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lens {
    /// Its radius, world space; 0 is a pinhole, which sees everything sharply.
    pub radius: f64,
    /// Distance from the eye, along the viewing direction, of the plane that is sharp; positive.
    pub focus_distance: f64,
}

impl Lens {
    /// Without extent.
    pub const PINHOLE: Self = Self {
        radius: 0.0,
        focus_distance: 1.0,
    };
}

impl Default for Camera {
    /// A pinhole at (0, 0, 4) that looks at the origin, +y up, with a vertical field of view of
    /// 40°.
    fn default() -> Self {
        Self {
            eye: 4.0 * DVec3::Z,
            right: DVec3::X,
            up: DVec3::Y,
            forward: DVec3::NEG_Z,
            projection: Projection::Perspective {
                fov_y: 40_f64.to_radians(),
            },
            lens: Lens::PINHOLE,
        }
    }
}

impl Camera {
    /// A pinhole camera at `eye` that looks at `target`.
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
            projection: Projection::Perspective { fov_y },
            lens: Lens::PINHOLE,
        };
        (eye.is_finite() && fov_y.is_finite()).then_some(camera)
    }

    /// Half the image's height: on the plane at distance 1 from the eye, or where the camera is
    /// orthographic, in world space.
    pub fn half_height(&self) -> f64 {
        match self.projection {
            Projection::Perspective { fov_y } => (0.5 * fov_y).tan(),
            Projection::Orthographic { height } => 0.5 * height,
        }
    }

    /// Whether its rays are parallel.
    pub fn is_orthographic(&self) -> bool {
        matches!(self.projection, Projection::Orthographic { .. })
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

    /// Index, row by row, of the pixel in column `x` and row `y`.
    pub fn index(self, (x, y): (u32, u32)) -> usize {
        y as usize * self.width as usize + x as usize
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
