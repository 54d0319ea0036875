//! Configuration factors F = E/(πL) of spheres, and of circular cones of directions.

use glam::DVec3;
use std::f64::consts::PI;

/// A sphere, wherever it lies: above the receiver's horizon, cut by it or below it. 1 inside the
/// sphere, which then has to emit inwards.
pub fn sphere_factor(point: DVec3, normal: DVec3, centre: DVec3, radius: f64) -> f64 {
    let to_centre = centre - point;
    let distance = to_centre.length();
    if distance < radius {
        return 1.0;
    }
    cone_factor(to_centre.dot(normal) / distance, radius / distance)
}

/// Constant radiance from a circular cone of directions whose half angle σ ≤ π/2 has the sine
/// `sin_half_angle` > 0, its axis at the angle β with cosine `cos_axis` from the receiver's normal.
///
/// ```text
///     F = sin²σ cosβ                                                         while it is above the horizon
///     F = (1/π)[sin²σ (cosβ·acos y − x s) + atan(s/x)]                       while the horizon cuts it
///         x = cotσ,  y = −x cotβ,  s = sinβ √(1 − y²) = √(1 − (cosβ/sinσ)²)
/// ```
///
/// (Naraghi & Chung 1982 for the sphere.) For small cones atan(s/x) − s/x is summed as a series: F
/// is of the third order in σ there, its terms of the first.
pub fn cone_factor(cos_axis: f64, sin_half_angle: f64) -> f64 {
    let sin2 = sin_half_angle * sin_half_angle;
    // Height of the cone's axis over the horizon in its own radii.
    let height = cos_axis / sin_half_angle;
    if height >= 1.0 {
        return sin2 * cos_axis;
    }
    if height <= -1.0 {
        return 0.0;
    }
    let cos_half_angle = ((1.0 - sin_half_angle) * (1.0 + sin_half_angle))
        .max(0.0)
        .sqrt();
    let s = ((1.0 - height) * (1.0 + height)).sqrt();
    let axis = sin2 * cos_axis * s.atan2(-cos_axis * cos_half_angle / sin_half_angle);
    let opposite = s * sin_half_angle;
    // opposite/cosσ = s/x.
    let chord = if opposite < 0.3 * cos_half_angle {
        // atan q − q + q sin²σ with q = s/x, because s x sin²σ = q cos²σ.
        let q = opposite / cos_half_angle;
        atan_minus_itself(q) + q * sin2
    } else {
        opposite.atan2(cos_half_angle) - opposite * cos_half_angle
    };
    (axis + chord) / PI
}

/// atan(q) − q for |q| < 0.3.
fn atan_minus_itself(q: f64) -> f64 {
    let q2 = q * q;
    // The last term is below 0.09^17/37 of the first.
    let series = (1..=17).rev().fold(0.0, |sum, k| {
        let sign = if k % 2 == 1 { -1.0 } else { 1.0 };
        sum * q2 + sign / f64::from(2 * k + 1)
    });
    q * q2 * series
}

#[cfg(test)]
mod tests {
    use super::super::direct::{Receiver, Shape, factor_by_cubature};
    use super::*;

    #[test]
    fn a_sphere_anywhere_is_the_integral() {
        let normal = DVec3::new(0.2, -0.3, 0.9).normalize();
        let side = normal.any_orthonormal_vector();
        let point = DVec3::new(0.5, 1.5, -2.5);
        for distance in [1.0, 1.01, 1.5, 4.0, 300.0] {
            for degrees in [
                0.0_f64, 3.0, 30.0, 60.0, 80.0, 89.95, 90.0, 93.0, 120.0, 150.0, 179.0,
            ] {
                let (sin, cos) = degrees.to_radians().sin_cos();
                let centre = point + (normal * cos + side * sin) * distance;
                let factor = sphere_factor(point, normal, centre, 1.0);
                let sphere = Shape::Sphere {
                    centre,
                    radius: 1.0,
                };
                let (integral, _) = factor_by_cubature(&Receiver { point, normal }, sphere, 1e-12);
                // On the surface an error of 1e-16 in the cone's sine is one of its root in the
                // cone.
                let rounding = if distance <= 1.0 { 1e-7 } else { 1e-13 };
                let bound = 1e-10 * factor + rounding / distance.powi(2);
                assert!(
                    (factor - integral).abs() < bound,
                    "{distance} {degrees}: {factor} {integral}"
                );
            }
        }
    }

    #[test]
    fn the_forms_join() {
        for cos_axis in [-0.1, 0.0, 0.1] {
            // q = 0.3 lies in between.
            let values: Vec<f64> = (0..400)
                .map(|i| cone_factor(cos_axis, 0.25 + 0.0003 * f64::from(i)))
                .collect();
            for w in values.windows(3) {
                let bend = w[2] - 2.0 * w[1] + w[0];
                assert!(bend.abs() < 1e-7, "{cos_axis} {bend}");
            }
        }
        let exact = |q: f64| q.atan() - q;
        assert!((atan_minus_itself(0.3) - exact(0.3)).abs() < 1e-16);
    }

    #[test]
    fn a_receiver_on_the_surface_sees_half_of_space() {
        assert!((cone_factor(1.0, 1.0) - 1.0).abs() < 1e-15);
        assert!((cone_factor(0.0, 1.0) - 0.5).abs() < 1e-15);
        assert!((cone_factor(-0.6, 1.0) - 0.2).abs() < 1e-15);
        assert!((sphere_factor(DVec3::ZERO, -DVec3::Z, DVec3::Z * 0.5, 1.0) - 1.0).abs() < 1e-15);
    }

    /// Receivers and lights of Cornell CS667 (2007), homework 4, albedo 0.5.
    #[test]
    fn cornells_spheres() {
        let above = sphere_factor(DVec3::ZERO, DVec3::Y, DVec3::Y * 5.0, 1.0);
        assert!((0.5 * 20.0 * above - 0.4).abs() < 1e-15);
        let level = sphere_factor(DVec3::ZERO, DVec3::Y, DVec3::X * 5.0, 1.0);
        assert!((0.5 * 200.0 * level - 0.171_847_3).abs() < 0.5e-7);
        // L(θ − sinθ)/4π with θ = 2 asin(r/d).
        let theta = 2.0 * 0.2_f64.asin();
        assert!((level - (theta - theta.sin()) / (2.0 * PI)).abs() < 1e-16);
    }
}
