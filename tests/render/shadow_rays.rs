//! Several shadow rays per camera ray, where they end, and shadow rays to every light.

use crate::support::{
    assert_pixel, context, emitter, floor_pixel, point_light, prepared, render, scene, statistics,
    unit_square,
};
use direkt::low_level::effects::Effect;
use direkt::low_level::reference::exact::cubature::{Tolerance, integrate};
use direkt::low_level::render::{Check, Film, Session};
use direkt::low_level::stats::moments::Moments;
use direkt::low_level::stats::t_test::one_sample;
use direkt::scene::Projection;
use direkt::scene::{
    DirectionalLight, ExpectedRadiance, FilmSize, Geometry, Light, LightSelection, Sampler, Scene,
    ShadowGrid, ShadowPattern, ShadowRays, Strategy,
};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

const RADIANCE: f64 = 10.0;
/// f_r L of the floor under a light.
const FACTOR: f64 = RADIANCE * 0.5 / PI;

/// `scene` with `rays` shadow rays in `pattern`.
fn with_rays(mut scene: Scene, rays: u32, pattern: ShadowPattern) -> Scene {
    scene.render.estimator.shadow_rays = ShadowRays::Number(rays);
    scene.render.estimator.shadow_pattern = pattern;
    scene
}

/// Scenes with several lights, with an environment, with lights that only MIS samples well, with
/// delta lights, and with a glossy surface.
const SCENES: [&str; 5] = [
    "lights_add_up",
    "sphere_half_below",
    "furnace_0.5",
    "inside_sphere_four_points",
    "ggx_albedo_alpha_0.25_60",
];

const WAYS: [(u32, ShadowPattern, LightSelection); 4] = [
    (1, ShadowPattern::Random, LightSelection::All),
    (3, ShadowPattern::Random, LightSelection::Uniform),
    (3, ShadowPattern::Stratified, LightSelection::All),
    (4, ShadowPattern::Stratified, LightSelection::Power),
];

/// Every unbiased way finds the scenes' exact values, and does not find values that are 2 % off,
/// where that is nine of the image's standard errors.
#[test]
fn exact_values_are_found_with_several_rays_and_every_light() {
    let context = context();
    let mut sharp = 0;
    for name in SCENES {
        for strategy in [
            Strategy::LightProjectedSolidAngle,
            Strategy::MisBalance,
            Strategy::MisPower,
        ] {
            for (rays, pattern, selection) in WAYS {
                let mut scene =
                    with_rays(scene(&format!("scenes/tests/{name}.toml")), rays, pattern);
                scene.render.estimator.strategy = strategy;
                scene.render.estimator.light_selection = selection;
                scene.render.stop.spp = (scene.render.stop.spp / 8).max(64);
                let film = render(context, scene.clone());
                let what = format!(
                    "{name}, {strategy}, {rays} {pattern} rays, {selection}, {}",
                    context.adapter.name
                );
                let mut expect = scene.expect.clone().unwrap();
                let check = Check::new(&film, &expect).unwrap();
                assert!(check.passed, "{what}: {check:?}");
                let error = film.standard_error_of_mean().unwrap()[0] / film.mean()[0];
                if error < 0.02 / 9.0 {
                    sharp += 1;
                    brighten(&mut expect.radiance);
                    let check = Check::new(&film, &expect).unwrap();
                    assert!(!check.passed, "{what}: 2 % off, and it passed");
                }
            }
        }
    }
    assert!(sharp > 40, "{sharp} images are sharp");
}

fn brighten(radiance: &mut ExpectedRadiance) {
    match radiance {
        ExpectedRadiance::Mean(mean) => *mean *= 1.02,
        ExpectedRadiance::Pixels(pixels) => pixels.iter_mut().for_each(|p| *p *= 1.02),
    }
}

/// 64 × 64 pixels that all see the same point of the floor, at height 1 below the corner of a unit
/// square.
fn square_over_floor() -> Scene {
    let mut scene = floor_pixel();
    scene.film = FilmSize {
        width: 64,
        height: 64,
    };
    let square = Geometry::Rectangle {
        corner: DVec3::Z,
        u: DVec3::Y,
        v: DVec3::X,
    };
    scene.shapes.push(emitter(square, RADIANCE, false));
    scene.render.estimator.strategy = Strategy::LightArea;
    scene
}

