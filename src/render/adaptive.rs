//! Adaptive sampling: more samples where the error is.
//!
//! After a pilot, the same for all pixels, pixels take samples in proportion to the root of their
//! squared error, which is what makes the sum of errors that fall with the inverse of the samples
//! smallest at a given number of them (Neyman 1934). A pixel's error is the sum of its parts of the
//! image's NMSE and of its relMSE, so that neither is had at the other's cost. How large it is in a
//! block of 4 × 2 pixels is told by the replicates of the pixels *around* the block. Its own samples
//! have no say: pixels that got more samples because their first ones were bright, or fewer because
//! they were dark, would have a biased mean (Kirk & Arvo 1991, "Unbiased Sampling Techniques for
//! Image Synthesis"). For the same reason the shares stay as the pilot gave them.
//!
//! Every pixel has a power of two of samples at any time, which is what stratified samplers are
//! best at.

use super::film::Film;
use crate::scene::FilmSize;
use crate::stats::sums::sum;
use rayon::prelude::*;

/// Samples of the pilot; later powers of two where it found no light.
pub(super) const PILOT: u64 = 16;
/// Columns and rows of a block of pixels that have the same number of samples: eight neighbouring
/// lanes of the kernel.
const BLOCK: [u32; 2] = [4, 2];
/// Pixels on each side of a block that tell its error.
const RADIUS: u32 = 2;
/// Classes to an octave of samples.
const PER_OCTAVE: u32 = 8;
/// Octaves between the pixels with fewest and with most samples.
const OCTAVES: u32 = 7;
/// Classes of pixels.
pub(super) const CLASSES: usize = (PER_OCTAVE * OCTAVES) as usize;
/// The class of a pixel with the mean error: eight times fewer samples at the least, sixteen times
/// more at most.
const MIDDLE: f64 = (3 * PER_OCTAVE) as f64;

/// How samples are shared out among pixels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Allocation {
    /// Samples of the pilot.
    pilot: u64,
    /// Class of each pixel, row by row: eight classes higher are twice the samples.
    classes: Vec<u8>,
    /// Pixels of each class.
    pixels: Vec<u64>,
}

impl Allocation {
    /// How those after the `pilot`, of `samples` per pixel, are shared out; `None` while a pixel
    /// has not two samples, or no difference between replicates tells where the error is.
    pub(crate) fn after(pilot: &Film, samples: u64) -> Option<Self> {
        let mean = pilot.mean();
        let overall = (mean[0] + mean[1] + mean[2]) / 3.0;
        let floor = 0.01 * overall * overall;
        let halves: Option<Vec<_>> = pilot.pixels.iter().map(|p| p.half_difference()).collect();
        let halves = halves?;
        let size = pilot.size;
        let blocks_per_row = size.width.div_ceil(BLOCK[0]);
        let blocks = 0..blocks_per_row * size.height.div_ceil(BLOCK[1]);
        let errors = blocks.into_par_iter().map(|block| -> [f64; 2] {
            let corner = [block % blocks_per_row, block / blocks_per_row];
            let (mut squares, mut values, mut count) = ([0.0; 3], [0.0; 3], 0.0);
            for pixel in around(size, corner) {
                for c in 0..3 {
                    squares[c] += halves[pixel][c].powi(2);
                    values[c] += pilot.pixels[pixel].mean[c];
                }
                count += 1.0;
            }
            if count == 0.0 {
                return [0.0; 2];
            }
            let relative =
                |c: usize| squares[c] * count / (values[c].powi(2) + floor * count * count);
            let absolute = |c: usize| squares[c] / count;
            [
                absolute(0) + absolute(1) + absolute(2),
                relative(0) + relative(1) + relative(2),
            ]
        });
        let errors: Vec<[f64; 2]> = errors.collect();
        let [absolute, relative] = sum(errors.par_iter().copied());
        if absolute <= 0.0 || relative <= 0.0 {
            return None;
        }
        let errors = errors.par_iter();
        let errors = errors.map(|e| (e[0] / absolute + e[1] / relative).sqrt());
        let errors: Vec<f64> = errors.collect();
        let [sum] = sum(errors.par_iter().map(|error| [*error]));
        let middle = sum / errors.len() as f64;
        if !(middle > 0.0 && middle.is_finite()) {
            return None;
        }
        let highest = (CLASSES - 1) as f64;
        let class = |error: f64| {
            let octaves = (error / middle).max(f64::MIN_POSITIVE).log2();
            (MIDDLE + f64::from(PER_OCTAVE) * octaves).clamp(0.0, highest) as u8
        };
        let of_pixel = |pixel: usize| {
            let (x, y) = (pixel as u32 % size.width, pixel as u32 / size.width);
            class(errors[(y / BLOCK[1] * blocks_per_row + x / BLOCK[0]) as usize])
        };
        let classes: Vec<_> = (0..halves.len()).map(of_pixel).collect();
        let mut pixels = vec![0; CLASSES];
        for class in &classes {
            pixels[usize::from(*class)] += 1;
        }
        Some(Self {
            pilot: samples,
            classes,
            pixels,
        })
    }

