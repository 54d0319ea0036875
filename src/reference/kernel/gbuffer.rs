//! The surface in the middle of every pixel; see `shaders/kernel/gbuffer.wesl`.

use super::camera::camera_ray;
use crate::reference::scene::fetch::World;
use crate::reference::scene::opacity::Crossings;
use crate::reference::scene::surface::surface_at;
use crate::reference::scene::trace::closest_hit;
use crate::scene::FilmSize;
use glam::{DVec2, DVec3};

/// The middle of a pixel, 2⁻⁷ and 2⁻⁸ beside.
pub const MIDDLE: DVec2 = DVec2::new(0.507_812_5, 0.503_906_25);

/// The surface that a camera ray meets first, normalised space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceSeen {
    /// Point on the primitive.
    pub position: DVec3,
    /// The primitive.
    pub primitive: u32,
    /// Unit geometric normal, on the viewer's side.
    pub normal: DVec3,
}

/// The surface at the point `film` of the image, in pixels, through the centre of the lens;
/// `crossings` decides which surfaces with an opacity are passed.
pub fn surface_at_film(
    world: &World<'_>,
    size: FilmSize,
    film: DVec2,
    crossings: Crossings,
) -> Option<SurfaceSeen> {
    let ray = camera_ray(world, size, film, DVec2::splat(0.5));
    let hit = closest_hit(world, &ray, crossings)?;
    let s = surface_at(world, &ray, &hit, -ray.direction);
    Some(SurfaceSeen {
        position: s.position - s.lift,
        primitive: hit.primitive,
        normal: s.normal,
    })
}
