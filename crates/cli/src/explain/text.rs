//! What `direkt explain` prints.

use super::Report;
use direkt_instruments::cost::Interval;
use direkt_instruments::explain::price::{Price, Prices};
use direkt_instruments::explain::sample::RandomNumbers;
use direkt_instruments::report::format::{grouped, number, range, seconds};
use std::fmt::Write;

/// All of it; writing to a String cannot fail.
pub(super) fn of(report: &Report) -> String {
    let mut out = format!("{} calls for\n", report.scene);
    for effect in &report.called_for {
        let _ = writeln!(out, "  {:22} {}", effect.name, effect.reason);
    }
    let _ = writeln!(out, "left out: {}", report.left_out.join(", "));
    let _ = writeln!(
        out,
        "{} primitives, {} lights, BVH of {} nodes and depth {}",
        report.primitives, report.lights, report.bvh_nodes, report.bvh_depth,
    );
    for aov in &report.aovs {
        let _ = writeln!(out, "AOV {:22} {}", aov.name, aov.cost);
    }
    if let Some(grid) = &report.environment {
        let by = if grid.compensated {
            "what of its luminance exceeds the mean (mis_compensation)"
        } else {
            "its luminance"
        };
        let _ = writeln!(
            out,
            "a direction towards the environment map is chosen among {} × {} cells, each by {by}",
            grid.columns, grid.rows
        );
    }
    if let Some(reason) = &report.mis_compensation_unused {
        let _ = writeln!(out, "mis_compensation changes nothing: {reason}");
    }
    out.push_str(&resources(report));
    if let Some(prices) = &report.measured {
        out.push_str(&table(report, prices));
    }
    for warning in report.biased.iter().chain(&report.warnings) {
        let _ = writeln!(out, "warning: {warning}");
    }
    out
}

/// What the kernel, its buffers and a sample take.
fn resources(report: &Report) -> String {
    let shader = report.shader;
    let mut out = format!(
        "kernel: {} bytes of WGSL, {} functions, {} instructions of SPIR-V\n",
        grouped(shader.wgsl_bytes as f64),
        shader.functions,
        grouped(shader.spirv_instructions as f64),
    );
    let rays = report.rays;
    let _ = write!(
        out,
        "rays per sample, at most: {} (camera {}, shadow {}, BSDF {})",
        number(rays.total()),
        number(rays.camera),
        number(rays.shadow),
        number(rays.bsdf),
    );
    if let Some(prices) = &report.measured {
        let found = prices.rays_per_sample;
        let _ = write!(
            out,
            "; measured {} (shadow {}, BSDF {})",
            number(found.total()),
            number(found.shadow),
            number(found.bsdf),
        );
    }
    let purposes: Vec<String> = report.random_numbers.iter().map(purpose).collect();
    let _ = writeln!(
        out,
        "\nrandom numbers per sample: {} ({})\nmemory: {}",
        report.random_numbers_per_sample,
        purposes.join(", "),
        bytes(report.memory_bytes),
    );
    for memory in &report.memory {
        let _ = writeln!(out, "  {:26} {:>12}", memory.name, bytes(memory.bytes));
    }
    out
}

/// `light point 4–5 × 16`.
fn purpose(numbers: &RandomNumbers) -> String {
    let (first, last) = (numbers.first, numbers.first + numbers.dimensions - 1);
    let mut out = format!("{} {first}", numbers.purpose);
    if first >= 64 {
        out += " and on";
    } else if last > first {
        let _ = write!(out, "–{last}");
    }
    if numbers.times > 1 {
        let _ = write!(out, " × {}", numbers.times);
    }
    out
}

/// Bytes in the unit that suits them.
fn bytes(count: u64) -> String {
    let count = count as f64;
    match count {
        c if c < 1024.0 => format!("{c} B"),
        c if c < 1_048_576.0 => format!("{} KiB", number(c / 1024.0)),
        c => format!("{} MiB", number(c / 1_048_576.0)),
    }
}

/// What each kernel costs.
fn table(report: &Report, prices: &Prices) -> String {
    let adapter = report.adapter.as_ref().map_or("", |a| a.name.as_str());
    let mut out = format!(
        "what each further effect costs on {adapter}, {} × {} pixels: compiled {} times, {} images of {} samples per pixel in \
         turn, {}{}\n  {:<28}{:>8}{:>12}{:>22}{:>12}{:>22}\n",
        prices.width,
        prices.height,
        prices.rounds,
        prices.turns,
        prices.samples,
        seconds(prices.seconds),
        if prices.interrupted {
            ", interrupted"
        } else {
            ""
        },
        "kernel",
        "SPIR-V",
        "compile",
        "× called for",
        "per sample",
        "× called for",
    );
    for price in &prices.kernels {
        let _ = writeln!(
            out,
            "  {:<28}{:>8}{:>12}{:>22}{:>12}{:>22}",
            price.kernel,
            grouped(price.size.spirv_instructions as f64),
            seconds(price.compile_seconds.value),
            ratio(&price.compile_ratio),
            seconds(price.sample_seconds.value),
            ratio(&price.sample_ratio),
        );
    }
    if let Some(Price {
        compile_ratio,
        sample_ratio,
        ..
    }) = prices.kernels.last().filter(|_| prices.kernels.len() > 1)
    {
        let _ = writeln!(
            out,
            "what is called for is {} times as fast as with all of it, and compiles {} times as fast",
            ratio(sample_ratio),
            ratio(compile_ratio),
        );
    }
    out
}

/// `1.25 [1.20, 1.30]`.
fn ratio(interval: &Interval) -> String {
    let show = |x: f64| {
        if x.is_finite() {
            format!("{x:.2}")
        } else {
            "∞".to_owned()
        }
    };
    format!("{} {}", show(interval.value), range(interval, show))
}
