//! The commands. Each prints facts on stdout or in files, progress and warnings on stderr.

mod calibrate;
mod check;
mod compare;
mod cost;
mod doctor;
mod duration;
mod explain;
mod interrupt;
mod lab;
mod outputs;
mod passes;
mod plan;
mod preview;
mod progress;
mod render;
mod settings;

use clap::{Parser, Subcommand};
use direkt::error::{Error, GpuError};
use direkt::low_level::console::{self, say};
use direkt::low_level::gpu::{Context, shader};
use direkt::low_level::output::{self, Destination};
use plan::Plan;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Direct lighting by Monte Carlo integration in WGSL compute shaders, with the error of every
/// image.
#[derive(Debug, Parser)]
#[command(name = "direkt", version, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Render a scene progressively to .exr and .png files
    Render(render::Arguments),
    /// Show a scene in a window while its image gets right
    Preview(preview::Arguments),
    /// Hold the GPU estimator against the reference: exit 0 when they agree, 1 when not
    Compare(compare::Arguments),
    /// Tell what accuracy costs in time: error against time of every estimator, in a report
    Cost(cost::Arguments),
    /// Tell which effects a scene calls for, and why
    Explain(explain::Arguments),
    /// Run the experiments of a lecture on Monte Carlo integration: exit 0 when all agree with
    /// their exact values
    Lab(lab::Arguments),
    /// Tell whether the adapters of this machine can be trusted
    Doctor(doctor::Arguments),
}

/// Parses the command line, runs the command and reports its error; the exit code is 0 for success,
/// 1 for a failed check or a failing driver, 2 for wrong use or bad input.
pub fn main() -> ExitCode {
    interrupt::survive_size_limit();
    let cli = Cli::parse();
    let result = match cli.command {
        Command::Render(arguments) => render::run(&arguments),
        Command::Preview(arguments) => preview::run(&arguments),
        Command::Compare(arguments) => compare::run(&arguments),
        Command::Cost(arguments) => cost::run(&arguments),
        Command::Explain(arguments) => explain::run(&arguments),
        Command::Lab(arguments) => lab::run(&arguments),
        Command::Doctor(arguments) => doctor::run(&arguments),
    };
    let code = result.unwrap_or_else(|error| {
        say(format_args!("direkt: {error}"));
        ExitCode::from(error.exit_code())
    });
    match console::stdout_failure() {
        Some(error) => {
            say(format_args!("direkt: stdout: cannot be written: {error}"));
            ExitCode::FAILURE
        }
        None => code,
    }
}

/// Which adapter to use.
#[derive(Debug, clap::Args)]
struct AdapterArgument {
    /// Use the first adapter whose name or driver contains this (any case); see `direkt doctor`
    #[arg(long, value_name = "SUBSTRING")]
    adapter: Option<String>,
}

impl AdapterArgument {
    /// Opens it.
    fn open(&self) -> Result<Context, GpuError> {
        Context::new(self.adapter.as_deref())
    }
}

/// Where the same facts go as JSON.
#[derive(Debug, clap::Args)]
struct JsonArgument {
    /// Write the facts as JSON to this file; `-` is stdout
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

impl JsonArgument {
    /// Adds the file to what the command is going to write, and keeps shaders of the user's own
    /// from being written.
    fn plan(&self, plan: &mut Plan) -> Result<(), Error> {
        if let Some(path) = self.json.as_ref().filter(|p| p.as_os_str() != STDOUT) {
            plan.file("--json", path)?;
        }
        plan.spare(&shader::own_files(), "a shader that is read")
    }

    /// Writes `facts`, or saves them elsewhere.
    fn write(&self, plan: &Plan, facts: &impl serde::Serialize) -> Result<(), Error> {
        let Some(path) = &self.json else {
            return Ok(());
        };
        let mut text = serde_json::to_string_pretty(facts).expect("facts are plain data");
        text.push('\n');
        if path.as_os_str() != STDOUT {
            return plan.write(path, text.as_bytes());
        }
        console::write_stdout(text.as_bytes()).map_err(|source| Error::Write {
            path: PathBuf::from("stdout"),
            source,
            saved_as: output::save_elsewhere(Path::new("direkt.json"), text.as_bytes()),
        })
    }

    /// Whether nothing else may be printed.
    fn is_stdout(&self) -> bool {
        let is_stdout = |path: &PathBuf| {
            path.as_os_str() == STDOUT || Destination::of(path) == Ok(Destination::Stdout)
        };
        self.json.as_ref().is_some_and(is_stdout)
    }
}

/// What `--json` calls the standard output.
const STDOUT: &str = "-";
