//! `direkt render`: a scene file in, images out.

mod live;
mod report;

use super::check::{CheckArgument, print_verdict};
use super::interrupt::Interrupt;
use super::outputs::OutputArguments;
use super::passes::{Passes, Progressed};
use super::plan::{Failures, Plan};
use super::settings::{AovArguments, EstimatorArguments, SceneArguments, warn};
use super::{AdapterArgument, JsonArgument};
use direkt::error::{Error, GpuError, number};
use direkt::low_level::console::say;
use direkt::low_level::gpu::{AdapterFacts, Context};
use direkt::low_level::image::layers;
use direkt::low_level::prepare::Prepared;
use direkt::low_level::render::{
    AovImages, Failure, Film, Pixel, RayCounts, Session, StoppedBy, render_aovs,
    render_keeping_image,
};
use direkt::scene::{Aovs, ErrorMetric, Scene};
use live::{Live, LiveArguments};
use report::{Seconds, command_line, ledger_sentence, report, summary};
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
    /// Stop at this error of the image, such as 0.01: √NMSE unless --error-metric says otherwise;
    /// without --spp or --time nothing else stops it
    #[arg(long, value_name = "RELATIVE")]
    error: Option<f64>,
    /// What --error is measured in [default: the scene's, nmse as a rule]
    #[arg(long, value_name = "METRIC", value_enum)]
    error_metric: Option<ErrorMetric>,
    /// Confidence with which the error has to be below --error [default: the scene's, 0.95 as a
    /// rule]
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
                "--time {}: a positive number of seconds is needed",
                number(time)
            ));
        }
        if let Some(error) = self.error.filter(|e| !(*e > 0.0 && e.is_finite())) {
            return refuse(format!(
                "--error {}: a positive number such as 0.01 is needed",
                number(error)
            ));
        }
        if let Some(confidence) = self.confidence.filter(|c| !(*c > 0.0 && *c < 1.0)) {
            return refuse(format!(
                "--confidence {}: a probability such as 0.95 is needed, above 0 and below 1",
                number(confidence)
            ));
        }
        let render = &mut scene.render;
        if self.time.is_some() || self.error.is_some() {
            render.stop.spp = u64::MAX;
        }
        render.stop.time = self.time.or(render.stop.time);
        render.stop.error = self.error.or(render.stop.error);
        render.stop.error_metric = self.error_metric.unwrap_or(render.stop.error_metric);
        render.stop.confidence = self.confidence.unwrap_or(render.stop.confidence);
        render.stop.spp = self.spp.unwrap_or(render.stop.spp);
        self.aov.apply(scene);
        self.estimator.apply(scene)
    }
}

impl Arguments {
    /// What is going to be written.
    fn plan(&self) -> Result<Plan, Error> {
        let mut plan = Plan::default();
        self.outputs.plan(&mut plan)?;
        self.json.plan(&mut plan)?;
        Ok(plan)
    }

    /// Refuses AOVs that no file would hold; those of the scene file are left out then.
    fn keep_aovs(&self, scene: &mut Scene) -> Result<(), Error> {
        if self.outputs.has_layers() || scene.render.aovs.is_empty() {
            return Ok(());
        }
        if !self.settings.aov.aovs.is_empty() {
            return Err(Error::Usage(
                "--aov: only an EXR holds AOVs; add an output such as -o out.exr".to_owned(),
            ));
        }
        if !self.outputs.output.is_empty() {
            let reason = if self.outputs.plain {
                "a plain EXR holds no AOVs"
            } else {
                "only an EXR holds AOVs, and no output is one"
            };
            let source = scene.source.display();
            say(format_args!(
                "direkt: warning: {source}: render.aovs: {reason}; they are left out"
            ));
        }
        scene.render.aovs = Aovs::default();
        Ok(())
    }

