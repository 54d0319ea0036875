//! Small lights that samples meet by chance: which of them rays are watched for nearly meeting
//! (`shaders/kernel/near_misses.wesl`).

use super::Prepared;
use crate::accel::PrimitiveGeometry;
use crate::effects::Effect;
use crate::emitters::{Emitter, luminance_over_sphere, mean_emission, row_height, texel_luminance};
use crate::scene::{Camera, EnvironmentMap, EnvironmentRadiance, FilmSize, Light};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Most lights that are watched; they stand for the others.
pub const MAX_SMALL_LIGHTS: usize = 32;

/// How many times the solid angle of a pixel a light and a lobe cover together, seen from the middle
/// of the scene, from which on they are so large that samples meet them also where a curved surface
/// makes them smaller.
const LARGE: f64 = 1000.0;

/// Width of lobes from which on highlights are found often enough.
const WIDE_LOBE: f64 = 0.03;

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

    /// What it adds to the variance of what a lobe of the solid angle `lobe` shows, at distance 1.
    fn weight(&self, lobe: f64) -> f64 {
        let solid_angle = self.solid_angle();
        let irradiance = match self.extent {
            Extent::Body { .. } | Extent::Planar { .. } => solid_angle * self.strength,
            Extent::Distant { .. } | Extent::Point { .. } => self.strength,
        };
        irradiance.length_squared() / (solid_angle + lobe)
    }
}

/// The solid angle of the narrowest lobe that shows lights, as in `note_highlight`: 0 of mirrors and
/// glass; `None` where all are wide.
fn narrowest_lobe(prepared: &Prepared) -> Option<f64> {
    if prepared.effects.contains(Effect::Specular) {
        return Some(0.0);
    }
    if !prepared.effects.contains(Effect::Glossy) {
        return None;
    }
    let materials = prepared.data.scene.materials.iter();
    let lobes = materials.filter_map(|m| m.bsdf.parameters().specular);
    let widths = lobes.map(|lobe| lobe.alpha).filter(|alpha| *alpha > 0.0);
    let narrowest = widths.fold(f64::INFINITY, f64::min);
    (narrowest < WIDE_LOBE).then_some(12.0 * PI * narrowest * narrowest)
}

/// The small lights that samples of `prepared` meet by chance where `camera` takes an image of `film`
/// pixels: all that mirrors, glass and narrow lobes may show, or else `in_view`, those that the camera
/// sees and that are not sampled there.
pub(super) fn small_lights(
    prepared: &Prepared,
    (camera, film): (&Camera, FilmSize),
    in_view: &[u32],
) -> Vec<SmallLight> {
    let shown = narrowest_lobe(prepared);
    let lobe = shown.unwrap_or(0.0);
    let large = LARGE * pixel_solid_angle(&prepared.data.normalization.camera(camera), film);
    let lights = (0..).zip(&prepared.emitters.lights);
    let watched = lights.filter(|(index, _)| shown.is_some() || in_view.contains(index));
    let lights = watched.filter_map(|(index, light)| of_light(prepared, index, light));
    let small = lights.chain(prepared.bright_texels.iter().copied());
    let small = small.filter(|light| {
        let width = light.solid_angle() + lobe;
        width > 0.0 && width < large
    });
    let mut small: Vec<_> = small.collect();
    small.sort_by(|a, b| b.weight(lobe).total_cmp(&a.weight(lobe)));
    let sum = |lights: &[SmallLight]| lights.iter().map(|light| light.weight(lobe)).sum::<f64>();
    let all = sum(&small);
    small.truncate(MAX_SMALL_LIGHTS);
    let factor = (all / sum(&small).max(f64::MIN_POSITIVE)).sqrt();
    for light in &mut small {
        light.strength *= factor;
    }
    small
}

/// Of a camera whose rays are parallel, that of a pixel seen from distance 1.
fn pixel_solid_angle(camera: &Camera, film: FilmSize) -> f64 {
    let side = 2.0 * camera.half_height() / f64::from(film.height);
    side * side
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
    let environment = environment.filter(|_| narrowest_lobe(prepared).is_some());
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
                place: environment.rotation * direction,
                extent: Extent::Distant { solid_angle },
                strength: solid_angle * radiance,
            });
        }
    }
    bright
}
