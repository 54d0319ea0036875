//! Every strategy estimates the same integral.

use crate::support::hard_cases::{Measured, survive};
use crate::support::twin::{
    COMMON_MISTAKES, Part, Power, accept_means, exact_means, recorded_film, same_means, twin_film,
};
use crate::support::{
    KINDS_OF_STRATEGIES, STRATEGIES, context, emitter, floor_pixel, lambert, own_scenes, prepared,
    prepared_for, render, scene, scenes_of_lights,
};
use direkt::low_level::prepare::Prepared;
use direkt::low_level::reference::BrokenTwin;
use direkt::low_level::render::Film;
use direkt::scene::Projection;
use direkt::scene::{
    Bsdf, FilmSize, Geometry, LightSampling, LightSelection, Sampler, Scene, ShadowPattern,
    ShadowRays, Strategy,
};
use glam::DVec3;

const FILM: FilmSize = FilmSize {
    width: 64,
    height: 48,
};
const SAMPLES: u64 = 256;
/// The broken twins' images: of the same proportions, so that their means are the same.
const TWIN_FILM: FilmSize = FilmSize {
    width: 40,
    height: 30,
};

/// A floor with a microfacet lobe, and a lamp in the mirror direction: all pixels see a lobe, where
/// those of `scenes/` are few.
fn glossy_floor() -> Scene {
    let mut scene = floor_pixel();
    scene.materials[0].bsdf = Bsdf::Conductor {
        reflectance: DVec3::splat(0.9),
        alpha: 0.4,
    };
    let lamp = Geometry::Rectangle {
        corner: DVec3::new(-2.0, 0.0, 1.0),
        u: 3.0 * DVec3::Y,
        v: 3.0 * DVec3::X,
    };
    scene.shapes.push(emitter(lamp, 1.0, false));
    scene
}

/// The means of what surfaces reflect: every pair of strategies where scenes differ in how they are
/// lit, one of each kind on the others. (Every strategy finds the exact values of `scenes/tests/`,
/// too.)
#[test]
fn strategies_agree_on_every_scene() {
    let context = context();
    let mut power = Power::default();
    let mut scenes = own_scenes();
    scenes.push(("glossy floor".to_owned(), glossy_floor()));
    let of_lights: Vec<String> = scenes_of_lights()
        .into_iter()
        .map(|(name, _)| name)
        .collect();
    for (name, scene) in scenes {
        let strategies = if of_lights.contains(&name) || name == "glossy floor" {
            STRATEGIES.as_slice()
        } else {
            KINDS_OF_STRATEGIES.as_slice()
        };
        let with = |&strategy| prepared_for(scene.clone(), strategy, LightSelection::Power);
        let all: Vec<Prepared> = strategies.iter().map(with).collect();
        let films: Vec<_> = (71..)
            .zip(&all)
            .map(|(seed, prepared)| {
                recorded_film(context, prepared, (FILM, seed, SAMPLES), Part::Reflected)
            })
            .collect();
        for i in 0..films.len() {
            for j in 0..i {
                let what = format!(
                    "{name}, {} and {}, {}",
                    strategies[i], strategies[j], context.adapter.name
                );
                accept_means(same_means(&films[i], &films[j]), &what);
            }
        }
        let index = |s: Strategy| strategies.iter().position(|t| *t == s).unwrap();
        let [area, bsdf, mis] = KINDS_OF_STRATEGIES.map(index);
        for (i, j) in [(area, mis), (bsdf, mis), (mis, area)] {
            let what = format!("{name}, {} against {}", strategies[i], strategies[j]);
            let p_values = |film: &_| same_means(film, &films[j]);
            let image = (TWIN_FILM, Part::Reflected);
            power.check(&all[i], image, Some(&films[j]), p_values, &what);
        }
    }
    power.found(&[
        BrokenTwin::PdfScaled,
        BrokenTwin::WrongMeasure,
        BrokenTwin::SwappedSinCos,
        BrokenTwin::LightLeftOut,
        BrokenTwin::MisWeights,
        BrokenTwin::ExtraCosine,
    ]);
}

