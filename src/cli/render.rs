//! `direkt render`: a scene file in, images out.

use super::check::{CheckArgument, print_verdict};
use super::outputs::OutputArguments;
use super::progress::Progress;
use super::settings::{EstimatorArguments, SceneArguments};
use super::{AdapterArgument, JsonArgument};
use crate::error::Error;
use crate::gpu::{AdapterFacts, Context};
use crate::render::{Check, Film, ImageError, Ledger, Prepared, RayCounts, Session, StopReason};
use crate::scene::{LightSelection, Sampler, Scene, ShadowPattern, Strategy};
use serde::Serialize;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Arguments of `direkt render`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    #[command(flatten)]
    outputs: OutputArguments,
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
    #[command(flatten)]
    estimator: EstimatorArguments,
}

impl SettingsArguments {
    fn apply(&self, scene: &mut Scene) -> Result<(), Error> {
        let render = &mut scene.render;
        if self.time.is_some() {
            render.time = self.time;
            render.spp = u64::MAX;
        }
        render.spp = self.spp.unwrap_or(render.spp);
        if render.spp == 0 {
            return Err(Error::Usage(
                "--spp 0: at least 1 sample per pixel is needed".into(),
            ));
        }
        if render.time.is_some_and(|t| !(t > 0.0 && t.is_finite())) {
            return Err(Error::Usage(format!(
                "--time {}: a positive number of seconds is needed",
                render.time.unwrap_or_default()
            )));
        }
        self.estimator.apply(scene)
    }
}

/// What `--json` writes.
#[derive(Debug, Serialize)]
struct Report {
    direkt: &'static str,
    scene: String,
    adapter: AdapterFacts,
    width: u32,
    height: u32,
    spp: u64,
    passes: u64,
    interrupted: bool,
    seconds: Seconds,
    rays: RayCounts,
    samples_per_second: f64,
    rays_per_second: f64,
    error: Option<ImageError>,
    non_finite: Ledger,
    effects: Vec<EffectReport>,
    strategy: Strategy,
    light_selection: LightSelection,
    shadow_rays: u32,
    shadow_pattern: ShadowPattern,
    biased: Option<String>,
    sampler: Sampler,
    seed: u32,
    image_mean: [f64; 3],
    image_mean_standard_error: Option<[f64; 3]>,
    check: Option<Check>,
    warnings: Vec<String>,
}

#[derive(Debug, Serialize)]
struct Seconds {
    load: f64,
    accel: f64,
    compile: f64,
    render: f64,
    total: f64,
}

