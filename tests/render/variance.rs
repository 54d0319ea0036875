//! The variance is the exact one over the number of samples.

use crate::support::twin::{Part, twin_film};
use crate::support::{STRATEGIES, context, emitter, floor_pixel, render, statistics, unit_square};
use direkt::low_level::prepare::Prepared;
use direkt::low_level::reference::broken::{BROKEN_TWINS, BrokenTwin};
use direkt::low_level::render::Film;
use direkt::low_level::stats::moments::Moments;
use direkt::low_level::stats::t_test::one_sample;
use direkt::low_level::stats::z_test::z_test;
use direkt::scene::Projection;
use direkt::scene::{FilmSize, Geometry, Scene, Strategy};
use glam::DVec3;

const RADIANCE: f64 = 10.0;
/// Under the square, ρ = ½ (HARD CASES H).
const EXACT: f64 = 1.197_282_352_303_87;
/// Of one sample: area sampling of a unit square at distance 1 has the variance 0.0171781413180395
/// in E (HARD CASES E).
const VARIANCE: f64 = 0.017_178_141_318_039_5;
/// Samples per pixel.
const LEVELS: [u64; 3] = [4, 16, 64];

/// 64 × 64 pixels that all see the same point of the floor, under a unit square at height 1.
fn square_over_floor() -> Scene {
    let mut scene = floor_pixel();
    scene.film = FilmSize {
        width: 64,
        height: 64,
    };
    scene.shapes.push(emitter(unit_square(), RADIANCE, false));
    scene.render.estimator.strategy = Strategy::LightArea;
    scene
}

/// Squared errors of the pixels, in units of the exact variance of one sample.
fn squares(film: &Film) -> Moments {
    let factor = RADIANCE * 0.5 / std::f64::consts::PI;
    let exact = factor * factor * VARIANCE;
    film.pixels
        .iter()
        .map(|p| (p.mean[0] - EXACT).powi(2) / exact)
        .collect()
}

/// p-value of the squared errors' mean being 1/N, from their own spread over the pixels, which are
/// independent.
fn level_p_value(film: &Film, samples: u64) -> f64 {
    one_sample(&squares(film), 1.0 / samples as f64)
        .unwrap()
        .p_value
}

/// Slope of ln(mean squared error) against ln N over the first and last level, and its variance.
/// Independent films; the logarithm's variance is that of the mean over its square.
fn slope(first: &Film, last: &Film) -> (f64, f64) {
    let [a, b] = [squares(first), squares(last)];
    let span = (LEVELS[2] as f64 / LEVELS[0] as f64).ln();
    let relative = |m: &Moments| m.variance_of_mean().unwrap() / (m.mean * m.mean);
    let slope = (b.mean / a.mean).ln() / span;
    (slope, (relative(&a) + relative(&b)) / (span * span))
}

/// p-value of the slope being −1.
fn slope_p_value(first: &Film, last: &Film) -> f64 {
    let (slope, variance) = slope(first, last);
    z_test(slope, -1.0, variance, 0.0).p_value
}

#[test]
fn variance_is_the_exact_one_over_the_number_of_samples() {
    let context = context();
    let films = LEVELS.map(|spp| {
        let mut scene = square_over_floor();
        scene.render.stop.spp = spp;
        scene.render.seed = spp as u32;
        render(context, scene)
    });
    for (film, spp) in films.iter().zip(LEVELS) {
        let what = format!(
            "mean squared error at {spp} samples, {}",
            context.adapter.name
        );
        statistics::accept(level_p_value(film, spp), &what);
        // What the film reports of itself has the same mean: its pixels' variances are unbiased.
        let factor = RADIANCE * 0.5 / std::f64::consts::PI;
        let exact = factor * factor * VARIANCE / spp as f64;
        let reported = film
            .pixels
            .iter()
            .filter_map(|p| Some(p.variance_of_mean()?[0]));
        let reported: Moments = reported.collect();
        let p = one_sample(&reported, exact).unwrap().p_value;
        statistics::accept(
            p,
            &format!(
                "reported variance at {spp} samples, {}",
                context.adapter.name
            ),
        );
    }
    statistics::accept(slope_p_value(&films[0], &films[2]), "slope of the error");
}

