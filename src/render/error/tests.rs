use super::*;
use crate::render::film::Pixel;
use crate::scene::{FilmSize, Sampler};
use crate::stats::testing::Stream;

const SIZE: FilmSize = FilmSize {
    width: 48,
    height: 40,
};

/// How much reported and actual errors may differ, all images together.
const PROMISE: f64 = 0.05;
/// Samples of a replicate.
const HALF: u64 = 16;
const METRICS: [ErrorMetric; 2] = [ErrorMetric::Nmse, ErrorMetric::RelMse];

/// What an image of 48 × 40 pixels would be without noise: a ramp, dark below the middle.
fn truth(i: usize) -> [f64; 3] {
    let (x, y) = (i % 48, i / 48);
    let value = (1.0 + 0.02 * x as f64) * if y < 20 { 1.0 } else { 0.1 };
    [value, 0.5 * value, 0.2 * value]
}

/// A replicate's error as a part of the truth, and the sum of squared deviations of its samples.
#[derive(Clone, Copy)]
struct Replicate {
    error: f64,
    m2: f64,
}

/// A replicate of normal samples, whose mean has the standard deviation 10 %. Of a sampler that
/// stratifies the scatter says four times the variance.
fn normal(stream: &mut Stream, sampler: Sampler) -> Replicate {
    let of_sample = 0.01 * HALF as f64;
    let m2 = if sampler.is_independent() {
        let squares = (1..HALF).map(|_| stream.normal().powi(2));
        of_sample * squares.sum::<f64>()
    } else {
        4.0 * of_sample * (HALF - 1) as f64
    };
    let error = 0.1 * stream.normal();
    Replicate { error, m2 }
}

/// A replicate of which all depends on one sample, which one of `rarity` finds.
fn rare(stream: &mut Stream, rarity: f64) -> Replicate {
    let found = stream.uniform() * rarity < 1.0;
    let error = 0.1
        * if found {
            (rarity - 1.0).sqrt()
        } else {
            -(1.0 / (rarity - 1.0)).sqrt()
        };
    let light = if found {
        0.1 * rarity / (rarity - 1.0).sqrt()
    } else {
        0.0
    };
    Replicate {
        error,
        m2: light * light * (HALF * (HALF - 1)) as f64,
    }
}

/// A film of two replicates for each pixel.
fn film(sampler: Sampler, mut replicates: impl FnMut(usize) -> [Replicate; 2]) -> Film {
    let mut film = Film::new(SIZE, sampler);
    for (i, pixel) in film.pixels.iter_mut().enumerate() {
        let [a, b] = replicates(i);
        let of = |error: f64| truth(i).map(|t| t * (1.0 + error));
        let m2 = |m2: f64| truth(i).map(|t| t * t * m2);
        let between = 0.5 * HALF as f64 * (a.error - b.error).powi(2);
        *pixel = Pixel {
            samples: 2 * HALF,
            mean: of(0.5 * (a.error + b.error)),
            m2: m2(a.m2 + b.m2 + between),
            second_samples: HALF,
            second_mean: of(b.error),
            expected_squares: 0.0,
            expected_hits: 0.0,
            second_m2: m2(b.m2),
        };
    }
    film
}

/// A film of normal errors.
fn normal_film(sampler: Sampler, stream: &mut Stream) -> Film {
    film(sampler, |_| [0, 1].map(|_| normal(stream, sampler)))
}

/// The image's actual error.
fn actual(film: &Film, metric: ErrorMetric) -> f64 {
    let sum = (0..film.pixels.len()).flat_map(truth).sum::<f64>();
    let squared_mean = (sum / (3 * film.pixels.len()) as f64).powi(2);
    let terms = film.pixels.iter().enumerate().flat_map(|(i, pixel)| {
        [0, 1, 2].map(|c| {
            let r = truth(i)[c];
            let denominator = match metric {
                ErrorMetric::Nmse => squared_mean,
                ErrorMetric::RelMse => r * r + 0.01 * squared_mean,
            };
            (pixel.mean[c] - r).powi(2) / denominator
        })
    });
    terms.sum::<f64>() / (3 * film.pixels.len()) as f64
}

