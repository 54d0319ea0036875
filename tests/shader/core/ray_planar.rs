//! `shaders/core/ray_planar.wesl`.

mod watertight;

use crate::support::context;
use crate::support::random::{Random, rounded};
use crate::support::rounding::U;
use crate::support::shader::{Answers, Function, call, words};
use direkt::low_level::gpu::Context;
use direkt::low_level::reference::core::ray::Ray;
use direkt::low_level::reference::core::ray_planar::{
    PlanarHit, intersect_disk, intersect_rectangle, intersect_triangle,
};
use glam::{DVec2, DVec3};

const IMPORTS: &str = "import package::core::ray::{Ray, ray_frame};
    import package::core::ray_planar::{intersect_disk, intersect_rectangle, intersect_triangle};";

/// A ray's origin and direction, and the points a, b, c.
type Case = [DVec3; 5];

fn intersect(context: &Context, shape: &str, cases: &[Case]) -> Answers {
    let body = format!(
        "let r = ray_frame(Ray(in_vec3f(0u), in_vec3f(3u)));
         let hit = intersect_{shape}(r, in_vec3f(6u), in_vec3f(9u), in_vec3f(12u));
         out_bool(0u, hit.inside);
         out_bool(1u, hit.front);
         out_f32(2u, hit.t);
         out_vec2f(3u, hit.st);"
    );
    let function = Function {
        imports: IMPORTS,
        body: &body,
        inputs: 15,
        outputs: 5,
        features: &[],
    };
    let inputs: Vec<f64> = cases.iter().flatten().flat_map(|v| v.to_array()).collect();
    call(context, &function, &words(&inputs))
}

fn hits(answers: &Answers) -> impl Iterator<Item = PlanarHit> {
    let flags = answers.u32(0).zip(answers.u32(1));
    let numbers = answers.f64(2).zip(answers.vec2(3));
    flags
        .zip(numbers)
        .map(|((inside, front), (t, st))| PlanarHit {
            inside: inside == 1,
            front: front == 1,
            t,
            st,
        })
}

/// Rays from anywhere towards points on and around the primitive, of any length.
fn random_cases(seed: u32, count: usize) -> Vec<Case> {
    let mut random = Random::new(seed);
    let mut case = || {
        let [origin, a, b, c] = std::array::from_fn(|_| random.in_cube());
        let (s, t) = (random.between(-1.5, 1.5), random.between(-1.5, 1.5));
        let direction = a + s * (b - a) + t * (c - a) - origin;
        let length = random.magnitude(1e-3, 1e3);
        [origin, rounded(length * direction), a, b, c]
    };
    (0..count).map(|_| case()).collect()
}

/// How far coordinates and distance (in length) of a hit may be off.
///
/// With R the largest distance of a vertex from the origin, M that of a projected one from the ray,
/// A the projected area: axes are off by 52 U (see `ray`), so projections by 60 U R together with
/// their own rounding. A parallelogram's corners, three projections together, are off by 180 U R;
/// an edge function is off by twice that times 2M, the area, of differences of projections, by 480
/// U R M; in all below 1200 U R M/A for coordinates of at most 1, M ≤ R including the products' own
/// rounding. The distance is off by that times the edges' extent along the ray, and by its own 20 U
/// R.
fn bounds([origin, direction, a, b, c]: &Case) -> (f64, f64) {
    let d = direction.normalize();
    let corners = [*a, *b, *c, *b + *c - *a].map(|p| p - *origin);
    let reach = corners.map(DVec3::length).into_iter().fold(0.0, f64::max);
    let aside = corners
        .map(|p| p.cross(d).length())
        .into_iter()
        .fold(0.0, f64::max);
    let area = (*b - *a).cross(*c - *a).dot(d).abs();
    let st = 1200.0 * U * reach * aside / area;
    let extent = (*b - *a).dot(d).abs() + (*c - *a).dot(d).abs();
    (st, st * extent + 20.0 * U * reach)
}

