//! The film: per pixel the merged mean and variance, in f64.

use crate::gpu::layout::PixelState;
use crate::scene::FilmSize;
use crate::stats::moments::Moments;
use rayon::prelude::*;

/// One pixel's samples so far: per channel the [`Moments`], which share their count.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Pixel {
    /// Number of finite samples.
    pub samples: u64,
    /// Mean radiance.
    pub mean: [f64; 3],
    /// Sum of squared deviations from the mean.
    pub m2: [f64; 3],
}

impl Pixel {
    /// Adds a block of samples.
    pub fn merge(&mut self, block: &PixelState) {
        for c in 0..3 {
            let mut channel = self.channel(c);
            channel.merge(&Moments {
                count: u64::from(block.samples),
                mean: f64::from(block.mean[c]),
                m2: f64::from(block.m2[c]),
            });
            (self.mean[c], self.m2[c]) = (channel.mean, channel.m2);
        }
        self.samples += u64::from(block.samples);
    }

    /// The moments of one channel.
    pub fn channel(&self, c: usize) -> Moments {
        Moments {
            count: self.samples,
            mean: self.mean[c],
            m2: self.m2[c],
        }
    }

    /// Variance of the mean per channel; `None` below two samples.
    pub fn variance_of_mean(&self) -> Option<[f64; 3]> {
        let n = self.samples as f64;
        (self.samples > 1).then(|| self.m2.map(|m2| m2 / (n * (n - 1.0))))
    }
}

/// The first sample of a kind that was not finite.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct FirstBad {
    /// Column of the pixel.
    pub x: u32,
    /// Row of the pixel.
    pub y: u32,
    /// Index of the sample.
    pub sample: u64,
}

/// Samples that were dropped because they were not finite.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
pub struct Ledger {
    /// How many.
    pub dropped: u64,
    /// The first that was NaN.
    pub first_nan: Option<FirstBad>,
    /// The first that was infinite.
    pub first_infinite: Option<FirstBad>,
}

impl Ledger {
    /// Enters what a pixel's block dropped; the block begins with sample `block_start`.
    pub fn enter(&mut self, state: &PixelState, x: u32, y: u32, block_start: u64) {
        if state.dropped == 0 {
            return;
        }
        self.dropped += u64::from(state.dropped);
        let entries = [
            (&mut self.first_nan, state.first_nan),
            (&mut self.first_infinite, state.first_infinite),
        ];
        for (first, position) in entries {
            if position == u32::MAX {
                continue;
            }
            let sample = block_start + u64::from(position);
            if first.is_none_or(|f| (sample, y, x) < (f.sample, f.y, f.x)) {
                *first = Some(FirstBad { x, y, sample });
            }
        }
    }
}

/// The image so far.
#[derive(Debug, Clone, PartialEq)]
pub struct Film {
    /// Size in pixels.
    pub size: FilmSize,
    /// Pixels, row by row from the top.
    pub pixels: Vec<Pixel>,
    /// What was dropped.
    pub ledger: Ledger,
}

/// The relative mean squared error of an image, estimated from its own variance.
///
/// relMSE = mean over pixels and channels of `Var / (mean² + 0.01·mean(image)²)`, where `Var` is the variance of the
/// pixel's mean. The interval holds with 95 % confidence: pixels count as independent, and their spread bounds the
/// estimate's own error from above.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct ImageError {
    /// The estimate.
    pub rel_mse: f64,
    /// Lower end of the interval.
    pub rel_mse_low: f64,
    /// Upper end of the interval.
    pub rel_mse_high: f64,
}

impl Film {
    /// A film without samples.
    pub fn new(size: FilmSize) -> Self {
        Self {
            size,
            pixels: vec![Pixel::default(); size.pixels()],
            ledger: Ledger::default(),
        }
    }

    /// Mean of each channel over the image.
    pub fn mean(&self) -> [f64; 3] {
        let sum = self
            .pixels
            .par_iter()
            .map(|p| p.mean)
            .reduce(|| [0.0; 3], |a, b| [a[0] + b[0], a[1] + b[1], a[2] + b[2]]);
        sum.map(|s| s / self.pixels.len() as f64)
    }

