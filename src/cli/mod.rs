//! The commands. Each prints facts on stdout or in files, progress and warnings on stderr.

mod calibrate;
mod check;
mod compare;
mod cost;
mod doctor;
mod explain;
mod interrupt;
mod lab;
mod outputs;
mod passes;
#[cfg(feature = "window")]
mod preview;
mod progress;
mod render;
mod settings;

use crate::error::Error;
use clap::{Parser, Subcommand};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Direct lighting by Monte Carlo integration in WGSL compute shaders, with the error of every image.
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
    #[cfg(feature = "window")]
    Preview(preview::Arguments),
    /// Hold the GPU estimator against the reference: exit 0 when they agree, 1 when not
    Compare(compare::Arguments),
    /// Tell what accuracy costs in time: error against time of every estimator, in a report
    Cost(cost::Arguments),
    /// Tell which effects a scene calls for, and why
    Explain(explain::Arguments),
    /// Run the experiments of a lecture on Monte Carlo integration: exit 0 when all agree with their exact values
    Lab(lab::Arguments),
    /// Tell whether the adapters of this machine can be trusted
    Doctor(doctor::Arguments),
}

/// Parses the command line, runs the command and reports its error; the exit code is 0 for success, 1 for a failed
/// check or a failing driver, 2 for wrong use or bad input.
pub fn main() -> ExitCode {
    let cli = Cli::parse();
    let result = match cli.command {
        Command::Render(arguments) => render::run(&arguments),
        #[cfg(feature = "window")]
        Command::Preview(arguments) => preview::run(&arguments),
        Command::Compare(arguments) => compare::run(&arguments),
        Command::Cost(arguments) => cost::run(&arguments),
        Command::Explain(arguments) => explain::run(&arguments),
        Command::Lab(arguments) => lab::run(&arguments),
        Command::Doctor(arguments) => doctor::run(&arguments),
    };
    match result {
        Ok(code) => code,
        Err(error) => {
            eprintln!("direkt: {error}");
            ExitCode::from(error.exit_code())
        }
    }
}

/// Which adapter to use.
#[derive(Debug, clap::Args)]
struct AdapterArgument {
    /// Use the first adapter whose name or driver contains this (any case); see `direkt doctor`
    #[arg(long, value_name = "SUBSTRING")]
    adapter: Option<String>,
}

/// Where the same facts go as JSON.
#[derive(Debug, clap::Args)]
struct JsonArgument {
    /// Write the facts as JSON to this file; `-` is stdout
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

impl JsonArgument {
    fn write(&self, facts: &impl serde::Serialize) -> Result<(), Error> {
        let Some(path) = &self.json else {
            return Ok(());
        };
        let mut text = serde_json::to_string_pretty(facts).expect("facts are plain data");
        text.push('\n');
        if path.as_os_str() == "-" {
            print(&text)
        } else {
            crate::image::write_atomically(path, text.as_bytes())
        }
    }

    fn is_stdout(&self) -> bool {
        self.json.as_deref() == Some(Path::new("-"))
    }
}

/// Writes to stdout; a reader that went away is no reason to panic.
fn print(text: &str) -> Result<(), Error> {
    use std::io::Write;
    match std::io::stdout().write_all(text.as_bytes()) {
        Err(source) if source.kind() != std::io::ErrorKind::BrokenPipe => Err(Error::Write {
            path: PathBuf::from("stdout"),
            source,
        }),
        _ => Ok(()),
    }
}
