//! `direkt cost`: what accuracy costs in time, for every estimator.

mod text;

use super::calibrate::{CalibrateArguments, print_table};
use super::duration::parse_duration;
use super::explain::parse_effect;
use super::interrupt::Interrupt;
use super::plan::{Failures, Plan, usable};
use super::progress::Bar;
use super::settings::{ImageArguments, SceneListArguments};
use super::{AdapterArgument, JsonArgument};
use clap::ValueEnum;
use direkt::error::{Error, number};
use direkt::low_level::console::{print, say};
use direkt::low_level::gpu::Context;
use direkt::scene::{
    LightSampling, LightSelection, Sampler, Scene, ShadowPattern, ShadowRays, Strategy,
};
use direkt_instruments::cost::calibrate::{self, Calibration};
use direkt_instruments::cost::estimator::{self, Choices};
use direkt_instruments::cost::{Compiled, SceneCost, Settings, measure};
use direkt_instruments::report::{self, csv, machine::Machine};
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
    /// How strategies that do not say so themselves choose a point of a light [default: the
    /// scene's]
    #[arg(long, value_name = "LIST", value_enum, value_delimiter = ',')]
    light_samplings: Vec<LightSampling>,
    /// Light selections to compare [default: the scene's]
    #[arg(long, value_name = "LIST", value_enum, value_delimiter = ',')]
    light_selections: Vec<LightSelection>,
    /// Numbers of shadow rays per camera ray to compare, each `auto` or 1 to 1024 [default: the scene's]
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    shadow_rays: Vec<ShadowRays>,
    /// Patterns of their points to compare [default: the scene's]
    #[arg(long, value_name = "LIST", value_enum, value_delimiter = ',')]
    shadow_patterns: Vec<ShadowPattern>,
    /// Samplers to compare [default: independent,sobol; with --calibrate all]
    #[arg(long, value_name = "LIST", value_enum, value_delimiter = ',')]
    samplers: Vec<Sampler>,
    /// Unneeded effects to compile in, each beside every estimator as the scene calls for it,
    /// or `everything` at once: they give the same image, which is checked bit for bit, and what
    /// they cost is time. `direkt explain` names the effects
    #[arg(long, value_name = "LIST", value_parser = parse_compiled, value_delimiter = ',', conflicts_with = "calibrate")]
    effects: Vec<Compiled>,
    /// Relative mean squared error whose price is told
    #[arg(long, value_name = "RELMSE", default_value_t = 1e-3)]
    target_error: f64,
    /// Image to compare with, an EXR of the same size; otherwise the scene's exact values or a long
    /// run of direkt's own
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
    let interrupt = Interrupt::listen();
    let mut plan = arguments.plan()?;
    let device = arguments.adapter.open();
    let mut scenes = arguments.scenes.load(&mut plan, device.as_ref().ok())?;
    for scene in &mut scenes {
        arguments.image.apply(scene)?;
    }
    let bench = Bench {
        context: device?,
        interrupt,
        quiet: arguments.quiet || arguments.json.is_stdout(),
        plan,
    };
    bench.interrupt.defer();
    match arguments.folder() {
        Some(folder) => arguments.measure(&bench, &scenes, folder),
        None => arguments.calibrate(&bench, &scenes),
    }
}

/// What every measurement needs.
struct Bench {
    context: Context,
    interrupt: Interrupt,
    /// Nothing but results is printed.
    quiet: bool,
    plan: Plan,
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
        say(format_args!("measuring {source} on {name} ({driver})"));
    }
    let progress = Bar::new(settings.budget, bench.quiet);
    let mut show = |what: &str, spent: f64| progress.show(&format!("{source}: {what}"), spent);
    let stop = || bench.interrupt.came();
    let cost = measure(&bench.context, scene, settings, &mut show, &stop)?;
    progress.finish();
    if let Some(cost) = cost.as_ref().filter(|_| !bench.quiet) {
        print(&text::summary(cost));
    }
    Ok(cost)
}

/// What is found on `scene`; estimators that are missing were not finished when Ctrl-C came.
fn calibrate_scene(
    bench: &Bench,
    scene: &Scene,
    settings: &calibrate::Settings,
) -> Result<Vec<Calibration>, Error> {
    let progress = Bar::new(1.0, bench.quiet);
    let mut show = |what: &str, part: f64| progress.show(what, part);
    let stop = || bench.interrupt.came();
    let found = calibrate::calibrate(&bench.context, scene, settings, &mut show, &stop)?;
    progress.finish();
    if !bench.quiet {
        print_table(&found);
    }
    Ok(found)
}

impl Arguments {
    /// Refuses what cannot be, before anything is rendered.
    fn check(&self) -> Result<(), Error> {
        let target = self.target_error;
        if !(target > 0.0 && target.is_finite()) {
            return Err(Error::Usage(format!(
                "--target-error {}: a positive number such as 0.001 is needed",
                number(target)
            )));
        }
        if self.reference.is_some() && self.scenes.scenes.len() > 1 {
            return Err(Error::Usage(
                "--reference is for one scene; name one".to_owned(),
            ));
        }
        Ok(())
    }

    /// The report's folder, where one is to be written.
    fn folder(&self) -> Option<&PathBuf> {
        let output = self.output.as_ref();
        output.filter(|_| !self.calibrate.calibrate)
    }

