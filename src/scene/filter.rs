//! Pixel filters: what a pixel shows of what lies around its middle.
//!
//! A pixel is the mean of radiance over the film, weighted by a filter around the pixel's middle.
//! Filters here are products of the same function of x and of y, symmetric, and nowhere negative:
//! the place of a sample is drawn in proportion to the filter, and all samples weigh the same
//! (Ernst, Stamminger & Greiner 2006, "Filter Importance Sampling"). Each pixel draws its own
//! samples, so that pixels stay independent of each other, as the image's error assumes.

use super::choice::choice;

choice! {
    /// Which function of the distance from the pixel's middle, along each axis.
    pub enum FilterKind {
        /// The same up to the radius.
        #[default]
        Box,
        /// Falls linearly to zero at the radius.
        Tent,
        /// A Gaussian less its value at the radius, as in pbrt and Mitsuba.
        Gaussian,
        /// The 4-term Blackman–Harris window (Harris 1978), as wide as twice the radius.
        BlackmanHarris,
    }
}

/// A filter; distances are in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelFilter {
    /// Which function.
    pub kind: FilterKind,
    /// Distance, along each axis, from which on it is zero; positive.
    pub radius: f64,
    /// Standard deviation of the Gaussian before anything is taken off it; positive. Other filters
    /// have none.
    pub stddev: f64,
}

impl Default for PixelFilter {
    fn default() -> Self {
        Self::of_kind(FilterKind::Box)
    }
}

impl PixelFilter {
    /// Standard deviation of a Gaussian where nothing else is said.
    pub const STDDEV: f64 = 0.5;

    /// The filter with the usual radius: the pixel's own square, a tent to the neighbours' middles,
    /// pbrt's Gaussian, and a Blackman–Harris window about as wide as that.
    pub fn of_kind(kind: FilterKind) -> Self {
        let radius = match kind {
            FilterKind::Box => 0.5,
            FilterKind::Tent => 1.0,
            FilterKind::Gaussian => 1.5,
            FilterKind::BlackmanHarris => 2.0,
        };
        Self {
            kind,
            radius,
            stddev: Self::STDDEV,
        }
    }

    /// Whether a pixel shows its own square and nothing else, each point alike.
    pub fn is_pixel(&self) -> bool {
        self.kind == FilterKind::Box && self.radius.to_bits() == 0.5_f64.to_bits()
    }

    /// The filter along one axis at the distance `x` ≥ 0; not normalised.
    pub fn value(&self, x: f64) -> f64 {
        let r = self.radius;
        if x > r {
            return 0.0;
        }
        match self.kind {
            FilterKind::Box => 1.0,
            FilterKind::Tent => 1.0 - x / r,
            FilterKind::Gaussian => {
                // e^{−x²/2σ²} − e^{−r²/2σ²} = e^{−r²/2σ²} (e^{(r²−x²)/2σ²} − 1), where the
                // difference would cancel.
                let exponent = |y: f64| 0.5 * (y / self.stddev) * (y / self.stddev);
                let rise = (r - x) * (r + x) / (2.0 * self.stddev * self.stddev);
                if rise < 1.0 {
                    (-exponent(r)).exp() * rise.exp_m1()
                } else {
                    (-exponent(x)).exp() - (-exponent(r)).exp()
                }
            }
            FilterKind::BlackmanHarris => {
                let phase = std::f64::consts::PI * x / r;
                0.35875
                    + 0.48829 * phase.cos()
                    + 0.14128 * (2.0 * phase).cos()
                    + 0.01168 * (3.0 * phase).cos()
            }
        }
    }

    /// Distance beyond which nothing is drawn: that of the filter, or where a Gaussian holds less
    /// than the random numbers resolve, 2⁻²⁴.
    fn reach(&self) -> f64 {
        match self.kind {
            FilterKind::Gaussian => self.radius.min(6.0 * self.stddev),
            FilterKind::Box | FilterKind::Tent | FilterKind::BlackmanHarris => self.radius,
        }
    }

    /// The table that distances are drawn from.
    pub fn table(&self) -> FilterTable {
        let width = self.reach() / FILTER_CELLS as f64;
        let mut masses = [0.0; FILTER_CELLS];
        for (i, mass) in masses.iter_mut().enumerate() {
            *mass = integral(|x| self.value(x), i as f64 * width, width);
        }
        let whole: f64 = masses.iter().sum();
        let peak = self.value(0.0);
        let mut below = 0.0;
        let knots = std::array::from_fn(|i| {
            let density = (self.value(i as f64 * width) / peak).max(0.0);
            let knot = [(below / whole) as f32, density as f32];
            below += masses.get(i).copied().unwrap_or(0.0);
            knot
        });
        FilterTable {
            knots: close(knots),
            cell_width: width as f32,
        }
    }
}

/// Cells of a [`FilterTable`]; a power of two, for the search.
pub const FILTER_CELLS: usize = 32;

/// What the distance |x| of a sample from its pixel's middle is drawn from, along one axis.
///
/// The distance is cut into [`FILTER_CELLS`] cells of equal width. Each holds exactly the part of
/// the filter's integral that lies in it, up to the rounding of its ends to f32; within a cell the
/// density is linear, in the ratio of the filter's values at the cell's ends. For box and tent this
/// is the filter itself. For the others the density is within 0.5 % of its peak, and the
/// distribution function, which is what an edge shows, within 5·10⁻⁵ of the filter's own: see the
/// tests.
///
/// A table of equal cells was chosen over polynomials for the inverse, whose slope is infinite
/// where a filter ends in zero, and over Newton's method, which evaluates three cosines per step:
/// it is exact where it matters, the same code for every filter, and costs five comparisons and a
/// square root.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilterTable {
    /// Per end of a cell: the distribution function of |x|, rising from 0 to 1, and the density
    /// over its peak.
    pub knots: [[f32; 2]; FILTER_CELLS + 1],
    /// Width of a cell in pixels.
    pub cell_width: f32,
}

