//! Adaptive sampling: which samples pixels have, that their means stay right, and what it gains.

use crate::support::{context, prepared, render, scene, statistics, take};
use direkt::low_level::gpu::Context;
use direkt::low_level::gpu::recorder::Recorder;
use direkt::low_level::prepare::Prepared;
use direkt::low_level::reference::core::sampler::{GROUP_FILM, Numbers};
use direkt::low_level::render::{Film, Pixel, Session, StopReason, render_through_losses};
use direkt::low_level::stats::moments::Moments;
use direkt::low_level::stats::z_test::z_test;
use direkt::scene::{FilmSize, Sampler, Scene, ShadowRays, Strategy};
use std::collections::BTreeSet;
use std::time::Duration;

const PILOT: u64 = 8;

fn cornell(width: u32, height: u32) -> Scene {
    let mut cornell = scene("scenes/cornell.toml");
    cornell.film = FilmSize { width, height };
    cornell.render.estimator.adaptive = true;
    cornell
}

fn session<'a>(context: &'a Context, prepared: &Prepared, seed: u32) -> Session<'a> {
    Session::new(context, prepared, prepared.film, seed).unwrap()
}

fn counts(film: &Film) -> BTreeSet<u64> {
    film.pixels.iter().map(|p| p.samples).collect()
}

/// A pixel with n samples has the first n of the image's, none of the pilot's.
#[test]
fn pixels_have_the_first_samples_after_the_pilot() {
    const SEED: u32 = 5;
    let context = context();
    let prepared = prepared(cornell(31, 33));
    let mut adaptive = session(context, &prepared, SEED);
    assert_eq!(adaptive.first_sample(), 0);
    take(&mut adaptive, 40);
    let first = adaptive.first_sample();
    assert!(first > u64::from(u32::MAX));
    assert_apart(first);
    let film = adaptive.snapshot().unwrap().0;
    let counts = counts(&film);
    assert!(counts.iter().all(|n| n.is_power_of_two()));
    assert!(counts.len() >= 4, "{counts:?}");
    assert!((40..80).contains(&film.mean_samples()));
    let recorder = Recorder::new(context, &prepared, prepared.film, SEED).unwrap();
    let most = *counts.last().unwrap();
    let mut sums = vec![[[0.0; 3]; 2]; film.pixels.len()];
    for i in 0..most {
        let records = recorder.samples(first + i).unwrap();
        for ((pixel, sums), record) in film.pixels.iter().zip(&mut sums).zip(records) {
            if i < pixel.samples {
                for (sum, x) in sums[i as usize % 2].iter_mut().zip(record.radiance) {
                    *sum += f64::from(x);
                }
            }
        }
    }
    // The kernel adds in f32.
    let rounding = 256.0 * (-24_f64).exp2();
    let near = |found: f64, sum: f64, n: u64| {
        let expected = sum / n as f64;
        (found - expected).abs() <= rounding * expected.abs()
    };
    for (pixel, [even, odd]) in film.pixels.iter().zip(&sums) {
        assert_eq!(2 * pixel.second_samples, pixel.samples);
        for c in 0..3 {
            let all = even[c] + odd[c];
            assert!(near(pixel.mean[c], all, pixel.samples), "{pixel:?}");
            assert!(near(pixel.second_mean[c], odd[c], pixel.second_samples));
        }
    }
}

/// The numbers of the samples from `first` on are none of the pilot's. Broken: where the image begins
/// with the pilot's.
fn assert_apart(first: u64) {
    let alike = |sampler: Sampler, first: u64| {
        let numbers = Numbers {
            sampler,
            pattern: sampler.pattern(64),
            width: 16,
        };
        let group = |pixel, index| numbers.group(numbers.sample_id(pixel, index, 7), GROUP_FILM);
        let samples = (0..256).flat_map(|pixel| (0..PILOT).map(move |i| (pixel, i)));
        let words = samples.flat_map(|(pixel, i)| {
            let (of_pilot, of_image) = (group(pixel, i), group(pixel, first + i));
            of_pilot.into_iter().zip(of_image)
        });
        words.filter(|(a, b)| a.abs_diff(*b) < 1 << 8).count()
    };
    let samplers = [
        Sampler::Independent,
        Sampler::Stratified,
        Sampler::Sobol,
        Sampler::BlueNoise,
    ];
    for sampler in samplers {
        assert_eq!(alike(sampler, first), 0, "{sampler}");
    }
    assert!(alike(Sampler::Sobol, 0) > 1000);
}

