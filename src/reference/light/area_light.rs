//! Sampling of lights with a surface: uniformly over its area, or over the solid angle in which a
//! point sees it.

use super::disk::{pdf_disk_area, sample_disk_area};
use super::ellipsoid::{Ellipsoid, EllipsoidView, pdf_ellipsoid_area, view_ellipsoid};
use super::emission::{emission_factor, emission_map, invert_light_area, pdf_emission};
use super::polygon::{ProjectedPolygon, project_polygon, sample_projected_polygon};
use super::rectangle::{
    pdf_rectangle_area, sample_parallelogram_solid_angle, sample_rectangle_area,
    sample_rectangle_solid_angle, spherical_parallelogram, spherical_rectangle,
};
use super::sample::LightSample;
use super::sphere::{
    cone_height, distance_within_sphere, pdf_sphere_area, sample_cone, sample_sphere_area,
    within_sphere,
};
use super::tree::pdf_tree_light;
use super::triangle::{
    pdf_triangle_area, pdf_uniform_solid_angle, sample_triangle_area, sample_triangle_solid_angle,
    spherical_triangle,
};
use crate::accel::PrimitiveGeometry;
use crate::effects::Effect;
use crate::emitters::{EmissionMap, Emitter, Selection};
use crate::reference::bsdf::lambert::{pdf_lambert, sample_lambert};
use crate::reference::core::frame::{ShadingFrame, to_local, to_world};
use crate::reference::core::math::max_abs;
use crate::reference::core::octahedral::from_octahedral;
use crate::reference::core::pdf::{
    PdfArea, PdfDiscrete, PdfSolidAngle, area_to_solid_angle, chosen,
};
use crate::reference::core::ray_ellipsoid::ellipsoid_normal;
use crate::reference::scene::fetch::World;
use crate::reference::scene::surface::OFFSET;
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// Solid angles below this are sampled by area.
pub const MIN_SOLID_ANGLE: f64 = 1e-5;

/// A light with a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AreaLight {
    /// Its geometry.
    pub geometry: PrimitiveGeometry,
    /// Emitted radiance.
    pub radiance: DVec3,
    /// Whether its back emits as well.
    pub two_sided: bool,
    /// Whether it is sampled over its solid angle.
    pub by_solid_angle: bool,
    /// Whether that is projected.
    pub projected: bool,
}

/// Light `index`, which has a surface.
pub fn area_light(world: &World<'_>, index: u32) -> AreaLight {
    let prepared = world.prepared;
    let Emitter::Area {
        primitive,
        radiance,
        two_sided,
        ..
    } = prepared.emitters.lights[index as usize]
    else {
        unreachable!("only lights with a surface are asked for");
    };
    AreaLight {
        geometry: world.primitives[primitive as usize].geometry,
        radiance,
        two_sided,
        by_solid_angle: prepared.effects.contains(Effect::SolidAngleLights),
        projected: prepared.effects.contains(Effect::ProjectedLights),
    }
}

/// A point on a light, and which way its front faces there.
struct LightPoint {
    position: DVec3,
    normal: DVec3,
    /// Size of the coordinates, for the offset.
    extent: f64,
    /// Density there of points that are chosen by area.
    pdf: PdfArea,
}

/// Size of its coordinates, for the offset.
pub fn extent(geometry: &PrimitiveGeometry) -> f64 {
    match *geometry {
        PrimitiveGeometry::Triangle { a, u, v }
        | PrimitiveGeometry::Rectangle { a, u, v }
        | PrimitiveGeometry::Disk { a, u, v } => max_abs(a) + max_abs(u) + max_abs(v),
        PrimitiveGeometry::Sphere { center, radius } => max_abs(center) + radius,
        PrimitiveGeometry::Ellipsoid { center, radii, .. } => max_abs(center) + radii.max_element(),
    }
}

/// Coordinates of the point of a planar light that the unit square has at `u`.
fn sample_light_area(geometry: &PrimitiveGeometry, u: DVec2) -> DVec2 {
    match geometry {
        PrimitiveGeometry::Triangle { .. } => sample_triangle_area(u),
        PrimitiveGeometry::Disk { .. } => sample_disk_area(u),
        _ => sample_rectangle_area(u),
    }
}