/// Of many images, in each metric: the mean of reported over that of actual errors, and how often
/// the interval holds the actual one.
fn calibration(mut film: impl FnMut() -> Film) -> [(f64, f64); 2] {
    const IMAGES: i32 = 400;
    let (mut reported, mut found, mut covered) = ([0.0; 2], [0.0; 2], [0; 2]);
    for _ in 0..IMAGES {
        let film = film();
        let error = film.error().expect("two replicates");
        for (i, metric) in METRICS.into_iter().enumerate() {
            let (stated, actual) = (error.in_metric(metric), actual(&film, metric));
            reported[i] += stated.value;
            found[i] += actual;
            covered[i] += i32::from(stated.low <= actual && actual <= stated.high);
        }
    }
    [0, 1].map(|i| {
        (
            reported[i] / found[i],
            f64::from(covered[i]) / f64::from(IMAGES),
        )
    })
}

/// Whether reported errors are the actual ones, and intervals hold them as often as they say: the
/// standard deviation of a coverage of 95 % over 400 images is 1.1 %.
fn is_calibrated((ratio, coverage): (f64, f64)) -> bool {
    (ratio - 1.0).abs() < PROMISE && (coverage - 0.95).abs() < 0.045
}

#[test]
fn intervals_hold_the_actual_error_of_the_image() {
    for sampler in [Sampler::Independent, Sampler::Sobol] {
        let mut stream = Stream::new(3);
        for found in calibration(|| normal_film(sampler, &mut stream)) {
            assert!(is_calibrated(found), "{sampler}: {found:?}");
        }
    }
}

/// Rare bright errors: 1 of 20 replicates has found light that the others have to make up for.
/// Where they are, the image's error is told to be: it is that of this image, not of one like it.
#[test]
fn skewed_errors_are_reported_as_they_are() {
    let mut stream = Stream::new(4);
    let [nmse, (ratio, coverage)] =
        calibration(|| film(Sampler::Sobol, |_| [0, 1].map(|_| rare(&mut stream, 20.0))));
    assert!(is_calibrated(nmse), "{nmse:?}");
    // relMSE allows for noise in denominators.
    assert!((ratio - 1.0).abs() < 0.1, "{ratio}");
    assert!(coverage > 0.95 - 0.045, "{coverage}");
}

/// Where one pixel holds nearly all of the error, the interval is as wide as that makes it, and the
/// image says that it cannot tell.
#[test]
fn an_error_of_one_pixel_cannot_be_told() {
    let mut stream = Stream::new(6);
    let mut dominated = || {
        film(Sampler::Sobol, |i| {
            let scale = if i == 500 { 3000.0 } else { 1.0 };
            [0, 1].map(|_| {
                let Replicate { error, m2 } = normal(&mut stream, Sampler::Sobol);
                Replicate {
                    error: scale * error,
                    m2: scale * scale * m2,
                }
            })
        })
    };
    let nmse = dominated().error().expect("two replicates").nmse;
    assert!(
        matches!(nmse.doubt, Some(Doubt::OnePixel(part)) if part > 0.5),
        "{nmse:?}"
    );
    assert!(nmse.high > 20.0 * nmse.value, "{nmse:?}");
    let [(_, coverage), _] = calibration(&mut dominated);
    assert!((coverage - 0.95).abs() < 0.045, "{coverage}");
}

/// Adds to pixel `i` a sample that its first replicate alone has met and that raises its mean by `bright`.
fn meet_once(film: &mut Film, i: usize, bright: f64) {
    let pixel = &mut film.pixels[i];
    let n = pixel.samples as f64;
    for c in 0..3 {
        pixel.mean[c] += bright;
        pixel.m2[c] += n * (n - 1.0) * bright * bright;
    }
}

/// The fifth of the error that one such sample holds is known to no more than 25 degrees of freedom.
#[test]
fn what_one_replicate_alone_has_met_widens_the_interval() {
    let mut film = normal_film(Sampler::Sobol, &mut Stream::new(7));
    let nmse = |film: &Film| film.error().expect("two replicates").nmse;
    let without = nmse(&film);
    let mean = film.mean().iter().sum::<f64>() / 3.0;
    let squared = 0.25 * without.value * film.pixels.len() as f64 * mean * mean;
    meet_once(&mut film, 500, squared.sqrt());
    let with = nmse(&film);
    assert!(without.high < 1.2 * without.value, "{without:?}");
    assert!(with.high > 2.0 * with.value, "{with:?}");
    assert!(
        with.low < 0.5 * with.value && with.doubt.is_none(),
        "{with:?}"
    );
}

