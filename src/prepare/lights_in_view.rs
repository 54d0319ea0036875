//! Which lights are sampled where the camera sees them (`shaders/kernel/lights_in_view.wesl`).
//!
//! A light that covers the part p of a pixel, or of the lens as seen through the point in focus, is
//! met by that part of the pixel's samples: the variance of what it adds is (1 − p)/p times the
//! square of that, and an image without a hit does not show that anything is missing. Of such lights
//! points are chosen on the light. Larger lights are noisy where their edges cross pixels; as lights
//! are brighter than what they light, that is most of the noise of many an image. There each sample
//! has several points of the pixel.

use super::SceneData;
use super::view::{Outline, View};
use crate::accel::PrimitiveGeometry;
use crate::emitters::{Emitter, Emitters, luminance};
use glam::{DVec2, DVec3};
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Most lights that are sampled in view: those that matter most.
pub const MAX_LIGHTS_IN_VIEW: usize = 16;
/// Points of a light that a sample has at most.
pub const MOST_POINTS: u32 = 64;

/// Largest part of a pixel, or of its circle of confusion, that a light may cover whose points are
/// chosen on it: of a larger one chance finds the edges as well.
const LARGEST_PART: f64 = 0.5;
/// Rays to lights in view that a sample may have on average over the image.
const RAYS_PER_SAMPLE: f64 = 2.0;
/// Points of the pixel that are better than what chance finds of an edge.
const FEWEST_POINTS_OF_PIXEL: u32 = 4;
/// Half axes of an ellipsoid, longest over shortest, up to which rounding spares what is sampled of
/// it.
const FLATTEST: f64 = 100.0;
/// Areas in normalised space below which f32 might not hold their squares.
const SMALLEST_AREA: f64 = 1e-16;

/// How points of a light in view are chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PointsInView {
    /// On the light, to be seen from the lens, somewhere on the film.
    OfFilm,
    /// On the light, to be seen through the point in focus, from somewhere on the lens.
    OfLens,
    /// In the pixel.
    OfPixel,
}

/// A light that is sampled in view of the camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightInView {
    /// Index of the light.
    pub light: u32,
    /// The middles of the pixels that may show it lie from here to
    pub low: DVec2,
    /// here, in pixels from the upper left corner.
    pub high: DVec2,
    /// How its points are chosen.
    pub points: PointsInView,
    /// How many a sample has: a power of two, [`MOST_POINTS`] at most.
    pub per_sample: u32,
}

impl LightInView {
    /// Whether the pixel in column `x` and row `y` may show it.
    pub fn is_near(&self, x: u32, y: u32) -> bool {
        let middle = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        middle.cmpge(self.low).all() && middle.cmple(self.high).all()
    }
}

/// What a camera sees of lights.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct InView {
    /// Those that are sampled there, in the order of their indices.
    pub sampled: Vec<LightInView>,
    /// Small ones that are left to chance.
    pub left_to_chance: Vec<u32>,
}

/// The lights among `emitters` that lie in `view`. Those are sampled that add most to the sum of the
/// pixels' variances; lights with an opacity and very flat ellipsoids never.
pub(super) fn lights_in_view(view: &View, data: &SceneData, emitters: &Emitters) -> InView {
    let lights = (0..).zip(&emitters.lights);
    let mut seen: Vec<Seen> = lights
        .filter_map(|(index, light)| view.sees(index, light, data))
        .collect();
    seen.sort_by(|a, b| b.variance().total_cmp(&a.variance()));
    // The pieces of a mesh are one light.
    let mut parts: BTreeMap<u32, f64> = BTreeMap::new();
    for (shape, part) in seen
        .iter()
        .filter_map(|seen| Some((seen.shape?, seen.part)))
    {
        *parts.entry(shape).or_default() += part;
    }
    let mut sampled = Vec::new();
    let mut left_to_chance = Vec::new();
    let mut rays_left = RAYS_PER_SAMPLE * view.size.element_product();
    for mut seen in seen {
        let is_small = seen.shape.map_or(seen.part, |shape| parts[&shape]) <= LARGEST_PART;
        if !is_small {
            seen.light.points = PointsInView::OfPixel;
            seen.light.per_sample = FEWEST_POINTS_OF_PIXEL;
        }
        let can_be_sampled = seen.can_be_sampled && !(is_small && view.leaves_small_lights);
        let has_room = sampled.len() < MAX_LIGHTS_IN_VIEW && (is_small || seen.rays() <= rays_left);
        if can_be_sampled && has_room {
            rays_left -= seen.rays();
            sampled.push(seen);
        } else if is_small {
            left_to_chance.push(seen.light.light);
        }
    }
    for seen in &mut sampled {
        while seen.light.per_sample < MOST_POINTS && seen.rays() <= rays_left {
            rays_left -= seen.rays();
            seen.light.per_sample *= 2;
        }
    }
    let mut sampled: Vec<_> = sampled.into_iter().map(|seen| seen.light).collect();
    sampled.sort_by_key(|light| light.light);
    InView {
        sampled,
        left_to_chance,
    }
}

