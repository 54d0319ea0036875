//! What the camera looks at: where, and how large what matters there is.
//!
//! A few probe rays over the image tell. What a probe meets at the distance t matters at the scale
//! of t, since a pixel of it is a fixed part of t; through a narrow field of view at that of the
//! field, as long as there is geometry that fine.

use super::ellipsoid::half_extent;
use super::normalize::bounds;
use super::{Camera, FilmSize, Geometry, Mesh, Projection, Scene};
use glam::{DMat3, DVec2, DVec3};
use rayon::prelude::*;
use std::ops::Range;

/// Probes per row and column of the image.
const PROBES: usize = 5;
/// Part of the distance below which the field of view is narrow: what it shows then is the centre,
/// not the eye.
const NARROW: f64 = 1.0 / 1024.0;

/// A point, and the smallest length that matters around it; world space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct View {
    /// The eye, or what is seen through a narrow field of view or by parallel rays.
    pub center: DVec3,
    /// The length, above 0.
    pub scale: f64,
}

/// An axis-parallel box.
type Box3 = (DVec3, DVec3);

/// What a probe met.
#[derive(Debug, Clone, Copy)]
struct Met {
    distance: f64,
    /// Size of the primitive.
    size: f64,
    shape: usize,
}

impl View {
    /// The view of `scene` through `camera`, if its scale is below `limit`. The scale is that of
    /// the probe with the smallest one.
    pub(super) fn below(scene: &Scene, camera: &Camera, limit: f64) -> Option<Self> {
        let boxes: Vec<Option<Box3>> = scene.shapes.iter().map(|s| bounds([s])).collect();
        let field = Field::of(camera, scene.film);
        let nearest = boxes.iter().flatten();
        let nearest = nearest.map(|b| distance_to_box(camera.eye, b));
        let nearest = nearest.fold(f64::INFINITY, f64::min);
        if field.scale(nearest, 0.0) >= limit {
            return None;
        }
        let probes = field.probes();
        let met = meet(scene, &boxes, &field, &probes);
        let views = probes.iter().zip(met);
        let views = views.filter_map(|(probe, met)| Some(field.view(probe, &met?, &boxes)));
        let view = views.min_by(|a, b| a.scale.total_cmp(&b.scale));
        view.filter(|view| view.scale < limit && view.scale > 0.0)
    }
}

/// A ray from the camera; unit direction.
#[derive(Debug, Clone, Copy)]
struct Probe {
    origin: DVec3,
    direction: DVec3,
}

/// What lies on the image.
struct Field<'a> {
    camera: &'a Camera,
    /// Half the image's width and height, as [`Camera::half_height`].
    half: DVec2,
}

impl<'a> Field<'a> {
    fn of(camera: &'a Camera, film: FilmSize) -> Self {
        let half = camera.half_height();
        Self {
            camera,
            half: DVec2::new(half * film.aspect(), half),
        }
    }

    /// The smallest length that matters at `distance`, where geometry is as fine as `detail`.
    fn scale(&self, distance: f64, detail: f64) -> f64 {
        let across = 2.0 * self.half.max_element();
        match self.camera.projection {
            Projection::Orthographic { .. } => across.max(detail),
            Projection::Perspective { .. } => (distance * across).max(detail).min(distance),
        }
    }

    fn view(&self, probe: &Probe, met: &Met, boxes: &[Option<Box3>]) -> View {
        let point = probe.origin + met.distance * probe.direction;
        let others = boxes.iter().enumerate();
        let others = others.filter(|(index, _)| *index != met.shape);
        let detail = others
            .filter_map(|(_, b)| b.as_ref())
            .map(|b| distance_to_box(point, b) + (b.1 - b.0).max_element())
            .fold(met.size, f64::min);
        let scale = self.scale(met.distance, detail);
        let wide = !self.camera.is_orthographic() && scale >= NARROW * met.distance;
        View {
            center: if wide { self.camera.eye } else { point },
            scale,
        }
    }

