//! How right an image is, told by the image itself.
//!
//! Every pixel has two independent *replicates* A and B, the samples with even and with odd
//! indices: two randomisations of the sampler's pattern, each with its own seed. With a and b the
//! replicates' errors, the image (A + B)/2 has the error (a + b)/2, and half the replicates'
//! difference is (a − b)/2. Their squares differ by
//!
//! ```text
//!     ((a + b)/2)² − ((a − b)/2)² = a·b
//! ```
//!
//! a product of two independent numbers whose means are zero. So whatever the sampler and however
//! heavy the tails of its samples, the squared half differences estimate the squared error of *this*
//! image without bias. What they miss it by has the variance (2V)², with V the variance of the
//! image's pixel, and E((a − b)/2)⁴ = 3V² tells it: exactly where errors are normal, too large
//! where their tails are heavier. But a single difference tells it badly, and nothing where both
//! replicates are wrong alike; so the scatter of the pixel's samples counts half at the least.

use super::film::{Film, Pixel};
use super::neighbourhood::{box_mean, mean_of_others};
use crate::scene::FilmSize;
use crate::stats::interval::{Interval, student};
use rayon::prelude::*;

/// Pixels on each side of one whose replicates tell its variance.
const VARIANCE_RADIUS: usize = 3;
/// Pixels on each side of one that tell what it is without its noise.
const MEAN_RADIUS: usize = 2;
/// Pixels that they are.
const LOCAL_PIXELS: f64 = ((2 * MEAN_RADIUS + 1) * (2 * MEAN_RADIUS + 1)) as f64;
/// Confidence of the interval that is reported unless another is asked for.
pub const CONFIDENCE: f64 = 0.95;

/// The relative mean squared error of an image against the truth, as the image itself tells it:
///
/// relMSE = mean over pixels and channels of (x − r)² / (r² + 0.01·mean(r)²), with x the image and
/// r the truth.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct RelMse {
    /// The estimate.
    pub rel_mse: f64,
    /// Lower end of the interval in which the image's relMSE lies.
    pub rel_mse_low: f64,
    /// Upper end.
    pub rel_mse_high: f64,
    /// Probability with which it lies there.
    pub confidence: f64,
}

/// What an image suggests for the square of the truth in one channel of a pixel.
#[derive(Clone, Copy)]
struct SquaredTruth {
    square: f64,
    /// What it may be at the least.
    least: f64,
    /// The variance of its root over that of the pixel: k² + (1 − k²)/n of k times the pixel and 1
    /// − k times the mean of n.
    noise: f64,
}

impl Film {
    /// The image's error with an interval of 95 % confidence; see [`error_at`](Self::error_at).
    pub fn error(&self) -> Option<RelMse> {
        self.error_at(CONFIDENCE)
    }

    /// The same, unless `stop`, which is asked now and then, says that nobody waits for it any
    /// more: then `None`, soon.
    pub fn error_unless(&self, stop: impl Fn() -> bool) -> Option<RelMse> {
        self.look(CONFIDENCE, stop)
    }

    /// The image's error, its interval holding with the probability `confidence`; `None` while a
    /// pixel has not two samples, one of each replicate, or when the image is black.
    ///
    /// In the denominators D stands what the image suggests for the truth r. Its noise, of variance
    /// ρV, is of two consequences. By chance D = r² is off by 2r√(ρV), pixel by pixel, which adds
    /// 4ρ(V/D)³ to the variance of the pixel's term. On the whole it makes the estimate too small
    /// or too large, as errors are skewed or not; how much it may be is told by denominators with
    /// their noise added to them, and the interval is so much wider. Its upper end allows besides
    /// for pixels that are bright by chance: their denominators may be those that the lesser
    /// replicate and the pixels around suggest.
    pub fn error_at(&self, confidence: f64) -> Option<RelMse> {
        self.look(confidence, || false)
    }

