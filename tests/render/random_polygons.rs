//! Polygon lights that nobody has looked at: each agrees with Lambert's formula.

use crate::support::{STRATEGIES, context, emitter, floor_pixel, render, statistics};
use direkt::low_level::reference::core::rng::{pcg4d, to_unit};
use direkt::low_level::reference::exact::polygon::polygon_factor;
use direkt::low_level::stats::z_test::z_test;
use direkt::scene::{FilmSize, Geometry, Mesh, Strategy};
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// Polygons tried.
const POLYGONS: u32 = 12;

/// Numbers in [0, 1), the same for the same polygon.
fn numbers(polygon: u32) -> impl FnMut() -> f64 {
    let mut drawn = 0;
    move || {
        drawn += 1;
        to_unit(pcg4d([polygon, drawn, 0, 171])[0])
    }
}

/// A convex polygon of 3 to 7 corners on an ellipse, somewhere around a point near the origin and
/// turned anyhow: some cross the horizon of the floor, and some show it their back.
fn polygon(index: u32) -> Vec<DVec3> {
    let mut next = numbers(index);
    let corners = 3 + (5.0 * next()) as usize;
    let mut angles: Vec<f64> = (0..corners).map(|_| TAU * next()).collect();
    angles.sort_by(f64::total_cmp);
    let axes = DVec2::new(0.4 + 2.0 * next(), 0.4 + 2.0 * next());
    let centre = DVec3::new(4.0 * next() - 2.0, 4.0 * next() - 2.0, 0.2 + 2.0 * next());
    let z = 2.0 * next() - 1.0;
    let azimuth = TAU * next();
    let normal = DVec3::new(
        (1.0 - z * z).sqrt() * azimuth.cos(),
        (1.0 - z * z).sqrt() * azimuth.sin(),
        z,
    );
    let (x, y) = normal.any_orthonormal_pair();
    let corner = |a: f64| centre + axes.x * a.cos() * x + axes.y * a.sin() * y;
    angles.into_iter().map(corner).collect()
}

/// As a mesh of triangles from the first corner.
fn fan(corners: &[DVec3]) -> Geometry {
    let last = corners.len() as u32 - 1;
    Geometry::Mesh(Mesh {
        positions: corners.to_vec(),
        triangles: (1..last).map(|i| [0, i, i + 1]).collect(),
        ..Mesh::default()
    })
}

/// 2²⁰ samples of a floor of reflectance ½ under a polygon of radiance 10: ρ·L·F within 4.5
/// standard errors. The floor is small, so that it hides nothing of what is below the horizon, and
/// what is below it must not arrive.
#[test]
fn any_polygon_light_agrees_with_lamberts_formula() {
    let context = context();
    let (mut lit, mut sharp) = (0, 0);
    for index in 0..POLYGONS {
        let corners = polygon(index);
        let factor = polygon_factor(DVec3::ZERO, DVec3::Z, &corners);
        for strategy in STRATEGIES {
            let two_sided = index % 3 == 2;
            let factor = if two_sided {
                factor.abs()
            } else {
                factor.max(0.0)
            };
            let mut scene = floor_pixel();
            scene.shapes[0].geometry = Geometry::Rectangle {
                corner: DVec3::new(-0.01, -0.01, 0.0),
                u: DVec3::new(0.02, 0.0, 0.0),
                v: DVec3::new(0.0, 0.02, 0.0),
            };
            // Close to the floor, so that no light comes between.
            let towards = scene.camera.eye.normalize();
            scene.camera.eye = 0.015 * towards;
            scene.shapes.push(emitter(fan(&corners), 10.0, two_sided));
            scene.render.estimator.strategy = strategy;
            // Under the others the polygons share the kernels that load them.
            scene.render.estimator.specialize = strategy == Strategy::MisPower;
            scene.render.seed = index;
            scene.render.stop.spp = 256;
            scene.film = FilmSize {
                width: 64,
                height: 64,
            };
            let film = render(context, scene);
            let what = format!("polygon {index}, {strategy}, {}", context.adapter.name);
            assert_eq!(film.ledger.dropped, 0, "{what}");
            let expected = 0.5 * 10.0 * factor;
            let error = film.standard_error_of_mean().unwrap()[0];
            let test = z_test(film.mean()[0], expected, error * error, 2e-5 * expected);
            assert!(test.z.abs() <= 4.5, "{what}: {} standard errors", test.z);
            statistics::accept(test.p_value, &what);
            lit += usize::from(expected > 0.0);
            if error < 2e-3 * expected {
                let scaled = z_test(film.mean()[0], 1.02 * expected, error * error, 0.0);
                statistics::reject(scaled.p_value, &format!("{what}, 2 % brighter"));
                sharp += 1;
            }
        }
    }
    assert!(lit >= 18, "half of the polygons light the floor: {lit}");
    assert!(sharp >= 9, "2 % would be seen in half of those: {sharp}");
}
