//! Rectangles that are the sides of a box: a ray is held against three pairs of planes, which takes
//! less than six rectangles do.

use super::condition::{Condition, Target};
use super::expressions::{linear, literal, without_traces};
use crate::accel::PrimitiveGeometry;
use glam::DVec3;
use std::fmt::Write as _;

/// Corners that are this part of the longest edge apart are the same.
const SAME: f64 = 1e-6;

/// A box whose six sides are rectangles.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Solid {
    middle: DVec3,
    /// Half of its edges.
    halves: [DVec3; 3],
    /// Per edge the primitives before and behind which the box lies along it.
    sides: [[usize; 2]; 3],
}

/// A rectangle as middle and half edges.
#[derive(Clone, Copy)]
struct Side {
    index: usize,
    middle: DVec3,
    halves: [DVec3; 2],
}

/// The boxes among `targets`; each side belongs to one.
pub(super) fn find(targets: &[Target]) -> Vec<Solid> {
    let side = |target: &Target| match target.geometry {
        PrimitiveGeometry::Rectangle { a, u, v } => Some(Side {
            index: target.index,
            middle: a + 0.5 * (u + v),
            halves: [0.5 * u, 0.5 * v],
        }),
        _ => None,
    };
    let mut left: Vec<Side> = targets.iter().filter_map(side).collect();
    let mut found = Vec::new();
    let mut first = 0;
    while first < left.len() {
        match solid_on(left[first], &left) {
            Some(solid) => {
                left.retain(|side| !solid.has(side.index));
                found.push(solid);
            }
            None => first += 1,
        }
    }
    found
}

/// The box that stands on `ground`.
fn solid_on(ground: Side, all: &[Side]) -> Option<Solid> {
    let [u, v] = ground.halves;
    all.iter().find_map(|top| {
        let halves = [u, v, 0.5 * (top.middle - ground.middle)];
        let middle = ground.middle + halves[2];
        let within = SAME * halves.iter().map(|h| h.length()).fold(0.0, f64::max);
        let sides = [0, 1, 2].map(|axis| {
            [-1.0, 1.0].map(|sign| {
                let edges = [halves[(axis + 1) % 3], halves[(axis + 2) % 3]];
                let at = middle + sign * halves[axis];
                let is_it = |side: &&Side| side.is(at, edges, within);
                all.iter().find(is_it).map(|side| side.index)
            })
        });
        let height = halves[2].dot(u.cross(v)).abs();
        let sides: Option<Vec<usize>> = sides.into_iter().flatten().collect();
        let [a, b, c, d, e, f] = sides?[..] else {
            return None;
        };
        (height > 0.0).then_some(Solid {
            middle,
            halves,
            sides: [[a, b], [c, d], [e, f]],
        })
    })
}

impl Side {
    /// Whether it is the rectangle around `middle` with these half edges, in any order and
    /// direction.
    fn is(&self, middle: DVec3, edges: [DVec3; 2], within: f64) -> bool {
        let same = |a: DVec3, b: DVec3| (a - b).length() <= within || (a + b).length() <= within;
        let [u, v] = self.halves;
        let [a, b] = edges;
        (self.middle - middle).length() <= within
            && (same(u, a) && same(v, b) || same(u, b) && same(v, a))
    }
}

impl Solid {
    /// Whether a primitive is one of its sides.
    pub(super) fn has(&self, index: usize) -> bool {
        self.sides.as_flattened().contains(&index)
    }

    /// Statements that tell where a ray enters (`near…`) and leaves (`far…`) the box: along each of
    /// its edges it lies between −1 and 1.
    fn enter(&self, number: usize) -> String {
        let mut text = String::new();
        let [u, v, w] = self.halves;
        let volume = u.dot(v.cross(w));
        let reciprocal = [v.cross(w), w.cross(u), u.cross(v)].map(|r| without_traces(r / volume));
        for (axis, r) in reciprocal.into_iter().enumerate() {
            let name = format!("{number}_{axis}");
            let _ = write!(
                text,
                "    let b{name} = 1.0 / away_from_zero({});\n    let c{name} = -b{name} * {};\n    \
                 let low{name} = c{name} - abs(b{name});\n    let high{name} = c{name} + abs(b{name});\n",
                linear(r, "d", 0.0),
                linear(r, "o", -r.dot(self.middle)),
            );
        }
        let all = |of: &str, end: &str| {
            format!("{of}({end}{number}_0, {of}({end}{number}_1, {end}{number}_2))")
        };
        let _ = write!(
            text,
            "    let near{number} = {};\n    let far{number} = {};\n",
            all("larger", "low"),
            all("smaller", "high")
        );
        text
    }

