//! `cost::measure` when it is asked to stop.

use crate::support::{context, scene};
use direkt::scene::{FilmSize, RenderSettings, Sampler, Strategy};
use direkt_instruments::cost::estimator::{Choices, combinations};
use direkt_instruments::cost::{SceneCost, Settings, measure};
use direkt_instruments::report::machine::Machine;
use direkt_instruments::report::write;
use std::cell::Cell;

/// The cost of estimators, stopped as soon as the progress says `at`.
fn stopped_at(at: &str, strategies: &[Strategy], budget: f64) -> Option<SceneCost> {
    let mut cornell = scene("scenes/cornell.toml");
    cornell.film = FilmSize {
        width: 24,
        height: 16,
    };
    let settings = Settings {
        estimators: combinations(&Choices {
            strategies: strategies.to_vec(),
            samplers: vec![Sampler::Sobol],
            ..Choices::of(&RenderSettings::default())
        }),
        budget,
        target: 1e-3,
        reference: None,
        seed: 1,
    };
    let stop = Cell::new(false);
    let mut progress = |what: &str, _: f64| stop.set(stop.get() || what == at);
    measure(context(), &cornell, &settings, &mut progress, &|| {
        stop.get()
    })
    .unwrap()
}

#[test]
fn without_the_least_counts_there_is_no_result() {
    for at in [
        "compiling light-area · sobol · auto · adaptive",
        "compiling the reference",
        "reference",
        "1 samples per pixel",
        "4 samples per pixel",
    ] {
        assert!(
            stopped_at(at, &[Strategy::LightArea], 60.0).is_none(),
            "stopped at `{at}`"
        );
    }
}

/// What is complete is told, what is not is left out.
#[test]
fn a_stopped_measurement_tells_what_it_has() {
    let two = [Strategy::LightArea, Strategy::Bsdf];
    let cost = stopped_at("8 samples per pixel", &two, 1.0).unwrap();
    assert!(cost.interrupted && cost.seconds < cost.budget);
    for e in &cost.estimators {
        let samples: Vec<u64> = e.points.iter().map(|p| p.samples).collect();
        assert_eq!(samples, [1, 2, 4]);
        assert!(e.equal_time.is_none() && e.efficiency.value > 0.0);
    }
    let folder = tempfile::tempdir().unwrap();
    write(
        folder.path(),
        &[cost],
        &[],
        &Machine::this(&context().adapter),
    )
    .unwrap();
    let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert!(page.contains("<b>interrupted</b> before the 1.00 s that were allowed"));
    assert!(!page.contains("Where the error is") && !page.contains("<img"));

    let cost = stopped_at("images at equal time", &two, 1.0).unwrap();
    assert!(cost.interrupted);
    assert!(
        cost.estimators
            .iter()
            .all(|e| e.points.len() > 3 && e.equal_time.is_none())
    );

    let cost = stopped_at("never", &two, 1.0).unwrap();
    assert!(!cost.interrupted);
    assert!(cost.estimators.iter().all(|e| e.equal_time.is_some()));
}
