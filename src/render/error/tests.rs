use super::*;
use crate::scene::Sampler;
use crate::stats::testing::Stream;

const SIZE: FilmSize = FilmSize {
    width: 48,
    height: 40,
};

/// How much reported and actual errors may differ, all images together.
const PROMISE: f64 = 0.1;

/// What an image of 48 × 40 pixels would be without noise: a ramp, dark below the middle.
fn truth(i: usize) -> [f64; 3] {
    let (x, y) = (i % 48, i / 48);
    let value = (1.0 + 0.02 * x as f64) * if y < 20 { 1.0 } else { 0.1 };
    [value, 0.5 * value, 0.2 * value]
}

/// A film whose replicates have independent errors of truth·`error()`.
fn film(sampler: Sampler, mut error: impl FnMut(usize) -> f64) -> Film {
    let mut film = Film::new(SIZE, sampler);
    for (i, pixel) in film.pixels.iter_mut().enumerate() {
        let (a, b) = (error(i), error(i));
        let of = |error: f64| truth(i).map(|t| t * (1.0 + error));
        let mean = of(0.5 * (a + b));
        *pixel = crate::render::film::Pixel {
            samples: 32,
            mean,
            // The scatter of samples says four times the actual variance; with independent ones the
            // very variance.
            m2: mean.map(|m| m * m * 0.01 * 0.5 * (32.0 * 31.0)),
            second_samples: 16,
            second_mean: of(b),
        };
        if !sampler.is_independent() {
            pixel.m2 = pixel.m2.map(|m2| 4.0 * m2);
        }
    }
    film
}

/// The image's actual relMSE.
fn actual(film: &Film) -> f64 {
    let mean: f64 = (0..film.pixels.len())
        .map(|i| truth(i).iter().sum::<f64>())
        .sum();
    let mean = mean / (3 * film.pixels.len()) as f64;
    let terms = film.pixels.iter().enumerate().map(|(i, pixel)| {
        let of = |c: usize| {
            let r = truth(i)[c];
            (pixel.mean[c] - r).powi(2) / (r * r + 0.01 * mean * mean)
        };
        (of(0) + of(1) + of(2)) / 3.0
    });
    terms.sum::<f64>() / film.pixels.len() as f64
}

/// Of many images: the mean of reported over that of actual errors, and how often the interval
/// holds the actual one.
fn calibration(mut film: impl FnMut() -> Film) -> (f64, f64) {
    let images = 400;
    let (mut reported, mut found, mut covered) = (0.0, 0.0, 0);
    for _ in 0..images {
        let film = film();
        let error = film.error().expect("two replicates");
        let actual = actual(&film);
        reported += error.rel_mse;
        found += actual;
        covered += i32::from(error.rel_mse_low <= actual && actual <= error.rel_mse_high);
    }
    (reported / found, f64::from(covered) / f64::from(images))
}

/// The standard deviation of a coverage of 95 % over 400 images is 1.1 %.
#[test]
fn intervals_hold_the_actual_error_of_the_image() {
    for sampler in [Sampler::Independent, Sampler::Sobol] {
        let mut stream = Stream::new(3);
        let (ratio, coverage) = calibration(|| film(sampler, |_| 0.1 * stream.normal()));
        assert!((ratio - 1.0).abs() < PROMISE, "{sampler}: {ratio}");
        assert!((coverage - 0.95).abs() < 0.045, "{sampler}: {coverage}");
    }
}

/// Rare bright errors: 1 of 20 replicates has found light that the others have to make up for.
/// Where they are, the image's error is told to be: it is that of this image, not of one like it.
/// The interval allows for noise in denominators.
#[test]
fn skewed_errors_are_reported_as_they_are() {
    let mut stream = Stream::new(4);
    let (ratio, coverage) = calibration(|| {
        film(Sampler::Sobol, |_| {
            let rare = stream.uniform() < 0.05;
            0.1 * if rare {
                19.0_f64.sqrt()
            } else {
                -1.0 / 19.0_f64.sqrt()
            }
        })
    });
    assert!((ratio - 1.0).abs() < PROMISE, "{ratio}");
    assert!(coverage > 0.95 - 0.045, "{coverage}");
}

/// Broken: the scatter of the samples in the place of the replicates.
#[test]
fn scatter_would_not_do() {
    let mut stream = Stream::new(5);
    let image = film(Sampler::Sobol, |_| 0.1 * stream.normal());
    let scatter = image.pixels.iter();
    let scatter = scatter.map(|p| p.variance_of_mean().expect("32 samples")[0]);
    let told = image.variances().expect("two replicates");
    let told = told.iter().map(|v| v[0]);
    assert!(scatter.sum::<f64>() > 3.0 * told.sum::<f64>());
}

#[test]
fn one_replicate_tells_no_error() {
    let mut film = film(Sampler::Sobol, |_| 0.0);
    film.pixels[11].second_samples = 0;
    assert!(film.error().is_none() && film.variances().is_none());
    assert!(film.standard_error_of_mean().is_none());
}

#[test]
fn black_has_no_relative_error() {
    let mut film = film(Sampler::Independent, |_| 0.0);
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
            let film = film(sampler, |_| 0.1 * stream.normal());
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
    let film = film(Sampler::Sobol, |_| 0.1 * stream.normal());
    assert_eq!(film.error_unless(|| false), film.error());
    assert!(film.error().is_some());
    for asked in 0..3 {
        let calls = std::cell::Cell::new(0);
        let stop = || calls.replace(calls.get() + 1) >= asked;
        assert_eq!(film.error_unless(stop), None, "stopped at question {asked}");
        assert_eq!(calls.get(), asked + 1);
    }
}
