//! Inversion against rejection, for densities and discrete distributions, and the alias table
//! (Walker 1974).
//!
//! ```text
//!     inversion    x = F⁻¹(u): one random number, if F has an inverse
//!     rejection    (x, y) uniform in a box around p, kept if y < p(x): 1/efficiency attempts of two numbers
//! ```
//!
//! Samples come from the GPU; their histogram is held against the distribution function by
//! Pearson's χ², and the attempts that they took against the geometric distribution.

use super::Settings;
use super::bench::Bench;
use super::densities::{DENSITIES, Density, Discrete};
use super::layout::{LabBlock, LabRun};
use super::plot::{Mark, Plot, Series};
use super::report::{Cell, Check, Report, Table};
use direkt::error::GpuError;
use direkt::low_level::gpu::Context;
use direkt::low_level::stats::chi2::{Totals, chi2_test};

/// Cells of a histogram; odd, so that no edge lies on a symmetry.
pub const CELLS: usize = 31;
/// Most samples of one row: each is read back by itself.
const MOST: u32 = 1 << 22;

/// Names of the ways to sample a discrete distribution, in the order of the kernel's variants.
const DISCRETE_METHODS: [&str; 4] = [
    "inversion, linear search",
    "inversion, binary search",
    "rejection",
    "alias table",
];

/// Draws from density number `density` by inversion (`variant` 0) or rejection (1).
///
/// # Errors
/// The driver fails.
pub fn draw(
    bench: &Bench<'_>,
    settings: &Settings,
    density: usize,
    variant: u32,
) -> Result<Vec<LabBlock>, GpuError> {
    let run = LabRun {
        variant,
        items: settings.samples.min(MOST),
        samples: 1,
        seed: settings.seed,
        stream: 2 * density as u32 + variant,
        size: density as u32,
        constants: [settings.density_scale as f32, 0.0, 0.0, 0.0],
        ..LabRun::default()
    };
    Ok(bench.run(&run, &[])?.blocks)
}

/// Draws from a discrete distribution by one of the kernel's four variants.
///
/// # Errors
/// The driver fails.
pub fn draw_discrete(
    bench: &Bench<'_>,
    settings: &Settings,
    distribution: &Discrete,
    variant: u32,
) -> Result<Vec<LabBlock>, GpuError> {
    let count = distribution.probability.len() as u32;
    let run = LabRun {
        variant,
        items: settings.samples.min(MOST),
        samples: 1,
        seed: settings.seed,
        stream: 100 + 4 * count + variant,
        size: count,
        ..LabRun::default()
    };
    let table = distribution.table(settings.density_scale);
    Ok(bench.run(&run, &table)?.blocks)
}

/// Counts per cell of `edges`, and in the last place those outside. A millionth of the interval
/// counts as rounding.
pub fn histogram(blocks: &[LabBlock], edges: &[f64]) -> Vec<u64> {
    let cells = edges.len() - 1;
    let (low, high) = (edges[0], edges[cells]);
    let length = high - low;
    let mut counts = vec![0; cells + 1];
    for block in blocks {
        let place = (f64::from(block.mean) - low) / length;
        let inside = (-1e-6..=1.0 + 1e-6).contains(&place);
        let cell = (place.max(0.0) * cells as f64) as usize;
        counts[if inside { cell.min(cells - 1) } else { cells }] += 1;
    }
    counts
}

/// The check that `counts` (the last of them outside) follow the distribution function `cdf`.
pub fn check_histogram(
    name: String,
    counts: &[u64],
    edges: &[f64],
    cdf: impl Fn(f64) -> f64,
) -> Check {
    let n: u64 = counts.iter().sum();
    let parts = edges.windows(2).map(|w| n as f64 * (cdf(w[1]) - cdf(w[0])));
    let expected: Vec<f64> = parts.chain([0.0]).collect();
    check_counts(name, counts, &expected)
}

/// The check that `counts` are as `expected`: χ² and its degrees of freedom.
fn check_counts(name: String, counts: &[u64], expected: &[f64]) -> Check {
    let test = chi2_test(counts, expected, Totals::Tied);
    let (statistic, freedom, p_value) = test.map_or((f64::NAN, 0, 0.0), |t| {
        (t.statistic, t.degrees_of_freedom, t.p_value)
    });
    Check {
        name,
        measured: statistic,
        expected: freedom as f64,
        p_value,
    }
}

fn mean_tries(blocks: &[LabBlock]) -> f64 {
    blocks.iter().map(|b| f64::from(b.tries)).sum::<f64>() / blocks.len() as f64
}