    /// Reads the scene and refuses what could not be rendered or written in the end.
    fn load(&self, plan: &mut Plan, device: Option<&Context>) -> Result<Scene, Error> {
        let mut scene = self.scene.load(plan, device)?;
        self.settings.apply(&mut scene)?;
        self.keep_aovs(&mut scene)?;
        self.check.before(&scene)?;
        warn(&scene);
        Ok(scene)
    }
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<ExitCode, Error> {
    let start = Instant::now();
    let interrupt = Interrupt::listen();
    let mut plan = arguments.plan()?;
    let device = arguments.adapter.open();
    let scene = arguments.load(&mut plan, device.as_ref().ok())?;
    let load_seconds = start.elapsed().as_secs_f64();
    let prepared = Prepared::of(scene);
    if let Some(bias) = prepared.bias() {
        say(format_args!("direkt: warning: {bias}"));
    }
    let quiet = arguments.quiet || arguments.json.is_stdout();
    let mut live = Live::new(&arguments.live, &arguments.outputs, &prepared.data.scene)?;
    let mut failures = Failures::default();
    let rendered = render(
        arguments,
        (&prepared, device?),
        interrupt,
        quiet,
        &mut live,
        &mut failures,
    )?;
    if rendered.rays.camera == 0 {
        say("direkt: interrupted before the first sample, nothing was written");
        return Ok(ExitCode::FAILURE);
    }
    let seconds = Seconds {
        load: load_seconds,
        accel: prepared.data.accel_seconds,
        compile: rendered.device.compile_seconds,
        render: rendered.progressed.seconds,
        aovs: rendered.aov_seconds,
        total: start.elapsed().as_secs_f64(),
    };
    live.end(&rendered.film);
    finish(arguments, &plan, &prepared, (rendered, seconds), failures)
}

/// Takes the passes. Where the driver fails after the first ones, that is a failure of its own, and
/// the image so far is returned.
fn render(
    arguments: &Arguments,
    (prepared, device): (&Prepared, Context),
    interrupt: Interrupt,
    quiet: bool,
    live: &mut Live<'_>,
    failures: &mut Failures,
) -> Result<Rendered, Error> {
    let mut first = Some(device);
    let open = || first.take().map_or_else(|| arguments.adapter.open(), Ok);
    let mut begun = None;
    let work = |session: &mut Session<'_>| {
        let (passes, device) = begun.get_or_insert_with(|| {
            announce(&prepared.data.scene, session, quiet);
            let passes = Passes::new(&prepared.data.scene, interrupt.clone(), quiet);
            (passes, Device::of(session))
        });
        *device = Device::of(session);
        let progressed = passes.take(session, |session| Ok(live.look(session)?))?;
        Rendered::new(progressed, session, prepared, failures)
    };
    let lost = |error: &GpuError, samples| {
        say(format_args!(
            "direkt: warning: {error}; going on with the {samples} samples per pixel that are safe"
        ));
    };
    let failure = match render_keeping_image(open, prepared, work, lost) {
        Ok(rendered) => return Ok(rendered),
        Err(failure) => failure,
    };
    let Failure { error, image } = failure;
    let (Some(image), Some((passes, device))) = (image, begun) else {
        return Err(error);
    };
    failures.note(Err(error));
    let (film, rays) = *image;
    say(format_args!(
        "direkt: the image of the {} samples per pixel that are safe is written",
        film.mean_samples()
    ));
    Ok(Rendered {
        film,
        rays,
        progressed: passes.end(StoppedBy::Failure),
        device,
        aovs: AovImages::default(),
        aov_seconds: 0.0,
    })
}

/// Says what is rendered where.
fn announce(scene: &Scene, session: &Session<'_>, quiet: bool) {
    if !quiet {
        let AdapterFacts { name, driver, .. } = &session.context().adapter;
        let path = scene.source.display();
        say(format_args!("rendering {path} on {name} ({driver})"));
    }
}

/// What renders.
struct Device {
    adapter: AdapterFacts,
    compile_seconds: f64,
}

