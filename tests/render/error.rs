//! Images know their own error: with every sampler, on the GPU.

use crate::support::{context, prepared_for, scene};
use direkt::low_level::render::Session;
use direkt::scene::{FilmSize, LightSelection, RenderSettings, Sampler, Scene, Strategy};
use direkt_instruments::cost::calibrate::{Reported, Settings, calibrate};
use direkt_instruments::cost::estimator::{Choices, combinations};
use std::cell::Cell;

const IMAGES: u32 = 60;

fn cornell() -> Scene {
    let mut cornell = scene("scenes/cornell.toml");
    cornell.film = FilmSize {
        width: 48,
        height: 48,
    };
    cornell
}

fn settings(adaptive: bool) -> Settings {
    let samplers = [
        Sampler::Independent,
        Sampler::Stratified,
        Sampler::Sobol,
        Sampler::BlueNoise,
    ];
    Settings {
        estimators: combinations(&Choices {
            strategies: vec![Strategy::MisPower],
            samplers: samplers.to_vec(),
            adaptive: vec![adaptive],
            ..Choices::of(&RenderSettings::default())
        }),
        images: IMAGES,
        samples: vec![32],
        seed: 40,
    }
}

/// Ctrl-C: what was finished is kept.
#[test]
fn a_calibration_that_is_stopped_has_the_estimators_before() {
    let mut scene = cornell();
    scene.film = FilmSize {
        width: 24,
        height: 16,
    };
    let settings = Settings {
        images: 10,
        ..settings(false)
    };
    let stop = Cell::new(false);
    let second = settings.estimators[1].to_string();
    let mut progress = |what: &str, part: f64| stop.set(what.starts_with(&second) && part > 0.2);
    let stop = || stop.get();
    let found = calibrate(context(), &scene, &settings, &mut progress, &stop).unwrap();
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].estimator, settings.estimators[0]);
}

/// Reported errors are within 10 % of actual ones, intervals hold what they say, and images that
/// stop by themselves are as right as they were told to be. The bounds leave four standard errors
/// of so few images.
fn assert_calibrated(scene: &Scene, settings: &Settings) {
    let found = calibrate(context(), scene, settings, &mut |_, _| {}, &|| false);
    for c in found.unwrap() {
        let off = |value: f64, due: f64| (value - due).abs();
        let of_95 = (0.95_f64 * 0.05 / f64::from(IMAGES)).sqrt();
        for reported in [&c.nmse, &c.rel_mse] {
            assert!(
                off(reported.ratio.value, 1.0) < 0.1 + 4.0 * reported.ratio.standard_error,
                "{c:#?}"
            );
        }
        let covered = |reported: &Reported| reported.coverage.value > 0.93 - 4.0 * of_95;
        assert!(covered(&c.rel_mse), "{c:#?}");
        let stopped = &c.stopped;
        // A few pixels at the lamp's edge may hold most of the NMSE of an image so small. Then it
        // says so, and stops so late that the truth, of fewer samples, cannot judge it.
        if c.nmse.told.value > 0.5 {
            assert!(covered(&c.nmse) && stopped.reached.value > 0.99, "{c:#?}");
        }
        // The truth, the mean of 60 images, has a 60th of their error, and so the part (n/32)^1.5/60
        // of the error of one that stops at n samples: the same in all of them, which their scatter
        // does not show. From an eighth on it cannot judge them.
        let judged = stopped.samples < 4.0 * c.samples as f64;
        if c.nmse.told.value > 0.5 && judged {
            assert!(
                off(stopped.ratio.value, 1.0) < 0.1 + 4.0 * stopped.ratio.standard_error,
                "{c:#?}"
            );
        }
        assert!(stopped.below_target.value > 0.93 - 4.0 * of_95, "{c:#?}");
        for bias in stopped.bias_of_mean {
            assert!(off(bias.value, 0.0) < 4.5 * bias.standard_error, "{c:#?}");
        }
    }
}

#[test]
fn reported_errors_are_the_actual_ones() {
    assert_calibrated(&cornell(), &settings(false));
}

#[test]
fn so_they_are_where_sampling_is_adaptive() {
    assert_calibrated(&cornell(), &settings(true));
}

/// Broken: the scatter of the samples, which takes Sobol points for independent ones.
#[test]
fn the_scatter_of_sobol_points_is_not_their_error() {
    let mut scene = cornell();
    scene.render.estimator.sampler = Sampler::Sobol;
    let prepared = prepared_for(scene, Strategy::MisPower, LightSelection::Power);
    let context = context();
    let mut session = Session::new(context, &prepared, prepared.film, 41).unwrap();
    session.pass(64, || false).unwrap();
    let film = session.snapshot().unwrap().0;
    let sum = |variances: &mut dyn Iterator<Item = [f64; 3]>| variances.map(|v| v[1]).sum::<f64>();
    let scatter = sum(&mut film.pixels.iter().map(|p| p.variance_of_mean().unwrap()));
    let told = sum(&mut film.variances().unwrap().into_iter());
    assert!(scatter > 2.0 * told, "{scatter} {told}");
    let (of_scatter, of_replicates) = (
        film.independent_standard_error_of_mean().unwrap()[1],
        film.standard_error_of_mean().unwrap()[1],
    );
    assert!(of_scatter > 1.4 * of_replicates);
}