    /// Row by row.
    fn probes(&self) -> Vec<Probe> {
        let Camera {
            eye,
            right,
            up,
            forward,
            ..
        } = *self.camera;
        let at = |i: usize| (2 * i + 1) as f64 / PROBES as f64 - 1.0;
        let probe = |index: usize| {
            let x = at(index % PROBES) * self.half.x;
            let y = at(index / PROBES) * self.half.y;
            let across = x * right + y * up;
            if self.camera.is_orthographic() {
                Probe {
                    origin: eye + across,
                    direction: forward,
                }
            } else {
                Probe {
                    origin: eye,
                    direction: (forward + across).normalize(),
                }
            }
        };
        (0..PROBES * PROBES).map(probe).collect()
    }

    /// Rows and columns of the probes that may meet a triangle: those in its box on the image, all
    /// where it reaches behind the eye.
    fn probes_near(&self, triangle: &[DVec3; 3]) -> [Range<usize>; 2] {
        let Camera {
            eye,
            right,
            up,
            forward,
            ..
        } = self.camera;
        let mut low = DVec2::INFINITY;
        let mut high = DVec2::NEG_INFINITY;
        let mut in_front = 0;
        for p in triangle {
            let q = *p - *eye;
            let depth = q.dot(*forward);
            let across = DVec2::new(q.dot(*right), q.dot(*up));
            let on_image = if self.camera.is_orthographic() {
                across
            } else {
                across / depth
            };
            in_front += u32::from(depth > 0.0);
            (low, high) = (low.min(on_image), high.max(on_image));
        }
        match in_front {
            0 => [0..0, 0..0],
            3 => {
                let at = |p: DVec2| (p / self.half + 1.0) * (0.5 * PROBES as f64) - 0.5;
                let (low, high) = (at(low) - 1e-6, at(high) + 1e-6);
                [low.y.ceil()..high.y, low.x.ceil()..high.x].map(|r| {
                    let end = (r.end.floor() + 1.0).clamp(0.0, PROBES as f64);
                    r.start.clamp(0.0, PROBES as f64) as usize..end as usize
                })
            }
            _ => [0..PROBES, 0..PROBES],
        }
    }
}

/// The nearest thing that each probe meets.
fn meet(
    scene: &Scene,
    boxes: &[Option<Box3>],
    field: &Field<'_>,
    probes: &[Probe],
) -> Vec<Option<Met>> {
    let mut nearest = vec![None; probes.len()];
    for (index, (shape, around)) in scene.shapes.iter().zip(boxes).enumerate() {
        let material = &scene.materials[shape.material.index()];
        let Some(around) = around.filter(|_| !material.opacity.is_never_met()) else {
            continue;
        };
        if !probes.iter().any(|probe| meets_box(probe, &around)) {
            continue;
        }
        let met = match &shape.geometry {
            Geometry::Mesh(mesh) => meet_mesh(mesh, field, probes),
            geometry => probes.iter().map(|p| meet_shape(geometry, p)).collect(),
        };
        for (nearest, met) in nearest.iter_mut().zip(met) {
            let Some((distance, size)) = met else {
                continue;
            };
            if nearest.is_none_or(|n: Met| distance < n.distance) {
                *nearest = Some(Met {
                    distance,
                    size,
                    shape: index,
                });
            }
        }
    }
    nearest
}

/// Distance and size of the nearest primitive of a mesh, per probe.
fn meet_mesh(mesh: &Mesh, field: &Field<'_>, probes: &[Probe]) -> Vec<Option<(f64, f64)>> {
    let nothing = || vec![None; probes.len()];
    let add = |mut nearest: Vec<Option<(f64, f64)>>, t: &[u32; 3]| {
        let corners = t.map(|i| mesh.positions[i as usize]);
        let [rows, columns] = field.probes_near(&corners);
        let [a, b, c] = corners;
        for index in rows.flat_map(|row| columns.clone().map(move |x| row * PROBES + x)) {
            let inside = |st: DVec2| st.min_element() >= 0.0 && st.element_sum() <= 1.0;
            let met = meet_plane(&probes[index], [a, b - a, c - a], inside);
            let met = met.map(|distance| (distance, longer(b - a, c - a)));
            nearest[index] = nearer(nearest[index], met);
        }
        nearest
    };
    let parts = mesh.triangles.par_iter().fold(nothing, add);
    parts.reduce(nothing, |a, b| {
        a.into_iter().zip(b).map(|(a, b)| nearer(a, b)).collect()
    })
}

