//! Degenerate cameras: HARD CASE I3.

use crate::support::hard_cases::{Measured, survive};
use crate::support::random::Random;
use crate::support::statistics::accept;
use crate::support::{context, floor_pixel, point_light, prepared, render};
use direkt::low_level::effects::Effect;
use direkt::low_level::stats::z_test::z_test;
use direkt::scene::{Camera, FilmSize, Projection, Scene};
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
        context(),
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

/// From a thousandth of a degree to 179°: every pixel has a finite value, and the middle one sees
/// the target.
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
        let film = render(context(), scene);
        assert_eq!(film.ledger.dropped, 0, "{degrees}°");
        assert!(film.pixels.iter().all(|p| p.mean[0].is_finite()));
        assert!(film.pixels[40].mean[0] > 0.0, "{degrees}°");
    }
}

/// From 10⁵ and 10⁷ sizes of the scene away, through a narrow view, a floor under a point light is
/// the orthographic image.
///
/// Rays begin a 65,536th of the distance before the floor, where f32 has them off by 2⁻²⁴ of that:
/// at 10⁷ by 10⁻⁵ of the light's height, and the light's falloff changes by less than ten times as
/// much.
#[test]
fn distant_cameras_see_what_parallel_rays_see() {
    let context = context();
    let mut scene = floor_pixel();
    scene.lights = vec![point_light(DVec3::new(0.3, 0.2, 1.0), 4.0)];
    scene.film = FilmSize {
        width: 8,
        height: 8,
    };
    scene.render.stop.spp = 1 << 10;
    let from = |distance: f64, scene: &Scene| {
        let mut scene = scene.clone();
        let eye = DVec3::new(0.0, 0.0, distance);
        let fov = 2.0 * (1.0 / distance).atan();
        scene.camera = Camera::look_at(eye, DVec3::ZERO, DVec3::Y, fov).unwrap();
        scene
    };
    let mut parallel = from(4.0, &scene);
    parallel.camera.projection = Projection::Orthographic { height: 2.0 };
    let parallel = render(context, parallel);
    for distance in [1e5_f64, 1e7] {
        let distant = from(distance, &scene);
        let effects = prepared(distant.clone()).effects;
        assert!(effects.contains(Effect::DistantCamera), "{distance:e}");
        let film = render(context, distant);
        for (i, (far, near)) in film.pixels.iter().zip(&parallel.pixels).enumerate() {
            let variance = far.variance_of_mean().unwrap()[0] + near.variance_of_mean().unwrap()[0];
            let test = z_test(far.mean[0], near.mean[0], variance, 1e-4 * near.mean[0]);
            accept(test.p_value, &format!("{distance:e}, pixel {i}"));
        }
    }
}
