//! The film: per pixel the merged mean and variance, in f64.

use crate::gpu::layout::{GroupMean, PixelState};
use crate::scene::{EstimatorSettings, FilmSize, Sampler, ShadowRays};
use crate::stats::moments::Moments;
use crate::stats::sums::sum;
use rayon::prelude::*;

/// One pixel's samples so far: per channel the [`Moments`], which share their count, and those of
/// the second of two independent *replicates*, that of the samples with odd indices.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Pixel {
    /// Number of finite samples.
    pub samples: u64,
    /// Mean radiance.
    pub mean: [f64; 3],
    /// Sum of squared deviations from the mean.
    pub m2: [f64; 3],
    /// Number of finite samples of the second replicate.
    pub second_samples: u64,
    /// Mean radiance of the second replicate.
    pub second_mean: [f64; 3],
    /// Sum of squared deviations of the second replicate from its mean.
    pub second_m2: [f64; 3],
    /// Sum over all samples of the squared radiance of light that they should have met, as near misses
    /// of small lights tell; see `shaders/kernel/near_misses.wesl`.
    pub expected_squares: f64,
    /// How often they should have met light of small lights.
    pub expected_hits: f64,
}

impl Pixel {
    /// Adds a block of samples.
    pub fn merge(&mut self, block: &PixelState) {
        self.merge_in(1.0, block);
    }

    /// The same for a block whose radiance is in multiples of `unit`.
    fn merge_in(&mut self, unit: f64, block: &PixelState) {
        for c in 0..3 {
            let mut channel = self.channel(c);
            channel.merge(&Moments {
                count: u64::from(block.samples),
                mean: unit * f64::from(block.mean[c]),
                m2: unit * unit * f64::from(block.m2[c]),
            });
            (self.mean[c], self.m2[c]) = (channel.mean, channel.m2);
        }
        self.samples += u64::from(block.samples);
        for c in 0..3 {
            let mut channel = self.second_channel(c);
            channel.merge(&Moments {
                count: u64::from(block.second_samples),
                mean: unit * f64::from(block.second_mean[c]),
                m2: unit * unit * f64::from(block.second_m2[c]),
            });
            (self.second_mean[c], self.second_m2[c]) = (channel.mean, channel.m2);
        }
        self.second_samples += u64::from(block.second_samples);
        if block.expected_squares.is_finite() {
            let squares = unit * unit * f64::from(block.expected_squares);
            self.add_expected(squares, f64::from(block.expected_hits));
        }
    }

    /// As `add_expected` of `shaders/kernel/near_misses.wesl`: of two kinds of hits, whose squares are
    /// more than ten times apart, those count that add more to the mean.
    fn add_expected(&mut self, squares: f64, hits: f64) {
        let (its, others) = (squares * self.expected_hits, self.expected_squares * hits);
        if its <= 10.0 * others && others <= 10.0 * its {
            self.expected_squares += squares;
            self.expected_hits += hits;
        } else if squares * hits > self.expected_squares * self.expected_hits {
            (self.expected_squares, self.expected_hits) = (squares, hits);
        }
    }

    /// The moments of one channel.
    pub fn channel(&self, c: usize) -> Moments {
        Moments {
            count: self.samples,
            mean: self.mean[c],
            m2: self.m2[c],
        }
    }

    /// The moments of one channel of the second replicate.
    pub fn second_channel(&self, c: usize) -> Moments {
        Moments {
            count: self.second_samples,
            mean: self.second_mean[c],
            m2: self.second_m2[c],
        }
    }

    /// Per channel the variance of the mean over all samples, as if each had been drawn by itself,
    /// as the scatter of either replicate alone tells it: the two are independent of each other.
    /// Zero for a replicate of fewer than two samples; `None` while one has none.
    pub fn variances_by_replicate(&self) -> Option<[[f64; 3]; 2]> {
        let replicates = self.replicates()?;
        let n = self.samples as f64;
        let [first, second] = [self.samples - self.second_samples, self.second_samples];
        let between = first as f64 * second as f64 / n;
        let variance = |m2: f64, samples: u64| m2.max(0.0) / (n * samples.max(2) as f64 - n);
        let of_first = |c: usize| {
            let difference = replicates[0][c] - replicates[1][c];
            let m2 = self.m2[c] - self.second_m2[c] - difference * difference * between;
            variance(m2, first)
        };
        let of_second = |c: usize| variance(self.second_m2[c], second);
        Some([[0, 1, 2].map(of_first), [0, 1, 2].map(of_second)])
    }