/// Runs the experiment.
///
/// # Errors
/// A kernel does not compile, or the driver fails.
pub fn run(context: &Context, settings: &Settings) -> Result<Report, GpuError> {
    let mut report = Report::new(
        "sampling",
        "inversion against rejection, and the alias table",
    );
    let mut shapes = Table::new(
        "shapes: each row of blocks from 0 to its own largest value",
        &["distribution", "pdf", "histogram", "cdf"],
    );
    continuous(context, settings, &mut report, &mut shapes)?;
    discrete(context, settings, &mut report, &mut shapes)?;
    report.tables.push(shapes);
    report.notes.push(
        "inversion takes one number and keeps a sequence's stratification, but needs an inverse; rejection needs only \
         the density and its maximum, and pays with attempts where the density is narrow in its box"
            .to_owned(),
    );
    report.notes.push(
        "the alias table costs one look-up however many outcomes there are; a search costs more the more there are"
            .to_owned(),
    );
    Ok(report)
}

fn continuous(
    context: &Context,
    settings: &Settings,
    report: &mut Report,
    shapes: &mut Table,
) -> Result<(), GpuError> {
    let bench = Bench::new(context, "lab_sampling")?;
    let mut table = Table::new(
        "densities: attempts per sample, random numbers per sample, χ² of 31 cells",
        &[
            "density", "method", "attempts", "exact", "numbers", "χ²", "p",
        ],
    );
    for (i, density) in DENSITIES.iter().enumerate() {
        let edges = density.edges(CELLS);
        let exact = [1.0, 1.0 / density.efficiency()];
        let methods = [
            format!("inversion: {}", density.inverse),
            "rejection".to_owned(),
        ];
        let mut kept = Vec::new();
        for (variant, method) in methods.into_iter().enumerate() {
            let blocks = draw(&bench, settings, i, variant as u32)?;
            let counts = histogram(&blocks, &edges);
            let what = format!("{} by {method}", density.name);
            let check = check_histogram(format!("χ² of {what}"), &counts, &edges, density.cdf);
            let tries = mean_tries(&blocks);
            let p = 1.0 / exact[variant];
            table.push(vec![
                Cell::text(density.name),
                Cell::text(method),
                Cell::fixed(tries, 4),
                Cell::fixed(exact[variant], 4),
                Cell::fixed(tries * [1.0, 2.0][variant], 2),
                Cell::fixed(check.measured, 1),
                Cell::short(check.p_value, 2),
            ]);
            report.checks.push(check);
            report.checks.push(Check::mean(
                format!("attempts of {what}"),
                tries,
                exact[variant],
                (1.0 - p) / (p * p) / blocks.len() as f64,
                1e-6,
            ));
            kept.push(counts);
        }
        show_density(density, &edges, &kept[1], report, shapes);
    }
    report.tables.push(table);
    Ok(())
}

/// Histogram of the rejected-from samples beside the density and the distribution function.
fn show_density(
    density: &Density,
    edges: &[f64],
    counts: &[u64],
    report: &mut Report,
    shapes: &mut Table,
) {
    let n: u64 = counts.iter().sum();
    let width = edges[1] - edges[0];
    let middles: Vec<f64> = edges.windows(2).map(|w| 0.5 * (w[0] + w[1])).collect();
    let found: Vec<f64> = counts[..CELLS]
        .iter()
        .map(|&c| c as f64 / (n as f64 * width))
        .collect();
    let pdf: Vec<f64> = edges
        .windows(2)
        .map(|w| ((density.cdf)(w[1]) - (density.cdf)(w[0])) / width)
        .collect();
    let cdf: Vec<f64> = edges[1..].iter().map(|&x| (density.cdf)(x)).collect();
    shapes.push(vec![
        Cell::text(density.name),
        Cell::text(blocks_of(&pdf)),
        Cell::text(blocks_of(&found)),
        Cell::text(blocks_of(&cdf)),
    ]);
    let fine = density.edges(400);
    let curve = |f: fn(f64) -> f64| fine.iter().map(|&x| (x, f(x))).collect();
    report.plots.push(plot(
        density.file,
        density.name,
        [
            middles.into_iter().zip(found).collect(),
            curve(density.pdf),
            curve(density.cdf),
        ],
    ));
}