/// Where passes end, how the image is cut into regions, and lost devices change nothing.
#[test]
fn passes_regions_and_lost_devices_change_nothing() {
    const SPP: u64 = 400;
    let mut scene = cornell(40, 30);
    scene.render.estimator.sampler = Sampler::Sobol;
    scene.render.estimator.shadow_rays = ShadowRays::Auto;
    let prepared = prepared(scene);
    let context = context();
    let mut whole = session(context, &prepared, 0);
    take(&mut whole, SPP);
    let expected = whole.snapshot().unwrap();
    let many = *counts(&expected.0).last().unwrap();
    assert!(many > 1024, "blocks are merged: {many}");

    let mut cut = Session::in_regions(context, &prepared, prepared.film, 0, 7).unwrap();
    for to in [3, 9, 10, 17, 60, 61, 200, SPP] {
        let mut interruptions = 0;
        let pass = |session: &mut Session<'_>| {
            let mut left = 9;
            let stop = || {
                left -= 1;
                left < 0
            };
            let samples = to.saturating_sub(session.samples());
            session.pass(samples, stop).unwrap()
        };
        while pass(&mut cut) == StopReason::Interrupted || cut.samples() < to {
            interruptions += 1;
        }
        assert!(to < SPP || interruptions > 0);
    }
    assert!(expected == cut.snapshot().unwrap());

    let mut destroyed_at = vec![(300, true), (120, false), (30, true), (9, true), (6, false)];
    let open = || Context::new(None);
    let work = |session: &mut Session<'_>| {
        while session.samples() < SPP {
            session.pass(5.min(SPP - session.samples()), || false)?;
            if let Some((_, saved)) = destroyed_at.pop_if(|(at, _)| session.samples() >= *at) {
                if saved {
                    session.save()?;
                }
                session.context().device.destroy();
            }
        }
        Ok(session.snapshot()?)
    };
    let found = render_through_losses(open, &prepared, work, |_, _| ()).unwrap();
    assert!(destroyed_at.is_empty());
    assert!(expected == found);
}

/// Until the image has as many samples as the pilot, it is the pilot's, and after a restart no pixel
/// has anything of the render before.
#[test]
fn a_render_that_begins_again_forgets_the_one_before() {
    let context = context();
    let prepared = prepared(cornell(40, 30));
    let mut again = session(context, &prepared, 2);
    take(&mut again, 64);
    again.restart(3, prepared.settings.stop.spp).unwrap();
    let mut new = session(context, &prepared, 3);
    for samples in [PILOT, PILOT + 1] {
        take(&mut again, samples);
        take(&mut new, samples);
        assert!(new.snapshot().unwrap() == again.snapshot().unwrap());
    }
    let mut stopped = session(context, &prepared, 3);
    // A dispatch is a row of pixels then, so that there is one to stop after.
    stopped.set_dispatch_time(Duration::ZERO);
    take(&mut stopped, PILOT);
    let pilot = stopped.snapshot().unwrap().0;
    let mut asked = 0;
    let after_one = || {
        asked += 1;
        asked > 1
    };
    let reason = stopped.pass(1, after_one).unwrap();
    assert_eq!(reason, StopReason::Interrupted);
    assert_eq!(stopped.samples(), PILOT);
    assert!(stopped.snapshot().unwrap().0 == pilot);
}

