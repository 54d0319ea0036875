//! Images beside radiance against the twin, pixel by pixel, and in world units.

use crate::support::{context, floor_pixel, prepared, scene};
use direkt::low_level::gpu::features::{Features, features, surfaces};
use direkt::low_level::gpu::layout::SurfaceRecord;
use direkt::low_level::prepare::Prepared;
use direkt::low_level::reference::kernel::gbuffer::{MIDDLE, SurfaceSeen, surface_at_film};
use direkt::low_level::reference::scene::opacity::Crossings;
use direkt::low_level::reference::{Direct, Sample, Twin};
use direkt::low_level::render::aov::surface_point;
use direkt::low_level::render::{AovImages, render_aovs};
use direkt::scene::{Aov, Camera, FilmSize, Projection, Scene};
use glam::{DVec2, DVec3};

const FILM: FilmSize = FilmSize {
    width: 40,
    height: 32,
};
const SEED: u32 = 11;
/// One batch of a dispatch, and three more.
const SAMPLES: u64 = 11;

/// What a mean of f32 sums loses, textures' coordinates included.
const ROUNDING: f64 = 3e-4;
/// How far rounding turns a camera ray, in radians: some f32 roundings of its direction and of
/// where it starts.
const TURN: f64 = 2e-6;

/// Textures and a normal map; mirror and glass; a lens; parallel rays; opacities.
const SCENES: [&str; 5] = ["textures", "glass", "depth_of_field", "isometric", "leaves"];

fn small(name: &str) -> Prepared {
    let mut scene = scene(&format!("scenes/{name}.toml"));
    scene.film = FILM;
    prepared(scene)
}

fn turns() -> [DVec2; 4] {
    [DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y].map(|turn| TURN * turn)
}

/// Albedo and normal of a sample as one list.
fn numbers(sample: &Sample) -> [f64; 6] {
    let f = sample.features;
    let [a, n] = [f.albedo, f.normal];
    [a.x, a.y, a.z, n.x, n.y, n.z]
}

/// Mean of the twin's features of a pixel, and how far rounding of its camera rays may move it.
fn twin_features(direct: &Direct<'_>, pixel: (u32, u32), first: u64) -> ([f64; 6], [f64; 6]) {
    let (mut mean, mut slack) = ([0.0; 6], [ROUNDING; 6]);
    for index in first..first + SAMPLES {
        let right = numbers(&direct.sample_radiance(pixel.0, pixel.1, index));
        let turned = turns().map(|turn| numbers(&direct.turned_sample(pixel, index, turn)));
        for i in 0..6 {
            let farthest = turned.iter().map(|t| (t[i] - right[i]).abs());
            mean[i] += right[i] / SAMPLES as f64;
            slack[i] += farthest.fold(0.0, f64::max) / SAMPLES as f64;
        }
    }
    (mean, slack)
}

/// Pixels whose features are not the twin's, with a mistake made in these.
fn wrong_features(
    twin: &Twin<'_>,
    found: &[Features],
    first: u64,
    mistake: fn([f64; 6]) -> [f64; 6],
) -> usize {
    let wrong = found.iter().enumerate().filter(|(pixel, found)| {
        let pixel = *pixel as u32;
        let place = (pixel % FILM.width, pixel / FILM.width);
        let (mean, slack) = twin_features(twin.direct(), place, first);
        let ([r, g, b], [x, y, z]) = (found.albedo, found.normal);
        let pairs = [r, g, b, x, y, z].into_iter().zip(mistake(mean));
        let mut pairs = pairs.zip(slack);
        pairs.any(|((found, twin), slack)| (found - twin).abs() > slack)
    });
    wrong.count()
}

#[test]
fn features_are_the_twins() {
    let context = context();
    for name in SCENES {
        let prepared = small(name);
        let found = features(context, &prepared, (FILM, SEED), SAMPLES).unwrap();
        let twin = Twin::new(&prepared, FILM, SEED, None);
        let wrong = |first, mistake| wrong_features(&twin, &found, first, mistake);
        assert_eq!(wrong(0, |f| f), 0, "{name}");
        let albedo_too_large = |f: [f64; 6]| [1.02 * f[0], f[1], f[2], f[3], f[4], f[5]];
        assert!(wrong(0, albedo_too_large) > 100, "{name}: albedo");
        let axes_swapped = |f: [f64; 6]| [f[0], f[1], f[2], f[4], f[3], f[5]];
        assert!(wrong(0, axes_swapped) > 100, "{name}: normal");
        assert!(wrong(1, |f| f) > 5, "{name}: other samples");
    }
}

/// How far a film point may be rounded, in pixels.
const FILM_ROUNDING: f64 = 1e-3;

/// Whether the record is what the twin sees in the middle of the pixel, or, where that is another
/// primitive, all but there.
fn is_seen(direct: &Direct<'_>, pixel: DVec2, record: &SurfaceRecord) -> bool {
    let world = direct.world();
    let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    let crossings = Crossings::of_sample(direct.id(pixel.x as u32, pixel.y as u32, 0));
    let at = |beside: DVec2| surface_at_film(world, FILM, pixel + MIDDLE + beside, crossings);
    let same = |seen: Option<SurfaceSeen>| match seen {
        None => record.primitive == u32::MAX,
        Some(seen) => {
            let nearby = turns().map(|turn| at(turn / TURN * FILM_ROUNDING));
            let moved = nearby
                .iter()
                .flatten()
                .map(|s| s.position.distance(seen.position));
            let slack = 1e-6 + moved.fold(0.0, f64::max);
            let normals = nearby
                .iter()
                .flatten()
                .map(|s| s.normal.distance(seen.normal));
            seen.primitive == record.primitive
                && vector(record.position).distance(seen.position) <= slack
                && vector(record.normal).distance(seen.normal) <= 1e-5 + normals.fold(0.0, f64::max)
        }
    };
    let beside = [DVec2::ZERO].into_iter();
    let mut places = beside.chain(turns().map(|turn| turn / TURN * FILM_ROUNDING));
    places.any(|beside| same(at(beside)))
}

