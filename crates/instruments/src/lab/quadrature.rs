//! Quadrature rules against Monte Carlo and quasi-Monte Carlo, in 1 to 6 dimensions: measured
//! orders beside theory.
//!
//! A rule with n = m^s panels errs by n^(−r/s) in s dimensions for a smooth integrand, by n^(−1/s)
//! for one that jumps across an axis; independent random points by n^(−1/2) in every dimension, so
//! they win from s > 2r on, or s > 2. Scrambled Sobol points are `shaders/core/sobol.wesl`'s pairs:
//! n^(−3/2) for smooth integrands in one and two dimensions (Owen 1997), but pairs are independent
//! of each other, so from three dimensions on n^(−1/2) again, with a smaller constant. Roberts's R
//! sequence with a random shift falls about as n^(−1) in all of them, up to logarithms.
//!
//! Errors are root mean squares: over boxes for rules, over boxes and randomisations for points.
//! What a rule gives is compared with its closed form in [`super::rules`].

use super::bench::Bench;
use super::integral::{Case, DIMENSIONS, Measured, Method, ladder};
use super::plot::{Mark, Plot, Series};
use super::report::{Cell, Check, Report, Table, short};
use super::rules::{Integrand, Rule};
use super::{Settings, slope};
use direkt::error::GpuError;
use direkt::low_level::gpu::Context;
use direkt::low_level::stats::moments::Moments;
use direkt::low_level::stats::z_test::z_test;

/// What one method did with one integrand in one dimension.
struct Row {
    ladder: Vec<Measured>,
    slope: f64,
}

impl Row {
    fn new(
        bench: &Bench<'_>,
        settings: &Settings,
        integrand: Integrand,
        method: Method,
        dimensions: u32,
    ) -> Result<Self, GpuError> {
        let cases = ladder(integrand, method, dimensions).into_iter();
        let measured: Result<Vec<_>, _> =
            cases.map(|c| Measured::new(bench, settings, c)).collect();
        let ladder = measured?;
        let points: Vec<(f64, f64)> = ladder
            .iter()
            .map(|m| {
                (
                    m.case.n(),
                    match method {
                        Method::Independent => m.normalised_rms(),
                        _ => m.rms(),
                    },
                )
            })
            .collect();
        Ok(Self {
            slope: slope(&points),
            ladder,
        })
    }

    fn last(&self) -> &Measured {
        self.ladder.last().expect("every ladder has a case")
    }

    fn checks(&self, seed: u32) -> Vec<Check> {
        let last = self.last();
        let Case {
            integrand,
            method,
            dimensions,
            ..
        } = last.case;
        let what = format!("{} of {integrand:?} in {dimensions}-D", method.name());
        if matches!(method, Method::Rule(_)) {
            let off = self.ladder.iter().map(|m| m.off).fold(0.0, f64::max);
            let name = format!("{what}: largest difference to the closed form");
            return vec![Check::exact(name, off, 0.0, last.case.allowance())];
        }
        let normalised = last.errors.iter().zip(&last.deviations);
        let errors: Moments = normalised.map(|(e, d)| e / d).collect();
        let smallest = last
            .deviations
            .iter()
            .copied()
            .fold(f64::INFINITY, f64::min);
        let known = method == Method::Independent;
        let variance = if known {
            1.0 / last.case.n() / errors.count as f64
        } else {
            errors.variance_of_mean().unwrap_or(0.0)
        };
        let mut checks = vec![Check::mean(
            format!("{what}: mean error over the deviation of a point"),
            errors.mean,
            0.0,
            variance,
            last.case.allowance() / smallest,
        )];
        if known {
            checks.push(self.slope_check(format!("{what}: order"), seed));
        }
        checks
    }

