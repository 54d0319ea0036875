//! Exact visibility of a polygonal light behind convex occluders.
//!
//! A convex occluder hides from the receiver the cone of directions through it, as far as it lies
//! beyond the occluder's plane: an intersection of half-spaces. What an intersection of half-spaces
//! leaves of a convex polygon is a few convex polygons, so the light is cut until only visible
//! pieces are left, and Lambert's formula holds for each.

use super::polygon::{polygon_factor, split};
use glam::DVec3;

/// The convex pieces of the convex polygon `light` that `point` sees past convex planar
/// `occluders`, which may overlap.
///
/// Pieces do not overlap and keep the light's orientation. An occluder in the light's plane or in a
/// plane through `point` hides nothing.
pub fn visible_pieces(point: DVec3, light: &[DVec3], occluders: &[Vec<DVec3>]) -> Vec<Vec<DVec3>> {
    let mut pieces = vec![light.to_vec()];
    for occluder in occluders {
        let shadow = shadow(point, occluder);
        if !shadow.is_empty() {
            pieces = pieces.iter().flat_map(|p| subtract(p, &shadow)).collect();
        }
    }
    pieces
}

/// Configuration factor F = E/(πL) of `light` as seen past `occluders`; sign as in
/// [`polygon_factor`].
pub fn visible_factor(
    point: DVec3,
    normal: DVec3,
    light: &[DVec3],
    occluders: &[Vec<DVec3>],
) -> f64 {
    visible_pieces(point, light, occluders)
        .iter()
        .map(|piece| polygon_factor(point, normal, piece))
        .sum()
}

/// The half-space of points x with (x − origin)·normal ≥ 0.
struct HalfSpace {
    origin: DVec3,
    normal: DVec3,
}

/// The half-spaces whose intersection an occluder hides; none when it hides nothing.
fn shadow(point: DVec3, occluder: &[DVec3]) -> Vec<HalfSpace> {
    let n = occluder.len();
    let centre = occluder.iter().sum::<DVec3>() / n as f64;
    let area: DVec3 = (0..n)
        .map(|i| (occluder[i] - centre).cross(occluder[(i + 1) % n] - centre))
        .sum();
    let Some(plane) = area.try_normalize() else {
        return Vec::new();
    };
    let height = plane.dot(centre - point);
    let reach = occluder
        .iter()
        .fold(0.0_f64, |m, v| m.max(v.distance(point)));
    if height.abs() <= 1e-12 * reach {
        return Vec::new();
    }
    let beyond = HalfSpace {
        origin: centre,
        normal: plane * height.signum(),
    };
    let sides = (0..n).filter_map(|i| {
        let (a, b) = (occluder[i], occluder[(i + 1) % n]);
        let normal = (a - point).cross(b - a).try_normalize()?;
        let inwards = normal.dot(centre - point).signum();
        Some(HalfSpace {
            origin: point,
            normal: normal * inwards,
        })
    });
    std::iter::once(beyond).chain(sides).collect()
}