    /// What is going to be written.
    fn plan(&self) -> Result<Plan, Error> {
        let mut plan = Plan::default();
        if let Some(folder) = self.folder() {
            let scenes: Vec<&Path> = self.scenes.scenes.iter().map(PathBuf::as_path).collect();
            plan.folder("-o", folder, &report::file_names(&scenes))?;
        }
        if let Some(path) = self.csv.as_ref().filter(|_| !self.calibrate.calibrate) {
            plan.file("--csv", path)?;
        }
        self.json.plan(&mut plan)?;
        plan.spare(&self.reference, "the reference")?;
        Ok(plan)
    }

    /// Measures the scenes and writes the report into `folder`. Where a scene cannot be measured,
    /// what was measured before is written first.
    fn measure(&self, bench: &Bench, scenes: &[Scene], folder: &Path) -> Result<ExitCode, Error> {
        let (mut costs, mut not_measured, mut failed) = (Vec::new(), Vec::new(), Ok(()));
        for scene in scenes {
            let measured = match &failed {
                Ok(()) => measure_scene(bench, scene, &self.settings(scene)),
                Err(_) => Ok(None),
            };
            match measured {
                Ok(Some(cost)) => costs.push(cost),
                Ok(None) => not_measured.push(scene.source.display().to_string()),
                Err(error) => {
                    not_measured.push(scene.source.display().to_string());
                    failed = Err(error);
                }
            }
        }
        if costs.is_empty() {
            return failed.map(|()| nothing_to_tell());
        }
        let failures = self.write(bench, &costs, &not_measured, folder);
        failed?;
        Ok(failures.exit_code(ExitCode::SUCCESS))
    }

    /// Writes all that is asked for.
    fn write(
        &self,
        bench: &Bench,
        costs: &[SceneCost],
        not_measured: &[String],
        folder: &Path,
    ) -> Failures {
        let machine = Machine::this(&bench.context.adapter);
        let interrupted = !not_measured.is_empty() || costs.iter().any(|c| c.interrupted);
        let mut failures = Failures::default();
        let folder = usable(folder.to_path_buf(), &mut failures);
        for (name, bytes) in report::files(costs, not_measured, &machine) {
            let path = folder.join(name);
            failures.note(bytes.and_then(|bytes| bench.plan.write(&path, &bytes)));
        }
        if let Some(path) = &self.csv {
            failures.note(bench.plan.write(path, csv::table(costs).as_bytes()));
        }
        let report = Report {
            machine: &machine,
            interrupted,
            not_measured,
            scenes: costs,
            calibrations: &[],
        };
        failures.note(self.json.write(&bench.plan, &report));
        if !bench.quiet {
            if interrupted {
                say("direkt: interrupted, the report shows what was measured until then");
            }
            let page = folder.join("report.html");
            print(&format!("{}\n", page.display()));
        }
        failures
    }

    /// `--calibrate`. Where a scene cannot be rendered, what was found before is written first.
    fn calibrate(&self, bench: &Bench, scenes: &[Scene]) -> Result<ExitCode, Error> {
        let (mut calibrations, mut not_measured, mut failed) = (Vec::new(), Vec::new(), Ok(()));
        for scene in scenes {
            let settings = self
                .calibrate
                .settings(scene, &self.strategies, &self.samplers);
            let found = match &failed {
                Ok(()) => calibrate_scene(bench, scene, &settings),
                Err(_) => Ok(Vec::new()),
            };
            let found = found.unwrap_or_else(|error| {
                failed = Err(error);
                Vec::new()
            });
            let finished = found.len() / settings.samples.len();
            if finished < settings.estimators.len() {
                let missing = settings.estimators[finished..].iter();
                let source = scene.source.display();
                not_measured.extend(missing.map(|e| format!("{source}: {e}")));
            }
            calibrations.extend(found);
        }
        if calibrations.is_empty() {
            return failed.map(|()| nothing_to_tell());
        }
        if !(not_measured.is_empty() || bench.quiet) {
            say("direkt: interrupted, the table shows the estimators that were finished");
        }
        let mut failures = Failures::default();
        let report = Report {
            machine: &Machine::this(&bench.context.adapter),
            interrupted: !not_measured.is_empty(),
            not_measured: &not_measured,
            scenes: &[],
            calibrations: &calibrations,
        };
        failures.note(self.json.write(&bench.plan, &report));
        failed?;
        Ok(failures.exit_code(ExitCode::SUCCESS))
    }

    fn settings(&self, scene: &Scene) -> Settings {
        let render = &scene.render;
        let choices = Choices {
            base: render.estimator,
            strategies: or(&self.strategies, Strategy::value_variants()),
            light_samplings: or(&self.light_samplings, &[render.estimator.light_sampling]),
            light_selections: or(&self.light_selections, &[render.estimator.light_selection]),
            shadow_rays: or(&self.shadow_rays, &[render.estimator.shadow_rays]),
            shadow_patterns: or(&self.shadow_patterns, &[render.estimator.shadow_pattern]),
            samplers: or(&self.samplers, &[Sampler::Independent, Sampler::Sobol]),
            adaptive: vec![render.estimator.adaptive],
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
    say("direkt: interrupted before there was enough for a result, nothing was written");
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

#[cfg(test)]
mod tests {
    use super::*;
    use direkt::low_level::effects::Effect;

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
}