/// The point of an ellipsoid that is the image of `p` on the unit sphere.
fn ellipsoid_point(ellipsoid: &Ellipsoid, p: DVec3) -> LightPoint {
    LightPoint {
        position: ellipsoid.point(p),
        normal: ellipsoid_normal(ellipsoid.axes, p),
        extent: ellipsoid.extent(),
        pdf: pdf_ellipsoid_area(ellipsoid, p),
    }
}

/// A point of the light, uniform over its area; of an ellipsoid, over that of the unit sphere.
fn sample_area(geometry: &PrimitiveGeometry, u: DVec2) -> LightPoint {
    if let Some(ellipsoid) = Ellipsoid::of(geometry) {
        return ellipsoid_point(&ellipsoid, sample_sphere_area(u));
    }
    let (position, normal) = match *geometry {
        PrimitiveGeometry::Triangle { a, u: e1, v: e2 }
        | PrimitiveGeometry::Rectangle { a, u: e1, v: e2 }
        | PrimitiveGeometry::Disk { a, u: e1, v: e2 } => {
            let st = sample_light_area(geometry, u);
            (a + st.x * e1 + st.y * e2, e1.cross(e2).normalize())
        }
        PrimitiveGeometry::Sphere { center, radius } => {
            let normal = sample_sphere_area(u);
            (center + radius * normal, normal)
        }
        PrimitiveGeometry::Ellipsoid { .. } => unreachable!("an ellipsoid has points of its own"),
    };
    LightPoint {
        position,
        normal,
        extent: extent(geometry),
        pdf: pdf_area(geometry, DVec2::ZERO),
    }
}

/// Density of [`sample_area`] at the light's coordinates `st`.
fn pdf_area(geometry: &PrimitiveGeometry, st: DVec2) -> PdfArea {
    if let Some(ellipsoid) = Ellipsoid::of(geometry) {
        return pdf_ellipsoid_area(&ellipsoid, from_octahedral(st).normalize());
    }
    let area = geometry.area();
    match geometry {
        PrimitiveGeometry::Triangle { .. } => pdf_triangle_area(area),
        PrimitiveGeometry::Rectangle { .. } => pdf_rectangle_area(area),
        PrimitiveGeometry::Disk { .. } => pdf_disk_area(area),
        PrimitiveGeometry::Sphere { .. } | PrimitiveGeometry::Ellipsoid { .. } => {
            pdf_sphere_area(area)
        }
    }
}

/// A direction from within the sphere, in proportion to the cosine at the surface with the frame
/// `frame`.
fn sample_sphere_from_within(frame: &ShadingFrame, u: DVec2) -> (DVec3, PdfSolidAngle) {
    let local = sample_lambert(u);
    (to_world(frame, local), pdf_lambert(local.z))
}

/// Whether `x` is within the light or on it, a sphere or an ellipsoid that is sampled over its
/// solid angle.
fn is_within(light: &AreaLight, x: DVec3) -> bool {
    let within = match light.geometry {
        PrimitiveGeometry::Sphere { center, radius } => within_sphere(center, radius, x),
        _ => seen_ellipsoid(&light.geometry, x).is_some_and(|seen| seen.within),
    };
    light.by_solid_angle && within
}

/// How `x` sees an ellipsoid; `None` for another kind.
fn seen_ellipsoid(geometry: &PrimitiveGeometry, x: DVec3) -> Option<EllipsoidView> {
    Ellipsoid::of(geometry).map(|ellipsoid| view_ellipsoid(ellipsoid, x))
}

/// 1 − cosθ of the cone in which `x` sees a sphere; `None` from within, and where the cone is too
/// narrow.
fn sphere_cone(center: DVec3, radius: f64, x: DVec3) -> Option<f64> {
    if within_sphere(center, radius, x) {
        return None;
    }
    let k = cone_height(radius * radius / (center - x).length_squared());
    Some(k).filter(|k| TAU * k >= MIN_SOLID_ANGLE)
}