    /// The slope of independent points is −½ exactly. ln of a mean of R squares of kurtosis k has
    /// variance v = (k − 1)/R and mean −v/2, to first order.
    fn slope_check(&self, name: String, seed: u32) -> Check {
        let logs: Vec<f64> = self.ladder.iter().map(|m| m.case.n().ln()).collect();
        let mean = logs.iter().sum::<f64>() / logs.len() as f64;
        let spread: f64 = logs.iter().map(|l| (l - mean).powi(2)).sum();
        let (mut expected, mut variance) = (-0.5, 0.0);
        for (m, log) in self.ladder.iter().zip(&logs) {
            let r = f64::from(m.case.replicates());
            let excess: Moments = (0..m.case.replicates())
                .map(|i| m.case.corner(seed, i))
                .map(|c| m.case.integrand.variance_and_kurtosis(&c).1 - 3.0)
                .collect();
            let v = (2.0 + excess.mean / m.case.n()) / r;
            let weight = (log - mean) / spread;
            // ln of the root is half of ln of the square.
            expected -= 0.25 * v * weight;
            variance += 0.25 * v * weight * weight;
        }
        Check {
            name,
            measured: self.slope,
            expected,
            p_value: z_test(self.slope, expected, variance, 0.0).p_value,
        }
    }
}

/// Runs the experiment.
///
/// # Errors
/// The kernel does not compile, or the driver fails.
pub fn run(context: &Context, settings: &Settings) -> Result<Report, GpuError> {
    let bench = Bench::new(context, "lab_quadrature")?;
    let mut report = Report::new(
        "quadrature",
        "quadrature rules against Monte Carlo and quasi-Monte Carlo in 1 to 6 dimensions",
    );
    lecture_formulas(&bench, settings, &mut report)?;
    for integrand in Integrand::ALL {
        let (what, formula) = match integrand {
            Integrand::Smooth => ("smooth", "∏ 2e^(2x)/(e² − 1)"),
            Integrand::Box => ("discontinuous", "[x₁ < c₁ and … and x_s < c_s], c random"),
        };
        let heads = ["method", "1-D", "2-D", "3-D", "4-D", "5-D", "6-D"];
        let mut orders = Table::new(
            format!("{what}, {formula}: order, exponent of n in the error; theory in brackets"),
            &heads,
        );
        let mut errors = Table::new(
            format!("{what}: RMS error with at most 4,096 evaluations"),
            &heads,
        );
        for method in Method::ALL {
            let mut order_row = vec![Cell::text(method.name())];
            let mut error_row = order_row.clone();
            for dimensions in 1..=DIMENSIONS {
                let row = Row::new(&bench, settings, integrand, method, dimensions)?;
                let theory = method.theory(integrand, dimensions);
                let shown = format!("{:.2} ({theory:.2})", row.slope);
                order_row.push(Cell::shown(row.slope, shown));
                error_row.push(error_cell(&bench, settings, &row)?);
                report.checks.extend(row.checks(settings.seed));
                report.plots = with_row(std::mem::take(&mut report.plots), what, &row);
            }
            orders.push(order_row);
            errors.push(error_row);
        }
        report.notes.push(winner(what, &errors));
        report.tables.push(orders);
        report.tables.push(errors);
    }
    report.notes.push(
        "by order, Monte Carlo beats a rule of order r in s dimensions when s > 2r: from 3 dimensions on at a \
         discontinuity (r = 1), from 5 on against midpoint and trapezoid (r = 2), from 9 on against Simpson and Gauss \
         (r = 4)"
            .to_owned(),
    );
    report.notes.push(
        "in 5 and 6 dimensions rules have 2 to 8 panels along an axis, and the R sequence's logarithms are not small \
         yet: measured orders there are not those of the limit"
            .to_owned(),
    );
    report.notes.push(
        "Sobol points are stratified in pairs of dimensions: from 3 dimensions on their order is Monte Carlo's again"
            .to_owned(),
    );
    Ok(report)
}

/// Error with as many evaluations as 4,096 allow.
fn error_cell(bench: &Bench<'_>, settings: &Settings, row: &Row) -> Result<Cell, GpuError> {
    const MOST: u32 = 4096;
    let last = row.last().case;
    let Method::Rule(rule) = last.method else {
        return Ok(Cell::shown(row.last().rms(), short(row.last().rms(), 2)));
    };
    let fits = |size: u32| {
        let nodes = rule.nodes(size).checked_pow(last.dimensions);
        nodes.is_some_and(|n| n <= MOST)
    };
    // Every rule has one that fits: 3⁶ = 729.
    let size = (1..=MOST).take_while(|&m| fits(m)).last().unwrap_or(1);
    let measured = Measured::new(bench, settings, Case { size, ..last })?;
    let (rms, floor) = (measured.rms(), last.allowance());
    Ok(if rms < floor {
        Cell::shown(rms, format!("< {}", short(floor, 1)))
    } else {
        Cell::shown(rms, short(rms, 2))
    })
}

