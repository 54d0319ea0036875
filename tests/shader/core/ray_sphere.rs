//! `shaders/core/ray_sphere.wesl`.

use crate::support::context;
use crate::support::hard_cases::{Measured, survive};
use crate::support::random::{Random, rounded};
use crate::support::rounding::U;
use crate::support::shader::{Function, call, words};
use direkt::low_level::reference::core::ray::Ray;
use direkt::low_level::reference::core::ray_sphere::intersect_sphere;
use glam::DVec3;

const INTERSECT: Function<'_> = Function {
    imports: "import package::core::ray_sphere::intersect_sphere;",
    body: "let hits = intersect_sphere(in_vec3f(0u), in_vec3f(3u), in_vec3f(6u), in_f32(9u));
           out_bool(0u, hits.exists);
           out_f32(1u, hits.near);
           out_f32(2u, hits.far);",
    inputs: 10,
    outputs: 3,
    features: &[],
};

#[derive(Debug, Clone, Copy)]
struct Case {
    ray: Ray,
    center: DVec3,
    radius: f64,
}

impl Case {
    fn new(origin: DVec3, direction: DVec3, center: DVec3, radius: f64) -> Self {
        Self {
            ray: Ray {
                origin: rounded(origin),
                direction: rounded(direction),
            },
            center: rounded(center),
            radius: f64::from(radius as f32),
        }
    }

    fn words(&self) -> Vec<u32> {
        let vectors = [self.ray.origin, self.ray.direction, self.center];
        let numbers = vectors.iter().flat_map(|v| v.to_array());
        words(&numbers.chain([self.radius]).collect::<Vec<_>>())
    }

    /// Lengths by which the half chord's square and each root may be off, with D the distance of
    /// the centre: the dot product and the quotient that make the closest point leave it 16 U D
    /// off, so its square l² 2 l · 16 U D, and r² and l² are rounded (4 U each). A root that is a
    /// sum is off by 10 U of itself and by the half chord's error; the other is (D² − r²)/q, off by
    /// 10 U of itself, by that root's relative error, and by 4 U (D² + r²)/q.
    fn bounds(&self) -> (f64, f64, [f64; 2]) {
        let d = self.ray.direction.normalize();
        let oc = self.center - self.ray.origin;
        let (distance, along) = (oc.length(), oc.dot(d));
        let aside = (oc - along * d).length();
        let r2 = self.radius * self.radius;
        let square = r2 - aside * aside;
        let off_square = (32.0 * aside * distance + 4.0 * (r2 + aside * aside)) * U
            + (16.0 * U * distance).powi(2);
        let chord = square.max(0.0).sqrt();
        let off_chord = off_square / chord.max(off_square.sqrt());
        let q = along.abs() + chord;
        let off_q = off_chord + 10.0 * U * q;
        let other = (distance * distance - r2).abs() / q;
        let off_other = other * (off_q / q + 10.0 * U) + 4.0 * U * (distance * distance + r2) / q;
        let roots = if along >= 0.0 {
            [off_other, off_q]
        } else {
            [off_q, off_other]
        };
        // The roots change places where they are closer than their errors.
        (
            square,
            off_square,
            roots.map(|off| off.max(if chord < off_other { off_other } else { 0.0 })),
        )
    }
}

fn cases() -> Vec<Case> {
    let mut random = Random::new(26);
    let mut cases = Vec::new();
    // HARD CASES G8: spheres up to 10⁴ radii away, and origins within; around the silhouette and
    // anywhere.
    for _ in 0..100_000 {
        let radius = random.magnitude(1e-3, 1.0);
        let distance = radius * random.magnitude(1e-3, 1e4);
        let direction = random.direction() * random.magnitude(1e-3, 1e3);
        let aside = random
            .direction()
            .cross(direction.normalize())
            .normalize_or_zero();
        let offset = aside * radius * random.between(0.0, 1.2);
        let origin = random.in_cube();
        let side = if random.uniform() < 0.8 { 1.0 } else { -1.0 };
        let center = origin + side * distance * direction.normalize() + offset;
        cases.push(Case::new(origin, direction, center, radius));
    }
    cases
}

#[test]
fn sphere_intersections_are_the_twins() {
    let context = context();
    let cases = cases();
    let inputs: Vec<u32> = cases.iter().flat_map(Case::words).collect();
    let answers = call(context, &INTERSECT, &inputs);
    let roots = answers.f64(1).zip(answers.f64(2));
    let mut compared = [0, 0];
    for (case, (exists, (near, far))) in cases.iter().zip(answers.u32(0).zip(roots)) {
        let what = format!("{}: {case:?}: {near} {far}", context.adapter.name);
        assert!(near.is_finite() && far.is_finite() && near <= far, "{what}");
        let (square, off_square, [off_near, off_far]) = case.bounds();
        if square.abs() <= off_square {
            continue;
        }
        let expected = intersect_sphere(&case.ray, case.center, case.radius);
        assert_eq!(exists == 1, expected.is_some(), "{what}, not {expected:?}");
        compared[exists as usize] += 1;
        if let Some(expected) = expected {
            let length = case.ray.direction.length();
            let off = [
                (near - expected.0).abs() * length,
                (far - expected.1).abs() * length,
            ];
            assert!(off[0] <= off_near, "{what}, not {expected:?}: {off:?}");
            assert!(off[1] <= off_far, "{what}, not {expected:?}: {off:?}");
        }
    }
    assert!(compared[0] > 10_000 && compared[1] > 50_000, "{compared:?}");
}

