//! Rounding to f32, and random inputs that the shaders and their twins share.

use direkt::reference::core::rng::{pcg4d, to_unit};
use glam::DVec3;

/// Half the distance of 1 to the next f32: the largest relative error of one rounding.
pub const UNIT: f64 = 1.0 / 16_777_216.0;

/// `v` as the shaders see it.
pub fn rounded(v: DVec3) -> DVec3 {
    v.as_vec3().as_dvec3()
}

/// Four numbers in [0, 1 − 2⁻²⁴] that f32 holds.
pub fn numbers(item: u32, stream: u32, seed: u32) -> [f64; 4] {
    pcg4d([item, stream, 0, seed]).map(to_unit)
}

/// A unit vector at polar angle `degrees` and azimuth `azimuth`, as the shaders see it.
pub fn direction(degrees: f64, azimuth: f64) -> DVec3 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    rounded(DVec3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos))
}

/// Whether `found` is `expected` up to `roundings` roundings relative to it.
pub fn close(found: f64, expected: f64, roundings: f64) -> bool {
    (found - expected).abs() <= roundings * UNIT * expected.abs()
}
