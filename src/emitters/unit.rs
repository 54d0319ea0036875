//! The unit of radiance on the GPU.
//!
//! The variance of a pixel is a sum of squares. In f32 that of a sample of 10¹⁹ is infinite, and
//! that of 10⁻²³ is 0. Where the lights of a scene are so bright or so dark, the GPU's radiance is
//! a multiple of a power of two, by which the film, which is in f64, multiplies it again: no digit
//! is lost or changed.

use super::{EmissionMap, Emitter};
use crate::scene::{EnvironmentRadiance, Scene};

/// Samples up to 256 times as many as its square, in 256 of them, are finite in f32, and nearly 2⁴⁸
/// times as bright as this.
const BRIGHT: f64 = 48.0;
/// Lights darker than 2 to the power of this have squares that f32 holds too roughly.
const DARK: f64 = -48.0;

/// The unit for `lights` of `scene`: 1 unless the brightest of them calls for another.
pub(super) fn of(scene: &Scene, lights: &[Emitter], maps: &[EmissionMap]) -> f64 {
    let brightest = lights.iter().map(|light| strength(scene, light, maps));
    let brightest = brightest.fold(0.0, f64::max);
    if brightest <= 0.0 {
        return 1.0;
    }
    let exponent = brightest.log2().ceil();
    let of_unit = if exponent > BRIGHT {
        exponent - BRIGHT
    } else if exponent < DARK {
        exponent
    } else {
        0.0
    };
    of_unit.clamp(-1000.0, 1000.0).exp2()
}

/// The largest radiance of a light; its normalised intensity or its irradiance where it has no
/// extent.
fn strength(scene: &Scene, light: &Emitter, maps: &[EmissionMap]) -> f64 {
    match light {
        Emitter::Area { radiance, map, .. } => {
            let texture = map.map(|map| maps[map as usize].texture.texture);
            let largest = texture.map_or(1.0, |t| scene.textures[t.index()].largest());
            radiance.max_element() * largest
        }
        Emitter::Sun(sun) => sun.radiance().max_element(),
        Emitter::Delta(light) => light.strength().max_element(),
        Emitter::Environment => scene.environment.as_ref().map_or(0.0, |environment| {
            let largest = match &environment.radiance {
                EnvironmentRadiance::Constant(radiance) => radiance.max_element(),
                EnvironmentRadiance::Map(map) => {
                    let channels = map.texels.iter().flatten().copied();
                    f64::from(channels.fold(0.0, f32::max))
                }
            };
            largest * environment.scale
        }),
    }
}
