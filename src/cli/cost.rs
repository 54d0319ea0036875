//! `direkt cost`: what accuracy costs in time, for every estimator.

mod text;

use super::calibrate::{CalibrateArguments, print_table};
use super::explain::parse_effect;
use super::interrupt::Interrupt;
use super::settings::{ImageArguments, SceneListArguments};
use super::{AdapterArgument, JsonArgument, print, progress};
use crate::cost::calibrate::{Calibration, calibrate};
use crate::cost::estimator::{self, Choices};
use crate::cost::{Compiled, SceneCost, Settings, measure};
use crate::error::Error;
use crate::gpu::Context;
use crate::report::{self, csv, machine::Machine};
use crate::scene::{LightSampling, LightSelection, Sampler, Scene, ShadowPattern, Strategy};
use clap::ValueEnum;
use indicatif::ProgressBar;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Arguments of `direkt cost`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    scenes: SceneListArguments,
    /// Folder for report.html and the plots (SVG and PNG); made if need be
    #[arg(
        short,
        long = "output",
        value_name = "DIR",
        required_unless_present = "calibrate"
    )]
    output: Option<PathBuf>,
    /// Rendering time on each scene, such as 30s, 2m or 1m30s; compiling comes on top
    #[arg(long, value_name = "DURATION", default_value = "60s", value_parser = parse_duration)]
    budget: f64,
    /// Strategies to compare [default: all]
    #[arg(long, value_name = "LIST", value_enum, value_delimiter = ',')]
    strategies: Vec<Strategy>,
    /// How strategies that do not say so themselves choose a point of a light [default: the scene's]
    #[arg(long, value_name = "LIST", value_enum, value_delimiter = ',')]
    light_samplings: Vec<LightSampling>,
    /// Light selections to compare [default: the scene's]
    #[arg(long, value_name = "LIST", value_enum, value_delimiter = ',')]
    light_selections: Vec<LightSelection>,
    /// Numbers of shadow rays per camera ray to compare, each 1 to 1024 [default: the scene's]
    #[arg(long, value_name = "LIST", value_parser = super::settings::shadow_rays(), value_delimiter = ',')]
    shadow_rays: Vec<u32>,
    /// Patterns of their points to compare [default: the scene's]
    #[arg(long, value_name = "LIST", value_enum, value_delimiter = ',')]
    shadow_patterns: Vec<ShadowPattern>,
    /// Samplers to compare [default: independent,sobol; with --calibrate all]
    #[arg(long, value_name = "LIST", value_enum, value_delimiter = ',')]
    samplers: Vec<Sampler>,
    /// Effects to compile in without need, each beside every estimator as the scene calls for it, or `everything` at once: they
    /// give the same image, which is checked bit for bit, and what they cost is time. `direkt explain` names the effects
    #[arg(long, value_name = "LIST", value_parser = parse_compiled, value_delimiter = ',', conflicts_with = "calibrate")]
    effects: Vec<Compiled>,
    /// Relative mean squared error whose price is told
    #[arg(long, value_name = "RELMSE", default_value_t = 1e-3)]
    target_error: f64,
    /// Image to compare with, an EXR of the same size; otherwise the scene's exact values or a long run of direkt's own
    #[arg(long, value_name = "FILE")]
    reference: Option<PathBuf>,
    #[command(flatten)]
    image: ImageArguments,
    /// Write every measured point as a line of CSV to this file
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    #[command(flatten)]
    calibrate: CalibrateArguments,
    /// No progress on stderr, no table on stdout
    #[arg(short, long)]
    quiet: bool,
    #[command(flatten)]
    adapter: AdapterArgument,
    #[command(flatten)]
    json: JsonArgument,
}

/// What `--json` writes.
#[derive(Debug, Serialize)]
struct Report<'a> {
    machine: &'a Machine,
    interrupted: bool,
    /// Scenes, with `--calibrate` estimators, of which there is no result because it was.
    not_measured: &'a [String],
    scenes: &'a [SceneCost],
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    calibrations: &'a [Calibration],
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<ExitCode, Error> {
    arguments.check()?;
    let mut scenes = arguments.scenes.load()?;
    for scene in &mut scenes {
        arguments.image.apply(scene)?;
    }
    let bench = Bench {
        context: Context::new(arguments.adapter.adapter.as_deref())?,
        interrupt: Interrupt::listen(),
        quiet: arguments.quiet || arguments.json.is_stdout(),
    };
    match &arguments.output {
        Some(output) if !arguments.calibrate.calibrate => {
            arguments.measure(&bench, &scenes, output)
        }
        _ => arguments.calibrate(&bench, &scenes),
    }
}

