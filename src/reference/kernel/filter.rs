//! Where in and around a pixel a sample lies: drawn in proportion to the pixel's filter, so that
//! all samples weigh the same (Ernst, Stamminger & Greiner 2006, "Filter Importance Sampling").

use crate::scene::filter::{FILTER_CELLS, FilterTable};
use glam::DVec2;

/// The distribution function of the distance from the pixel's middle at the lower end of a cell,
/// and the filter there over its peak.
fn filter_knot(table: &FilterTable, cell: usize) -> DVec2 {
    let [below, density] = table.knots[cell];
    DVec2::new(f64::from(below), f64::from(density))
}

/// t in [0, 1] with density proportional to (1 − t)·a + t·b, a > 0 and b ≥ 0: inverts (a t + (b −
/// a) t²/2)/((a + b)/2) = u without cancellation (Pharr et al. 2023, §2.3.2).
pub fn sample_in_cell(u: f64, a: f64, b: f64) -> f64 {
    (u * (a + b) / (a + ((1.0 - u) * a * a + u * b * b).sqrt())).min(1.0)
}

/// A coordinate's distance from the pixel's middle, in pixels, to the right or down.
pub fn sample_filter(table: &FilterTable, u: f64) -> f64 {
    let signed = 2.0 * u - 1.0;
    let below = signed.abs();
    let starts = &table.knots[..FILTER_CELLS];
    let begun = starts.partition_point(|&[start, _]| f64::from(start) <= below);
    let cell = begun.saturating_sub(1);
    let (low, high) = (filter_knot(table, cell), filter_knot(table, cell + 1));
    let part = ((below - low.x) / (high.x - low.x).max((-24_f64).exp2())).min(1.0);
    let distance =
        (cell as f64 + sample_in_cell(part, low.y, high.y)) * f64::from(table.cell_width);
    if signed < 0.0 { -distance } else { distance }
}

/// Density of [`film_point`] at the distance `off` from the pixel's middle.
pub fn filter_density(table: &FilterTable, off: DVec2) -> f64 {
    let along_axis = |off: f64| {
        let width = f64::from(table.cell_width);
        let place = off.abs() / width;
        if place >= FILTER_CELLS as f64 {
            return 0.0;
        }
        let cell = place as usize;
        let (low, high) = (filter_knot(table, cell), filter_knot(table, cell + 1));
        let shape = low.y + (high.y - low.y) * place.fract();
        (high.x - low.x) * shape / (low.y + high.y) / width
    };
    along_axis(off.x) * along_axis(off.y)
}

/// The point of the film that a sample of `pixel` sees, in pixels from the upper left corner.
pub fn film_point(table: &FilterTable, pixel: DVec2, u: DVec2) -> DVec2 {
    pixel + 0.5 + DVec2::new(sample_filter(table, u.x), sample_filter(table, u.y))
}
