//! Lights that touch what they light: HARD CASES G9, L2.

use crate::support::hard_cases::{Measured, survive};
use crate::support::{STRATEGIES, context, emitter, floor_pixel, lambert, render, statistics};
use direkt::low_level::gpu::Context;
use direkt::low_level::reference::exact::rectangle::{parallel_rectangle, perpendicular_rectangle};
use direkt::low_level::reference::exact::variance::{parallel_rectangle_by_area, wall_by_area};
use direkt::low_level::stats::moments::Moments;
use direkt::low_level::stats::z_test::z_test;
use direkt::scene::{
    Camera, FilmSize, Geometry, LightSampling, Material, MaterialId, Sampler, Scene, Strategy,
};
use glam::DVec3;
use std::f64::consts::PI;

/// How far f32's rounding may move a mean, relative to it.
const ROUNDING: f64 = 2e-5;
/// With samples of L·Ω·cosθ, which lie in [0, Ω], the variance is at most Ω²/4 (Popoviciu); Ω ≤ π
/// for a wall that stands on the floor.
const BOUND: f64 = PI * PI / 4.0;

/// The point (0, 0, 0) of a floor of side 2, seen from the side of the negative x by 32 × 32
/// pixels, and a light of radiance 1 whose back rays pass through.
fn floor_and_light(light: Geometry) -> Scene {
    let mut scene = floor_pixel();
    scene.camera =
        Camera::look_at(DVec3::new(-0.5, -0.4, 0.6), DVec3::ZERO, DVec3::Z, 1e-9).unwrap();
    scene.film = FilmSize {
        width: 32,
        height: 32,
    };
    scene.shapes[0].geometry = Geometry::Rectangle {
        corner: DVec3::new(-1.0, -1.0, 0.0),
        u: 2.0 * DVec3::X,
        v: 2.0 * DVec3::Y,
    };
    scene.materials.push(Material {
        name: "seen through from behind".to_owned(),
        double_sided: false,
        ..lambert(0.0)
    });
    let mut light = emitter(light, 1.0, false);
    light.material = MaterialId(1);
    scene.shapes.push(light);
    scene.render.estimator.sampler = Sampler::Independent;
    scene.render.estimator.light_sampling = LightSampling::SolidAngle;
    scene.render.stop.spp = 256;
    scene
}

/// A square of side 1 that stands on the floor at `gap` from the point, and faces it.
fn wall(gap: f64) -> Scene {
    floor_and_light(Geometry::Rectangle {
        corner: DVec3::new(gap, -0.5, 0.0),
        u: DVec3::Z,
        v: DVec3::Y,
    })
}

/// A rectangle parallel to the floor at `gap`, centred over `center`.
fn lid(center: [f64; 2], [width, depth]: [f64; 2], gap: f64) -> Scene {
    floor_and_light(Geometry::Rectangle {
        corner: DVec3::new(center[0] - 0.5 * width, center[1] - 0.5 * depth, gap),
        u: depth * DVec3::Y,
        v: width * DVec3::X,
    })
}

/// Samples of the irradiance: L_o = ρ E/π.
fn irradiance(context: &Context, scene: &Scene, strategy: Strategy) -> Moments {
    let mut scene = scene.clone();
    scene.render.estimator.strategy = strategy;
    let film = render(context, scene);
    assert_eq!(
        film.ledger.dropped, 0,
        "{strategy}: samples that are not finite"
    );
    let mut all = Moments::default();
    for pixel in &film.pixels {
        all.merge(&pixel.channel(0));
    }
    let factor = PI / 0.5;
    Moments {
        count: all.count,
        mean: factor * all.mean,
        m2: factor * factor * all.m2,
    }
}

fn p_value(found: &Moments, exact: f64, variance: Option<f64>) -> f64 {
    let of_mean = match variance {
        Some(variance) => variance / found.count as f64,
        None => found.variance_of_mean().unwrap(),
    };
    z_test(found.mean, exact, of_mean, ROUNDING * exact).p_value
}