#[derive(Debug, Serialize)]
struct EffectReport {
    name: &'static str,
    reason: String,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<ExitCode, Error> {
    let start = Instant::now();
    arguments.outputs.check(&arguments.scene.scene)?;
    let mut scene = arguments.scene.load()?;
    arguments.settings.apply(&mut scene)?;
    arguments.check.before(&scene)?;
    let load_seconds = start.elapsed().as_secs_f64();
    arguments.scene.warn(&scene);
    let settings = scene.render;
    let film_size = scene.film;
    let context = Context::new(arguments.adapter.adapter.as_deref())?;
    let prepared = Prepared::new(scene, settings.strategy, settings.light_selection);
    if let Some(bias) = prepared.bias() {
        eprintln!("direkt: warning: {bias}");
    }
    let mut session = Session::new(&context, &prepared, film_size, settings.seed)?;

    let quiet = arguments.quiet || arguments.json.is_stdout();
    if !quiet {
        let (name, driver) = (&context.adapter.name, &context.adapter.driver);
        let path = arguments.scene.scene.display();
        eprintln!("rendering {path} on {name} ({driver})");
    }
    let progressed = take_passes(&mut session, &prepared.scene, quiet)?;
    let (film, rays) = session.snapshot()?;
    if rays.camera == 0 {
        eprintln!("direkt: interrupted before the first sample, nothing was written");
        return Ok(ExitCode::FAILURE);
    }
    let seconds = Seconds {
        load: load_seconds,
        accel: prepared.accel_seconds,
        compile: session.compile_seconds,
        render: progressed.seconds,
        total: start.elapsed().as_secs_f64(),
    };
    let mut report = report(&prepared, &context, &film, rays, &progressed, seconds);
    arguments.outputs.write(&film, &attributes(&report))?;
    report.check = arguments.check.compare(&prepared.scene, &film)?;
    finish(arguments, &report, quiet)
}

/// How the passes went.
struct Progressed {
    passes: u64,
    seconds: f64,
    interrupted: bool,
}

/// Takes passes until the samples, the time or the user's patience run out.
fn take_passes(session: &mut Session<'_>, scene: &Scene, quiet: bool) -> Result<Progressed, Error> {
    let settings = scene.render;
    let interrupted = stop_on_interrupt();
    let time = settings.time.map(Duration::from_secs_f64);
    let mut progress = Progress::new(settings.spp, time, quiet);
    let start = Instant::now();
    let mut passes = 0;
    while session.samples() < settings.spp {
        let samples = session.pass_samples(settings.spp - session.samples());
        // The first pass is finished whatever the time, so that there is an image.
        let first = session.samples() == 0;
        let out_of_time = || !first && time.is_some_and(|t| start.elapsed() >= t);
        let stop = || interrupted.load(Ordering::Relaxed) || out_of_time();
        if session.pass(samples, stop)? == StopReason::Interrupted {
            break;
        }
        passes += 1;
        progress.update(session, passes, scene.film.pixels())?;
    }
    progress.finish();
    Ok(Progressed {
        passes,
        seconds: start.elapsed().as_secs_f64(),
        interrupted: interrupted.load(Ordering::Relaxed),
    })
}

fn report(
    prepared: &Prepared,
    context: &Context,
    film: &Film,
    rays: RayCounts,
    progressed: &Progressed,
    seconds: Seconds,
) -> Report {
    let settings = prepared.scene.render;
    Report {
        direkt: env!("CARGO_PKG_VERSION"),
        scene: prepared.scene.source.display().to_string(),
        adapter: context.adapter.clone(),
        width: film.size.width,
        height: film.size.height,
        spp: film.sample_range().1,
        passes: progressed.passes,
        interrupted: progressed.interrupted,
        samples_per_second: rays.camera as f64 / seconds.render,
        rays_per_second: rays.total() as f64 / seconds.render,
        seconds,
        rays,
        error: film.error(),
        non_finite: film.ledger,
        effects: effect_reports(prepared),
        strategy: settings.strategy,
        light_selection: settings.light_selection,
        shadow_rays: settings.shadow_rays,
        shadow_pattern: settings.shadow_pattern,
        biased: prepared.bias(),
        sampler: settings.sampler,
        seed: settings.seed,
        image_mean: film.mean(),
        image_mean_standard_error: film.standard_error_of_mean(),
        check: None,
        warnings: prepared.scene.warnings.clone(),
    }
}

fn finish(arguments: &Arguments, report: &Report, quiet: bool) -> Result<ExitCode, Error> {
    arguments.json.write(report)?;
    if !quiet {
        eprintln!("{}", summary(arguments, report));
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

fn effect_reports(prepared: &Prepared) -> Vec<EffectReport> {
    let effects = prepared
        .effects
        .iter()
        .map(|(effect, reason)| EffectReport {
            name: effect.name(),
            reason: reason.to_owned(),
        });
    effects.collect()
}

/// Sets a flag at Ctrl-C; a second Ctrl-C ends the process at once.
fn stop_on_interrupt() -> Arc<AtomicBool> {
    let flag = Arc::new(AtomicBool::new(false));
    let seen = Arc::clone(&flag);
    // A handler that cannot be installed leaves the default: Ctrl-C ends the process.
    let _ = ctrlc::set_handler(move || {
        if seen.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    });
    flag
}

/// The EXR's attributes.
fn attributes(report: &Report) -> Vec<(&'static str, String)> {
    let mut attributes = vec![
        ("command", std::env::args().collect::<Vec<_>>().join(" ")),
        ("scene", report.scene.clone()),
        ("adapter", report.adapter.name.clone()),
        ("driver", report.adapter.driver.clone()),
        ("seed", report.seed.to_string()),
        ("spp", report.spp.to_string()),
        ("seconds", format!("{:.3}", report.seconds.render)),
        ("direkt", report.direkt.to_owned()),
        ("strategy", report.strategy.to_string()),
        ("light_selection", report.light_selection.to_string()),
        ("shadow_rays", report.shadow_rays.to_string()),
        ("shadow_pattern", report.shadow_pattern.to_string()),
        ("sampler", report.sampler.to_string()),
    ];
    attributes.extend(report.biased.clone().map(|bias| ("biased", bias)));
    attributes
}

fn summary(arguments: &Arguments, report: &Report) -> String {
    let files: Vec<String> = match arguments.outputs.output.as_slice() {
        [] => vec![report.scene.clone()],
        files => files.iter().map(|p| p.display().to_string()).collect(),
    };
    let error = report.error.map_or_else(
        || "error unknown".to_owned(),
        |e| {
            format!(
                "relMSE {:.3e} [{:.3e}, {:.3e}]",
                e.rel_mse, e.rel_mse_low, e.rel_mse_high
            )
        },
    );
    format!(
        "{}: {} × {}, {} spp in {:.2} s ({:.1} M samples/s, {:.1} M rays/s), {error}",
        files.join(", "),
        report.width,
        report.height,
        report.spp,
        report.seconds.render,
        report.samples_per_second / 1e6,
        report.rays_per_second / 1e6,
    )
}

fn ledger_sentence(ledger: &Ledger) -> String {
    let first = |kind: &str, bad: Option<crate::render::FirstBad>| {
        bad.map_or_else(String::new, |b| {
            format!(
                "; first {kind} at pixel ({}, {}), sample {}",
                b.x, b.y, b.sample
            )
        })
    };
    format!(
        "{} samples were not finite and were dropped{}{}",
        ledger.dropped,
        first("NaN", ledger.first_nan),
        first("infinity", ledger.first_infinite),
    )
}
