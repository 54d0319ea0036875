//! `shaders/core/ray_ellipsoid.wesl`.

use crate::support::context;
use crate::support::random::{Random, rounded};
use crate::support::rounding::{U, assert_all_near};
use crate::support::shader::{Answers, Function, call, words};
use direkt::low_level::reference::core::ray::Ray;
use direkt::low_level::reference::core::ray_ellipsoid::{ellipsoid_normal, intersect_ellipsoid};
use direkt::scene::ellipsoid::{PrincipalAxes, rotation};
use glam::{DMat3, DVec3};

/// Three products and sums of components of `v`, and twice more: 16 U of its length.
#[test]
fn rotations_are_the_twins() {
    let function = Function {
        imports: "import package::core::ray_ellipsoid::rotate;",
        body: "out_vec3f(0u, rotate(in_vec3f(0u), in_vec3f(3u)));
               out_vec3f(3u, rotate(-in_vec3f(0u), in_vec3f(3u)));",
        inputs: 6,
        outputs: 6,
        features: &[],
    };
    let mut random = Random::new(91);
    let cases: Vec<(DVec3, DVec3)> = (0..10_000)
        .map(|_| {
            let g = rounded(random.direction() * random.between(0.0, 0.62));
            (g, rounded(random.direction() * random.magnitude(1e-6, 1e6)))
        })
        .collect();
    let inputs: Vec<f64> = cases
        .iter()
        .flat_map(|(g, v)| [g.to_array(), v.to_array()].concat())
        .collect();
    let answers = call(context(), &function, &words(&inputs));
    for ((g, v), (there, back)) in cases.iter().zip(answers.vec3(0).zip(answers.vec3(3))) {
        let bound = 16.0 * U * v.length();
        assert_all_near(there, rotation(*g) * *v, bound, format!("{g} {v}"));
        let expected = rotation(*g).transpose() * *v;
        assert_all_near(back, expected, bound, format!("{g} {v}, back"));
    }
}

#[derive(Debug, Clone, Copy)]
struct Case {
    ray: Ray,
    center: DVec3,
    radii: DVec3,
    rodrigues: DVec3,
}

impl Case {
    fn words(&self) -> Vec<u32> {
        let vectors = [
            self.ray.origin,
            self.ray.direction,
            self.center,
            self.radii,
            self.rodrigues,
        ];
        words(&vectors.map(|v| v.to_array()).concat())
    }

    /// By how much rounding moves points: 32 roundings of the coordinates relative to the centre.
    fn rounding(&self) -> f64 {
        let reach = (self.center - self.ray.origin).length() + self.radii.max_element();
        32.0 * U * reach
    }

    fn axes(&self) -> DMat3 {
        PrincipalAxes {
            radii: self.radii,
            rodrigues: self.rodrigues,
        }
        .axes()
    }

    /// Ray parameters at which the ellipsoid with half axes longer by `more` is met; `None` where
    /// it has none, or is missed.
    fn met(&self, more: f64) -> Option<(f64, f64)> {
        let radii = self.radii + DVec3::splat(more);
        if radii.min_element() <= 0.0 {
            return None;
        }
        let grown = Self { radii, ..*self };
        let (near, far) = intersect_ellipsoid(&self.ray, self.center, grown.axes())?;
        Some((near.0, far.0))
    }
}