/// Under every strategy that has a variance there: slopes within 0.03 of −1, known five times as
/// well.
#[test]
fn the_variance_of_every_strategy_falls_with_the_number_of_samples() {
    let context = context();
    for strategy in STRATEGIES {
        let film = |spp: u64| {
            let mut scene = square_over_floor();
            scene.film.width = 192;
            scene.film.height = 192;
            scene.render.estimator.strategy = strategy;
            scene.render.stop.spp = spp;
            scene.render.seed = 50 + spp as u32;
            render(context, scene)
        };
        let [first, last] = [LEVELS[0], LEVELS[2]].map(film);
        if strategy == Strategy::LightProjectedSolidAngle {
            let off = first.pixels.iter().map(|p| (p.mean[0] / EXACT - 1.0).abs());
            assert!(off.fold(0.0, f64::max) < 1e-5, "no variance but rounding");
            continue;
        }
        let (slope, variance) = slope(&first, &last);
        assert!(5.0 * variance.sqrt() < 0.03, "{strategy}: {variance}");
        assert!((slope + 1.0).abs() < 0.03, "{strategy}: {slope}");
    }
}

#[test]
fn biased_twins_do_not_have_the_exact_variance() {
    let scene = square_over_floor();
    let size = scene.film;
    let prepared = Prepared::of(scene);
    for row in BROKEN_TWINS.iter().filter(|row| (row.applies)(&prepared)) {
        let films = [LEVELS[0], LEVELS[2]].map(|spp| {
            twin_film(
                &prepared,
                (size, 100 + spp as u32, spp),
                Part::All,
                Some(row.twin),
            )
        });
        match row.twin {
            // A bias stays where the variance falls.
            BrokenTwin::PdfScaled
            | BrokenTwin::WrongMeasure
            | BrokenTwin::ExtraCosine
            | BrokenTwin::SwappedSinCos
            | BrokenTwin::LightLeftOut => {
                statistics::reject(level_p_value(&films[1], LEVELS[2]), row.name);
                statistics::reject(slope_p_value(&films[0], &films[1]), row.name);
            }
            // It is about sampling the BSDF as well, which does not happen here.
            BrokenTwin::MisWeights | BrokenTwin::RaysForgotten | BrokenTwin::OpaqueShadows => {
                unreachable!("{}", row.name)
            }
        }
    }
}

/// A polygon light that is seen as a whole has no variance over its projected solid angle, whatever
/// it is: each sample is ρ·L·F, up to f32's rounding. Over its solid angle it has the cosine's.
#[test]
fn projected_solid_angle_leaves_no_variance() {
    let context = context();
    for distance in [0.01, 0.1, 1.0] {
        let mut scene = floor_pixel();
        let wall = Geometry::Rectangle {
            corner: DVec3::new(-distance, -0.5, 0.0),
            u: DVec3::new(0.0, 0.0, 1.0),
            v: DVec3::new(0.0, 1.0, 0.0),
        };
        scene.shapes.push(emitter(wall, 1.0, true));
        scene.render.stop.spp = 256;
        // So that what the pixel sees does not vary either.
        scene.camera.projection = Projection::Perspective { fov_y: 1e-9 };
        let relative = |strategy: Strategy| {
            let mut scene = scene.clone();
            scene.render.estimator.strategy = strategy;
            let pixel = render(context, scene).pixels[0];
            (pixel.m2[0] / 255.0).sqrt() / pixel.mean[0]
        };
        let projected = relative(Strategy::LightProjectedSolidAngle);
        assert!(projected < 1e-5, "wall at {distance}: {projected:.1e}");
        let solid_angle = relative(Strategy::LightSolidAngle);
        assert!(solid_angle > 0.1, "wall at {distance}: {solid_angle:.1e}");
    }
}
