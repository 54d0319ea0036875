//! Small lights that the camera sees: what is sampled of them is what chance finds.

use crate::support::{
    context, emitter, lambert, prepared, render, render_prepared, shape, statistics,
};
use direkt::low_level::effects::Effect;
use direkt::low_level::render::{Film, Pixel};
use direkt::low_level::stats::z_test::z_test;
use direkt::scene::filter::FilterKind;
use direkt::scene::{
    Camera, FilmSize, Geometry, Lens, Light, Mesh, PixelFilter, Projection, Sampler, Scene, Shape,
    SunLight,
};
use glam::{DMat3, DQuat, DVec3};
use std::f64::consts::PI;

const SIDE: u32 = 8;
/// Half the image's height at distance 1.
const HALF_HEIGHT: f64 = 0.25;
/// Pixels per unit at distance 1.
const SCALE: f64 = SIDE as f64 / 2.0 / HALF_HEIGHT;

/// A camera at the origin that looks along −z at `shapes`.
fn seen(lens: Lens, shapes: Vec<Shape>) -> Scene {
    let mut scene = crate::support::floor_pixel();
    scene.camera = Camera {
        lens,
        projection: Projection::Perspective {
            fov_y: 2.0 * HALF_HEIGHT.atan(),
        },
        ..Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 1.0).unwrap()
    };
    scene.film = FilmSize {
        width: SIDE,
        height: SIDE,
    };
    scene.shapes = shapes;
    scene.render.stop.spp = 64;
    scene
}

fn lens(radius: f64, focus_distance: f64) -> Lens {
    Lens {
        radius,
        focus_distance,
    }
}

/// The point at `depth` that the film shows at (x, y), in pixels from its middle to the right and
/// up.
fn at(x: f64, y: f64, depth: f64) -> DVec3 {
    depth * DVec3::new(x / SCALE, y / SCALE, -1.0)
}

/// A disk across the view, turned to the camera, that covers `pixels`.
fn disk(x: f64, y: f64, depth: f64, pixels: f64) -> Geometry {
    let radius = depth * (pixels / PI).sqrt() / SCALE;
    Geometry::Disk {
        center: at(x, y, depth),
        u: radius * DVec3::X,
        v: radius * DVec3::Y,
    }
}

fn sum(film: &Film) -> f64 {
    film.pixels.iter().map(|p| p.mean[0]).sum()
}

/// A disk across the view adds to the sum of all pixels its radiance times the pixels that it
/// covers, however small it is and wherever it is sharp. In focus before a pinhole each sample says
/// so exactly.
#[test]
fn a_disk_adds_what_it_covers() {
    let context = context();
    let pixels = 1e-7;
    for lens in [
        Lens::PINHOLE,
        lens(0.05, 2.0),
        lens(0.05, 1.0),
        lens(0.05, 5.0),
        lens(0.01, 2.2),
    ] {
        let light = emitter(disk(0.3, 0.4, 2.0, pixels), 1e7, false);
        let wall = shape("wall", disk(0.0, 0.0, 8.0, 30.0));
        let mut scene = seen(lens, vec![light, wall]);
        // The light shines away from the wall, which is black.
        scene.render.stop.spp = 1 << 14;
        let film = render(context, scene);
        let variance: f64 = film.variances().unwrap().iter().map(|v| v[0]).sum();
        let what = format!("a disk before {lens:?}, {}", context.adapter.name);
        let test = |expected: f64| z_test(sum(&film), expected, variance, 1e-4).p_value;
        statistics::accept(test(1.0), &what);
        statistics::reject(test(1.02), &format!("{what}, 2 % too dark"));
        assert!(variance < 1e-3, "{what}: {variance}");
    }
}

/// One light of every kind, each in a part of the image of its own, and what hides some of one.
fn every_kind(lens: Lens) -> Scene {
    let edge = 2.0 * 0.3 / SCALE;
    let turned = DMat3::from_quat(DQuat::from_rotation_y(0.6) * DQuat::from_rotation_x(0.4));
    let (u, v) = (edge * turned.x_axis, edge * turned.y_axis);
    let triangle = |x: f64, y: f64, depth: f64| {
        let a = at(x, y, depth);
        let triangle = Mesh {
            positions: vec![a, a + u, a + v],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        };
        Geometry::Mesh(triangle)
    };
    let rectangle = Geometry::Rectangle {
        corner: at(-2.8, 2.6, 2.0),
        u,
        v,
    };
    let ellipse = Geometry::Disk {
        center: at(2.5, 2.5, 1.6),
        u: 0.6 * u,
        v: 0.4 * v + 0.2 * u,
    };
    let sphere = Geometry::Sphere {
        center: at(-2.4, -2.5, 3.0),
        radius: 0.06,
    };
    let ellipsoid = Geometry::Ellipsoid {
        center: at(2.5, -2.4, 2.5),
        axes: turned * DMat3::from_diagonal(DVec3::new(0.03, 0.06, 0.02)),
    };
    let hidden = Geometry::Sphere {
        center: at(0.2, 3.0, 3.0),
        radius: 0.05,
    };
    let blind = Geometry::Rectangle {
        corner: at(0.2, 2.5, 1.5),
        u: DVec3::new(0.2, 0.0, 0.0),
        v: DVec3::new(0.0, 0.2, 0.0),
    };
    let mut scene = seen(
        lens,
        vec![
            emitter(rectangle, 3.0, true),
            emitter(ellipse, 5.0, true),
            emitter(sphere, 2.0, false),
            emitter(ellipsoid, 4.0, false),
            emitter(triangle(-3.0, 0.2, 2.2), 6.0, true),
            emitter(hidden, 7.0, false),
            shape("blind", blind),
        ],
    );
    scene.materials[0] = lambert(0.5);
    let to_sun = at(0.1, -0.3, 1.0).normalize();
    scene.lights = vec![Light::Sun(SunLight {
        direction: -to_sun,
        irradiance: DVec3::splat(1e-3),
        angular_radius: 0.01,
    })];
    scene
}

