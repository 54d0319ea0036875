//! Intersection with a sphere.

use super::ray::Ray;
use glam::DVec3;

/// Both ray parameters, near first; `None` where the ray's line misses.
pub fn intersect_sphere(ray: &Ray, center: DVec3, radius: f64) -> Option<(f64, f64)> {
    let a = ray.direction.length_squared();
    let oc = center - ray.origin;
    let b = oc.dot(ray.direction) / a;
    let closest = oc - b * ray.direction;
    let discriminant = (radius * radius - closest.length_squared()) / a;
    if discriminant < 0.0 {
        return None;
    }
    let root = discriminant.sqrt();
    let c = (oc.length_squared() - radius * radius) / a;
    let q = if b >= 0.0 { b + root } else { b - root };
    if q == 0.0 {
        return None;
    }
    let other = c / q;
    Some((q.min(other), q.max(other)))
}
