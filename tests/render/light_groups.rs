//! The light of groups of lights: together the image, each that of its lights alone, and absent
//! where nobody asks.

use crate::support::{context, point_light, prepared, prepared_for, scene, statistics, take};
use direkt::low_level::gpu::Context;
use direkt::low_level::prepare::Prepared;
use direkt::low_level::reference::{BrokenTwin, Twin};
use direkt::low_level::render::{Film, Session};
use direkt::low_level::stats::moments::Moments;
use direkt::low_level::stats::z_test::z_test;
use direkt::scene::{Aov, Aovs, FilmSize, LightSelection, Sampler, Scene, Strategy};

const FILM: FilmSize = FilmSize {
    width: 24,
    height: 20,
};

/// Sun, sky and lamps; a sphere, a disk and an environment with groups, in a mirror and behind
/// glass.
fn grouped(name: &str) -> Scene {
    let mut scene = scene(&format!("scenes/{name}.toml"));
    scene.film = FILM;
    scene.render.aovs = [Aov::LightGroups].into_iter().collect();
    scene
}

/// The plates of Veach and the room with mirror and glass, whose lights get groups by turns.
fn by_turns(name: &str) -> Scene {
    let mut scene = grouped(name);
    let shapes = (0..).zip(&scene.shapes);
    let emitting = shapes.filter(|(_, s)| s.emission.is_some());
    for (turn, (shape, _)) in emitting.enumerate() {
        let group = ["even", "odd"][turn % 2];
        let shape = direkt::scene::ShapeId(shape);
        scene.light_groups.add_shape(shape, group);
    }
    scene
}

/// With a lamp of no group as well.
fn with_a_lamp(mut scene: Scene) -> Scene {
    let position = scene.camera.eye + 0.1 * scene.camera.up;
    scene.lights.push(point_light(position, 2.0));
    scene
}

fn scenes() -> Vec<(&'static str, Scene)> {
    vec![
        ("spot_and_sun", grouped("spot_and_sun")),
        ("veach", by_turns("veach")),
        ("glass", with_a_lamp(by_turns("glass"))),
        ("depth_of_field", by_turns("depth_of_field")),
    ]
}

fn film(context: &Context, prepared: &Prepared, samples: u64) -> Film {
    let mut session = Session::new(context, prepared, prepared.film, 3).unwrap();
    take(&mut session, samples);
    session.snapshot().unwrap().0
}

/// Largest difference of the groups' sum from the image, relative to the image.
fn worst_sum(film: &Film) -> f64 {
    let mut worst = 0.0_f64;
    for (i, pixel) in film.pixels.iter().enumerate() {
        for c in 0..3 {
            let sum: f64 = film.light_groups.iter().map(|group| group[i][c]).sum();
            worst = worst.max((sum - pixel.mean[c]).abs() / pixel.mean[c].max(1e-6));
        }
    }
    worst
}

#[test]
fn all_groups_together_are_the_image() {
    let context = context();
    for (name, scene) in scenes() {
        for strategy in [Strategy::LightArea, Strategy::Bsdf, Strategy::MisPower] {
            let prepared = prepared_for(scene.clone(), strategy, LightSelection::Power);
            let names = &prepared.emitters.groups.names;
            let mut film = film(context, &prepared, 9);
            assert_eq!(film.light_groups.len(), names.len(), "{name}");
            assert!(names.len() > 1, "{name}: {names:?}");
            let worst = worst_sum(&film);
            // Sums of at most 9 + 9 numbers, in another order.
            assert!(worst <= 2e-6, "{name}, {strategy}: {worst:e}");
            let (brightest, _) = (0..)
                .zip(&film.light_groups)
                .max_by(|(_, a), (_, b)| mean(a).total_cmp(&mean(b)))
                .unwrap();
            for value in &mut film.light_groups[brightest] {
                *value = value.map(|x: f64| 0.98 * x);
            }
            assert!(worst_sum(&film) > 1e-3, "{name}: a group 2 % too dark");
        }
    }
}

fn mean(group: &[[f64; 3]]) -> f64 {
    let sum: f64 = group.iter().map(|rgb| rgb.iter().sum::<f64>()).sum();
    sum / (3 * group.len()) as f64
}

/// Mean and its variance of the light of a group, as the twin finds them.
fn twin_mean(
    prepared: &Prepared,
    group: u32,
    samples: u64,
    broken: Option<BrokenTwin>,
) -> [f64; 2] {
    let twin = Twin::new(prepared, FILM, 8, broken).with_light_group(group);
    let mut pixels = vec![Moments::default(); FILM.pixels()];
    for index in 0..samples {
        for (pixel, sample) in pixels.iter_mut().zip(twin.samples(index)) {
            pixel.push(sample.radiance.element_sum() / 3.0);
        }
    }
    let n = pixels.len() as f64;
    let variance: f64 = pixels
        .iter()
        .map(|p| p.m2 / (samples * (samples - 1)) as f64)
        .sum();
    [
        pixels.iter().map(|p| p.mean).sum::<f64>() / n,
        variance / (n * n),
    ]
}

/// p-value of a group's mean being that of the twin, whose samples scatter alike.
fn p_value(film: &Film, group: usize, samples: u64, [expected, variance]: [f64; 2]) -> f64 {
    let found = mean(&film.light_groups[group]);
    let of_film = film.pixels[0].samples;
    let variance = variance * (1.0 + samples as f64 / of_film as f64);
    z_test(found, expected, variance, 2e-5 * expected).p_value
}

