//! Which random number goes where; see `shaders/core/sampler.wesl`.

use super::rng::pcg4d;
use super::sobol::sobol_2d;
use super::stratified::stratified_2d;
use crate::scene::Sampler;

/// Film x, film y, lens x, lens y.
pub const GROUP_FILM: u32 = 0;
/// Light point x, light point y, light choice, lobe.
pub const GROUP_LIGHT: u32 = 1;
/// Direction x, direction y, environment texel, –.
pub const GROUP_DIRECTION: u32 = 2;

/// What the light tree needs beyond the light choice, one word after the other.
pub const GROUP_LIGHT_TREE: u32 = 3;

/// What decides which surfaces of an opacity stop the sample's rays; hashed further.
pub const GROUP_OPACITY: u32 = 8;

/// Group of the points on light 0, where every light has its own, or of a grid's first cell: light
/// point x, light point y; –, –. That of the next follows.
pub const GROUP_LIGHT_POINTS: u32 = 16;

/// Group of the choice at a camera ray's first specular surface: way; –, –, –. That of the next
/// follows.
pub const GROUP_SPECULAR: u32 = 0x5bd1_e995;

/// Group of the point on the first of the small lights in view: light point x, light point y; –, –.
/// That of the next follows.
pub const GROUP_LIGHTS_IN_VIEW: u32 = 0x2545_f491;

/// Names one sample of one pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SampleId {
    /// Index of the pixel, row by row.
    pub pixel: u32,
    /// Index of the sample in its replicate.
    pub index: u64,
    /// The replicate's seed.
    pub seed: u32,
}

/// Added to the seed of the second replicate.
const REPLICATE_SEED: u32 = 0x6c8e_9cf5;

/// A sampler with its pattern.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Numbers {
    /// How numbers are made.
    pub sampler: Sampler,
    /// See [`Sampler::pattern`].
    pub pattern: [u32; 2],
    /// Pixels per row.
    pub width: u32,
}

impl Numbers {
    /// Sample `index` of pixel `pixel` in a render with seed `seed`; even and odd samples are two
    /// replicates.
    pub fn sample_id(&self, pixel: u32, index: u64, seed: u32) -> SampleId {
        if self.sampler.is_independent() {
            return SampleId { pixel, index, seed };
        }
        let replicate = (index & 1) as u32;
        SampleId {
            pixel,
            index: index >> 1,
            seed: seed.wrapping_add(replicate * REPLICATE_SEED),
        }
    }

    /// The four random words of a group of dimensions.
    pub fn group(&self, id: SampleId, group: u32) -> [u32; 4] {
        if self.sampler.is_independent() {
            return random_group(id, group);
        }
        let [a, b] = self.pair(id, 2 * group);
        let [c, d] = self.pair(id, 2 * group + 1);
        [a, b, c, d]
    }

    /// Two dimensions that are stratified together.
    fn pair(&self, id: SampleId, pair: u32) -> [u32; 2] {
        let (low, high) = (id.index as u32, (id.index >> 32) as u32);
        let later = high.wrapping_mul(0x85eb_ca6b);
        let three = |[a, b, c, _]: [u32; 4]| [a, b, c];
        match self.sampler {
            Sampler::Sobol => sobol_2d(low, three(pcg4d([id.pixel, high, pair, id.seed]))),
            Sampler::BlueNoise => {
                let bits = self.pattern[0];
                let place = morton(id.pixel % self.width, id.pixel / self.width);
                let index = (place << bits) | (low & ((1 << bits) - 1));
                let sequence = (low >> bits).wrapping_add(later);
                let block = place.checked_shr(32 - bits).unwrap_or(0);
                sobol_2d(index, three(pcg4d([sequence, block, pair, id.seed])))
            }
            Sampler::Stratified | Sampler::Independent => {
                let bits = self.pattern[0] + self.pattern[1];
                let grid = (low >> bits).wrapping_add(later);
                let seed = pcg4d([id.pixel, grid, pair, id.seed])[0];
                let apart = high.wrapping_add(pair.wrapping_mul(0x9e37_79b9));
                let [x, y, ..] = pcg4d([id.pixel, low, apart, !id.seed]);
                stratified_2d(low, self.pattern, seed, [x, y])
            }
        }
    }
}

/// Part `part` of the `parts` that sample `id` has in some groups.
pub fn part_of_sample(id: SampleId, part: u32, parts: u32) -> SampleId {
    let first = id.index.wrapping_mul(u64::from(parts));
    SampleId {
        index: first.wrapping_add(u64::from(part)),
        ..id
    }
}

/// The lower 16 bits of both coordinates in turn, x lowest.
pub fn morton(x: u32, y: u32) -> u32 {
    (0..16).fold(0, |m, bit| {
        m | (x >> bit & 1) << (2 * bit) | (y >> bit & 1) << (2 * bit + 1)
    })
}

/// The four random words of a group of dimensions, each by itself.
pub fn random_group(id: SampleId, group: u32) -> [u32; 4] {
    pcg4d(independent_counter(id, group))
}

/// What the words of a group are hashed from where each is drawn by itself.
pub fn independent_counter(id: SampleId, group: u32) -> [u32; 4] {
    let (low, high) = (id.index as u32, (id.index >> 32) as u32);
    let group = group.wrapping_mul(0x9e37_79b9);
    [id.pixel, low, high.wrapping_add(group), id.seed]
}
