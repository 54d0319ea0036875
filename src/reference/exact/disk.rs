//! Configuration factors F = E/(πL) of disks.

use glam::DVec3;

/// A disk of `radius` r, parallel to the receiver at `height` h > 0, its centre `offset` a
/// sideways.
///
/// F = ½[1 − (Z − 2R²)/√(Z² − 4R²)] with H = h/a, R = r/a, Z = 1 + H² + R² (Hamilton & Morgan
/// 1952), rearranged so that neither a small disk nor a = 0 cancels.
pub fn disk_parallel(height: f64, radius: f64, offset: f64) -> f64 {
    let root = spread(height, radius, offset);
    let rest = offset * offset + height * height - radius * radius;
    if rest < 0.0 {
        0.5 * (root - rest) / root
    } else {
        2.0 * (radius * height / root) * (radius * height / (root + rest))
    }
}

/// A disk of `radius` r whose axis is perpendicular to the receiver's normal: the receiver lies
/// `height` h > 0 before the disk's plane and `offset` a ≥ r beside its axis, its normal pointing
/// towards the axis.
///
/// F = (H/2)[Z/√(Z² − 4R²) − 1] with H = h/a, R = r/a, Z = 1 + H² + R² (Hamilton & Morgan 1952),
/// rearranged likewise. Below a = r the horizon cuts the disk, and the formula does not hold.
pub fn disk_perpendicular(height: f64, radius: f64, offset: f64) -> f64 {
    debug_assert!(offset >= radius);
    let root = spread(height, radius, offset);
    let sum = offset * offset + height * height + radius * radius;
    2.0 * (height * radius / root) * (radius * offset / (root + sum))
}

/// a²√(Z² − 4R²): the product of the distances to the nearest and to the furthest point of the rim.
fn spread(height: f64, radius: f64, offset: f64) -> f64 {
    height.hypot(offset - radius) * height.hypot(offset + radius)
}

/// A disk anywhere that lies above the receiver's horizon as a whole, or below it (then 0).
/// `normal` and `axis` have unit length; either side of the disk counts. `None` when the horizon
/// cuts the disk.
///
/// Above the horizon irradiance is linear in the receiver's normal, so its part along the axis and
/// its part towards the axis give all.
pub fn disk_factor(
    point: DVec3,
    normal: DVec3,
    centre: DVec3,
    axis: DVec3,
    radius: f64,
) -> Option<f64> {
    let to_centre = centre - point;
    let height = to_centre.dot(axis);
    let rise = to_centre.dot(normal);
    let drop = radius * (normal - axis * normal.dot(axis)).length();
    if rise <= -drop {
        return Some(0.0);
    }
    if rise < drop {
        return None;
    }
    if height.abs() <= 0.0 {
        return Some(0.0);
    }
    let axis = axis * height.signum();
    let height = height.abs();
    let inward = to_centre - axis * height;
    let offset = inward.length();
    let along = normal.dot(axis) * disk_parallel(height, radius, offset);
    let root = spread(height, radius, offset);
    let sum = offset * offset + height * height + radius * radius;
    // disk_perpendicular over the offset, finite on the axis.
    let across = 2.0 * (height * radius / root) * (radius / (root + sum));
    Some(along + normal.dot(inward) * across)
}

#[cfg(test)]
mod tests {
    use super::super::direct::{Receiver, Shape, factor_by_cubature};
    use super::*;

    #[test]
    fn a_disk_anywhere_is_the_integral() {
        for (centre, axis, normal, radius) in [
            (DVec3::new(0.0, 0.0, 2.0), DVec3::NEG_Z, DVec3::Z, 1.5),
            (
                DVec3::new(1.0, -0.5, 1.5),
                DVec3::new(0.3, 0.5, -0.9),
                DVec3::new(0.1, 0.2, 1.0),
                0.7,
            ),
            (
                DVec3::new(2.0, 0.0, 1.0),
                DVec3::new(-1.0, 0.0, 0.2),
                DVec3::new(1.0, 0.0, 1.0),
                1.2,
            ),
        ] {
            let (axis, normal) = (axis.normalize(), normal.normalize());
            let point = DVec3::new(0.4, -0.3, 0.2);
            let factor = disk_factor(point, normal, centre + point, axis, radius).unwrap();
            let disk = Shape::Disk {
                centre: centre + point,
                normal: axis,
                radius,
            };
            let (integral, _) = factor_by_cubature(&Receiver { point, normal }, disk, 1e-12);
            assert!((factor - integral).abs() < 1e-12, "{factor} {integral}");
        }
    }

    #[test]
    fn a_disk_that_the_horizon_cuts_has_no_closed_form_here() {
        let cut = disk_factor(DVec3::ZERO, DVec3::Z, DVec3::X, DVec3::X, 0.5);
        assert!(cut.is_none());
        let below = disk_factor(
            DVec3::ZERO,
            DVec3::Z,
            DVec3::new(1.0, 0.0, -2.0),
            DVec3::X,
            0.5,
        );
        assert!(below.unwrap().abs() <= 0.0);
    }

    #[test]
    fn a_wide_disk_fills_the_hemisphere() {
        assert!((disk_parallel(1.0, 1e6, 0.0) - 1.0).abs() < 1e-11);
        assert!((disk_parallel(1.0, 1e6, 3.0) - 1.0).abs() < 1e-11);
    }
}
