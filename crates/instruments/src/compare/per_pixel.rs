//! Means of pixels by independent random numbers, GPU against twin.
//!
//! Sample i of the GPU and sample i of the twin make a pair. If both estimate alike, the difference
//! of a pair is symmetric about zero, whatever the distribution of radiance, and t = Σd/√Σd² is at
//! least as unlikely to be large as [`stats::symmetric`](direkt::low_level::stats::symmetric) says:
//! heavy tails raise no false alarm. For many well-behaved samples t is the z-score of the
//! difference.

use super::{PixelComparison, pixel_family, radiance};
use direkt::low_level::gpu::layout::SampleRecord;
use direkt::low_level::reference::Sample;
use direkt::low_level::stats::pairs::PairSum;
use direkt::scene::FilmSize;
use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

/// How far rounding in f32 may move a mean, relative to it: the criterion for Monte Carlo means in
/// f32.
pub const ROUNDING: f64 = 5e-6;
/// Bins of the histogram of t, from −4 to 4; an odd number, so that zero lies within one.
const BINS: usize = 17;
const HALF_RANGE: f64 = 4.25;

/// Sums while samples come.
#[derive(Debug)]
pub struct Accumulator {
    pub(super) film: FilmSize,
    pub(super) pixels: Vec<PixelSums>,
}

/// Sums of one pixel.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct PixelSums {
    gpu: DVec3,
    reference: DVec3,
    pub(super) pairs: [PairSum; 3],
}

impl PixelSums {
    /// Mean of the twin.
    pub(super) fn reference_mean(&self) -> DVec3 {
        self.reference / self.pairs[0].pairs.max(1) as f64
    }

    /// Mean of the GPU.
    pub(super) fn gpu_mean(&self) -> DVec3 {
        self.gpu / self.pairs[0].pairs.max(1) as f64
    }

    /// t of each channel.
    fn t(&self) -> [f64; 3] {
        let mean = self.reference_mean();
        std::array::from_fn(|c| self.pairs[c].test(ROUNDING * mean[c].abs()).t)
    }
}

impl Accumulator {
    /// Nothing summed yet.
    pub fn new(film: FilmSize) -> Self {
        Self {
            film,
            pixels: vec![PixelSums::default(); film.pixels()],
        }
    }

    /// Adds a pair of samples to every pixel. GPU samples that are not finite count as black.
    pub fn add(&mut self, gpu: &[SampleRecord], reference: &[Sample]) {
        let samples = gpu.par_iter().zip(reference);
        self.pixels
            .par_iter_mut()
            .zip(samples)
            .for_each(|(sums, (gpu, reference))| {
                let gpu = Some(radiance(gpu)).filter(|r| r.is_finite());
                let gpu = gpu.unwrap_or(DVec3::ZERO);
                sums.gpu += gpu;
                sums.reference += reference.radiance;
                for (c, pair) in sums.pairs.iter_mut().enumerate() {
                    pair.add(gpu[c] - reference.radiance[c]);
                }
            });
    }

    /// Mean of the twin over the image.
    pub(super) fn reference_mean(&self) -> DVec3 {
        self.mean(PixelSums::reference_mean)
    }

    /// Mean of the GPU over the image.
    pub(super) fn gpu_mean(&self) -> DVec3 {
        self.mean(PixelSums::gpu_mean)
    }

    fn mean(&self, of: fn(&PixelSums) -> DVec3) -> DVec3 {
        self.pixels.iter().map(of).sum::<DVec3>() / self.pixels.len() as f64
    }

    /// The pixels' means and t.
    pub fn pixels(&self) -> Vec<PixelComparison> {
        let pixel = |p: &PixelSums| PixelComparison {
            gpu: p.gpu_mean(),
            reference: p.reference_mean(),
            t: p.t(),
        };
        self.pixels.iter().map(pixel).collect()
    }
}

/// The pixel that differs most.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct WorstPixel {
    /// Column.
    pub x: u32,
    /// Row.
    pub y: u32,
    /// Channel: 0 red, 1 green, 2 blue.
    pub channel: usize,
    /// Its t.
    pub t: f64,
    /// Bound on the probability of one as large in this pixel and channel.
    pub p_value: f64,
}

/// A bin of the histogram of t.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Bin {
    /// Its middle; the outer bins reach to infinity.
    pub t: f64,
    /// Fraction of the pixels and channels with noise.
    pub found: f64,
    /// Fraction under N(0, 1).
    pub expected: f64,
}

/// How pixels compare.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PerPixel {
    /// Tests: pixels times channels.
    pub tests: usize,
    /// Level of all together.
    pub family_level: f64,
    /// Level of each (Šidák).
    pub test_level: f64,
    /// Pixels and channels that differ.
    pub rejected: usize,
    /// The one that differs most.
    pub worst: Option<WorstPixel>,
    /// Mean of t over pixels and channels with noise; 0 is expected.
    pub mean_t: f64,
    /// Mean of t²; 1 is expected.
    pub mean_t_squared: f64,
    /// The distribution of t beside N(0, 1).
    pub histogram: Vec<Bin>,
}

impl PerPixel {
    /// Tests every pixel and channel.
    pub fn new(sums: &Accumulator) -> Self {
        let family = pixel_family(sums.film);
        let mut worst: Option<WorstPixel> = None;
        let mut rejected = 0;
        let mut noisy = Vec::new();
        for (i, pixel) in sums.pixels.iter().enumerate() {
            let mean = pixel.reference_mean();
            for (channel, pair) in pixel.pairs.iter().enumerate() {
                let test = pair.test(ROUNDING * mean[channel].abs());
                rejected += usize::from(family.rejects(test.p_value));
                if pair.squares > 0.0 {
                    noisy.push(test.t);
                }
                if worst.is_none_or(|w| test.t.abs() > w.t.abs()) {
                    worst = Some(WorstPixel {
                        x: i as u32 % sums.film.width,
                        y: i as u32 / sums.film.width,
                        channel,
                        t: test.t,
                        p_value: test.p_value,
                    });
                }
            }
        }
        let n = noisy.len().max(1) as f64;
        Self {
            tests: family.tests,
            family_level: family.level,
            test_level: family.test_level(),
            rejected,
            worst,
            mean_t: noisy.iter().sum::<f64>() / n,
            mean_t_squared: noisy.iter().map(|t| t * t).sum::<f64>() / n,
            histogram: histogram(&noisy),
        }
    }

    /// Whether no pixel differs.
    pub fn agrees(&self) -> bool {
        self.rejected == 0
    }
}

fn histogram(t: &[f64]) -> Vec<Bin> {
    let width = 2.0 * HALF_RANGE / BINS as f64;
    let mut counts = [0_usize; BINS];
    for t in t {
        let bin = ((t + HALF_RANGE) / width).floor();
        counts[bin.clamp(0.0, (BINS - 1) as f64) as usize] += 1;
    }
    let below = |edge: usize| match edge {
        0 => 0.0,
        BINS => 1.0,
        _ => direkt::low_level::stats::normal_below(edge as f64 * width - HALF_RANGE),
    };
    let bin = |i: usize| Bin {
        t: (i as f64 + 0.5) * width - HALF_RANGE,
        found: counts[i] as f64 / t.len().max(1) as f64,
        expected: below(i + 1) - below(i),
    };
    (0..BINS).map(bin).collect()
}
