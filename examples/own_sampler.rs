//! A way of sampling of the reader's own, tested as direkt tests its own: a χ² test of the samples
//! against the density that goes with them, and one that a wrong density fails.

use direkt::low_level::reference::core::rng::{pcg4d, to_unit_2d};
use direkt::low_level::stats::chi2::{Totals, chi2_test};
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// A direction of the hemisphere around +z whose density falls with the square of the cosine.
fn sample_cosine_squared(u: DVec2) -> DVec3 {
    let cos_theta = u.x.cbrt();
    let sin_theta = (1.0 - cos_theta * cos_theta).max(0.0).sqrt();
    let phi = TAU * u.y;
    DVec3::new(sin_theta * phi.cos(), sin_theta * phi.sin(), cos_theta)
}

/// Its density per solid angle: 3 cos²θ / 2π.
fn pdf_cosine_squared(cos_theta: f64) -> f64 {
    3.0 * cos_theta * cos_theta / TAU
}

/// The density that one might take it for: cosθ / π.
fn pdf_cosine(cos_theta: f64) -> f64 {
    cos_theta / PI
}

const CELLS: [usize; 2] = [8, 16];
const SAMPLES: u32 = 100_000;

/// What a density expects in each cell of equal height in z and width in azimuth, by the midpoint
/// rule.
fn expected(pdf: impl Fn(f64) -> f64) -> Vec<f64> {
    const STEPS: usize = 1000;
    let ring = |i: usize| {
        let z = |step: usize| (i as f64 + (step as f64 + 0.5) / STEPS as f64) / CELLS[0] as f64;
        let mean: f64 = (0..STEPS).map(|step| pdf(z(step))).sum::<f64>() / STEPS as f64;
        f64::from(SAMPLES) * mean * TAU / (CELLS[0] * CELLS[1]) as f64
    };
    (0..CELLS[0] * CELLS[1])
        .map(|cell| ring(cell / CELLS[1]))
        .collect()
}

fn main() {
    let mut observed = vec![0; CELLS[0] * CELLS[1]];
    for sample in 0..SAMPLES {
        let [x, y, ..] = pcg4d([sample, 0, 0, 1]);
        let direction = sample_cosine_squared(to_unit_2d(x, y));
        let azimuth = direction.y.atan2(direction.x).rem_euclid(TAU) / TAU;
        let cell = |part: f64, cells: usize| ((part * cells as f64) as usize).min(cells - 1);
        observed[cell(direction.z, CELLS[0]) * CELLS[1] + cell(azimuth, CELLS[1])] += 1;
    }
    let p_value = |pdf: fn(f64) -> f64| {
        let test = chi2_test(&observed, &expected(pdf), Totals::Free);
        test.expect("cells that expect enough").p_value
    };
    let (own, wrong) = (p_value(pdf_cosine_squared), p_value(pdf_cosine));
    println!("3 cos²θ / 2π: p = {own:.3}; cosθ / π: p = {wrong:.1e}");
    assert!(own > 1e-4, "the samples do not follow their density");
    assert!(wrong < 1e-4, "the test cannot tell the densities apart");
}
