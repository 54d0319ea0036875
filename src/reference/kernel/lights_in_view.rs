//! Small lights that the camera sees; see `shaders/kernel/lights_in_view.wesl`.

use super::direct::Direct;
use super::filter::filter_density;
use crate::accel::PrimitiveGeometry;
use crate::emitters::Emitter;
use crate::prepare::lights_in_view::LightInView;
use crate::reference::broken::BrokenTwin;
use crate::reference::core::frame::frame_from_normal;
use crate::reference::core::pdf::PdfSolidAngle;
use crate::reference::core::ray::Ray;
use crate::reference::core::ray_ellipsoid::{ellipsoid_normal, intersect_ellipsoid};
use crate::reference::core::rng::to_unit_2d;
use crate::reference::core::sampler::{GROUP_LIGHTS_IN_VIEW, SampleId};
use crate::reference::light::area_light::extent;
use crate::reference::light::disk::sample_disk_area;
use crate::reference::light::ellipsoid::Ellipsoid;
use crate::reference::light::light::emitted_radiance;
use crate::reference::light::sample::FAR;
use crate::reference::light::sun::sun_radiance;
use crate::reference::light::triangle::sample_triangle_area;
use crate::reference::scene::fetch::World;
use crate::reference::scene::opacity::{Crossings, RAY_LIGHTS_IN_VIEW};
use crate::reference::scene::surface::OFFSET;
use crate::reference::scene::trace::any_hit;
use crate::scene::Camera;
use glam::{DMat3, DVec2, DVec3};
use std::f64::consts::PI;

/// A flat piece that a point sees where it sees the light.
struct Patch {
    /// From the point to its corner or middle.
    to_a: DVec3,
    u: DVec3,
    v: DVec3,
    /// Coordinates on it, uniform over its area.
    sample: fn(DVec2) -> DVec2,
    /// Its area over that of the parallelogram u × v.
    share: f64,
}

impl Patch {
    /// An ellipse around the point at `to_middle`.
    fn ellipse(to_middle: DVec3, u: DVec3, v: DVec3) -> Self {
        Self {
            to_a: to_middle,
            u,
            v,
            sample: sample_disk_area,
            share: PI,
        }
    }

    /// That of light `index` as `origin` sees it.
    fn of(world: &World<'_>, index: u32, origin: DVec3) -> Self {
        let primitive = match world.prepared.emitters.lights[index as usize] {
            Emitter::Area { primitive, .. } => primitive,
            Emitter::Sun(sun) => {
                let around = frame_from_normal(-sun.direction);
                let tan = sun.angular_radius.tan();
                return Self::ellipse(-sun.direction, tan * around.x, tan * around.y);
            }
            Emitter::Delta(_) | Emitter::Environment => unreachable!("it has no extent in view"),
        };
        match world.primitives[primitive as usize].geometry {
            PrimitiveGeometry::Rectangle { a, u, v } => Self {
                to_a: a - origin,
                u,
                v,
                sample: |u| u,
                share: 1.0,
            },
            PrimitiveGeometry::Triangle { a, u, v } => Self {
                to_a: a - origin,
                u,
                v,
                sample: sample_triangle_area,
                share: 0.5,
            },
            PrimitiveGeometry::Disk { a, u, v } => Self::ellipse(a - origin, u, v),
            PrimitiveGeometry::Sphere { center, radius } => {
                around_body(center, DMat3::from_diagonal(DVec3::splat(radius)), origin)
            }
            geometry @ PrimitiveGeometry::Ellipsoid { .. } => {
                let body = Ellipsoid::of(&geometry).expect("the geometry is an ellipsoid");
                around_body(body.center, body.axes, origin)
            }
        }
    }
}

/// The ellipse in which the cone around the body center + axes·p, |p| ≤ 1, as `origin` sees it,
/// cuts the plane through its centre across the way there, in the space of p.
fn around_body(center: DVec3, axes: DMat3, origin: DVec3) -> Patch {
    let to_origin = axes.inverse() * (origin - center);
    let distance = to_origin.length();
    let around = frame_from_normal(to_origin / distance);
    let radius = distance / (distance * distance - 1.0).sqrt();
    Patch::ellipse(
        center - origin,
        axes * (radius * around.x),
        axes * (radius * around.y),
    )
}

