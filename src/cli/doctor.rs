//! `direkt doctor`: can the adapters of this machine be trusted?

use super::{AdapterArgument, JsonArgument, print};
use crate::error::{Error, GpuError};
use crate::gpu::doctor::{Diagnosis, examine};
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
    arguments.json.write(&diagnoses)?;
    if !arguments.json.is_stdout() {
        for diagnosis in &diagnoses {
            print(&text(diagnosis))?;
        }
    }
    let all_fit = diagnoses.iter().all(Diagnosis::is_fit);
    Ok(if all_fit {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
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
    match &d.loop_budget {
        Ok(budget) => {
            for canary in &budget.canaries {
                let _ = writeln!(
                    out,
                    "  loop of {:17} {} of {} iterations ran",
                    canary.shape, canary.ran, canary.expected
                );
            }
        }
        Err(message) => {
            let _ = writeln!(out, "  loop canary               {message}");
        }
    }
    let _ = writeln!(out, "  verdict                   {}", d.verdict());
    out
}
