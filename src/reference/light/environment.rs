//! The latitude-longitude environment map; see `shaders/light/environment.wesl`.

use crate::reference::core::math::{angle_of, sin_cos_two_pi};
use crate::reference::core::pdf::{PdfDiscrete, PdfSolidAngle};
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// The unit direction at azimuth fraction `u` (0 at the image's left edge), `depth` below the zenith in z or, where
/// `south`, above the nadir.
pub fn direction_from_map(u: f64, depth: f64, south: bool) -> DVec3 {
    let r = (depth * (2.0 - depth)).max(0.0).sqrt();
    let sc = sin_cos_two_pi(u);
    let y = if south { depth - 1.0 } else { 1.0 - depth };
    DVec3::new(-sc.x * r, y, sc.y * r)
}

/// Image coordinates in [0, 1]² of a unit direction in the map's space; row 0 is the zenith.
pub fn map_from_direction(d: DVec3) -> DVec2 {
    let azimuth = angle_of(-d.x, d.z) / TAU;
    let polar = angle_of(d.x.hypot(d.z), d.y) / PI;
    DVec2::new(
        if azimuth < 0.0 {
            azimuth + 1.0
        } else {
            azimuth
        },
        polar,
    )
}

/// Depth in z of the edge above row `row`: 1 − cos(π j/H).
pub fn row_depth(row: u32, height: u32) -> f64 {
    2.0 * (0.5 * PI * f64::from(row) / f64::from(height))
        .sin()
        .powi(2)
}

/// Height of row `row` in z: cos(π j/H) − cos(π (j+1)/H).
pub fn row_height(row: u32, height: u32) -> f64 {
    crate::emitters::row_height(f64::from(row), f64::from(height))
}

/// A direction in the cell (column, row) of a `grid[0]` × `grid[1]` map.
pub fn sample_environment_cell(cell: [u32; 2], grid: [u32; 2], u: DVec2) -> DVec3 {
    let south = 2 * cell[1] >= grid[1];
    let (row, v) = if south {
        (grid[1] - 1 - cell[1], 1.0 - u.y)
    } else {
        (cell[1], u.y)
    };
    let depth = row_depth(row, grid[1]) + v * row_height(row, grid[1]);
    direction_from_map(
        (f64::from(cell[0]) + u.x) / f64::from(grid[0]),
        depth,
        south,
    )
}

/// Density of [`sample_environment_cell`] when the cell has probability `choice`.
pub fn pdf_environment_cell(choice: PdfDiscrete, row: u32, grid: [u32; 2]) -> PdfSolidAngle {
    PdfSolidAngle(choice.0 * f64::from(grid[0]) / (TAU * row_height(row, grid[1])))
}

/// The texels around a point of the image and how to blend them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BilinearTexels {
    /// Column on the left.
    pub left: u32,
    /// Column on the right.
    pub right: u32,
    /// Row above.
    pub top: u32,
    /// Row below.
    pub bottom: u32,
    /// Weight of the right column and of the bottom row.
    pub blend: DVec2,
}

/// `position` is in texels, in [0, size]; texel centres lie at ½. Columns wrap around, rows end at the poles.
pub fn bilinear_texels(position: DVec2, [width, height]: [u32; 2]) -> BilinearTexels {
    let p = position - DVec2::splat(0.5);
    let low = p.floor();
    let column = |x: f64| (x as i64).rem_euclid(i64::from(width)) as u32;
    let row = |y: f64| (y as i64).clamp(0, i64::from(height) - 1) as u32;
    BilinearTexels {
        left: column(low.x),
        right: column(low.x + 1.0),
        top: row(low.y),
        bottom: row(low.y + 1.0),
        blend: p - low,
    }
}
