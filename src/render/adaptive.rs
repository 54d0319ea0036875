//! Adaptive sampling: more samples where the error is.
//!
//! After a pilot, the same for all pixels, pixels take samples in proportion to the root of their
//! squared error, which is what makes the sum of errors that fall with the inverse of the samples
//! smallest at a given number of them (Neyman 1934). A pixel's error is the sum of its parts of the
//! image's NMSE and of its relMSE, so that neither is had at the other's cost.
//!
//! The pilot's samples say where the others go and are not part of the image. If they were, pixels
//! that got more samples because their first ones were bright, or fewer because they were dark,
//! would have a biased mean (Kirk & Arvo 1991, "Unbiased Sampling Techniques for Image Synthesis").
//! As they are not, a pixel's own samples can say how large its error is: a bright light that is
//! mirrored in one pixel is found where it is. For the same reason the shares stay as the pilot
//! gave them.
//!
//! Every pixel has a power of two of samples at any time, which is what stratified samplers are
//! best at.

use super::film::{Film, Pixel};
use super::neighbourhood::box_mean;
use crate::scene::FilmSize;
use crate::stats::sums::sum;
use rayon::prelude::*;

/// Samples of the pilot; later powers of two where it found no light.
pub(super) const PILOT: u64 = 8;
/// Index of the first sample after the pilot: far enough from the pilot's that samplers which
/// stratify take it from a sequence of its own.
pub(super) const FIRST: u64 = 1 << 33;
/// Samples of a pixel at the least, one of each replicate.
const FEWEST: u64 = 2;
/// Columns and rows of a block of pixels that have the same number of samples: eight neighbouring
/// lanes of the kernel.
const BLOCK: [usize; 2] = [4, 2];
/// Pixels on each side of a pixel that help to tell its error.
const RADIUS: usize = 2;
/// The part of its block's error from which on a pixel has a number of samples of its own.
const ALONE: f64 = 0.5;
/// Classes to an octave of samples.
const PER_OCTAVE: u32 = 8;
/// Octaves between the pixels with fewest and with most samples.
const OCTAVES: u32 = 12;
/// Classes of pixels.
pub(super) const CLASSES: usize = (PER_OCTAVE * OCTAVES) as usize;
/// The class of a pixel with the mean error: eight times fewer samples at the least, 500 times more
/// at most.
const MIDDLE: f64 = (3 * PER_OCTAVE) as f64;
/// How many times as long a sample takes where errors are spread most evenly and samples are shared
/// out all the same: the pixels that get them are those where rays part.
const DEARER: f64 = 1.25;

/// How samples are shared out among pixels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Allocation {
    /// Samples of the pilot.
    pilot: u64,
    /// Whether all pixels take as many: no class is above another, and any number will do.
    is_even: bool,
    /// Class of each pixel, row by row: eight classes higher are twice the samples.
    classes: Vec<u8>,
    /// Pixels of each class.
    pixels: Vec<u64>,
}

impl Allocation {
    /// How those after the `pilot`, of `samples` per pixel, are shared out: evenly where that is as
    /// good. `None` while a pixel has not two samples, or none has an error.
    pub(crate) fn after(pilot: &Film, samples: u64) -> Option<Self> {
        let size = pilot.size;
        let errors = share_in_blocks(size, &tell_errors(pilot)?);
        let count = errors.len() as f64;
        let [error, root] = sum(errors.par_iter().map(|error| [*error, error.sqrt()]));
        let middle = root / count;
        if !(middle > 0.0 && middle.is_finite()) {
            return None;
        }
        let is_even = error / count / (middle * middle) < DEARER;
        let highest = (CLASSES - 1) as f64;
        let class = |error: &f64| {
            let octaves = (error.sqrt() / middle).max(f64::MIN_POSITIVE).log2();
            let class = if is_even {
                MIDDLE
            } else {
                MIDDLE + f64::from(PER_OCTAVE) * octaves
            };
            class.clamp(0.0, highest) as u8
        };
        let classes: Vec<_> = errors.par_iter().map(class).collect();
        let mut pixels = vec![0; CLASSES];
        for class in &classes {
            pixels[usize::from(*class)] += 1;
        }
        Some(Self {
            pilot: samples,
            is_even,
            classes,
            pixels,
        })
    }

    /// Whether all pixels take as many samples.
    pub(crate) fn is_even(&self) -> bool {
        self.is_even
    }

    /// Samples of the pilot.
    pub(crate) fn pilot(&self) -> u64 {
        self.pilot
    }

    /// Whether an image whose pixels of each class have `samples` is better than the pilot's: no
    /// pixel is without, and on average they have as many.
    pub(crate) fn replaces_pilot(&self, samples: impl Iterator<Item = u64> + Clone) -> bool {
        let mut classes = self.pixels.iter().zip(samples.clone());
        classes.all(|(pixels, samples)| *pixels == 0 || samples >= FEWEST)
            && self.mean(samples) >= self.pilot
    }

    /// Class of the pixel `index`.
    pub(crate) fn class(&self, index: usize) -> usize {
        usize::from(self.classes[index])
    }

    /// Whether there is a pixel of `class`.
    pub(crate) fn has(&self, class: usize) -> bool {
        self.pixels[class] > 0
    }

