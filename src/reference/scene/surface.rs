//! The surface where a ray ended.

use super::fetch::World;
use crate::accel::PrimitiveGeometry;
use crate::reference::core::frame::{ShadingFrame, frame_from_normal, to_local};
use crate::reference::core::math::max_abs;
use crate::reference::core::ray::{Hit, Ray};
use crate::scene::material::BsdfParameters;
use glam::DVec3;

/// Rays leave a surface from points this far off it, relative to the size of its coordinates: as far as on the GPU, so
/// that both see the same where surfaces touch.
pub const OFFSET: f64 = 1.0 / 1_048_576.0;

/// A point on a surface, seen from the direction `wo`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surface {
    /// Position.
    pub position: DVec3,
    /// The point from which rays leave on the side of `wo`.
    pub origin: DVec3,
    /// Frame around the geometric normal, on the side of `wo`.
    pub frame: ShadingFrame,
    /// Direction towards the viewer, local frame; z ≥ 0.
    pub wo: DVec3,
    /// How it scatters.
    pub material: BsdfParameters,
    /// Index of the light that the surface belongs to.
    pub light: Option<u32>,
    /// The same where that light is flat, so that it does not shine on the surface.
    pub own_light: Option<u32>,
    /// Whether the viewer is on the front.
    pub front: bool,
}

/// The surface that `ray` met at `hit`, seen from `wo`.
pub fn surface_at(world: &World<'_>, ray: &Ray, hit: &Hit, wo: DVec3) -> Surface {
    let p = &world.primitives[hit.primitive as usize];
    let (position, normal, extent) = match p.geometry {
        PrimitiveGeometry::Triangle { a, u, v }
        | PrimitiveGeometry::Rectangle { a, u, v }
        | PrimitiveGeometry::Disk { a, u, v } => (
            a + hit.st.x * u + hit.st.y * v,
            u.cross(v).normalize(),
            max_abs(a).max(max_abs(a + u)).max(max_abs(a + v)),
        ),
        PrimitiveGeometry::Sphere { center, radius } => {
            let normal = (ray.origin + hit.t * ray.direction - center).normalize();
            (center + radius * normal, normal, max_abs(center) + radius)
        }
    };
    let flat = !matches!(p.geometry, PrimitiveGeometry::Sphere { .. });
    let front = normal.dot(wo) >= 0.0;
    let facing = if front { normal } else { -normal };
    let frame = frame_from_normal(facing);
    Surface {
        position,
        origin: position + facing * (extent * OFFSET),
        frame,
        wo: to_local(&frame, wo),
        material: p.material,
        light: p.light,
        own_light: p.light.filter(|_| flat),
        front,
    }
}

/// The segment from a surface to a point above its plane, parameter 0 to 1, which never comes nearer to the plane than it
/// begins.
pub fn shadow_ray(s: &Surface, target_point: DVec3) -> Ray {
    let segment = target_point - s.origin;
    Ray {
        origin: s.origin,
        direction: segment + s.frame.z * (-s.frame.z.dot(segment)).max(0.0),
    }
}
