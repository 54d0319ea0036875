//! `direkt lab`: the experiments of a lecture on Monte Carlo integration.

use super::plan::{Failures, Plan, usable};
use super::{AdapterArgument, JsonArgument};
use direkt::error::Error;
use direkt::low_level::console::print;
use direkt::low_level::gpu::{AdapterFacts, Context};
use direkt_instruments::lab::report::Report;
use direkt_instruments::lab::{Experiment, Settings, run as run_experiment};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Arguments of `direkt lab`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Run this experiment only; may be repeated
    #[arg(long = "experiment", value_enum, value_name = "NAME")]
    experiments: Vec<Experiment>,
    /// Samples per row, from 65536 on
    #[arg(long, default_value_t = Settings::default().samples)]
    samples: u32,
    /// Seed of the random numbers
    #[arg(long, default_value_t = 0)]
    seed: u32,
    /// Write the plots as SVG files into this folder, which is made where it is missing
    #[arg(short, long = "output", value_name = "DIR")]
    output: Option<PathBuf>,
    /// Make every density 2 % too large, which the checks have to find: exit 1
    #[arg(long = "break")]
    broken: bool,
    #[command(flatten)]
    adapter: AdapterArgument,
    #[command(flatten)]
    json: JsonArgument,
}

/// What `--json` writes.
#[derive(Debug, Serialize)]
struct Facts {
    direkt: &'static str,
    adapter: AdapterFacts,
    samples: u32,
    seed: u32,
    broken: bool,
    agrees: bool,
    experiments: Vec<Report>,
}

/// Runs the command; 1 when a measured value differs from the exact one.
pub fn run(arguments: &Arguments) -> Result<ExitCode, Error> {
    let settings = Settings {
        samples: arguments.samples,
        seed: arguments.seed,
        density_scale: if arguments.broken { 1.02 } else { 1.0 },
    };
    settings
        .validate()
        .map_err(|e| Error::Usage(format!("--samples: {e}")))?;
    let mut plan = Plan::default();
    if let Some(folder) = &arguments.output {
        plan.folder("-o", folder, &[])?;
    }
    arguments.json.plan(&mut plan)?;
    if let Some(folder) = &arguments.output {
        plan.reserve(folder, "svg")?;
    }
    let mut failures = Failures::default();
    let context = arguments.adapter.open()?;
    let to_stdout = !arguments.json.is_stdout();
    if to_stdout {
        print(&heading(&context, arguments));
    }
    let mut experiments = Vec::new();
    let mut folder = arguments.output.clone();
    for experiment in chosen(&arguments.experiments) {
        let report = run_experiment(&context, experiment, &settings)?;
        if to_stdout {
            print(&report.text());
        }
        folder = folder.map(|folder| usable(folder, &mut failures));
        if let Some(folder) = &folder {
            write_plots(&plan, folder, &report, &mut failures);
        }
        experiments.push(report);
    }
    let facts = Facts {
        direkt: env!("CARGO_PKG_VERSION"),
        adapter: context.adapter.clone(),
        samples: settings.samples,
        seed: settings.seed,
        broken: arguments.broken,
        agrees: experiments.iter().all(Report::agrees),
        experiments,
    };
    failures.note(arguments.json.write(&plan, &facts));
    if to_stdout {
        print(if facts.agrees {
            "verdict: all measured values agree with the exact ones\n"
        } else {
            "verdict: measured values DIFFER from the exact ones\n"
        });
    }
    Ok(failures.exit_code(if facts.agrees {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }))
}

/// All where none was named; each once, in the order of the lecture.
fn chosen(named: &[Experiment]) -> Vec<Experiment> {
    let all = Experiment::ALL.into_iter();
    all.filter(|e| named.is_empty() || named.contains(e))
        .collect()
}

fn heading(context: &Context, arguments: &Arguments) -> String {
    let broken = if arguments.broken {
        "broken on purpose: every density is 2 % too large\n"
    } else {
        ""
    };
    format!(
        "{} samples per row, seed {}, on {} ({})\n{broken}\n",
        arguments.samples, arguments.seed, context.adapter.name, context.adapter.driver
    )
}

fn write_plots(plan: &Plan, folder: &Path, report: &Report, failures: &mut Failures) {
    for plot in &report.plots {
        let path = folder.join(format!("{}.svg", plot.file));
        failures.note(plan.write(&path, plot.draw().file().as_bytes()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn experiments_run_once_and_all_where_none_is_named() {
        assert_eq!(chosen(&[]), Experiment::ALL);
        assert_eq!(
            chosen(&[Experiment::Pi, Experiment::Importance, Experiment::Pi]),
            [Experiment::Importance, Experiment::Pi]
        );
    }
}
