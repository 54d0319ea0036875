//! Lights that are sampled in view of the camera; see `shaders/kernel/lights_in_view.wesl`.

use super::camera::camera_ray;
use super::direct::Direct;
use super::filter::{film_point, filter_density};
use crate::accel::PrimitiveGeometry;
use crate::emitters::Emitter;
use crate::prepare::lights_in_view::{LightInView, MOST_POINTS, PointsInView};
use crate::reference::broken::BrokenTwin;
use crate::reference::core::frame::frame_from_normal;
use crate::reference::core::math::max_abs;
use crate::reference::core::pdf::PdfSolidAngle;
use crate::reference::core::ray::Ray;
use crate::reference::core::ray_ellipsoid::{ellipsoid_normal, intersect_ellipsoid};
use crate::reference::core::rng::to_unit_2d;
use crate::reference::core::sampler::{GROUP_LIGHTS_IN_VIEW, SampleId, part_of_sample};
use crate::reference::light::area_light::extent;
use crate::reference::light::disk::sample_disk_area;
use crate::reference::light::ellipsoid::{Ellipsoid, conjugate_axes};
use crate::reference::light::light::emitted_radiance;
use crate::reference::light::sample::FAR;
use crate::reference::light::sun::sun_radiance;
use crate::reference::light::triangle::sample_triangle_area;
use crate::reference::scene::fetch::World;
use crate::reference::scene::opacity::{Crossings, RAY_LIGHTS_IN_VIEW};
use crate::reference::scene::surface::OFFSET;
use crate::reference::scene::trace::any_hit;
use crate::scene::Camera;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// A flat piece that a point sees where it sees the light.
struct Patch {
    /// From the point to its corner or middle.
    to_a: DVec3,
    u: DVec3,
    v: DVec3,
    /// Coordinates on it, uniform over its area.
    sample: fn(DVec2) -> DVec2,
    /// Whether coordinates are of a point on it, or no farther away than an extent.
    holds: fn(DVec2, DVec2) -> bool,
    /// Its area over that of the parallelogram u × v.
    share: f64,
}

impl Patch {
    /// The parameter and the coordinates at which the ray from the point that sees it meets its plane
    /// in the direction `w`.
    fn coordinates(&self, w: DVec3) -> (f64, DVec2) {
        let n = self.u.cross(self.v);
        let t = n.dot(self.to_a) / n.dot(w);
        let p = t * w - self.to_a;
        let st = DVec2::new(p.cross(self.v).dot(n), self.u.cross(p).dot(n));
        (t, st / n.length_squared())
    }

    /// Where that ray meets it.
    fn meet(&self, w: DVec3) -> Option<DVec2> {
        let (t, st) = self.coordinates(w);
        (t > 0.0 && (self.holds)(st, DVec2::ZERO)).then_some(st)
    }

    /// An ellipse around the point at `to_middle`.
    fn ellipse(to_middle: DVec3, u: DVec3, v: DVec3) -> Self {
        Self {
            to_a: to_middle,
            u,
            v,
            sample: sample_disk_area,
            holds: |st, extent| st.length() <= 1.0 + extent.length(),
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
                holds: |st, extent| {
                    (st + extent).min_element() >= 0.0 && (st - extent).max_element() <= 1.0
                },
                share: 1.0,
            },
            PrimitiveGeometry::Triangle { a, u, v } => Self {
                to_a: a - origin,
                u,
                v,
                sample: sample_triangle_area,
                holds: |st, extent| {
                    (st + extent).min_element() >= 0.0 && st.x + st.y <= 1.0 + extent.x + extent.y
                },
                share: 0.5,
            },
            PrimitiveGeometry::Disk { a, u, v } => Self::ellipse(a - origin, u, v),
            geometry @ (PrimitiveGeometry::Sphere { .. } | PrimitiveGeometry::Ellipsoid { .. }) => {
                around(
                    &Ellipsoid::or_sphere(&geometry).expect("it is a body"),
                    origin,
                )
            }
        }
    }
}