/// A direction towards the light, uniform over a solid angle, and that solid angle (of an
/// ellipsoid, one over the density); `None` where it is too small to be sampled so, and within a
/// sphere.
fn sample_direction(geometry: &PrimitiveGeometry, x: DVec3, u: DVec2) -> Option<(DVec3, f64)> {
    if let Some(seen) = seen_ellipsoid(geometry, x) {
        let direction = seen.sample_direction(u);
        return Some((direction, seen.inverse_direction_density(direction)?));
    }
    let (direction, solid_angle) = match *geometry {
        PrimitiveGeometry::Triangle { a, u: e1, v: e2 } => {
            let t = spherical_triangle(x, a, e1, e2);
            let direction = sample_triangle_solid_angle(&t, u.x * t.solid_angle, u.y);
            (direction, t.solid_angle)
        }
        PrimitiveGeometry::Rectangle { a, u: e1, v: e2 } => {
            sample_quadrilateral(geometry.is_skewed(), x, [a, e1, e2], u)
        }
        PrimitiveGeometry::Disk { a, u: e1, v: e2 } => {
            // The box around it: what misses the disk finds no light.
            let around = [a - e1 - e2, 2.0 * e1, 2.0 * e2];
            sample_quadrilateral(geometry.is_skewed(), x, around, u)
        }
        PrimitiveGeometry::Sphere { center, radius } => {
            let k = sphere_cone(center, radius, x)?;
            (sample_cone((center - x).normalize(), k, u).0, TAU * k)
        }
        PrimitiveGeometry::Ellipsoid { .. } => unreachable!("an ellipsoid has a way of its own"),
    };
    (solid_angle >= MIN_SOLID_ANGLE).then_some((direction, solid_angle))
}

/// A direction into a rectangle, or another parallelogram where it is skewed, and its solid angle.
fn sample_quadrilateral(skewed: bool, x: DVec3, [a, e1, e2]: [DVec3; 3], u: DVec2) -> (DVec3, f64) {
    if skewed {
        let p = spherical_parallelogram(x, a, e1, e2);
        (sample_parallelogram_solid_angle(&p, u), p.solid_angle)
    } else {
        let r = spherical_rectangle(x, a, e1, e2);
        (sample_rectangle_solid_angle(&r, u).wi, r.solid_angle)
    }
}

/// Projected solid angles below this are sampled by solid angle.
pub const MIN_PROJECTED: f64 = 1e-4;

/// A triangle or rectangle as `frame` at `x` sees it; `None` for other lights, and where its
/// projected solid angle is too small to be sampled.
fn projected(light: &AreaLight, x: DVec3, frame: &ShadingFrame) -> Option<ProjectedPolygon> {
    let vertices = match light.geometry {
        PrimitiveGeometry::Triangle { a, u, v } => vec![a, a + u, a + v],
        PrimitiveGeometry::Rectangle { a, u, v } => vec![a, a + u, a + u + v, a + v],
        PrimitiveGeometry::Disk { .. }
        | PrimitiveGeometry::Sphere { .. }
        | PrimitiveGeometry::Ellipsoid { .. } => return None,
    };
    let local: Vec<DVec3> = vertices.iter().map(|p| to_local(frame, p - x)).collect();
    Some(project_polygon(&local)).filter(|p| light.projected && p.area >= MIN_PROJECTED)
}

