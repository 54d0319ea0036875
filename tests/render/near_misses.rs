//! What near misses of small lights tell, beside how often samples meet these.

use crate::support::{context, emitter, floor_pixel, prepared, render_prepared, shape};
use direkt::low_level::effects::Effect;
use direkt::low_level::render::Film;
use direkt::scene::{
    Bsdf, Camera, FilmSize, Geometry, Light, Material, PointLight, Projection, Scene, Shape,
};
use glam::DVec3;

const RADIANCE: f64 = 50.0;

/// A camera at the origin that looks along −z at a mirror, or what else `bsdf` is, in which it sees
/// what is behind it.
fn seen_in(bsdf: Bsdf, mirror: Geometry, behind: Vec<Shape>) -> Scene {
    let mut scene = floor_pixel();
    scene.camera = Camera {
        projection: Projection::Perspective {
            fov_y: 2.0 * 0.25_f64.atan(),
        },
        ..Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 1.0).unwrap()
    };
    scene.film = FilmSize {
        width: 24,
        height: 24,
    };
    scene.materials = vec![Material::new("mirror", bsdf)];
    scene.shapes = vec![shape("mirror", mirror)];
    scene.shapes.extend(behind);
    scene.render.stop.spp = 1 << 14;
    scene
}

fn flat() -> Geometry {
    Geometry::Rectangle {
        corner: DVec3::new(-3.0, -3.0, -3.0),
        u: 6.0 * DVec3::X,
        v: 6.0 * DVec3::Y,
    }
}

fn ball() -> Geometry {
    Geometry::Sphere {
        center: DVec3::new(0.0, 0.0, -3.0),
        radius: 0.5,
    }
}

fn mirror() -> Bsdf {
    Bsdf::Mirror {
        reflectance: DVec3::splat(0.8),
    }
}

/// A lamp behind the camera, whose front faces the mirror.
fn lamp(radius: f64) -> Shape {
    let disk = Geometry::Disk {
        center: DVec3::new(0.4, 0.3, 1.0),
        u: radius * DVec3::Y,
        v: radius * DVec3::X,
    };
    emitter(disk, RADIANCE, false)
}

/// Squares of radiance and hits, as near misses tell them, over all pixels.
fn told(film: &Film) -> [f64; 2] {
    let sum = |of: fn(&direkt::low_level::render::Pixel) -> f64| film.pixels.iter().map(of).sum();
    [sum(|p| p.expected_squares), sum(|p| p.expected_hits)]
}

/// The sum of the squares of all samples' radiance.
fn squares(film: &Film) -> f64 {
    let of_pixel = |p: &direkt::low_level::render::Pixel| {
        let n = p.samples as f64;
        (0..3)
            .map(|c| p.m2[c] + n * p.mean[c] * p.mean[c])
            .sum::<f64>()
    };
    film.pixels.iter().map(of_pixel).sum()
}

/// In a mirror, flat or not, near misses tell how often samples meet a lamp, and the squares of what
/// they find, as exactly as lamps and mirrors are alike all over the cone of near misses.
#[test]
fn near_misses_tell_how_often_mirrors_show_a_lamp() {
    let context = context();
    for (name, geometry, radius) in [("flat", flat(), 0.01), ("ball", ball(), 0.1)] {
        let prepared = prepared(seen_in(mirror(), geometry, vec![lamp(radius)]));
        assert!(prepared.effects.contains(Effect::NearMisses), "{name}");
        let film = render_prepared(context, &prepared);
        let [expected, hits] = told(&film);
        let found = squares(&film);
        let met = found / (3.0 * (0.8 * RADIANCE).powi(2));
        assert!(met > 200.0, "{name}: {met} hits are too few to tell");
        assert!(
            (expected / found - 1.0).abs() < 0.25,
            "{name}: {expected} for {found}"
        );
        assert!((hits / met - 1.0).abs() < 0.25, "{name}: {hits} for {met}");
    }
}

/// What hides the lamp hides it from near misses.
#[test]
fn a_hidden_lamp_is_not_nearly_met() {
    let shade = Geometry::Rectangle {
        corner: DVec3::new(0.2, 0.1, 0.9),
        u: 0.4 * DVec3::X,
        v: 0.4 * DVec3::Y,
    };
    let mut blind = shape("shade", shade);
    blind.material = direkt::scene::MaterialId(1);
    let mut scene = seen_in(mirror(), flat(), vec![lamp(0.01), blind]);
    scene.materials.push(crate::support::lambert(0.5));
    scene.render.stop.spp = 256;
    let film = render_prepared(context(), &prepared(scene));
    assert_eq!(told(&film), [0.0; 2]);
}

/// A point light over a narrow lobe: what near misses tell is within a factor of two of what light
/// sampling finds, whose lobe is not the even one that they take it for.
#[test]
fn near_misses_tell_of_highlights() {
    let light = Light::Point(PointLight {
        position: DVec3::new(0.4, 0.3, 1.0),
        intensity: DVec3::splat(2.0),
    });
    let bsdf = Bsdf::Conductor {
        reflectance: DVec3::splat(0.8),
        alpha: 0.01,
    };
    let mut scene = seen_in(bsdf, ball(), Vec::new());
    scene.lights.push(light);
    let film = render_prepared(context(), &prepared(scene));
    let [expected, _] = told(&film);
    let ratio = expected / squares(&film);
    assert!((0.5..2.0).contains(&ratio), "{ratio}");
}

/// Only narrow lobes and what camera rays meet by chance call for it.
#[test]
fn only_what_shows_light_by_chance_is_watched() {
    let watched = |bsdf: Bsdf, radius: f64| {
        let prepared = prepared(seen_in(bsdf, flat(), vec![lamp(radius)]));
        prepared.effects.contains(Effect::NearMisses)
    };
    let rough = Bsdf::Conductor {
        reflectance: DVec3::splat(0.8),
        alpha: 0.3,
    };
    assert!(watched(mirror(), 0.01));
    assert!(!watched(rough, 0.01));
    assert!(!watched(mirror(), 2.0), "it is found often enough");
}

/// Camera rays beside a lamp that no pixel shows are no near misses, though a mirror elsewhere makes it
/// one to watch.
#[test]
fn a_lamp_beside_the_image_is_not_nearly_met() {
    let behind_the_camera = Geometry::Sphere {
        center: DVec3::new(0.0, 0.0, 5.0),
        radius: 0.5,
    };
    let disk = Geometry::Disk {
        center: DVec3::new(0.8, 0.0, -3.0),
        u: 0.01 * DVec3::X,
        v: 0.01 * DVec3::Y,
    };
    let mut scene = seen_in(
        mirror(),
        behind_the_camera,
        vec![emitter(disk, RADIANCE, false)],
    );
    scene.render.stop.spp = 256;
    let prepared = prepared(scene);
    assert!(prepared.effects.contains(Effect::NearMisses));
    assert_eq!(told(&render_prepared(context(), &prepared)), [0.0; 2]);
}
