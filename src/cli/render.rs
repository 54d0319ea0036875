//! `direkt render`: a scene file in, images out.

mod live;
mod report;

use super::check::{CheckArgument, print_verdict};
use super::outputs::OutputArguments;
use super::passes::{Passes, Progressed, StoppedBy};
use super::settings::{AovArguments, EstimatorArguments, SceneArguments, warn};
use super::{AdapterArgument, JsonArgument};
use crate::error::Error;
use crate::gpu::{AdapterFacts, Context};
use crate::image::layers;
use crate::render::{
    AovImages, Film, Prepared, RayCounts, Session, render_aovs, render_through_losses,
};
use crate::scene::{Aovs, Scene};
use live::{Live, LiveArguments};
use report::{Report, Seconds, attributes, ledger_sentence, report, summary};
use std::process::ExitCode;
use std::time::Instant;

/// Arguments of `direkt render`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    #[command(flatten)]
    outputs: OutputArguments,
    #[command(flatten)]
    live: LiveArguments,
    #[command(flatten)]
    check: CheckArgument,
    #[command(flatten)]
    settings: SettingsArguments,
    /// No progress and no summary on stderr
    #[arg(short, long)]
    quiet: bool,
    #[command(flatten)]
    adapter: AdapterArgument,
    #[command(flatten)]
    json: JsonArgument,
}

/// Flags that override the scene's `[render]` table.
#[derive(Debug, clap::Args)]
struct SettingsArguments {
    /// Samples per pixel
    #[arg(long)]
    spp: Option<u64>,
    /// Stop after this many seconds of rendering; without --spp nothing else stops it
    #[arg(long, value_name = "SECONDS")]
    time: Option<f64>,
    /// Stop at this relative error of the image, √relMSE, such as 0.01; without --spp or --time nothing else stops it
    #[arg(long, value_name = "RELATIVE")]
    error: Option<f64>,
    /// Confidence with which the error has to be below --error [default: the scene's, 0.95 as a rule]
    #[arg(long, value_name = "PROBABILITY")]
    confidence: Option<f64>,
    #[command(flatten)]
    estimator: EstimatorArguments,
    #[command(flatten)]
    aov: AovArguments,
}

impl SettingsArguments {
    fn apply(&self, scene: &mut Scene) -> Result<(), Error> {
        let refuse = |message: String| Err(Error::Usage(message));
        if self.spp == Some(0) {
            return refuse("--spp 0: at least 1 sample per pixel is needed".to_owned());
        }
        if let Some(time) = self.time.filter(|t| !(*t > 0.0 && t.is_finite())) {
            return refuse(format!(
                "--time {time}: a positive number of seconds is needed"
            ));
        }
        if let Some(error) = self.error.filter(|e| !(*e > 0.0 && e.is_finite())) {
            return refuse(format!(
                "--error {error}: a positive number such as 0.01 is needed"
            ));
        }
        if let Some(confidence) = self.confidence.filter(|c| !(*c > 0.0 && *c < 1.0)) {
            return refuse(format!(
                "--confidence {confidence}: a probability such as 0.95 is needed, above 0 and below 1"
            ));
        }
        let render = &mut scene.render;
        if self.time.is_some() || self.error.is_some() {
            render.spp = u64::MAX;
        }
        render.time = self.time.or(render.time);
        render.error = self.error.or(render.error);
        render.confidence = self.confidence.unwrap_or(render.confidence);
        render.spp = self.spp.unwrap_or(render.spp);
        self.aov.apply(scene);
        self.estimator.apply(scene)
    }
}