/// The ellipse in which the cone around `body`, as `origin` sees it, cuts the plane through its centre
/// across the way there, in the space in which it is the unit sphere.
fn around(body: &Ellipsoid, origin: DVec3) -> Patch {
    let to_origin = body.axes.inverse() * (origin - body.center);
    let distance = to_origin.length();
    let radius = distance / (distance * distance - 1.0).sqrt();
    let [u, v] = conjugate_axes(body, to_origin);
    Patch::ellipse(body.center - origin, radius * u, radius * v)
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
        PrimitiveGeometry::Sphere { .. } | PrimitiveGeometry::Ellipsoid { .. } => {
            let body = Ellipsoid::or_sphere(&geometry)?;
            let ((_, p), _) = intersect_ellipsoid(&ray, body.center, body.axes)?;
            (body.point(p), ellipsoid_normal(body.axes, p))
        }
    };
    let front = normal.dot(w) <= 0.0;
    let towards_viewer = if front { normal } else { -normal };
    let extent = extent(&geometry) + max_abs(viewer);
    let target = point + towards_viewer * (extent * OFFSET);
    Some((emitted_radiance(world, index, front, st), target))
}

/// A point of a light's patch as a sample of the pixel sees it.
struct PointInView {
    /// The point of the lens.
    viewer: DVec3,
    /// Unit direction from there, away from the camera.
    direction: DVec3,
    /// Its coordinates on the patch.
    st: DVec2,
    /// Factor on the radiance.
    weight: f64,
}

