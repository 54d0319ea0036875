//! `direkt explain`: which effects a scene calls for, and why; what they take, and what others
//! would cost.

mod text;

use super::cost::or;
use super::duration::parse_duration;
use super::interrupt::Interrupt;
use super::plan::{Failures, Plan, usable};
use super::progress::Bar;
use super::settings::{AovArguments, AssetArguments, EstimatorArguments};
use super::{AdapterArgument, JsonArgument};
use direkt::error::Error;
use direkt::low_level::console::{print, say};
use direkt::low_level::effects::Effect;
use direkt::low_level::gpu::kernel::DIRECT;
use direkt::low_level::gpu::shader::KernelConstants;
use direkt::low_level::gpu::{AdapterFacts, SceneKernel};
use direkt::low_level::image::extension;
use direkt::low_level::prepare::Prepared;
use direkt::scene::load::schema;
use direkt_instruments::drawing::{raster, svg::Svg};
use direkt_instruments::explain::aov::{self, AovCost};
use direkt_instruments::explain::memory::{self, Memory};
use direkt_instruments::explain::plot;
use direkt_instruments::explain::price::{self, Prices};
use direkt_instruments::explain::sample::{self, RandomNumbers, Rays};
use direkt_instruments::explain::shader::ShaderSize;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Arguments of `direkt explain`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// The scene: .toml, .gltf or .glb
    #[arg(required_unless_present = "schema")]
    scene: Option<PathBuf>,
    /// Print the JSON Schema of scene files instead, for editors that complete them
    #[arg(long, conflicts_with_all = ["scene", "wgsl", "measure"])]
    schema: bool,
    /// Print the linked WGSL of the scene's kernel instead
    #[arg(long, conflicts_with = "measure")]
    wgsl: bool,
    /// Measure what each effect would cost that the scene does not call for, and all of them
    /// together
    #[arg(long)]
    measure: bool,
    /// Time of measuring, compiling included, such as 30s, 2m or 1m30s; three rounds are made at
    /// least
    #[arg(long, value_name = "DURATION", default_value = "60s", value_parser = parse_duration, requires = "measure")]
    budget: f64,
    /// Effects whose cost is measured [default: all that can be compiled in without need]
    #[arg(long, value_name = "LIST", value_parser = parse_effect, value_delimiter = ',', requires = "measure")]
    effects: Vec<Effect>,
    /// Plot of what was measured: .svg or .png, or a folder for both
    #[arg(short, long = "output", value_name = "FILE", requires = "measure")]
    output: Option<PathBuf>,
    /// No progress on stderr
    #[arg(short, long)]
    quiet: bool,
    #[command(flatten)]
    assets: AssetArguments,
    #[command(flatten)]
    estimator: EstimatorArguments,
    #[command(flatten)]
    aov: AovArguments,
    #[command(flatten)]
    adapter: AdapterArgument,
    #[command(flatten)]
    json: JsonArgument,
}

#[derive(Debug, Serialize)]
struct Report {
    scene: String,
    called_for: Vec<CalledFor>,
    left_out: Vec<&'static str>,
    #[serde(flatten)]
    shader: ShaderSize,
    memory: Vec<Memory>,
    memory_bytes: u64,
    /// At most, per sample.
    rays: Rays,
    random_numbers: Vec<RandomNumbers>,
    random_numbers_per_sample: u32,
    primitives: usize,
    bvh_nodes: usize,
    bvh_depth: usize,
    lights: usize,
    aovs: Vec<AovCost>,
    environment: Option<EnvironmentSampling>,
    mis_compensation_unused: Option<String>,
    biased: Option<String>,
    warnings: Vec<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    adapter: Option<AdapterFacts>,
    #[serde(skip_serializing_if = "Option::is_none")]
    measured: Option<Prices>,
}

/// How directions towards the environment map are chosen.
#[derive(Debug, Serialize)]
struct EnvironmentSampling {
    columns: u32,
    rows: u32,
    compensated: bool,
}

#[derive(Debug, Serialize)]
struct CalledFor {
    name: &'static str,
    reason: String,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<ExitCode, Error> {
    let Some(path) = arguments.scene.as_ref().filter(|_| !arguments.schema) else {
        print(&schema());
        return Ok(ExitCode::SUCCESS);
    };
    let mut plan = arguments.plan()?;
    let mut scene = arguments.assets.load(path, &mut plan, None)?;
    arguments.aov.apply(&mut scene);
    arguments.estimator.apply(&mut scene)?;
    let mut prepared = Prepared::of(scene);
    let wgsl = SceneKernel::link(&DIRECT, &prepared.effects, &KernelConstants::of(&prepared))?;
    if arguments.wgsl {
        print(&wgsl);
        return Ok(ExitCode::SUCCESS);
    }
    let mut report = report(path, &prepared, &wgsl)?;
    let mut failures = Failures::default();
    if arguments.measure {
        let found = arguments.measure(&mut prepared, &mut report)?;
        match (found, &arguments.output) {
            (None, _) => say("direkt: interrupted before one round was finished"),
            (Some(prices), path) => {
                if let Some(path) = path {
                    draw(&plan, path, plot::of(&report.scene, &prices), &mut failures);
                }
                report.measured = Some(prices);
            }
        }
    }
    failures.note(arguments.json.write(&plan, &report));
    if !arguments.json.is_stdout() {
        print(&text::of(&report));
    }
    Ok(failures.exit_code(ExitCode::SUCCESS))
}

impl Arguments {
    /// What is going to be written.
    fn plan(&self) -> Result<Plan, Error> {
        let mut plan = Plan::default();
        match &self.output {
            None => {}
            Some(path) if is_folder(path) => plan.folder("-o", path, &PLOTS.map(str::to_owned))?,
            Some(path) if matches!(extension(path).as_str(), "svg" | "png") => {
                plan.file("-o", path)?;
            }
            Some(path) => {
                return Err(Error::Usage(format!(
                    "{}: a plot ends in .svg or .png; name such a file or a folder",
                    path.display()
                )));
            }
        }
        self.json.plan(&mut plan)?;
        Ok(plan)
    }

