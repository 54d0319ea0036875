//! A sample that is no number is dropped and counted, never shown.

use crate::support::{
    context, floor_pixel, own_scenes, point_light, prepared, render, render_prepared,
    scenes_of_lights,
};
use direkt::scene::{FilmSize, Sampler, Strategy};
use glam::DVec3;

#[test]
fn overflowing_samples_are_dropped_and_counted() {
    let context = context();
    let mut scene = floor_pixel();
    // Close to the floor, an intensity near f32's largest value overflows when it is divided by d².
    scene
        .lights
        .push(point_light(DVec3::new(0.0, 0.0, 1e-3), 1e37));
    scene.film = FilmSize {
        width: 9,
        height: 9,
    };
    scene.render.estimator.strategy = Strategy::LightArea;
    scene.render.stop.spp = 5;
    let mut in_watts = prepared(scene.clone());
    // A larger unit keeps such a light within f32.
    assert_eq!(render_prepared(context, &in_watts).ledger.dropped, 0);
    in_watts.emitters.unit = 1.0;
    let film = render_prepared(context, &in_watts);
    assert_eq!(film.ledger.dropped, 5 * 81, "{}", context.adapter.name);
    let first = film
        .ledger
        .first_infinite
        .or(film.ledger.first_nan)
        .unwrap();
    assert_eq!((first.x, first.y, first.sample), (0, 0, 0));
    assert!(
        film.pixels
            .iter()
            .all(|p| p.samples == 0 && p.mean.iter().all(|m| m.is_finite()))
    );

    scene.lights[0] = point_light(DVec3::new(0.0, 0.0, 1e-3), 1.0);
    let film = render(context, scene);
    assert_eq!(film.ledger.dropped, 0);
}

/// Every scene of `scenes/` as it is: those of lights with 2²⁴ samples, the others with 2²⁰ each.
/// Those of `scenes/tests/` are where their exact values are checked.
#[test]
fn no_scene_has_a_sample_that_is_not_finite() {
    let context = context();
    let of_lights = scenes_of_lights().into_iter();
    let of_lights = of_lights.map(|(_, scene)| (scene, 1 << 24));
    let own = own_scenes().into_iter().map(|(_, scene)| (scene, 1 << 20));
    for (mut scene, samples) in of_lights.chain(own) {
        scene.render.estimator.sampler = Sampler::Sobol;
        scene.render.stop.spp = samples / scene.film.pixels() as u64;
        let name = scene.source.display().to_string();
        let film = render(context, scene);
        assert_eq!(film.ledger.dropped, 0, "{name}: {:?}", film.ledger);
        assert!(film.sample_range().0 > 0, "{name}");
    }
}