/// The smallest p-value of both films having the same mean: in each pixel where chance has found
/// light often enough that the mean is nearly normal, and as a whole (Šidák).
fn least_p_value(film: &Film, by_chance: &Film, factor: f64) -> f64 {
    let moments = |p: &Pixel| {
        let variance = p.variance_of_mean().expect("many samples")[0];
        (p.mean[0], variance)
    };
    let mut p_values = Vec::new();
    let mut whole = [0.0; 3];
    for (a, b) in film.pixels.iter().zip(&by_chance.pixels) {
        let ((a, variance_a), (b, variance_b)) = (moments(a), moments(b));
        let variance = factor * factor * variance_a + variance_b;
        for (sum, x) in whole.iter_mut().zip([factor * a, b, variance]) {
            *sum += x;
        }
        if variance_b.sqrt() < 0.1 * b {
            p_values.push(z_test(factor * a, b, variance, 1e-4 * b).p_value);
        }
    }
    let [a, b, variance] = whole;
    p_values.push(z_test(a, b, variance, 1e-4 * b).p_value);
    let least = p_values.iter().copied().fold(1.0, f64::min);
    -(p_values.len() as f64 * (-least).ln_1p()).exp_m1()
}

#[test]
fn what_is_sampled_is_what_chance_finds() {
    let context = context();
    for (lens, filter) in [
        (Lens::PINHOLE, FilterKind::Box),
        (lens(0.08, 1.2), FilterKind::Gaussian),
        (lens(0.08, 2.3), FilterKind::Box),
    ] {
        let mut scene = every_kind(lens);
        scene.filter = PixelFilter::of_kind(filter);
        scene.render.stop.spp = 1 << 14;
        let sampled = prepared(scene);
        let what = format!("{lens:?}, {filter}, {}", context.adapter.name);
        assert_eq!(sampled.lights_in_view.len(), 7, "{what}");
        assert!(sampled.effects.contains(Effect::LightsInView));
        let by_chance = sampled.clone().with_lights_in_view_by_chance();
        assert!(!by_chance.effects.contains(Effect::LightsInView));
        let (film, other) = (
            render_prepared(context, &sampled),
            render_prepared(context, &by_chance),
        );
        statistics::accept(least_p_value(&film, &other, 1.0), &what);
        statistics::reject(
            least_p_value(&film, &other, 1.1),
            &format!("{what}, 10 % too bright"),
        );
        let variance = |film: &Film| -> f64 {
            let variances = film.variances().unwrap();
            variances.iter().map(|v| v[0]).sum()
        };
        assert!(
            variance(&film) < 0.5 * variance(&other),
            "{what}: {} by chance {}",
            variance(&film),
            variance(&other)
        );
    }
}

/// A sample has more points of lights that fewer pixels show, up to 64. What covers all of the image, or
/// is not in it, is not called for.
#[test]
fn few_pixels_have_many_points() {
    let per_sample = |geometry: Geometry| {
        let scene = seen(Lens::PINHOLE, vec![emitter(geometry, 1.0, false)]);
        let lights = prepared(scene).lights_in_view;
        lights
            .into_iter()
            .map(|light| light.per_sample)
            .collect::<Vec<_>>()
    };
    // Two rays of each of 64 pixels: 128, and (2√(0.3/π) + 1)² = 2.6 pixels may show it.
    assert_eq!(per_sample(disk(0.0, 0.0, 2.0, 0.3)), [32]);
    // Its edges cross 4(2√(8/π) + 1) = 17 at most.
    assert_eq!(per_sample(disk(0.0, 0.0, 2.0, 8.0)), [4]);
    assert!(per_sample(disk(0.0, 0.0, 2.0, 500.0)).is_empty());
    let lights = |geometry: Geometry| per_sample(geometry).len();
    assert_eq!(lights(disk(9.0, 0.0, 2.0, 0.3)), 0, "beside the image");
    assert_eq!(lights(disk(0.0, 0.0, -2.0, 0.3)), 0, "behind the camera");
    let orthographic = |projection: Projection| {
        let mut scene = seen(
            Lens::PINHOLE,
            vec![emitter(disk(0.0, 0.0, 2.0, 0.3), 1.0, false)],
        );
        scene.camera.projection = projection;
        prepared(scene).lights_in_view.len()
    };
    assert_eq!(orthographic(Projection::Orthographic { height: 1.0 }), 0);
}

/// Each sampler's replicates are as far apart as the image is off: what is sampled is stratified,
/// and that does not make them depend on each other.
#[test]
fn samplers_agree_on_what_they_sample() {
    let context = context();
    let film = |sampler: Sampler| {
        let mut scene = every_kind(lens(0.08, 1.2));
        scene.render.estimator.sampler = sampler;
        scene.render.stop.spp = 1 << 10;
        render(context, scene)
    };
    let independent = film(Sampler::Independent);
    for sampler in [Sampler::Sobol, Sampler::Stratified, Sampler::BlueNoise] {
        let film = film(sampler);
        let what = format!("{sampler}, {}", context.adapter.name);
        // The scatter of stratified samples is at least their variance.
        statistics::accept(least_p_value(&film, &independent, 1.0), &what);
        statistics::reject(least_p_value(&film, &independent, 1.2), &what);
    }
}
