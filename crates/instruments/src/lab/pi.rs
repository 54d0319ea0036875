//! π from the quarter of the unit circle.
//!
//! ```text
//!     4·[x² + y² ≤ 1]    mean π, variance π(4 − π) = 2.697, two random numbers
//!     4·√(1 − x²)        mean π, variance 32/3 − π² = 0.797, one random number
//! ```
//!
//! The second integrates over y exactly, which cannot raise the variance (Rao & Blackwell).
//! Efficiency is 1/(V·T) with T the random numbers of a sample. Rejection itself keeps π/4 of its
//! points.

use super::bench::{Bench, Outcome};
use super::layout::{LabRun, merged};
use super::plot::{Mark, Plot, Series};
use super::report::{Cell, Check, Report, Table};
use super::{BLOCK, CONFIDENCE_95, Settings, expected_errors, rms_errors};
use direkt::error::GpuError;
use direkt::low_level::gpu::Context;
use direkt::low_level::stats::moments::Moments;
use std::f64::consts::PI;

/// A way to π.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Method {
    /// Its formula.
    pub name: &'static str,
    /// Variance of one sample.
    pub variance: f64,
    /// (E(s − π)⁴)/V².
    pub kurtosis: f64,
    /// Random numbers of one sample.
    pub numbers: f64,
}

/// Hit or miss, and the mean height.
pub fn methods() -> [Method; 2] {
    let p = PI / 4.0;
    let height = 32.0 / 3.0 - PI * PI;
    // Fourth central moment of 4√(1 − x²): E s² = 32/3, E s³ = 64·3π/16, E s⁴ = 256·8/15.
    let (s2, s3, s4) = (32.0 / 3.0, 12.0 * PI, 256.0 * 8.0 / 15.0);
    let fourth = s4 - 4.0 * PI * s3 + 6.0 * PI * PI * s2 - 3.0 * PI.powi(4);
    [
        Method {
            name: "4·[x² + y² ≤ 1]",
            variance: PI * (4.0 - PI),
            kurtosis: (1.0 - 3.0 * p * (1.0 - p)) / (p * (1.0 - p)),
            numbers: 2.0,
        },
        Method {
            name: "4·√(1 − x²)",
            variance: height,
            kurtosis: fourth / (height * height),
            numbers: 1.0,
        },
    ]
}

/// Runs `variant` of the kernel.
///
/// # Errors
/// The driver fails.
pub fn draw(bench: &Bench<'_>, settings: &Settings, variant: u32) -> Result<Outcome, GpuError> {
    let run = LabRun {
        variant,
        items: settings.blocks(),
        samples: BLOCK,
        seed: settings.seed,
        stream: variant,
        constants: [(1.0 / settings.density_scale) as f32, 0.0, 0.0, 0.0],
        ..LabRun::default()
    };
    bench.run(&run, &[])
}

/// Runs the experiment.
///
/// # Errors
/// The kernel does not compile, or the driver fails.
pub fn run(context: &Context, settings: &Settings) -> Result<Report, GpuError> {
    let bench = Bench::new(context, "lab_pi")?;
    let mut report = Report::new("pi", "π from the quarter of the unit circle");
    let mut table = Table::new(
        "efficiency is 1/(variance · random numbers); ± is half a 95 % interval",
        &[
            "sample",
            "mean",
            "exact",
            "variance",
            "exact variance",
            "numbers",
            "efficiency",
            "relative",
        ],
    );
    let mut series = Vec::new();
    let mut first = None;
    for (i, method) in methods().iter().enumerate() {
        let blocks = draw(&bench, settings, i as u32)?.blocks;
        let found = merged(&blocks);
        let variance = found.variance().unwrap_or(f64::NAN);
        let efficiency = 1.0 / (variance * method.numbers);
        let base = *first.get_or_insert(efficiency);
        let mut row = table_row(method, &found);
        row.extend([
            Cell::fixed(efficiency, 3),
            Cell::fixed(efficiency / base, 2),
        ]);
        table.push(row);
        report.checks.extend(checks(method, &found));
        let measured = rms_errors(&blocks, PI);
        series.push(Series {
            points: expected_errors(&measured, method.variance),
            name: String::new(),
            mark: Mark::Dashed,
            colour: i,
        });
        series.push(Series {
            points: measured,
            name: method.name.to_owned(),
            mark: Mark::Dots,
            colour: i,
        });
    }
    report.tables.push(table);
    rejection(&bench, settings, &mut report)?;
    report.notes.push(format!(
        "the mean height is {:.2} times as efficient: {:.2} times less variance, half the random numbers",
        2.0 * methods()[0].variance / methods()[1].variance,
        methods()[0].variance / methods()[1].variance
    ));
    report.plots.push(Plot {
        file: "pi".to_owned(),
        title: "π: RMS error over samples (dashed: σ/√n)".to_owned(),
        axes: ["samples n".to_owned(), "RMS error".to_owned()],
        logarithmic: true,
        series,
    });
    Ok(report)
}