fn nearer(a: Option<(f64, f64)>, b: Option<(f64, f64)>) -> Option<(f64, f64)> {
    match (a, b) {
        (Some(a), Some(b)) => Some(if b.0 < a.0 { b } else { a }),
        (a, b) => a.or(b),
    }
}

/// Distance and size of a shape of one primitive.
fn meet_shape(geometry: &Geometry, probe: &Probe) -> Option<(f64, f64)> {
    match geometry {
        Geometry::Rectangle { corner, u, v } => {
            let inside = |st: DVec2| st.min_element() >= 0.0 && st.max_element() <= 1.0;
            let distance = meet_plane(probe, [*corner, *u, *v], inside)?;
            Some((distance, longer(*u, *v)))
        }
        Geometry::Disk { center, u, v } => {
            let inside = |st: DVec2| st.length_squared() <= 1.0;
            let distance = meet_plane(probe, [*center, *u, *v], inside)?;
            Some((distance, 2.0 * longer(*u, *v)))
        }
        Geometry::Sphere { center, radius } => {
            Some((meet_sphere(probe, *center, *radius)?, 2.0 * radius))
        }
        Geometry::Ellipsoid { center, axes } => {
            let distance = meet_ellipsoid(probe, *center, *axes)?;
            Some((distance, 2.0 * half_extent(*axes).max_element()))
        }
        Geometry::Mesh(_) => None,
    }
}

/// The longer edge.
fn longer(u: DVec3, v: DVec3) -> f64 {
    u.length().max(v.length())
}

/// Distance to the point a + s·u + t·v on the probe, where `inside` holds for (s, t).
fn meet_plane(probe: &Probe, [a, u, v]: [DVec3; 3], inside: impl Fn(DVec2) -> bool) -> Option<f64> {
    let across = probe.direction.cross(v);
    let determinant = u.dot(across);
    if determinant == 0.0 {
        return None;
    }
    let from = probe.origin - a;
    let turned = from.cross(u);
    let st = DVec2::new(from.dot(across), probe.direction.dot(turned)) / determinant;
    let distance = v.dot(turned) / determinant;
    (distance > 0.0 && inside(st)).then_some(distance)
}

fn meet_sphere(probe: &Probe, center: DVec3, radius: f64) -> Option<f64> {
    let to_center = center - probe.origin;
    let along = to_center.dot(probe.direction);
    let off = to_center - along * probe.direction;
    let half_chord = ((radius - off.length()) * (radius + off.length())).sqrt();
    let hits = [along - half_chord, along + half_chord];
    hits.into_iter().find(|&t| t > 0.0)
}

/// Distance to the image of the unit sphere under `axes`, moved to `center`: met in the sphere's
/// own space.
fn meet_ellipsoid(probe: &Probe, center: DVec3, axes: DMat3) -> Option<f64> {
    let to_sphere = axes.inverse();
    let direction = to_sphere * probe.direction;
    let stretch = direction.length();
    let probe = Probe {
        origin: to_sphere * (probe.origin - center),
        direction: direction / stretch,
    };
    Some(meet_sphere(&probe, DVec3::ZERO, 1.0)? / stretch)
}

fn meets_box(probe: &Probe, (low, high): &Box3) -> bool {
    let inverse = probe.direction.recip();
    let (mut enter, mut leave) = (0.0_f64, f64::INFINITY);
    for axis in 0..3 {
        let a = (low[axis] - probe.origin[axis]) * inverse[axis];
        let b = (high[axis] - probe.origin[axis]) * inverse[axis];
        // `max` and `min` drop the NaN of 0·∞: the probe lies in the face.
        enter = enter.max(a.min(b));
        leave = leave.min(a.max(b));
    }
    enter <= leave * (1.0 + 1e-12)
}

fn distance_to_box(p: DVec3, (low, high): &Box3) -> f64 {
    (*low - p).max(p - *high).max(DVec3::ZERO).length()
}