/// Broken in the three ways that are easily made: the calibration finds each of them.
#[test]
fn a_broken_estimate_of_the_error_is_found() {
    let mut stream = Stream::new(9);
    let mut replicates_share_numbers = || {
        film(Sampler::Sobol, |_| {
            let [a, b] = [0, 1].map(|_| normal(&mut stream, Sampler::Sobol));
            let error = 0.6 * a.error + 0.8 * b.error;
            [a, Replicate { error, ..b }]
        })
    };
    assert!(!is_calibrated(
        calibration(&mut replicates_share_numbers)[0]
    ));
    let mut stream = Stream::new(9);
    let mut a_factor_of_two_is_forgotten = || {
        let mut film = normal_film(Sampler::Sobol, &mut stream);
        for pixel in &mut film.pixels {
            // The image of the first replicate alone has twice the squared error.
            pixel.mean = pixel.replicates().expect("two replicates")[0];
            pixel.second_mean = [0, 1, 2].map(|c| pixel.mean[c] - pixel.second_mean[c]);
            let half = pixel.second_mean.map(|difference| 0.5 * difference);
            pixel.second_mean = [0, 1, 2].map(|c| pixel.mean[c] - half[c]);
        }
        film
    };
    assert!(!is_calibrated(
        calibration(&mut a_factor_of_two_is_forgotten)[0]
    ));
    let mut stream = Stream::new(9);
    let mut tailed = || film(Sampler::Sobol, |_| [0, 1].map(|_| rare(&mut stream, 400.0)));
    let [(whole, _), _] = calibration(&mut tailed);
    assert!((whole - 1.0).abs() < PROMISE, "{whole}");
    let mut the_tail_is_cut_off = || {
        let mut film = tailed();
        for pixel in &mut film.pixels {
            let [a, b] = pixel.replicates().expect("two replicates");
            let lesser = [0, 1, 2].map(|c| a[c].min(1.5 * b[c]).max(b[c] / 1.5));
            pixel.second_mean = [0, 1, 2].map(|c| pixel.mean[c] - 0.5 * (lesser[c] - b[c]));
        }
        film
    };
    let [(cut, _), _] = calibration(&mut the_tail_is_cut_off);
    assert!(cut < 0.5, "{cut}");
}

/// Broken: the scatter of the samples in the place of the replicates.
#[test]
fn scatter_would_not_do() {
    let mut stream = Stream::new(5);
    let image = normal_film(Sampler::Sobol, &mut stream);
    let scatter = image.pixels.iter();
    let scatter = scatter.map(|p| p.variance_of_mean().expect("32 samples")[0]);
    let told = image.variances().expect("two replicates");
    let told = told.iter().map(|v| v[0]);
    assert!(scatter.sum::<f64>() > 3.0 * told.sum::<f64>());
}

#[test]
fn one_replicate_tells_no_error() {
    let mut film = normal_film(Sampler::Sobol, &mut Stream::new(1));
    film.pixels[11].second_samples = 0;
    assert!(film.error().is_none() && film.variances().is_none());
    assert!(film.standard_error_of_mean().is_none());
}

#[test]
fn black_has_no_relative_error() {
    let mut film = normal_film(Sampler::Independent, &mut Stream::new(1));
    for pixel in &mut film.pixels {
        (pixel.mean, pixel.second_mean) = ([0.0; 3], [0.0; 3]);
    }
    assert!(film.error().is_none());
}

#[test]
fn the_means_error_comes_from_replicates() {
    for sampler in [Sampler::Independent, Sampler::Sobol, Sampler::BlueNoise] {
        let mut stream = Stream::new(8);
        let (mut squares, mut told) = (0.0, 0.0);
        for _ in 0..400 {
            let film = normal_film(sampler, &mut stream);
            let exact = (0..SIZE.pixels()).map(|i| truth(i)[0]).sum::<f64>() / SIZE.pixels() as f64;
            squares += (film.mean()[0] - exact).powi(2);
            told += film.standard_error_of_mean().expect("two replicates")[0].powi(2);
        }
        // The variance of a variance over 400 normal values: 7 %.
        assert!(
            (told / squares - 1.0).abs() < 0.25,
            "{sampler}: {told} {squares}"
        );
    }
}