/// `margin` is how far coordinates lie inside (or, below zero, outside) of the primitive.
fn compare(
    shape: &str,
    twin: fn(&Ray, DVec3, DVec3, DVec3) -> PlanarHit,
    margin: fn(DVec2) -> f64,
) {
    let context = context();
    let cases = random_cases(22, 100_000);
    let answers = intersect(context, shape, &cases);
    let mut compared = [0, 0];
    for (case, got) in cases.iter().zip(hits(&answers)) {
        let what = format!("{}: {shape} {case:?}: {got:?}", context.adapter.name);
        assert!(got.t.is_finite() && got.st.is_finite(), "{what}");
        let &[origin, direction, a, b, c] = case;
        let expected = twin(&Ray { origin, direction }, a, b - a, c - a);
        let (off_st, off_t) = bounds(case);
        // A sum of two coordinates is off by both.
        if off_st > 0.02 || margin(expected.st).abs() <= 2.0 * off_st {
            continue;
        }
        assert_eq!(got.inside, expected.inside, "{what}, not {expected:?}");
        compared[usize::from(got.inside)] += 1;
        if got.inside {
            assert_eq!(got.front, expected.front, "{what}");
            let off = (got.st - expected.st).abs().max_element();
            assert!(off <= off_st, "{what}, not {expected:?}");
            let off = (got.t - expected.t).abs() * direction.length();
            assert!(off <= off_t, "{what}, not {expected:?}");
        }
    }
    assert!(compared[0] > 5_000 && compared[1] > 5_000, "{compared:?}");
}

#[test]
fn triangle_intersections_are_the_twins() {
    compare("triangle", intersect_triangle, |st| {
        st.min_element().min(1.0 - st.x - st.y)
    });
}

#[test]
fn rectangle_intersections_are_the_twins() {
    compare("rectangle", intersect_rectangle, |st| {
        st.min_element().min(1.0 - st.max_element())
    });
}

#[test]
fn disk_intersections_are_the_twins() {
    compare("disk", intersect_disk, |st| 1.0 - st.length());
}

/// Seen edge-on, without area, minute or huge, along an axis: finite, and within the primitive
/// where it is met.
#[test]
fn degenerate_primitives_give_finite_hits() {
    let context = context();
    let mut cases = vec![];
    let mut random = Random::new(23);
    for scale in [1e-20, 1e-12, 1e-6, 1.0, 1e6] {
        for _ in 0..200 {
            let [origin, a, u, v] = std::array::from_fn(|_| random.in_cube());
            let (u, v) = (scale * u, scale * v);
            let to = |p: DVec3| p - origin;
            // No area: a point, a line; a sliver; edge-on; along a side; from a vertex.
            cases.push([origin, to(a), a, a, a]);
            cases.push([origin, to(a + 0.5 * u), a, a + u, a + 2.0 * u]);
            cases.push([origin, to(a + 0.5 * u), a, a + u, a + 0.5 * u + 1e-7 * v]);
            cases.push([a - u - v, u + v, a, a + u, a + v]);
            cases.push([a - u, u, a, a + u, a + v]);
            cases.push([a, u, a, a + u, a + v]);
            cases.push([a, u.cross(v), a, a + u, a + v]);
            cases.push([a, -DVec3::Z, a + u, a + v, a]);
        }
    }
    let cases: Vec<Case> = cases
        .iter()
        .map(|c| c.map(rounded))
        .filter(|c| c[1].length() > 1e-15)
        .collect();
    for shape in ["triangle", "rectangle", "disk"] {
        let answers = intersect(context, shape, &cases);
        for (case, got) in cases.iter().zip(hits(&answers)) {
            let what = format!("{}: {shape} {case:?}: {got:?}", context.adapter.name);
            assert!(got.t.is_finite() && got.st.is_finite(), "{what}");
            let range = if shape == "disk" {
                -1.0..=1.0
            } else {
                0.0..=1.0
            };
            let slack = 8.0 * U;
            let within = |x: f64| {
                range.contains(&x) || range.contains(&(x - slack)) || range.contains(&(x + slack))
            };
            assert!(
                !got.inside || (within(got.st.x) && within(got.st.y)),
                "{what}"
            );
        }
    }
}
