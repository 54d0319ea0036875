//! The camera of a scene that has none: the whole geometry fits the film.

use crate::scene::normalize::bounds;
use crate::scene::{Camera, FilmSize, Lens, Projection, Shape};
use glam::DVec3;

/// Vertical field of view of a framed camera, in degrees.
pub(super) const FOV_DEGREES: f64 = 40.0;
/// Part of the film's half width and half height that stays free on each side.
const MARGIN: f64 = 0.05;

/// A camera that looks along −z at the middle of the shapes' bounding box, from just as far away that the box's
/// front face fits the film with a margin.
pub(super) fn framed(shapes: &[Shape], film: FilmSize) -> Camera {
    let fov_y = FOV_DEGREES.to_radians();
    let (low, high) = bounds(shapes).unwrap_or((DVec3::NEG_ONE, DVec3::ONE));
    let (center, half) = (0.5 * (low + high), 0.5 * (high - low));
    let tangent_y = (0.5 * fov_y).tan() * (1.0 - MARGIN);
    let tangent_x = tangent_y * film.aspect();
    let mut distance = (half.x / tangent_x).max(half.y / tangent_y);
    if distance <= 1e-6 * half.max_element() || distance <= 0.0 {
        distance = if half.z > 0.0 { half.z } else { 1.0 };
    }
    Camera {
        eye: center + DVec3::Z * (half.z + distance),
        right: DVec3::X,
        up: DVec3::Y,
        forward: DVec3::NEG_Z,
        projection: Projection::Perspective { fov_y },
        lens: Lens::PINHOLE,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Geometry, MaterialId};

    fn sphere(center: DVec3, radius: f64) -> Shape {
        Shape {
            name: "sphere".to_owned(),
            geometry: Geometry::Sphere { center, radius },
            material: MaterialId(0),
            emission: None,
        }
    }

    #[test]
    fn the_box_fits_with_the_margin() {
        let shapes = [
            sphere(DVec3::new(5.0, 0.0, 0.0), 1.0),
            sphere(DVec3::new(-5.0, 2.0, 3.0), 1.0),
        ];
        for (width, height) in [(512, 512), (100, 400), (1920, 1080)] {
            let film = FilmSize { width, height };
            let camera = framed(&shapes, film);
            // Corners of the front face, in units of the film's half sides.
            let depth = camera.eye.z - 4.0;
            let y = 2.0 / depth / camera.half_height();
            let x = 6.0 / depth / camera.half_height() / film.aspect();
            assert!((x.max(y) - 0.95).abs() < 1e-12, "{x} {y}");
            assert_eq!(camera.eye.truncate(), glam::DVec2::new(0.0, 1.0));
        }
    }

    #[test]
    fn nothing_and_a_point_are_framed_too() {
        let film = FilmSize::default();
        assert!(framed(&[], film).eye.is_finite());
        let point = Shape {
            geometry: Geometry::Mesh(crate::scene::Mesh {
                positions: vec![DVec3::ONE],
                triangles: vec![[0; 3]],
                ..crate::scene::Mesh::default()
            }),
            ..sphere(DVec3::ZERO, 1.0)
        };
        assert_eq!(framed(&[point], film).eye, DVec3::new(1.0, 1.0, 2.0));
    }
}