/// cosθ cosθ'/d² of the point `u` of that square, whose coordinates may be swapped.
fn irradiance(u: DVec2) -> f64 {
    (1.0 + u.length_squared()).powi(-2)
}

/// Mean of [`irradiance`], and variance of the mean of one uniform point in each of `columns` ×
/// `rows` cells.
fn stratified_moments(columns: u32, rows: u32) -> (f64, f64) {
    let cells = f64::from(columns * rows);
    let edges = |i: u32, n: u32| [i, i + 1].map(|i| f64::from(i) / f64::from(n));
    let (mut mean, mut variance) = (0.0, 0.0);
    for cell in 0..columns * rows {
        let (x, y) = (edges(cell % columns, columns), edges(cell / columns, rows));
        let powers = |x: f64, y: f64| {
            let e = irradiance(DVec2::new(x, y));
            DVec3::new(e, e * e, 0.0)
        };
        let integral = cells * integrate(powers, &x, &y, Tolerance::relative(1e-12)).value;
        mean += integral.x / cells;
        variance += (integral.y - integral.x * integral.x) / (cells * cells);
    }
    (mean, variance)
}

/// p-value of the pixels' mean squared error being that of `samples` samples of this mean and
/// variance, from its spread over the pixels, which are independent.
fn level_p_value(film: &Film, (mean, variance): (f64, f64), samples: u64) -> f64 {
    let unit = FACTOR * FACTOR * variance;
    let squares: Moments = film
        .pixels
        .iter()
        .map(|p| (p.mean[0] - FACTOR * mean).powi(2) / unit)
        .collect();
    one_sample(&squares, 1.0 / samples as f64).unwrap().p_value
}

/// A camera sample's variance is that of one light sample over n with n random rays, and that of
/// the strata with n stratified ones, which is less: the tests tell them apart.
#[test]
fn variance_falls_with_the_number_of_rays() {
    let context = context();
    let samples = 4;
    let one = stratified_moments(1, 1);
    for rays in [3, 4, 16, 64] {
        let grid = ShadowGrid::new(rays);
        let strata = stratified_moments(grid.columns, grid.rows);
        let random = (one.0, one.1 / f64::from(rays));
        assert!(strata.1 < 0.7 * random.1, "{rays}: {}", strata.1 / random.1);
        for (pattern, moments, others) in [
            (ShadowPattern::Random, random, strata),
            (ShadowPattern::Stratified, strata, random),
        ] {
            let mut scene = with_rays(square_over_floor(), rays, pattern);
            scene.render.stop.spp = samples;
            scene.render.seed = rays;
            let film = render(context, scene);
            let what = format!(
                "variance of {rays} {pattern} rays, {}",
                context.adapter.name
            );
            statistics::accept(level_p_value(&film, moments, samples), &what);
            statistics::reject(
                level_p_value(&film, others, samples),
                &format!("{what}, taken for the other pattern"),
            );
        }
    }
}

/// A floor under four lights without extent, as seen in one point.
fn four_lights() -> (Scene, f64) {
    let mut scene = floor_pixel();
    let heights = [1.0, 2.0, 3.0];
    let points = heights.map(|z| point_light(DVec3::new(0.0, 0.0, z), 10.0));
    scene.lights = points.into();
    scene.lights.push(Light::Directional(DirectionalLight {
        direction: -DVec3::Z,
        irradiance: DVec3::splat(2.0),
    }));
    scene.render.estimator.strategy = Strategy::LightArea;
    let irradiance = heights.iter().map(|z| 10.0 / (z * z)).sum::<f64>() + 2.0;
    (scene, 0.5 / PI * irradiance)
}

/// Lights without extent leave nothing to chance when all of them have a shadow ray, or when each
/// is chosen once.
#[test]
fn every_light_leaves_no_variance_of_choice() {
    let context = context();
    for (rays, pattern, selection, traced) in [
        (1, ShadowPattern::Random, LightSelection::All, 4),
        (7, ShadowPattern::Random, LightSelection::All, 4),
        (4, ShadowPattern::Stratified, LightSelection::Uniform, 4),
        (8, ShadowPattern::Stratified, LightSelection::Uniform, 8),
    ] {
        let (scene, expected) = four_lights();
        let mut scene = with_rays(scene, rays, pattern);
        scene.render.estimator.light_selection = selection;
        let (film, size) = (render(context, scene.clone()), scene.film);
        let pixel = &film.pixels[0];
        let what = format!("{rays} {pattern}, {selection}: {pixel:?}");
        assert!(
            (pixel.mean[0] / expected - 1.0).abs() < 1e-6,
            "{what} of {expected}"
        );
        assert!(pixel.m2[0].sqrt() < 1e-6 * expected, "{what}");
        let prepared = prepared(scene);
        let mut session = Session::new(context, &prepared, size, 0).unwrap();
        session.pass(16, || false).unwrap();
        let (_, counts) = session.snapshot().unwrap();
        assert_eq!(counts.shadow, 16 * traced, "{what}");
    }
    let (mut scene, expected) = four_lights();
    scene.render.estimator.light_selection = LightSelection::Uniform;
    let pixel = render(context, scene).pixels[0];
    assert!((pixel.m2[0] / 15.0).sqrt() > 0.3 * expected, "{pixel:?}");
}

