//! Bounds on the rounding of f32.
//!
//! A sum, difference or product is off by a relative [`U`] at most; WGSL allows a quotient 2.5
//! units in the last place, that is 5 U, and a square root, as the reciprocal of `inverseSqrt`, 9
//! U. A dot product of three components is off by 3 U times the sum of its terms' magnitudes, in
//! any order and fused or not (Higham 2002, §3.1). Bounds of tests are sums of these, to first
//! order in U.

use glam::DVec3;

/// 2⁻²⁴: the relative error of rounding to f32.
pub const U: f64 = 1.0 / (1 << 24) as f64;

/// Fails unless `got` differs from `expected` by `bound` at most.
#[track_caller]
pub fn assert_near(got: f64, expected: f64, bound: f64, what: impl std::fmt::Display) {
    let off = (got - expected).abs();
    assert!(
        off <= bound,
        "{what}: {got:e}, not {expected:e}; off by {off:.3e}, bound {bound:.3e}"
    );
}

/// The same for every component of a vector.
#[track_caller]
pub fn assert_all_near(got: DVec3, expected: DVec3, bound: f64, what: impl std::fmt::Display) {
    for i in 0..3 {
        assert_near(
            got[i],
            expected[i],
            bound,
            format_args!("{what}, component {i}"),
        );
    }
}

/// Fails unless a density per area times the area is one, within `bound`. `element(x, y)` is the
/// area element of a map of the unit square onto the surface, whose integral is the area.
#[track_caller]
pub fn assert_integrates_to_one(
    density: f64,
    element: impl Fn(f64, f64) -> f64,
    bound: f64,
    what: impl std::fmt::Display,
) {
    use direkt::low_level::reference::exact::cubature::{Tolerance, integrate};
    let square = [0.0, 1.0];
    let area = integrate(
        |x, y| DVec3::splat(element(x, y)),
        &square,
        &square,
        Tolerance::relative(1e-12),
    );
    assert_near(density * area.value.x, 1.0, bound, what);
}

/// Whether `found` is `expected` up to `roundings` roundings relative to it.
pub fn close(found: f64, expected: f64, roundings: f64) -> bool {
    (found - expected).abs() <= roundings * U * expected.abs()
}