    /// Class of the pixel `index`.
    pub(crate) fn class(&self, index: usize) -> usize {
        usize::from(self.classes[index])
    }

    /// Samples of the pixels of `class` at a `level`: eight levels higher are twice the samples.
    pub(crate) fn target(&self, level: u32, class: usize) -> u64 {
        let octave = (level + class as u32) / PER_OCTAVE;
        (1_u64 << octave.min(40)).max(self.pilot)
    }

    /// The first level from `level` on at which the mean number of samples is `mean` at least.
    pub(crate) fn level_of(&self, mean: u64, level: u32) -> u32 {
        let reached = |level: u32| {
            let targets = (0..CLASSES).map(|class| self.target(level, class));
            self.mean(targets) >= mean
        };
        let levels = level..PER_OCTAVE * 40;
        levels.into_iter().find(|l| reached(*l)).unwrap_or(level)
    }

    /// The mean over the image where the pixels of each class have `samples`, rounded down.
    pub(crate) fn mean(&self, samples: impl Iterator<Item = u64>) -> u64 {
        let classes = self.pixels.iter().zip(samples);
        let total: u64 = classes.map(|(pixels, samples)| pixels * samples).sum();
        total / self.classes.len() as u64
    }
}

/// The pixels at most `RADIUS` away from a block and not in it.
fn around(size: FilmSize, block: [u32; 2]) -> impl Iterator<Item = usize> {
    let inside = [0, 1].map(|i| block[i] * BLOCK[i]..(block[i] + 1) * BLOCK[i]);
    let near = |i: usize, length: u32| {
        inside[i].start.saturating_sub(RADIUS)..(inside[i].end + RADIUS).min(length)
    };
    let (columns, rows) = (near(0, size.width), near(1, size.height));
    rows.flat_map(move |y| columns.clone().map(move |x| (x, y)))
        .filter(move |(x, y)| !(inside[0].contains(x) && inside[1].contains(y)))
        .map(move |at| size.index(at))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Pixel;
    use crate::scene::{FilmSize, Sampler};

    /// 32 × 32 pixels after the pilot: those of the right half have a hundred times the squared
    /// error.
    fn pilot() -> Film {
        let size = FilmSize {
            width: 32,
            height: 32,
        };
        let mut film = Film::new(size, Sampler::Sobol);
        for (i, pixel) in film.pixels.iter_mut().enumerate() {
            let half = if i % 32 < 16 { 0.01 } else { 0.1 };
            *pixel = Pixel {
                samples: PILOT,
                mean: [1.0; 3],
                m2: [1.0; 3],
                second_samples: PILOT / 2,
                second_mean: [1.0 - half; 3],
                ..Pixel::default()
            };
        }
        film
    }

    #[test]
    fn samples_follow_the_root_of_the_error() {
        let allocation = Allocation::after(&pilot(), PILOT).expect("there is an error");
        let (low, high) = (allocation.class(0), allocation.class(31));
        // Ten times as many are 3.3 octaves of eight classes.
        assert!((high - low).abs_diff(27) <= 1, "{low}, {high}");
        let level = allocation.level_of(512, 0);
        let (few, many) = (
            allocation.target(level, low),
            allocation.target(level, high),
        );
        assert!((8..=16).contains(&(many / few)), "{few}, {many}");
        assert!(few.is_power_of_two() && many.is_power_of_two());
    }

    #[test]
    fn a_pixels_own_samples_have_no_say() {
        let mut film = pilot();
        let (index, far) = (8 * 32 + 8, 0);
        film.pixels[index].second_mean = [0.0; 3];
        let allocation = Allocation::after(&film, PILOT).expect("an error");
        assert_eq!(allocation.class(index), allocation.class(far));
        assert!(allocation.class(index + 4) > allocation.class(far) + 8);
    }

    #[test]
    fn the_mean_is_reached_and_hardly_exceeded() {
        let allocation = Allocation::after(&pilot(), PILOT).expect("there is an error");
        let at = |level| allocation.mean((0..CLASSES).map(|c| allocation.target(level, c)));
        let mut level = 0;
        for mean in [17, 20, 64, 100, 1000] {
            level = allocation.level_of(mean, level);
            assert!(at(level) >= mean && (level == 0 || at(level - 1) < mean));
        }
    }

    #[test]
    fn without_an_error_nothing_is_shared_out() {
        let mut black = pilot();
        for pixel in &mut black.pixels {
            (pixel.mean, pixel.second_mean) = ([0.0; 3], [0.0; 3]);
        }
        assert_eq!(Allocation::after(&black, PILOT), None);
    }
}
