//! Lights edge-on, from behind, in the receiver's plane and below its horizon: HARD CASES G10.

use crate::support::hard_cases::{Measured, survive};
use crate::support::random::numbers;
use crate::support::{STRATEGIES, assert_pixel, context, emitter, floor_pixel, render};
use direkt::scene::{Geometry, LightSampling, Mesh, Sampler, Scene};
use glam::{DVec3, Vec3};

fn lit_by(geometry: Geometry, two_sided: bool) -> Scene {
    let mut scene = floor_pixel();
    scene.shapes.push(emitter(geometry, 1.0, two_sided));
    scene.render.estimator.sampler = Sampler::Independent;
    scene.render.estimator.light_sampling = LightSampling::SolidAngle;
    scene
}

fn square(corner: DVec3, u: DVec3, v: DVec3) -> Geometry {
    Geometry::Rectangle { corner, u, v }
}

/// Lights of which nothing arrives at the origin of the plane z = 0.
fn dark() -> [(&'static str, Scene); 4] {
    let [x, y, z] = DVec3::AXES;
    let coplanar = || square(DVec3::new(0.5, -0.5, 0.0), x, y);
    let behind = square(DVec3::new(-0.5, -0.5, 1.0), x, y);
    let below = square(DVec3::new(-0.5, -0.5, -1.0), x, y);
    // Level with the horizon above, but edge-on.
    let edge_on = square(DVec3::new(0.5, 0.0, 0.1), x, z);
    [
        ("coplanar", lit_by(coplanar(), true)),
        ("from behind", lit_by(behind, false)),
        ("below", lit_by(below, true)),
        ("edge-on", lit_by(edge_on, true)),
    ]
}

/// The textbook's sample in f32: density d²/(A·|cosθ|) of area sampling, in the power heuristic
/// with that of the cosine.
fn textbook_sample(light: &Geometry, u: [f64; 2]) -> f32 {
    let Geometry::Rectangle {
        corner,
        u: e1,
        v: e2,
    } = light
    else {
        unreachable!("the lights are rectangles")
    };
    let y: Vec3 = (*corner + *e1 * u[0] + *e2 * u[1]).as_vec3();
    let n = e1.cross(*e2).as_vec3();
    let wi = y.normalize();
    let cos_light = n.normalize().dot(wi).abs();
    let by_light = y.length_squared() / (n.length() * cos_light);
    let by_cosine = wi.z.max(0.0) / std::f32::consts::PI;
    let weight = by_light * by_light / (by_light * by_light + by_cosine * by_cosine);
    weight * wi.z.max(0.0) / by_light
}

#[test]
fn lights_that_send_nothing_send_nothing() {
    let context = context();
    let (mut ours, mut naive) = (0.0, 0.0);
    for (what, scene) in dark() {
        for strategy in STRATEGIES {
            let mut scene = scene.clone();
            scene.render.estimator.strategy = strategy;
            scene.render.stop.spp = 1024;
            let film = render(context, scene);
            let pixel = &film.pixels[0];
            // Edge-on, the position's rounding decides how much of the light is seen.
            let most = if what == "edge-on" { 2e-5 } else { 0.0 };
            assert!(pixel.mean[0] <= most, "{what}, {strategy}: {pixel:?}");
            ours += film.ledger.dropped as f64;
        }
        let light = &scene.shapes[1].geometry;
        let samples = (0..1024).map(|i| {
            let [x, y, ..] = numbers(i, 1, 81);
            textbook_sample(light, [x, y])
        });
        naive += samples.filter(|s| !s.is_finite()).count() as f64;
    }
    survive(
        context,
        Measured {
            entry: "G10",
            case: "lights in the plane, from behind, below and edge-on",
            figure: "samples that are not finite",
            bound: 0.0,
            textbook: "power heuristic with d²/(A·cosθ)",
            naive,
            ours,
        },
    );
}

/// The triangle of the catalogue, cut by the horizon: F = 0.391227737431134.
#[test]
fn half_a_triangle_below_the_horizon_does_not_count() {
    let context = context();
    let triangle = Geometry::Mesh(Mesh {
        positions: vec![
            DVec3::new(1.0, 0.0, -0.5),
            DVec3::new(0.0, 1.0, 1.0),
            DVec3::new(-1.0, -0.5, 2.0),
        ],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    });
    for strategy in STRATEGIES {
        let mut scene = lit_by(triangle.clone(), true);
        // The camera is behind the triangle otherwise.
        scene.camera.eye = DVec3::new(0.0, -0.1, 0.05);
        scene.camera =
            direkt::scene::Camera::look_at(scene.camera.eye, DVec3::ZERO, DVec3::Z, 1e-5).unwrap();
        scene.render.estimator.strategy = strategy;
        scene.render.stop.spp = 1 << 16;
        let film = render(context, scene);
        let what = format!("clipped triangle, {strategy}, {}", context.adapter.name);
        assert_pixel(&film, 0.5 * 0.391_227_737_431_134, &what);
    }
}