impl Arguments {
    /// Refuses AOVs that no file would hold; those of the scene file are left out then.
    fn keep_aovs(&self, scene: &mut Scene) -> Result<(), Error> {
        if self.outputs.has_exr() || scene.render.aovs.is_empty() {
            return Ok(());
        }
        if !self.settings.aov.aovs.is_empty() {
            return Err(Error::Usage(
                "--aov: only an EXR holds AOVs; add an output such as -o out.exr".to_owned(),
            ));
        }
        if !self.outputs.output.is_empty() {
            eprintln!(
                "direkt: warning: {}: render.aovs: only an EXR holds AOVs, and no output is one; they are left out",
                scene.source.display()
            );
        }
        scene.render.aovs = Aovs::default();
        Ok(())
    }
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<ExitCode, Error> {
    let start = Instant::now();
    arguments.outputs.check(&arguments.scene.scene)?;
    let mut scene = arguments.scene.load()?;
    arguments.settings.apply(&mut scene)?;
    arguments.keep_aovs(&mut scene)?;
    arguments.check.before(&scene)?;
    let load_seconds = start.elapsed().as_secs_f64();
    warn(&scene);
    let settings = scene.render;
    let open = || Context::new(arguments.adapter.adapter.as_deref());
    let prepared = Prepared::new(scene, settings.strategy, settings.light_selection);
    if let Some(bias) = prepared.bias() {
        eprintln!("direkt: warning: {bias}");
    }
    let quiet = arguments.quiet || arguments.json.is_stdout();
    let mut live = Live::new(&arguments.live, &arguments.outputs, &prepared.scene)?;
    let mut passes = None;
    let work = |session: &mut Session<'_>| {
        let passes = passes.get_or_insert_with(|| {
            announce(&prepared.scene, session, quiet);
            Passes::new(&prepared.scene, quiet)
        });
        let progressed = passes.take(session, |session| live.look(session))?;
        Rendered::new(progressed, session, &prepared)
    };
    let rendered = render_through_losses(open, &prepared, work, |error, samples| {
        eprintln!(
            "direkt: warning: {error}; going on with the {samples} samples per pixel that are safe"
        );
    })?;
    if rendered.rays.camera == 0 {
        eprintln!("direkt: interrupted before the first sample, nothing was written");
        return Ok(ExitCode::FAILURE);
    }
    let seconds = Seconds {
        load: load_seconds,
        accel: prepared.accel_seconds,
        compile: rendered.compile_seconds,
        render: rendered.progressed.seconds,
        aovs: rendered.aov_seconds,
        total: start.elapsed().as_secs_f64(),
    };
    let film = &rendered.film;
    let mut report = report(&prepared, &rendered, seconds);
    let channels = layers::channels(&prepared, film, &rendered.aovs);
    let mut attributes = attributes(&report);
    attributes.extend(layers::attributes(&prepared, &rendered.aovs));
    live.end(film);
    arguments.outputs.write(film, &channels, &attributes)?;
    report.check = arguments.check.compare(&prepared.scene, film)?;
    finish(arguments, &report, quiet)
}

/// Says what is rendered where.
fn announce(scene: &Scene, session: &Session<'_>, quiet: bool) {
    if !quiet {
        let AdapterFacts { name, driver, .. } = &session.context().adapter;
        let path = scene.source.display();
        eprintln!("rendering {path} on {name} ({driver})");
    }
}

/// The image and how it came about.
struct Rendered {
    film: Film,
    rays: RayCounts,
    progressed: Progressed,
    compile_seconds: f64,
    adapter: AdapterFacts,
    aovs: AovImages,
    aov_seconds: f64,
}

impl Rendered {
    fn new(
        progressed: Progressed,
        session: &Session<'_>,
        prepared: &Prepared,
    ) -> Result<Self, Error> {
        let (film, rays) = session.snapshot()?;
        let start = Instant::now();
        let samples = film.mean_samples();
        let aovs = if samples > 0 {
            let image = (film.size, prepared.scene.render.seed);
            render_aovs(session.context(), prepared, image, samples)?
        } else {
            AovImages::default()
        };
        Ok(Self {
            film,
            rays,
            progressed,
            compile_seconds: session.compile_seconds,
            adapter: session.context().adapter.clone(),
            aovs,
            aov_seconds: start.elapsed().as_secs_f64(),
        })
    }
}

fn finish(arguments: &Arguments, report: &Report, quiet: bool) -> Result<ExitCode, Error> {
    arguments.json.write(report)?;
    if !quiet {
        eprintln!("{}", summary(&arguments.outputs.output, report));
    }
    if report.stopped_by == StoppedBy::Black {
        eprintln!("direkt: warning: no sample found any light, so that no --error can be reached");
    }
    if report.non_finite.dropped > 0 {
        eprintln!("direkt: warning: {}", ledger_sentence(&report.non_finite));
    }
    let Some(check) = &report.check else {
        return Ok(ExitCode::SUCCESS);
    };
    if !arguments.json.is_stdout() {
        print_verdict(check)?;
    }
    Ok(ExitCode::from(u8::from(!check.passed)))
}