/// The mean of every strategy, and of MIS with every way of sampling lights, against `exact`. Area
/// sampling is held against its exact variance, which its samples do not tell: the rare ones that
/// make it are missing.
fn means_are_right(scene: &Scene, exact: f64, by_area: f64, what: &str) {
    let context = context();
    for strategy in STRATEGIES {
        let found = irradiance(context, scene, strategy);
        let variance = (strategy == Strategy::LightArea).then_some(by_area);
        let what = format!("{what}, {strategy}, {}", context.adapter.name);
        statistics::accept(p_value(&found, exact, variance), &what);
        if strategy == Strategy::MisPower {
            // Power: an irradiance that is 3 % brighter is not taken for this one.
            statistics::reject(p_value(&found, 1.03 * exact, None), &what);
        }
    }
}

fn wall_is_right_at(gap: f64) {
    let exact = PI * perpendicular_rectangle([-0.5, 0.5], [0.0, 1.0], gap);
    let by_area = wall_by_area(1.0, 1.0, gap).variance;
    means_are_right(&wall(gap), exact, by_area, &format!("wall at {gap}"));
}

#[test]
fn every_strategy_finds_a_wall_at_gaps_of_0_1_and_0_01() {
    wall_is_right_at(1e-1);
    wall_is_right_at(1e-2);
}

#[test]
fn every_strategy_finds_a_wall_at_gaps_of_1e_3_and_1e_4() {
    wall_is_right_at(1e-3);
    wall_is_right_at(1e-4);
}

#[test]
fn every_strategy_finds_a_wall_at_gaps_of_1e_5_and_1e_6() {
    wall_is_right_at(1e-5);
    wall_is_right_at(1e-6);
}

#[test]
fn the_variance_beside_a_wall_is_bounded() {
    let context = context();
    let [by_area, ours] =
        [Strategy::LightArea, Strategy::MisPower].map(|s| irradiance(context, &wall(1e-3), s));
    survive(
        context,
        Measured {
            entry: "G9",
            case: "unit wall 10⁻³ from the point that it lights",
            figure: "variance of a sample of the irradiance",
            bound: BOUND,
            textbook: "area sampling",
            naive: by_area.variance().unwrap(),
            ours: ours.variance().unwrap(),
        },
    );
    // So near, area sampling's variance of 10¹¹ is made by samples that are never seen: its mean is
    // short of them.
    let exact = PI * perpendicular_rectangle([-0.5, 0.5], [0.0, 1.0], 1e-6);
    let [by_area, ours] =
        [Strategy::LightArea, Strategy::MisPower].map(|s| irradiance(context, &wall(1e-6), s));
    assert!(ours.variance().unwrap() <= BOUND, "{ours:?}");
    let off = |found: &Moments| (found.mean / exact - 1.0).abs();
    survive(
        context,
        Measured {
            entry: "G9",
            case: "unit wall 10⁻⁶ from the point that it lights, 2¹⁸ samples",
            figure: "relative error of the irradiance",
            bound: statistics::family().z_bound() * (BOUND / ours.count as f64).sqrt() / exact,
            textbook: "area sampling",
            naive: off(&by_area),
            ours: off(&ours),
        },
    );
}

/// A lamp as large as the Cornell box's, a hundredth below the ceiling that it lights from below
/// (here turned upside down): over its centre, over its edge, and beside it.
#[test]
fn every_strategy_finds_the_ceiling_a_hundredth_above_a_lamp() {
    for x in [0.0, 0.23, 0.28] {
        let exact = PI * parallel_rectangle([x - 0.23, x + 0.23], [-0.19, 0.19], 0.01);
        let by_area = parallel_rectangle_by_area(0.46, 0.38, 0.01).variance;
        let scene = lid([x, 0.0], [0.46, 0.38], 0.01);
        means_are_right(&scene, exact, by_area, &format!("ceiling at {x}"));
    }
}

/// Samples of L·Ω·cosθ lie in [0, Ω], and Ω < 2π.
#[test]
fn the_variance_a_hundredth_above_a_lamp_is_bounded() {
    let context = context();
    let scene = lid([0.0, 0.0], [0.46, 0.38], 0.01);
    let [by_area, ours] = [Strategy::LightArea, Strategy::MisPower]
        .map(|strategy| irradiance(context, &scene, strategy).variance().unwrap());
    survive(
        context,
        Measured {
            entry: "L2",
            case: "ceiling 0.01 above a lamp of 0.46 × 0.38",
            figure: "variance of a sample of the irradiance",
            bound: PI * PI,
            textbook: "area sampling",
            naive: by_area,
            ours,
        },
    );
}
