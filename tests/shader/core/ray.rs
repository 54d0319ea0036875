//! `shaders/core/ray.wesl`.

use crate::support::context;
use crate::support::random::{Random, rounded};
use crate::support::rounding::{U, assert_all_near, assert_near};
use crate::support::shader::{Function, call, words};
use direkt::low_level::reference::core::frame::frame_from_normal;
use glam::{DVec2, DVec3};

/// |d|² is off by 3 U and its reciprocal by 8 U; the root by 4 U + 9 U, the normalised direction by 14 U. The frame's
/// axes change by three times that at most, and have 10 U of their own: 52 U.
#[test]
fn ray_frames_are_orthonormal_around_the_direction() {
    let context = context();
    let function = Function {
        imports: "import package::core::ray::{Ray, ray_frame};",
        body: "let r = ray_frame(Ray(in_vec3f(0u), in_vec3f(3u)));
               out_vec3f(0u, r.origin);
               out_vec3f(3u, r.direction);
               out_vec3f(6u, r.x);
               out_vec3f(9u, r.y);
               out_f32(12u, r.inv_length_squared);",
        inputs: 6,
        outputs: 13,
        features: &[],
    };
    let mut random = Random::new(19);
    let mut rays: Vec<[DVec3; 2]> = (0..50_000)
        .map(|_| {
            let direction = random.direction() * random.magnitude(1e-12, 1e12);
            [random.in_cube(), rounded(direction)]
        })
        .collect();
    for d in [DVec3::X, DVec3::Y, DVec3::Z] {
        for tiny in [0.0, 1e-30, 1e-10] {
            let tilt = tiny * DVec3::new(1.0, -1.0, 1.0);
            rays.extend([d + tilt, tilt - d].map(|d| [DVec3::ZERO, rounded(d)]));
        }
    }
    let inputs: Vec<f64> = rays.iter().flatten().flat_map(|v| v.to_array()).collect();
    let answers = call(context, &function, &words(&inputs));
    let axes = answers.vec3(6).zip(answers.vec3(9));
    for ((&[_, d], (x, y)), inverse) in rays.iter().zip(axes).zip(answers.f64(12)) {
        let what = format!("{}: {d}", context.adapter.name);
        let expected = frame_from_normal(d.normalize());
        assert_all_near(x, expected.x, 52.0 * U, &what);
        assert_all_near(y, expected.y, 52.0 * U, &what);
        let expected = 1.0 / d.length_squared();
        assert_near(inverse, expected, 8.0 * U * expected, &what);
    }
    for (ray, kept) in rays.iter().zip(answers.vec3(0).zip(answers.vec3(3))) {
        assert_eq!((ray[0], ray[1]), kept);
    }
}

/// Each difference is off by U, the dot product by 3 U of its terms.
#[test]
fn projections_are_along_the_ray() {
    let context = context();
    let function = Function {
        imports: "import package::core::ray::{RayFrame, project};",
        body:
            "let r = RayFrame(in_vec3f(0u), vec3f(0.0, 0.0, 1.0), in_vec3f(3u), in_vec3f(6u), 1.0);
               out_vec2f(0u, project(r, in_vec3f(9u)));",
        inputs: 12,
        outputs: 2,
        features: &[],
    };
    let mut random = Random::new(20);
    let cases: Vec<[DVec3; 4]> = (0..20_000)
        .map(|_| {
            let frame = frame_from_normal(random.direction());
            [
                random.in_cube(),
                rounded(frame.x),
                rounded(frame.y),
                random.in_cube(),
            ]
        })
        .collect();
    let inputs: Vec<f64> = cases.iter().flatten().flat_map(|v| v.to_array()).collect();
    let answers = call(context, &function, &words(&inputs));
    for (&[origin, x, y, p], got) in cases.iter().zip(answers.vec2(0)) {
        let q = p - origin;
        let on = |axis: DVec3| (q.dot(axis), 4.0 * U * q.abs().dot(axis.abs()));
        for (got, (expected, bound)) in got.to_array().into_iter().zip([on(x), on(y)]) {
            assert_near(
                got,
                expected,
                bound,
                format!("{}: {p}", context.adapter.name),
            );
        }
    }
}

/// Rounding is monotone: the difference of the rounded products may be zero, but never has the
/// wrong sign, also where the points are parallel up to rounding. Both triangles at an edge see the
/// same number: the edge backwards is its negative, bit for bit. A compiler that fuses one product
/// and not the other breaks this (HARD CASES G1).
#[test]
fn edge_functions_never_have_the_wrong_sign() {
    let context = context();
    let function = Function {
        imports: "import package::core::ray::edge;",
        body: "out_f32(0u, edge(in_vec2f(0u), in_vec2f(2u)));
               out_f32(1u, edge(in_vec2f(2u), in_vec2f(0u)));",
        inputs: 4,
        outputs: 2,
        features: &[],
    };
    let mut random = Random::new(21);
    let mut cases = Vec::new();
    for _ in 0..100_000 {
        let p = random.in_cube().truncate();
        // Parallel up to rounding, and anywhere.
        let along = (p * random.between(-2.0, 2.0)).as_vec2().as_dvec2();
        cases.extend([[p, along], [p, random.in_cube().truncate()]]);
    }
    cases.push([DVec2::ZERO, DVec2::ONE]);
    let inputs: Vec<f64> = cases.iter().flatten().flat_map(|v| v.to_array()).collect();
    let answers = call(context, &function, &words(&inputs));
    let (mut zeros, mut fused_differs) = (0, 0);
    for (&[p, q], (forth, back)) in cases.iter().zip(answers.f64(0).zip(answers.f64(1))) {
        let what = format!("{}: {p} {q}", context.adapter.name);
        // Products of two f32 are exact in f64, and so is the sign of their difference.
        let (a, b) = (p.x * q.y, p.y * q.x);
        assert!(forth * (a - b) >= 0.0, "{what}: {forth} for {}", a - b);
        assert_near(forth, a - b, 2.0 * U * (a.abs() + b.abs()), &what);
        assert_eq!(forth, -back, "{what}");
        zeros += u32::from(forth == 0.0);
        // Broken: one of the products fused with the difference.
        let [px, py, qx, qy] = [p.x, p.y, q.x, q.y].map(|x| x as f32);
        let fused = |a: f32, b: f32, c: f32, d: f32| a.mul_add(b, -(c * d));
        fused_differs += u32::from(fused(px, qy, py, qx) != -fused(qx, py, qy, px));
    }
    assert!(zeros > 1000, "only {zeros} hard cases");
    assert!(fused_differs > 1000, "the cases are hard for no one");
}