/// The roots of |o + t·d − c|² = r² by the quadratic formula.
const TEXTBOOK: Function<'_> = Function {
    imports: "",
    body: "let oc = in_vec3f(0u) - in_vec3f(6u);
           let d = in_vec3f(3u);
           let a = dot(d, d);
           let b = 2.0 * dot(oc, d);
           let c = dot(oc, oc) - in_f32(9u) * in_f32(9u);
           let discriminant = b * b - 4.0 * a * c;
           out_bool(0u, discriminant >= 0.0);
           let root = sqrt(max(discriminant, 0.0));
           out_f32(1u, (-b - root) / (2.0 * a));
           out_f32(2u, (-b + root) / (2.0 * a));",
    inputs: 10,
    outputs: 3,
    features: &[],
};

/// Spheres that are hit or missed though the exact discriminant is beyond rounding, and largest
/// error of the nearer root in units of its bound.
fn mistakes(function: &Function<'_>, cases: &[Case]) -> (f64, f64) {
    let inputs: Vec<u32> = cases.iter().flat_map(Case::words).collect();
    let answers = call(context(), function, &inputs);
    let (mut wrong, mut largest) = (0.0, 0.0_f64);
    for (case, (exists, near)) in cases.iter().zip(answers.u32(0).zip(answers.f64(1))) {
        let (square, off_square, [off_near, _]) = case.bounds();
        if square.abs() <= off_square {
            continue;
        }
        let expected = intersect_sphere(&case.ray, case.center, case.radius);
        if expected.is_some() != (exists == 1) {
            wrong += 1.0;
        } else if let Some((t, _)) = expected {
            largest = largest.max((near - t).abs() * case.ray.direction.length() / off_near);
        }
    }
    (wrong, largest)
}

#[test]
fn distant_spheres_are_hit_where_they_are() {
    let mut random = Random::new(28);
    let cases: Vec<Case> = (0..100_000)
        .map(|_| {
            let radius = random.magnitude(1e-3, 1.0);
            let distance = radius * random.magnitude(10.0, 1e4);
            let direction = random.direction().normalize();
            let aside = direction.any_orthonormal_vector() * radius * random.between(0.0, 1.5);
            let origin = random.in_cube();
            Case::new(
                origin,
                direction,
                origin + distance * direction + aside,
                radius,
            )
        })
        .collect();
    let (naive, ours) = (mistakes(&TEXTBOOK, &cases), mistakes(&INTERSECT, &cases));
    let case = "spheres 10 to 10⁴ radii away, 10⁵ rays";
    for (figure, bound, naive, ours) in [
        ("spheres wrongly hit or missed", 0.0, naive.0, ours.0),
        (
            "error of the distance, over the rounding of coordinates",
            1.0,
            naive.1,
            ours.1,
        ),
    ] {
        survive(
            context(),
            Measured {
                entry: "G8",
                case,
                figure,
                bound,
                textbook: "quadratic formula",
                naive,
                ours,
            },
        );
    }
}

/// From the centre, from the surface inwards and outwards, along a tangent, from behind, a point:
/// finite, and which roots exist and their signs as they should be.
#[test]
fn special_positions_of_spheres_are_right() {
    let context = context();
    let case = |origin, direction| Case::new(origin, direction, DVec3::ZERO, 0.5);
    let [x, z] = [DVec3::X, DVec3::Z];
    let point = Case::new(z, -z, DVec3::ZERO, 0.0);
    // Numbers are powers of two: the roots are exact.
    let rows = [
        (case(DVec3::ZERO, z), Some((-0.5, 0.5))),
        (case(0.5 * z, z), Some((-1.0, 0.0))),
        (case(0.5 * z, -z), Some((0.0, 1.0))),
        (case(0.25 * z, 2.0 * z), Some((-0.375, 0.125))),
        (case(z, -z), Some((0.5, 1.5))),
        (case(z, z), Some((-1.5, -0.5))),
        (case(z + 0.5 * x, -z), Some((1.0, 1.0))),
        (case(z + 0.75 * x, -z), None),
        // A tangent from the point of contact has a double root at zero, which no ray wants.
        (case(0.5 * z, x), None),
        (point, Some((1.0, 1.0))),
    ];
    let inputs: Vec<u32> = rows.iter().flat_map(|(case, _)| case.words()).collect();
    let answers = call(context, &INTERSECT, &inputs);
    let roots = answers.f64(1).zip(answers.f64(2));
    for ((case, expected), (exists, roots)) in rows.iter().zip(answers.u32(0).zip(roots)) {
        assert!(roots.0.is_finite() && roots.1.is_finite());
        let got = (exists == 1).then_some(roots);
        assert_eq!(got, *expected, "{}: {case:?}", context.adapter.name);
        assert_eq!(
            intersect_sphere(&case.ray, case.center, case.radius),
            *expected
        );
    }
}
