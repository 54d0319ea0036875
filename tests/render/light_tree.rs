//! The light tree: what it changes of an image, and what not.

use crate::support::twin::{Part, accept_means, recorded_film, same_means, twin_film};
use crate::support::{
    context, emitter, floor_pixel, point_light, prepared, prepared_for, scene, statistics,
    unit_square,
};
use direkt::low_level::effects::Effect;
use direkt::low_level::emitters::{LightTree, Selection};
use direkt::low_level::prepare::Prepared;
use direkt::low_level::render::Film;
use direkt::low_level::stats::z_test::z_test;
use direkt::scene::{FilmSize, Geometry, LightSelection, Scene, Strategy};
use glam::DVec3;

const FILM: FilmSize = FilmSize {
    width: 64,
    height: 48,
};

const SELECTIONS: [LightSelection; 4] = [
    LightSelection::Uniform,
    LightSelection::Power,
    LightSelection::Tree,
    LightSelection::All,
];

/// Lamps of all sizes around the point, looking at it, so that BSDF sampling finds them as well.
fn lamps() -> Scene {
    let mut scene = floor_pixel();
    for i in 0..12 {
        let (sin, cos) = (0.7 * f64::from(i)).sin_cos();
        let size = 0.2 + 0.1 * f64::from(i % 5);
        let around = DVec3::new(cos, sin, 0.0);
        let lamp = Geometry::Rectangle {
            corner: (0.6 + 0.15 * f64::from(i)) * around + DVec3::new(0.0, 0.0, 0.8),
            u: size * DVec3::new(sin, -cos, 0.0),
            v: size * DVec3::new(-cos, -sin, 1.0).normalize(),
        };
        let lamp = emitter(lamp, 1.0 + f64::from(i % 3), i % 4 == 0);
        scene.shapes.push(lamp);
    }
    scene
}

/// `prepared` with its tree changed.
fn with_tree(mut prepared: Prepared, change: impl Fn(&mut LightTree)) -> Prepared {
    match &mut prepared.emitters.selection {
        Some(Selection::Tree(tree)) => change(tree),
        other => panic!("no light tree but {other:?}"),
    }
    prepared
}

/// What makes a tree wrong.
type Mistake = fn(&mut LightTree);

/// The probability that MIS asks for decides on the mean; and the cones by which lights are left
/// out, where no BSDF sampling stands in for them.
#[test]
fn a_tree_with_a_mistake_is_found_out() {
    let context = context();
    let mistakes: [(&str, Strategy, Mistake); 2] = [
        (
            "every light asked for as the first",
            Strategy::MisPower,
            |tree| tree.trails.fill(0),
        ),
        (
            "light emitted along the normals alone",
            Strategy::LightSolidAngle,
            |tree| {
                for child in tree.nodes.iter_mut().flat_map(|node| &mut node[..2]) {
                    child[3] |= 0x7fff_0000;
                }
            },
        ),
    ];
    for (mistake, strategy, make_it) in mistakes {
        let make = || prepared_for(lamps(), strategy, LightSelection::Tree);
        let honest = make();
        let gpu = recorded_film(context, &honest, (FILM, 200, 256), Part::Reflected);
        let twin = |p: &Prepared| twin_film(p, (FILM, 201, 128), Part::Reflected, None);
        let what = format!("light tree, {strategy}, {}", context.adapter.name);
        accept_means(same_means(&gpu, &twin(&honest)), &what);
        let broken = twin(&with_tree(make(), make_it));
        let p = same_means(&gpu, &broken).into_iter().fold(1.0, f64::min);
        statistics::reject(p, &format!("{what}, {mistake}"));
    }
}

