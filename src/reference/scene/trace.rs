//! Rays against the scene.

use super::fetch::{Primitive, World};
use super::opacity::{CROSSING_FIRST, CROSSING_SECOND, Crossings, opacity_at};
use crate::accel::PrimitiveGeometry;
use crate::accel::octahedral::octahedral;
use crate::effects::Effect;
use crate::reference::core::bvh::{Aabb, Children, enter_box};
use crate::reference::core::ray::{Hit, Ray};
use crate::reference::core::ray_ellipsoid::intersect_ellipsoid;
use crate::reference::core::ray_planar::{
    PlanarHit, intersect_disk, intersect_rectangle, intersect_triangle,
};
use crate::reference::core::ray_sphere::intersect_sphere;
use crate::reference::light::ellipsoid::Ellipsoid;
use glam::DVec2;

/// Nodes that wait for their turn: room for all of them in most scenes.
const PENDING: usize = 32;

/// Ray parameter and coordinates at which the ray meets the primitive in (0, t_max).
pub fn intersect_primitive(ray: &Ray, p: &Primitive, t_max: f64) -> Option<(f64, DVec2)> {
    let planar = |hit: PlanarHit| {
        let visible = hit.inside && (hit.front || !p.one_sided);
        (visible && hit.t > 0.0 && hit.t < t_max).then_some((hit.t, hit.st))
    };
    match p.geometry {
        PrimitiveGeometry::Triangle { a, u, v } => planar(intersect_triangle(ray, a, u, v)),
        PrimitiveGeometry::Rectangle { a, u, v } => planar(intersect_rectangle(ray, a, u, v)),
        PrimitiveGeometry::Disk { a, u, v } => planar(intersect_disk(ray, a, u, v)),
        PrimitiveGeometry::Sphere { .. } | PrimitiveGeometry::Ellipsoid { .. } => {
            let [near, far] = crossings_of(ray, &p.geometry)?;
            let enters = near.0 > 0.0;
            let (t, st) = if enters { near } else { far };
            let visible = t > 0.0 && t < t_max && (enters || !p.one_sided);
            visible.then_some((t, st))
        }
    }
}

/// Ray parameters and coordinates where the ray's line enters and leaves a sphere or an ellipsoid;
/// `None` where it misses, and for planar primitives.
fn crossings_of(ray: &Ray, geometry: &PrimitiveGeometry) -> Option<[(f64, DVec2); 2]> {
    if let PrimitiveGeometry::Sphere { center, radius } = *geometry {
        let (near, far) = intersect_sphere(ray, center, radius)?;
        return Some([(near, DVec2::ZERO), (far, DVec2::ZERO)]);
    }
    let ellipsoid = Ellipsoid::of(geometry)?;
    let (near, far) = intersect_ellipsoid(ray, ellipsoid.center, ellipsoid.axes)?;
    Some([near, far].map(|(t, p)| (t, octahedral(p))))
}

/// Where primitive `index` stops the ray in (0, t_max): one without an opacity wherever it is met.
pub fn stop_at_primitive(
    world: &World<'_>,
    ray: &Ray,
    crossings: Crossings,
    index: u32,
    t_max: f64,
) -> Option<(f64, DVec2)> {
    let p = &world.primitives[index as usize];
    let met = intersect_primitive(ray, p, t_max)?;
    if !p.attributed.opacity {
        return Some(met);
    }
    let alpha = opacity_at(world, p, met.1);
    let Some([near, far]) = crossings_of(ray, &p.geometry) else {
        let stopped = crossings.is_stopped(alpha, index, CROSSING_FIRST);
        return stopped.then_some(met);
    };
    let met = [
        (near, CROSSING_FIRST, true),
        (far, CROSSING_SECOND, !p.one_sided),
    ];
    let mut met = met.into_iter();
    let stop = met.find(|&((t, _), crossing, exists)| {
        exists && t > 0.0 && t < t_max && crossings.is_stopped(alpha, index, crossing)
    });
    stop.map(|(at, ..)| at)
}

/// Walks the hierarchy for the nearest intersection with parameter in (0, t_max), or for any.
fn traverse(
    world: &World<'_>,
    ray: &Ray,
    crossings: Crossings,
    t_max: f64,
    stop_at_any: bool,
) -> Option<Hit> {
    if world.bvh.nodes.is_empty() {
        return None;
    }
    let inv_direction = ray.direction.recip();
    let mut nearest: Option<Hit> = None;
    let mut pending = Vec::with_capacity(PENDING);
    pending.push((0_u32, 0.0_f64));
    while let Some((index, enter)) = pending.pop() {
        let limit = nearest.map_or(t_max, |h| h.t);
        if enter > limit {
            continue;
        }
        match world.bvh.nodes[index as usize].children {
            Children::Leaf(first, end) => {
                for &i in &world.bvh.order[first as usize..end as usize] {
                    let limit = nearest.map_or(t_max, |h| h.t);
                    if let Some((t, st)) = stop_at_primitive(world, ray, crossings, i, limit) {
                        nearest = Some(Hit {
                            t,
                            primitive: i,
                            st,
                        });
                    }
                }
                if stop_at_any && nearest.is_some() {
                    return nearest;
                }
            }
            Children::Inner(a, b) => {
                let enter = |child: u32| {
                    let aabb = &world.bvh.nodes[child as usize].aabb;
                    Some((child, enter_box(ray.origin, inv_direction, aabb, limit)?))
                };
                match (enter(a), enter(b)) {
                    (Some(a), Some(b)) if a.1 <= b.1 => pending.extend([b, a]),
                    (a, b) => pending.extend(a.into_iter().chain(b)),
                }
            }
        }
    }
    nearest
}

/// Whether the ray enters the box of a primitive that emits, or in a specialized kernel would meet
/// one if nothing lay before it: it meets no light otherwise. The GPU's boxes are wider.
pub fn may_meet_light(world: &World<'_>, ray: &Ray) -> bool {
    let mut emitting = world.primitives.iter().filter(|p| p.light.is_some());
    if world.prepared.effects.contains(Effect::SpecializedScene) {
        return emitting.any(|p| intersect_primitive(ray, p, f64::INFINITY).is_some());
    }
    let inv_direction = ray.direction.recip();
    emitting.any(|p| {
        let (low, high) = p.geometry.bounds();
        let aabb = Aabb { low, high };
        enter_box(ray.origin, inv_direction, &aabb, f64::INFINITY).is_some()
    })
}

/// The nearest intersection with parameter in (0, ∞) that stops the ray.
pub fn closest_hit(world: &World<'_>, ray: &Ray, crossings: Crossings) -> Option<Hit> {
    traverse(world, ray, crossings, f64::INFINITY, false)
}

/// Whether anything stops the ray with parameter in (0, t_max).
pub fn any_hit(world: &World<'_>, ray: &Ray, crossings: Crossings, t_max: f64) -> bool {
    traverse(world, ray, crossings, t_max, true).is_some()
}
