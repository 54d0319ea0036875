//! Everything that emits, as one list, and which of it light sampling chooses.

pub mod area_map;
mod emission_map;
mod environment;
mod light_groups;
mod selection;
pub mod tree;
pub mod unit;

pub use emission_map::EmissionMap;
pub use environment::EnvironmentGrid;
pub use light_groups::EmitterGroups;
pub use selection::Selection;
pub use tree::LightTree;

use crate::accel::Primitive;
use crate::scene::normalize::Normalization;
use crate::scene::{
    Emission, Environment, EnvironmentMap, EnvironmentRadiance, EstimatorSettings, Light,
    LightSelection, RenderSettings, Scene, SunLight,
};
use emission_map::{Varies, of_primitives};
use glam::DVec3;
use selection::selection_for;
use std::f64::consts::PI;
use tree::TreeLight;

/// One light, in normalised space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Emitter {
    /// A primitive that emits.
    Area {
        /// Index of the primitive, in leaf order.
        primitive: u32,
        /// Radiance; where a texture varies it, the factor on that.
        radiance: DVec3,
        /// Whether its back emits as well.
        two_sided: bool,
        /// Index of the [`EmissionMap`] that varies the radiance.
        map: Option<u32>,
    },
    /// A light without extent, in normalised space.
    Delta(Light),
    /// A sun.
    Sun(SunLight),
    /// The environment.
    Environment,
}

/// The lights of a scene and how one of them is chosen.
#[derive(Debug, Clone, PartialEq)]
pub struct Emitters {
    /// The lights. Those without power are left out.
    pub lights: Vec<Emitter>,
    /// How light sampling chooses; `None` where it has nothing to choose from.
    pub selection: Option<Selection>,
    /// How a direction towards the environment map is chosen, where there is a map that emits.
    pub environment: Option<EnvironmentGrid>,
    /// Emission that varies over lights.
    pub maps: Vec<EmissionMap>,
    /// Their groups, where the image keeps these apart.
    pub groups: EmitterGroups,
    /// Radiance that the GPU has as 1; see [`mod@unit`].
    pub unit: f64,
}

