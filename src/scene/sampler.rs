//! How random numbers are made.

use super::choice::choice;

choice! {
    /// How random numbers are made.
    pub enum Sampler {
        /// Each number by itself.
        Independent,
        /// Pairs of dimensions on a jittered grid for every pixel.
        Stratified,
        /// Pairs of dimensions by Sobol's sequence with Owen's scrambling, one for every pixel
        /// (Burley 2020).
        #[default]
        Sobol,
        /// As `sobol`, with one sequence for all pixels along a Z-shaped curve, so that the errors
        /// of neighbouring pixels differ (Ahmed & Wonka 2020).
        BlueNoise,
    }
}

impl Sampler {
    /// Whether samples are drawn each by itself, so that their scatter tells the error of their
    /// mean.
    pub fn is_independent(self) -> bool {
        self == Self::Independent
    }

    /// Pixels along the side of the squares whose errors count as independent of each other: single
    /// pixels, but under blue noise, where neighbours share a sequence, tiles.
    pub fn independent_side(self) -> u32 {
        match self {
            Self::Independent | Self::Stratified | Self::Sobol => 1,
            Self::BlueNoise => 16,
        }
    }

    /// Numbers that the sampler's pattern is made for, for `spp` samples per pixel in two
    /// replicates: of the jittered grid the logarithms of its columns and rows, of blue noise that
    /// of the samples of a replicate.
    pub fn pattern(self, spp: u64) -> [u32; 2] {
        self.light_pattern(spp, 1)
    }

    /// The same for the light samples of a pixel, `rays` for each of its samples.
    pub fn light_pattern(self, spp: u64, rays: u32) -> [u32; 2] {
        // Larger patterns gain little, and smaller ones can be gone through again; without a number
        // of samples, as when time alone decides, a medium one serves.
        let samples = if spp > MAX_PATTERN {
            32
        } else {
            spp.div_ceil(2)
        };
        let samples = (samples * u64::from(rays)).min(MAX_PATTERN);
        let bits = samples.next_power_of_two().ilog2();
        match self {
            Self::Independent | Self::Sobol => [0, 0],
            Self::Stratified => [bits.div_ceil(2), bits / 2],
            Self::BlueNoise => [bits, 0],
        }
    }
}

/// Samples per pixel of the largest pattern.
const MAX_PATTERN: u64 = 1 << 16;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_hold_the_samples() {
        assert_eq!(Sampler::Stratified.pattern(128), [3, 3]);
        assert_eq!(Sampler::Stratified.pattern(129), [4, 3]);
        assert_eq!(Sampler::Stratified.pattern(1), [0, 0]);
        assert_eq!(Sampler::BlueNoise.pattern(16), [3, 0]);
        assert_eq!(Sampler::BlueNoise.pattern(u64::MAX), [5, 0]);
        assert_eq!(Sampler::Sobol.pattern(1024), [0, 0]);
        assert_eq!(Sampler::Stratified.light_pattern(32, 4), [3, 3]);
        assert_eq!(Sampler::BlueNoise.light_pattern(u64::MAX, 3), [7, 0]);
        assert_eq!(Sampler::BlueNoise.light_pattern(1 << 16, 1024), [16, 0]);
    }
}
