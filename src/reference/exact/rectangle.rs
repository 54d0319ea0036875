//! Configuration factors F = E/(πL) of rectangles parallel and perpendicular to the receiver.
//!
//! Formulas 11 and 12 for a differential element to a rectangle in Siegel & Howell, *Thermal
//! Radiation Heat Transfer*; other positions by addition and subtraction of rectangles with a
//! corner above (or level with) the receiver.

use std::f64::consts::TAU;

/// A rectangle with sides `a` and `b`, parallel to the receiver at `distance` > 0, one corner
/// straight above it.
///
/// F = (1/2π)[A/√(1+A²)·atan(B/√(1+A²)) + B/√(1+B²)·atan(A/√(1+B²))] with A = a/distance, B =
/// b/distance. Odd in `a` and in `b`.
pub fn parallel_corner(a: f64, b: f64, distance: f64) -> f64 {
    let (a, b) = (a / distance, b / distance);
    let (sa, sb) = (1.0_f64.hypot(a), 1.0_f64.hypot(b));
    (a / sa * (b / sa).atan() + b / sb * (a / sb).atan()) / TAU
}

/// A rectangle parallel to the receiver at `distance` > 0 that covers `x` and `y`, ranges relative
/// to the receiver.
pub fn parallel_rectangle(x: [f64; 2], y: [f64; 2], distance: f64) -> f64 {
    let corner = |a, b| parallel_corner(a, b, distance);
    corner(x[1], y[1]) - corner(x[0], y[1]) - corner(x[1], y[0]) + corner(x[0], y[0])
}

/// A wall perpendicular to the receiver at `gap` > 0: it begins level with the receiver and
/// opposite to it, is `width` wide to one side and `height` ≥ 0 high.
///
/// F = (1/2π)[atan(b/c) − c/√(a²+c²)·atan(b/√(a²+c²))] with height a, width b, gap c. Odd in
/// `width`.
pub fn perpendicular_corner(width: f64, height: f64, gap: f64) -> f64 {
    let reach = height.hypot(gap);
    ((width / gap).atan() - gap / reach * (width / reach).atan()) / TAU
}

/// A wall perpendicular to the receiver at `gap` > 0 that covers `y` to the sides and `z` upwards,
/// ranges relative to the receiver. What lies below the receiver's horizon, at negative z, does not
/// count.
pub fn perpendicular_rectangle(y: [f64; 2], z: [f64; 2], gap: f64) -> f64 {
    let [low, high] = z.map(|z| z.max(0.0));
    let corner = |y, z| perpendicular_corner(y, z, gap);
    corner(y[1], high) - corner(y[0], high) - corner(y[1], low) + corner(y[0], low)
}

#[cfg(test)]
mod tests {
    use super::super::polygon::polygon_factor;
    use super::*;
    use glam::DVec3;

    #[test]
    fn rectangles_are_lamberts_polygons() {
        for (x, y, c) in [
            ([0.0, 1.0], [0.0, 2.0], 0.5),
            ([-1.0, 3.0], [0.3, 0.4], 1.0),
            ([1.0, 1.5], [-7.0, -2.0], 3.0),
            ([-0.2, 0.2], [-0.1, 0.3], 1e-3),
        ] {
            let at = |i: usize, j: usize| DVec3::new(x[i], y[j], c);
            let corners = [at(0, 0), at(0, 1), at(1, 1), at(1, 0)];
            let lambert = polygon_factor(DVec3::ZERO, DVec3::Z, &corners);
            let factor = parallel_rectangle(x, y, c);
            assert!((factor - lambert).abs() < 1e-14, "{factor} {lambert}");

            let at = |i: usize, j: usize| DVec3::new(c, x[i], y[j]);
            let corners = [at(0, 0), at(0, 1), at(1, 1), at(1, 0)];
            let lambert = polygon_factor(DVec3::ZERO, DVec3::Z, &corners);
            let factor = perpendicular_rectangle(x, y, c);
            assert!((factor - lambert).abs() < 1e-14, "{factor} {lambert}");
        }
    }
}