/// A light in view, and what decides whether it is sampled.
struct Seen {
    light: LightInView,
    /// Whether what is sampled of it would be right.
    can_be_sampled: bool,
    /// Index of its shape; suns have none.
    shape: Option<u32>,
    /// The part of a pixel, or of its circle of confusion, that it covers.
    part: f64,
    /// Pixels that it covers.
    pixels: f64,
    /// Pixels in which it is sampled: those that may show it, or that its edges cross.
    sampled_pixels: f64,
    radiance: f64,
}

impl Seen {
    /// What a sample of each pixel adds to the sum of their variances if chance finds it.
    fn variance(&self) -> f64 {
        self.radiance * self.radiance * self.pixels.min(self.sampled_pixels)
    }

    /// Rays that a sample of each pixel sends to it, at most.
    fn rays(&self) -> f64 {
        f64::from(self.light.per_sample) * self.sampled_pixels
    }
}

impl View {
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
                let (middle, radius) = of.geometry.bounding_sphere();
                let to_middle = middle - self.camera.eye;
                let direction = if self.camera.is_orthographic() {
                    self.camera.forward
                } else {
                    to_middle.normalize()
                };
                let area = facing_area(&of.geometry, direction);
                let corners = corners(&of.geometry).map(|c| c.map(|c| c - self.camera.eye));
                let outline = Outline {
                    to_middle,
                    radius,
                    corners,
                };
                let place = self.place(index, &outline, area, luminance(radiance))?;
                Some(Seen {
                    shape: Some(of.shape.0),
                    can_be_sampled: !opacity
                        && !back_alone
                        && !is_flat_ellipsoid(&of.geometry)
                        && area > SMALLEST_AREA,
                    ..place
                })
            }
            Emitter::Sun(sun) => {
                let far = 1e6 * data.normalization.reach.max(self.camera.eye.length());
                let radius = far * sun.angular_radius.tan();
                let area = PI * radius * radius;
                let radiance = luminance(sun.radiance());
                let outline = Outline {
                    to_middle: -far * sun.direction,
                    radius,
                    corners: None,
                };
                self.place(index, &outline, area, radiance)
            }
            Emitter::Delta(_) | Emitter::Environment => None,
        }
    }

    /// Where a light within `outline` lies on the film; `area` is what the eye sees of it, across the
    /// line of sight.
    fn place(&self, light: u32, outline: &Outline, area: f64, radiance: f64) -> Option<Seen> {
        let Outline {
            to_middle, radius, ..
        } = *outline;
        let lens = self.camera.lens;
        let depth = to_middle.dot(self.camera.forward);
        let behind = depth - radius <= radius + 2.0 * lens.radius;
        if area <= 0.0 || (behind && !self.camera.is_orthographic()) {
            return None;
        }
        let (low, high) = self.bounds(outline);
        if high.cmplt(DVec2::ZERO).any() || low.cmpgt(self.size).any() {
            return None;
        }
        let pixels = self.scale * self.scale * area * self.stretch(to_middle).powf(1.5)
            / self.squared_distance(to_middle);
        let circle = PI * (self.scale * self.blur(depth)).powi(2);
        let out_of_focus = circle > 1.0 && (depth - lens.focus_distance).abs() > 2.0 * radius;
        let shown = high.min(self.size) - low.max(DVec2::ZERO);
        let sampled = if lens.radius > 0.0 {
            shown.x * shown.y
        } else {
            // Those that the circumference of a convex shape crosses, and those that it touches.
            2.0 * (shown.x + shown.y) * (2.0 * self.reach).max(1.0)
        };
        Some(Seen {
            light: LightInView {
                light,
                low,
                high,
                points: if out_of_focus {
                    PointsInView::OfLens
                } else {
                    PointsInView::OfFilm
                },
                per_sample: 1,
            },
            shape: None,
            can_be_sampled: true,
            part: pixels / if out_of_focus { circle } else { 1.0 },
            pixels,
            sampled_pixels: sampled.min(shown.x * shown.y),
            radiance,
        })
    }
}

/// Corners of a triangle, or of a parallelogram around another planar one.
fn corners(geometry: &PrimitiveGeometry) -> Option<[DVec3; 4]> {
    match *geometry {
        // The fourth is one of the three again.
        PrimitiveGeometry::Triangle { a, u, v } => Some([a, a + u, a + v, a]),
        PrimitiveGeometry::Rectangle { a, u, v } => Some([a, a + u, a + v, a + u + v]),
        PrimitiveGeometry::Disk { a, u, v } => Some([a - u - v, a + u - v, a - u + v, a + u + v]),
        PrimitiveGeometry::Sphere { .. } | PrimitiveGeometry::Ellipsoid { .. } => None,
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

/// At most the area of what a viewer sees of it in the unit direction `direction`, across that.
fn facing_area(geometry: &PrimitiveGeometry, direction: DVec3) -> f64 {
    match geometry.vector_area() {
        Some(area) => area.dot(direction).abs(),
        None => PI * geometry.bounding_sphere().1.powi(2),
    }
}
