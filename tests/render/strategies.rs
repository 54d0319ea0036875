//! Every strategy estimates the same integral.

use crate::support::{
    STRATEGIES, context, emitter, floor_pixel, own_scenes, render, scene, unit_square,
};
use direkt::render::Film;
use direkt::scene::{FilmSize, LightSelection, Scene, Strategy};

/// Two-sided normal bound for a family-wise false alarm of 1e-4 over up to 100 comparisons: Φ⁻¹(1 − 1e-4/200).
const BOUND: f64 = 4.89;

fn small(mut scene: Scene) -> Scene {
    scene.film = FilmSize {
        width: 96,
        height: 72,
    };
    scene.render.spp = 256;
    scene
}

/// Whether the image means of two independent renders differ by less than `BOUND` standard errors, in every channel.
fn worst_z(a: &Film, b: &Film) -> f64 {
    let (mean_a, mean_b) = (a.mean(), b.mean());
    let error = |film: &Film| film.standard_error_of_mean().expect("two samples or more");
    let (error_a, error_b) = (error(a), error(b));
    let z = (0..3).map(|c| {
        let sigma = error_a[c].hypot(error_b[c]);
        let rounding = 1e-5 * mean_a[c].abs();
        ((mean_a[c] - mean_b[c]).abs() - rounding).max(0.0) / sigma.max(1e-30)
    });
    z.fold(0.0, f64::max)
}

#[test]
fn strategies_agree_on_every_scene() {
    let context = context();
    for (name, scene) in own_scenes() {
        let films = STRATEGIES.map(|strategy| {
            let mut scene = small(scene.clone());
            scene.render.strategy = strategy;
            scene.render.seed = strategy as u32;
            render(&context, scene)
        });
        for (i, j) in [(0, 1), (0, 2), (1, 2)] {
            let z = worst_z(&films[i], &films[j]);
            let what = format!("{name}: {} and {}", STRATEGIES[i], STRATEGIES[j]);
            assert!(
                z < BOUND,
                "{what} differ by {z:.2} standard errors on {}",
                context.adapter.name
            );
            assert_eq!(films[i].ledger.dropped, 0, "{what}");
        }
    }
}

#[test]
fn light_selection_does_not_change_the_mean() {
    let context = context();
    for (name, scene) in own_scenes() {
        let films = [LightSelection::Uniform, LightSelection::Power].map(|selection| {
            let mut scene = small(scene.clone());
            scene.render.light_selection = selection;
            scene.render.seed = 7 + selection as u32;
            render(&context, scene)
        });
        let z = worst_z(&films[0], &films[1]);
        assert!(
            z < BOUND,
            "{name}: uniform and power differ by {z:.2} standard errors"
        );
    }
}

/// The Cornell box's image mean, by another renderer at 8,192 samples per pixel (Mitsuba 3.9.1, `direct`, box filter),
/// which is known to five digits.
#[test]
fn cornells_image_mean_is_the_reference_mean() {
    let mut cornell = scene("scenes/cornell.toml");
    cornell.render.spp = 32;
    cornell.render.strategy = Strategy::LightArea;
    let film = render(&context(), cornell);
    let (mean, error) = (film.mean(), film.standard_error_of_mean().unwrap());
    for (c, reference) in [0.16392, 0.11420, 0.05207].into_iter().enumerate() {
        let bound = 4.5 * error[c] + 5e-6;
        assert!(
            bound < 2.5e-3 * reference,
            "channel {c}: the bound {bound:.1e} must be sharp"
        );
        assert!(
            (mean[c] - reference).abs() < bound,
            "channel {c}: {} against {reference}",
            mean[c]
        );
    }
}

/// The comparison must be able to fail: a light 2 % too bright is a difference that it sees.
#[test]
fn a_bias_of_two_percent_is_rejected() {
    let context = context();
    let (_, cornell) = own_scenes()
        .into_iter()
        .find(|(name, _)| name == "cornell.toml")
        .unwrap();
    let honest = render(&context, small(cornell.clone()));
    let mut biased = small(cornell);
    biased.render.seed = 1;
    for shape in &mut biased.shapes {
        if let Some(emission) = &mut shape.emission {
            emission.radiance *= 1.02;
        }
    }
    let z = worst_z(&honest, &render(&context, biased));
    assert!(z > BOUND, "2 % of bias is only {z:.2} standard errors");
}

/// Area sampling of a unit square at distance 1 has the variance 0.0171781413180395 in E (section E of HARD CASES).
/// The mean squared error over 4,096 independent pixels is that variance over N, for every N: its own relative
/// standard deviation is √(2/4096) for nearly normal pixels, and 4.5 of them are allowed. At N = 4 the pixels' excess
/// kurtosis, at most 3/N for a bounded sample, widens it by less than a factor 1.2.
#[test]
fn variance_is_the_exact_one_over_the_number_of_samples() {
    let context = context();
    let (radiance, reflectance) = (10.0, 0.5);
    let expected = 1.197_282_352_303_87;
    let factor: f64 = radiance * reflectance / std::f64::consts::PI;
    for spp in [4, 16, 64] {
        let mut scene = unit_square_over_floor(radiance);
        scene.render.strategy = Strategy::LightArea;
        scene.render.spp = spp;
        let film = render(&context, scene);
        let squares = film.pixels.iter().map(|p| (p.mean[0] - expected).powi(2));
        let mse = squares.sum::<f64>() / film.pixels.len() as f64;
        let exact = factor * factor * 0.017_178_141_318_039_5 / spp as f64;
        let bound = 4.5 * 1.2 * (2.0_f64 / 4096.0).sqrt();
        let ratio = mse / exact;
        assert!(
            (ratio - 1.0).abs() < bound,
            "{spp} spp: error over exact variance {ratio:.3}, bound {bound:.3}"
        );
        // The error that the film reports of itself is the same.
        let reported = film
            .pixels
            .iter()
            .filter_map(|p| Some(p.variance_of_mean()?[0]));
        let reported = reported.sum::<f64>() / film.pixels.len() as f64 / exact;
        assert!(
            (reported - 1.0).abs() < bound,
            "{spp} spp: reported over exact variance {reported:.3}"
        );
    }
}

/// 64 × 64 pixels that all see the same point of the floor, under a unit square at height 1.
fn unit_square_over_floor(radiance: f64) -> Scene {
    let mut scene = floor_pixel();
    scene.film = FilmSize {
        width: 64,
        height: 64,
    };
    scene.shapes.push(emitter(unit_square(), radiance, false));
    scene
}
