//! Small lights that samples meet by chance: which of them rays are watched for nearly meeting
//! (`shaders/kernel/near_misses.wesl`).

use super::Prepared;
use super::shiny::Shiny;
use super::view::View;
use crate::accel::PrimitiveGeometry;
use crate::emitters::{Emitter, luminance_over_sphere, mean_emission, row_height, texel_luminance};
use crate::scene::{EnvironmentMap, EnvironmentRadiance, Light};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Most lights that are watched; they stand for the others.
pub const MAX_SMALL_LIGHTS: usize = 32;

/// How many times the solid angle of a pixel's rays, after they were reflected, a light and a lobe cover
/// together from which on samples meet them often enough.
const FOUND_OFTEN: f64 = 100.0;
/// Their solid angle from which on one sample in 63 meets them even where a pixel's rays go all ways.
const WIDEST: f64 = 0.2;

/// How many times the mean of an environment map a texel is that counts as a light.
const BRIGHT_TEXEL: f64 = 16.0;

/// How large a small light is, and which way it shines.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Extent {
    /// In all directions alike.
    Body {
        /// Radius of a sphere around it.
        radius: f64,
        /// Its area across the line of sight, on average.
        area: f64,
    },
    /// To the front, or to both sides.
    Planar {
        /// Radius of a sphere around it.
        radius: f64,
        /// Its normal times its area.
        area: DVec3,
        /// Whether its back shines as well.
        two_sided: bool,
    },
    /// From infinitely far away.
    Distant {
        /// Its solid angle, which may be 0.
        solid_angle: f64,
    },
    /// Has none, and shines into a cone.
    Point {
        /// Its axis.
        axis: DVec3,
        /// The cosine at the axis beyond which it does not shine; below −1 where it shines in all
        /// directions.
        cos_outer: f64,
    },
}

/// A small light, normalised space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SmallLight {
    /// Index of the light; none of a part of the environment.
    pub light: Option<u32>,
    /// Whether the camera may see it and it is not sampled there.
    pub is_in_view: bool,
    /// Its middle; of a distant one the unit direction to it.
    pub place: DVec3,
    /// How large it is.
    pub extent: Extent,
    /// Its radiance; the irradiance from a distant one, the radiant intensity of a point. Of one
    /// that stands for several as much more.
    pub strength: DVec3,
}

impl SmallLight {
    /// Its solid angle seen from distance 1, of a planar one at most.
    fn solid_angle(&self) -> f64 {
        match self.extent {
            Extent::Body { area, .. } => area,
            Extent::Planar { area, .. } => area.length(),
            Extent::Distant { solid_angle } => solid_angle,
            Extent::Point { .. } => 0.0,
        }
    }

    /// What it adds to the variance of what shows it in the solid angle `width`, at distance 1.
    fn weight(&self, width: f64) -> f64 {
        let irradiance = match self.extent {
            Extent::Body { .. } | Extent::Planar { .. } => self.solid_angle() * self.strength,
            Extent::Distant { .. } | Extent::Point { .. } => self.strength,
        };
        irradiance.length_squared() / width
    }
}

/// The small lights that samples of `prepared` meet by chance in an image of `view`: what mirrors, glass
/// and lobes may show, and of `in_view`, those that the camera sees and that are not sampled there, what
/// pixels do.
pub(super) fn small_lights(prepared: &Prepared, view: &View, in_view: &[u32]) -> Vec<SmallLight> {
    // Lobes, each with the solid angle below which what it shows is small.
    let limited = |shiny: &Shiny| (shiny.lobe, WIDEST.min(FOUND_OFTEN * shiny.spread(view)));
    let by_camera = limited(&Shiny::CAMERA);
    let by_materials: Vec<_> = prepared.shiny.iter().map(limited).collect();
    let lights = (0..).zip(&prepared.emitters.lights);
    let lights = lights.filter(|(index, _)| !by_materials.is_empty() || in_view.contains(index));
    let lights = lights.filter_map(|(index, light)| of_light(prepared, index, light));
    let lights = lights.chain(prepared.bright_texels.iter().copied());
    let small = lights.filter_map(|light| {
        let is_in_view = match light.light {
            Some(index) => in_view.contains(&index),
            None => view.shows_direction(light.place),
        };
        let shown_by = by_materials.iter().chain(is_in_view.then_some(&by_camera));
        let widths = shown_by.filter_map(|(lobe, limit)| {
            let width = light.solid_angle() + lobe;
            (width > 0.0 && width < *limit).then_some(width)
        });
        let weight = light.weight(widths.reduce(f64::min)?);
        let light = SmallLight {
            is_in_view,
            ..light
        };
        Some((weight, light))
    });
    let mut small: Vec<_> = small.collect();
    small.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    let sum = |lights: &[(f64, SmallLight)]| lights.iter().map(|(weight, _)| weight).sum::<f64>();
    let all = sum(&small);
    small.truncate(MAX_SMALL_LIGHTS);
    let factor = (all / sum(&small).max(f64::MIN_POSITIVE)).sqrt();
    let stronger = small.into_iter().map(|(_, light)| SmallLight {
        strength: factor * light.strength,
        ..light
    });
    stronger.collect()
}

