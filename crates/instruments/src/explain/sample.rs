//! What one sample takes: rays, and random numbers.

use direkt::low_level::effects::Effect;
use direkt::low_level::emitters::Emitter;
use direkt::low_level::prepare::Prepared;
use serde::Serialize;

/// Rays of one sample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Rays {
    /// From the camera.
    pub camera: f64,
    /// Towards lights.
    pub shadow: f64,
    /// In directions that are chosen without regard to lights.
    pub bsdf: f64,
}

impl Rays {
    /// All of them.
    pub fn total(&self) -> f64 {
        self.camera + self.shadow + self.bsdf
    }
}

/// The most rays that a sample takes. A sample that meets nothing has one, and what a surface
/// reflects nothing of is not traced.
pub fn most_rays(prepared: &Prepared) -> Rays {
    let calls_for = |effect| prepared.effects.contains(effect);
    let sampled = calls_for(Effect::SampleLights);
    Rays {
        camera: 1.0,
        shadow: if sampled {
            prepared.most_light_samples()
        } else {
            0.0
        },
        bsdf: f64::from(u8::from(calls_for(Effect::SampleBsdf))),
    }
}

/// Random numbers for one purpose: see the groups of dimensions in `shaders/core/sampler.wesl`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct RandomNumbers {
    /// What they choose.
    pub purpose: &'static str,
    /// The first dimension; 64 and those behind it belong to the points of several shadow rays.
    pub first: u32,
    /// Dimensions from there.
    pub dimensions: u32,
    /// How often they are drawn for one sample.
    pub times: u32,
}

impl RandomNumbers {
    /// Numbers per sample.
    pub fn count(&self) -> u32 {
        self.dimensions * self.times
    }
}

/// The random numbers that one sample of `prepared` uses, where it meets a surface; those for mirrors
/// and glass before it, and for lights that are sampled in view, come on top.
pub fn random_numbers(prepared: &Prepared) -> Vec<RandomNumbers> {
    let calls_for = |effect| prepared.effects.contains(effect);
    let mut numbers = Vec::new();
    let mut add = |needed: bool, purpose, first, dimensions, times| {
        if needed && times > 0 {
            numbers.push(RandomNumbers {
                purpose,
                first,
                dimensions,
                times,
            });
        }
    };
    add(true, "film", 0, 2, 1);
    add(calls_for(Effect::DepthOfField), "lens", 2, 2, 1);
    let lights = calls_for(Effect::SampleLights);
    let extended = points(prepared);
    let fixed = calls_for(Effect::CenterPattern) || calls_for(Effect::GridPattern);
    let cells = calls_for(Effect::StratifiedPattern);
    let own = cells || calls_for(Effect::AllLights);
    let first = if own { 64 } else { 4 };
    add(lights && !fixed, "light point", first, 2, extended);
    // A pattern's choices follow from the first ray's.
    let choices = if fixed || cells {
        1
    } else {
        prepared.shadow_rays()
    };
    let choice = calls_for(Effect::LightChoice) && !calls_for(Effect::AllLights);
    add(lights && choice, "light choice", 6, 1, choices);
    let bsdf = calls_for(Effect::SampleBsdf);
    let hemisphere = calls_for(Effect::UniformHemisphere) || calls_for(Effect::CosineHemisphere);
    let lobes = calls_for(Effect::Glossy) && !hemisphere;
    add(bsdf && lobes, "lobe", 7, 1, 1);
    add(bsdf, "direction", 8, 2, 1);
    let map = calls_for(Effect::EnvironmentMap) && samples_environment(prepared);
    add(lights && map, "environment texel", 10, 1, choices);
    numbers
}

fn sampled(prepared: &Prepared) -> impl Iterator<Item = (usize, &Emitter)> {
    let emitters = &prepared.emitters;
    let lights = emitters.lights.iter().enumerate();
    lights.filter(|(index, _)| emitters.probability(*index) > 0.0)
}

fn samples_environment(prepared: &Prepared) -> bool {
    sampled(prepared).any(|(_, light)| *light == Emitter::Environment)
}

/// Points on lights that are drawn for one sample.
fn points(prepared: &Prepared) -> u32 {
    let mut extended = sampled(prepared).filter(|(_, l)| !matches!(l, Emitter::Delta(_)));
    if prepared.effects.contains(Effect::AllLights) {
        let samples = extended.map(|(index, _)| prepared.light_samples(index));
        return samples.sum::<f64>() as u32;
    }
    extended.next().map_or(0, |_| prepared.shadow_rays())
}
