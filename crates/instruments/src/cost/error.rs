//! The error of images against a reference, with intervals.
//!
//! With x an image, r the reference and means over pixels and channels,
//!
//! ```text
//!     MSE    = mean (x − r)²              relMSE = mean (x − r)² / (r² + 0.01·mean(r)²)
//! ```
//!
//! Where r was rendered, E(x − r)² = Var x + Var r, because the two are independent; Var r is
//! estimated from two independent halves a and b of r = (a + b)/2 as (a − b)²/4, and subtracted.
//!
//! The intervals come from independent replicates (other seeds), pixel by pixel: how the squared
//! errors of one pixel vary over the replicates, summed over pixels, which are independent of each
//! other under all samplers but blue noise. For that one, tiles take the place of pixels
//! ([`Sampler::independent_side`]).

use super::interval::{Interval, student_95};
use super::reference::Reference;
use direkt::low_level::render::{Film, tile_sums};
use direkt::scene::{FilmSize, Sampler};
use rayon::prelude::*;

/// A squared error, absolute and relative.
type Squared = [f64; 2];

/// Sums over the replicates of one independent unit, pixel or tile.
#[derive(Debug, Clone, Copy, Default)]
struct Unit {
    sum: Squared,
    squares: Squared,
}

/// Squared errors of replicates.
#[derive(Debug, Clone)]
pub struct Errors {
    size: FilmSize,
    /// Side of a unit in pixels.
    side: u32,
    units: Vec<Unit>,
    replicates: u32,
}

/// Error of the images of one estimator at one number of samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredError {
    /// Mean squared error.
    pub mse: Interval,
    /// Relative mean squared error.
    pub rel_mse: Interval,
}

impl Errors {
    /// No replicates yet, of images of `size` by `sampler`.
    pub fn new(size: FilmSize, sampler: Sampler) -> Self {
        let side = sampler.independent_side();
        let units = size.width.div_ceil(side) as usize * size.height.div_ceil(side) as usize;
        Self {
            size,
            side,
            units: vec![Unit::default(); units],
            replicates: 0,
        }
    }

    /// Images so far.
    pub fn replicates(&self) -> u32 {
        self.replicates
    }

    /// Adds a replicate.
    pub fn add(&mut self, film: &Film, reference: &Reference) {
        let squared = tile_sums(squared_errors(film, reference), self.size, self.side);
        self.replicates += 1;
        let pairs = self.units.par_iter_mut().zip(squared);
        pairs.for_each(|(unit, squared)| {
            for (k, d) in squared.into_iter().enumerate() {
                unit.sum[k] += d;
                unit.squares[k] += d * d;
            }
        });
    }

    /// The error of the images so far, `reference`'s own subtracted. There have to be two
    /// replicates.
    pub fn finish(&self, reference: &Reference) -> MeasuredError {
        assert!(self.replicates > 1, "one replicate has no spread");
        let of = |k: usize| {
            let own = reference.own_error();
            self.interval(k, own.value[k], own.standard_error[k])
        };
        MeasuredError {
            mse: of(0),
            rel_mse: of(1),
        }
    }

    /// The interval of error `k`. `own` is the reference's, with `own_error` its standard error:
    /// subtracting it adds this much, and the reference's actual squared error, which all
    /// replicates share, as much again.
    fn interval(&self, k: usize, own: f64, own_error: f64) -> Interval {
        let r = f64::from(self.replicates);
        let (mut sum, mut variance, mut squares) = (0.0, 0.0, 0.0);
        for unit in &self.units {
            sum += unit.sum[k];
            let mean = unit.sum[k] / r;
            let v = ((unit.squares[k] - mean * unit.sum[k]) / (r - 1.0)).max(0.0);
            variance += v;
            squares += v * v;
        }
        let pixels = self.size.pixels() as f64;
        // Satterthwaite's degrees of freedom: few where few pixels make most of the variance.
        let freedom = if squares > 0.0 {
            (r - 1.0) * (variance * variance / squares)
        } else {
            (r - 1.0) * self.units.len() as f64
        };
        let from_replicates = student_95(freedom) * (variance / r).sqrt() / pixels;
        let from_reference = student_95(f64::INFINITY) * std::f64::consts::SQRT_2 * own_error;
        Interval::positive(sum / r / pixels, from_replicates).less(own, from_reference)
    }
}

