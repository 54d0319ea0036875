//! Standard errors of pixels and of the image's mean.

use super::evidence::Evidence;
use crate::render::film::Film;
use crate::scene::FilmSize;
use rayon::prelude::*;

impl Film {
    /// Per pixel and channel the variance of the mean; `None` while a pixel has not two samples,
    /// one of each replicate.
    ///
    /// Of samples that are drawn each by itself from their scatter; of others their replicates say
    /// how much less than the scatter it is.
    pub fn variances(&self) -> Option<Vec<[f64; 3]>> {
        Evidence::of(self).map(|evidence| evidence.variances())
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
