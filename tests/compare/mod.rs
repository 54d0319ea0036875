//! `compare`: GPU and reference agree on every scene, and every broken twin is found out.

mod exact;
mod power;
mod scenes;

use crate::support::{context, prepared_for};
use direkt::low_level::reference::BrokenTwin;
use direkt::scene::{FilmSize, Scene, Strategy};
use direkt_instruments::compare::{Comparison, Settings, compare};

/// Compares `scene` under `strategy`, its image scaled to at most `pixels` pixels.
fn compared(
    scene: &Scene,
    strategy: Strategy,
    (pixels, samples): (u32, u64),
    broken: Option<BrokenTwin>,
) -> Comparison {
    let context = context();
    let prepared = prepared_for(
        scene.clone(),
        strategy,
        scene.render.estimator.light_selection,
    );
    let settings = Settings {
        film: scaled(scene.film, pixels),
        samples,
        seed: 0,
        broken,
        exact: false,
    };
    compare(context, &prepared, &settings, |_| ()).unwrap()
}

fn scaled(film: FilmSize, pixels: u32) -> FilmSize {
    let factor = (f64::from(pixels) / film.pixels() as f64).sqrt().min(1.0);
    let side = |n: u32| (f64::from(n) * factor) as u32;
    FilmSize {
        width: side(film.width),
        height: side(film.height),
    }
}