    /// Statements that take the nearer of `t` and the box.
    pub(super) fn closest(&self, number: usize) -> String {
        let n = number;
        let mut text = self.enter(n);
        let _ = write!(
            text,
            "    let enters{n} = near{n} > 0.0;\n    let m{n} = select(far{n}, near{n}, enters{n});\n    \
             let meets{n} = (near{n} <= far{n}) & (m{n} > 0.0) & (m{n} < t);\n    t = select(t, m{n}, meets{n});\n"
        );
        let side = |axis: usize| {
            let [low, high] = self.sides[axis];
            // A ray that runs along the edge enters at its lower end and leaves at its upper one.
            format!("select({low}u, {high}u, (b{n}_{axis} < 0.0) == enters{n})")
        };
        let is_at = |axis: usize| {
            format!("select(high{n}_{axis} == m{n}, low{n}_{axis} == m{n}, enters{n})")
        };
        let _ = writeln!(
            text,
            "    primitive = select(primitive, select(select({}, {}, {}), {}, {}), meets{n});",
            side(2),
            side(1),
            is_at(1),
            side(0),
            is_at(0),
        );
        text
    }

    /// The condition under which the ray meets it before `t_max`.
    pub(super) fn meets(&self, number: usize, t_max: &str) -> Condition {
        let n = number;
        Condition {
            before: self.enter(n),
            holds: format!(
                "(near{n} <= far{n}) & (far{n} > 0.0) & (near{n} < {t_max}) & ((near{n} > 0.0) | (far{n} < {t_max}))"
            ),
        }
    }
}

/// What [`Solid::enter`] calls.
pub(super) fn away_from_zero() -> String {
    let least = literal(1e-18);
    format!(
        "fn away_from_zero(x: f32) -> f32 {{\n    return select(x, {least}, abs(x) < {least});\n}}\n\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sides of a box at the origin, in an order and with corners that nobody chose.
    fn sides(first: usize) -> Vec<Target> {
        let edges = [
            DVec3::new(1.0, 0.2, 0.0),
            DVec3::new(-0.1, 0.5, 0.0),
            DVec3::new(0.3, 0.1, 0.8),
        ];
        let corners = [
            (DVec3::ZERO, 0, 1),
            (edges[2], 1, 0),
            (DVec3::ZERO, 1, 2),
            (edges[0], 2, 1),
            (DVec3::ZERO, 2, 0),
            (edges[1], 0, 2),
        ];
        let side = |(index, (a, u, v)): (usize, (DVec3, usize, usize))| Target {
            index: first + index,
            geometry: PrimitiveGeometry::Rectangle {
                a,
                u: edges[u],
                v: edges[v],
            },
            one_sided: false,
            emits: false,
            overlap: [0.0; 4],
        };
        corners.into_iter().enumerate().map(side).collect()
    }

    #[test]
    fn six_sides_are_a_box_and_five_are_none() {
        let mut all = sides(3);
        let found = find(&all);
        assert_eq!(found.len(), 1);
        assert!((3..9).all(|side| found[0].has(side)) && !found[0].has(2));
        let opposite = |[a, b]: [usize; 2]| (a - 3) / 2 == (b - 3) / 2;
        assert!(found[0].sides.into_iter().all(opposite), "{found:?}");
        all.remove(4);
        assert_eq!(find(&all), []);
    }

    #[test]
    fn two_boxes_are_two() {
        let moved = sides(6).into_iter().map(|mut side| {
            if let PrimitiveGeometry::Rectangle { a, .. } = &mut side.geometry {
                *a += DVec3::new(0.0, 3.0, 0.5);
            }
            side
        });
        let all: Vec<_> = sides(0).into_iter().chain(moved).collect();
        let found = find(&all);
        assert_eq!(found.len(), 2);
        assert!((0..12).all(|side| found[0].has(side) != found[1].has(side)));
    }
}