/// Where the ray from `x` in direction `wi` meets the light.
fn point_in_direction(geometry: &PrimitiveGeometry, x: DVec3, wi: DVec3) -> Option<LightPoint> {
    if let Some(seen) = seen_ellipsoid(geometry, x) {
        let p = seen.point_in_direction(wi)?;
        return Some(ellipsoid_point(&seen.ellipsoid, p));
    }
    let (position, normal) = match *geometry {
        PrimitiveGeometry::Triangle { a, u, v }
        | PrimitiveGeometry::Rectangle { a, u, v }
        | PrimitiveGeometry::Disk { a, u, v } => {
            let normal = u.cross(v);
            let t = normal.dot(a - x) / normal.dot(wi);
            let p = x + t * wi - a;
            let squared = normal.length_squared();
            let st = DVec2::new(p.cross(v).dot(normal), u.cross(p).dot(normal)) / squared;
            let disk = matches!(geometry, PrimitiveGeometry::Disk { .. });
            if t.is_nan() || t <= 0.0 || (disk && st.length_squared() > 1.0) {
                return None;
            }
            (a + st.x * u + st.y * v, normal.normalize())
        }
        PrimitiveGeometry::Sphere { center, radius } => {
            let t = if within_sphere(center, radius, x) {
                distance_within_sphere(center, radius, x, wi)
            } else {
                let to_center = center - x;
                let along = to_center.dot(wi);
                let off = (to_center - along * wi).length_squared();
                along - (radius * radius - off).max(0.0).sqrt()
            };
            if t <= 0.0 {
                return None;
            }
            let normal = (x + t * wi - center).normalize();
            (center + radius * normal, normal)
        }
        PrimitiveGeometry::Ellipsoid { .. } => unreachable!("an ellipsoid has points of its own"),
    };
    Some(LightPoint {
        position,
        normal,
        extent: extent(geometry),
        pdf: pdf_area(geometry, DVec2::ZERO),
    })
}

/// A direction towards the light that is not chosen by area, and its density.
fn sample_by_direction(
    light: &AreaLight,
    x: DVec3,
    frame: &ShadingFrame,
    u: DVec2,
) -> Option<(DVec3, PdfSolidAngle)> {
    if let Some(polygon) = projected(light, x, frame) {
        let local = sample_projected_polygon(&polygon, u);
        let pdf = PdfSolidAngle(local.z.max(1e-7) / polygon.area);
        return Some((to_world(frame, local), pdf));
    }
    if !light.by_solid_angle {
        return None;
    }
    if is_within(light, x) {
        return Some(sample_sphere_from_within(frame, u));
    }
    let (wi, solid_angle) = sample_direction(&light.geometry, x, u)?;
    Some((wi, pdf_uniform_solid_angle(solid_angle)))
}

/// A sample of a light with a surface, seen from `x` on a surface with the frame `frame`.
pub fn sample_area_light(
    light: &AreaLight,
    choice: PdfDiscrete,
    x: DVec3,
    frame: &ShadingFrame,
    u: DVec2,
) -> LightSample {
    let direction = sample_by_direction(light, x, frame, u);
    let (point, wi, pdf) = match direction {
        Some((wi, pdf)) => {
            let point = point_in_direction(&light.geometry, x, wi);
            let Some(point) = point.filter(|_| pdf.0 > 0.0) else {
                return LightSample::NONE;
            };
            (point, wi, Some(pdf))
        }
        None => {
            let point = sample_area(&light.geometry, u);
            let Some(wi) = (point.position - x).try_normalize() else {
                return LightSample::NONE;
            };
            (point, wi, None)
        }
    };
    let on_light = point.pdf;
    light_sample(light, choice, (x, wi), point, (pdf, on_light))
}

/// A sample of a planar light whose emission varies by `map`, at a point of the unit square with
/// its density there.
pub fn sample_textured_light(
    world: &World<'_>,
    light: &AreaLight,
    map: &EmissionMap,
    choice: PdfDiscrete,
    x: DVec3,
    (u, on_square): (DVec2, PdfArea),
) -> LightSample {
    let point = sample_area(&light.geometry, u);
    let Some(wi) = (point.position - x).try_normalize() else {
        return LightSample::NONE;
    };
    let st = sample_light_area(&light.geometry, u);
    let here = AreaLight {
        radiance: light.radiance * emission_factor(world, map, st),
        ..*light
    };
    let on_light = PdfArea(on_square.0 * point.pdf.0);
    light_sample(&here, choice, (x, wi), point, (None, on_light))
}

