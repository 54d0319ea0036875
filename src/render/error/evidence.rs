//! What a film's replicates and samples say about the squared error of its pixels.

use super::chance::RADIUS;
use crate::render::film::Film;
use crate::render::neighbourhood::box_mean;
use crate::scene::FilmSize;
use rayon::prelude::*;

/// What is known about one pixel's error, per channel.
#[derive(Debug, Clone, Copy)]
pub(super) struct PixelEvidence {
    /// Square of half the replicates' difference.
    pub squared: [f64; 3],
    /// Variance of the mean as the scatter of all samples tells it.
    pub scatter: [f64; 3],
    /// The same as the scatter of either replicate tells it.
    pub by_replicate: [[f64; 3]; 2],
}

/// What is known about the errors of a film.
#[derive(Debug, Clone)]
pub(super) struct Evidence {
    pub size: FilmSize,
    pub pixels: Vec<PixelEvidence>,
    /// Whether samples are drawn each by itself.
    pub independent: bool,
    /// Independent replicates that a pixel's error is told by: two, or all samples where these are
    /// drawn each by itself.
    pub replicates: f64,
}

impl Evidence {
    /// That of `film`; `None` while a pixel has not two samples, one of each replicate.
    pub(super) fn of(film: &Film) -> Option<Self> {
        let pixels: Option<Vec<_>> = film
            .pixels
            .par_iter()
            .map(|pixel| {
                Some(PixelEvidence {
                    squared: pixel.half_difference()?.map(|half| half * half),
                    scatter: pixel.variance_of_mean()?,
                    by_replicate: pixel.variances_by_replicate()?,
                })
            })
            .collect();
        let independent = film.sampler.is_independent();
        let replicates = if independent {
            film.mean_samples() as f64
        } else {
            2.0
        };
        Some(Self {
            size: film.size,
            pixels: pixels?,
            independent,
            replicates,
        })
    }

    /// What tells the squared error of a pixel.
    pub(super) fn estimate<'p>(&self, pixel: &'p PixelEvidence) -> &'p [f64; 3] {
        if self.independent {
            &pixel.scatter
        } else {
            &pixel.squared
        }
    }

    /// Per pixel and channel the variance of the mean.
    ///
    /// That of independent samples follows from their scatter. With samplers that stratify the mean
    /// is better than the scatter says; by how much is told by the replicates of the 7 × 7 pixels
    /// around.
    pub(super) fn variances(&self) -> Vec<[f64; 3]> {
        let of_pixels = |values: fn(&PixelEvidence) -> [f64; 3]| -> Vec<[f64; 3]> {
            self.pixels.par_iter().map(values).collect()
        };
        let scatter = of_pixels(|pixel| pixel.scatter);
        if self.independent {
            return scatter;
        }
        let by_replicates = box_mean(&of_pixels(|pixel| pixel.squared), self.size, RADIUS);
        let by_scatter = box_mean(&scatter, self.size, RADIUS);
        let pixels = scatter.par_iter().zip(by_replicates).zip(by_scatter);
        let scaled = pixels.map(|((scatter, replicates), around)| {
            [0, 1, 2].map(|c| scatter[c] * replicates[c] / around[c].max(f64::MIN_POSITIVE))
        });
        scaled.collect()
    }
}
