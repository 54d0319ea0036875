//! Every strategy estimates the same integral.

use crate::support::{STRATEGIES, context, own_scenes, render};
use direkt::render::Film;
use direkt::scene::{FilmSize, LightSelection, Scene};

/// Two-sided normal bound for a family-wise false alarm of 1e-4 over up to 100 comparisons: Φ⁻¹(1 − 1e-4/200).
const BOUND: f64 = 4.89;

fn small(mut scene: Scene) -> Scene {
    scene.film = FilmSize { width: 96, height: 72 };
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
            assert!(z < BOUND, "{what} differ by {z:.2} standard errors on {}", context.adapter.name);
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
        assert!(z < BOUND, "{name}: uniform and power differ by {z:.2} standard errors");
    }
}

/// The comparison must be able to fail: a light 2 % too bright is a difference that it sees.
#[test]
fn a_bias_of_two_percent_is_rejected() {
    let context = context();
    let (_, cornell) = own_scenes().into_iter().find(|(name, _)| name == "cornell.toml").unwrap();
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

/// Four times the samples, a quarter of the variance.
#[test]
fn variance_falls_with_the_number_of_samples() {
    let context = context();
    let (_, cornell) = own_scenes().into_iter().find(|(name, _)| name == "cornell.toml").unwrap();
    let error_at = |spp| {
        let mut scene = small(cornell.clone());
        scene.render.spp = spp;
        render(&context, scene).error().expect("the image is not black").rel_mse
    };
    let slope = (error_at(1024) / error_at(64)).ln() / 16_f64.ln();
    assert!((slope + 1.0).abs() < 0.05, "slope of variance against samples: {slope:.3}");
}
