//! Adaptive cubature over a rectangle, with an error estimate.
//!
//! Each cell takes the tensor product of Kronrod's 15 points (Kronrod 1965) with itself. Where
//! Gauss's 7 among them differ in one direction, the cell errs in that direction; the cell with the
//! largest error is halved across it.

use glam::DVec3;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// When an integral is good enough: its error is below `absolute`, or below `relative` times its
/// largest component.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// In the integral's unit; 0 for none.
    pub absolute: f64,
    /// As a fraction; below 1e-13 rounding makes it unreachable.
    pub relative: f64,
}

impl Tolerance {
    /// A relative error.
    pub fn relative(relative: f64) -> Self {
        Self {
            absolute: 0.0,
            relative,
        }
    }
}

/// An integral and how far it may be off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The integral.
    pub value: DVec3,
    /// Difference to the rule of lower degree, summed over the cells. For integrands that the cells
    /// resolve it is above the error by orders of magnitude. It may exceed the tolerance when
    /// [`MAX_CELLS`] were not enough.
    pub error: f64,
}

impl Estimate {
    /// The integral over an empty domain.
    pub const ZERO: Self = Self {
        value: DVec3::ZERO,
        error: 0.0,
    };
}

/// Cells after which refinement ends.
pub const MAX_CELLS: usize = 40_000;

/// Kronrod's abscissae on [−1, 1], not negative; the odd ones are Gauss's.
const NODES: [f64; 8] = [
    0.991_455_371_120_812_6,
    0.949_107_912_342_758_5,
    0.864_864_423_359_769_1,
    0.741_531_185_599_394_4,
    0.586_087_235_467_691_1,
    0.405_845_151_377_397_2,
    0.207_784_955_007_898_47,
    0.0,
];

/// Kronrod's weights of [`NODES`].
const KRONROD: [f64; 8] = [
    0.022_935_322_010_529_224,
    0.063_092_092_629_978_55,
    0.104_790_010_322_250_18,
    0.140_653_259_715_525_92,
    0.169_004_726_639_267_9,
    0.190_350_578_064_785_4,
    0.204_432_940_075_298_9,
    0.209_482_141_084_727_83,
];

/// Gauss's weights of [`NODES`].
const GAUSS: [f64; 8] = [
    0.0,
    0.129_484_966_168_869_7,
    0.0,
    0.279_705_391_489_276_64,
    0.0,
    0.381_830_050_505_118_9,
    0.0,
    0.417_959_183_673_469_4,
];

/// Abscissa, Kronrod's and Gauss's weight of the 15 points on [−1, 1].
fn points() -> [(f64, f64, f64); 15] {
    std::array::from_fn(|i| {
        let k = i.min(14 - i);
        let side = if i < 7 { -1.0 } else { 1.0 };
        (side * NODES[k], KRONROD[k], GAUSS[k])
    })
}

struct Cell {
    u: [f64; 2],
    v: [f64; 2],
    value: DVec3,
    error: f64,
    /// Whether `u` errs more than `v`.
    across_u: bool,
}

impl Cell {
    fn new(f: &impl Fn(f64, f64) -> DVec3, u: [f64; 2], v: [f64; 2]) -> Self {
        let (half_u, half_v) = (0.5 * (u[1] - u[0]), 0.5 * (v[1] - v[0]));
        let (mid_u, mid_v) = (0.5 * (u[0] + u[1]), 0.5 * (v[0] + v[1]));
        let points = points();
        let (mut both, mut gauss_u, mut gauss_v) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
        for (x, kronrod_x, gauss_x) in points {
            let (mut row, mut row_gauss) = (DVec3::ZERO, DVec3::ZERO);
            for (y, kronrod_y, gauss_y) in points {
                let value = f(mid_u + half_u * x, mid_v + half_v * y);
                row += value * kronrod_y;
                row_gauss += value * gauss_y;
            }
            both += row * kronrod_x;
            gauss_u += row * gauss_x;
            gauss_v += row_gauss * kronrod_x;
        }
        let area = half_u * half_v;
        let error_u = (both - gauss_u).abs().max_element() * area;
        let error_v = (both - gauss_v).abs().max_element() * area;
        Self {
            u,
            v,
            value: both * area,
            error: error_u + error_v,
            across_u: error_u > error_v,
        }
    }

    fn halves(&self, f: &impl Fn(f64, f64) -> DVec3) -> [Self; 2] {
        let halve = |range: [f64; 2]| {
            let middle = 0.5 * (range[0] + range[1]);
            [[range[0], middle], [middle, range[1]]]
        };
        if self.across_u {
            halve(self.u).map(|u| Self::new(f, u, self.v))
        } else {
            halve(self.v).map(|v| Self::new(f, self.u, v))
        }
    }
}

