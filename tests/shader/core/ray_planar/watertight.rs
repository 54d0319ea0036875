//! Triangles with an edge or a vertex in common leave no gap between them.

use super::IMPORTS;
use crate::support::context;
use crate::support::random::{Random, rounded};
use crate::support::shader::{Function, call, words};
use direkt::low_level::gpu::Context;
use direkt::low_level::reference::core::frame::frame_from_normal;
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_3};

/// Möller and Trumbore's test, which decides for each triangle on its own: the broken twin of
/// watertightness.
const MOLLER_TRUMBORE: &str = "fn leaky(o: vec3f, d: vec3f, a: vec3f, b: vec3f, c: vec3f) -> bool {
    let p = cross(d, c - a);
    let inv = 1.0 / dot(b - a, p);
    let s = dot(o - a, p) * inv;
    let q = cross(o - a, b - a);
    let t = dot(d, q) * inv;
    return s >= 0.0 && t >= 0.0 && s + t <= 1.0;
}
fn watertight(o: vec3f, d: vec3f, a: vec3f, b: vec3f, c: vec3f) -> bool {
    return intersect_triangle(ray_frame(Ray(o, d)), a, b, c).inside;
}";

/// Rays that no triangle of a fan stops: origin, direction, centre and ring of `N` points per item.
/// `closed` fans go all the way round.
fn leaks<const N: usize>(
    context: &Context,
    test: &str,
    closed: bool,
    fans: &[[DVec3; N]],
) -> usize {
    let ring = N - 3;
    let triangles = if closed { ring } else { ring - 1 };
    let body = format!(
        "var stopped = false;
         for (var i = 0u; i < {triangles}u; i++) {{
             let b = in_vec3f(9u + 3u * i);
             let c = in_vec3f(9u + 3u * ((i + 1u) % {ring}u));
             // Every other triangle begins at another corner.
             let a = in_vec3f(6u);
             let o = in_vec3f(0u);
             let d = in_vec3f(3u);
             if i % 2u == 0u {{
                 stopped = stopped || {test}(o, d, a, b, c);
             }} else {{
                 stopped = stopped || {test}(o, d, c, a, b);
             }}
         }}
         out_bool(0u, stopped);"
    );
    let imports = format!("{IMPORTS}\n{MOLLER_TRUMBORE}");
    let function = Function {
        imports: &imports,
        body: &body,
        inputs: 3 * N,
        outputs: 1,
        features: &[],
    };
    let inputs: Vec<f64> = fans.iter().flatten().flat_map(|v| v.to_array()).collect();
    let answers = call(context, &function, &words(&inputs));
    answers.u32(0).filter(|&stopped| stopped == 0).count()
}

/// Points around the ray from `origin` towards `target`, one per given angle, anywhere along it.
fn around<const K: usize>(
    random: &mut Random,
    origin: DVec3,
    target: DVec3,
    angles: [f64; K],
) -> [DVec3; K] {
    let f = frame_from_normal((target - origin).normalize());
    angles.map(|angle| {
        let (sin, cos) = (angle + random.between(-0.3, 0.3)).sin_cos();
        let out = (f.x * cos + f.y * sin) * random.magnitude(0.01, 2.0);
        rounded(target + out + f.z * random.between(-1.0, 1.0))
    })
}

/// HARD CASES G1: two triangles with an edge in common, aimed at that edge: a ray that misses both
/// has leaked.
#[test]
fn triangles_do_not_leak_at_an_edge() {
    let context = context();
    let mut random = Random::new(24);
    let fans: Vec<[DVec3; 6]> = (0..100_000)
        .map(|_| {
            let [origin, a, b] = std::array::from_fn(|_| random.in_cube());
            let target = a.lerp(b, random.between(0.05, 0.95));
            let f = frame_from_normal((target - origin).normalize());
            let along = DVec2::new(f.x.dot(b - a), f.y.dot(b - a));
            let angle = along.y.atan2(along.x);
            let [p, q] = around(
                &mut random,
                origin,
                target,
                [angle - FRAC_PI_2, angle + FRAC_PI_2],
            );
            // Triangles (a, p, b) and (a, b, q).
            [origin, rounded(target - origin), a, p, b, q]
        })
        .collect();
    assert_eq!(
        leaks(context, "watertight", false, &fans),
        0,
        "{}",
        context.adapter.name
    );
    assert!(
        leaks(context, "leaky", false, &fans) > 1000,
        "rays that are hard for none"
    );
}

/// Six triangles around a vertex that the ray is aimed at.
#[test]
fn triangles_do_not_leak_at_a_vertex() {
    let context = context();
    let mut random = Random::new(25);
    let sixths = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0].map(|i| i * FRAC_PI_3);
    let fans: Vec<[DVec3; 9]> = (0..100_000)
        .map(|_| {
            let [origin, target] = std::array::from_fn(|_| random.in_cube());
            let [a, b, c, d, e, f] = around(&mut random, origin, target, sixths);
            [origin, rounded(target - origin), target, a, b, c, d, e, f]
        })
        .collect();
    assert_eq!(
        leaks(context, "watertight", true, &fans),
        0,
        "{}",
        context.adapter.name
    );
    assert!(
        leaks(context, "leaky", true, &fans) > 1000,
        "rays that are hard for none"
    );
}
