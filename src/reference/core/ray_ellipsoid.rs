//! Intersection with an ellipsoid, the image M·p + center of the unit sphere |p| = 1.

use super::ray::Ray;
use super::ray_sphere::intersect_sphere;
use glam::{DMat3, DVec3};

/// Ray parameter and point of the unit sphere.
pub type EllipsoidHit = (f64, DVec3);

/// Where a ray's line enters and leaves it, found in the sphere's space; `None` where it misses.
pub fn intersect_ellipsoid(
    ray: &Ray,
    center: DVec3,
    axes: DMat3,
) -> Option<(EllipsoidHit, EllipsoidHit)> {
    let to_sphere = axes.inverse();
    let ray = Ray {
        origin: to_sphere * (ray.origin - center),
        direction: to_sphere * ray.direction,
    };
    let (near, far) = intersect_sphere(&ray, DVec3::ZERO, 1.0)?;
    let hit = |t: f64| (t, (ray.origin + t * ray.direction).normalize());
    Some((hit(near), hit(far)))
}

/// The outward unit normal at the image of the unit sphere's point `p`: by the inverse transpose.
pub fn ellipsoid_normal(axes: DMat3, p: DVec3) -> DVec3 {
    (axes.inverse().transpose() * p).normalize()
}
