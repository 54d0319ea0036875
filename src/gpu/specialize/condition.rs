//! When a ray o + t·d meets one primitive.

use super::expressions::{linear, literal, turned, vector, without_traces};
use crate::accel::PrimitiveGeometry;
use glam::DVec3;
use std::fmt::Write as _;

/// Statements, and the condition that they make ready.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Condition {
    pub(super) before: String,
    pub(super) holds: String,
}

/// A primitive as rays meet it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Target {
    pub(super) index: usize,
    pub(super) geometry: PrimitiveGeometry,
    /// Whether rays pass through its back.
    pub(super) one_sided: bool,
    pub(super) emits: bool,
    /// What a planar primitive is larger by at each of its [`edges`].
    pub(super) overlap: [f64; 4],
}

/// The edges of a primitive with coordinates s and w along its own: where s and w begin and, but
/// for a triangle, which has one more, where they end.
pub(super) fn edges(geometry: &PrimitiveGeometry) -> Vec<[DVec3; 2]> {
    match *geometry {
        PrimitiveGeometry::Triangle { a, u, v } => {
            vec![[a, a + v], [a, a + u], [a + u, a + v]]
        }
        PrimitiveGeometry::Rectangle { a, u, v } => {
            let across = a + u + v;
            vec![[a, a + v], [a, a + u], [a + u, across], [a + v, across]]
        }
        _ => Vec::new(),
    }
}

impl Target {
    /// The condition under which the ray meets it before `t_max`; what is before it defines
    /// t{index}. `None` where no ray does.
    pub(super) fn meets(&self, t_max: &str) -> Option<Condition> {
        match self.geometry {
            PrimitiveGeometry::Sphere { center, radius } => {
                let (center, radius) = (vector(center), literal(radius as f32));
                Some(self.round(&format!("sphere(o, d, {center}, {radius})"), t_max))
            }
            PrimitiveGeometry::Ellipsoid {
                center,
                radii,
                rodrigues,
            } => {
                let vectors = [center, radii, rodrigues].map(vector);
                Some(self.round(&format!("ellipsoid(o, d, {})", vectors.join(", ")), t_max))
            }
            PrimitiveGeometry::Triangle { a, u, v }
            | PrimitiveGeometry::Rectangle { a, u, v }
            | PrimitiveGeometry::Disk { a, u, v } => self.planar([a, u, v], t_max),
        }
    }

    /// The same for what the ray enters and leaves, as intersect_`call` says.
    fn round(&self, call: &str, t_max: &str) -> Condition {
        let i = self.index;
        let mut holds = format!("q{i}.exists & (t{i} > 0.0) & (t{i} < {t_max})");
        if self.one_sided {
            let _ = write!(holds, " & e{i}");
        }
        Condition {
            before: format!(
                "    let q{i} = intersect_{call};\n    let e{i} = q{i}.near > 0.0;\n    \
                 let t{i} = select(q{i}.far, q{i}.near, e{i} & (q{i}.near < {t_max}));\n"
            ),
            holds,
        }
    }

    fn planar(&self, [a, u, v]: [DVec3; 3], t_max: &str) -> Option<Condition> {
        let i = self.index;
        let normal = u.cross(v);
        let squared = normal.length_squared();
        if !(squared > 0.0 && squared.is_finite()) {
            return None;
        }
        let (n, is_turned) = turned(normal);
        let along = linear(n, "d", 0.0);
        let mut before = format!(
            "    let t{i} = ({} - {}) * (1.0 / {along});\n",
            literal(n.dot(a) as f32),
            linear(n, "o", 0.0),
        );
        let inside = if matches!(self.geometry, PrimitiveGeometry::Rectangle { .. })
            && !self.geometry.is_skewed()
        {
            self.within_edges(a + 0.5 * (u + v), [u, v])
        } else {
            let reciprocal = [v.cross(normal), normal.cross(u)].map(|r| r / squared);
            for (name, r) in ["s", "w"].into_iter().zip(reciprocal) {
                let _ = writeln!(before, "    let {name}{i} = {};", self.at(r, r.dot(a)));
            }
            self.within_coordinates(reciprocal)
        };
        let mut holds = format!("{inside} & (t{i} > 0.0) & (t{i} < {t_max})");
        if self.one_sided {
            let against = if is_turned { ">" } else { "<" };
            let _ = write!(holds, " & ({along} {against} 0.0)");
        }
        Some(Condition { before, holds })
    }

    /// Whether the point of the plane lies within a rectangle around `middle`.
    fn within_edges(&self, middle: DVec3, edges: [DVec3; 2]) -> String {
        let within = |axis: usize| {
            let edge = edges[axis];
            let [before, behind] = [self.overlap[axis], self.overlap[axis + 2]];
            let middle = middle + 0.5 * (behind - before) * edge.normalize();
            let half = literal((0.5 * (edge.length() + before + behind)) as f32);
            let (along, _) = turned(edge);
            format!("(abs({}) <= {half})", self.at(along, along.dot(middle)))
        };
        format!("{} & {}", within(0), within(1))
    }

    /// Whether coordinates s and w along the edges are those of a point within; `reciprocal` are
    /// their gradients.
    fn within_coordinates(&self, reciprocal: [DVec3; 2]) -> String {
        let [s, w] = ["s", "w"].map(|name| format!("{name}{}", self.index));
        let [of_s, of_w] = reciprocal.map(DVec3::length);
        let number = |x: f64| literal(x as f32);
        let [s_low, w_low, third, fourth] = self.overlap;
        let begins = format!(
            "({s} >= {}) & ({w} >= {})",
            number(-s_low * of_s),
            number(-w_low * of_w)
        );
        match self.geometry {
            PrimitiveGeometry::Disk { .. } => format!("(fma({s}, {s}, {w} * {w}) <= 1.0)"),
            PrimitiveGeometry::Triangle { .. } => {
                let of_sum = (reciprocal[0] + reciprocal[1]).length();
                format!("{begins} & ({s} + {w} <= {})", number(1.0 + third * of_sum))
            }
            _ => format!(
                "{begins} & ({s} <= {}) & ({w} <= {})",
                number(1.0 + third * of_s),
                number(1.0 + fourth * of_w)
            ),
        }
    }

    /// r · (o + t·d) − `middle` where the ray meets the plane.
    fn at(&self, r: DVec3, middle: f64) -> String {
        let r = without_traces(r);
        let [along, from] = [("d", 0.0), ("o", -middle)].map(|(of, plus)| linear(r, of, plus));
        format!("fma(t{}, {along}, {from})", self.index)
    }
}