/// Rec. 709 luminance.
pub fn luminance(rgb: DVec3) -> f64 {
    rgb.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

/// Whether anything is emitted at all.
pub fn is_lit(rgb: DVec3) -> bool {
    rgb.max_element() > 0.0
}

impl Default for Emitters {
    fn default() -> Self {
        Self {
            lights: Vec::new(),
            selection: None,
            environment: None,
            maps: Vec::new(),
            groups: EmitterGroups::default(),
            unit: 1.0,
        }
    }
}

impl Emitters {
    /// The primitives that emit.
    pub fn primitives(&self) -> impl Iterator<Item = u32> {
        self.lights.iter().filter_map(|light| match light {
            Emitter::Area { primitive, .. } => Some(*primitive),
            Emitter::Delta(_) | Emitter::Sun(_) | Emitter::Environment => None,
        })
    }

    /// Lists the lights of `scene`, whose primitives are `primitives`, as `settings` sample them.
    ///
    /// With strategies that do not sample lights only those without a surface are ever chosen:
    /// nothing else reaches them.
    pub fn new(
        scene: &Scene,
        normalization: &Normalization,
        primitives: &[Primitive],
        settings: &RenderSettings,
    ) -> Self {
        let Surfaces {
            mut lights,
            mut power,
            mut groups,
            maps,
        } = Surfaces::new(scene, primitives, normalization.radius);
        // Suns stand together.
        let is_sun = |(_, light): &(usize, &Light)| matches!(light, Light::Sun(_));
        let named = || scene.lights.iter().enumerate();
        let points = named().filter(|light| !is_sun(light));
        for (index, light) in points.chain(named().filter(is_sun)) {
            let light = light.normalized(normalization);
            let of_light = light.power_of_strength(normalization.radius)
                * luminance(light.strength())
                * part_that_arrives(light.position(), normalization.radius);
            if of_light > 0.0 {
                power.push(of_light);
                lights.push(match light {
                    Light::Sun(sun) => Emitter::Sun(sun),
                    delta => Emitter::Delta(delta),
                });
                groups.push(scene.light_groups.of_light(index));
            }
        }
        let mut grid = None;
        if let Some(environment) = &scene.environment {
            let of_environment = environment_power(environment, normalization.radius);
            if of_environment > 0.0 {
                power.push(of_environment);
                lights.push(Emitter::Environment);
                groups.push(scene.light_groups.of_environment());
                if let EnvironmentRadiance::Map(map) = &environment.radiance {
                    grid = if settings.estimator.mis_compensation
                        && settings.estimator.strategy.is_mis()
                    {
                        EnvironmentGrid::compensated(map)
                    } else {
                        EnvironmentGrid::new(map)
                    };
                }
            }
        }
        let (selection, weights) = weights(&settings.estimator, &lights, &power);
        let tree = match selection {
            LightSelection::Tree => tree_over(&lights, &weights, primitives, &maps),
            _ => None,
        };
        let unit = unit::of(scene, &lights, &maps);
        let table = || Selection::new(&weights, selection);
        Self {
            selection: tree.map(Selection::Tree).or_else(table),
            lights,
            environment: grid,
            maps,
            groups: EmitterGroups::new(scene, settings, &groups),
            unit,
        }
    }

    /// Index of the environment among the lights.
    pub fn index_of_environment(&self) -> Option<usize> {
        let mut lights = self.lights.iter();
        lights.position(|light| *light == Emitter::Environment)
    }

    /// Probability with which a light sample is one of light `index`: with a tree averaged over
    /// surfaces, 1 where every light has its own.
    pub fn probability(&self, index: usize) -> f64 {
        self.selection
            .as_ref()
            .map_or(0.0, |selection| selection.probability(index))
    }

    /// Light samples of a camera ray that go to light `index`, on average: n·p, which is what
    /// multiplies the density of light sampling when several samples are taken (Veach 1997, eq.
    /// 9.8). `rays` is the number of shadow rays. Where every light has its own, those without
    /// extent have one: a second would be the same.
    pub fn samples(&self, index: usize, rays: u32) -> f64 {
        let rays = if self.takes_one(index) { 1 } else { rays };
        f64::from(rays) * self.probability(index)
    }

    /// Whether light `index` has one sample whatever the number of shadow rays.
    pub fn takes_one(&self, index: usize) -> bool {
        let own = matches!(self.selection, Some(Selection::All(_)));
        own && matches!(self.lights[index], Emitter::Delta(_))
    }

    /// Index of the first sun, and how many there are.
    pub fn suns(&self) -> (usize, usize) {
        let is_sun = |light: &Emitter| matches!(light, Emitter::Sun(_));
        let first = self.lights.iter().position(is_sun).unwrap_or(0);
        let count = self.lights.iter().filter(|light| is_sun(light)).count();
        (first, count)
    }

    /// The lights that light sampling chooses.
    pub fn sampled(&self) -> impl Iterator<Item = &Emitter> {
        let lights = self.lights.iter().enumerate();
        let sampled = lights.filter(|(index, _)| self.probability(*index) > 0.0);
        sampled.map(|(_, light)| light)
    }
}

/// The primitives that emit.
#[derive(Default)]
struct Surfaces {
    lights: Vec<Emitter>,
    power: Vec<f64>,
    groups: Vec<Option<u32>>,
    maps: Vec<EmissionMap>,
}

impl Surfaces {
    fn new(scene: &Scene, primitives: &[Primitive], radius: f64) -> Self {
        let emission = |p: &Primitive| {
            let emission = scene.shapes[p.shape.index()].emission;
            emission.filter(|e| is_lit(e.radiance))
        };
        let lit: Vec<(u32, Emission)> = (0..)
            .zip(primitives)
            .filter_map(|(index, p)| Some((index, emission(p)?)))
            .collect();
        let emitting = lit.iter().map(|(index, _)| &primitives[*index as usize]);
        let mut surfaces = Self::default();
        for (&(index, emission), varies) in lit.iter().zip(of_primitives(scene, emitting)) {
            let primitive = &primitives[index as usize];
            if surfaces.add(index, primitive, emission, varies) {
                let (low, high) = primitive.geometry.bounds();
                let nearest = DVec3::ZERO.clamp(low, high);
                if let Some(power) = surfaces.power.last_mut() {
                    *power *= part_that_arrives(Some(nearest), radius);
                }
                let group = scene.light_groups.of_shape(primitive.shape);
                surfaces.groups.push(group);
            }
        }
        surfaces
    }

    /// Adds primitive `index`, unless it is dark.
    fn add(
        &mut self,
        index: u32,
        primitive: &Primitive,
        emission: Emission,
        varies: Varies,
    ) -> bool {
        let (mean, map) = match varies {
            Varies::Dark => return false,
            Varies::Not => (DVec3::ONE, None),
            Varies::Textured(mut map) => {
                let before = self.maps.last();
                map.first_cell = before.map_or(0, |m| m.first_cell + m.grid[0] * m.grid[1]);
                self.maps.push(*map);
                let index = self.maps.len() - 1;
                (self.maps[index].mean, Some(index as u32))
            }
        };
        let sides = if emission.two_sided { 2.0 } else { 1.0 };
        let area = primitive.geometry.area();
        self.power
            .push(sides * PI * area * luminance(emission.radiance * mean));
        self.lights.push(Emitter::Area {
            primitive: index,
            radiance: emission.radiance,
            two_sided: emission.two_sided,
            map,
        });
        true
    }
}

/// How `lights` are selected, and the weights that they are chosen by; 0 where a light is not sampled.
fn weights(
    settings: &EstimatorSettings,
    lights: &[Emitter],
    power: &[f64],
) -> (LightSelection, Vec<f64>) {
    let samples_all = settings.strategy.samples_lights();
    let is_sampled = |light: &Emitter| samples_all || matches!(light, Emitter::Delta(_));
    let sampled = lights.iter().filter(|light| is_sampled(light)).count();
    let selection = selection_for(settings.light_selection, sampled);
    let weight = |(light, &power): (&Emitter, &f64)| match selection {
        _ if !is_sampled(light) => 0.0,
        LightSelection::Power => power,
        _ => 1.0,
    };
    (selection, lights.iter().zip(power).map(weight).collect())
}

/// The light tree over those `lights` whose weight is positive. `None` where fewer than two of them
/// are at a finite distance: the tree's rule then gives all the same probability.
fn tree_over(
    lights: &[Emitter],
    weights: &[f64],
    primitives: &[Primitive],
    maps: &[EmissionMap],
) -> Option<LightTree> {
    let mut finite = Vec::new();
    let mut infinite = Vec::new();
    let sampled = (0..).zip(lights).zip(weights).filter(|(_, w)| **w > 0.0);
    for ((index, light), _) in sampled {
        let light = match light {
            Emitter::Area {
                primitive,
                radiance,
                two_sided,
                map,
            } => {
                let geometry = &primitives[*primitive as usize].geometry;
                let radiance = luminance(*radiance * mean_emission(*map, maps));
                Some(TreeLight::area(index, geometry, radiance, *two_sided))
            }
            Emitter::Delta(light) => TreeLight::delta(index, light),
            Emitter::Sun(_) | Emitter::Environment => None,
        };
        match light {
            Some(light) => finite.push(light),
            None => infinite.push(index),
        }
    }
    LightTree::new(&finite, infinite, lights.len())
}

/// Distance from the centre, in radii of what is rendered, beyond which a light counts for what
/// arrives.
const FAR: f64 = 64.0;

/// Part of a light's power that counts when lights are chosen: all of one that is near; of one that
/// is far away, whose power may be that of the Sun, what falls on the sphere of `radius`, as with
/// light from infinitely far. `nearest` is the light's point nearest to the centre; infinitely
/// distant lights have none.
fn part_that_arrives(nearest: Option<DVec3>, radius: f64) -> f64 {
    let distance = nearest.map_or(0.0, DVec3::length);
    if distance > FAR * radius {
        (radius / distance).powi(2)
    } else {
        1.0
    }
}

fn environment_power(environment: &Environment, radius: f64) -> f64 {
    let mean = match &environment.radiance {
        EnvironmentRadiance::Constant(radiance) => luminance(*radiance),
        EnvironmentRadiance::Map(map) => luminance_over_sphere(map),
    };
    4.0 * PI * PI * radius * radius * mean * environment.scale
}

/// Mean luminance of a map over the sphere, each texel by its own solid angle.
pub fn luminance_over_sphere(map: &EnvironmentMap) -> f64 {
    let height = f64::from(map.height);
    let width = map.width as usize;
    let rows = map.texels.chunks_exact(width).enumerate();
    let rows = rows.map(|(row, texels)| {
        let sum: f64 = texels.iter().map(|t| texel_luminance(*t)).sum();
        0.5 * row_height(row as f64, height) * sum / width as f64
    });
    rows.sum()
}

/// Mean factor of the emission map `map` of a light, of `maps`, on its radiance; 1 without one.
pub fn mean_emission(map: Option<u32>, maps: &[EmissionMap]) -> DVec3 {
    map.map_or(DVec3::ONE, |map| maps[map as usize].mean)
}

/// Luminance of a texel.
pub fn texel_luminance(texel: [f32; 3]) -> f64 {
    luminance(DVec3::from(texel.map(f64::from)))
}

/// Height in z = cosθ of row `row` of a latitude-longitude map: 2 sin(π (row+½)/H) sin(π/2H).
pub fn row_height(row: f64, height: f64) -> f64 {
    2.0 * (PI * (row + 0.5) / height).sin() * (PI / (2.0 * height)).sin()
}