    /// Variance of the mean per channel, as if each sample had been drawn by itself; `None` below
    /// two samples.
    pub fn variance_of_mean(&self) -> Option<[f64; 3]> {
        let n = self.samples as f64;
        (self.samples > 1).then(|| self.m2.map(|m2| m2 / (n * (n - 1.0))))
    }

    /// The two replicates' means; `None` while one has no sample.
    pub fn replicates(&self) -> Option<[[f64; 3]; 2]> {
        let first = (self.samples - self.second_samples) as f64;
        let part = self.second_samples as f64 / first;
        let of_first = |c: usize| self.mean[c] + (self.mean[c] - self.second_mean[c]) * part;
        (first > 0.0 && self.second_samples > 0)
            .then(|| [[0, 1, 2].map(of_first), self.second_mean])
    }

    /// Per channel half the difference of the two replicates, scaled where their numbers of samples
    /// a and b differ: it has the mean zero and the variance of the mean over all samples. `None`
    /// while a replicate has no sample.
    ///
    /// With A and B the replicates' means, (A − B)·√(ab)/(a + b) = (mean − B)·√(b/a).
    pub fn half_difference(&self) -> Option<[f64; 3]> {
        let (first, second) = (self.samples - self.second_samples, self.second_samples);
        let factor = (second as f64 / first as f64).sqrt();
        (first > 0 && second > 0)
            .then(|| [0, 1, 2].map(|c| (self.mean[c] - self.second_mean[c]) * factor))
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
        let firsts = [&mut self.first_nan, &mut self.first_infinite];
        for (first, position) in firsts.into_iter().zip(state.first_bad()) {
            let Some(position) = position else {
                continue;
            };
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
    /// How its samples' random numbers were made.
    pub sampler: Sampler,
    /// Shadow rays per camera ray, with light selection `all` per light.
    pub shadow_rays: u32,
    /// Radiance that the blocks which are merged have as 1: a power of two.
    pub unit: f64,
    /// Pixels, row by row from the top.
    pub pixels: Vec<Pixel>,
    /// What was dropped.
    pub ledger: Ledger,
    /// Mean radiance of each group of lights, row by row; none where they are not kept apart.
    pub light_groups: Vec<Vec<[f64; 3]>>,
}

impl Film {
    /// A film without samples, for those of `sampler`.
    pub fn new(size: FilmSize, sampler: Sampler) -> Self {
        Self {
            size,
            sampler,
            shadow_rays: 1,
            unit: 1.0,
            pixels: vec![Pixel::default(); size.pixels()],
            ledger: Ledger::default(),
            light_groups: Vec::new(),
        }
    }

    /// The same with `groups` groups of lights.
    #[must_use]
    pub fn with_light_groups(self, groups: usize) -> Self {
        Self {
            light_groups: vec![vec![[0.0; 3]; self.pixels.len()]; groups],
            ..self
        }
    }

    /// The same for blocks whose radiance is in multiples of `unit`.
    #[must_use]
    pub fn in_units_of(self, unit: f64) -> Self {
        Self { unit, ..self }
    }

    /// One alike without samples.
    #[must_use]
    pub fn emptied(&self) -> Self {
        let shadow_rays = self.shadow_rays;
        let film = Self::new(self.size, self.sampler)
            .with_light_groups(self.light_groups.len())
            .in_units_of(self.unit);
        Self {
            shadow_rays,
            ..film
        }
    }

    /// `settings` as they were used: with the number of shadow rays where they leave it open.
    pub fn settings_of(&self, settings: EstimatorSettings) -> EstimatorSettings {
        match settings.shadow_rays {
            ShadowRays::Auto => EstimatorSettings {
                shadow_rays: ShadowRays::Number(self.shadow_rays),
                ..settings
            },
            ShadowRays::Number(_) => settings,
        }
    }

    /// Adds a block of the pixel `index`: `groups` are its groups' means.
    pub fn merge(&mut self, index: usize, block: &PixelState, groups: &[GroupMean]) {
        self.pixels[index].merge_in(self.unit, block);
        if block.samples == 0 {
            return;
        }
        let part = f64::from(block.samples) / self.pixels[index].samples as f64;
        for (image, group) in self.light_groups.iter_mut().zip(groups) {
            for (mean, bits) in image[index].iter_mut().zip(group) {
                *mean += (self.unit * f64::from(f32::from_bits(*bits)) - *mean) * part;
            }
        }
    }

    /// Mean of each channel over the image.
    pub fn mean(&self) -> [f64; 3] {
        let sum = sum(self.pixels.par_iter().map(|p| p.mean));
        sum.map(|s| s / self.pixels.len() as f64)
    }

    /// Samples per pixel on average, rounded up.
    pub fn mean_samples(&self) -> u64 {
        let samples: u64 = self.pixels.iter().map(|p| p.samples).sum();
        samples.div_ceil(self.pixels.len() as u64)
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

    /// The block that begins with an even sample.
    fn block(values: &[f32]) -> PixelState {
        let mut state = PixelState::default();
        for (i, &x) in values.iter().enumerate() {
            state.samples += 1;
            let second = i % 2;
            state.second_samples += second as u32;
            for c in 0..3 {
                let delta = x - state.mean[c];
                state.mean[c] += delta / state.samples as f32;
                state.m2[c] += delta * (x - state.mean[c]);
                let delta = (x - state.second_mean[c]) * second as f32;
                state.second_mean[c] += delta / state.second_samples.max(1) as f32;
                state.second_m2[c] += delta * (x - state.second_mean[c]);
            }
        }
        state
    }

    /// Rare bright hits and many dim ones stay apart: what adds more to the mean is kept.
    #[test]
    fn expected_hits_of_one_kind_add_up() {
        let mut pixel = Pixel::default();
        pixel.add_expected(100.0, 1.0);
        pixel.add_expected(150.0, 1.0);
        assert_eq!((pixel.expected_squares, pixel.expected_hits), (250.0, 2.0));
        // Their square is 10⁸, and they add 10⁻² to the squared mean: less than those before.
        pixel.add_expected(1e3, 1e-5);
        assert_eq!((pixel.expected_squares, pixel.expected_hits), (250.0, 2.0));
        pixel.add_expected(1e9, 1e-5);
        assert_eq!((pixel.expected_squares, pixel.expected_hits), (1e9, 1e-5));
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
        let odd = values.iter().skip(1).step_by(2);
        let second = odd.map(|&x| f64::from(x)).sum::<f64>() / 500.0;
        assert_eq!(pixel.second_samples, 500);
        assert!((pixel.second_mean[2] - second).abs() < 1e-6 * second);
        let half = pixel.half_difference().expect("1000 samples")[0];
        assert!((half - (mean - second)).abs() < 1e-5);
        let told = pixel.variances_by_replicate().expect("1000 samples");
        for (first, told) in told.into_iter().enumerate() {
            let values = values.iter().skip(first).step_by(2);
            let replicate: Moments = values.map(|&x| f64::from(x)).collect();
            let expected = replicate.variance().expect("500 samples") / n;
            assert!((told[1] - expected).abs() < 1e-5 * expected, "{told:?}");
        }
    }

    #[test]
    fn replicates_may_differ_in_size() {
        // Means A = 3 of one sample and B = 1 of three: (A − B)·√(1·3)/4.
        let pixel = Pixel {
            samples: 4,
            mean: [1.5; 3],
            second_samples: 3,
            second_mean: [1.0; 3],
            ..Pixel::default()
        };
        let half = pixel.half_difference().expect("both have samples")[1];
        assert!((half - 2.0 * 3.0_f64.sqrt() / 4.0).abs() < 1e-12);
        // The first has one sample, and no scatter; the second has three of the sum 6.
        let scattered = Pixel {
            m2: [9.0; 3],
            second_m2: [6.0; 3],
            ..pixel
        };
        let [first, second] = scattered
            .variances_by_replicate()
            .expect("both have samples");
        assert!(first.iter().all(|v| v.abs() < f64::MIN_POSITIVE));
        assert!((second[0] - 6.0 / (4.0 * 2.0)).abs() < 1e-12);
        let alone = Pixel {
            samples: 3,
            ..pixel
        };
        assert!(alone.half_difference().is_none());
    }

    #[test]
    fn variance_survives_a_large_mean() {
        // Mean 100, standard deviation 0.01 (HARD CASES A3): E[x²] − E[x]² would be negative in
        // f32.
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
        let bad = |first_nan: u32, first_infinite: u32| PixelState {
            dropped: 1,
            first_bad: first_infinite << 16 | first_nan,
            ..PixelState::default()
        };
        let mut ledger = Ledger::default();
        ledger.enter(&bad(7, 0xffff), 3, 4, 256);
        ledger.enter(&bad(2, 0xffff), 9, 1, 256);
        ledger.enter(&bad(0xffff, 0), 5, 5, 512);
        ledger.enter(&PixelState::default(), 0, 0, 0);
        assert_eq!(ledger.dropped, 3);
        let first = |x, y, sample| Some(FirstBad { x, y, sample });
        assert_eq!(ledger.first_nan, first(9, 1, 258));
        assert_eq!(ledger.first_infinite, first(5, 5, 512));
    }
}
