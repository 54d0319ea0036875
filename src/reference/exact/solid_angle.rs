//! Solid angles, in steradians.

use glam::DVec3;
use std::f64::consts::TAU;

/// Solid angle of a triangle as seen from `point`, with the sign of its side: positive when its
/// vertices run counter-clockwise as seen from there.
///
/// tan(Ω/2) = −a·(e₁×e₂) / (|a||b||c| + (a·b)|c| + (a·c)|b| + (b·c)|a|) (Van Oosterom & Strackee
/// 1983), with the edges e₁ = b − a and e₂ = c − a in the determinant, which keeps it exact for a
/// small distant triangle. In (−2π, 2π); 0 in the triangle's plane.
pub fn triangle_solid_angle(point: DVec3, vertices: [DVec3; 3]) -> f64 {
    let [a, b, c] = vertices.map(|v| v - point);
    let determinant = a.dot((vertices[1] - vertices[0]).cross(vertices[2] - vertices[0]));
    if determinant.abs() <= 0.0 {
        return 0.0;
    }
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let denominator = la * lb * lc + a.dot(b) * lc + a.dot(c) * lb + b.dot(c) * la;
    -2.0 * determinant.atan2(denominator)
}

/// Solid angle of a planar polygon, which need not be convex, as seen from `point`; sign as in
/// [`triangle_solid_angle`].
pub fn polygon_solid_angle(point: DVec3, vertices: &[DVec3]) -> f64 {
    let Some((&first, rest)) = vertices.split_first() else {
        return 0.0;
    };
    rest.windows(2)
        .map(|edge| triangle_solid_angle(point, [first, edge[0], edge[1]]))
        .sum()
}

/// Solid angle of a circular cone whose half angle has this sine, at most π/2: 2πs²/(1 + √(1 −
/// s²)). A sphere of radius r at distance d has s = r/d.
pub fn cone_solid_angle(sin_half_angle: f64) -> f64 {
    let s2 = sin_half_angle * sin_half_angle;
    TAU * s2 / (1.0 + (1.0 - s2).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn a_closed_surface_fills_the_sphere() {
        let p = [
            DVec3::new(1.0, 0.2, -0.5),
            DVec3::new(-0.3, 1.4, -0.6),
            DVec3::new(-0.9, -1.0, -0.4),
            DVec3::new(0.1, 0.2, 1.7),
        ];
        let faces = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]];
        let total = |point: DVec3| -> f64 {
            faces
                .iter()
                .map(|f| triangle_solid_angle(point, f.map(|i| p[i])))
                .sum()
        };
        assert!((total(DVec3::new(0.0, 0.1, 0.1)).abs() - 4.0 * PI).abs() < 1e-14);
        assert!(total(DVec3::new(5.0, 3.0, 1.0)).abs() < 1e-14);
    }

    #[test]
    fn a_polygon_is_the_sum_of_its_parts() {
        // An L, as one polygon and as two squares and a rectangle's half.
        let at = |x: f64, y: f64| DVec3::new(x, y, 0.7);
        let l = [
            at(0.0, 0.0),
            at(2.0, 0.0),
            at(2.0, 1.0),
            at(1.0, 1.0),
            at(1.0, 2.0),
            at(0.0, 2.0),
        ];
        let parts = [
            [at(0.0, 0.0), at(2.0, 0.0), at(2.0, 1.0), at(0.0, 1.0)],
            [at(0.0, 1.0), at(1.0, 1.0), at(1.0, 2.0), at(0.0, 2.0)],
        ];
        let whole = polygon_solid_angle(DVec3::ZERO, &l);
        let sum: f64 = parts
            .iter()
            .map(|q| polygon_solid_angle(DVec3::ZERO, q))
            .sum();
        assert!((whole - sum).abs() < 1e-14 && whole < 0.0);
        assert!(polygon_solid_angle(at(0.5, 0.5), &l).abs() <= 0.0);
    }

    #[test]
    fn the_widest_cone_is_a_hemisphere() {
        assert!((cone_solid_angle(1.0) - TAU).abs() < 1e-15);
    }
}
