//! The surface where a ray ended.

use super::attributes::{
    fetch_colors, fetch_normals, fetch_tangents, interpolate_color, interpolate_normal,
    interpolate_uv, map_normal, map_normal_along, seen_normal, terminator_offset, uvs_of,
};
use super::fetch::{Primitive, World};
use super::textured::{mapped_normal, texture_factors, textured_material};
use crate::accel::PrimitiveGeometry;
use crate::reference::core::frame::{ShadingFrame, frame_from_normal, to_local};
use crate::reference::core::math::max_abs;
use crate::reference::core::ray::{Hit, Ray};
use crate::reference::core::ray_ellipsoid::ellipsoid_normal;
use crate::reference::light::ellipsoid::Ellipsoid;
use crate::scene::material::BsdfParameters;
use crate::scene::texture::TexturedFactors;
use glam::{DVec2, DVec3};

/// Rays leave a surface from points this far off it, relative to the size of its coordinates: as
/// far as on the GPU, so that both see the same where surfaces touch.
pub const OFFSET: f64 = 1.0 / 1_048_576.0;

/// A point on a surface, seen from the direction `wo`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surface {
    /// Position; with vertex normals it is lifted to the smooth surface.
    pub position: DVec3,
    /// The point from which rays leave on the side of `wo`.
    pub origin: DVec3,
    /// Frame around the shading normal, on the side of `wo`.
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
    /// Geometric normal, on the side of `wo`.
    pub normal: DVec3,
    /// Cosine between it and `wo`.
    pub cos_o: f64,
    /// What `position` and `origin` are lifted off the primitive by.
    pub lift: DVec3,
}

/// What shading sees of a surface, on the front of the primitive.
struct Shading {
    /// Where it is another than the geometric normal.
    normal: Option<DVec3>,
    /// What lifts the point off the primitive.
    offset: DVec3,
    material: BsdfParameters,
}

/// The shading of the point `st` of `p`, whose edges are u and v and whose normal is `normal`, seen
/// from the front (`side`
/// 1) or the back (−1).
fn shading_at(
    world: &World<'_>,
    p: &Primitive,
    st: DVec2,
    [u, v, normal]: [DVec3; 3],
    side: f64,
) -> Shading {
    let mut shading = Shading {
        normal: None,
        offset: DVec3::ZERO,
        material: p.material,
    };
    if p.attributed.normals {
        let normals = fetch_normals(world, p);
        shading.normal = Some(interpolate_normal(&normals, st, normal));
        let offset = terminator_offset(&normals, st, u, v, side);
        if side * offset.dot(normal) >= 0.0 {
            shading.offset = offset;
        }
    }
    let material = &world.prepared.data.scene.materials[p.material_id.index()];
    let mut factors = TexturedFactors::default();
    if p.attributed.colors {
        factors.color = interpolate_color(&fetch_colors(world, p), st).truncate();
    }
    if p.attributed.uvs {
        factors = texture_factors(world, factors, material, p, st);
        if let Some(map) = &material.textures.normal {
            let uvs = uvs_of(world, p, &map.texture);
            let mapped = mapped_normal(world, map, interpolate_uv(&uvs, st));
            let around = shading.normal.unwrap_or(normal);
            shading.normal = Some(if p.attributed.tangents {
                map_normal_along(mapped, &fetch_tangents(world, p), st, around)
            } else {
                map_normal(mapped, &uvs, u, v, around)
            });
        }
    }
    if p.attributed.uvs || p.attributed.colors {
        shading.material = textured_material(material, &p.material, &factors);
    }
    shading
}

/// Position, edges (none) and normal, and size of the coordinates where `ray` met an ellipsoid at
/// `hit`.
fn ellipsoid_surface(
    geometry: &PrimitiveGeometry,
    ray: &Ray,
    hit: &Hit,
) -> (DVec3, [DVec3; 3], f64) {
    let ellipsoid = Ellipsoid::of(geometry).expect("the geometry is an ellipsoid");
    let on_ray = ray.origin + hit.t * ray.direction;
    let on_sphere = (ellipsoid.axes.inverse() * (on_ray - ellipsoid.center)).normalize();
    let normal = ellipsoid_normal(ellipsoid.axes, on_sphere);
    (
        ellipsoid.point(on_sphere),
        [DVec3::ZERO, DVec3::ZERO, normal],
        ellipsoid.extent(),
    )
}

/// The surface that `ray` met at `hit`, seen from `wo`.
pub fn surface_at(world: &World<'_>, ray: &Ray, hit: &Hit, wo: DVec3) -> Surface {
    let p = &world.primitives[hit.primitive as usize];
    let (position, [u, v, normal], extent) = match p.geometry {
        PrimitiveGeometry::Triangle { a, u, v }
        | PrimitiveGeometry::Rectangle { a, u, v }
        | PrimitiveGeometry::Disk { a, u, v } => (
            a + hit.st.x * u + hit.st.y * v,
            [u, v, u.cross(v).normalize()],
            max_abs(a).max(max_abs(a + u)).max(max_abs(a + v)),
        ),
        PrimitiveGeometry::Sphere { center, radius } => {
            let normal = (ray.origin + hit.t * ray.direction - center).normalize();
            let extent = max_abs(center) + radius;
            (
                center + radius * normal,
                [DVec3::ZERO, DVec3::ZERO, normal],
                extent,
            )
        }
        PrimitiveGeometry::Ellipsoid { .. } => ellipsoid_surface(&p.geometry, ray, hit),
    };
    let flat = !matches!(
        p.geometry,
        PrimitiveGeometry::Sphere { .. } | PrimitiveGeometry::Ellipsoid { .. }
    );
    let front = normal.dot(wo) >= 0.0;
    let side = if front { 1.0 } else { -1.0 };
    let facing = side * normal;
    let shading = shading_at(world, p, hit.st, [u, v, normal], side);
    let frame_normal = shading.normal.map_or(facing, |n| seen_normal(side * n, wo));
    let frame = frame_from_normal(frame_normal);
    let position = position + shading.offset;
    Surface {
        position,
        origin: position + facing * (extent * OFFSET),
        frame,
        wo: to_local(&frame, wo),
        material: shading.material,
        light: p.light,
        own_light: p.light.filter(|_| flat),
        front,
        normal: facing,
        cos_o: facing.dot(wo),
        lift: shading.offset,
    }
}

/// Whether light from the unit direction `wi` reaches the side that is seen.
pub fn is_above(s: &Surface, wi: DVec3) -> bool {
    s.normal.dot(wi) > 0.0
}

/// The segment from a surface to a point above its plane, parameter 0 to 1, which never comes
/// nearer to the plane than it begins.
pub fn shadow_ray(s: &Surface, target_point: DVec3) -> Ray {
    let segment = target_point - s.origin;
    Ray {
        origin: s.origin,
        direction: segment + s.normal * (-s.normal.dot(segment)).max(0.0),
    }
}
