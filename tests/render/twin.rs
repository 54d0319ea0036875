//! Pixel by pixel and as a whole, every strategy against its twin with random numbers of its own.
//!
//! Pairs of samples of one strategy are exchangeable, so that the test of their differences holds
//! for tails of any weight. Pairs of different strategies are not: BSDF sampling that has not met a
//! small light yet is dark in all its samples. Pixels of different strategies are therefore
//! compared through their twins.

use crate::support::{KINDS_OF_STRATEGIES, context, own_scenes, prepared_for, scene, statistics};
use direkt::low_level::gpu::recorder::Recorder;
use direkt::low_level::reference::Twin;
use direkt::low_level::reference::broken::{BROKEN_TWINS, BrokenTwin};
use direkt::scene::{FilmSize, LightSelection, ShadowRays};
use direkt_instruments::compare::per_pixel::{Accumulator, PerPixel};
use direkt_instruments::compare::whole_image::WholeImage;
use std::collections::BTreeMap;

const FILM: FilmSize = FilmSize {
    width: 48,
    height: 36,
};
/// Enough that 64 pairs of equal sign reject: 2·exp(−n/2) times the number of pixels is 3·10⁻¹⁷ for 96.
const SAMPLES: u64 = 96;

/// p-value of the worst pixel among all (Šidák).
fn worst_pixel(sums: &Accumulator) -> f64 {
    let pixels = PerPixel::new(sums);
    let p = pixels.worst.map_or(1.0, |w| w.p_value);
    -(pixels.tests as f64 * (-p).ln_1p()).exp_m1()
}

/// p-values of the channels' means.
fn means(sums: &Accumulator) -> [f64; 3] {
    WholeImage::new(sums).channels.map(|c| c.p_value)
}

#[test]
fn pixels_and_means_are_the_twins() {
    let context = context();
    // Per mistake the smallest p-values over all scenes and strategies: some show in few.
    let mut smallest = BTreeMap::new();
    let mut scenes = own_scenes();
    let mut sky = scene("scenes/tests/sky.toml");
    sky.render.estimator.shadow_rays = ShadowRays::Number(4);
    scenes.push(("sky.toml with 4 shadow rays".to_owned(), sky));
    for (name, scene) in scenes {
        for strategy in KINDS_OF_STRATEGIES {
            let prepared = prepared_for(scene.clone(), strategy, LightSelection::Power);
            let recorder = Recorder::new(context, &prepared, FILM, 60).unwrap();
            let records: Vec<_> = (0..SAMPLES).map(|i| recorder.samples(i).unwrap()).collect();
            let against = |broken: Option<BrokenTwin>| {
                let twin = Twin::new(&prepared, FILM, 61, broken);
                let mut sums = Accumulator::new(FILM);
                for (i, gpu) in (0..).zip(&records) {
                    sums.add(gpu, &twin.samples(i));
                }
                sums
            };
            let what = format!(
                "{name}, {strategy}, seeds 60 and 61, {}",
                context.adapter.name
            );
            let honest = against(None);
            statistics::accept(worst_pixel(&honest), &format!("{what}, worst pixel"));
            for p in means(&honest) {
                statistics::accept(p, &format!("{what}, image"));
            }
            for row in BROKEN_TWINS.iter().filter(|row| (row.applies)(&prepared)) {
                let sums = against(Some(row.twin));
                let p = [
                    worst_pixel(&sums),
                    means(&sums).into_iter().fold(1.0, f64::min),
                ];
                let best = smallest.entry(row.name).or_insert((row.twin, [1.0_f64; 2]));
                best.1 = [best.1[0].min(p[0]), best.1[1].min(p[1])];
            }
        }
    }
    assert_eq!(smallest.len(), BROKEN_TWINS.len());
    for (name, (twin, [pixel, image])) in smallest {
        statistics::reject(pixel, &format!("pixels of all scenes, {name}"));
        match twin {
            BrokenTwin::LightLeftOut | BrokenTwin::ExtraCosine | BrokenTwin::OpaqueShadows => {
                statistics::reject(image, &format!("means of all scenes, {name}"));
            }
            // Of so few samples the means do not tell; those of `strategies.rs` do.
            BrokenTwin::PdfScaled
            | BrokenTwin::WrongMeasure
            | BrokenTwin::SwappedSinCos
            | BrokenTwin::MisWeights
            | BrokenTwin::RaysForgotten => {}
        }
    }
}