/// Ellipsoids whose half axes differ by up to `aspect`, up to 10³ of the longest away: from outside
/// towards them and past, and from within.
fn cases(aspect: f64, count: usize) -> Vec<Case> {
    let mut random = Random::new(92);
    let mut case = || {
        let longest = random.magnitude(1e-3, 1.0);
        let mut length = || longest / random.magnitude(1.0, aspect);
        let mut radii = [longest, length(), length()];
        radii.rotate_left((random.uniform() * 3.0) as usize);
        let rodrigues = random.direction() * random.between(0.0, 0.6);
        let radii = DVec3::from_array(radii);
        let target = rotation(rodrigues) * (radii * random.direction() * random.between(0.0, 1.2));
        let direction = random.direction().normalize();
        let back = longest * random.magnitude(1e-2, 1e3);
        let center = random.in_cube();
        let origin = if random.uniform() < 0.2 {
            center + 0.8 * target
        } else {
            center + target - back * direction
        };
        Case {
            ray: Ray {
                origin: rounded(origin),
                direction: rounded(direction * random.magnitude(1e-3, 1e3)),
            },
            center: rounded(center),
            radii: rounded(radii),
            rodrigues: rounded(rodrigues),
        }
    };
    (0..count).map(|_| case()).collect()
}

const INTERSECT: Function<'_> = Function {
    imports: "import package::core::ray_ellipsoid::intersect_ellipsoid;",
    body: "let hits = intersect_ellipsoid(
               in_vec3f(0u), in_vec3f(3u), in_vec3f(6u), in_vec3f(9u), in_vec3f(12u));
           out_bool(0u, hits.exists); out_f32(1u, hits.near); out_f32(2u, hits.far);
           out_vec3f(3u, hits.near_point); out_vec3f(6u, hits.far_point);",
    inputs: 15,
    outputs: 9,
    features: &[],
};

/// In the sphere's space, by its intersection: what is divided by a short half axis loses as many
/// digits.
const IN_SPHERES_SPACE: Function<'_> = Function {
    imports: "import package::core::ray_ellipsoid::rotate;
              import package::core::ray_sphere::intersect_sphere;",
    body: "let origin = rotate(-in_vec3f(12u), in_vec3f(0u) - in_vec3f(6u)) / in_vec3f(9u);
           let direction = rotate(-in_vec3f(12u), in_vec3f(3u)) / in_vec3f(9u);
           let hits = intersect_sphere(origin, direction, vec3f(0.0), 1.0);
           out_bool(0u, hits.exists); out_f32(1u, hits.near); out_f32(2u, hits.far);
           out_vec3f(3u, normalize(origin + hits.near * direction));
           out_vec3f(6u, normalize(origin + hits.far * direction));",
    ..INTERSECT
};

/// How many cases are hit or missed that are not, met elsewhere than between the ellipsoid grown
/// and shrunk by rounding, or at points that do not lie there; and how many of all were hit.
fn mistakes(function: &Function<'_>, cases: &[Case]) -> (usize, usize) {
    let inputs: Vec<u32> = cases.iter().flat_map(Case::words).collect();
    let answers = call(context(), function, &inputs);
    let roots = answers.f64(1).zip(answers.f64(2));
    let points = answers.vec3(3).zip(answers.vec3(6));
    let found = answers.u32(0).zip(roots.zip(points));
    let mut hits = 0;
    let wrong = cases.iter().zip(found).filter(|(case, found)| {
        let &(exists, ((near, far), (near_point, far_point))) = found;
        hits += exists as usize;
        let rounding = case.rounding();
        let (grown, shrunk) = (case.met(rounding), case.met(-rounding));
        if exists == 0 {
            return shrunk.is_some();
        }
        let Some(grown) = grown else { return true };
        let off = rounding / case.ray.direction.length();
        let (first, last) = shrunk.unwrap_or((grown.1, grown.0));
        let between = near >= grown.0 - off
            && near <= first + off
            && far >= last - off
            && far <= grown.1 + off
            && near <= far + off;
        let there = [(near, near_point), (far, far_point)].map(|(t, p)| {
            let on_ray = case.ray.origin + t * case.ray.direction;
            let on_ellipsoid = case.center + case.axes() * p;
            (p.length() - 1.0).abs() < 32.0 * U && on_ray.distance(on_ellipsoid) < 8.0 * rounding
        });
        !(between && there == [true; 2])
    });
    (wrong.count(), hits)
}

