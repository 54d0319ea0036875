//! How many shadow rays an image has where its settings leave that open.

use crate::support::{context, prepared, render, scene_as_it_is};
use direkt::low_level::effects::Effect;
use direkt::low_level::render::{Film, Session};
use direkt::scene::{FilmSize, Scene, ShadowRays};

/// A scene of `scenes/`, small, with as many samples for every pixel.
fn small(name: &str, rays: ShadowRays) -> Scene {
    let mut scene = scene_as_it_is(&format!("scenes/{name}.toml"));
    scene.film = FilmSize {
        width: 96,
        height: 72,
    };
    scene.render.stop.spp = 16;
    scene.render.estimator.shadow_rays = rays;
    scene
}

/// Penumbrae of a large light need several; a lens out of focus needs more camera rays. What is asked
/// leaves no trace in the image.
#[test]
fn images_have_as_many_as_pay_and_no_other_difference() {
    for (name, rays) in [("corner", ShadowRays::SEVERAL), ("depth_of_field", 1)] {
        for seed in 0..3 {
            let film = |rays: ShadowRays| -> Film {
                let mut scene = small(name, rays);
                scene.render.seed = seed;
                render(context(), scene)
            };
            let chosen = film(ShadowRays::Auto);
            assert_eq!(chosen.shadow_rays, rays, "{name}, seed {seed}");
            let named = film(ShadowRays::Number(rays));
            assert!(chosen == named, "{name}, seed {seed}");
        }
    }
}

/// A view that moves keeps the number that it began with; another image has its own.
#[test]
fn a_view_that_moves_asks_once() {
    let prepared = prepared(small("corner", ShadowRays::Auto));
    let mut session = Session::new(context(), &prepared, prepared.film, 0).unwrap();
    assert_eq!(session.shadow_rays(), 1);
    session.pass(1, || false).unwrap();
    assert_eq!(session.shadow_rays(), ShadowRays::SEVERAL);
    let smaller = FilmSize {
        width: 40,
        height: 30,
    };
    session.reframe(&prepared, smaller).unwrap();
    assert_eq!(session.shadow_rays(), ShadowRays::SEVERAL);
    session.pass(1, || false).unwrap();
    let film = session.snapshot().unwrap().0;
    assert_eq!(
        (film.size, film.shadow_rays),
        (smaller, ShadowRays::SEVERAL)
    );
    session.restart(1, 16).unwrap();
    assert_eq!(session.shadow_rays(), 1);
}

/// Nobody is asked where a second ray would be the same.
#[test]
fn lights_without_extent_have_one() {
    let mut scene = small("corner", ShadowRays::Auto);
    scene.shapes.retain(|shape| shape.emission.is_none());
    scene.lights.push(crate::support::point_light(
        glam::DVec3::new(0.0, 0.5, 0.5),
        1.0,
    ));
    let prepared = prepared(scene);
    assert!(!prepared.effects.contains(Effect::ShadowRays));
    let mut session = Session::new(context(), &prepared, prepared.film, 0).unwrap();
    session.pass(1, || false).unwrap();
    assert_eq!(session.shadow_rays(), 1);
}
