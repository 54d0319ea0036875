//! Intersection with planar primitives, by the plane's equation: another way than the shaders' edge
//! functions, so that a mistake in one is not repeated in the other.

use super::ray::Ray;
use glam::{DVec2, DVec3};

/// Where a ray meets a planar primitive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlanarHit {
    /// Whether it does, at any ray parameter.
    pub inside: bool,
    /// Whether it meets the front, to which u × v points.
    pub front: bool,
    /// Ray parameter.
    pub t: f64,
    /// Coordinates: the point is a + s·u + t·v.
    pub st: DVec2,
}

/// The plane through `a` with directions `u` and `v`; `None` where the ray runs within it.
fn intersect_plane(ray: &Ray, a: DVec3, u: DVec3, v: DVec3) -> Option<PlanarHit> {
    let normal = u.cross(v);
    let approach = ray.direction.dot(normal);
    if approach == 0.0 {
        return None;
    }
    let t = (a - ray.origin).dot(normal) / approach;
    let p = ray.origin + t * ray.direction - a;
    let squared = normal.length_squared();
    let st = DVec2::new(p.cross(v).dot(normal), u.cross(p).dot(normal)) / squared;
    Some(PlanarHit {
        inside: true,
        front: approach < 0.0,
        t,
        st,
    })
}

fn within(ray: &Ray, [a, u, v]: [DVec3; 3], inside: impl Fn(DVec2) -> bool) -> PlanarHit {
    match intersect_plane(ray, a, u, v) {
        Some(hit) => PlanarHit {
            inside: inside(hit.st),
            ..hit
        },
        None => PlanarHit {
            inside: false,
            front: false,
            t: f64::INFINITY,
            st: DVec2::ZERO,
        },
    }
}

/// The triangle a, a + u, a + v.
pub fn intersect_triangle(ray: &Ray, a: DVec3, u: DVec3, v: DVec3) -> PlanarHit {
    within(ray, [a, u, v], |st| {
        st.x >= 0.0 && st.y >= 0.0 && st.x + st.y <= 1.0
    })
}

/// The parallelogram with corner a and edges u and v.
pub fn intersect_rectangle(ray: &Ray, a: DVec3, u: DVec3, v: DVec3) -> PlanarHit {
    within(ray, [a, u, v], |st| {
        st.min_element() >= 0.0 && st.max_element() <= 1.0
    })
}

/// The ellipse with centre a and half axes u and v.
pub fn intersect_disk(ray: &Ray, a: DVec3, u: DVec3, v: DVec3) -> PlanarHit {
    within(ray, [a, u, v], |st| st.length_squared() <= 1.0)
}