impl Direct<'_> {
    /// The lights that are sampled in view of the camera in pixel (x, y).
    pub(super) fn lights_of_pixel(&self, x: u32, y: u32) -> Vec<(u32, LightInView)> {
        let lights = (0..).zip(&self.world.prepared.lights_in_view);
        let near =
            lights.filter(|(_, light)| light.is_near(x, y) && self.is_sampled_in(light, x, y));
        near.map(|(i, light)| (i, *light)).collect()
    }

    /// Whether the light `seen` is to be sampled in pixel (x, y). A larger one is not where it covers
    /// all of it, which camera rays see as well, nor where it lies beside it.
    fn is_sampled_in(&self, seen: &LightInView, x: u32, y: u32) -> bool {
        let lens = self.world.prepared.camera.lens.radius > 0.0;
        if lens || seen.points != PointsInView::OfPixel {
            return true;
        }
        let middle = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let reach = self.filter.reach();
        let seen_at = |x: f64, y: f64| {
            let film = middle + reach * DVec2::new(x, y);
            let ray = camera_ray(&self.world, self.size, film, DVec2::splat(0.5));
            let patch = Patch::of(&self.world, seen.light, ray.origin);
            let (t, st) = patch.coordinates(ray.direction);
            (t > 0.0 && (patch.holds)(st, DVec2::ZERO), st, patch)
        };
        let (_, center, patch) = seen_at(0.0, 0.0);
        let corners = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
        let corners = corners.map(|(x, y)| seen_at(x, y));
        let extents = corners.iter().map(|(_, st, _)| (*st - center).abs());
        let extent = extents.fold(DVec2::ZERO, DVec2::max);
        let covered = corners.iter().all(|(met, ..)| *met);
        !covered && (patch.holds)(center, extent)
    }

    /// What the light `seen`, number `i` of those in view, contributes to a sample of pixel (x, y).
    pub(super) fn estimate_light_in_view(
        &self,
        (i, seen): (u32, LightInView),
        id: SampleId,
        (x, y): (u32, u32),
    ) -> DVec3 {
        let pixel = DVec2::new(f64::from(x), f64::from(y));
        let seen_at = |n: u32| {
            let part = part_of_sample(id, n, seen.per_sample);
            let group = GROUP_LIGHTS_IN_VIEW.wrapping_add(i);
            let [a, b, c, d] = self.numbers.group(part, group);
            let (first, second) = (to_unit_2d(a, b), to_unit_2d(c, d));
            let point = if seen.points == PointsInView::OfPixel {
                self.point_of_pixel(seen.light, pixel, first, second)?
            } else {
                self.point_of_light(seen, pixel, first, second)
            };
            Some(self.seen(seen.light, &point, id, MOST_POINTS * i + n))
        };
        let sum: DVec3 = (0..seen.per_sample).filter_map(seen_at).sum();
        sum / f64::from(seen.per_sample)
    }

    /// What light `index` shows at `point`, unless something hides it from ray number `ray` to lights
    /// in view.
    fn seen(&self, index: u32, point: &PointInView, id: SampleId, ray: u32) -> DVec3 {
        let PointInView {
            viewer,
            direction,
            st,
            weight,
        } = *point;
        let Some((radiance, target)) = shown(&self.world, index, st, viewer, direction) else {
            return DVec3::ZERO;
        };
        let contribution = weight * radiance;
        if contribution.max_element() <= 0.0 {
            return DVec3::ZERO;
        }
        let crossings = Crossings::of_sample(id).of_ray(RAY_LIGHTS_IN_VIEW.wrapping_add(ray));
        let crossings = BrokenTwin::crossings(self.broken, crossings);
        let ray = Ray {
            origin: viewer,
            direction: target - viewer,
        };
        if any_hit(&self.world, &ray, crossings, 1.0) {
            return DVec3::ZERO;
        }
        contribution
    }

    /// The point of light `index` that the lens's point `lens` sees where the filter chose `film` in the
    /// pixel.
    fn point_of_pixel(
        &self,
        index: u32,
        pixel: DVec2,
        film: DVec2,
        lens: DVec2,
    ) -> Option<PointInView> {
        let film = film_point(&self.filter, pixel, film);
        let ray = camera_ray(&self.world, self.size, film, lens);
        let st = Patch::of(&self.world, index, ray.origin).meet(ray.direction)?;
        let one = BrokenTwin::density(self.broken, PdfSolidAngle(1.0));
        Some(PointInView {
            viewer: ray.origin,
            direction: ray.direction,
            st,
            weight: 1.0 / one.0,
        })
    }

    /// The point `on_light` of the light's patch, seen from the point `lens_or_film` of the lens, or
    /// through the point in focus that the filter chose by it.
    fn point_of_light(
        &self,
        seen: LightInView,
        pixel: DVec2,
        on_light: DVec2,
        lens_or_film: DVec2,
    ) -> PointInView {
        let film = film_point(&self.filter, pixel, lens_or_film);
        let camera_ray = camera_ray(&self.world, self.size, film, lens_or_film);
        let prepared = self.world.prepared;
        let camera = prepared.data.normalization.camera(&prepared.camera);
        let (lens, by_lens) = (camera.lens, seen.points == PointsInView::OfLens);
        let in_focus = lens.focus_distance / camera_ray.direction.dot(camera.forward);
        let through = if by_lens {
            camera_ray.origin + in_focus * camera_ray.direction
        } else {
            camera_ray.origin
        };
        let patch = Patch::of(&self.world, seen.light, through);
        let st = (patch.sample)(on_light);
        let d = patch.to_a + st.x * patch.u + st.y * patch.v;
        let axis = d.normalize().dot(camera.forward);
        let direction = axis.signum() * d.normalize();
        let area = patch.share * patch.u.cross(patch.v).dot(direction).abs();
        let pdf = PdfSolidAngle(d.length_squared() / area);
        let pdf = BrokenTwin::density(self.broken, pdf);
        let (viewer, density) = if by_lens {
            let viewer = through - direction * (lens.focus_distance / axis.abs());
            let on_lens = viewer.distance(camera.eye) <= lens.radius;
            let per_area = lens.focus_distance.powi(2) / (PI * lens.radius.powi(2));
            (viewer, if on_lens { per_area } else { 0.0 })
        } else {
            let viewer = camera_ray.origin;
            let d = direction / axis.abs();
            (viewer, self.density_on_film(&camera, d, viewer, pixel))
        };
        PointInView {
            viewer,
            direction,
            st,
            weight: density / (pdf.0 * axis.abs().powi(3)),
        }
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