#[test]
fn each_group_is_the_twins_with_its_lights_alone() {
    let context = context();
    let (mut broken_shown, mut swapped_shown) = (0, 0);
    for (name, mut scene) in scenes() {
        scene.render.estimator.sampler = Sampler::Independent;
        let prepared = prepared(scene);
        let film = film(context, &prepared, 128);
        let names = &prepared.emitters.groups.names;
        let twins: Vec<_> = (0..names.len())
            .map(|group| twin_mean(&prepared, group as u32, 64, None))
            .collect();
        for (group, of_group) in names.iter().enumerate() {
            let what = format!("{name}, group {of_group}, seeds 3 and 8");
            statistics::accept(p_value(&film, group, 64, twins[group]), &what);
            let other = twins[(group + 1) % names.len()];
            let p = p_value(&film, group, 64, other);
            swapped_shown += usize::from(statistics::family().rejects(p));
            let broken = twin_mean(&prepared, group as u32, 64, Some(BrokenTwin::ExtraCosine));
            let p = p_value(&film, group, 64, broken);
            broken_shown += usize::from(statistics::family().rejects(p));
        }
    }
    assert!(swapped_shown >= 6, "another group shows in {swapped_shown}");
    assert!(
        broken_shown >= 4,
        "an extra cosine shows in {broken_shown} groups"
    );
}

/// p-value of independent pixels having the mean `exact`.
fn p_of_pixels(pixels: &[f64], exact: f64) -> f64 {
    let mut moments = Moments::default();
    for &pixel in pixels {
        moments.push(pixel);
    }
    let variance = moments.variance_of_mean().expect("several pixels");
    z_test(moments.mean, exact, variance, 2e-5 * exact).p_value
}

/// Exact values of the parts of `lights_add_up.toml`, whose lights are of one group each.
#[test]
fn groups_have_their_exact_values() {
    let mut scene = scene("scenes/tests/light_groups.toml");
    // Lights without a surface then have no noise.
    scene.render.estimator.light_selection = LightSelection::All;
    let total = match &scene.expect.as_ref().unwrap().radiance {
        direkt::scene::ExpectedRadiance::Mean(mean) => mean.x,
        direkt::scene::ExpectedRadiance::Pixels(_) => unreachable!("one value"),
    };
    let prepared = prepared(scene);
    let context = context();
    let film = film(context, &prepared, 256);
    let names = &prepared.emitters.groups.names;
    assert_eq!(names, &["square", "point", "sky", "default"]);
    // I cosθ ρ/(π d²) of 100 at distance 5 and cosine 4/5; E cosθ ρ/π of 10 at 60°.
    let pi = std::f64::consts::PI;
    let point = 100.0 * 0.8 * 0.5 / (25.0 * pi);
    let sun = 10.0 * 0.5 * 0.5 / pi;
    let image = |groups: &[usize]| -> Vec<f64> {
        let value = |i: usize| groups.iter().map(|&g| film.light_groups[g][i][1]).sum();
        (0..film.pixels.len()).map(value).collect()
    };
    let rest = total - point - sun;
    for (groups, exact) in [(&[1][..], point), (&[3], sun), (&[0, 2], rest)] {
        let what = format!("{groups:?} of {names:?}");
        statistics::accept(p_of_pixels(&image(groups), exact), &what);
        let bright = p_of_pixels(&image(groups), 1.02 * exact);
        statistics::reject(bright, &format!("{what}, 2 % brighter"));
    }
}

#[test]
fn without_groups_shader_and_image_are_as_before() {
    let context = context();
    let with = prepared(grouped("spot_and_sun"));
    let mut scene = grouped("spot_and_sun");
    scene.render.aovs = Aovs::default();
    let asked_for_others: Aovs = [Aov::Albedo, Aov::ShadingNormal, Aov::Depth, Aov::ObjectId]
        .into_iter()
        .collect();
    let session = |scene: &Scene| {
        let prepared = prepared(scene.clone());
        let mut session = Session::new(context, &prepared, FILM, 3).unwrap();
        take(&mut session, 5);
        (session.wgsl().to_owned(), session.snapshot().unwrap().0)
    };
    let (wgsl, image) = session(&scene);
    for absent in [
        "light_group",
        "group_radiance",
        "LIGHT_GROUP",
        "record_features",
        "surface_records",
    ] {
        assert!(!wgsl.contains(absent), "{absent}");
    }
    scene.render.aovs = asked_for_others;
    assert_eq!(session(&scene), (wgsl.clone(), image.clone()));
    scene.render.aovs = Aovs::default();
    scene.light_groups = direkt::scene::LightGroups::default();
    assert_eq!(session(&scene), (wgsl, image.clone()));
    assert!(image.light_groups.is_empty());
    let grouped = film(context, &with, 5);
    assert_eq!(grouped.light_groups.len(), 3);
    assert_eq!(
        grouped.pixels, image.pixels,
        "groups change no bit of the image"
    );
}

/// However passes are cut, in regions of any size, and when another device goes on.
#[test]
fn groups_go_on_exactly_from_where_they_stood() {
    let context = context();
    let prepared = prepared(grouped("spot_and_sun"));
    let whole = film(context, &prepared, 300);
    let mut session = Session::in_regions(context, &prepared, FILM, 3, 2).unwrap();
    for samples in [1, 100, 155, 20] {
        session.pass(samples, || false).unwrap();
    }
    session.save().unwrap();
    session.pass(3, || false).unwrap();
    let checkpoint = session.into_checkpoint();
    assert_eq!(checkpoint.samples(), 276);
    let mut other = Session::in_regions(context, &prepared, FILM, 3, 2).unwrap();
    other.resume(checkpoint).unwrap();
    take(&mut other, 300);
    assert_eq!(other.snapshot().unwrap().0, whole);
    other.restart(3, prepared.settings.stop.spp).unwrap();
    take(&mut other, 300);
    assert_eq!(other.snapshot().unwrap().0, whole);
}
