//! What a lens calls for, and what is seen through it.

use crate::support::{context, emitter, floor_pixel, prepared, render, statistics};
use direkt::low_level::effects::Effect;
use direkt::low_level::stats::z_test::z_test;
use direkt::scene::filter::FilterKind;
use direkt::scene::{Camera, Geometry, Lens, PixelFilter, Projection, Scene};
use glam::DVec3;

/// One narrow pixel along −z through a lens of radius `radius` that is focused at 2, before a disk
/// light of radius ½ at distance 5 whose middle lies `aside`.
fn disk_behind_focus(radius: f64, aside: f64, projection: Projection) -> Scene {
    let mut scene = floor_pixel();
    scene.camera = Camera {
        projection,
        lens: Lens {
            radius,
            focus_distance: 2.0,
        },
        ..Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 1.0).unwrap()
    };
    let disk = Geometry::Disk {
        center: DVec3::new(aside, 0.0, -5.0),
        u: DVec3::new(0.5, 0.0, 0.0),
        v: DVec3::new(0.0, 0.5, 0.0),
    };
    scene.shapes = vec![emitter(disk, 1.0, false)];
    scene.render.stop.spp = 1 << 16;
    scene
}

/// Area of the intersection of circles of radii `a` and `b` at distance `d`, where they do
/// intersect.
fn lens_shape(a: f64, b: f64, d: f64) -> f64 {
    let segment = |r: f64, s: f64| ((d * d + r * r - s * s) / (2.0 * d * r)).acos();
    let (alpha, beta) = (segment(a, b), segment(b, a));
    a * a * (alpha - alpha.sin() * alpha.cos()) + b * b * (beta - beta.sin() * beta.cos())
}

/// A ray from o on the lens reaches the disk's plane at o(1 − 5/2): the lens's image there is a
/// disk of 1.5 times its radius, of which the light covers what both have in common.
#[test]
fn the_circle_of_confusion_is_as_wide_as_it_should_be() {
    let context = context();
    let narrow = [
        Projection::Perspective { fov_y: 1e-6 },
        Projection::Orthographic { height: 1e-6 },
    ];
    for projection in narrow {
        for (radius, aside) in [(0.4, 0.3), (0.4, 0.25), (0.6, 0.5)] {
            let film = render(context, disk_behind_focus(radius, aside, projection));
            let spread = 1.5 * radius;
            let area = |spread: f64| std::f64::consts::PI * spread * spread;
            let expected = |spread: f64| lens_shape(spread, 0.5, aside) / area(spread);
            let test = |expected: f64| {
                let variance = expected * (1.0 - expected) / film.pixels[0].samples as f64;
                z_test(film.pixels[0].mean[0], expected, variance, 1e-5).p_value
            };
            let name = &context.adapter.name;
            let what = format!("{projection:?}, lens {radius}, light aside {aside}, {name}");
            statistics::accept(test(expected(spread)), &what);
            let broken = format!("{what}, a lens that is 10 % wider");
            statistics::reject(test(expected(1.1 * spread)), &broken);
        }
    }
}

#[test]
fn only_what_makes_a_difference_is_called_for() {
    let effects = |change: &dyn Fn(&mut Scene)| {
        let mut scene = floor_pixel();
        change(&mut scene);
        let prepared = prepared(scene);
        let camera = [
            Effect::DepthOfField,
            Effect::Orthographic,
            Effect::PixelFilter,
        ];
        let reason = |wanted: &Effect| {
            let mut found = prepared.effects.iter().filter(|(e, _)| e == wanted);
            found.next().map(|(_, reason)| reason.to_owned())
        };
        camera.iter().filter_map(reason).collect::<Vec<String>>()
    };
    assert_eq!(effects(&|_| ()), [""; 0]);
    assert_eq!(effects(&|s| s.camera.lens.focus_distance = 3.0), [""; 0]);
    assert_eq!(
        effects(&|s| s.camera.lens.radius = 0.02),
        ["camera.lens_radius = 0.02"]
    );
    let projection = Projection::Orthographic { height: 2.0 };
    assert_eq!(
        effects(&|s| s.camera.projection = projection),
        ["camera.type = \"orthographic\""]
    );
    assert_eq!(
        effects(&|s| s.filter = PixelFilter::of_kind(FilterKind::BlackmanHarris)),
        ["film.filter = \"blackman-harris\" of radius 2"]
    );
    assert_eq!(
        effects(&|s| s.filter.radius = 0.75),
        ["film.filter = \"box\" of radius 0.75"]
    );
}
