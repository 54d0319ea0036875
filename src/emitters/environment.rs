//! The grid over which directions towards an environment map are chosen.

use super::{row_height, texel_luminance};
use crate::scene::EnvironmentMap;
use crate::scene::alias_table::AliasTable;
use crate::scene::light::Interpolation;

/// Cells at most; larger maps are sampled in blocks of texels.
const MAX_CELLS: usize = 1 << 21;

/// Cells of a latitude-longitude map and the probability of each, in proportion to its luminance and to its height
/// in z = cosθ. A cell is a texel, or a block of texels.
#[derive(Debug, Clone, PartialEq)]
pub struct EnvironmentGrid {
    /// Cells per row, and rows.
    pub size: [u32; 2],
    /// Choice of a cell, row by row.
    pub table: AliasTable,
}

impl EnvironmentGrid {
    /// The grid of `map`; `None` where the map is black.
    pub fn new(map: &EnvironmentMap) -> Option<Self> {
        let (size, weights) = cell_weights(map);
        let table = AliasTable::new(&weights)?;
        Some(Self { size, table })
    }
}

/// Size of the grid, and per cell the luminance of its texels times their height in z.
fn cell_weights(map: &EnvironmentMap) -> ([u32; 2], Vec<f64>) {
    let (width, height) = (map.width as usize, map.height as usize);
    let fits = |block: &usize| {
        let whole = width.is_multiple_of(*block) && height.is_multiple_of(*block);
        whole && (width / block) * (height / block) <= MAX_CELLS
    };
    // Sides without a common factor: one cell per row.
    let block = (1..=width.min(height)).find(fits);
    let (block_x, block_y) = block.map_or((width, 1), |b| (b, b));
    let columns = width / block_x;
    let mut weights = vec![0.0; columns * (height / block_y)];
    for (y, row) in mean_luminance(map).chunks_exact(width).enumerate() {
        let dz = row_height(y as f64, height as f64);
        for (x, luminance) in row.iter().enumerate() {
            weights[(y / block_y) * columns + x / block_x] += dz * luminance;
        }
    }
    ([columns as u32, (height / block_y) as u32], weights)
}

/// Per texel the mean luminance over it. Where radiance is interpolated, a texel's mean takes in its neighbours by
/// 1/8, 6/8, 1/8 per axis: it is above zero wherever the interpolated radiance is.
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