/// What is left of a convex polygon outside an intersection of half-spaces.
fn subtract(polygon: &[DVec3], region: &[HalfSpace]) -> Vec<Vec<DVec3>> {
    let mut rest = polygon.to_vec();
    let mut pieces = Vec::new();
    for half_space in region {
        let local: Vec<DVec3> = rest.iter().map(|v| v - half_space.origin).collect();
        let (inside, outside) = split(&local, half_space.normal);
        let back = |part: Vec<DVec3>| part.into_iter().map(|v| v + half_space.origin).collect();
        if inside.is_empty() {
            // Nothing is hidden; a polygon in the bounding plane is not hidden either.
            return vec![polygon.to_vec()];
        }
        if !outside.is_empty() {
            pieces.push(back(outside));
            rest = back(inside);
        }
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rectangle(corner: DVec3, a: DVec3, b: DVec3) -> Vec<DVec3> {
        vec![corner, corner + a, corner + a + b, corner + b]
    }

    fn area(polygon: &[DVec3]) -> f64 {
        let fan = polygon[1..].windows(2);
        let sum: DVec3 = fan
            .map(|e| (e[0] - polygon[0]).cross(e[1] - polygon[0]))
            .sum();
        0.5 * sum.length()
    }

    /// Whether the segment from `p` to `q` crosses a convex polygon.
    fn blocked(p: DVec3, q: DVec3, occluder: &[DVec3]) -> bool {
        let normal = (occluder[1] - occluder[0]).cross(occluder[2] - occluder[0]);
        let (hp, hq) = ((p - occluder[0]).dot(normal), (q - occluder[0]).dot(normal));
        if hp * hq >= 0.0 {
            return false;
        }
        let x = p + (q - p) * (hp / (hp - hq));
        let n = occluder.len();
        (0..n).all(|i| {
            let (a, b) = (occluder[i], occluder[(i + 1) % n]);
            (b - a).cross(x - a).dot(normal) >= 0.0
        })
    }

    /// CIE 171:2006, 5.7: a room of 4 × 4 × 3 m whose wall y = 4 emits, a box y 2.5–2.7, z 0–1 of
    /// full width before it.
    #[test]
    fn configuration_factors_behind_a_box() {
        let wall = rectangle(DVec3::new(0.0, 4.0, 0.0), DVec3::X * 4.0, DVec3::Z * 3.0);
        let (x, y, z) = (DVec3::X * 4.0, DVec3::Y * 0.2, DVec3::Z);
        let corner = DVec3::new(0.0, 2.5, 0.0);
        let solid = [
            rectangle(corner, x, z),
            rectangle(corner + y, x, z),
            rectangle(corner + z, x, y),
            rectangle(corner, y, z),
            rectangle(corner + x, y, z),
        ];
        let percent = |point, normal| 100.0 * visible_factor(point, normal, &wall, &solid).abs();
        let on_wall = [16.071, 16.330, 15.399, 13.322, 10.317, 7.079];
        for (i, expected) in on_wall.into_iter().enumerate() {
            let found = percent(DVec3::new(2.0, 0.0, 2.75 - 0.5 * i as f64), DVec3::Y);
            assert!((found - expected).abs() < 0.5e-3, "wall {i}: {found}");
        }
        let on_floor = [3.382, 3.629, 3.013, 0.0, 0.0];
        for (i, expected) in on_floor.into_iter().enumerate() {
            let found = percent(DVec3::new(2.0, 0.25 + 0.5 * i as f64, 0.0), DVec3::Z);
            assert!((found - expected).abs() < 0.5e-3, "floor {i}: {found}");
        }
    }

    #[test]
    fn pieces_are_what_rays_see() {
        let light = rectangle(
            DVec3::new(-1.0, -1.0, 2.0),
            DVec3::X * 2.0,
            DVec3::new(0.0, 2.0, 0.3),
        );
        let triangle =
            |a: [f64; 3], b: [f64; 3], c: [f64; 3]| [a, b, c].map(DVec3::from_array).to_vec();
        let occluders = [
            triangle([-0.3, -0.2, 1.0], [0.4, 0.0, 1.1], [0.0, 0.5, 0.9]),
            rectangle(
                DVec3::new(0.0, -0.6, 1.3),
                DVec3::new(0.5, 0.1, 0.2),
                DVec3::new(0.0, 0.7, 0.0),
            ),
            // Crosses the light's plane.
            triangle([-1.0, 0.2, 1.5], [-0.2, 0.3, 3.0], [-0.5, 1.2, 1.8]),
            // Beyond the light, and behind the receiver.
            rectangle(DVec3::new(-1.0, -1.0, 3.0), DVec3::X * 2.0, DVec3::Y * 2.0),
            rectangle(DVec3::new(-1.0, -1.0, -1.0), DVec3::X * 2.0, DVec3::Y * 2.0),
        ];
        let point = DVec3::new(0.1, -0.1, 0.0);
        let normal = DVec3::new(0.2, 0.1, 1.0).normalize();
        let pieces = visible_pieces(point, &light, &occluders);
        let exact = visible_factor(point, normal, &light, &occluders);

        // Midpoints of n × n cells: a cell that a shadow's border crosses errs by at most its own
        // factor, and each of the 10 edges crosses at most 2n cells, with random signs; 4.9
        // standard deviations are 1e-6.
        let n = 1000;
        let (a, b) = (light[1] - light[0], light[3] - light[0]);
        let light_normal = a.cross(b);
        let (mut seen, mut factor) = (0_u32, 0.0);
        for i in 0..n * n {
            let (u, v) = (f64::from(i % n) + 0.5, f64::from(i / n) + 0.5);
            let q = light[0] + (a * u + b * v) / f64::from(n);
            if occluders.iter().any(|o| blocked(point, q, o)) {
                continue;
            }
            seen += 1;
            let d = q - point;
            factor += d.dot(normal) * d.dot(light_normal).abs() / d.length_squared().powi(2);
        }
        let cells = f64::from(n * n);
        let factor = factor / cells / std::f64::consts::PI;
        let fraction = pieces.iter().map(|p| area(p)).sum::<f64>() / area(&light);
        let bound = 4.9 * (20.0 * f64::from(n)).sqrt() / cells;
        assert!(
            (fraction - f64::from(seen) / cells).abs() < bound,
            "{fraction} {seen}"
        );
        assert!(fraction > 0.2 && fraction < 0.9, "{fraction}");
        assert!((exact.abs() - factor).abs() < bound, "{exact} {factor}");
    }

    #[test]
    fn an_occluder_counts_once() {
        let light = rectangle(DVec3::new(-1.0, -1.0, 2.0), DVec3::X * 2.0, DVec3::Y * 2.0);
        let half = rectangle(DVec3::new(0.0, -5.0, 1.0), DVec3::X * 5.0, DVec3::Y * 10.0);
        let full = polygon_factor(DVec3::ZERO, DVec3::Z, &light);
        for occluders in [vec![half.clone()], vec![half.clone(), half]] {
            let seen = visible_factor(DVec3::ZERO, DVec3::Z, &light, &occluders);
            assert!((seen - 0.5 * full).abs() < 1e-15);
        }
    }

    #[test]
    fn planes_of_the_light_and_of_the_receiver_hide_nothing() {
        let light = rectangle(
            DVec3::new(0.1, 0.2, 1.7),
            DVec3::X,
            DVec3::new(0.0, 0.3, 0.1),
        );
        let receiver_plane = rectangle(
            DVec3::new(-5.0, -5.0, 0.0),
            DVec3::X * 10.0,
            DVec3::Y * 10.0,
        );
        let pieces = visible_pieces(DVec3::ZERO, &light, &[light.clone(), receiver_plane]);
        assert_eq!(pieces, vec![light]);
    }
}
