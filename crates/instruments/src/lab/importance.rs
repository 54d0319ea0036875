//! ∫₀⁴ x dx = 8 by importance sampling with linear densities, the lecture's table.
//!
//! ```text
//!     x ~ p,   E[x/p(x)] = 8,   V[x/p(x)] = ∫₀⁴ x²/p(x) dx − 64,   N = V/0.008²
//! ```
//!
//! Exact values: [`direkt::low_level::reference::exact::lecture`].

use super::bench::Bench;
use super::layout::{LabBlock, LabRun, merged};
use super::plot::{Mark, Plot, Series};
use super::report::{Cell, Check, Report, Table, grouped};
use super::{BLOCK, CONFIDENCE_95, Settings, expected_errors, integral, rms_errors};
use direkt::error::GpuError;
use direkt::low_level::gpu::Context;
use direkt::low_level::reference::exact::lecture::{INTEGRAL, LinearDensity};
use direkt::low_level::stats::moments::Moments;

/// Standard deviation of the mean that the lecture asks for.
pub const STANDARD_DEVIATION: f64 = 0.008;

/// A row of the lecture's table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// The density as the lecture writes it.
    pub name: &'static str,
    /// The density.
    pub density: LinearDensity,
    /// The variance in closed form.
    pub closed_form: &'static str,
    /// The variance that the lecture prints, to one decimal.
    pub printed_variance: f64,
    /// The number of samples that it prints.
    pub printed_samples: f64,
}

/// The lecture's table.
pub const ROWS: [Row; 4] = [
    Row {
        name: "(6 − x)/16",
        density: LinearDensity {
            constant: 0.375,
            slope: -0.0625,
        },
        closed_form: "576(ln 3 − 1)",
        printed_variance: 56.8,
        printed_samples: 887_500.0,
    },
    Row {
        name: "1/4",
        density: LinearDensity {
            constant: 0.25,
            slope: 0.0,
        },
        closed_form: "64/3",
        printed_variance: 21.3,
        printed_samples: 332_812.0,
    },
    Row {
        name: "(x + 2)/16",
        density: LinearDensity {
            constant: 0.125,
            slope: 0.0625,
        },
        closed_form: "64(ln 3 − 1)",
        printed_variance: 6.4,
        printed_samples: 98_432.0,
    },
    Row {
        name: "x/8",
        density: LinearDensity {
            constant: 0.0,
            slope: 0.125,
        },
        closed_form: "0",
        printed_variance: 0.0,
        printed_samples: 1.0,
    },
];

impl Row {
    /// Fewest samples whose mean has [`STANDARD_DEVIATION`]: one at least.
    pub fn samples_needed(&self) -> f64 {
        self.density.samples_for(STANDARD_DEVIATION).ceil().max(1.0)
    }

    /// Whether the printed variance is the exact one, rounded to the decimal that is printed.
    pub fn printed_is_right(&self) -> bool {
        (self.density.variance() - self.printed_variance).abs() <= 0.05
    }

    /// ∫ p(x) (x/p(x) − 8)⁴ dx / V², 1 where the variance is zero.
    fn kurtosis(&self) -> f64 {
        let variance = self.density.variance();
        if variance <= 0.0 {
            return 1.0;
        }
        let LinearDensity { constant, slope } = self.density;
        let fourth = |x: f64| {
            let p = constant + slope * x;
            p * (x / p - INTEGRAL).powi(4)
        };
        integral(fourth, 0.0, 4.0) / (variance * variance)
    }
}

/// Draws x by `sampled` and divides by `divided` on the GPU.
///
/// # Errors
/// The driver fails.
pub fn draw(
    bench: &Bench<'_>,
    settings: &Settings,
    sampled: LinearDensity,
    divided: LinearDensity,
    stream: u32,
) -> Result<Vec<LabBlock>, GpuError> {
    let run = LabRun {
        items: settings.blocks(),
        samples: BLOCK,
        seed: settings.seed,
        stream,
        constants: [
            sampled.constant as f32,
            sampled.slope as f32,
            divided.constant as f32,
            divided.slope as f32,
        ],
        ..LabRun::default()
    };
    Ok(bench.run(&run, &[])?.blocks)
}

/// What mean and variance of the samples have to be.
pub fn checks(row: &Row, found: &Moments) -> [Check; 2] {
    let n = found.count as f64;
    let variance = row.density.variance();
    // x, p and x/p are rounded, and 256 means in turn: in f32 up to some 30 units of the last place
    // of 16.
    let allowance = 30.0 * f64::from(f32::EPSILON) * INTEGRAL;
    [
        Check::mean(
            format!("mean by {}", row.name),
            found.mean,
            INTEGRAL,
            variance / n,
            allowance,
        ),
        Check::variance(
            format!("variance by {}", row.name),
            found.variance().unwrap_or(f64::NAN),
            variance,
            (row.kurtosis(), n),
            1e-5,
        ),
    ]
}

