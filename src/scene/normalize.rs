//! Moves and scales a scene for f32.
//!
//! On the GPU, coordinates are f32. Before they are rounded, the centre of the geometry is
//! subtracted in f64 and everything is scaled by a power of two so that it lies in [−1, 1]: a scene
//! far from the origin, or of any size, loses no more than one near it. Radiance does not change;
//! the intensity of a point light grows with the square of the scale.
//!
//! A scene that is larger than the detail in view by more than [`EXTREME_RATIO`] is *extreme*: in
//! [−1, 1] rounding would swallow that detail. Its centre is what the camera sees, and its unit the
//! length that matters there. f32 rounds relative to the distance from the centre, so the far parts
//! lose no more than the near ones as the camera sees them.

use super::ellipsoid::half_extent;
use super::view::View;
use super::{Camera, Geometry, Lens, Projection, Scene, Shape};
use glam::DVec3;

/// Size of a scene over the smallest length that matters in view beyond which the scene is extreme.
/// Rays leave a surface 2⁻²⁰ of its coordinates off it: at this ratio 2⁻⁸ of that length.
pub const EXTREME_RATIO: f64 = 4096.0;
/// Largest coordinate of an extreme scene, normalised space: the fourth power of an edge, the
/// squared length of a normal that is not normalised, is finite in f32.
const MAX_REACH: f64 = 1_073_741_824.0;
/// Smallest length that matters in view of an extreme scene, normalised space: 2⁻⁶⁰, whose square
/// is normal in f32.
const MIN_RADIUS: f64 = 1.0 / (1_u64 << 60) as f64;

/// The map from world space to normalised space: `(p − center) · scale`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Normalization {
    /// Centre of the geometry, world space.
    pub center: DVec3,
    /// A power of two.
    pub scale: f64,
    /// Radius of what is rendered, normalised space: half the longest side of the geometry's box,
    /// above ½ and at most 1; 1 without geometry. In an extreme scene the smallest length that
    /// matters in view.
    pub radius: f64,
    /// Largest coordinate of the geometry, normalised space: 1 unless the scene is extreme.
    pub reach: f64,
}

impl Normalization {
    /// The normalisation of a scene; that of one without geometry moves the eye to the origin.
    pub fn of(scene: &Scene) -> Self {
        Self::for_camera(scene, &scene.camera)
    }

    /// The same where `camera` takes the place of the scene's.
    pub fn for_camera(scene: &Scene, camera: &Camera) -> Self {
        let Some((low, high)) = bounds(&scene.shapes) else {
            return Self {
                center: camera.eye,
                scale: 1.0,
                radius: 1.0,
                reach: 1.0,
            };
        };
        let half = 0.5 * (high - low).max_element();
        if let Some(view) = View::below(scene, camera, half / EXTREME_RATIO) {
            return Self::around(&view, (low, high));
        }
        let scale = to_one(half);
        Self {
            center: 0.5 * (low + high),
            scale,
            radius: if half > 0.0 { half * scale } else { 1.0 },
            reach: 1.0,
        }
    }

    /// The normalisation of an extreme scene between the corners `low` and `high`.
    fn around(view: &View, (low, high): (DVec3, DVec3)) -> Self {
        let farthest = (low - view.center).abs().max((high - view.center).abs());
        let farthest = farthest.max_element();
        let scale = to_one(view.scale).min(to_one(farthest) * MAX_REACH);
        Self {
            center: view.center,
            scale,
            radius: (view.scale * scale).max(MIN_RADIUS),
            reach: farthest * scale,
        }
    }

    /// Whether the scene is extreme: its coordinates go beyond [−1, 1].
    pub fn is_extreme(&self) -> bool {
        self.reach > 1.0
    }

    /// A point of world space in normalised space.
    pub fn point(&self, p: DVec3) -> DVec3 {
        (p - self.center) * self.scale
    }

    /// A point of normalised space in world space.
    pub fn point_in_world(&self, p: DVec3) -> DVec3 {
        p / self.scale + self.center
    }

    /// A vector of world space in normalised space.
    pub fn vector(&self, v: DVec3) -> DVec3 {
        v * self.scale
    }

    /// A length of world space in normalised space.
    pub fn length(&self, length: f64) -> f64 {
        length * self.scale
    }

    /// A camera of world space in normalised space.
    pub fn camera(&self, camera: &Camera) -> Camera {
        Camera {
            eye: self.point(camera.eye),
            projection: match camera.projection {
                Projection::Perspective { .. } => camera.projection,
                Projection::Orthographic { height } => Projection::Orthographic {
                    height: self.length(height),
                },
            },
            lens: Lens {
                radius: self.length(camera.lens.radius),
                focus_distance: self.length(camera.lens.focus_distance),
            },
            ..*camera
        }
    }

    /// The intensity of a light without extent, so that I/d² stays the same.
    pub fn intensity(&self, intensity: DVec3) -> DVec3 {
        intensity * (self.scale * self.scale)
    }
}

/// The power of two that maps `length` to (½, 1]; 1 for lengths of 0.
fn to_one(length: f64) -> f64 {
    let exponent = if length > 0.0 {
        -length.log2().ceil()
    } else {
        0.0
    };
    exponent.clamp(-1000.0, 1000.0).exp2()
}

/// The axis-parallel box around all `shapes`; `None` where there is none.
pub fn bounds<'a>(shapes: impl IntoIterator<Item = &'a Shape>) -> Option<(DVec3, DVec3)> {
    let mut low = DVec3::INFINITY;
    let mut high = DVec3::NEG_INFINITY;
    let mut add = |p: DVec3| {
        low = low.min(p);
        high = high.max(p);
    };
    for shape in shapes {
        match &shape.geometry {
            Geometry::Rectangle { corner, u, v } => {
                for p in [*corner, corner + u, corner + v, corner + u + v] {
                    add(p);
                }
            }
            Geometry::Disk { center, u, v } => {
                let half = disk_half_extent(*u, *v);
                add(center - half);
                add(center + half);
            }
            Geometry::Sphere { center, radius } => {
                add(center - DVec3::splat(*radius));
                add(center + DVec3::splat(*radius));
            }
            Geometry::Ellipsoid { center, axes } => {
                let half = half_extent(*axes);
                add(center - half);
                add(center + half);
            }
            Geometry::Mesh(mesh) => {
                if let Some((low, high)) = mesh.bounds() {
                    add(low);
                    add(high);
                }
            }
        }
    }
    (low.x <= high.x).then_some((low, high))
}

/// Half the size of the box around the ellipse with half axes `u` and `v`: per axis √(u² + v²).
pub fn disk_half_extent(u: DVec3, v: DVec3) -> DVec3 {
    let squared = u * u + v * v;
    DVec3::new(squared.x.sqrt(), squared.y.sqrt(), squared.z.sqrt())
}