    fn look(&self, confidence: f64, stop: impl Fn() -> bool) -> Option<RelMse> {
        let mean = self.mean();
        let overall = (mean[0] + mean[1] + mean[2]) / 3.0;
        let floor = 0.01 * overall * overall;
        let noise = self.squared_half_differences()?;
        if floor <= 0.0 || stop() {
            return None;
        }
        let truth = self.squared_truth(&noise)?;
        if stop() {
            return None;
        }
        let variances = self.variances()?;
        if stop() {
            return None;
        }
        let pixels = noise.par_iter().zip(&truth).zip(&variances);
        let terms = pixels.map(|((noise, truth), variances)| {
            let (mut term, mut with_noise, mut at_most) = (0.0, 0.0, 0.0);
            let (mut relative, mut of_denominator) = (0.0, 0.0);
            for c in 0..3 {
                let denominator = truth[c].square + floor;
                let its_noise = truth[c].noise * noise[c];
                term += noise[c] / denominator / 3.0;
                with_noise += noise[c] / (denominator + its_noise) / 3.0;
                at_most += noise[c] / (truth[c].least + floor) / 3.0;
                let variance = variances[c] / denominator;
                relative += variance / 3.0;
                of_denominator += 4.0 * truth[c].noise * variance.powi(3) / 3.0;
            }
            let by_replicates = 4.0 / 3.0 * term.powi(2);
            let by_scatter = 2.0 * relative.powi(2);
            let variance = by_replicates.max(by_scatter) + of_denominator;
            let of_denominators = [term - with_noise, at_most - term];
            [
                term,
                of_denominators[0],
                of_denominators[1],
                variance,
                variance.powi(2),
            ]
        });
        let [sum, above, below, variance, squares] =
            terms.reduce(|| [0.0; 5], |a, b| std::array::from_fn(|i| a[i] + b[i]));
        // How many pixels share the variance: few products of errors are no normal variable.
        let freedom = if squares > 0.0 {
            variance * variance / squares
        } else {
            f64::INFINITY
        };
        let by_chance = student(freedom, confidence) * variance.sqrt();
        let pixels = self.pixels.len() as f64;
        if !(sum.is_finite() && by_chance.is_finite()) {
            return None;
        }
        let interval = |of_denominators: f64| {
            Interval::positive(sum / pixels, by_chance.hypot(of_denominators) / pixels)
        };
        Some(RelMse {
            rel_mse: sum / pixels,
            rel_mse_low: interval(above).low,
            rel_mse_high: interval(above.max(below)).high,
            confidence,
        })
    }

    /// Per pixel and channel the variance of the mean; `None` while a pixel has not two samples,
    /// one of each replicate.
    ///
    /// That of independent samples follows from their scatter. With samplers that stratify the mean
    /// is better than the scatter says; by how much is told by the replicates of the 7 × 7 pixels
    /// around.
    pub fn variances(&self) -> Option<Vec<[f64; 3]>> {
        let squares = self.squared_half_differences()?;
        let scatter: Option<Vec<_>> = self
            .pixels
            .par_iter()
            .map(|p| p.variance_of_mean())
            .collect();
        let scatter = scatter?;
        if self.sampler.is_independent() {
            return Some(scatter);
        }
        let by_replicates = box_mean(&squares, self.size, VARIANCE_RADIUS);
        let by_scatter = box_mean(&scatter, self.size, VARIANCE_RADIUS);
        let pixels = scatter.par_iter().zip(by_replicates).zip(by_scatter);
        let scaled = pixels.map(|((scatter, replicates), around)| {
            [0, 1, 2].map(|c| scatter[c] * replicates[c] / around[c].max(f64::MIN_POSITIVE))
        });
        Some(scaled.collect())
    }