#[test]
fn light_selection_does_not_change_the_mean() {
    let context = context();
    let mut power = Power::default();
    let selections = [
        LightSelection::Uniform,
        LightSelection::Power,
        LightSelection::Tree,
        LightSelection::All,
    ];
    for (name, scene) in scenes_of_lights() {
        let all =
            selections.map(|selection| prepared_for(scene.clone(), Strategy::MisPower, selection));
        let films = [0, 1, 2, 3].map(|i| {
            let run = (FILM, 80 + i as u32, SAMPLES);
            recorded_film(context, &all[i], run, Part::Reflected)
        });
        for i in [1, 2, 3] {
            let what = format!(
                "{name}, uniform and {}, {}",
                selections[i], context.adapter.name
            );
            accept_means(same_means(&films[0], &films[i]), &what);
            let p_values = |film: &_| same_means(film, &films[0]);
            let image = (TWIN_FILM, Part::Reflected);
            power.check(&all[i], image, Some(&films[0]), p_values, &what);
        }
    }
    power.found(&COMMON_MISTAKES);
}

#[test]
fn shadow_rays_do_not_change_the_mean() {
    let context = context();
    let mut power = Power::default();
    let mut scenes = scenes_of_lights();
    scenes.push(("glossy floor".to_owned(), glossy_floor()));
    for (name, scene) in scenes {
        let one = prepared_for(scene.clone(), Strategy::MisPower, LightSelection::Power);
        let film = recorded_film(context, &one, (FILM, 85, SAMPLES), Part::Reflected);
        for pattern in [ShadowPattern::Random, ShadowPattern::Stratified] {
            let mut scene = scene.clone();
            scene.render.estimator.shadow_rays = ShadowRays::Number(4);
            scene.render.estimator.shadow_pattern = pattern;
            let four = prepared_for(scene, Strategy::MisPower, LightSelection::Power);
            let of_four = recorded_film(context, &four, (FILM, 86, SAMPLES), Part::Reflected);
            let what = format!("{name}, 1 and 4 {pattern} rays, {}", context.adapter.name);
            accept_means(same_means(&of_four, &film), &what);
            if pattern == ShadowPattern::Random {
                let p_values = |broken: &_| same_means(broken, &film);
                let image = (TWIN_FILM, Part::Reflected);
                power.check(&four, image, Some(&film), p_values, &what);
            }
        }
    }
    power.found(&[BrokenTwin::RaysForgotten, BrokenTwin::MisWeights]);
}

/// Difference of the red channel's means.
fn standard_errors(film: &Film, other: &Film) -> f64 {
    let [a, b] = [film, other].map(|f| (f.mean()[0], f.standard_error_of_mean().unwrap()[0]));
    (a.0 - b.0).abs() / a.1.hypot(b.1)
}

