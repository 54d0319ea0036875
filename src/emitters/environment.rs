//! The grid over which directions towards an environment map are chosen.

use super::{row_height, texel_luminance};
use crate::scene::EnvironmentMap;
use crate::scene::alias_table::AliasTable;
use crate::scene::environment::Interpolation;

/// Cells at most; larger maps are sampled in blocks of texels.
const MAX_CELLS: usize = 1 << 21;

/// How far a cell's luminance may lie above the mean, relative to it, and count as the mean: texels
/// are f32.
const ROUNDING: f64 = 1e-6;

/// Cells of a latitude-longitude map and the probability of each, in proportion to its solid angle
/// and to its luminance or to what of that exceeds the mean. A cell is a texel, or a block of
/// texels.
#[derive(Debug, Clone, PartialEq)]
pub struct EnvironmentGrid {
    /// Cells per row, and rows.
    pub size: [u32; 2],
    /// Choice of a cell, row by row.
    pub table: AliasTable,
    /// Whether only cells above the mean luminance are chosen.
    pub compensated: bool,
}

impl EnvironmentGrid {
    /// The grid of `map`, by luminance: every cell from which light comes can be chosen. `None`
    /// where the map is black.
    pub fn new(map: &EnvironmentMap) -> Option<Self> {
        let Cells { size, power, .. } = Cells::new(map);
        let table = AliasTable::new(&power)?;
        Some(Self {
            size,
            table,
            compensated: false,
        })
    }

    /// The grid of `map` for use beside BSDF sampling under multiple importance sampling, by max(0,
    /// L − L̄), L̄ the mean luminance over the sphere: what lies below the mean is left to BSDF
    /// sampling, which finds a broad sky by itself (Karlík et al. 2019, "MIS Compensation", for as
    /// many samples of either kind). By itself it would be biased. A constant map, of which nothing
    /// would remain, has the grid of [`new`](Self::new).
    pub fn compensated(map: &EnvironmentMap) -> Option<Self> {
        let cells = Cells::new(map);
        AliasTable::new(&cells.above_mean()).map_or_else(
            || Self::new(map),
            |table| {
                Some(Self {
                    size: cells.size,
                    table,
                    compensated: true,
                })
            },
        )
    }
}

/// The cells of a map. Solid angles are in units of a texel's width in azimuth.
struct Cells {
    /// Per row, and rows.
    size: [u32; 2],
    /// Mean luminance times solid angle.
    power: Vec<f64>,
    solid_angle: Vec<f64>,
}

impl Cells {
    fn new(map: &EnvironmentMap) -> Self {
        let (width, height) = (map.width as usize, map.height as usize);
        let fits = |block: &usize| {
            let whole = width.is_multiple_of(*block) && height.is_multiple_of(*block);
            whole && (width / block) * (height / block) <= MAX_CELLS
        };
        // Sides without a common factor: one cell per row.
        let block = (1..=width.min(height)).find(fits);
        let (block_x, block_y) = block.map_or((width, 1), |b| (b, b));
        let (columns, rows) = (width / block_x, height / block_y);
        let mut power = vec![0.0; columns * rows];
        let mut solid_angle = power.clone();
        for (y, row) in mean_luminance(map).chunks_exact(width).enumerate() {
            let dz = row_height(y as f64, height as f64);
            for (x, luminance) in row.iter().enumerate() {
                let cell = (y / block_y) * columns + x / block_x;
                power[cell] += dz * luminance;
                solid_angle[cell] += dz;
            }
        }
        Self {
            size: [columns as u32, rows as u32],
            power,
            solid_angle,
        }
    }

    /// Per cell what of its power exceeds that of the mean luminance.
    fn above_mean(&self) -> Vec<f64> {
        let mean = self.power.iter().sum::<f64>() / self.solid_angle.iter().sum::<f64>();
        let cells = self.power.iter().zip(&self.solid_angle);
        let above = cells.map(|(power, solid_angle)| {
            let of_mean = mean * solid_angle;
            let excess = power - of_mean;
            if excess > ROUNDING * of_mean {
                excess
            } else {
                0.0
            }
        });
        above.collect()
    }
}