impl Device {
    fn of(session: &Session<'_>) -> Self {
        Self {
            adapter: session.context().adapter.clone(),
            compile_seconds: session.compile_seconds,
        }
    }
}

/// The image and how it came about.
struct Rendered {
    film: Film,
    rays: RayCounts,
    progressed: Progressed,
    device: Device,
    aovs: AovImages,
    aov_seconds: f64,
}

impl Rendered {
    /// The image of `session` with its AOVs; where these fail, but not by the loss of the device,
    /// without them.
    fn new(
        progressed: Progressed,
        session: &Session<'_>,
        prepared: &Prepared,
        failures: &mut Failures,
    ) -> Result<Self, Error> {
        let (film, rays) = session.snapshot()?;
        let start = Instant::now();
        let samples = film.mean_samples();
        let image = (film.size, prepared.settings.seed);
        let aovs = render_aovs(session.context(), prepared, image, samples);
        let aovs = match aovs {
            Err(error) if !matches!(error, GpuError::Lost { .. }) => {
                failures.note(Err(error.into()));
                say("direkt: the image is written without AOVs");
                AovImages::default()
            }
            aovs => aovs?,
        };
        Ok(Self {
            film,
            rays,
            progressed,
            device: Device::of(session),
            aovs,
            aov_seconds: start.elapsed().as_secs_f64(),
        })
    }
}

/// What the 32-bit numbers of image files cannot hold of `film`.
fn beyond_file(film: &Film) -> Option<String> {
    let largest = |pixel: &Pixel| pixel.mean.into_iter().fold(0.0, f64::max);
    let values = film.pixels.iter().map(largest);
    let beyond: Vec<f64> = values.filter(|&x| x > f64::from(f32::MAX)).collect();
    let most = beyond.iter().copied().reduce(f64::max)?;
    Some(format!(
        "{} of {} pixels are brighter than 3.4e38, the largest number of an image file, which stands there; the brightest is {most:e}",
        beyond.len(),
        film.pixels.len()
    ))
}

/// Writes all that is asked for, and reports.
fn finish(
    arguments: &Arguments,
    plan: &Plan,
    prepared: &Prepared,
    (rendered, seconds): (Rendered, Seconds),
    mut failures: Failures,
) -> Result<ExitCode, Error> {
    let film = &rendered.film;
    let render_seconds = format!("{:.3}", seconds.render);
    let mut report = report(prepared, &rendered, seconds);
    let channels = layers::channels(prepared, film, &rendered.aovs);
    let mut attributes = layers::render_attributes(prepared, film, &rendered.device.adapter);
    attributes.extend([("command", command_line()), ("seconds", render_seconds)]);
    attributes.extend(layers::attributes(prepared, &rendered.aovs));
    let mut written = Vec::new();
    for (path, bytes) in arguments.outputs.encode(film, &channels, &attributes) {
        if failures.note(bytes.and_then(|bytes| plan.write(path, &bytes))) {
            written.push(path);
        }
    }
    let checked = arguments.check.compare(&prepared.data.scene, film);
    report.check = checked.as_ref().ok().cloned().flatten();
    failures.note(arguments.json.write(plan, &report));
    if !(arguments.quiet || arguments.json.is_stdout()) {
        say(summary(&written, &report));
    }
    if report.stopped_by == StoppedBy::Black {
        say("direkt: warning: no sample found any light, so that no --error can be reached");
    }
    if let Some(warning) = beyond_file(film) {
        say(format_args!("direkt: warning: {warning}"));
    }
    if report.non_finite.dropped > 0 {
        let sentence = ledger_sentence(&report.non_finite);
        say(format_args!("direkt: warning: {sentence}"));
    }
    let Some(check) = checked? else {
        return Ok(failures.exit_code(ExitCode::SUCCESS));
    };
    if !arguments.json.is_stdout() {
        print_verdict(&check);
    }
    Ok(failures.exit_code(ExitCode::from(u8::from(!check.passed))))
}
