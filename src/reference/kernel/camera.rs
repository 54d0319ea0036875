//! The pinhole camera.

use crate::reference::core::ray::Ray;
use crate::reference::scene::fetch::World;
use crate::scene::FilmSize;
use glam::DVec2;

/// The ray through the point `film` of the image, in pixels from the upper left corner; unit direction, normalised
/// space.
pub fn camera_ray(world: &World<'_>, size: FilmSize, film: DVec2) -> Ray {
    let camera = &world.prepared.scene.camera;
    let half_height = (0.5 * camera.fov_y).tan();
    let x = (2.0 * film.x / f64::from(size.width) - 1.0) * half_height * size.aspect();
    let y = (1.0 - 2.0 * film.y / f64::from(size.height)) * half_height;
    let direction = camera.forward + x * camera.right + y * camera.up;
    Ray {
        origin: world.prepared.normalization.point(camera.eye),
        direction: direction.normalize(),
    }
}