/// Mean of [`irradiance`] over the middles of a grid's cells.
fn quadrature(rays: u32) -> f64 {
    let grid = ShadowGrid::new(rays);
    let size = DVec2::new(f64::from(grid.columns), f64::from(grid.rows));
    let cells =
        (0..rays).map(|i| DVec2::new(f64::from(i % grid.columns), f64::from(i / grid.columns)));
    cells.map(|c| irradiance((c + 0.5) / size)).sum::<f64>() / f64::from(rays)
}

/// With a single light nothing is random: every sample is the quadrature's value, whatever the
/// sampler, and that is not the light's.
#[test]
fn center_and_grid_are_quadratures() {
    let context = context();
    let exact = stratified_moments(1, 1).0;
    for (pattern, rays, points) in [
        (ShadowPattern::Center, 1, 1),
        (ShadowPattern::Center, 5, 1),
        (ShadowPattern::Grid, 1, 1),
        (ShadowPattern::Grid, 4, 4),
        (ShadowPattern::Grid, 7, 7),
        (ShadowPattern::Grid, 12, 12),
    ] {
        for sampler in [Sampler::Independent, Sampler::Sobol] {
            let mut scene = with_rays(square_over_floor(), rays, pattern);
            scene.film = floor_pixel().film;
            // So that what the pixel sees does not vary either.
            scene.camera.projection = Projection::Perspective { fov_y: 1e-9 };
            scene.render.estimator.sampler = sampler;
            let pixel = render(context, scene.clone()).pixels[0];
            let expected = FACTOR * quadrature(points);
            let what = format!("{pattern}, {rays} rays, {sampler}: {pixel:?} for {expected}");
            assert!((pixel.mean[0] / expected - 1.0).abs() < 1e-5, "{what}");
            assert!(pixel.m2[0].sqrt() < 1e-5 * expected, "{what}");
            assert!((quadrature(points) / exact - 1.0).abs() > 1e-3, "{what}");
            let bias = prepared(scene).bias().unwrap();
            assert!(bias.contains("shadow_pattern = \""), "{bias}");
        }
    }
}

/// With two lights every point of the grid meets both of them alike, in every pixel and with every
/// sampler: the image converges to the sum of the lights' quadratures.
#[test]
fn every_point_of_a_grid_meets_every_light() {
    let context = context();
    let rays = 4;
    // From x, so wide, at height 1.
    let squares = [(-1.2, 1.0), (0.2, 2.0)];
    let points = [0.25, 0.75].map(|s| [0.25, 0.75].map(|t| DVec2::new(s, t)));
    let of_square = |(x, width): (f64, f64)| {
        let value = |u: &DVec2| {
            let at = DVec2::new(x + width * u.x, u.y - 0.5);
            width * (1.0 + at.length_squared()).powi(-2)
        };
        points.as_flattened().iter().map(value).sum::<f64>() / 4.0
    };
    let expected = FACTOR * squares.map(of_square).iter().sum::<f64>();
    for sampler in [
        Sampler::Independent,
        Sampler::Stratified,
        Sampler::Sobol,
        Sampler::BlueNoise,
    ] {
        let mut scene = with_rays(floor_pixel(), rays, ShadowPattern::Grid);
        for (x, width) in squares {
            let square = Geometry::Rectangle {
                corner: DVec3::new(x, -0.5, 1.0),
                u: DVec3::Y,
                v: width * DVec3::X,
            };
            scene.shapes.push(emitter(square, RADIANCE, false));
        }
        scene.render.estimator.strategy = Strategy::LightArea;
        scene.render.estimator.sampler = sampler;
        scene.render.estimator.light_selection = LightSelection::Uniform;
        scene.render.stop.spp = 1 << 14;
        let film = render(context, scene);
        assert_pixel(&film, expected, &format!("grid over two lights, {sampler}"));
    }
}

