//! What relMSE divides by: the squared truth, which a noisy image does not know.

use super::evidence::Evidence;
use crate::render::film::{Film, Pixel};
use crate::render::neighbourhood::{box_mean, mean_of_others};
use rayon::prelude::*;

/// Pixels on each side of one that tell what it is without its noise.
const RADIUS: usize = 2;
/// Pixels that they are.
const LOCAL_PIXELS: f64 = ((2 * RADIUS + 1) * (2 * RADIUS + 1)) as f64;

/// What an image suggests for the square of the truth in one channel of a pixel.
#[derive(Debug, Clone, Copy)]
pub(super) struct SquaredTruth {
    /// The square.
    pub square: f64,
    /// What it may be at the least.
    pub least: f64,
    /// The variance of its root over that of the pixel: k² + (1 − k²)/n of k times the pixel and 1
    /// − k times the mean of n.
    pub noise: f64,
}

/// What `film` suggests for the square of the truth, pixel by pixel; `None` while a replicate of a
/// pixel has no sample.
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
pub(super) fn squared_truth(film: &Film, evidence: &Evidence) -> Option<Vec<[SquaredTruth; 3]>> {
    let noise: Vec<_> = evidence.pixels.par_iter().map(|p| p.squared).collect();
    let replicates: Option<Vec<_>> = film.pixels.par_iter().map(Pixel::replicates).collect();
    let replicates = replicates?;
    let values: Vec<_> = film.pixels.par_iter().map(|p| p.mean).collect();
    let squares: Vec<_> = values.par_iter().map(|v| v.map(|v| v * v)).collect();
    let around = |values: &[[f64; 3]]| box_mean(values, film.size, RADIUS);
    let (local, squares, noise_around) = (around(&values), around(&squares), around(&noise));
    let others = mean_of_others(&local, &values, film.size, RADIUS);
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

/// `values` with less of their noise: towards the local mean as far as the pixels around differ by
/// no more than their `noise`, which is their variance (Lee 1980, "Digital Image Enhancement and
/// Noise Filtering by Use of Local Statistics").
pub(super) fn smoothed(
    values: &[[f64; 3]],
    noise: &[[f64; 3]],
    evidence: &Evidence,
) -> Vec<[f64; 3]> {
    let around = |values: &[[f64; 3]]| box_mean(values, evidence.size, RADIUS);
    let squares: Vec<_> = values.par_iter().map(|v| v.map(|v| v * v)).collect();
    let (local, squares, noise) = (around(values), around(&squares), around(noise));
    let pixels = (0..values.len()).into_par_iter().map(|i| {
        [0, 1, 2].map(|c| {
            let mean = local[i][c];
            let spread = squares[i][c] - mean * mean;
            let signal = (spread - noise[i][c]).max(0.0);
            let keep = if spread > 0.0 { signal / spread } else { 0.0 };
            mean + keep * (values[i][c] - mean)
        })
    });
    pixels.collect()
}