    /// What the image suggests for the square of the truth, pixel by pixel; `noise` are squares of
    /// each pixel's noise.
    ///
    /// A pixel's own square would not do: where it is too bright by chance, its error would be
    /// divided by the too bright value, and where samples are skewed that is just where the error
    /// is large. So it is first the local mean as far as the pixels around differ by no more than
    /// their noise, whose mean over so few pixels is known to a factor of two (Lee 1980, "Digital
    /// Image Enhancement and Noise Filtering by Use of Local Statistics"). With x the value found
    /// so and h half the difference of what the replicates say, r² is taken as x² − h²·(1 − h²/x²):
    /// without the noise h² in x², but x² itself where one replicate alone has met any light (h =
    /// x), as nothing is known of such a pixel.
    ///
    /// A pixel brighter than those around is told from one with a rare bright sample by its
    /// replicates: the lesser of them is what the pixel has at the least, and its square is what r²
    /// is taken for where that is more and the replicates' noise is large beside it.
    fn squared_truth(&self, noise: &[[f64; 3]]) -> Option<Vec<[SquaredTruth; 3]>> {
        let replicates: Option<Vec<_>> = self.pixels.par_iter().map(Pixel::replicates).collect();
        let replicates = replicates?;
        let values: Vec<_> = self.pixels.par_iter().map(|p| p.mean).collect();
        let squares: Vec<_> = values.par_iter().map(|v| v.map(|v| v * v)).collect();
        let around = |values: &[[f64; 3]]| box_mean(values, self.size, MEAN_RADIUS);
        let (local, squares, noise_around) = (around(&values), around(&squares), around(noise));
        let others = mean_of_others(&local, &values, self.size, MEAN_RADIUS);
        let truth = (0..values.len()).into_par_iter().map(|i| {
            [0, 1, 2].map(|c| {
                let mean = local[i][c];
                let spread = squares[i][c] - mean * mean;
                let signal = (spread - 2.0 * noise_around[i][c]).max(0.0);
                let keep = if spread > 0.0 { signal / spread } else { 0.0 };
                let [a, b] = replicates[i].map(|r| mean + keep * (r[c] - mean));
                let (square, left) = ((0.5 * (a + b)).powi(2), (0.5 * (a - b)).powi(2));
                let share = if square > left { left / square } else { 1.0 };
                let square = square * (1.0 - share * (1.0 - share));
                let lesser = replicates[i][0][c].min(replicates[i][1][c]);
                let doubt = noise[i][c] / (noise[i][c] + square).max(f64::MIN_POSITIVE);
                let square = square.max(doubt * lesser * lesser);
                SquaredTruth {
                    square,
                    least: square.min(lesser.max(others[i][c]).powi(2)),
                    noise: keep * keep + (1.0 - keep * keep) / LOCAL_PIXELS,
                }
            })
        });
        Some(truth.collect())
    }

    fn squared_half_differences(&self) -> Option<Vec<[f64; 3]>> {
        let halves = self.half_differences()?;
        Some(halves.into_par_iter().map(|h| h.map(|h| h * h)).collect())
    }

    fn half_differences(&self) -> Option<Vec<[f64; 3]>> {
        self.pixels
            .par_iter()
            .map(|p| p.half_difference())
            .collect()
    }

    /// Standard error of [`mean`](Self::mean); `None` while a pixel has not two samples, one of
    /// each replicate.
    pub fn standard_error_of_mean(&self) -> Option<[f64; 3]> {
        if self.sampler.is_independent() {
            return self.independent_standard_error_of_mean();
        }
        let sums = tile_sums(
            self.half_differences()?,
            self.size,
            self.sampler.independent_side(),
        );
        let squares = sums.into_iter().map(|s| s.map(|s| s * s));
        let sum = squares.fold([0.0; 3], add);
        Some(sum.map(|s| s.sqrt() / self.pixels.len() as f64))
    }

    /// A standard error of [`mean`](Self::mean) to judge it by: where the replicates of too few
    /// parts of the image would have to tell it, what the scatter of the samples says, which is
    /// larger.
    pub fn cautious_standard_error_of_mean(&self) -> Option<[f64; 3]> {
        let parts = self.pixels.len() / self.sampler.independent_side().pow(2) as usize;
        if parts < FEWEST_PARTS {
            self.independent_standard_error_of_mean()
        } else {
            self.standard_error_of_mean()
        }
    }

    /// Standard error of [`mean`](Self::mean) if each sample had been drawn by itself: too large
    /// with samplers that stratify. `None` while a pixel has fewer than two samples.
    pub fn independent_standard_error_of_mean(&self) -> Option<[f64; 3]> {
        let variances: Option<Vec<_>> = self
            .pixels
            .par_iter()
            .map(|p| p.variance_of_mean())
            .collect();
        let sum = variances?.into_iter().fold([0.0; 3], add);
        Some(sum.map(|s| s.sqrt() / self.pixels.len() as f64))
    }
}

fn add(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// Parts of an image, independent of each other, whose replicates tell its mean's error well enough
/// to judge the mean by.
const FEWEST_PARTS: usize = 32;

/// Sums over tiles of `side` × `side` pixels, row by row.
pub fn tile_sums<const N: usize>(
    values: Vec<[f64; N]>,
    size: FilmSize,
    side: u32,
) -> Vec<[f64; N]> {
    if side == 1 {
        return values;
    }
    let (width, side) = (size.width as usize, side as usize);
    let per_row = width.div_ceil(side);
    let mut sums = vec![[0.0; N]; per_row * (size.height as usize).div_ceil(side)];
    for (i, value) in values.into_iter().enumerate() {
        let sum = &mut sums[i / width / side * per_row + i % width / side];
        for (sum, value) in sum.iter_mut().zip(value) {
            *sum += value;
        }
    }
    sums
}

#[cfg(test)]
mod tests;
