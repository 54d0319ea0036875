//! Which small lights the camera sees: those that camera rays would meet by chance alone.
//!
//! A light that covers the part p of a pixel, or of the lens as seen through the point in focus, is
//! met by that part of the pixel's samples: the variance of what it adds is (1 − p)/p times the
//! square of that, and an image without a hit does not show that anything is missing. Such a light
//! is sampled instead (`shaders/kernel/lights_in_view.wesl`) in all pixels that may show it.

use super::SceneData;
use crate::accel::PrimitiveGeometry;
use crate::emitters::{Emitter, Emitters, luminance};
use crate::scene::{Camera, FilmSize};
use glam::{DVec2, DVec3};
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Most lights that are sampled in view: those that matter most.
pub const MAX_LIGHTS_IN_VIEW: usize = 16;

/// Largest part of a pixel, or of its circle of confusion, that a light may cover: of a larger one
/// chance finds the edges as well as sampling does.
const LARGEST_PART: f64 = 0.5;

/// Half axes of an ellipsoid, longest over shortest, up to which rounding spares what is sampled of
/// it.
const FLATTEST: f64 = 100.0;

/// Areas in normalised space below which f32 might not hold them.
const SMALLEST_AREA: f64 = 1e-32;

/// A small light that the camera sees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightInView {
    /// Index of the light.
    pub light: u32,
    /// The middles of the pixels that may show it lie from here to
    pub low: DVec2,
    /// here, in pixels from the upper left corner.
    pub high: DVec2,
    /// Whether its circle of confusion is larger than a pixel: points of the lens are chosen by it,
    /// else points of the film.
    pub out_of_focus: bool,
}

impl LightInView {
    /// Whether the pixel in column `x` and row `y` may show it.
    pub fn is_near(&self, x: u32, y: u32) -> bool {
        let middle = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        middle.cmpge(self.low).all() && middle.cmple(self.high).all()
    }
}

/// The small lights among `emitters` that `camera` sees on a film of `size`, in the order of their
/// indices: those that add most to the sum of the pixels' squares.
///
/// Cameras whose rays are parallel, or begin before the eye because that is far away, have none;
/// nor have lights with an opacity, and very flat ellipsoids.
pub fn lights_in_view(
    data: &SceneData,
    camera: &Camera,
    size: FilmSize,
    emitters: &Emitters,
) -> Vec<LightInView> {
    let distant = super::near_plane::is_distant(&data.normalization, camera);
    if camera.is_orthographic() || distant {
        return Vec::new();
    }
    let view = View::new(data.normalization.camera(camera), size, data);
    let lights = (0..).zip(&emitters.lights);
    let seen: Vec<Seen> = lights
        .filter_map(|(index, light)| view.sees(index, light, data))
        .collect();
    // The pieces of a mesh are one light.
    let mut parts: BTreeMap<Option<u32>, f64> = BTreeMap::new();
    for seen in &seen {
        *parts.entry(seen.shape).or_default() += seen.part;
    }
    let is_small = |seen: &Seen| match seen.shape {
        Some(_) => parts[&seen.shape] <= LARGEST_PART,
        None => seen.part <= LARGEST_PART,
    };
    let mut small: Vec<Seen> = seen.into_iter().filter(is_small).collect();
    small.sort_by(|a, b| b.square.total_cmp(&a.square));
    small.truncate(MAX_LIGHTS_IN_VIEW);
    small.sort_by_key(|seen| seen.light.light);
    small.into_iter().map(|seen| seen.light).collect()
}

/// A light in view, and what decides whether it is sampled.
struct Seen {
    light: LightInView,
    /// Index of its shape; suns have none.
    shape: Option<u32>,
    /// The part of a pixel, or of its circle of confusion, that it covers.
    part: f64,
    /// What it adds to the sum of the pixels' squares, in an arbitrary unit.
    square: f64,
}

/// What a camera sees, normalised space.
struct View {
    camera: Camera,
    /// Pixels per unit of the plane at distance 1.
    scale: f64,
    size: DVec2,
    /// How far from its middle a pixel's filter reaches, in pixels.
    reach: f64,
}

impl View {
    fn new(camera: Camera, size: FilmSize, data: &SceneData) -> Self {
        let height = f64::from(size.height);
        Self {
            scale: 0.5 * height / camera.half_height(),
            camera,
            size: DVec2::new(f64::from(size.width), height),
            reach: data.scene.filter.radius,
        }
    }

