//! Polygons of mesh files as triangles.
//!
//! A fan from the first corner where that covers the polygon, as of every convex one; else the ears
//! that the crate `earcut` cuts. Orientation is kept, and which corner comes first matters to
//! neither area nor outline.

use super::transform;
use earcut::Earcut;
use glam::{DVec2, DVec3};

/// Distance, in extents of the polygon, by which a corner may lie on the wrong side of a line: what
/// rounding to f32 makes of corners on a line.
const ROUNDING: f64 = 4.0 / 16_777_216.0;
/// Part of a polygon's area that its triangles may differ from it by.
const AREA_TOLERANCE: f64 = 1e-6;

/// Cuts polygons into triangles, and counts those that are none.
#[derive(Default)]
pub(super) struct Triangulator {
    earcut: Earcut<f64>,
    ears: Vec<u32>,
    /// Polygons whose edges cross: triangles cover another area than they enclose.
    crossing: usize,
    /// Faces of fewer than three corners.
    too_short: usize,
}

impl Triangulator {
    /// Adds the triangles of the polygon `corners`, indices into `positions`.
    pub(super) fn add(
        &mut self,
        corners: &[u32],
        positions: &[DVec3],
        triangles: &mut Vec<[u32; 3]>,
    ) {
        if corners.len() <= 3 {
            match *corners {
                [a, b, c] => triangles.push([a, b, c]),
                _ => self.too_short += 1,
            }
            return;
        }
        let points = corners.iter().map(|&i| positions[i as usize]);
        let points: Vec<DVec3> = points.collect();
        match project(&points) {
            None => {
                self.crossing += usize::from(fan(&points).any(|t| has_area(&points, t)));
                add_fan(corners, triangles);
            }
            Some(plane) if fan_covers(&plane) => add_fan(corners, triangles),
            Some(plane) => self.add_ears(corners, &points, &plane, triangles),
        }
    }

    /// Sentences about the faces of `name` so far that are no simple polygons.
    pub(super) fn warnings(&self, name: &str) -> Vec<String> {
        let mut warnings = Vec::new();
        if self.crossing > 0 {
            let polygons = count(self.crossing, "polygon crosses", "polygons cross");
            let themselves = if self.crossing == 1 {
                "itself"
            } else {
                "themselves"
            };
            warnings.push(format!(
                "{name}: {polygons} {themselves}: what triangles cover of them may differ from what is meant"
            ));
        }
        if self.too_short > 0 {
            let faces = count(self.too_short, "face has", "faces have");
            warnings.push(format!("{name}: {faces} fewer than three corners"));
        }
        warnings
    }

    fn add_ears(
        &mut self,
        corners: &[u32],
        points: &[DVec3],
        plane: &[DVec2],
        triangles: &mut Vec<[u32; 3]>,
    ) {
        let count = corners.len();
        let first = canonical_start(points);
        let from_first = |i: usize| (first + i) % count;
        let ring = (0..count).map(|i| plane[from_first(i)].to_array());
        self.earcut.earcut(ring, &[], &mut self.ears);
        let mut cut: Vec<[usize; 3]> = Vec::with_capacity(count);
        for ear in self.ears.chunks_exact(3) {
            let [a, b, c] = [ear[0], ear[1], ear[2]].map(|i| from_first(i as usize));
            let turned = area([plane[a], plane[b], plane[c]]) < 0.0;
            cut.push(if turned { [a, c, b] } else { [a, b, c] });
        }
        let covered: f64 = cut.iter().map(|t| area(t.map(|i| plane[i])).abs()).sum();
        let enclosed: f64 = fan(plane).map(|t| area(t.map(|i| plane[i]))).sum();
        self.crossing += usize::from((covered - enclosed).abs() > AREA_TOLERANCE * enclosed);
        triangles.extend(cut.iter().map(|t| t.map(|i| corners[i])));
    }
}

fn count(count: usize, one: &str, several: &str) -> String {
    if count == 1 {
        format!("1 {one}")
    } else {
        format!("{count} {several}")
    }
}

/// The triangles of a fan from the first of `points`.
fn fan<T>(points: &[T]) -> impl Iterator<Item = [usize; 3]> + use<T> {
    (2..points.len()).map(|i| [0, i - 1, i])
}

fn add_fan(corners: &[u32], triangles: &mut Vec<[u32; 3]>) {
    triangles.extend(fan(corners).map(|t| t.map(|i| corners[i])));
}

/// Twice the area, above 0 where the triangle turns counter-clockwise.
fn area([a, b, c]: [DVec2; 3]) -> f64 {
    (b - a).perp_dot(c - a)
}

fn has_area(points: &[DVec3], [a, b, c]: [usize; 3]) -> bool {
    let (u, v) = (points[b] - points[a], points[c] - points[a]);
    u.cross(v).length() > 1e-12 * u.length() * v.length()
}

/// The points in the plane that fits best, seen from its front, their extent brought to 1; `None`
/// where they are not finite or enclose no area. The plane's normal is that of the enclosed area
/// (Newell 1972, in Sutherland, Sproull & Schumacker 1974, *A Characterization of Ten
/// Hidden-Surface Algorithms*).
fn project(points: &[DVec3]) -> Option<Vec<DVec2>> {
    let from_first = points.iter().map(|p| *p - points[0]);
    let extent = from_first.clone().map(|p| p.abs().max_element());
    let extent = extent.fold(0.0, f64::max);
    let points: Vec<DVec3> = from_first.map(|p| p / extent).collect();
    let next = points.iter().cycle().skip(1);
    let enclosed: DVec3 = points.iter().zip(next).map(|(a, b)| a.cross(*b)).sum();
    // False where anything is not finite.
    if enclosed.length() > 1e-12 {
        let (u, v) = transform::frame(enclosed.normalize());
        let plane = points.iter().map(|p| DVec2::new(p.dot(u), p.dot(v)));
        Some(plane.collect())
    } else {
        None
    }
}

/// Whether a fan from the first point covers the polygon and nothing twice: no triangle of it is
/// turned over, by more than its corners' rounding.
fn fan_covers(plane: &[DVec2]) -> bool {
    fan(plane).all(|t| {
        let [a, b, c] = t.map(|i| plane[i]);
        let longest = (b - a).length().max((c - b).length()).max((a - c).length());
        area([a, b, c]) >= -ROUNDING * longest
    })
}

/// The point from which on the polygon is cut, whichever point comes first: the least of the
/// sequences that begin at a point.
fn canonical_start(points: &[DVec3]) -> usize {
    let count = points.len();
    let sequence = |start: usize| (0..count).map(move |i| points[(start + i) % count].to_array());
    let order = |a: &usize, b: &usize| {
        let pairs = sequence(*a).zip(sequence(*b));
        let mut orders = pairs.map(|(a, b)| {
            let coordinates = a.iter().zip(&b);
            coordinates
                .map(|(a, b)| a.total_cmp(b))
                .find(|o| o.is_ne())
                .unwrap_or(std::cmp::Ordering::Equal)
        });
        orders
            .find(|o| o.is_ne())
            .unwrap_or(std::cmp::Ordering::Equal)
    };
    (0..count).min_by(order).unwrap_or(0)
}

#[cfg(test)]
mod tests;
