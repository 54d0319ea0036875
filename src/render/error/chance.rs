//! How far chance takes an image's squared error from what the image's replicates say.
//!
//! With V_i the variance of pixel i, errors that are nearly normal have the sum of squares E =
//! Σ e_i², which is distributed as (ΣV/ν)·χ²_ν with ν = (ΣV)²/ΣV² (Satterthwaite 1946): ν is how
//! many pixels share the error. What the replicates say is distributed alike and independent of it,
//! and so the ratio of both has Fisher's F distribution, whatever V is.
//!
//! ΣV² is the sum of products of *independent* estimates of V, as the square of one estimate would
//! be too large by the estimate's variance, which with heavy tails is most of it. Two products
//! serve, and the larger sum of the two counts: the scatter of the first replicate's samples times
//! that of the second's, which needs no neighbours but misses light that one of them has not met;
//! and a pixel's squared half difference times that of the pixels around, which misses what single
//! pixels have to themselves. Neither knows of a bright sample that one replicate alone has met, in
//! one pixel alone; so the sum counts as no less than the square of what that pixel adds.

use super::evidence::Evidence;
use crate::render::neighbourhood::{box_mean, mean_of_others};
use crate::scene::FilmSize;
use crate::stats::interval::{Interval, fisher};
use crate::stats::sums::sum;
use rayon::prelude::*;

/// Pixels on each side of one that tell what is common to their variances.
pub(super) const RADIUS: usize = 3;

/// The sum over an image's pixels of squared errors, and how many of them share it.
#[derive(Debug, Clone, Copy)]
pub(super) struct SquaredError {
    /// The sum as the image tells it.
    pub sum: f64,
    /// Σ(2V)², the variance of the difference between the sum and what replicates say.
    pub variance: f64,
    /// What the pixel with most of it adds.
    pub largest: f64,
    /// Replicates that a pixel's part is told by.
    pub replicates: f64,
}

impl SquaredError {
    /// That of `evidence`, whose channels count in each pixel with its `weights`, which know nothing
    /// of the pixel's noise. Of samples that are drawn each by itself the scatter tells it.
    pub(super) fn of(evidence: &Evidence, weights: impl Fn(usize) -> [f64; 3] + Sync) -> Self {
        let replicates = evidence.replicates;
        Self::told_by(
            evidence,
            weights,
            usize::from(evidence.independent),
            replicates,
        )
    }

    /// The same by the two replicates whatever the sampler. Where weights come from the same
    /// samples, the scatter of these is the worse guide: a bright sample adds to both.
    pub(super) fn of_two(evidence: &Evidence, weights: impl Fn(usize) -> [f64; 3] + Sync) -> Self {
        Self::told_by(evidence, weights, 0, 2.0)
    }

    /// Told by the squared half differences (0) or the scatter (1).
    fn told_by(
        evidence: &Evidence,
        weights: impl Fn(usize) -> [f64; 3] + Sync,
        which: usize,
        replicates: f64,
    ) -> Self {
        let pixels = evidence.pixels.par_iter().enumerate();
        let weighted: Vec<[f64; 4]> = pixels
            .map(|(i, pixel)| {
                let weights = weights(i);
                let total = |values: [f64; 3]| (0..3).map(|c| weights[c] * values[c]).sum::<f64>();
                [
                    total(pixel.squared),
                    total(pixel.variance),
                    total(pixel.by_replicate[0]),
                    total(pixel.by_replicate[1]),
                ]
            })
            .collect();
        // Σ4V² by the two products.
        let by_replicates = weighted.par_iter().map(|w| [4.0 * w[2] * w[3]]);
        let [by_replicates] = sum(by_replicates);
        let around = by_neighbours(&weighted, evidence.size);
        let parts = weighted.par_iter().map(|w| w[which]);
        let largest = parts.clone().reduce(|| 0.0, f64::max);
        Self {
            sum: sum(parts.map(|part| [part]))[0],
            largest,
            variance: by_replicates.max(around).max(4.0 * largest * largest),
            replicates,
        }
    }

    /// Degrees of freedom: pixels that share the error.
    pub(super) fn freedom(&self) -> f64 {
        4.0 * self.sum * self.sum / self.variance.max(f64::MIN_POSITIVE)
    }

    /// Where the actual sum lies with the probability `confidence`.
    pub(super) fn interval(&self, confidence: f64) -> Interval {
        if self.sum <= 0.0 {
            return Interval::exactly(self.sum);
        }
        let of_actual = self.freedom();
        let of_told = of_actual * (self.replicates - 1.0);
        let end = |below: f64| self.sum * fisher(of_actual, of_told, below);
        Interval {
            value: self.sum,
            low: end(0.5 * (1.0 - confidence)),
            high: end(0.5 * (1.0 + confidence)),
        }
    }
}

/// Σ4V² from each pixel and those around.
fn by_neighbours(weighted: &[[f64; 4]], size: FilmSize) -> f64 {
    let squared: Vec<[f64; 1]> = weighted.par_iter().map(|w| [w[0]]).collect();
    let means = box_mean(&squared, size, RADIUS);
    let others = mean_of_others(&means, &squared, size, RADIUS);
    let pixels = squared.par_iter().zip(&others);
    sum(pixels.map(|([pixel], [others])| [4.0 * pixel * others.max(0.0)]))[0]
}