#[test]
fn tiles_add_up() {
    let values: Vec<[f64; 3]> = (0..15).map(|i| [f64::from(i), 1.0, 0.0]).collect();
    let size = FilmSize {
        width: 5,
        height: 3,
    };
    let sums = tile_sums(values, size, 2);
    // 0, 1, 5, 6; 2, 3, 7, 8; 4, 9; 10, 11; 12, 13; 14.
    let expected = [12.0, 20.0, 13.0, 21.0, 25.0, 14.0];
    assert_eq!(sums.len(), 6);
    for (sum, expected) in sums.iter().zip(expected) {
        assert!((sum[0] - expected).abs() < 1e-12);
    }
}

#[test]
fn a_look_that_nobody_waits_for_ends_without_an_error() {
    let mut stream = Stream::new(7);
    let film = normal_film(Sampler::Sobol, &mut stream);
    assert_eq!(film.error_unless(|| false), film.error());
    assert!(film.error().is_some());
    for asked in 0..3 {
        let calls = std::cell::Cell::new(0);
        let stop = || calls.replace(calls.get() + 1) >= asked;
        assert_eq!(film.error_unless(stop), None, "stopped at question {asked}");
        assert_eq!(calls.get(), asked + 1);
    }
}

/// A sample that one replicate alone has met, as bright as all the rest of the image: the mean by which
/// the error is divided is known no better than the error, which is one pixel's. Twenty of them in as many
/// pixels, half as bright each, leave the mean as the doubt.
#[test]
fn a_mean_that_few_samples_make_is_a_doubt() {
    let image = |pixels: &[usize], bright: f64| {
        let mut film = normal_film(Sampler::Sobol, &mut Stream::new(12));
        let before = film.mean()[0];
        for &i in pixels {
            let bright = bright * before * film.pixels.len() as f64;
            meet_once(&mut film, i, bright);
        }
        let nmse = film.error().expect("two replicates").nmse;
        (nmse, nmse.value * (film.mean()[0] / before).powi(2))
    };
    let (nmse, actual) = image(&[300], 1.0);
    assert!(matches!(nmse.doubt, Some(Doubt::OnePixel(part)) if part > 0.9));
    assert!(nmse.high > actual, "{nmse:?} {actual}");
    let twenty: Vec<usize> = (0..20).map(|i| 96 * i).collect();
    let (nmse, _) = image(&twenty, 0.5);
    assert!(matches!(nmse.doubt, Some(Doubt::Mean(relative)) if (0.18..0.23).contains(&relative)));
    assert!(nmse.high > 2.5 * nmse.value, "{nmse:?}");
}

/// Small lights that an image should have met a few times, each time adding more than all of the
/// error that it shows, are a reason for doubt; those that no such image meets are not, nor those
/// that all do.
#[test]
fn light_that_should_have_been_met_is_a_doubt() {
    let mut stream = Stream::new(11);
    let mut doubt = |hits: f64| {
        let mut film = normal_film(Sampler::Sobol, &mut stream);
        let n = film.pixels[0].samples as f64;
        let shown: f64 = film
            .variances()
            .expect("two replicates")
            .iter()
            .flatten()
            .sum();
        let pixel = &mut film.pixels[300];
        pixel.expected_hits = hits;
        pixel.expected_squares = 10.0 * shown * n * n;
        let nmse = film.error().expect("two replicates").nmse;
        let of_others = normal_film(Sampler::Sobol, &mut stream);
        let others = of_others.error().expect("two replicates").nmse;
        assert_eq!(
            nmse.doubt.is_some(),
            nmse.high > 2.0 * others.high,
            "{nmse:?}"
        );
        nmse.doubt
    };
    assert!(matches!(doubt(2.0), Some(Doubt::MissedLight(times)) if (5.0..20.0).contains(&times)));
    // With a chance of one in ten to be met it lacks a tenth of what that would add.
    assert_eq!(doubt(0.1), None);
    assert_eq!(doubt(1e-4), None);
    assert_eq!(doubt(1000.0), None);
}
