//! Images of scenes that nobody chose know their own error.

use crate::scene::random_scenes::{random_scene, write_textures};
use crate::support::{context, take};
use direkt::low_level::prepare::Prepared;
use direkt::low_level::render::{Session, StatedError};
use direkt::scene::{FilmSize, Sampler};
use direkt_instruments::cost::error::mean_errors;
use direkt_instruments::cost::reference::Reference;

const SCENES: u64 = 10;
/// Images of each scene, uniform and adaptive.
const IMAGES: u32 = 12;
/// Samples per pixel of the truth, whose seed is another.
const OF_TRUTH: u64 = 4096;

/// What images state, each beside its actual error.
#[derive(Default)]
struct Tally {
    images: f64,
    /// Those that say that they can tell it.
    told: Vec<(StatedError, f64)>,
    /// Those of these that state less than half of it.
    too_small: f64,
}

impl Tally {
    fn add(&mut self, stated: StatedError, actual: f64) {
        self.images += 1.0;
        if stated.doubt.is_none() {
            self.told.push((stated, actual));
            self.too_small += f64::from(u8::from(stated.value < 0.5 * actual));
        }
    }

    fn covered(&self) -> f64 {
        let told = self.told.iter();
        let holds = told.filter(|(e, actual)| e.low <= *actual && *actual <= e.high);
        holds.count() as f64 / self.told.len() as f64
    }
}

/// Ten scenes of the generator at 16 and 64 samples. Where images give an interval, it holds the actual
/// error as often as it says, but for four standard errors; and no more than one in 20 cannot tell that
/// it states less than half.
#[test]
fn errors_hold_on_scenes_that_nobody_chose() {
    let folder = tempfile::tempdir().unwrap();
    write_textures(folder.path());
    let mut tally = Tally::default();
    for seed in 1..=SCENES {
        let mut scene = random_scene(folder.path(), seed);
        scene.film = FilmSize {
            width: 32,
            height: 32,
        };
        let sampler = [Sampler::Sobol, Sampler::Independent][seed as usize % 2];
        scene.render.estimator.sampler = sampler;
        let prepared = Prepared::of(scene);
        let mut session = Session::new(context(), &prepared, prepared.film, 99_991).unwrap();
        take(&mut session, OF_TRUTH);
        let truth = session.snapshot().unwrap().0;
        let mean = truth.mean().iter().sum::<f64>() / 3.0;
        let reference = Reference::exact(truth.pixels.iter().map(|p| p.mean).collect());
        for adaptive in [false, true] {
            session.set_adaptive(adaptive);
            for image in 0..IMAGES {
                session.restart(image, u64::MAX).unwrap();
                for samples in [16, 64] {
                    take(&mut session, samples);
                    let film = session.snapshot().unwrap().0;
                    let stated = film.error().unwrap().nmse;
                    let [mse, _] = mean_errors(&film, &reference);
                    tally.add(stated, mse / (mean * mean));
                }
            }
        }
    }
    let told = tally.told.len() as f64;
    let covered = tally.covered();
    println!(
        "{told} of {} images tell their error, {:.1} % hold it, {} of them are too small by half",
        tally.images,
        100.0 * covered,
        tally.too_small
    );
    assert!(told > 0.5 * tally.images, "{told} of {}", tally.images);
    let deviation = (0.95 * 0.05 / told).sqrt();
    assert!(covered > 0.95 - 4.0 * deviation, "{covered}");
    assert!(
        tally.too_small < 0.05 * told,
        "{} of {told}",
        tally.too_small
    );
}