fn wrong_surfaces(prepared: &Prepared, records: &[SurfaceRecord], aside: DVec2) -> usize {
    let twin = Twin::new(prepared, FILM, SEED, None);
    let pixels = records.iter().enumerate();
    let wrong = pixels.filter(|(pixel, record)| {
        let pixel = *pixel as u32;
        let place = DVec2::new(f64::from(pixel % FILM.width), f64::from(pixel / FILM.width));
        !is_seen(twin.direct(), place + aside, record)
    });
    wrong.count()
}

#[test]
fn surfaces_are_the_twins() {
    let context = context();
    for name in SCENES {
        let prepared = small(name);
        let mut found = surfaces(context, &prepared, (FILM, SEED)).unwrap();
        assert_eq!(wrong_surfaces(&prepared, &found, DVec2::ZERO), 0, "{name}");
        let aside = wrong_surfaces(&prepared, &found, DVec2::new(0.05, 0.0));
        assert!(aside > 100, "{name}: a twentieth of a pixel aside: {aside}");
        for record in &mut found {
            record.normal = record.normal.map(|x| -x);
        }
        let turned = wrong_surfaces(&prepared, &found, DVec2::ZERO);
        assert!(turned > 100, "{name}: normals turned round: {turned}");
    }
}

fn with_all(mut scene: Scene) -> Scene {
    scene.render.aovs = [Aov::All].into_iter().collect();
    scene
}

fn images(scene: Scene) -> (Prepared, AovImages) {
    let (film, seed) = (scene.film, scene.render.seed);
    let prepared = prepared(with_all(scene));
    let images = render_aovs(context(), &prepared, (film, seed), 4).unwrap();
    (prepared, images)
}

/// The floor that a pixel sees is at the origin, √14 before the eye, in the file's unit and
/// wherever the scene lies.
#[test]
fn positions_and_depths_are_those_of_the_file() {
    for (offset, scale) in [
        (DVec3::ZERO, 1.0),
        (DVec3::new(3e6, -2e5, 1e4), 0.01),
        (DVec3::X, 1e4),
    ] {
        let mut scene = floor_pixel();
        let place = |p: DVec3| p * scale + offset;
        let eye = DVec3::new(1.0, -3.0, 2.0);
        scene.camera = Camera::look_at(place(eye), place(DVec3::ZERO), DVec3::Z, 1e-5).unwrap();
        if let direkt::scene::Geometry::Rectangle { corner, u, v } = &mut scene.shapes[0].geometry {
            (*corner, *u, *v) = (place(*corner), *u * scale, *v * scale);
        }
        let (_, images) = images(scene);
        let point = images.surfaces.unwrap()[0].expect("the floor is seen");
        let wrong = (point.position - offset).length() / scale;
        assert!(wrong < 1e-5, "{offset}, {scale}: {wrong}");
        let depth = point.depth / scale;
        assert!(
            (depth - 14_f64.sqrt()).abs() < 1e-5,
            "{offset}, {scale}: {depth}"
        );
        assert!(point.normal.distance(DVec3::Z) < 1e-6);
        assert_eq!((point.shape.0, point.material.0), (0, 0));
        let features = images.features.unwrap()[0];
        assert!((features.albedo[1] - 0.5).abs() < 1e-6 && features.normal[2] > 0.999_999);
    }
}

/// Of parallel rays to a plane that faces them every pixel has the same depth, and the depth of a
/// perspective image of it is the same all over as well: it is measured along the viewing
/// direction.
#[test]
fn depth_is_measured_along_the_viewing_direction() {
    let wide = Projection::Perspective { fov_y: 1.2 };
    for projection in [wide, Projection::Orthographic { height: 4.0 }] {
        let mut scene = floor_pixel();
        scene.film = FILM;
        scene.camera = Camera {
            projection,
            ..Camera::look_at(
                DVec3::new(0.5, 0.25, 3.0),
                DVec3::new(0.5, 0.25, 0.0),
                DVec3::Y,
                1.0,
            )
            .unwrap()
        };
        let (_, images) = images(scene);
        for point in images.surfaces.unwrap() {
            let depth = point.expect("the floor is everywhere").depth;
            assert!((depth - 3.0).abs() < 1e-5, "{projection:?}: {depth}");
        }
    }
}

/// A mirror shows denoisers what is seen in it, and compositors itself.
#[test]
fn features_go_on_in_mirrors_and_surfaces_do_not() {
    let mirror = scene("scenes/tests/mirror_shows_direct_lighting.toml");
    let (prepared, images) = images(mirror);
    let first = images.surfaces.unwrap()[0].expect("the mirror is seen");
    let material = &prepared.data.scene.materials[first.material.index()];
    assert!(material.bsdf.parameters().is_specular(), "{material:?}");
    let normal = DVec3::from_array(images.features.unwrap()[0].normal);
    assert!(
        normal.distance(first.normal) > 0.1,
        "the normal of what is seen in the mirror: {normal}"
    );
}

/// Nothing is rendered that is not asked for.
#[test]
fn what_nobody_asks_for_is_not_rendered() {
    let prepared = prepared(floor_pixel());
    let context = context();
    let none = render_aovs(context, &prepared, (prepared.film, 0), 4).unwrap();
    assert_eq!(none, AovImages::default());
    let beyond = SurfaceRecord {
        primitive: u32::MAX,
        ..SurfaceRecord::default()
    };
    assert_eq!(surface_point(&prepared, &beyond), None);
}