/// Also such as are flat as a disk or thin as a needle, where the intersection of spheres fails in
/// their space.
#[test]
fn ellipsoids_are_met_where_they_are() {
    for aspect in [3.0, 1e4, 1e6, 1e8] {
        let cases = cases(aspect, 50_000);
        let (wrong, hits) = mistakes(&INTERSECT, &cases);
        assert_eq!(wrong, 0, "half axes that differ by up to {aspect:e}");
        assert!(hits > 10_000, "{hits} hits at {aspect:e}");
        let (naive, _) = mistakes(&IN_SPHERES_SPACE, &cases);
        assert!(aspect < 1e4 || naive > 1000, "{naive} at {aspect:e}");
    }
}

fn special(origin: DVec3, direction: DVec3) -> Case {
    Case {
        ray: Ray { origin, direction },
        center: DVec3::new(0.5, 0.0, -1.0),
        radii: DVec3::new(2.0, 0.5, 0.25),
        rodrigues: DVec3::ZERO,
    }
}

/// From the centre, from the surface inwards and outwards, along a tangent, past it, from far away:
/// numbers are powers of two, so that all is exact.
#[test]
fn special_positions_of_ellipsoids_are_right() {
    let center = DVec3::new(0.5, 0.0, -1.0);
    let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z];
    let rows = [
        (special(center, z), Some((-0.25, 0.25))),
        (special(center + 0.25 * z, z), Some((-0.5, 0.0))),
        (special(center + 0.25 * z, -z), Some((0.0, 0.5))),
        (special(center - 4.0 * x, 2.0 * x), Some((1.0, 3.0))),
        (special(center + 2.0 * y, y), Some((-2.5, -1.5))),
        (special(center + 0.5 * y - 8.0 * x, x), Some((8.0, 8.0))),
        (special(center + y - 8.0 * x, x), None),
        (special(center + 8.0 * y - 8.0 * x, x), None),
        (special(center + 1e18 * y, x), None),
    ];
    let inputs: Vec<u32> = rows.iter().flat_map(|(case, _)| case.words()).collect();
    let answers: Answers = call(context(), &INTERSECT, &inputs);
    let roots = answers.f64(1).zip(answers.f64(2));
    for ((case, expected), (exists, roots)) in rows.iter().zip(answers.u32(0).zip(roots)) {
        assert!(roots.0.is_finite() && roots.1.is_finite(), "{case:?}");
        assert_eq!((exists == 1).then_some(roots), *expected, "{case:?}");
        let twin = intersect_ellipsoid(&case.ray, case.center, case.axes());
        let twin = twin.map(|(near, far)| (near.0, far.0));
        assert_eq!(twin, *expected, "{case:?}, the twin");
    }
}

/// Components of a unit vector are known to 4 U, and multiplied by what differs by the square of
/// the aspect; turned, 16 U.
#[test]
fn normals_are_the_twins() {
    let function = Function {
        imports: "import package::core::ray_ellipsoid::ellipsoid_normal;",
        body: "out_vec3f(0u, ellipsoid_normal(in_vec3f(0u), in_vec3f(3u), in_vec3f(6u)));",
        inputs: 9,
        outputs: 3,
        features: &[],
    };
    let mut random = Random::new(93);
    for aspect in [2.0, 1e4, 1e9] {
        let cases: Vec<[DVec3; 3]> = cases(aspect, 5000)
            .iter()
            .map(|case| {
                [
                    case.radii,
                    case.rodrigues,
                    rounded(random.direction().normalize()),
                ]
            })
            .collect();
        let inputs: Vec<f64> = cases.iter().flatten().flat_map(|v| v.to_array()).collect();
        let answers = call(context(), &function, &words(&inputs));
        for ([radii, rodrigues, p], normal) in cases.iter().zip(answers.vec3(0)) {
            let axes = PrincipalAxes {
                radii: *radii,
                rodrigues: *rodrigues,
            };
            let expected = ellipsoid_normal(axes.axes(), *p);
            assert_all_near(normal, expected, 40.0 * U, format!("{axes:?} {p}"));
        }
    }
}