impl PartialEq for Cell {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Cell {}

impl PartialOrd for Cell {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Cell {
    fn cmp(&self, other: &Self) -> Ordering {
        self.error.total_cmp(&other.error)
    }
}

/// Integrates `f` over the rectangle from the first to the last of the ascending `u` and `v`.
///
/// What stands between them cuts the rectangle at the start: put it where the integrand peaks or
/// bends, because a peak that lies between all points of the first cells is not seen. Next to a cut
/// the points are densest, 0.4 % of a cell from it.
pub fn integrate(
    f: impl Fn(f64, f64) -> DVec3,
    u: &[f64],
    v: &[f64],
    tolerance: Tolerance,
) -> Estimate {
    let mut cells = BinaryHeap::new();
    for a in u.windows(2).filter(|w| w[1] > w[0]) {
        for b in v.windows(2).filter(|w| w[1] > w[0]) {
            cells.push(Cell::new(&f, [a[0], a[1]], [b[0], b[1]]));
        }
    }
    let mut sum = total(&cells);
    while cells.len() < MAX_CELLS {
        if sum.error <= limit(tolerance, sum.value) {
            // The running sum has gathered rounding from the cells that were replaced.
            sum = total(&cells);
            if sum.error <= limit(tolerance, sum.value) {
                break;
            }
        }
        let Some(worst) = cells.pop() else { break };
        sum.value -= worst.value;
        sum.error -= worst.error;
        for half in worst.halves(&f) {
            sum.value += half.value;
            sum.error += half.error;
            cells.push(half);
        }
    }
    total(&cells)
}

fn limit(tolerance: Tolerance, value: DVec3) -> f64 {
    tolerance
        .absolute
        .max(tolerance.relative * value.abs().max_element())
}

fn total(cells: &BinaryHeap<Cell>) -> Estimate {
    cells.iter().fold(Estimate::ZERO, |sum, cell| Estimate {
        value: sum.value + cell.value,
        error: sum.error + cell.error,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn the_rules_have_their_degrees() {
        // Gauss's 7 points are exact to degree 13, Kronrod's 15 to degree 23 (22, and odd ones by
        // symmetry).
        for degree in 0..24 {
            let exact = if degree % 2 == 0 {
                2.0 / (f64::from(degree) + 1.0)
            } else {
                0.0
            };
            let (mut kronrod, mut gauss) = (0.0, 0.0);
            for (x, k, g) in points() {
                kronrod += k * x.powi(degree);
                gauss += g * x.powi(degree);
            }
            assert!((kronrod - exact).abs() < 1e-15, "Kronrod {degree}");
            assert!(
                degree > 13 || (gauss - exact).abs() < 1e-15,
                "Gauss {degree}"
            );
        }
    }

    #[test]
    fn smooth_peaked_and_bent_integrands() {
        let relative = Tolerance::relative(1e-12);
        let smooth = integrate(
            |u, v| DVec3::new((u * v).exp(), 1.0, u),
            &[0.0, 1.0],
            &[0.0, 1.0],
            relative,
        );
        // Σ 1/(n·n!) = Ei(1) − γ.
        assert!((smooth.value - DVec3::new(1.317_902_151_454_404, 1.0, 0.5)).length() < 1e-14);

        let width = 1e-4;
        let peak = |u: f64, v: f64| {
            let (x, y) = ((u - 0.3) / width, (v - 0.6) / width);
            DVec3::splat(1.0 / (1.0 + x * x) / (1.0 + y * y))
        };
        let side = |c: f64| width * (((1.0 - c) / width).atan() + (c / width).atan());
        let exact = side(0.3) * side(0.6);
        let found = integrate(peak, &[0.0, 0.3, 1.0], &[0.0, 0.6, 1.0], relative);
        assert!((found.value.x / exact - 1.0).abs() < 1e-12 && found.error < 1e-12 * exact);

        let bent = integrate(
            |u, v| DVec3::splat((u + v - 1.0).max(0.0)),
            &[0.0, 1.0],
            &[0.0, 1.0],
            Tolerance {
                absolute: 1e-8,
                relative: 0.0,
            },
        );
        assert!((bent.value.x - 1.0 / 6.0).abs() <= bent.error && bent.error <= 1e-8);

        let quarter = integrate(
            |u, _| DVec3::splat((1.0 - u * u).sqrt()),
            &[0.0, 1.0],
            &[0.0, 1.0],
            relative,
        );
        assert!((quarter.value.x - PI / 4.0).abs() < 1e-12);
    }

    #[test]
    fn an_empty_domain_has_no_integral() {
        let none = integrate(
            |_, _| DVec3::NAN,
            &[1.0, 1.0],
            &[0.0, 1.0],
            Tolerance::relative(1e-9),
        );
        assert_eq!(none, Estimate::ZERO);
    }
}