/// From which dimension on Monte Carlo's error is below the midpoint rule's.
fn winner(what: &str, errors: &Table) -> String {
    let error = |method: Method, s: u32| errors.number(method.name(), &format!("{s}-D"));
    let wins = |s: &u32| {
        let monte_carlo = error(Method::Independent, *s);
        let midpoint = error(Method::Rule(Rule::Midpoint), *s);
        monte_carlo.zip(midpoint).is_some_and(|(a, b)| a < b)
    };
    match (1..=DIMENSIONS).find(|s| (*s..=DIMENSIONS).all(|t| wins(&t))) {
        Some(s) => format!(
            "{what}, 4,096 evaluations: Monte Carlo's error is below the midpoint rule's from {s} dimensions on"
        ),
        None => format!(
            "{what}, 4,096 evaluations: Monte Carlo's error is not below the midpoint rule's in up to {DIMENSIONS} dimensions"
        ),
    }
}

/// Adds a method's ladder to the plot of its integrand and dimension.
fn with_row(mut plots: Vec<Plot>, what: &str, row: &Row) -> Vec<Plot> {
    let case = row.last().case;
    let file = format!("quadrature-{what}-{}d", case.dimensions);
    let colour = (case.variant() % 8) as usize;
    let evaluations = |m: &Measured| f64::from(m.case.evaluations().unwrap_or(0));
    let series = Series {
        name: case.method.name().to_owned(),
        points: row
            .ladder
            .iter()
            .map(|m| (evaluations(m), m.rms()))
            .collect(),
        mark: Mark::Dots,
        colour,
    };
    if let Some(plot) = plots.iter_mut().find(|p| p.file == file) {
        plot.series.push(series);
    } else {
        plots.push(Plot {
            file,
            title: format!("{what} integrand, {} dimensions", case.dimensions),
            axes: ["evaluations".to_owned(), "RMS error".to_owned()],
            logarithmic: true,
            series: vec![series],
        });
    }
    plots
}

/// The lecture's error formulas in one dimension: f″ averages 4 over [0, 1], and a jump costs
/// 1/(n√12) in the root mean square, the deviation of a uniform number of width 1/n.
fn lecture_formulas(
    bench: &Bench<'_>,
    settings: &Settings,
    report: &mut Report,
) -> Result<(), GpuError> {
    let mut table = Table::new(
        "one dimension, n panels: error I − Q beside the lecture's formulas",
        &[
            "n",
            "midpoint",
            "(b−a)³f″/(24n²)",
            "trapezoid",
            "−(b−a)³f″/(12n²)",
            "jump, midpoint, RMS",
            "1/(n√12)",
        ],
    );
    for size in [2, 4, 8, 16, 32, 64] {
        let error = |integrand, rule| -> Result<Measured, GpuError> {
            let case = Case {
                integrand,
                method: Method::Rule(rule),
                dimensions: 1,
                size,
            };
            Measured::new(bench, settings, case)
        };
        let midpoint = error(Integrand::Smooth, Rule::Midpoint)?;
        let trapezoid = error(Integrand::Smooth, Rule::Trapezoid)?;
        let n = f64::from(size);
        table.push(vec![
            Cell::fixed(n, 0),
            Cell::short(-midpoint.errors[0], 4),
            Cell::short(4.0 / (24.0 * n * n), 4),
            Cell::short(-trapezoid.errors[0], 4),
            Cell::short(-4.0 / (12.0 * n * n), 4),
            Cell::short(error(Integrand::Box, Rule::Midpoint)?.rms(), 4),
            Cell::short(1.0 / (n * 12_f64.sqrt()), 4),
        ]);
    }
    report.tables.push(table);
    Ok(())
}
