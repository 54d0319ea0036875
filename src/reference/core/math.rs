//! Elementary functions: those of `f64`, where the shaders bring polynomials of their own.

use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// (sin x, cos x).
pub fn sin_cos_octant(x: f64) -> DVec2 {
    DVec2::new(x.sin(), x.cos())
}

/// (sin 2πu, cos 2πu).
pub fn sin_cos_two_pi(u: f64) -> DVec2 {
    sin_cos_octant(TAU * u)
}

/// Angle of (x, y) in (−π, π]; 0 at the origin.
pub fn angle_of(y: f64, x: f64) -> f64 {
    // Adding 0 takes the sign off a zero, which `atan2` would heed.
    (y + 0.0).atan2(x + 0.0)
}

/// (sin², cos²) of half the angle that has this cosine and squared sine.
pub fn half_angle_squares(cosine: f64, sine_squared: f64) -> DVec2 {
    let half = 0.5 * sine_squared.sqrt().atan2(cosine);
    DVec2::new(half.sin().powi(2), half.cos().powi(2))
}

/// High word of the 64-bit product a·b.
pub fn multiply_high(a: u32, b: u32) -> u32 {
    ((u64::from(a) * u64::from(b)) >> 32) as u32
}

pub use crate::emitters::luminance;

/// Largest absolute component.
pub fn max_abs(v: DVec3) -> f64 {
    v.abs().max_element()
}