impl FilterTable {
    /// How far samples lie from the pixel's middle at most, along each axis.
    pub fn reach(&self) -> f64 {
        FILTER_CELLS as f64 * f64::from(self.cell_width)
    }
}

/// Makes the last value of the distribution function 1.
fn close(mut knots: [[f32; 2]; FILTER_CELLS + 1]) -> [[f32; 2]; FILTER_CELLS + 1] {
    knots[FILTER_CELLS][0] = 1.0;
    knots
}

/// ∫ f from `start` over `width`, by Gauss and Legendre's rule of 5 points.
fn integral(f: impl Fn(f64) -> f64, start: f64, width: f64) -> f64 {
    const RULE: [(f64, f64); 5] = [
        (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
        (-0.538_469_310_105_683, 0.478_628_670_499_366_47),
        (0.0, 0.568_888_888_888_888_9),
        (0.538_469_310_105_683, 0.478_628_670_499_366_47),
        (0.906_179_845_938_664, 0.236_926_885_056_189_08),
    ];
    let at = |x: f64| start + 0.5 * width * (1.0 + x);
    let sum: f64 = RULE.iter().map(|(x, weight)| weight * f(at(*x))).sum();
    0.5 * width * sum
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filters() -> Vec<PixelFilter> {
        use strum::VariantArray;
        let usual = FilterKind::VARIANTS.iter();
        let mut all: Vec<_> = usual.map(|k| PixelFilter::of_kind(*k)).collect();
        for (radius, stddev) in [(2.0, 0.5), (0.3, 50.0), (9.0, 0.25)] {
            all.push(PixelFilter {
                radius,
                stddev,
                ..PixelFilter::of_kind(FilterKind::Gaussian)
            });
        }
        all
    }

    /// The filter's own distribution function of |x|, from many cells.
    fn distribution(filter: &PixelFilter, x: f64) -> f64 {
        let part = |end: f64| -> f64 {
            let width = end / 512.0;
            let cells =
                (0..512).map(|i| integral(|x| filter.value(x), f64::from(i) * width, width));
            cells.sum()
        };
        part(x) / part(filter.radius)
    }

    /// Inside the cells, where the density is linear, nothing is further off than the documentation
    /// says.
    #[test]
    fn tables_hold_their_filters() {
        for filter in filters() {
            let table = filter.table();
            let peak = filter.value(0.0) / distribution_scale(&filter);
            for (i, ends) in table.knots.windows(2).enumerate() {
                let [[c0, f0], [c1, f1]] = [ends[0], ends[1]].map(|k| k.map(f64::from));
                assert!(c1 >= c0 && f1 <= f0, "{filter:?}: cell {i} of {ends:?}");
                for t in [0.0, 0.25, 0.5, 0.75] {
                    let x = (i as f64 + t) * f64::from(table.cell_width);
                    let part = t * (f0 + 0.5 * t * (f1 - f0)) / (0.5 * (f0 + f1));
                    let found = c0 + part * (c1 - c0);
                    let expected = distribution(&filter, x);
                    assert!(
                        (found - expected).abs() < 5e-5,
                        "{filter:?} at {x}: {found}, not {expected}"
                    );
                    let linear = (c1 - c0) / f64::from(table.cell_width) * (f0 + t * (f1 - f0))
                        / (0.5 * (f0 + f1));
                    let density = filter.value(x) / distribution_scale(&filter);
                    let off = (linear - density).abs() / peak;
                    assert!(off < 5e-3, "{filter:?} at {x}: off by {off} of the peak");
                }
            }
        }
    }

    /// ∫ value over all distances.
    fn distribution_scale(filter: &PixelFilter) -> f64 {
        let width = filter.radius / 512.0;
        let cells = (0..512).map(|i| integral(|x| filter.value(x), f64::from(i) * width, width));
        cells.sum()
    }

    #[test]
    fn the_default_is_the_pixel() {
        assert!(PixelFilter::default().is_pixel());
        let wide = PixelFilter {
            radius: 1.0,
            ..PixelFilter::default()
        };
        assert!(!wide.is_pixel());
        assert!(!PixelFilter::of_kind(FilterKind::Tent).is_pixel());
    }

    #[test]
    fn usual_filters_are_about_as_wide() {
        let deviation = |filter: PixelFilter| {
            let width = filter.radius / 512.0;
            let square = |x: f64| x * x * filter.value(x);
            let cells = (0..512).map(|i| integral(square, f64::from(i) * width, width));
            (cells.sum::<f64>() / distribution_scale(&filter)).sqrt()
        };
        let gaussian = deviation(PixelFilter::of_kind(FilterKind::Gaussian));
        let window = deviation(PixelFilter::of_kind(FilterKind::BlackmanHarris));
        let tent = deviation(PixelFilter::of_kind(FilterKind::Tent));
        assert!((0.4..0.5).contains(&gaussian), "{gaussian}");
        assert!((0.4..0.6).contains(&window), "{window}");
        assert!((tent - 1.0 / 6.0_f64.sqrt()).abs() < 1e-9, "{tent}");
    }
}