/// Half width of the variance's 95 % interval, from the spread of the blocks' own variances.
fn variance_half_width(blocks: &[LabBlock]) -> f64 {
    let variances = blocks.iter().filter_map(|b| b.moments().variance());
    let spread: Moments = variances.collect();
    CONFIDENCE_95 * spread.variance_of_mean().unwrap_or(0.0).sqrt()
}

/// Runs the experiment.
///
/// # Errors
/// The kernel does not compile, or the driver fails.
pub fn run(context: &Context, settings: &Settings) -> Result<Report, GpuError> {
    let bench = Bench::new(context, "lab_importance")?;
    let mut report = Report::new(
        "importance",
        "∫₀⁴ x dx = 8 by importance sampling: samples x/p(x), x drawn by p",
    );
    let mut table = Table::new(
        "N is how many samples give the mean a standard deviation of 0.008; ± is half a 95 % interval",
        &[
            "p(x)",
            "mean",
            "variance",
            "exact",
            "printed",
            "N measured",
            "N exact",
            "N printed",
        ],
    );
    let mut series = Vec::new();
    for (i, row) in ROWS.iter().enumerate() {
        let scaled = LinearDensity {
            constant: row.density.constant * settings.density_scale,
            slope: row.density.slope * settings.density_scale,
        };
        let blocks = draw(&bench, settings, row.density, scaled, i as u32)?;
        let found = merged(&blocks);
        let exact = row.density.variance();
        let half = variance_half_width(&blocks);
        table.push(table_row(row, &found, half));
        if !row.printed_is_right() {
            report.notes.push(misprint(row, &found, half));
        }
        report.checks.extend(checks(row, &found));
        let measured = rms_errors(&blocks, INTEGRAL);
        series.push(Series {
            points: expected_errors(&measured, exact),
            name: String::new(),
            mark: Mark::Dashed,
            colour: i,
        });
        series.push(Series {
            points: measured,
            name: format!("p = {}", row.name),
            mark: Mark::Dots,
            colour: i,
        });
    }
    report.notes.push(
        "the printed N are V/0.008² of rounded V, so they differ from the exact ones by up to half a unit of V's last digit".to_owned(),
    );
    report.tables.push(table);
    report.plots.push(Plot {
        file: "importance".to_owned(),
        title: "∫ x dx: RMS error over samples (dashed: σ/√n)".to_owned(),
        axes: ["samples n".to_owned(), "RMS error".to_owned()],
        logarithmic: true,
        series,
    });
    Ok(report)
}

/// `half` is half the width of the variance's interval.
fn table_row(row: &Row, found: &Moments, half: f64) -> Vec<Cell> {
    let exact = row.density.variance();
    let variance = found.variance().unwrap_or(f64::NAN);
    let error = CONFIDENCE_95 * found.variance_of_mean().unwrap_or(0.0).sqrt();
    let wrong = if row.printed_is_right() {
        ""
    } else {
        " (wrong)"
    };
    vec![
        Cell::text(row.name),
        Cell::with_error(found.mean, error, 4),
        Cell::with_error(variance, half, 3),
        Cell::shown(exact, format!("{} = {exact:.8}", row.closed_form)),
        Cell::shown(
            row.printed_variance,
            format!("{}{wrong}", row.printed_variance),
        ),
        Cell::count((variance / STANDARD_DEVIATION.powi(2)).max(1.0)),
        Cell::count(row.samples_needed()),
        Cell::count(row.printed_samples),
    ]
}

fn misprint(row: &Row, found: &Moments, half: f64) -> String {
    let variance = found.variance().unwrap_or(f64::NAN);
    let meant = row.printed_samples * STANDARD_DEVIATION.powi(2);
    format!(
        "printed variance {} of p = {} is wrong: exact {} = {:.8}, measured {variance:.3} ± {half:.3}; \
         its own N = {} belongs to a variance of {meant:.2}, so {meant:.1} was meant",
        row.printed_variance,
        row.name,
        row.closed_form,
        row.density.variance(),
        grouped(row.printed_samples),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_that_of_the_lecture() {
        let exact = [56.800_678_27, 64.0 / 3.0, 6.311_186_47, 0.0];
        let needed = [887_511.0, 333_334.0, 98_613.0, 1.0];
        let right = [true, true, false, true];
        for (row, ((exact, needed), right)) in ROWS.iter().zip(exact.iter().zip(needed).zip(right))
        {
            assert!((row.density.variance() - exact).abs() < 1e-8, "{row:?}");
            assert!((row.samples_needed() - needed).abs() < 0.5, "{row:?}");
            assert_eq!(row.printed_is_right(), right, "{row:?}");
        }
    }

    #[test]
    fn the_kurtosis_of_uniform_samples_is_nine_fifths() {
        assert!((ROWS[1].kurtosis() - 1.8).abs() < 1e-10);
        assert!((ROWS[3].kurtosis() - 1.0).abs() < 1e-15);
    }
}
