//! The film of a render against the mean of the same samples, recorded one by one and summed in
//! f64.

use super::per_pixel::Accumulator;
use direkt::low_level::render::Film;
use glam::DVec3;
use serde::Serialize;

/// Largest deviation of a pixel's mean, relative to its largest sample. Welford's mean over a block
/// of 256 samples in f32 rounds twice per sample, each time by at most 2⁻²⁴ of the largest: 3·10⁻⁵
/// in the worst case, usually a hundredth of it.
pub const TOLERANCE: f64 = 3e-5;

/// How the film compares with its samples.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Accumulation {
    /// Largest deviation of a mean, relative to the largest sample of its pixel.
    pub largest_deviation: f64,
    /// Samples that the film dropped because they were not finite.
    pub dropped: u64,
}

impl Accumulation {
    /// Compares `film` with the samples' sums in `recorded`; `largest` is each pixel's largest
    /// sample.
    pub(super) fn new(film: &Film, recorded: &Accumulator, largest: &[DVec3]) -> Self {
        let pixels = film.pixels.iter().zip(&recorded.pixels).zip(largest);
        let deviations = pixels.map(|((film, sums), largest)| {
            let off = (DVec3::from_array(film.mean) - sums.gpu_mean()).abs();
            (off / largest.max(DVec3::splat(f64::MIN_POSITIVE))).max_element()
        });
        Self {
            largest_deviation: deviations.fold(0.0, f64::max),
            dropped: film.ledger.dropped,
        }
    }

    /// Whether they agree.
    pub fn agrees(&self) -> bool {
        self.largest_deviation <= TOLERANCE && self.dropped == 0
    }
}