    /// Light number `index`, where it is in view.
    fn sees(&self, index: u32, light: &Emitter, data: &SceneData) -> Option<Seen> {
        match *light {
            Emitter::Area {
                primitive,
                radiance,
                two_sided,
                ..
            } => {
                let of = &data.primitives[primitive as usize];
                let material = &data.scene.materials[of.material.index()];
                let opacity = data.attributes.of_primitive[primitive as usize].opacity;
                // The back of a surface with one side emits nothing.
                let back_alone = two_sided && !material.double_sided;
                if opacity || back_alone || is_flat_ellipsoid(&of.geometry) {
                    return None;
                }
                let (middle, radius) = bounding_sphere(&of.geometry);
                let to_middle = middle - self.camera.eye;
                let area = facing_area(&of.geometry, to_middle);
                if area < SMALLEST_AREA {
                    return None;
                }
                let solid_angle = area / to_middle.length_squared();
                self.place(index, to_middle, radius, solid_angle, luminance(radiance))
                    .map(|seen| Seen {
                        shape: Some(of.shape.0),
                        ..seen
                    })
            }
            Emitter::Sun(sun) => {
                let far = 1e6 * data.normalization.reach.max(self.camera.eye.length());
                let radius = far * sun.angular_radius.tan();
                let solid_angle = 4.0 * PI * (0.5 * sun.angular_radius).sin().powi(2);
                let radiance = luminance(sun.radiance());
                self.place(index, -far * sun.direction, radius, solid_angle, radiance)
            }
            Emitter::Delta(_) | Emitter::Environment => None,
        }
    }

    /// Where a light within the sphere of `radius` at `to_middle` from the eye lies on the film.
    fn place(
        &self,
        light: u32,
        to_middle: DVec3,
        radius: f64,
        solid_angle: f64,
        radiance: f64,
    ) -> Option<Seen> {
        let Camera {
            right, up, lens, ..
        } = self.camera;
        let depth = to_middle.dot(self.camera.forward);
        let nearest = depth - radius;
        if solid_angle <= 0.0 || nearest <= radius + 2.0 * lens.radius {
            return None;
        }
        let across = DVec2::new(to_middle.dot(right), -to_middle.dot(up)) / depth;
        let stretch = 1.0 + across.length_squared();
        let blur = |depth: f64| lens.radius * (1.0 / depth - 1.0 / lens.focus_distance).abs();
        let largest_blur = blur(nearest).max(blur(depth + radius));
        let extent = self.scale * (stretch * radius / nearest + largest_blur) + self.reach;
        let middle = self.scale * across + 0.5 * self.size;
        let (low, high) = (middle - extent, middle + extent);
        if high.cmplt(DVec2::ZERO).any() || low.cmpgt(self.size).any() {
            return None;
        }
        let pixels = self.scale * self.scale * solid_angle * stretch.powf(1.5);
        let circle = PI * (self.scale * blur(depth)).powi(2);
        let out_of_focus = circle > 1.0 && (depth - lens.focus_distance).abs() > 2.0 * radius;
        let spread = if out_of_focus { circle } else { 1.0 };
        Some(Seen {
            light: LightInView {
                light,
                low,
                high,
                out_of_focus,
            },
            shape: None,
            part: pixels / spread,
            square: (pixels * radiance).powi(2) / spread,
        })
    }
}

fn is_flat_ellipsoid(geometry: &PrimitiveGeometry) -> bool {
    match *geometry {
        PrimitiveGeometry::Ellipsoid { radii, .. } => {
            radii.max_element() > FLATTEST * radii.min_element()
        }
        _ => false,
    }
}

/// Middle and radius of a sphere around it.
fn bounding_sphere(geometry: &PrimitiveGeometry) -> (DVec3, f64) {
    let (low, high) = geometry.bounds();
    (0.5 * (low + high), 0.5 * (high - low).length())
}

/// At most the area of what a viewer in the direction `to_middle` sees of it, across that
/// direction.
fn facing_area(geometry: &PrimitiveGeometry, to_middle: DVec3) -> f64 {
    let direction = to_middle.normalize();
    let facing = |u: DVec3, v: DVec3| u.cross(v).dot(direction).abs();
    match *geometry {
        PrimitiveGeometry::Triangle { u, v, .. } => 0.5 * facing(u, v),
        PrimitiveGeometry::Rectangle { u, v, .. } => facing(u, v),
        PrimitiveGeometry::Disk { u, v, .. } => PI * facing(u, v),
        PrimitiveGeometry::Sphere { radius, .. } => PI * radius * radius,
        PrimitiveGeometry::Ellipsoid { radii, .. } => PI * radii.max_element().powi(2),
    }
}
