//! Degenerate cameras: HARD CASE I3.

use crate::support::hard_cases::{Measured, survive};
use crate::support::random::Random;
use crate::support::{context, floor_pixel, point_light, render};
use direkt::scene::{Camera, FilmSize};
use glam::{DMat3, DVec3};

/// How far columns are from orthonormal: the largest element of MᵀM − 1.
fn deviation(columns: [DVec3; 3]) -> f64 {
    let m = DMat3::from_cols_array_2d(&columns.map(|c| c.to_array()));
    let off = (m.transpose() * m - DMat3::IDENTITY).to_cols_array();
    off.map(f64::abs).into_iter().fold(0.0, worst)
}

/// The larger; NaN where either is.
fn worst(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() {
        f64::NAN
    } else {
        a.max(b)
    }
}

#[test]
fn any_view_has_a_frame() {
    let mut random = Random::new(92);
    let mut directions = vec![DVec3::X, DVec3::Y, DVec3::Z, -DVec3::Z];
    directions.extend((0..1000).map(|_| random.direction()));
    let ups = [0.0, 1e-300, 1e-17, 1e-12, 1e-6].map(|t| DVec3::new(t, -t, t));
    let views: Vec<(DVec3, DVec3)> = directions
        .into_iter()
        .flat_map(|forward| ups.map(|tilt| (forward, 3.0 * forward + tilt)))
        .collect();
    let ours = |&(forward, up): &(DVec3, DVec3)| {
        let camera = Camera::look_at(DVec3::ONE, DVec3::ONE + forward, up, 1.0).unwrap();
        deviation([camera.right, camera.up, camera.forward])
    };
    let naive = |&(forward, up): &(DVec3, DVec3)| {
        let right = forward.cross(up).normalize();
        deviation([right, right.cross(forward), forward])
    };
    survive(
        &context(),
        Measured {
            entry: "I3",
            case: "views along `up`, and as good as along it",
            figure: "deviation from orthonormal",
            bound: 1e-6,
            textbook: "forward × up, normalised",
            naive: views.iter().map(naive).fold(0.0, worst),
            ours: views.iter().map(ours).fold(0.0, worst),
        },
    );
}

/// From a thousandth of a degree to 179°: every pixel has a finite value, and the middle one sees the target.
#[test]
fn narrow_and_wide_views_are_finite() {
    for degrees in [1e-3_f64, 179.0] {
        let mut scene = floor_pixel();
        scene
            .lights
            .push(point_light(DVec3::new(0.0, 0.0, 2.0), 100.0));
        let eye = DVec3::new(0.0, 0.0, 1.0);
        scene.camera = Camera::look_at(eye, DVec3::ZERO, DVec3::Z, degrees.to_radians()).unwrap();
        scene.film = FilmSize {
            width: 9,
            height: 9,
        };
        let film = render(&context(), scene);
        assert_eq!(film.ledger.dropped, 0, "{degrees}°");
        assert!(film.pixels.iter().all(|p| p.mean[0].is_finite()));
        assert!(film.pixels[40].mean[0] > 0.0, "{degrees}°");
    }
}