    /// Standard error of [`mean`](Self::mean); `None` while a pixel has fewer than two samples.
    pub fn standard_error_of_mean(&self) -> Option<[f64; 3]> {
        let sum = self
            .pixels
            .par_iter()
            .map(Pixel::variance_of_mean)
            .try_reduce(
                || [0.0; 3],
                |a, b| Some([a[0] + b[0], a[1] + b[1], a[2] + b[2]]),
            )?;
        Some(sum.map(|s| s.sqrt() / self.pixels.len() as f64))
    }

    /// The image's error; `None` while a pixel has fewer than two samples, or when the image is black.
    pub fn error(&self) -> Option<ImageError> {
        let mean = self.mean();
        let overall = (mean[0] + mean[1] + mean[2]) / 3.0;
        let floor = 0.01 * overall * overall;
        if floor <= 0.0 {
            return None;
        }
        let terms = self.pixels.par_iter().map(|p| {
            let variance = p.variance_of_mean()?;
            let term: f64 = (0..3)
                .map(|c| variance[c] / (p.mean[c] * p.mean[c] + floor))
                .sum();
            Some((term / 3.0, (term / 3.0) * (term / 3.0)))
        });
        let (sum, squares) =
            terms.try_reduce(|| (0.0, 0.0), |a, b| Some((a.0 + b.0, a.1 + b.1)))?;
        let n = self.pixels.len() as f64;
        let rel_mse = sum / n;
        let spread = (squares / n - rel_mse * rel_mse).max(0.0);
        let half = 1.959_963_984_540_054 * (spread / n).sqrt();
        Some(ImageError {
            rel_mse,
            rel_mse_low: (rel_mse - half).max(0.0),
            rel_mse_high: rel_mse + half,
        })
    }

    /// Fewest and most samples of any pixel.
    pub fn sample_range(&self) -> (u64, u64) {
        let samples = self.pixels.iter().map(|p| p.samples);
        samples.fold((u64::MAX, 0), |(low, high), n| (low.min(n), high.max(n)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(values: &[f32]) -> PixelState {
        let mut state = PixelState::default();
        for &x in values {
            state.samples += 1;
            for c in 0..3 {
                let delta = x - state.mean[c];
                state.mean[c] += delta / state.samples as f32;
                state.m2[c] += delta * (x - state.mean[c]);
            }
        }
        state
    }

    #[test]
    fn merged_blocks_equal_all_samples_at_once() {
        let values: Vec<f32> = (0..1000)
            .map(|i| (i * 7919 % 1000) as f32 / 100.0)
            .collect();
        let mut pixel = Pixel::default();
        for chunk in values.chunks(256) {
            pixel.merge(&block(chunk));
        }
        let n = values.len() as f64;
        let mean = values.iter().map(|&x| f64::from(x)).sum::<f64>() / n;
        let m2: f64 = values.iter().map(|&x| (f64::from(x) - mean).powi(2)).sum();
        assert_eq!(pixel.samples, 1000);
        assert!((pixel.mean[0] - mean).abs() < 1e-6 * mean);
        assert!((pixel.m2[1] - m2).abs() < 1e-5 * m2);
    }

    #[test]
    fn variance_survives_a_large_mean() {
        // Mean 100, standard deviation 0.01 (HARD CASES A3): E[x²] − E[x]² would be negative in f32.
        let values: Vec<f32> = (0..4096)
            .map(|i| 100.0 + if i % 2 == 0 { 0.01 } else { -0.01 })
            .collect();
        let mut pixel = Pixel::default();
        for chunk in values.chunks(256) {
            pixel.merge(&block(chunk));
        }
        let variance = pixel.m2[2] / 4095.0;
        assert!((variance - 1e-4).abs() < 1e-6, "{variance}");
    }

    #[test]
    fn the_ledger_keeps_the_first_of_each_kind() {
        let bad = |first_nan, first_infinite| PixelState {
            dropped: 1,
            first_nan,
            first_infinite,
            ..PixelState::default()
        };
        let mut ledger = Ledger::default();
        ledger.enter(&bad(7, u32::MAX), 3, 4, 256);
        ledger.enter(&bad(2, u32::MAX), 9, 1, 256);
        ledger.enter(&bad(u32::MAX, 0), 5, 5, 512);
        ledger.enter(&PixelState::default(), 0, 0, 0);
        assert_eq!(ledger.dropped, 3);
        let first = |x, y, sample| Some(FirstBad { x, y, sample });
        assert_eq!(ledger.first_nan, first(9, 1, 258));
        assert_eq!(ledger.first_infinite, first(5, 5, 512));
    }
}