    /// Samples of the pixels of `class` at a `level`: eight levels higher are twice the samples.
    pub(crate) fn target(&self, level: u32, class: usize) -> u64 {
        let octave = (level + class as u32) / PER_OCTAVE;
        (1_u64 << octave.min(40)).max(FEWEST)
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

/// Per pixel the sum of its parts of the NMSE and of the relMSE of an image with as many samples as
/// the `pilot`, in any unit; `None` where they cannot be told.
///
/// The scatter of the samples tells a pixel's error as if each had been drawn by itself: half of
/// what is taken is the pixel's own, half that of the pixels around it. It is multiplied by how much
/// smaller the squared difference of replicates is than it, which a pixel cannot tell alone: half
/// the ratio around the pixel, half that of the image.
fn tell_errors(pilot: &Film) -> Option<Vec<f64>> {
    let tell = |pixel: &Pixel| -> Option<[f64; 5]> {
        let squares: f64 = pixel.half_difference()?.iter().map(|h| h * h).sum();
        let scatter = pixel.variance_of_mean()?.iter().sum();
        let [r, g, b] = pixel.mean;
        Some([squares, scatter, r, g, b])
    };
    let told: Option<Vec<_>> = pilot.pixels.par_iter().map(tell).collect();
    let told = told?;
    let around = box_mean(&told, pilot.size, RADIUS);
    let [squares, scatter, r, g, b] = sum(told.par_iter().copied());
    let gain = squares / scatter;
    let mean = (r + g + b) / (3.0 * told.len() as f64);
    let floor = 0.01 * mean * mean;
    let pixels = told.par_iter().zip(&around);
    let errors = pixels.map(|(own, around)| -> [f64; 2] {
        if around[1] <= 0.0 {
            return [0.0; 2];
        }
        let half: [f64; 5] = std::array::from_fn(|i| 0.5 * (own[i] + around[i]));
        let error = half[1] * 0.5 * (around[0] / around[1] + gain);
        let value: f64 = half[2..].iter().map(|x| x * x).sum();
        [error, error / (value / 3.0 + floor)]
    });
    let errors: Vec<_> = errors.collect();
    let [absolute, relative] = sum(errors.par_iter().copied());
    let errors = errors.par_iter();
    (absolute > 0.0 && relative > 0.0)
        .then(|| errors.map(|e| e[0] / absolute + e[1] / relative).collect())
}

/// The same where the pixels of each block share their mean, but for one that holds more of the
/// block's than all the others.
fn share_in_blocks(size: FilmSize, errors: &[f64]) -> Vec<f64> {
    let width = size.width as usize;
    let [columns, rows] = BLOCK;
    let mut shared = errors.to_vec();
    let bands = shared.par_chunks_mut(width * rows);
    bands.for_each(|band| {
        for x in (0..width).step_by(columns) {
            let row = x..(x + columns).min(width);
            let starts = (0..band.len()).step_by(width);
            let pixels = starts.flat_map(|start| row.clone().map(move |x| start + x));
            share(band, &pixels.collect::<Vec<_>>());
        }
    });
    shared
}

/// Gives the `pixels` of a block the mean of their `errors`, but for one that holds more of the
/// block's than all the others.
fn share(errors: &mut [f64], pixels: &[usize]) {
    let total: f64 = pixels.iter().map(|pixel| errors[*pixel]).sum();
    let mut alike = pixels.to_vec();
    alike.retain(|pixel| errors[*pixel] <= ALONE * total);
    let mean = alike.iter().map(|pixel| errors[*pixel]).sum::<f64>() / alike.len() as f64;
    for pixel in alike {
        errors[pixel] = mean;
    }
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
                m2: [half * half * (PILOT * (PILOT - 1)) as f64; 3],
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
        assert!(!allocation.is_even());
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

    /// A bright light that is mirrored in one pixel takes no other pixel along.
    #[test]
    fn one_pixel_that_holds_most_of_its_blocks_error_is_alone() {
        let mut film = pilot();
        let (index, far) = (8 * 32 + 4, 0);
        film.pixels[index].second_mean = [0.0; 3];
        film.pixels[index].m2 = [100.0; 3];
        let allocation = Allocation::after(&film, PILOT).expect("an error");
        let [own, beside, other] = [index, index + 1, far].map(|pixel| allocation.class(pixel));
        assert!(own > beside + 12, "{own}, {beside}, {other}");
        assert!(beside > other, "what is around it helps to tell its error");
    }

    #[test]
    fn a_pilot_is_replaced_by_an_image_of_as_many_samples_without_a_hole() {
        let allocation = Allocation::after(&pilot(), PILOT).expect("there is an error");
        let few = allocation.class(0);
        let replaces = |of_few: u64, of_many: u64| {
            let samples = |class| match class {
                class if class == few => of_few,
                _ => of_many,
            };
            allocation.replaces_pilot((0..CLASSES).map(samples))
        };
        assert!(replaces(2, 64) && replaces(PILOT, PILOT));
        assert!(!replaces(1, 64) && !replaces(64, 0) && !replaces(2, 4));
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

    /// The pilot is left out even then: to keep it where it found nothing would be a bias.
    #[test]
    fn where_errors_are_alike_samples_are() {
        let mut film = pilot();
        for (i, pixel) in film.pixels.iter_mut().enumerate() {
            let half = if i % 32 < 16 { 0.05 } else { 0.1 };
            pixel.second_mean = [1.0 - half; 3];
            pixel.m2 = [half * half * (PILOT * (PILOT - 1)) as f64; 3];
        }
        let allocation = Allocation::after(&film, PILOT).expect("there is an error");
        assert!(allocation.is_even());
        assert_eq!(allocation.class(0), allocation.class(31));
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