/// What light `index` shows on the line from `viewer` in the unit direction `w`, which passes
/// through the coordinates `st` of its patch, and where a ray towards it ends.
fn shown(
    world: &World<'_>,
    index: u32,
    st: DVec2,
    viewer: DVec3,
    w: DVec3,
) -> Option<(DVec3, DVec3)> {
    let primitive = match world.prepared.emitters.lights[index as usize] {
        Emitter::Area { primitive, .. } => primitive,
        Emitter::Sun(sun) if world.shines(index as usize) => {
            return Some((
                sun_radiance(&sun),
                viewer + (FAR + 2.0 * viewer.length()) * w,
            ));
        }
        _ => return None,
    };
    let geometry = world.primitives[primitive as usize].geometry;
    let ray = Ray {
        origin: viewer,
        direction: w,
    };
    let (point, normal) = match geometry {
        PrimitiveGeometry::Triangle { a, u, v }
        | PrimitiveGeometry::Rectangle { a, u, v }
        | PrimitiveGeometry::Disk { a, u, v } => (a + st.x * u + st.y * v, u.cross(v).normalize()),
        PrimitiveGeometry::Sphere { center, radius } => {
            let axes = DMat3::from_diagonal(DVec3::splat(radius));
            let ((_, p), _) = intersect_ellipsoid(&ray, center, axes)?;
            (center + radius * p, p)
        }
        PrimitiveGeometry::Ellipsoid { .. } => {
            let body = Ellipsoid::of(&geometry)?;
            let ((_, p), _) = intersect_ellipsoid(&ray, body.center, body.axes)?;
            (body.point(p), ellipsoid_normal(body.axes, p))
        }
    };
    let front = normal.dot(w) <= 0.0;
    let towards_viewer = if front { normal } else { -normal };
    let target = point + towards_viewer * (extent(&geometry) * OFFSET);
    Some((emitted_radiance(world, index, front, st), target))
}

impl Direct<'_> {
    /// The small lights that pixel (x, y) may show.
    pub(super) fn lights_of_pixel(&self, x: u32, y: u32) -> Vec<(u32, LightInView)> {
        let lights = (0..).zip(&self.world.prepared.lights_in_view);
        let near = lights.filter(|(_, light)| light.is_near(x, y));
        near.map(|(i, light)| (i, *light)).collect()
    }

    /// What the light `seen`, number `i` of those in view, contributes to a sample of pixel (x, y)
    /// whose camera ray is `camera_ray`.
    pub(super) fn estimate_light_in_view(
        &self,
        (i, seen): (u32, LightInView),
        id: SampleId,
        (x, y): (u32, u32),
        camera_ray: &Ray,
    ) -> DVec3 {
        let prepared = self.world.prepared;
        let camera = prepared.data.normalization.camera(&prepared.camera);
        let lens = camera.lens;
        let in_focus = lens.focus_distance / camera_ray.direction.dot(camera.forward);
        let through = if seen.out_of_focus {
            camera_ray.origin + in_focus * camera_ray.direction
        } else {
            camera_ray.origin
        };
        let patch = Patch::of(&self.world, seen.light, through);
        let [a, b, ..] = self.numbers.group(id, GROUP_LIGHTS_IN_VIEW.wrapping_add(i));
        let st = (patch.sample)(to_unit_2d(a, b));
        let d = patch.to_a + st.x * patch.u + st.y * patch.v;
        let direction = d.normalize();
        let axis = direction.dot(camera.forward);
        let w = axis.signum() * direction;
        let area = patch.share * patch.u.cross(patch.v).dot(direction).abs();
        let pdf = PdfSolidAngle(d.length_squared() / area);
        let pdf = BrokenTwin::density(self.broken, pdf);
        let (viewer, density) = if seen.out_of_focus {
            let viewer = through - w * (lens.focus_distance / axis.abs());
            let on_lens = viewer.distance(camera.eye) <= lens.radius;
            let per_area = lens.focus_distance.powi(2) / (PI * lens.radius.powi(2));
            (viewer, if on_lens { per_area } else { 0.0 })
        } else {
            let pixel = DVec2::new(f64::from(x), f64::from(y));
            let viewer = camera_ray.origin;
            (
                viewer,
                self.density_on_film(&camera, w / axis, viewer, pixel),
            )
        };
        let weight = density / (pdf.0 * axis.abs().powi(3));
        let Some((radiance, target)) = shown(&self.world, seen.light, st, viewer, w) else {
            return DVec3::ZERO;
        };
        let contribution = weight * radiance;
        if contribution.max_element() <= 0.0 {
            return DVec3::ZERO;
        }
        let ray = Ray {
            origin: viewer,
            direction: target - viewer,
        };
        let crossings = Crossings::of_sample(id).of_ray(RAY_LIGHTS_IN_VIEW + i);
        let crossings = BrokenTwin::crossings(self.broken, crossings);
        if any_hit(&self.world, &ray, crossings, 1.0) {
            return DVec3::ZERO;
        }
        contribution
    }

    /// The filter of the pixel whose upper left corner is `pixel`, where the film shows what lies
    /// in the direction `d` from the lens's point `viewer`, over the plane at distance 1; `d` has
    /// the length 1 along the viewing direction.
    fn density_on_film(&self, camera: &Camera, d: DVec3, viewer: DVec3, pixel: DVec2) -> f64 {
        let in_focus = d + (viewer - camera.eye) / camera.lens.focus_distance;
        let across = DVec2::new(in_focus.dot(camera.right), -in_focus.dot(camera.up));
        let height = f64::from(self.size.height);
        let per_unit = 0.5 * height / camera.half_height();
        let middle = 0.5 * DVec2::new(f64::from(self.size.width), height);
        let off = middle + per_unit * across - (pixel + 0.5);
        per_unit * per_unit * filter_density(&self.filter, off)
    }
}