fn discrete(
    context: &Context,
    settings: &Settings,
    report: &mut Report,
    shapes: &mut Table,
) -> Result<(), GpuError> {
    let bench = Bench::new(context, "lab_discrete")?;
    let mut table = Table::new(
        "discrete distributions: steps (comparisons, attempts, look-ups) per sample, χ² of all outcomes",
        &["distribution", "method", "steps", "exact", "χ²", "p"],
    );
    for distribution in Discrete::all() {
        let count = distribution.probability.len();
        let mut found = Vec::new();
        for (variant, method) in DISCRETE_METHODS.into_iter().enumerate() {
            let blocks = draw_discrete(&bench, settings, &distribution, variant as u32)?;
            let mut counts = vec![0_u64; count + 1];
            for block in &blocks {
                counts[(block.mean as usize).min(count)] += 1;
            }
            let n = blocks.len() as f64;
            let expected = distribution.probability.iter().map(|p| n * p);
            let expected: Vec<f64> = expected.chain([0.0]).collect();
            let what = format!("{} by {method}", distribution.name);
            let check = check_counts(format!("χ² of {what}"), &counts, &expected);
            let steps = mean_tries(&blocks);
            let exact = distribution.steps(variant);
            table.push(vec![
                Cell::text(distribution.name),
                Cell::text(method),
                Cell::fixed(steps, 4),
                Cell::fixed(exact.mean, 4),
                Cell::fixed(check.measured, 1),
                Cell::short(check.p_value, 2),
            ]);
            report.checks.push(check);
            let variance = (exact.square - exact.mean * exact.mean).max(0.0);
            report.checks.push(Check::mean(
                format!("steps of {what}"),
                steps,
                exact.mean,
                variance / n,
                1e-6,
            ));
            found = counts[..count].iter().map(|&c| c as f64 / n).collect();
        }
        show_discrete(&distribution, &found, report, shapes);
    }
    report.tables.push(table);
    Ok(())
}

/// Histogram of the alias table's samples beside the probabilities and their sums; long ones every
/// fourth.
fn show_discrete(distribution: &Discrete, found: &[f64], report: &mut Report, shapes: &mut Table) {
    let step = distribution.probability.len().div_ceil(CELLS);
    let thin = |values: &[f64]| -> Vec<f64> { values.iter().copied().step_by(step).collect() };
    let cdf = distribution.cdf();
    shapes.push(vec![
        Cell::text(distribution.name),
        Cell::text(blocks_of(&thin(&distribution.probability))),
        Cell::text(blocks_of(&thin(found))),
        Cell::text(blocks_of(&thin(&cdf))),
    ]);
    let indexed = |values: &[f64]| -> Vec<(f64, f64)> {
        values
            .iter()
            .zip(0..)
            .map(|(&p, i)| (f64::from(i), p))
            .collect()
    };
    report.plots.push(plot(
        distribution.file,
        distribution.name,
        [
            indexed(found),
            indexed(&distribution.probability),
            indexed(&cdf),
        ],
    ));
}

fn plot(file: &str, title: &str, [found, pdf, cdf]: [Vec<(f64, f64)>; 3]) -> Plot {
    let series = |name: &str, points, mark, colour| Series {
        name: name.to_owned(),
        points,
        mark,
        colour,
    };
    Plot {
        file: file.to_owned(),
        title: title.to_owned(),
        axes: ["x".to_owned(), "density, distribution".to_owned()],
        logarithmic: false,
        series: vec![
            series("GPU samples", found, Mark::Columns, 5),
            series("pdf", pdf, Mark::Line, 0),
            series("cdf", cdf, Mark::Dashed, 1),
        ],
    }
}

/// A row of block characters, from 0 to the largest value.
fn blocks_of(values: &[f64]) -> String {
    const LEVELS: [char; 9] = [' ', '▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
    let largest = values.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let level = |v: &f64| LEVELS[((v / largest * 8.0).ceil() as usize).min(8)];
    values.iter().map(level).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(x: f32) -> LabBlock {
        LabBlock {
            mean: x,
            ..LabBlock::default()
        }
    }

    #[test]
    fn what_lies_outside_is_counted_apart() {
        let blocks = [0.0, 0.49, 0.5, 1.0, 1.000_000_1, 1.1, -0.2].map(value);
        assert_eq!(histogram(&blocks, &[0.0, 0.5, 1.0]), [2, 3, 2]);
        assert_eq!(histogram(&[value(f32::NAN)], &[0.0, 1.0]), [0, 1]);
    }

    #[test]
    fn a_hit_outside_is_rejected() {
        let check = |counts: &[u64]| {
            check_histogram(String::new(), counts, &[0.0, 0.5, 1.0], |x| x).p_value
        };
        assert!(check(&[5000, 5000, 0]) >= 1.0);
        assert!(check(&[5000, 5000, 1]) <= 0.0);
    }

    #[test]
    fn rows_of_blocks_reach_from_nothing_to_full() {
        assert_eq!(blocks_of(&[0.0, 0.5, 1.0]), " ▄█");
    }
}
