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
    pub variance: [f64; 3],
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
    ///
    /// Of samples that are drawn each by itself the variance follows from their scatter. With
    /// samplers that stratify the mean is better than the scatter says; by how much is told by the
    /// replicates of the 7 × 7 pixels around.
    pub(super) fn of(film: &Film) -> Option<Self> {
        let pixels = film.pixels.par_iter().map(|pixel| {
            Some(PixelEvidence {
                squared: pixel.half_difference()?.map(|half| half * half),
                variance: pixel.variance_of_mean()?,
                by_replicate: pixel.variances_by_replicate()?,
            })
        });
        let pixels: Option<Vec<_>> = pixels.collect();
        let mut pixels = pixels?;
        let independent = film.sampler.is_independent();
        if !independent {
            reduce_to_replicates(&mut pixels, film.size);
        }
        Some(Self {
            size: film.size,
            pixels,
            independent,
            replicates: if independent {
                film.mean_samples() as f64
            } else {
                2.0
            },
        })
    }

    /// Per pixel and channel the variance of the mean.
    pub(super) fn variances(&self) -> Vec<[f64; 3]> {
        self.pixels.par_iter().map(|pixel| pixel.variance).collect()
    }
}

/// Multiplies what the scatter says by what the replicates around say of it.
fn reduce_to_replicates(pixels: &mut [PixelEvidence], size: FilmSize) {
    let around = |values: fn(&PixelEvidence) -> [f64; 3]| {
        let values: Vec<_> = pixels.par_iter().map(values).collect();
        box_mean(&values, size, RADIUS)
    };
    let by_replicates = around(|pixel| pixel.squared);
    let by_scatter = around(|pixel| pixel.variance);
    let around = by_replicates.into_par_iter().zip(by_scatter);
    pixels
        .par_iter_mut()
        .zip(around)
        .for_each(|(pixel, (replicates, scatter))| {
            for c in 0..3 {
                let part = if scatter[c] > 0.0 {
                    replicates[c] / scatter[c]
                } else {
                    0.0
                };
                pixel.variance[c] *= part;
                pixel.by_replicate[0][c] *= part;
                pixel.by_replicate[1][c] *= part;
            }
        });
}