#[test]
fn sessions_begin_again() {
    let context = context();
    let prepared = prepared(cornell(40, 30));
    let mut one = session(context, &prepared, 2);
    take(&mut one, 64);
    let expected = one.snapshot().unwrap();
    one.reframe(
        &prepared,
        FilmSize {
            width: 9,
            height: 9,
        },
    )
    .unwrap();
    take(&mut one, 64);
    one.reframe(&prepared, prepared.film).unwrap();
    take(&mut one, 64);
    assert!(expected == one.snapshot().unwrap());
}

/// No light, no others to learn from: samples as without.
#[test]
fn without_an_error_all_pixels_have_the_same() {
    let mut black = cornell(24, 16);
    black.shapes.retain(|shape| shape.emission.is_none());
    let mut pixel = cornell(1, 1);
    pixel.render.stop.spp = 100;
    black.render.stop.spp = 100;
    for scene in [black, pixel] {
        let film = render(context(), scene);
        assert_eq!(counts(&film), BTreeSet::from([100]));
    }
}

/// The means of images whose samples are rarely bright. Broken: the pilot's samples, which say how
/// many others a pixel has, count with them.
#[test]
fn means_are_unbiased() {
    const IMAGES: u32 = 25;
    let mut scene = cornell(64, 64);
    scene.render.estimator.strategy = Strategy::Bsdf;
    scene.render.estimator.sampler = Sampler::Independent;
    let mut exact = scene.clone();
    (exact.render.estimator.strategy, exact.render.stop.spp) = (Strategy::MisPower, 1 << 12);
    (
        exact.render.estimator.sampler,
        exact.render.estimator.adaptive,
    ) = (Sampler::Sobol, false);
    let context = context();
    let exact = render(context, exact);
    let (expected, its_error) = (exact.mean()[1], exact.standard_error_of_mean().unwrap()[1]);

    let prepared = prepared(scene);
    let mut session = session(context, &prepared, 0);
    let mut means = [Moments::default(), Moments::default()];
    for seed in 0..IMAGES {
        session.restart(seed, prepared.settings.stop.spp).unwrap();
        take(&mut session, PILOT);
        let pilot = session.snapshot().unwrap().0;
        take(&mut session, 40);
        let film = session.snapshot().unwrap().0;
        let with_pilot = |(pilot, pixel): (&Pixel, &Pixel)| {
            let [few, many] = [pilot, pixel].map(|p| p.samples as f64);
            (few * pilot.mean[1] + many * pixel.mean[1]) / (few + many)
        };
        let pixels = pilot.pixels.iter().zip(&film.pixels);
        let sum: f64 = pixels.map(with_pilot).sum();
        means[0].push(film.mean()[1]);
        means[1].push(sum / film.pixels.len() as f64);
    }
    let [ours, broken] = means.map(|means| {
        let variance = means.variance_of_mean().unwrap() + its_error * its_error;
        z_test(means.mean, expected, variance, 2e-5 * expected).p_value
    });
    statistics::accept(ours, "the mean of 25 adaptive images of 64 × 64 pixels");
    statistics::reject(broken, "the mean with the pilot's samples");
}

/// The error at the same number of samples, against an image of far more of them.
#[test]
fn the_error_is_smaller_at_equal_samples() {
    let context = context();
    let mut scene = cornell(128, 128);
    scene.render.estimator.sampler = Sampler::Sobol;
    scene.render.stop.spp = 2048;
    let truth = render(context, scene.clone());
    (scene.render.stop.spp, scene.render.seed) = (64, 1);
    let errors = [true, false].map(|adaptive| {
        scene.render.estimator.adaptive = adaptive;
        let film = render(context, scene.clone());
        let mean = truth.mean()[1];
        let terms = film.pixels.iter().zip(&truth.pixels).map(|(found, truth)| {
            let (x, r) = (found.mean[1], truth.mean[1]);
            (x - r).powi(2) / (r * r + 0.01 * mean * mean)
        });
        terms.sum::<f64>()
    });
    assert!(2.0 * errors[0] < errors[1], "{errors:?}");
}