/// What every measurement needs.
struct Bench {
    context: Context,
    interrupt: Interrupt,
    /// Nothing but results is printed.
    quiet: bool,
}

/// The cost on `scene`; `None` where Ctrl-C came before there was enough for a result.
fn measure_scene(
    bench: &Bench,
    scene: &Scene,
    settings: &Settings,
) -> Result<Option<SceneCost>, Error> {
    if bench.interrupt.came() {
        return Ok(None);
    }
    let source = scene.source.display();
    if !bench.quiet {
        let (name, driver) = (&bench.context.adapter.name, &bench.context.adapter.driver);
        eprintln!("measuring {source} on {name} ({driver})");
    }
    let progress = Bar::new(settings.budget, bench.quiet);
    let mut show = |what: &str, spent: f64| progress.show(&format!("{source}: {what}"), spent);
    let stop = || bench.interrupt.came();
    let cost = measure(&bench.context, scene, settings, &mut show, &stop)?;
    progress.finish();
    if let Some(cost) = cost.as_ref().filter(|_| !bench.quiet) {
        print(&text::summary(cost))?;
    }
    Ok(cost)
}

impl Arguments {
    /// Refuses what cannot be, before anything is rendered.
    fn check(&self) -> Result<(), Error> {
        let target = self.target_error;
        if !(target > 0.0 && target.is_finite()) {
            return Err(Error::Usage(format!(
                "--target-error {target}: a positive number such as 0.001 is needed"
            )));
        }
        if let Some(output) = self.output.as_ref().filter(|o| o.is_file()) {
            return Err(Error::Usage(format!(
                "{} is a file; name a folder for the report",
                output.display()
            )));
        }
        if self.reference.is_some() && self.scenes.scenes.len() > 1 {
            return Err(Error::Usage(
                "--reference is for one scene; name one".to_owned(),
            ));
        }
        Ok(())
    }

    /// Measures the scenes and writes the report into the folder `output`.
    fn measure(&self, bench: &Bench, scenes: &[Scene], output: &Path) -> Result<ExitCode, Error> {
        let machine = Machine::this(&bench.context.adapter);
        let (mut costs, mut not_measured) = (Vec::new(), Vec::new());
        for scene in scenes {
            match measure_scene(bench, scene, &self.settings(scene))? {
                Some(cost) => costs.push(cost),
                None => not_measured.push(scene.source.display().to_string()),
            }
        }
        let interrupted = !not_measured.is_empty() || costs.iter().any(|c| c.interrupted);
        if costs.is_empty() {
            return Ok(nothing_to_tell());
        }
        report::write(output, &costs, &not_measured, &machine)?;
        if let Some(path) = &self.csv {
            crate::image::write_atomically(path, csv::table(&costs).as_bytes())?;
        }
        self.json.write(&Report {
            machine: &machine,
            interrupted,
            not_measured: &not_measured,
            scenes: &costs,
            calibrations: &[],
        })?;
        if !bench.quiet {
            if interrupted {
                eprintln!("direkt: interrupted, the report shows what was measured until then");
            }
            let page = output.join("report.html");
            print(&format!("{}\n", page.display()))?;
        }
        Ok(ExitCode::SUCCESS)
    }

    /// `--calibrate`.
    fn calibrate(&self, bench: &Bench, scenes: &[Scene]) -> Result<ExitCode, Error> {
        let stop = || bench.interrupt.came();
        let (mut calibrations, mut not_measured) = (Vec::new(), Vec::new());
        for scene in scenes {
            let progress = Bar::new(1.0, bench.quiet);
            let mut show = |what: &str, part: f64| progress.show(what, part);
            let settings = self
                .calibrate
                .settings(scene, &self.strategies, &self.samplers);
            let found = calibrate(&bench.context, scene, &settings, &mut show, &stop)?;
            progress.finish();
            if found.len() < settings.estimators.len() {
                let missing = settings.estimators[found.len()..].iter();
                let source = scene.source.display();
                not_measured.extend(missing.map(|e| format!("{source}: {e}")));
            }
            if !bench.quiet {
                print_table(&found)?;
            }
            calibrations.extend(found);
        }
        if calibrations.is_empty() {
            return Ok(nothing_to_tell());
        }
        if !(not_measured.is_empty() || bench.quiet) {
            eprintln!("direkt: interrupted, the table shows the estimators that were finished");
        }
        self.json.write(&Report {
            machine: &Machine::this(&bench.context.adapter),
            interrupted: !not_measured.is_empty(),
            not_measured: &not_measured,
            scenes: &[],
            calibrations: &calibrations,
        })?;
        Ok(ExitCode::SUCCESS)
    }

