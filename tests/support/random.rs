//! Random inputs for functions under test: all of them are numbers of f32.

use direkt::low_level::reference::core::rng::{pcg4d, to_unit};
use glam::DVec3;
use std::f64::consts::TAU;

/// A stream of random numbers.
#[derive(Debug)]
pub struct Random {
    seed: u32,
    drawn: u32,
}

/// Rounded to f32, in every component.
pub fn rounded(v: DVec3) -> DVec3 {
    v.as_vec3().as_dvec3()
}

/// Four numbers in [0, 1 − 2⁻²⁴] for an item of a stream.
pub fn numbers(item: u32, stream: u32, seed: u32) -> [f64; 4] {
    pcg4d([item, stream, 0, seed]).map(to_unit)
}

/// A unit vector at polar angle `degrees` and azimuth `azimuth`, rounded to f32.
pub fn direction(degrees: f64, azimuth: f64) -> DVec3 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    rounded(DVec3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos))
}

impl Random {
    /// The stream of number `seed`.
    pub fn new(seed: u32) -> Self {
        Self { seed, drawn: 0 }
    }

    /// A word.
    pub fn word(&mut self) -> u32 {
        self.drawn += 1;
        pcg4d([self.drawn, self.seed, 0x7e57, 0])[0]
    }

    /// Uniform in [0, 1): a multiple of 2⁻²⁴.
    pub fn uniform(&mut self) -> f64 {
        to_unit(self.word())
    }

    /// Uniform in [low, high], rounded to f32.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        f64::from((low + (high - low) * self.uniform()) as f32)
    }

    /// With a uniform logarithm in [low, high], rounded to f32.
    pub fn magnitude(&mut self, low: f64, high: f64) -> f64 {
        f64::from(self.between(low.ln(), high.ln()).exp() as f32)
    }

    /// Uniform in the cube [−1, 1]³.
    pub fn in_cube(&mut self) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|_| self.between(-1.0, 1.0)))
    }

    /// Uniform on the unit sphere, then rounded to f32.
    pub fn direction(&mut self) -> DVec3 {
        let z = self.between(-1.0, 1.0);
        let (sin, cos) = (TAU * self.uniform()).sin_cos();
        let r = (1.0 - z * z).sqrt();
        rounded(DVec3::new(r * cos, r * sin, z))
    }

    /// Two edges of a parallelogram between minute and huge.
    pub fn edges(&mut self) -> (DVec3, DVec3) {
        let u = self.in_cube() * self.magnitude(1e-9, 1e9);
        (u, self.in_cube())
    }
}
