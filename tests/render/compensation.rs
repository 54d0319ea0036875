//! MIS compensation of the environment map (Karlík et al. 2019): the same mean, less variance, and
//! wrong where light sampling is alone.

use crate::support::every_kind::{environment_map, every_kind};
use crate::support::twin::{
    COMMON_MISTAKES, Part, Power, accept_means, exact_means, recorded_film, same_means,
};
use crate::support::{context, floor_pixel, prepared_for, scene, statistics};
use direkt::low_level::emitters::EnvironmentGrid;
use direkt::low_level::prepare::Prepared;
use direkt::low_level::render::Film;
use direkt::low_level::stats::moments::Moments;
use direkt::low_level::stats::t_test::welch;
use direkt::scene::environment::Interpolation;
use direkt::scene::{
    Bsdf, EnvironmentRadiance, ExpectedRadiance, FilmSize, LightSelection, Scene, Strategy,
};
use glam::DVec3;

const FILM: FilmSize = FilmSize {
    width: 32,
    height: 32,
};
const MIS: [Strategy; 2] = [Strategy::MisBalance, Strategy::MisPower];

fn prepared(mut scene: Scene, strategy: Strategy, compensation: bool) -> Prepared {
    scene.render.estimator.mis_compensation = compensation;
    prepared_for(scene, strategy, LightSelection::Power)
}

fn compensated(prepared: &Prepared) -> bool {
    let grid = prepared.emitters.environment.as_ref().unwrap();
    grid.compensated
}

/// A sun in a broad sky over a Lambert plane, and what the plane exactly shows.
fn sun_and_sky() -> (Scene, [f64; 3]) {
    let scene = scene("scenes/tests/sun_and_sky.toml");
    let expect = scene.expect.as_ref().unwrap();
    let ExpectedRadiance::Mean(exact) = expect.radiance else {
        panic!("the image is of one radiance")
    };
    let exact = exact.to_array();
    (scene, exact)
}

/// Under an interpolated map: a glossy floor, and a scene with every kind of light besides.
fn interpolated_scenes() -> [(&'static str, Scene); 2] {
    let map = || environment_map(Interpolation::Linear);
    let mut glossy = floor_pixel();
    glossy.materials[0].bsdf = Bsdf::Conductor {
        reflectance: DVec3::splat(0.9),
        alpha: 0.4,
    };
    glossy.environment = Some(map());
    [("glossy floor", glossy), ("every kind", every_kind(map()))]
}

#[test]
fn compensation_does_not_change_the_mean() {
    let context = context();
    let mut power = Power::default();
    for (name, scene) in interpolated_scenes() {
        for strategy in MIS {
            let both = [false, true].map(|c| prepared(scene.clone(), strategy, c));
            assert_eq!(both.each_ref().map(compensated), [false, true]);
            let mut seed = 40;
            let films = both.each_ref().map(|prepared| {
                seed += 1;
                recorded_film(context, prepared, (FILM, seed, 256), Part::Reflected)
            });
            let what = format!("{name}, {strategy}, {}", context.adapter.name);
            accept_means(same_means(&films[1], &films[0]), &what);
            let p_values = |film: &_| same_means(film, &films[0]);
            let image = (FILM, Part::Reflected);
            power.check(&both[1], image, Some(&films[0]), p_values, &what);
        }
    }
    power.found(&COMMON_MISTAKES);
}

/// Light sampling that leaves the sky out, with nothing beside it that would find it.
#[test]
fn compensation_under_light_sampling_alone_is_biased_and_found() {
    let context = context();
    let (scene, exact) = sun_and_sky();
    let mut prepared = prepared(scene.clone(), Strategy::LightArea, true);
    assert!(!compensated(&prepared), "the setting is for MIS alone");
    let what = format!("sun and sky, light-area, {}", context.adapter.name);
    let test = |prepared: &Prepared| {
        let film = recorded_film(context, prepared, (FILM, 44, 256), Part::Reflected);
        exact_means(&film, exact, 0.0)
    };
    accept_means(test(&prepared), &what);
    let radiance = &scene.environment.as_ref().unwrap().radiance;
    let EnvironmentRadiance::Map(map) = radiance else {
        panic!("the sky is a map")
    };
    prepared.emitters.environment = EnvironmentGrid::compensated(map);
    for p in test(&prepared) {
        statistics::reject(p, &format!("{what}, compensated"));
    }
}

/// Squared errors of the pixels, over all channels.
fn squares(film: &Film, exact: [f64; 3]) -> Moments {
    let squared = |mean: [f64; 3]| (0..3).map(|c| (mean[c] - exact[c]).powi(2)).sum::<f64>();
    film.pixels.iter().map(|p| squared(p.mean)).collect()
}

/// Pixels are independent, and all see the same radiance.
#[test]
fn compensation_lowers_the_variance_under_a_sun_in_a_broad_sky() {
    let context = context();
    let (scene, exact) = sun_and_sky();
    for strategy in MIS {
        let [plain, lower] = [(false, 46), (true, 47)].map(|(compensation, seed)| {
            let prepared = prepared(scene.clone(), strategy, compensation);
            let run = (FILM, seed, 64);
            let film = recorded_film(context, &prepared, run, Part::Reflected);
            squares(&film, exact)
        });
        let what = format!(
            "sun and sky, {strategy}, {}: mean squared error {:.3e}, compensated {:.3e}",
            context.adapter.name, plain.mean, lower.mean
        );
        let p = welch(&plain, &lower).unwrap().p_value;
        assert!(
            lower.mean < plain.mean && statistics::family().rejects(p),
            "{what}: p = {p:.1e}"
        );
    }
}