    fn settings(&self, scene: &Scene) -> Settings {
        let render = &scene.render;
        let choices = Choices {
            strategies: or(&self.strategies, Strategy::value_variants()),
            light_samplings: or(&self.light_samplings, &[render.light_sampling]),
            light_selections: or(&self.light_selections, &[render.light_selection]),
            shadow_rays: or(&self.shadow_rays, &[render.shadow_rays]),
            shadow_patterns: or(&self.shadow_patterns, &[render.shadow_pattern]),
            samplers: or(&self.samplers, &[Sampler::Independent, Sampler::Sobol]),
            effects: [&[Compiled::CalledFor], self.effects.as_slice()].concat(),
        };
        Settings {
            estimators: estimator::combinations(&choices),
            budget: self.budget,
            target: self.target_error,
            reference: self.reference.clone(),
            seed: scene.render.seed,
        }
    }
}

/// Says that Ctrl-C came too early.
fn nothing_to_tell() -> ExitCode {
    eprintln!("direkt: interrupted before there was enough for a result, nothing was written");
    ExitCode::FAILURE
}

/// `everything`, or an effect by its name.
fn parse_compiled(name: &str) -> Result<Compiled, String> {
    if name == Compiled::EVERYTHING {
        return Ok(Compiled::WithEverything);
    }
    let all = Compiled::EVERYTHING;
    let effect = parse_effect(name).map_err(|message| format!("{message}, or {all}"))?;
    Ok(Compiled::With(effect))
}

/// `list`, or `default` where it is empty.
pub fn or<T: Clone>(list: &[T], default: &[T]) -> Vec<T> {
    if list.is_empty() { default } else { list }.to_vec()
}

/// The progress bar: how much of the budget is spent.
pub(super) struct Bar(ProgressBar);

impl Bar {
    pub(super) fn new(budget: f64, quiet: bool) -> Self {
        let length = (1000.0 * budget) as u64;
        Self(progress::bar(
            length,
            "{bar:24} {percent:>3} % {msg}",
            quiet,
        ))
    }

    pub(super) fn show(&self, what: &str, spent: f64) {
        self.0.set_position((1000.0 * spent) as u64);
        self.0.set_message(what.to_owned());
        self.0.tick();
    }

    pub(super) fn finish(&self) {
        self.0.finish_and_clear();
    }
}

/// Seconds of a duration such as `90s`, `1m30s`, `500ms` or `2h`.
pub(super) fn parse_duration(text: &str) -> Result<f64, String> {
    let wrong =
        || format!("`{text}` is no duration; expected such as 30s, 2m or 1m30s, above zero");
    let mut rest = text.trim();
    let mut total = 0.0;
    while !rest.is_empty() {
        let digits = rest.find(|c: char| !(c.is_ascii_digit() || c == '.'));
        let (number, tail) = rest.split_at(digits.ok_or_else(wrong)?);
        let units = tail.find(|c: char| !c.is_ascii_alphabetic());
        let (unit, tail) = tail.split_at(units.unwrap_or(tail.len()));
        let factor = match unit {
            "ms" => 1e-3,
            "s" => 1.0,
            "m" | "min" => 60.0,
            "h" => 3600.0,
            _ => return Err(wrong()),
        };
        total += factor * number.parse::<f64>().map_err(|_| wrong())?;
        rest = tail;
    }
    if total > 0.0 && total.is_finite() {
        Ok(total)
    } else {
        Err(wrong())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Effect;

    #[test]
    fn everything_is_no_effect() {
        assert_eq!(parse_compiled("everything"), Ok(Compiled::WithEverything));
        for effect in Effect::ALL.iter().filter(|e| e.can_be_forced()) {
            assert_eq!(parse_compiled(effect.name()), Ok(Compiled::With(*effect)));
        }
        for wrong in ["sobol-sampler", ""] {
            assert!(parse_compiled(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn durations_are_parsed() {
        for (text, seconds) in [
            ("30s", 30.0),
            ("2m", 120.0),
            ("1m30s", 90.0),
            ("250ms", 0.25),
        ] {
            let parsed = parse_duration(text).expect("a duration");
            assert!((parsed - seconds).abs() < 1e-12, "{text}");
        }
        for wrong in ["", "30", "s", "0s", "-1s", "1x", "1.2.3s", "infs"] {
            assert!(parse_duration(wrong).is_err(), "{wrong}");
        }
    }
}