/// Squared errors of each pixel, means over its channels.
fn squared_errors(film: &Film, reference: &Reference) -> Vec<Squared> {
    let pixels = film.pixels.par_iter().zip(&reference.mean);
    pixels
        .map(|(pixel, r)| {
            let mut sum = [0.0; 2];
            for (x, r) in pixel.mean.iter().zip(r) {
                let squared = (x - r) * (x - r);
                sum[0] += squared / 3.0;
                sum[1] += squared * reference.weight(*r) / 3.0;
            }
            sum
        })
        .collect()
}

/// √ of the relative squared error of each pixel.
pub fn relative_errors(film: &Film, reference: &Reference) -> Vec<f64> {
    let squared = squared_errors(film, reference);
    squared.into_iter().map(|s| s[1].sqrt()).collect()
}

/// Mean squared error and relMSE of one image, the reference's own subtracted, without intervals.
pub fn mean_errors(film: &Film, reference: &Reference) -> [f64; 2] {
    let squared = squared_errors(film, reference);
    [0, 1].map(|k| {
        let sum: f64 = squared.iter().map(|s| s[k]).sum();
        sum / squared.len() as f64 - reference.own_error().value[k]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use direkt::low_level::stats::testing::Stream;

    const SIZE: FilmSize = FilmSize {
        width: 40,
        height: 25,
    };

    /// An image of mean 1 with normal errors; those of a tenth of the pixels ten times as large.
    fn image(stream: &mut Stream, sigma: f64) -> Film {
        let mut film = Film::new(SIZE, Sampler::Independent);
        for (i, pixel) in film.pixels.iter_mut().enumerate() {
            let sigma = if i % 10 == 0 { 10.0 * sigma } else { sigma };
            pixel.mean = [0.0; 3].map(|_: f64| 1.0 + sigma * stream.normal());
        }
        film
    }

    /// E of the mean squared error of [`image`].
    fn expected(sigma: f64) -> f64 {
        sigma * sigma * (0.9 + 0.1 * 100.0)
    }

    #[test]
    fn intervals_cover_the_error_at_their_rate() {
        let mut stream = Stream::new(5);
        let reference = Reference::exact(vec![[1.0; 3]; SIZE.pixels()]);
        for sampler in [Sampler::Sobol, Sampler::BlueNoise] {
            let experiments = 400;
            let mut covered = 0;
            for _ in 0..experiments {
                let mut errors = Errors::new(SIZE, sampler);
                (0..3).for_each(|_| errors.add(&image(&mut stream, 0.1), &reference));
                let mse = errors.finish(&reference).mse;
                let inside = mse.low < expected(0.1) && expected(0.1) < mse.high;
                covered += i32::from(inside);
            }
            // 380 expected; the standard deviation is 4.4, and Satterthwaite's approximation errs
            // to the safe side.
            assert!(covered > 362, "{sampler}: {covered} of {experiments}");
        }
    }

    #[test]
    fn the_references_own_error_is_subtracted() {
        let mut stream = Stream::new(6);
        let halves = [0, 1].map(|_| image(&mut stream, 0.2));
        let reference = Reference::from_halves(&halves[0], &halves[1]);
        let own = reference.own_error();
        assert!((own.value[0] / expected(0.2) - 0.5).abs() < 0.1, "{own:?}");
        let mut errors = Errors::new(SIZE, Sampler::Independent);
        (0..8).for_each(|_| errors.add(&image(&mut stream, 0.1), &reference));
        let mse = errors.finish(&reference).mse;
        assert!(
            mse.low < expected(0.1) && expected(0.1) < mse.high,
            "{mse:?}"
        );
    }

    #[test]
    fn relative_errors_are_those_of_the_definition() {
        let reference = Reference::exact(vec![[2.0, 2.0, 2.0]; SIZE.pixels()]);
        let mut film = Film::new(SIZE, Sampler::Independent);
        for pixel in &mut film.pixels {
            pixel.mean = [3.0, 2.0, 2.0];
        }
        let expected = 1.0 / (4.0 + 0.01 * 4.0) / 3.0;
        assert!((mean_errors(&film, &reference)[1] - expected).abs() < 1e-12);
        assert!((relative_errors(&film, &reference)[7] - expected.sqrt()).abs() < 1e-12);
    }
}