/// Per texel the mean luminance over it. Where radiance is interpolated, a texel's mean takes in
/// its neighbours by 1/8, 6/8, 1/8 per axis: it is above zero wherever the interpolated radiance
/// is.
fn mean_luminance(map: &EnvironmentMap) -> Vec<f64> {
    let luminance: Vec<f64> = map.texels.iter().map(|&t| texel_luminance(t)).collect();
    if map.interpolation == Interpolation::Nearest {
        return luminance;
    }
    let (width, height) = (map.width as usize, map.height as usize);
    let mean = |before: f64, at: f64, after: f64| 0.125 * before + 0.75 * at + 0.125 * after;
    let along_rows: Vec<f64> = luminance
        .chunks_exact(width)
        .flat_map(|row| {
            (0..width).map(|x| mean(row[(x + width - 1) % width], row[x], row[(x + 1) % width]))
        })
        .collect();
    let at = |x: usize, y: usize| along_rows[y * width + x];
    let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    texels
        .map(|(x, y)| {
            mean(
                at(x, y.saturating_sub(1)),
                at(x, y),
                at(x, (y + 1).min(height - 1)),
            )
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(width: u32, luminance: &[f32], interpolation: Interpolation) -> EnvironmentMap {
        EnvironmentMap {
            source: "test".to_owned(),
            width,
            height: luminance.len() as u32 / width,
            texels: luminance.iter().map(|&l| [l; 3]).collect(),
            interpolation,
        }
    }

    fn assert_probabilities(grid: &EnvironmentGrid, expected: &[f64]) {
        assert_eq!(grid.table.probability.len(), expected.len());
        for (p, e) in grid.table.probability.iter().zip(expected) {
            assert!((p - e).abs() < 1e-8, "{:?}", grid.table.probability);
        }
    }

    /// Three rows are ½, 1 and ½ high in z. The mean is (½·4 + 1 + 5 + ½·6)/4 = 2.75; above it lie
    /// 1.25, 2.25 and 3.25, by solid angle 0.625, 2.25 and 1.625 of 4.5.
    #[test]
    fn cells_above_the_mean_are_chosen_by_what_exceeds_it() {
        let map = map(2, &[4.0, 0.0, 1.0, 5.0, 6.0, 0.0], Interpolation::Nearest);
        let grid = EnvironmentGrid::compensated(&map).unwrap();
        assert!(grid.compensated);
        let expected = [5.0, 0.0, 0.0, 18.0, 13.0, 0.0].map(|x| x / 36.0);
        assert_probabilities(&grid, &expected);
        let all = EnvironmentGrid::new(&map).unwrap();
        assert!(!all.compensated);
        let expected = [2.0, 0.0, 1.0, 5.0, 3.0, 0.0].map(|x| x / 11.0);
        assert_probabilities(&all, &expected);
    }

    /// Where texels 9, 5 and 0 are interpolated, the rows' means are 8.5, 4.875 and 0.625, theirs
    /// 9.4375/2. Above that lie 3.78125, by solid angle half of it, and 0.15625.
    #[test]
    fn interpolated_cells_are_held_against_the_mean_of_interpolated_cells() {
        let map = map(1, &[9.0, 5.0, 0.0], Interpolation::Linear);
        let grid = EnvironmentGrid::compensated(&map).unwrap();
        let expected = [1.890_625, 0.156_25, 0.0].map(|x| x / 2.046_875);
        assert_probabilities(&grid, &expected);
    }

    /// Their means differ by rounding.
    #[test]
    fn constant_maps_have_the_grid_of_their_luminance() {
        for interpolation in [Interpolation::Nearest, Interpolation::Linear] {
            let map = map(30, &[0.1; 30 * 17], interpolation);
            let grid = EnvironmentGrid::compensated(&map).unwrap();
            assert!(!grid.compensated);
            assert_eq!(Some(grid), EnvironmentGrid::new(&map));
        }
        let black = map(2, &[0.0; 4], Interpolation::Nearest);
        assert_eq!(EnvironmentGrid::compensated(&black), None);
    }
}