/// HARD CASES M2: squares of radiances 10⁻³ and 10³ side by side, chosen alike or by power.
#[test]
fn lights_of_very_different_power_have_the_same_mean_under_every_selection() {
    let context = context();
    let mut power = Power::default();
    for strategy in [Strategy::LightArea, Strategy::MisPower] {
        let scenes = [LightSelection::Uniform, LightSelection::Power].map(|selection| {
            let mut scene = floor_pixel();
            for (x, radiance) in [(-1.5, 1e-3), (0.5, 1e3)] {
                let square = Geometry::Rectangle {
                    corner: DVec3::new(x, -0.5, 1.0),
                    u: DVec3::Y,
                    v: DVec3::X,
                };
                scene.shapes.push(emitter(square, radiance, false));
            }
            scene.film = TWIN_FILM;
            scene.render.estimator.strategy = strategy;
            scene.render.estimator.light_selection = selection;
            scene.render.stop.spp = 1024;
            scene.render.seed = 20 + selection as u32;
            scene.render.estimator.sampler = Sampler::Independent;
            scene.render.estimator.light_sampling = LightSampling::Area;
            scene
        });
        let films = scenes.clone().map(|scene| render(context, scene));
        let what = format!(
            "1 : 1e6, {strategy}, uniform and power, {}",
            context.adapter.name
        );
        accept_means(same_means(&films[0], &films[1]), &what);
        let mistaken = twin_film(
            &prepared(scenes[1].clone()),
            (TWIN_FILM, 1000, 64),
            Part::All,
            Some(BrokenTwin::WrongMeasure),
        );
        survive(
            context,
            Measured {
                entry: "M2",
                case: &format!("lights of 1 and 10⁶, chosen alike and by power, {strategy}"),
                figure: "difference of the means in standard errors",
                bound: 4.5,
                textbook: "densities per area as if per solid angle",
                naive: standard_errors(&mistaken, &films[0]),
                ours: standard_errors(&films[1], &films[0]),
            },
        );
        for (i, scene) in scenes.iter().enumerate() {
            let other = &films[1 - i];
            let p_values = |film: &_| same_means(film, other);
            let image = (TWIN_FILM, Part::All);
            power.check(
                &prepared(scene.clone()),
                image,
                Some(other),
                p_values,
                &what,
            );
        }
    }
    power.found(&COMMON_MISTAKES);
}

/// The Cornell box's image mean, by another renderer at 8,192 samples per pixel (Mitsuba 3.9.1,
/// `direct`, box filter), which is known to five digits.
#[test]
fn cornells_image_mean_is_the_reference_mean() {
    let exact = [0.16392, 0.11420, 0.05207];
    let mut cornell = scene("scenes/cornell.toml");
    cornell.render.stop.spp = 32;
    cornell.render.estimator.strategy = Strategy::LightArea;
    let context = context();
    let film = render(context, cornell.clone());
    let what = format!("cornell.toml, Mitsuba's mean, {}", context.adapter.name);
    let test = |film: &_| exact_means(film, exact, 5e-6);
    accept_means(test(&film), &what);
    let mut power = Power::default();
    // The borders of the lamp are the mean's noise, which falls with the number of pixels.
    let size = FilmSize {
        width: 64,
        height: 64,
    };
    power.check(
        &prepared(cornell.clone()),
        (size, Part::All),
        None,
        test,
        &what,
    );
    // Most of the mean is the lamp in sight: what moves the rest by little does not show.
    power.found(&[BrokenTwin::LightLeftOut, BrokenTwin::ExtraCosine]);
}

/// A furnace: inside a sphere that emits 1 and reflects ρ in the form of a Lambert surface, a point
/// of it sends 1 + ρ·1 to the camera, wherever one looks and whatever the strategy.
#[test]
fn a_furnace_is_as_bright_everywhere() {
    let context = context();
    let mut power = Power::default();
    for strategy in STRATEGIES {
        for reflectance in [0.5, 1.0] {
            let mut scene = floor_pixel();
            scene.shapes.clear();
            scene.materials = vec![lambert(reflectance)];
            let sphere = Geometry::Sphere {
                center: DVec3::new(1.0, -3.0, 2.0),
                radius: 2.0,
            };
            scene.shapes.push(emitter(sphere, 1.0, true));
            scene.camera.projection = Projection::Perspective { fov_y: 1.5 };
            scene.film = TWIN_FILM;
            scene.render.estimator.strategy = strategy;
            scene.render.stop.spp = 256;
            let film = render(context, scene.clone());
            let what = format!(
                "furnace {reflectance}, {strategy}, {}",
                context.adapter.name
            );
            let test = |film: &_| exact_means(film, [1.0 + reflectance; 3], 0.0);
            accept_means(test(&film), &what);
            let image = (TWIN_FILM, Part::All);
            power.check(&prepared(scene.clone()), image, None, test, &what);
        }
    }
    power.found(&COMMON_MISTAKES);
}
