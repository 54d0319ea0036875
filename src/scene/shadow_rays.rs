//! Several shadow rays per camera ray: how many, and where on the lights they end.

use super::choice::choice;
use crate::lattice;

/// Most shadow rays per camera ray, and with light selection `all` per light.
pub const MAX_SHADOW_RAYS: u32 = 1024;

/// Most light samples that a camera ray takes in all: with light selection `all` the lights' shadow
/// rays together. So many fit half a word of a sample's record.
pub const MAX_LIGHT_SAMPLES: u64 = 0xffff;

choice! {
    /// Where on the lights the points of a camera ray's shadow rays lie.
    pub enum ShadowPattern {
        /// Where the sampler's next numbers say.
        #[default]
        Random,
        /// In the middle; biased, for study.
        Center,
        /// In the middles of a grid's cells, one ray in each; biased, for study.
        Grid,
        /// Jittered in the cells of that grid; several lights get their shares of the rays, too.
        Stratified,
    }
}

/// A grid over the unit square with a cell for each of a camera ray's shadow rays, and the lattice
/// of what they choose lights by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ShadowGrid {
    /// Shadow rays, at least 1.
    pub rays: u32,
    /// Columns of the grid.
    pub columns: u32,
    /// Rows of the grid; columns times rows are all rays.
    pub rows: u32,
    /// What a ray's words for the choices of light and of environment texel are ahead of the ray's
    /// before, in fractions of 2³². All rays together have one word in each of `rays` equal parts,
    /// and those of a light lie all over the grid: a rank-1 lattice over (ray, light, texel) with
    /// the generator (1, k, k²), k near the golden section.
    pub steps: [u32; 2],
}

impl ShadowGrid {
    /// The grid of `rays` cells that is nearest to a square, with no more rows than columns.
    pub fn new(rays: u32) -> Self {
        let divides = |rows: &u32| rays.is_multiple_of(*rows);
        let rows = (1..=rays.isqrt()).rev().find(divides).unwrap_or(1);
        let generator = lattice::coprime(rays);
        let step = |k: u64| ((k << 32) / u64::from(rays)) as u32;
        let square = u64::from(generator).pow(2) % u64::from(rays);
        Self {
            rays,
            columns: rays / rows,
            rows,
            steps: [step(u64::from(generator)), step(square)],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grids_have_a_cell_for_every_ray() {
        for (rays, expected) in [
            (1, [1, 1]),
            (2, [2, 1]),
            (4, [2, 2]),
            (7, [7, 1]),
            (12, [4, 3]),
            (1000, [40, 25]),
            (1024, [32, 32]),
        ] {
            let grid = ShadowGrid::new(rays);
            assert_eq!([grid.columns, grid.rows], expected, "{rays} rays");
        }
    }

    /// Each of n equal parts of the words holds one ray, wherever the first ray's word lies; and
    /// the rays that choose a half of the lights have texels from all over.
    #[test]
    fn every_part_of_the_choices_holds_one_ray() {
        for rays in 1..=MAX_SHADOW_RAYS {
            let grid = ShadowGrid::new(rays);
            let part = |word: u32| (u64::from(word) * u64::from(rays)) >> 32;
            let start = u32::MAX / rays / 2;
            for step in grid.steps {
                let words = (0..rays).map(|i| start.wrapping_add(i.wrapping_mul(step)));
                let mut parts: Vec<u64> = words.map(part).collect();
                parts.sort_unstable();
                assert!(parts.iter().copied().eq(0..u64::from(rays)), "{rays} rays");
            }
            let chosen = |i: &u32| i.wrapping_mul(grid.steps[0]) < 1 << 31;
            let texels = (0..rays).filter(chosen);
            let low = texels.filter(|i| i.wrapping_mul(grid.steps[1]) < 1 << 31);
            let share = low.count() as f64 / f64::from(rays);
            assert!(rays < 16 || (share - 0.25).abs() < 0.1, "{rays}: {share}");
        }
    }
}
