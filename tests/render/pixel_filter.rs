//! Images of an edge, which show the integral of the pixel filter.

use crate::support::{context, emitter, floor_pixel, render, shape, statistics};
use direkt::low_level::render::Film;
use direkt::low_level::stats::z_test::z_test;
use direkt::scene::filter::FilterKind;
use direkt::scene::{Camera, FilmSize, Geometry, PixelFilter, Projection, Sampler, Scene};
use glam::DVec3;

/// Where the light begins, in pixels from the left edge.
const EDGE: f64 = 4.3;
const PIXELS: u32 = 9;

/// A row of pixels of side 1, straight above a light that covers what lies to the right of
/// [`EDGE`].
fn edge(filter: PixelFilter, sampler: Sampler) -> Scene {
    let mut scene = floor_pixel();
    let half = 0.5 * f64::from(PIXELS);
    scene.camera = Camera {
        projection: Projection::Orthographic { height: 1.0 },
        ..Camera::look_at(
            DVec3::new(half, 0.0, 1.0),
            DVec3::new(half, 0.0, 0.0),
            DVec3::Y,
            1.0,
        )
        .unwrap()
    };
    scene.film = FilmSize {
        width: PIXELS,
        height: 1,
    };
    let light = Geometry::Rectangle {
        corner: DVec3::new(EDGE, -50.0, 0.0),
        u: DVec3::new(100.0, 0.0, 0.0),
        v: DVec3::new(0.0, 100.0, 0.0),
    };
    let wall = Geometry::Rectangle {
        corner: DVec3::new(EDGE - 100.0, -50.0, 0.0),
        u: DVec3::new(100.0, 0.0, 0.0),
        v: DVec3::new(0.0, 100.0, 0.0),
    };
    scene.shapes = vec![emitter(light, 1.0, false), shape("wall", wall)];
    scene.filter = filter;
    scene.render.estimator.sampler = sampler;
    scene.render.stop.spp = 1 << 16;
    scene
}

/// The part of the filter's integral to the right of `x`, by the rectangle rule in many steps.
fn beyond(filter: PixelFilter, x: f64) -> f64 {
    let steps = 40_000;
    let width = 2.0 * filter.radius / f64::from(steps);
    let (mut above, mut whole) = (0.0, 0.0);
    for i in 0..steps {
        let at = -filter.radius + (f64::from(i) + 0.5) * width;
        let value = filter.value(at.abs());
        whole += value;
        above += if at > x { value } else { 0.0 };
    }
    above / whole
}

/// Per pixel, the p-value of the number of samples on the light.
fn p_values(film: &Film, filter: PixelFilter) -> Vec<f64> {
    let pixels = film.pixels.iter().enumerate();
    let p_value = pixels.map(|(i, pixel)| {
        let expected = beyond(filter, EDGE - (i as f64 + 0.5));
        let variance = expected * (1.0 - expected) / pixel.samples as f64;
        // The rectangle rule's steps, and a table's cells.
        z_test(pixel.mean[0], expected, variance, 1e-4).p_value
    });
    p_value.collect()
}

#[test]
fn an_edge_shows_the_filters_integral() {
    use clap::ValueEnum;
    let context = context();
    for &kind in FilterKind::value_variants() {
        for radius in [PixelFilter::of_kind(kind).radius, 1.0, 3.0] {
            let filter = PixelFilter {
                radius,
                ..PixelFilter::of_kind(kind)
            };
            let film = render(context, edge(filter, Sampler::Independent));
            let what = format!("edge under {filter:?}, {}", context.adapter.name);
            for (i, p) in p_values(&film, filter).into_iter().enumerate() {
                statistics::accept(p, &format!("{what}, pixel {i}"));
            }
            let wider = PixelFilter {
                radius: 1.1 * radius,
                stddev: 1.1 * filter.stddev,
                ..filter
            };
            let least = p_values(&film, wider).into_iter().fold(1.0, f64::min);
            statistics::reject(least, &format!("{what}, a filter that is 10 % wider"));
        }
    }
}

/// Filters draw places one after the other: a sampler's stratification of the film goes with them.
#[test]
fn filters_keep_the_stratification() {
    let context = context();
    let filter = PixelFilter::of_kind(FilterKind::Gaussian);
    let error = |sampler: Sampler| -> f64 {
        let film = render(context, edge(filter, sampler));
        let pixels = film.pixels.iter().enumerate();
        let off = pixels.map(|(i, p)| p.mean[0] - beyond(filter, EDGE - (i as f64 + 0.5)));
        off.map(|x| x * x).sum()
    };
    let (independent, sobol) = (error(Sampler::Independent), error(Sampler::Sobol));
    assert!(sobol < 0.1 * independent, "{sobol:e}, {independent:e}");
}