/// All but the efficiencies.
fn table_row(method: &Method, found: &Moments) -> Vec<Cell> {
    let variance = found.variance().unwrap_or(f64::NAN);
    let error = CONFIDENCE_95 * found.variance_of_mean().unwrap_or(0.0).sqrt();
    let relative = ((method.kurtosis - 1.0) / found.count as f64).sqrt();
    vec![
        Cell::text(method.name),
        Cell::with_error(found.mean, error, 4),
        Cell::fixed(PI, 6),
        Cell::with_error(variance, CONFIDENCE_95 * variance * relative, 4),
        Cell::fixed(method.variance, 6),
        Cell::fixed(method.numbers, 0),
    ]
}

/// What mean and variance of the samples have to be.
fn checks(method: &Method, found: &Moments) -> [Check; 2] {
    let n = found.count as f64;
    [
        Check::mean(
            format!("mean of {}", method.name),
            found.mean,
            PI,
            method.variance / n,
            1e-5,
        ),
        Check::variance(
            format!("variance of {}", method.name),
            found.variance().unwrap_or(f64::NAN),
            method.variance,
            (method.kurtosis, n),
            1e-5,
        ),
    ]
}

/// Points of the quarter circle found by rejection: attempts until one is kept are geometric with p =
/// π/4.
fn rejection(bench: &Bench<'_>, settings: &Settings, report: &mut Report) -> Result<(), GpuError> {
    let blocks = draw(bench, settings, 2)?.blocks;
    let kept = merged(&blocks);
    let tries: u64 = blocks.iter().map(|b| u64::from(b.tries)).sum();
    let n = kept.count as f64;
    let p = PI / 4.0;
    let mut table = Table::new(
        "rejection of points outside the quarter circle",
        &["what", "measured", "exact"],
    );
    let efficiency = n / tries as f64;
    let mut add = |name: &str, measured: f64, exact: f64| {
        table.push(vec![
            Cell::text(name),
            Cell::fixed(measured, 6),
            Cell::fixed(exact, 6),
        ]);
    };
    add("efficiency: points kept, π/4", efficiency, p);
    add("attempts per point, 4/π", 1.0 / efficiency, 1.0 / p);
    add("mean of x² + y², 1/2", kept.mean, 0.5);
    report.checks.push(Check::mean(
        "attempts per point of the quarter circle",
        tries as f64 / n,
        1.0 / p,
        (1.0 - p) / (p * p) / n,
        0.0,
    ));
    // The squared distance is uniform on [0, 1].
    report.checks.push(Check::mean(
        "squared distance of points kept",
        kept.mean,
        0.5,
        1.0 / 12.0 / n,
        1e-5,
    ));
    report.tables.push(table);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::integral;
    use super::*;

    #[test]
    fn moments_are_the_integrals() {
        let height = |x: f64| 4.0 * (1.0 - x * x).max(0.0).sqrt();
        // With x = sin t the integrand is smooth.
        let mean_of =
            |f: &dyn Fn(f64) -> f64| integral(|t| f(height(t.sin())) * t.cos(), 0.0, PI / 2.0);
        let [hit, mean_height] = methods();
        assert!((mean_of(&|s| s) - PI).abs() < 1e-10);
        let variance = mean_of(&|s| (s - PI).powi(2));
        assert!((variance - mean_height.variance).abs() < 1e-10);
        let kurtosis = mean_of(&|s| (s - PI).powi(4)) / (variance * variance);
        assert!((kurtosis - mean_height.kurtosis).abs() < 1e-8);
        // Two values: 4 with probability p, 0 with 1 − p.
        let p = PI / 4.0;
        let fourth = p * (4.0 - PI).powi(4) + (1.0 - p) * PI.powi(4);
        assert!((hit.kurtosis - fourth / hit.variance.powi(2)).abs() < 1e-12);
    }
}
