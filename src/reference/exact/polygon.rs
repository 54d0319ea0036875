//! Lambert's configuration factor of a polygon.

use glam::DVec3;
use std::f64::consts::TAU;

/// Relative distance from a plane up to which a vertex counts as lying in it.
const ON_PLANE: f64 = 1e-14;

/// Configuration factor F = E/(πL), in [−1, 1], of a planar polygon with constant radiance, seen
/// from `point` with unit `normal`. The part below the receiver's horizon is cut off.
///
/// ```text
///     F = −(1/2π) Σ θ_i Γ_i·n,    θ_i the angle of edge i as seen from the receiver, Γ_i the unit normal of its plane
/// ```
///
/// (Lambert 1760; Baum, Rushmeier & Winget 1989, equation 7.) F is positive when the polygon's
/// vertices run counter-clockwise as seen from the receiver, that is when its normal by the
/// right-hand rule points to the receiver's side: a one-sided light gives `F.max(0)`, a two-sided
/// one `F.abs()`. The polygon need not be convex. A receiver in the polygon's plane sees 0.
///
/// Absolute error about 1e-16 times the angle that the polygon's edges span.
pub fn polygon_factor(point: DVec3, normal: DVec3, vertices: &[DVec3]) -> f64 {
    let local: Vec<DVec3> = vertices.iter().map(|v| v - point).collect();
    let (above, _) = split(&local, normal);
    if above.len() < 3 {
        return 0.0;
    }
    let mut sum = 0.0;
    for (i, &a) in above.iter().enumerate() {
        let b = above[(i + 1) % above.len()];
        let moment = a.cross(b - a);
        let length = moment.length();
        if length > 0.0 {
            sum += length.atan2(a.dot(b)) * moment.dot(normal) / length;
        }
    }
    -sum / TAU
}

/// Cuts a polygon, its vertices relative to a point of the plane, by the plane with this normal
/// (Sutherland & Hodgman 1974): the part on the normal's side, and the part on the other. A part
/// without area is empty; of a polygon that lies in the plane both are. Exact for convex polygons;
/// others may keep bridges of no width along the plane.
pub(super) fn split(polygon: &[DVec3], normal: DVec3) -> (Vec<DVec3>, Vec<DVec3>) {
    let reach = polygon.iter().fold(0.0_f64, |m, v| m.max(v.length()));
    let limit = ON_PLANE * reach * normal.length();
    let height: Vec<f64> = polygon
        .iter()
        .map(|v| {
            let h = v.dot(normal);
            if h.abs() <= limit { 0.0 } else { h }
        })
        .collect();
    if height.iter().all(|&h| h >= 0.0) {
        let flat = height.iter().all(|&h| h <= 0.0);
        return (if flat { Vec::new() } else { polygon.to_vec() }, Vec::new());
    }
    if height.iter().all(|&h| h <= 0.0) {
        return (Vec::new(), polygon.to_vec());
    }
    let (mut above, mut below) = (Vec::new(), Vec::new());
    for (i, (&a, &ha)) in polygon.iter().zip(&height).enumerate() {
        let next = (i + 1) % polygon.len();
        let (b, hb) = (polygon[next], height[next]);
        if ha >= 0.0 {
            above.push(a);
        }
        if ha <= 0.0 {
            below.push(a);
        }
        if ha * hb < 0.0 {
            let cut = a + (b - a) * (ha / (ha - hb));
            above.push(cut);
            below.push(cut);
        }
    }
    (above, below)
}

#[cfg(test)]
mod tests {
    use super::super::direct::{Receiver, Shape, factor_by_cubature};
    use super::*;
    use std::f64::consts::PI;

    /// A number in [−1, 1] for each index.
    fn scatter(i: usize) -> f64 {
        (i as f64 * 0.618_033_988_749_895 + 0.37).fract() * 2.0 - 1.0
    }

    /// A convex polygon on a random plane: points of an ellipse.
    fn random_polygon(i: usize) -> Vec<DVec3> {
        let r = |k: usize| scatter(97 * i + 31 * k * k + k);
        let centre = DVec3::new(r(1), r(2), r(3) + 0.4) * 1.5;
        let normal = DVec3::new(r(4), r(5), r(6) + 0.1).normalize();
        let (x, y) = normal.any_orthonormal_pair();
        let corners = 3 + i % 4;
        (0..corners)
            .map(|k| {
                let angle = TAU * (k as f64 + 0.3 * r(7 + k)) / corners as f64;
                centre + x * angle.cos() * (1.2 + r(8)) + y * angle.sin()
            })
            .collect()
    }