    /// Measures; `None` where Ctrl-C came too early.
    fn measure(
        &self,
        prepared: &mut Prepared,
        report: &mut Report,
    ) -> Result<Option<Prices>, Error> {
        let context = self.adapter.open()?;
        let interrupt = Interrupt::listen();
        interrupt.defer();
        let progress = Bar::new(self.budget, self.quiet);
        let mut show = |what: &str, spent: f64| progress.show(what, spent);
        let stop = || interrupt.came();
        let effects = or(&self.effects, Effect::ALL);
        let wanted = (effects.as_slice(), self.budget);
        let found = price::measure(&context, prepared, wanted, &mut show, &stop)?;
        progress.finish();
        report.adapter = Some(context.adapter.clone());
        Ok(found)
    }
}

/// What the plots in a folder are called.
const PLOTS: [&str; 2] = ["explain.svg", "explain.png"];

/// Whether `-o` names a folder, there or not yet.
fn is_folder(path: &Path) -> bool {
    path.is_dir() || extension(path).is_empty()
}

/// An effect by its name.
pub(super) fn parse_effect(name: &str) -> Result<Effect, String> {
    let mut all = Effect::ALL.iter().copied().filter(|e| e.can_be_forced());
    let names: Vec<_> = all.clone().map(Effect::name).collect();
    all.find(|e| e.name() == name).ok_or_else(|| {
        let names = names.join(", ");
        format!("no effect of this name can be compiled in without need; expected {names}")
    })
}

/// Writes the plot to a file, or both kinds of file into a folder.
fn draw(plan: &Plan, path: &Path, plot: Svg, failures: &mut Failures) {
    let files = if is_folder(path) {
        let folder = usable(path.to_path_buf(), failures);
        PLOTS.map(|name| folder.join(name)).to_vec()
    } else {
        vec![path.to_path_buf()]
    };
    for file in files {
        let bytes = match extension(&file).as_str() {
            "png" => raster::png(&plot),
            _ => Ok(plot.file().into_bytes()),
        };
        failures.note(bytes.and_then(|bytes| plan.write(&file, &bytes)));
    }
}

fn report(path: &Path, prepared: &Prepared, wgsl: &str) -> Result<Report, Error> {
    let called_for = prepared.effects.iter().map(|(effect, reason)| CalledFor {
        name: effect.name(),
        reason: reason.to_owned(),
    });
    let left_out = Effect::ALL
        .iter()
        .filter(|e| !prepared.effects.contains(**e));
    let memory = memory::of(prepared, prepared.film);
    let random_numbers = sample::random_numbers(prepared);
    Ok(Report {
        scene: path.display().to_string(),
        called_for: called_for.collect(),
        left_out: left_out.map(|e| e.name()).collect(),
        shader: ShaderSize::of(wgsl)?,
        memory_bytes: memory::total(&memory),
        memory,
        rays: sample::most_rays(prepared),
        random_numbers_per_sample: random_numbers.iter().map(RandomNumbers::count).sum(),
        random_numbers,
        primitives: prepared.data.primitives.len(),
        bvh_nodes: prepared.data.bvh.nodes.len(),
        bvh_depth: prepared.data.bvh.depth,
        lights: prepared.emitters.lights.len(),
        aovs: aov::costs(prepared.settings.aovs),
        environment: environment_sampling(prepared),
        mis_compensation_unused: mis_compensation_unused(prepared),
        biased: prepared.bias(),
        warnings: prepared.data.scene.warnings.clone(),
        adapter: None,
        measured: None,
    })
}

fn environment_sampling(prepared: &Prepared) -> Option<EnvironmentSampling> {
    let grid = prepared.emitters.environment.as_ref()?;
    let sampled = prepared.settings.estimator.strategy.samples_lights();
    sampled.then_some(EnvironmentSampling {
        columns: grid.size[0],
        rows: grid.size[1],
        compensated: grid.compensated,
    })
}

/// Why `mis_compensation`, which is asked for, changes nothing.
fn mis_compensation_unused(prepared: &Prepared) -> Option<String> {
    let settings = prepared.settings;
    if !settings.estimator.mis_compensation {
        return None;
    }
    match &prepared.emitters.environment {
        None => Some("the scene has no environment map that emits".to_owned()),
        Some(_) if !settings.estimator.strategy.is_mis() => Some(format!(
            "strategy {} does not combine light and BSDF sampling",
            settings.estimator.strategy
        )),
        Some(grid) => (!grid.compensated).then(|| "the environment map is constant".to_owned()),
    }
}
