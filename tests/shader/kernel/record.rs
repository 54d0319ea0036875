//! `shaders/kernel/record.wesl`: what it records is what a render accumulates.

use crate::support::{KINDS_OF_STRATEGIES, context, own_scenes, prepared_for};
use direkt::low_level::gpu::layout::{NONE, SampleRecord};
use direkt::low_level::gpu::recorder::Recorder;
use direkt::low_level::render::{Session, StopReason};
use direkt::low_level::stats::moments::Moments;
use direkt::scene::{FilmSize, LightSelection, Strategy};
use direkt_instruments::compare::accumulation::TOLERANCE;

const SAMPLES: u64 = 8;
const FILM: FilmSize = FilmSize {
    width: 63,
    height: 65,
};

/// Mean and squares of every pixel, from records and from the film. [`TOLERANCE`] is that of a
/// block of 256 samples.
#[test]
fn recorded_samples_make_the_film() {
    let context = context();
    for (name, scene) in own_scenes() {
        for strategy in KINDS_OF_STRATEGIES {
            let prepared = prepared_for(scene.clone(), strategy, LightSelection::Power);
            let recorder = Recorder::new(context, &prepared, FILM, 33).unwrap();
            let records: Vec<_> = (0..SAMPLES).map(|i| recorder.samples(i).unwrap()).collect();
            let mut session = Session::new(context, &prepared, FILM, 33).unwrap();
            assert_eq!(session.pass(SAMPLES, || false).unwrap(), StopReason::Done);
            let film = session.snapshot().unwrap().0;
            for (i, pixel) in film.pixels.iter().enumerate() {
                for channel in 0..3 {
                    let of_sample = |r: &Vec<SampleRecord>| f64::from(r[i].radiance[channel]);
                    let values: Vec<f64> = records.iter().map(of_sample).collect();
                    let largest = values.iter().copied().fold(0.0, f64::max);
                    let expected: Moments = values.into_iter().collect();
                    let off = (pixel.mean[channel] - expected.mean).abs();
                    let off_m2 = (pixel.m2[channel] - expected.m2).abs();
                    assert!(
                        off <= TOLERANCE * largest
                            && off_m2 <= TOLERANCE * largest * largest * SAMPLES as f64,
                        "{}, {name}, {strategy}: pixel {i} is {pixel:?}, not {expected:?}",
                        context.adapter.name
                    );
                }
            }
        }
    }
}

/// The radiance of a surface that does not emit is the sum of its parts, and what met nothing has
/// none; but for lights that are sampled in view.
#[test]
fn parts_add_up() {
    let context = context();
    for (name, scene) in own_scenes() {
        let prepared = prepared_for(scene, Strategy::MisPower, LightSelection::Power);
        let prepared = prepared.with_lights_in_view_by_chance();
        let recorder = Recorder::new(context, &prepared, FILM, 34).unwrap();
        let records = recorder.samples(u64::from(u32::MAX) + 5).unwrap();
        // Of camera rays that went on there is a hash.
        let emits = |r: &SampleRecord| {
            let primitive = prepared.data.primitives.get(r.camera_primitive as usize);
            primitive.is_none_or(|p| {
                prepared.data.scene.shapes[p.shape.index()]
                    .emission
                    .is_some()
            })
        };
        let mut checked = 0;
        for r in &records {
            if r.camera_primitive == NONE {
                assert_eq!([r.by_light, r.by_bsdf], [[0.0; 3]; 2], "{name}: {r:?}");
            } else if !emits(r) {
                checked += 1;
                for c in 0..3 {
                    assert_eq!(r.radiance[c], r.by_light[c] + r.by_bsdf[c], "{name}: {r:?}");
                }
            }
        }
        assert!(checked > records.len() / 4, "{name}: {checked} checked");
    }
}
