//! Cameras: perspective and orthographic, each with a pinhole or a thin lens.

use crate::reference::core::ray::Ray;
use crate::reference::light::disk::sample_disk_area;
use crate::reference::scene::fetch::World;
use crate::scene::FilmSize;
use glam::DVec2;

/// The ray through the point `film` of the image, in pixels from the upper left corner, and through
/// the point of the lens that `lens` of the unit square maps to; unit direction, normalised space.
/// All rays of a point of the image meet on the plane at the focus distance.
pub fn camera_ray(world: &World<'_>, size: FilmSize, film: DVec2, lens: DVec2) -> Ray {
    let prepared = world.prepared;
    let camera = prepared.data.normalization.camera(&prepared.camera);
    let half_height = camera.half_height();
    let x = (2.0 * film.x / f64::from(size.width) - 1.0) * half_height * size.aspect();
    let y = (1.0 - 2.0 * film.y / f64::from(size.height)) * half_height;
    let across = x * camera.right + y * camera.up;
    let on_disk = sample_disk_area(lens);
    let aside = camera.lens.radius * (on_disk.x * camera.right + on_disk.y * camera.up);
    let turned = aside / camera.lens.focus_distance;
    if camera.is_orthographic() {
        return Ray {
            origin: camera.eye + across + aside,
            direction: (camera.forward - turned).normalize(),
        };
    }
    Ray {
        origin: camera.eye + aside,
        direction: (camera.forward + across - turned).normalize(),
    }
}