/// A sample of the point `point` of a light, which lies in the unit direction `wi` from `x`: chosen
/// with the density `pdf`, else with `on_light` by area.
fn light_sample(
    light: &AreaLight,
    choice: PdfDiscrete,
    (x, wi): (DVec3, DVec3),
    point: LightPoint,
    (pdf, on_light): (Option<PdfSolidAngle>, PdfArea),
) -> LightSample {
    let signed_cos = -point.normal.dot(wi);
    let cos_light = if light.two_sided {
        signed_cos.abs()
    } else {
        signed_cos
    };
    if cos_light <= 0.0 {
        return LightSample::NONE;
    }
    let towards_x = if signed_cos > 0.0 {
        point.normal
    } else {
        -point.normal
    };
    let d2 = (point.position - x).length_squared();
    let radiance_over_pdf = match pdf {
        Some(pdf) => light.radiance / (pdf.0 * choice.0),
        None => light.radiance * cos_light / (d2 * on_light.0 * choice.0),
    };
    let pdf = pdf.unwrap_or_else(|| area_to_solid_angle(on_light, d2, cos_light));
    LightSample {
        wi,
        target_point: point.position + towards_x * (point.extent * OFFSET),
        radiance_over_pdf,
        pdf: chosen(choice, pdf),
        pdf_on_light: Some(on_light),
        cos_light,
        delta: false,
    }
}

/// Probability that light selection chooses `light`, which can be hit, for a surface at `x` with
/// the normal `normal`.
pub fn pdf_light(world: &World<'_>, light: u32, x: DVec3, normal: DVec3) -> PdfDiscrete {
    let emitters = &world.prepared.emitters;
    match &emitters.selection {
        Some(Selection::Tree(tree)) => pdf_tree_light(tree, tree.trails[light as usize], x, normal),
        _ => PdfDiscrete(emitters.probability(light as usize)),
    }
}

/// That probability for a surface with the frame `frame`, and the density at the light's
/// coordinates `st` of a point chosen by its area, in proportion to its emission.
pub fn pdf_light_area(
    world: &World<'_>,
    light: u32,
    (x, frame): (DVec3, &ShadingFrame),
    st: DVec2,
) -> (PdfDiscrete, PdfArea) {
    let geometry = area_light(world, light).geometry;
    let on_square = match emission_map(world, light) {
        Some(map) => pdf_emission(map, invert_light_area(&geometry, st)),
        None => PdfArea(1.0),
    };
    let on_light = PdfArea(on_square.0 * pdf_area(&geometry, st).0);
    (pdf_light(world, light, x, frame.z), on_light)
}

/// Density with which light sampling from `x`, on a surface with the frame `frame`, would have
/// chosen the direction `wi` in which a ray met a light's surface at its coordinates `st`, light
/// selection included: `distance_squared` away, at cosine `cos_light` > 0.
pub fn pdf_area_light(
    world: &World<'_>,
    light: u32,
    (x, frame): (DVec3, &ShadingFrame),
    wi: DVec3,
    (distance_squared, cos_light, st): (f64, f64, DVec2),
) -> PdfSolidAngle {
    let (selection, on_light) = pdf_light_area(world, light, (x, frame), st);
    if emission_map(world, light).is_some() {
        let pdf = area_to_solid_angle(on_light, distance_squared, cos_light);
        return chosen(selection, pdf);
    }
    let light = area_light(world, light);
    if let Some(polygon) = projected(&light, x, frame) {
        return chosen(
            selection,
            PdfSolidAngle(frame.z.dot(wi).max(0.0) / polygon.area),
        );
    }
    if is_within(&light, x) {
        return chosen(selection, pdf_lambert(frame.z.dot(wi)));
    }
    let sampled = if light.by_solid_angle {
        match seen_ellipsoid(&light.geometry, x) {
            Some(seen) => seen.inverse_direction_density(wi),
            None => sample_direction(&light.geometry, x, DVec2::ZERO).map(|(_, angle)| angle),
        }
    } else {
        None
    };
    let pdf = match sampled {
        Some(solid_angle) => pdf_uniform_solid_angle(solid_angle),
        None => area_to_solid_angle(on_light, distance_squared, cos_light),
    };
    chosen(selection, pdf)
}
