//! Which random number goes where; see `shaders/core/sampler.wesl`.

use super::rng::pcg4d;

/// Film x, film y, lens x, lens y.
pub const GROUP_FILM: u32 = 0;
/// Light choice, light point x, light point y, lobe.
pub const GROUP_LIGHT: u32 = 1;
/// Direction x, direction y, environment texel, –.
pub const GROUP_DIRECTION: u32 = 2;

/// Names one sample of one pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SampleId {
    /// Index of the pixel, row by row.
    pub pixel: u32,
    /// Index of the sample.
    pub index: u64,
    /// The render's seed.
    pub seed: u32,
}

/// The four random words of a group of dimensions.
pub fn random_group(id: SampleId, group: u32) -> [u32; 4] {
    let (low, high) = (id.index as u32, (id.index >> 32) as u32);
    let group = group.wrapping_mul(0x9e37_79b9);
    pcg4d([id.pixel, low, high.wrapping_add(group), id.seed])
}
