//! Chi-squared tests of samplers: samples drawn on the GPU against a density in f64.

use direkt::low_level::reference::exact::cubature::{Tolerance, integrate};
use direkt::low_level::stats::chi2::{Totals, chi2_test};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// Cells along each axis; odd, so that no cell's edge lies on a symmetry of the sampler.
pub const CELLS: [usize; 2] = [31, 17];

/// p-value of the hypothesis that points of [low, high]² have the density `pdf` there.
///
/// Samples outside are hits in a cell without density.
pub fn p_value(samples: &[DVec2], low: DVec2, high: DVec2, pdf: impl Fn(DVec2) -> f64) -> f64 {
    let size = (high - low) / DVec2::new(CELLS[0] as f64, CELLS[1] as f64);
    // One cell more for what lies outside.
    let mut observed = vec![0_u64; CELLS[0] * CELLS[1] + 1];
    for p in samples {
        // The upper edges belong to the last cells.
        let last = DVec2::new(CELLS[0] as f64 - 1.0, CELLS[1] as f64 - 1.0);
        let cell = ((*p - low) / size).floor().min(last);
        let index = if p.cmpge(low).all() && p.cmple(high).all() {
            cell.y as usize * CELLS[0] + cell.x as usize
        } else {
            CELLS[0] * CELLS[1]
        };
        observed[index] += 1;
    }
    // A twentieth of a count is far below the noise of any cell.
    let tolerance = Tolerance {
        absolute: 0.05 / samples.len() as f64,
        relative: 0.0,
    };
    let expected = (0..CELLS[0] * CELLS[1]).map(|i| {
        let corner = low + size * DVec2::new((i % CELLS[0]) as f64, (i / CELLS[0]) as f64);
        let cuts = [[corner.x, corner.x + size.x], [corner.y, corner.y + size.y]];
        let of_cell = integrate(
            |x, y| DVec3::splat(pdf(DVec2::new(x, y))),
            &cuts[0],
            &cuts[1],
            tolerance,
        );
        of_cell.value.x * samples.len() as f64
    });
    let expected: Vec<f64> = expected.chain([0.0]).collect();
    chi2_test(&observed, &expected, Totals::Free)
        .expect("the density is testable")
        .p_value
}

/// The same for unit vectors with density `pdf` per solid angle: cells of azimuth and z have equal
/// solid angles.
pub fn directions_p_value(samples: &[DVec3], pdf: impl Fn(DVec3) -> f64) -> f64 {
    let flat: Vec<DVec2> = samples
        .iter()
        .map(|w| DVec2::new(w.y.atan2(w.x), w.z.clamp(-1.0, 1.0)))
        .collect();
    let low = DVec2::new(-PI, -1.0);
    let high = DVec2::new(PI, 1.0);
    p_value(&flat, low, high, |p| {
        let r = (1.0 - p.y * p.y).max(0.0).sqrt();
        pdf(DVec3::new(r * p.x.cos(), r * p.x.sin(), p.y))
    })
}