fn of_light(prepared: &Prepared, index: u32, light: &Emitter) -> Option<SmallLight> {
    let (place, extent, strength) = match *light {
        Emitter::Area {
            primitive,
            radiance,
            two_sided,
            map,
        } => {
            let geometry = &prepared.data.primitives[primitive as usize].geometry;
            let (place, extent) = of_geometry(geometry, two_sided);
            let mean = mean_emission(map, &prepared.emitters.maps);
            (place, extent, radiance * mean)
        }
        Emitter::Sun(sun) => {
            let extent = Extent::Distant {
                solid_angle: sun.solid_angle(),
            };
            (-sun.direction, extent, sun.irradiance)
        }
        Emitter::Delta(light) => {
            let place = light
                .position()
                .unwrap_or_else(|| light.record().vectors[0]);
            (place, of_delta(light), light.strength())
        }
        Emitter::Environment => return None,
    };
    Some(SmallLight {
        light: Some(index),
        is_in_view: false,
        place,
        extent,
        strength,
    })
}

/// The extent of a light without a surface.
fn of_delta(light: Light) -> Extent {
    if light.position().is_none() {
        return Extent::Distant { solid_angle: 0.0 };
    }
    light.spread().map_or(
        Extent::Point {
            axis: DVec3::Z,
            cos_outer: -2.0,
        },
        |spread| Extent::Point {
            axis: spread.axis,
            cos_outer: (spread.full_angle + spread.falloff_angle).cos(),
        },
    )
}

/// The middle of a light with this geometry, and its extent.
fn of_geometry(geometry: &PrimitiveGeometry, two_sided: bool) -> (DVec3, Extent) {
    let (place, radius) = geometry.bounding_sphere();
    let extent = match geometry.vector_area() {
        Some(area) => Extent::Planar {
            radius,
            area,
            two_sided,
        },
        // A convex body's mean shadow (Cauchy 1841).
        None => Extent::Body {
            radius,
            area: 0.25 * geometry.area(),
        },
    };
    (place, extent)
}

/// The texels of the environment that are much brighter than it is on average, where mirrors, glass or
/// narrow lobes may show them.
pub(super) fn bright_texels(prepared: &Prepared) -> Vec<SmallLight> {
    let environment = prepared.data.scene.environment.as_ref();
    let environment = environment.filter(|_| !prepared.shiny.is_empty());
    let Some((environment, EnvironmentRadiance::Map(map))) = environment.map(|e| (e, &e.radiance))
    else {
        return Vec::new();
    };
    let EnvironmentMap {
        width,
        height,
        texels,
        ..
    } = map;
    let (columns, rows) = (f64::from(*width), f64::from(*height));
    let least = BRIGHT_TEXEL * luminance_over_sphere(map);
    let mut bright = Vec::new();
    for (row, texels) in texels.chunks_exact(*width as usize).enumerate() {
        let solid_angle = TAU / columns * row_height(row as f64, rows);
        let (sin, cos) = (PI * (row as f64 + 0.5) / rows).sin_cos();
        for (column, texel) in texels.iter().enumerate() {
            if texel_luminance(*texel) < least {
                continue;
            }
            let radiance = environment.scale * DVec3::from(texel.map(f64::from));
            let azimuth = TAU * (column as f64 + 0.5) / columns;
            let direction = DVec3::new(-azimuth.sin() * sin, cos, azimuth.cos() * sin);
            bright.push(SmallLight {
                light: None,
                is_in_view: false,
                place: environment.rotation * direction,
                extent: Extent::Distant { solid_angle },
                strength: solid_angle * radiance,
            });
        }
    }
    bright
}
