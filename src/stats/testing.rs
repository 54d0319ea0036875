//! Random numbers for the tests of the tests: counters through a hash, so that every run draws the
//! same.

use super::sidak::Family;
use std::f64::consts::TAU;

/// A stream of random numbers (`SplitMix64`: Steele, Lea & Flood 2014).
#[derive(Debug)]
pub struct Stream(u64);

impl Stream {
    /// The stream of number `seed`.
    pub fn new(seed: u64) -> Self {
        Self(seed << 40)
    }

    fn word(&mut self) -> u64 {
        self.0 += 1;
        let mut z = self.0.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in (0, 1).
    pub fn uniform(&mut self) -> f64 {
        ((self.word() >> 12) as f64 + 0.5) * (-52_f64).exp2()
    }

    /// Standard normal (Box & Muller 1958).
    pub fn normal(&mut self) -> f64 {
        (-2.0 * self.uniform().ln()).sqrt() * (TAU * self.uniform()).cos()
    }
}

/// Experiments under the null hypothesis that a test of the rate is made of.
pub const EXPERIMENTS: u32 = 20_000;

/// Asserts that `p_value`, fed with experiments in which the null hypothesis holds, is below 1 % in
/// 1 % of them.
///
/// The number of rejections is binomial with mean 200 and standard deviation √(20,000·0.01·0.99) =
/// 14.07. Its normal bound at the family's level over the crate's ten such tests is z = 4.42, that
/// is 62. `excess` is what the p-value's own approximation may add to the rate (Cochran 1952 for
/// χ²), in rejections.
pub fn assert_rejects_at_its_rate(excess: f64, mut p_value: impl FnMut(&mut Stream) -> f64) {
    let mut stream = Stream::new(1);
    let rejected = (0..EXPERIMENTS)
        .filter(|_| p_value(&mut stream) < 0.01)
        .count() as f64;
    let mean = 0.01 * f64::from(EXPERIMENTS);
    let bound = Family::new(10).z_bound() * (0.99 * mean).sqrt() + excess;
    assert!(
        (rejected - mean).abs() <= bound,
        "{rejected} rejections, expected {mean} within {bound}"
    );
}
