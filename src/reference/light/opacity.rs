//! Lights whose surfaces have an opacity; see `shaders/light/opacity.wesl`.

use crate::accel::PrimitiveGeometry;
use crate::emitters::Emitter;
use crate::reference::core::ray::Ray;
use crate::reference::core::ray_planar::intersect_rectangle;
use crate::reference::scene::fetch::World;
use crate::reference::scene::opacity::opacity_at;
use glam::{DVec2, DVec3};

/// α of light `index` where it lies in the direction `wi` from `x`; 1 of one without an opacity.
pub fn light_opacity(world: &World<'_>, index: u32, x: DVec3, wi: DVec3) -> f64 {
    let Emitter::Area { primitive, .. } = world.prepared.emitters.lights[index as usize] else {
        return 1.0;
    };
    let p = &world.primitives[primitive as usize];
    if !p.attributed.opacity {
        return 1.0;
    }
    let ray = Ray {
        origin: x,
        direction: wi,
    };
    let st = match p.geometry {
        PrimitiveGeometry::Triangle { a, u, v }
        | PrimitiveGeometry::Rectangle { a, u, v }
        | PrimitiveGeometry::Disk { a, u, v } => intersect_rectangle(&ray, a, u, v).st,
        PrimitiveGeometry::Sphere { .. } | PrimitiveGeometry::Ellipsoid { .. } => DVec2::ZERO,
    };
    opacity_at(world, p, st)
}
