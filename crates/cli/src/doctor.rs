//! `direkt doctor`: can the adapters of this machine be trusted?

use super::plan::{Failures, Plan};
use super::{AdapterArgument, JsonArgument};
use direkt::error::{Error, GpuError};
use direkt::low_level::console::print;
use direkt::low_level::gpu::doctor::{Diagnosis, DriverFacts, examine};
use std::fmt::Write;
use std::process::ExitCode;

/// Arguments of `direkt doctor`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    adapter: AdapterArgument,
    #[command(flatten)]
    json: JsonArgument,
}

/// Runs the command; 1 when an adapter that was examined cannot render.
pub fn run(arguments: &Arguments) -> Result<ExitCode, Error> {
    let mut plan = Plan::default();
    arguments.json.plan(&mut plan)?;
    let wanted = arguments.adapter.adapter.as_deref();
    let diagnoses = examine(wanted);
    if diagnoses.is_empty() {
        return Err(match wanted {
            Some(wanted) => GpuError::NoSuchAdapter {
                wanted: wanted.to_owned(),
                available: examine(None).into_iter().map(|d| d.adapter.name).collect(),
            },
            None => GpuError::NoAdapter,
        }
        .into());
    }
    let mut failures = Failures::default();
    failures.note(arguments.json.write(&plan, &diagnoses));
    if !arguments.json.is_stdout() {
        for diagnosis in &diagnoses {
            print(&text(diagnosis));
        }
    }
    let all_fit = diagnoses.iter().all(Diagnosis::is_fit);
    Ok(failures.exit_code(if all_fit {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }))
}

fn text(d: &Diagnosis) -> String {
    let mut out = String::new();
    let kind = if d.adapter.software {
        "software"
    } else {
        "hardware"
    };
    // Writing to a String cannot fail.
    let _ = writeln!(out, "{} ({kind}, {})", d.adapter.name, d.adapter.backend);
    let _ = writeln!(out, "  driver                    {}", d.adapter.driver);
    let _ = writeln!(
        out,
        "  storage binding           {} MiB",
        d.limits.max_storage_buffer_binding_size >> 20
    );
    let _ = writeln!(
        out,
        "  buffer                    {} MiB",
        d.limits.max_buffer_size >> 20
    );
    let _ = writeln!(
        out,
        "  texture side              {}",
        d.limits.max_texture_dimension_2d
    );
    let _ = writeln!(
        out,
        "  subgroup size             {}–{}",
        d.limits.subgroup_min_size, d.limits.subgroup_max_size
    );
    let _ = writeln!(
        out,
        "  subgroup operations       {}; direkt uses none",
        offered(d.limits.subgroup_operations)
    );
    match &d.driver {
        Ok(facts) => driver(&mut out, facts),
        Err(message) => {
            let _ = writeln!(out, "  driver                    {message}");
        }
    }
    let _ = writeln!(out, "  verdict                   {}", d.verdict());
    out
}

fn offered(yes: bool) -> &'static str {
    if yes { "offered" } else { "not offered" }
}

fn driver(out: &mut String, facts: &DriverFacts) {
    for canary in &facts.loop_budget.canaries {
        let _ = writeln!(
            out,
            "  loop of {:17} {} of {} iterations ran",
            canary.shape, canary.ran, canary.expected
        );
    }
    let a = &facts.arithmetic;
    let mut line = |what: &str, found: String| {
        let _ = writeln!(out, "  {what:25} {found}");
    };
    line(
        "NaN and infinity",
        format!(
            "{} misread by bits, {} by comparison, {} let through by a range test",
            a.misclassified, a.misclassified_by_comparison, a.passed_by_range
        ),
    );
    let choose = |yes: bool, a: &str, b: &str| if yes { a } else { b }.to_owned();
    line(
        "subnormal numbers",
        choose(a.keeps_subnormals, "kept", "flushed to zero"),
    );
    line(
        "a·b − c",
        choose(a.contracts, "fused unasked", "rounded twice"),
    );
    line("fma", choose(a.fuses_fma, "rounded once", "rounded twice"));
    line(
        "compensated sums",
        choose(a.keeps_compensation, "work", "lose their error term"),
    );
    for p in &facts.precision {
        line(
            p.function,
            format!(
                "off by {} of {} that are allowed, on {}{}",
                p.worst(),
                p.bound(),
                p.domain,
                if p.needed { "" } else { " (not used)" }
            ),
        );
    }
    line(
        "load per invocation",
        format!(
            "{:.2} ns at an address of its own, {:.2} ns at one that all share",
            facts.loads.own_nanoseconds, facts.loads.shared_nanoseconds
        ),
    );
}
