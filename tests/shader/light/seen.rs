//! Parallelograms and triangles seen from points where rounding is hardest on solid angles, and how
//! far it may move what is made of them.

use crate::support::random::{Random, numbers, rounded};
use crate::support::rounding::U;
use direkt::low_level::reference::exact::solid_angle::polygon_solid_angle;
use glam::{DVec2, DVec3};

/// The points a, a + u and a + v, and for a parallelogram a + u + v, seen from x. All are numbers
/// of f32, edges beginning at a among them.
#[derive(Debug, Clone, Copy)]
pub struct Seen {
    pub kind: &'static str,
    pub x: DVec3,
    pub a: DVec3,
    pub u: DVec3,
    pub v: DVec3,
}

impl Seen {
    /// Edges of these lengths, the second turned off the first's normal by `shear`, seen from the
    /// point with coordinates `foot` and `height`.
    pub fn new(
        kind: &'static str,
        axes: [DVec3; 3],
        (lengths, shear): (DVec2, f64),
        (foot, height): (DVec2, f64),
        x: DVec3,
    ) -> Self {
        let [along, across, normal] = axes;
        let u = rounded(lengths.x * along);
        let v = rounded(lengths.y * (across + shear * along));
        let x = rounded(x);
        let a = rounded(x - foot.x * u - foot.y * v - height * normal);
        Self { kind, x, a, u, v }
    }

    /// Exact solid angle of the parallelogram.
    pub fn solid_angle(&self) -> f64 {
        let Self { x, a, u, v, .. } = *self;
        polygon_solid_angle(x, &[a, a + u, a + u + v, a + v]).abs()
    }

    /// Exact solid angle of the triangle.
    pub fn triangle_solid_angle(&self) -> f64 {
        let Self { x, a, u, v, .. } = *self;
        polygon_solid_angle(x, &[a, a + u, a + v]).abs()
    }

    /// Distance of the farthest corner of the parallelogram.
    pub fn reach(&self) -> f64 {
        let Self { x, a, u, v, .. } = *self;
        let corners = [a, a + u, a + v, a + u + v];
        corners
            .map(|p| p.distance(x))
            .into_iter()
            .fold(0.0, f64::max)
    }

    /// Input words: x, a, u, v.
    pub fn inputs(&self) -> [f64; 12] {
        let parts = [self.x, self.a, self.u, self.v].map(|p| p.to_array());
        std::array::from_fn(|i| parts[i / 3][i % 3])
    }
}

/// A random orthonormal frame, or the axes themselves.
fn axes(random: &mut Random, turned: bool) -> [DVec3; 3] {
    if !turned {
        return [DVec3::X, DVec3::Y, DVec3::Z];
    }
    let z = random.direction().normalize();
    let (x, y) = z.any_orthonormal_pair();
    let (sin, cos) = (random.between(0.0, 6.0)).sin_cos();
    [cos * x + sin * y, cos * y - sin * x, z]
}

/// Points above, beside edges, corners and the plane, at gaps of 10⁻¹ to 10⁻⁵; tiny ones of about
/// 10⁻⁶ sr; slivers. Every other one parallel to the axes.
pub fn hard_cases(seed: u32, shear: f64) -> Vec<Seen> {
    let mut random = Random::new(seed);
    let mut cases = Vec::new();
    for i in 0..2400_u32 {
        let gap = 10_f64.powf(-1.0 - f64::from(i % 5));
        let axes = axes(&mut random, i % 2 == 1);
        let x = 0.5 * random.in_cube();
        let [s, t] = [random.uniform(), random.uniform()];
        let sizes = DVec2::new(random.between(0.3, 1.0), random.between(0.3, 1.0));
        let beside = |r: f64| gap * (r - 0.5);
        let outside = DVec2::new(1.3 + s, 3.0 * t - 1.0);
        let (kind, lengths, foot, height) = match i % 6 {
            0 => ("above", sizes, DVec2::new(s, t), gap),
            1 => ("beside an edge", sizes, DVec2::new(beside(s), t), gap),
            2 => (
                "beside a corner",
                sizes,
                DVec2::new(1.0 + beside(s), beside(t)),
                gap,
            ),
            3 => ("beside the plane", sizes, outside, gap),
            4 => (
                "tiny",
                1e-3 * sizes,
                1e3 * DVec2::new(2.0 * s - 1.0, 2.0 * t - 1.0),
                1.0,
            ),
            _ => (
                "sliver",
                DVec2::new(sizes.x, gap),
                DVec2::new(3.0 * s - 1.0, (2.0 * t - 1.0) / gap),
                0.1,
            ),
        };
        cases.push(Seen::new(kind, axes, (lengths, shear), (foot, height), x));
    }
    cases
}

/// Each case with four points of the unit square: two anywhere, two towards opposite corners.
pub fn with_points(cases: &[Seen], seed: u32) -> Vec<(Seen, DVec2)> {
    let point = |item: u32, k: u32| {
        let [x, y, ..] = numbers(item, k, seed);
        let corner = DVec2::new(x, y).powf(6.0);
        let steps = (corner / U).floor() * U;
        match k {
            0 | 1 => DVec2::new(x, y),
            2 => steps,
            _ => DVec2::splat(1.0 - U) - steps,
        }
    };
    let points = |(i, case): (u32, &Seen)| (0..4).map(|k| (*case, point(i, k))).collect::<Vec<_>>();
    (0..).zip(cases).flat_map(points).collect()
}

/// Roundings by which a coordinate in a rectangle's frame may be off, relative to the farthest
/// corner: the scalar product (3) with an edge that was divided by its length (13). An angle as a
/// fraction of 2π is off by fewer (11).
pub const OF_RECTANGLES: f64 = 16.0;

/// The same of a direction in a triangle's plane, and of its angle at B: a triple product of
/// differences (7) with a length (10), over the scalar product (3) of two cross products (3 each)
/// of sums of differences (2 each); and a root (2).
pub const OF_TRIANGLES: f64 = 32.0;

/// How far `f` is moved by so many roundings of the point relative to the farthest corner, of the
/// edges relative to their lengths, and of both random numbers; along each axis.
pub fn conditioning(
    f: impl Fn(&Seen, DVec2) -> DVec3,
    roundings: f64,
    seen: &Seen,
    u: DVec2,
) -> f64 {
    let step = roundings * U;
    let honest = f(seen, u);
    let mut moved = step * honest.length();
    let mut larger = |cases: [(Seen, DVec2); 2]| {
        let off = cases.map(|(s, u)| f(&s, u).distance(honest));
        moved += off[0].max(off[1]);
    };
    for axis in DVec3::AXES {
        let shift = |length: f64| [step * length * axis, -step * length * axis];
        larger(shift(seen.reach()).map(|d| {
            (
                Seen {
                    x: seen.x + d,
                    ..*seen
                },
                u,
            )
        }));
        larger(shift(seen.u.length()).map(|d| {
            (
                Seen {
                    u: seen.u + d,
                    ..*seen
                },
                u,
            )
        }));
        larger(shift(seen.v.length()).map(|d| {
            (
                Seen {
                    v: seen.v + d,
                    ..*seen
                },
                u,
            )
        }));
    }
    for axis in DVec2::AXES {
        let inside = |u: DVec2| u.clamp(DVec2::ZERO, DVec2::ONE);
        larger([step, -step].map(|d| (*seen, inside(u + d * axis))));
    }
    moved
}