/// Lights below the horizon get no ray, so that nothing but the loop over the rays, or over the
/// lights, runs: over 256 samples 2¹⁸ times and more, which is beyond what Mesa 22's lavapipe
/// grants an invocation (65,535). The kernel notices that the loop was cut and goes on: no sample
/// is short of its last light.
#[test]
fn cut_loops_lose_no_shadow_ray() {
    let context = context();
    for (below, rays, pattern, selection) in [
        (63, 1024, ShadowPattern::Stratified, LightSelection::Uniform),
        (5_000, 1, ShadowPattern::Random, LightSelection::All),
    ] {
        let mut scene = with_rays(floor_pixel(), rays, pattern);
        let light = |z: f64| point_light(DVec3::new(0.0, 0.0, z), 8.0);
        scene.lights = vec![light(-1.0); below];
        scene.lights.push(light(2.0));
        scene.render.estimator.light_selection = selection;
        let prepared = prepared(scene);
        let mut session = Session::new(context, &prepared, prepared.film, 0).unwrap();
        session.pass(256, || false).unwrap();
        let (film, _) = session.snapshot().unwrap();
        let pixel = &film.pixels[0];
        let what = format!("{selection}: {pixel:?}, {:?}", context.adapter);
        assert_eq!(pixel.samples, 256, "{what}");
        let expected = 0.5 / PI * 8.0 / 4.0;
        assert!((pixel.mean[0] / expected - 1.0).abs() < 1e-5, "{what}");
        assert!(pixel.m2[0].sqrt() < 1e-4 * expected, "{what}");
        let limited = !direkt::low_level::gpu::doctor::loops::loop_budget(context)
            .unwrap()
            .is_unlimited();
        assert_eq!(session.dispatches > 1, limited, "{what}");
    }
}

/// What makes no difference is not compiled in: a second ray that would be the first again, a
/// pattern of points that are not there, a choice among one light.
#[test]
fn only_what_makes_a_difference_is_called_for() {
    let (points, _) = four_lights();
    let mut point = points.clone();
    point.lights.truncate(1);
    let square = square_over_floor();
    let both = {
        let mut both = points.clone();
        both.shapes.push(emitter(unit_square(), 1.0, false));
        both
    };
    let effects = [
        Effect::LightChoice,
        Effect::AllLights,
        Effect::ShadowRays,
        Effect::CenterPattern,
        Effect::GridPattern,
        Effect::StratifiedPattern,
    ];
    use LightSelection::{All, Power};
    use ShadowPattern::{Center, Grid, Random, Stratified};
    for (name, scene, rays, pattern, selection, expected) in [
        ("a point", &point, 4, Random, Power, &[][..]),
        ("a point", &point, 4, Stratified, All, &[]),
        ("a point", &point, 4, Grid, Power, &[]),
        ("points", &points, 4, Random, Power, &[0, 2]),
        ("points", &points, 4, Random, All, &[1]),
        ("points", &points, 4, Center, Power, &[0, 2]),
        ("points", &points, 4, Stratified, Power, &[0, 2, 5]),
        ("a square", &square, 1, Random, All, &[]),
        ("a square", &square, 4, Random, All, &[2]),
        ("a square", &square, 4, Center, Power, &[3]),
        ("a square", &square, 1, Grid, Power, &[3]),
        ("a square", &square, 4, Grid, Power, &[2, 4]),
        ("a square", &square, 1, Stratified, Power, &[]),
        ("a square", &square, 4, Stratified, Power, &[2, 5]),
        ("both", &both, 1, Random, Power, &[0]),
        ("both", &both, 1, Random, All, &[1]),
        ("both", &both, 4, Grid, All, &[1, 2, 4]),
    ] {
        let mut scene = with_rays(scene.clone(), rays, pattern);
        scene.render.estimator.light_selection = selection;
        let prepared = prepared(scene);
        let expected: Vec<Effect> = expected.iter().map(|&i: &usize| effects[i]).collect();
        let found = effects
            .into_iter()
            .filter(|&e| prepared.effects.contains(e));
        let what = format!("{name}, {rays} {pattern} rays, {selection}");
        assert_eq!(found.collect::<Vec<_>>(), expected, "{what}");
    }
}
