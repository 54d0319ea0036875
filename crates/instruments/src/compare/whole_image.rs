//! The image's mean by independent random numbers, GPU against twin.

use super::IMAGE_FAMILY;
use super::per_pixel::{Accumulator, ROUNDING};
use direkt::low_level::stats::pairs::PairSum;
use serde::Serialize;

/// How a channel of the image's mean compares.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ChannelMean {
    /// Mean on the GPU.
    pub gpu: f64,
    /// Mean of the twin.
    pub reference: f64,
    /// GPU minus twin.
    pub difference: f64,
    /// Half the width of the difference's 95 % confidence interval.
    pub half_width: f64,
    /// Self-normalised difference over all pairs of samples of all pixels.
    pub t: f64,
    /// Bound on the probability of one as large.
    pub p_value: f64,
}

/// How the image's mean compares.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WholeImage {
    /// Red, green, blue.
    pub channels: [ChannelMean; 3],
    /// Level of the three tests together.
    pub family_level: f64,
    /// Level of each (Šidák).
    pub test_level: f64,
}

impl WholeImage {
    /// Tests each channel.
    pub fn new(sums: &Accumulator) -> Self {
        let (gpu, reference) = (sums.gpu_mean(), sums.reference_mean());
        let channels = std::array::from_fn(|c| {
            let mut all = PairSum::default();
            for pixel in &sums.pixels {
                all.merge(&pixel.pairs[c]);
            }
            let test = all.test(ROUNDING * reference[c].abs());
            ChannelMean {
                gpu: gpu[c],
                reference: reference[c],
                difference: gpu[c] - reference[c],
                half_width: 1.959_963_984_540_054 * all.squares.sqrt() / all.pairs.max(1) as f64,
                t: test.t,
                p_value: test.p_value,
            }
        });
        Self {
            channels,
            family_level: IMAGE_FAMILY.level,
            test_level: IMAGE_FAMILY.test_level(),
        }
    }

    /// Whether no channel differs.
    pub fn agrees(&self) -> bool {
        let rejects = |c: &ChannelMean| IMAGE_FAMILY.rejects(c.p_value);
        !self.channels.iter().any(rejects)
    }
}