/// Two lamps of powers 1 : 10⁶ at one height; and at distances 1 : 10³, so that both give the same.
#[test]
fn dim_and_bright_lights_give_their_sum() {
    let context = context();
    // By power the dim lamp has one sample in a million: no image has enough, where it matters.
    let all_but_power = [0, 2, 3].map(|i| SELECTIONS[i]);
    let near = 10_f64.powf(-1.5);
    for (dim, bright, selections) in [
        (1.0, 1.0, &SELECTIONS[..]),
        (near, 1e3 * near, &all_but_power[..]),
    ] {
        let mut scene = floor_pixel();
        scene.lights = vec![
            point_light(dim * DVec3::Z, 1e-3),
            point_light(bright * DVec3::Z, 1e3),
        ];
        // ρ/π · I/d² with ρ = ½.
        let exact = 0.5 / std::f64::consts::PI * (1e-3 / (dim * dim) + 1e3 / (bright * bright));
        for &selection in selections {
            let prepared = prepared_for(scene.clone(), Strategy::MisPower, selection);
            let film = recorded_film(context, &prepared, (FILM, 210, 64), Part::Reflected);
            let error = film.standard_error_of_mean().unwrap()[0];
            let mean = film.mean()[0];
            let p = z_test(mean, exact, error * error, 2e-5 * exact).p_value;
            let what = format!("dim lamp at {dim}, {selection}: {mean} for {exact}");
            statistics::accept(p, &what);
        }
    }
}

/// Sum of the pixels' variances.
fn variance(film: &Film) -> f64 {
    let pixels = film.pixels.iter().filter_map(|p| p.variance_of_mean());
    pixels.map(|v| v.iter().sum::<f64>()).sum()
}

/// What the tree is for: among 100,000 lights of the same power the few that light a point.
#[test]
fn a_tree_has_less_than_a_tenth_of_the_variance_of_power() {
    let context = context();
    let mut scene = scene("scenes/many_lights/many_lights.toml");
    scene.film = FilmSize {
        width: 96,
        height: 54,
    };
    let variance_by = |selection| {
        let prepared = prepared_for(scene.clone(), Strategy::LightSolidAngle, selection);
        assert_eq!(prepared.emitters.lights.len(), 100_000);
        let film = recorded_film(context, &prepared, (scene.film, 220, 32), Part::Reflected);
        variance(&film)
    };
    let by_tree = variance_by(LightSelection::Tree);
    let by_power = variance_by(LightSelection::Power);
    assert!(by_power > 10.0 * by_tree, "{by_tree} and {by_power}");
}

/// A tree is called for where it has lights to choose from: two or more at a finite distance, that
/// are sampled.
#[test]
fn a_tree_is_called_for_by_two_lights() {
    let calls = |scene: &Scene, strategy: Strategy| {
        let mut scene = scene.clone();
        scene.render.estimator.light_selection = LightSelection::Tree;
        scene.render.estimator.strategy = strategy;
        let effects = prepared(scene).effects;
        let reason = effects
            .iter()
            .find(|(effect, _)| *effect == Effect::LightTree);
        reason.map(|(_, reason)| reason.to_owned())
    };
    let mut scene = floor_pixel();
    scene.shapes.push(emitter(unit_square(), 1.0, false));
    scene.environment = Some(crate::support::every_kind::constant_environment());
    assert_eq!(calls(&scene, Strategy::MisPower), None);
    scene.lights.push(point_light(DVec3::Z, 1.0));
    let reason = calls(&scene, Strategy::MisPower);
    assert_eq!(
        reason.as_deref(),
        Some("light_selection = \"tree\", 3 lights")
    );
    assert_eq!(calls(&scene, Strategy::Bsdf), None, "one light is sampled");
    scene.lights.push(point_light(0.5 * DVec3::Z, 1.0));
    assert!(calls(&scene, Strategy::Bsdf).is_some());
}

/// Unless a scene says otherwise every one of few lights has its own samples, and one of many is chosen by
/// the tree: of those that are sampled, which with BSDF sampling alone are those without a surface.
#[test]
fn all_of_few_lights_are_sampled_and_one_of_many() {
    let calls = |points: usize, strategy: Strategy| {
        let mut scene = floor_pixel();
        scene.shapes.push(emitter(unit_square(), 1.0, false));
        for i in 1..=points {
            scene
                .lights
                .push(point_light(DVec3::Z / (i as f64 + 1.0), 1.0));
        }
        scene.render.estimator.strategy = strategy;
        let effects = prepared(scene).effects;
        [Effect::AllLights, Effect::LightTree].map(|effect| effects.contains(effect))
    };
    assert_eq!(calls(0, Strategy::MisPower), [false, false]);
    assert_eq!(calls(1, Strategy::MisPower), [true, false]);
    assert_eq!(calls(7, Strategy::MisPower), [true, false]);
    assert_eq!(calls(8, Strategy::MisPower), [false, true]);
    assert_eq!(calls(8, Strategy::Bsdf), [true, false]);
    assert_eq!(calls(9, Strategy::Bsdf), [false, true]);
}