    #[test]
    fn lamberts_formula_is_the_integral() {
        let mut clipped = 0;
        for i in 0..40 {
            let polygon = random_polygon(i);
            let r = |k: usize| scatter(53 * i + k);
            let receiver = Receiver {
                point: DVec3::new(r(1), r(2), r(3)),
                normal: DVec3::new(r(4), r(5), r(6) + 1.5).normalize(),
            };
            let heights = polygon
                .iter()
                .map(|v| (v - receiver.point).dot(receiver.normal));
            let above = heights.filter(|&h| h > 0.0).count();
            clipped += usize::from(above > 0 && above < polygon.len());
            let exact = polygon_factor(receiver.point, receiver.normal, &polygon);
            let (integral, error) = factor_by_cubature(&receiver, Shape::Polygon(polygon), 1e-11);
            let difference = (exact.abs() - integral).abs();
            assert!(difference < 1e-11 + error, "{i}: {exact} {integral}");
        }
        assert!(clipped >= 8, "{clipped} polygons cross the horizon");
    }

    #[test]
    fn the_sign_is_that_of_the_side() {
        let square =
            [(1, 1), (1, -1), (-1, -1), (-1, 1)].map(|(x, y)| DVec3::new(x.into(), y.into(), 1.0));
        // Clockwise from above: the normal points down, to the receiver.
        let facing = polygon_factor(DVec3::ZERO, DVec3::Z, &square);
        let reversed: Vec<DVec3> = square.into_iter().rev().collect();
        let averted = polygon_factor(DVec3::ZERO, DVec3::Z, &reversed);
        assert!(facing > 0.5 && (facing + averted).abs() < 1e-15);
        assert!(polygon_factor(DVec3::ZERO, -DVec3::Z, &square).abs() <= 0.0);
        assert!(polygon_factor(DVec3::Z, DVec3::Z, &square).abs() <= 0.0);
    }

    #[test]
    fn factors_do_not_depend_on_the_frame() {
        let polygon = random_polygon(5);
        let (point, normal) = (
            DVec3::new(0.1, -0.2, -0.9),
            DVec3::new(0.3, 0.1, 0.8).normalize(),
        );
        let turn = glam::DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 1.234);
        let shift = DVec3::new(3.0, -7.0, 2.0);
        let turned: Vec<DVec3> = polygon.iter().map(|&v| turn * v + shift).collect();
        let a = polygon_factor(point, normal, &polygon);
        let b = polygon_factor(turn * point + shift, turn * normal, &turned);
        assert!(a.abs() > 1e-3 && (a - b).abs() < 1e-14, "{a} {b}");
    }

    /// Cornell CS667 (2007), homework 4: albedo 0.5, L = 20.
    #[test]
    fn cornells_triangle() {
        let triangle = [
            DVec3::new(0.0, 5.0, 1.0),
            DVec3::new(-0.866, 5.0, -0.5),
            DVec3::new(0.866, 5.0, -0.5),
        ];
        let radiance = 0.5 * 20.0 * polygon_factor(DVec3::ZERO, DVec3::Y, &triangle).abs();
        assert!((radiance - 0.162_163_3).abs() < 0.5e-7, "{radiance}");
    }

    /// CIE 171:2006, 5.3, in a room of 4 × 4 × 3 m: a light of 1 × 1 m in the ceiling, L = 1000.
    #[test]
    fn illuminance_below_an_area_light() {
        let light =
            [(1.5, 1.5), (2.5, 1.5), (2.5, 2.5), (1.5, 2.5)].map(|(x, y)| DVec3::new(x, y, 3.0));
        let lux = |point, normal| 1000.0 * PI * polygon_factor(point, normal, &light).abs();
        let wall = [32.677, 75.194, 81.323, 69.061, 53.404, 40.002];
        for (i, expected) in wall.into_iter().enumerate() {
            let found = lux(DVec3::new(2.0, 0.0, 2.75 - 0.5 * i as f64), DVec3::Y);
            assert!((found - expected).abs() < 0.5e-3, "wall {i}: {found}");
        }
        let floor = [61.424, 79.255, 95.667, 105.778];
        for (i, expected) in floor.into_iter().enumerate() {
            let found = lux(DVec3::new(2.0, 0.25 + 0.5 * i as f64, 0.0), DVec3::Z);
            assert!((found - expected).abs() < 0.5e-3, "floor {i}: {found}");
        }
    }
}
