//! `direkt compare`: the GPU estimator held against the reference.

use super::plan::{Failures, Plan};
use super::settings::{EstimatorArguments, SceneArguments, warn};
use super::{AdapterArgument, JsonArgument, progress};
use direkt::error::Error;
use direkt::low_level::console::print;
use direkt::low_level::gpu::{AdapterFacts, Context};
use direkt::low_level::image::signed;
use direkt::low_level::prepare::Prepared;
use direkt::low_level::reference::BrokenTwin;
use direkt::scene::{EstimatorSettings, FilmSize, Sampler, ShadowRays};
use direkt_instruments::compare::{
    CompareError, Comparison, Settings, compare, default_film, minimum_samples, per_sample,
};
use serde::Serialize;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Arguments of `direkt compare`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// Samples per pixel
    #[arg(long, default_value_t = 64)]
    spp: u64,
    #[command(flatten)]
    estimator: EstimatorArguments,
    /// Let the reference make a mistake, which the comparison has to find: exit 1
    #[arg(long = "break", value_enum, value_name = "NAME")]
    broken: Option<BrokenTwin>,
    /// Compare with exact direct lighting as well: scenes of polygons under polygon, point, spot
    /// and directional lights
    #[arg(long)]
    exact: bool,
    /// Write GPU minus reference as an image (.exr, .png); the PNG's scale is the image's mean
    #[arg(long, value_name = "FILE")]
    difference: Option<PathBuf>,
    /// Write the pixels' z-scores as an image (.exr, .png); the PNG's scale is ±4
    #[arg(long, value_name = "FILE")]
    z_scores: Option<PathBuf>,
    /// No progress on stderr
    #[arg(short, long)]
    quiet: bool,
    #[command(flatten)]
    adapter: AdapterArgument,
    #[command(flatten)]
    json: JsonArgument,
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
    seed: u32,
    #[serde(flatten)]
    estimator: EstimatorSettings,
    biased: Option<String>,
    broken: Option<&'static str>,
    agrees: bool,
    #[serde(flatten)]
    comparison: Comparison,
    warnings: Vec<String>,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<ExitCode, Error> {
    let mut plan = arguments.plan()?;
    let device = arguments.adapter.open();
    let (prepared, settings) = prepare(arguments, &mut plan, device.as_ref().ok())?;
    let context = device?;
    let quiet = arguments.quiet || arguments.json.is_stdout();
    let template = "{bar:24} {percent:>3} % comparing, {eta} left";
    let bar = progress::bar(settings.samples, template, quiet);
    let path = arguments.scene.scene.display();
    let comparison = compare(&context, &prepared, &settings, |done| {
        bar.set_position(done);
    })
    .map_err(|e| match e {
        CompareError::NotExact(e) => Error::Usage(format!("--exact: {path}: {e}")),
        CompareError::Gpu(e) => Error::Gpu(e),
    })?;
    bar.finish_and_clear();
    let report = Report {
        direkt: env!("CARGO_PKG_VERSION"),
        scene: path.to_string(),
        adapter: context.adapter.clone(),
        width: settings.film.width,
        height: settings.film.height,
        spp: settings.samples,
        seed: settings.seed,
        estimator: prepared.settings.estimator,
        biased: prepared.bias(),
        broken: settings.broken.map(|b| b.row().name),
        agrees: comparison.agrees(),
        comparison,
        warnings: prepared.data.scene.warnings.clone(),
    };
    let mut failures = Failures::default();
    for (path, bytes) in images(arguments, settings.film, &report) {
        failures.note(bytes.and_then(|bytes| plan.write(path, &bytes)));
    }
    failures.note(arguments.json.write(&plan, &report));
    if !arguments.json.is_stdout() {
        print(&text(&report));
    }
    Ok(failures.exit_code(if report.agrees {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }))
}

impl Arguments {
    /// What is going to be written.
    fn plan(&self) -> Result<Plan, Error> {
        let mut plan = Plan::default();
        if let Some(path) = &self.difference {
            plan.image("--difference", path)?;
        }
        if let Some(path) = &self.z_scores {
            plan.image("--z-scores", path)?;
        }
        self.json.plan(&mut plan)?;
        Ok(plan)
    }
}

/// Reads the scene and refuses what could not be compared, before anything runs.
fn prepare(
    arguments: &Arguments,
    plan: &mut Plan,
    device: Option<&Context>,
) -> Result<(Prepared, Settings), Error> {
    let mut scene = arguments.scene.load(plan, device)?;
    scene.render.estimator.sampler = Sampler::Independent;
    arguments.estimator.apply(&mut scene)?;
    let rays = &mut scene.render.estimator.shadow_rays;
    *rays = ShadowRays::Number(rays.least());
    warn(&scene);
    let size = arguments.estimator.image.size;
    let settings = Settings {
        film: size.unwrap_or_else(|| default_film(scene.film)),
        samples: arguments.spp,
        seed: scene.render.seed,
        broken: arguments.broken,
        exact: arguments.exact,
    };
    check_samples(&settings)?;
    let prepared = Prepared::of(scene);
    check_broken(&prepared, arguments.broken)?;
    if let Some(bias) = prepared.bias().filter(|_| arguments.exact) {
        return Err(Error::Usage(format!("--exact: {bias}")));
    }
    Ok((prepared, settings))
}

/// Refuses a number of samples with which no pixel could be found to differ.
fn check_samples(settings: &Settings) -> Result<(), Error> {
    let FilmSize { width, height } = settings.film;
    let fewest = minimum_samples(settings.film);
    if settings.samples >= fewest {
        return Ok(());
    }
    Err(Error::Usage(format!(
        "--spp {}: with fewer than {fewest} samples in each of {width} × {height} pixels no pixel could be found to differ",
        settings.samples
    )))
}

/// Refuses a mistake in code that the scene never runs.
fn check_broken(prepared: &Prepared, broken: Option<BrokenTwin>) -> Result<(), Error> {
    let Some(row) = broken.map(BrokenTwin::row) else {
        return Ok(());
    };
    if (row.applies)(prepared) {
        return Ok(());
    }
    Err(Error::Usage(format!(
        "--break {}: {} - but this scene with this strategy never gets there",
        row.name, row.description
    )))
}

/// Each image that is asked for, with its name.
fn images<'a>(
    arguments: &'a Arguments,
    size: FilmSize,
    report: &Report,
) -> Vec<(&'a Path, Result<Vec<u8>, Error>)> {
    let pixels = &report.comparison.pixels;
    let attributes = [
        ("scene", report.scene.clone()),
        ("adapter", report.adapter.name.clone()),
        ("driver", report.adapter.driver.clone()),
        ("direkt", report.direkt.to_owned()),
    ];
    let encode = |path: &'a PathBuf, values: Vec<[f64; 3]>, scale: f64| {
        let encoded = signed::encode(path, size, &values, scale, &attributes);
        (path.as_path(), encoded.map_err(|e| Error::write(path, e)))
    };
    let difference = arguments.difference.as_ref().map(|path| {
        let values = pixels.iter().map(|p| (p.gpu - p.reference).to_array());
        let means = report.comparison.whole_image.channels.map(|c| c.reference);
        let scale = means.iter().sum::<f64>() / 3.0;
        encode(path, values.collect(), scale.max(f64::MIN_POSITIVE))
    });
    let z_scores = arguments.z_scores.as_ref().map(|path| {
        let values = pixels.iter().map(|p| p.t);
        encode(path, values.collect(), 4.0)
    });
    difference.into_iter().chain(z_scores).collect()
}

fn text(report: &Report) -> String {
    let mut out = format!(
        "{}, {}, {} light selection, {} {} shadow {}, {} × {} pixels, {} samples each, seed {}, on {} ({})\n",
        report.scene,
        report.estimator.strategy,
        report.estimator.light_selection,
        report.estimator.shadow_rays,
        report.estimator.shadow_pattern,
        if report.estimator.shadow_rays == ShadowRays::Number(1) {
            "ray"
        } else {
            "rays"
        },
        report.width,
        report.height,
        report.spp,
        report.seed,
        report.adapter.name,
        report.adapter.driver
    );
    if let Some(broken) = report.broken {
        let _ = writeln!(out, "the reference is broken on purpose: {broken}");
    }
    per_sample_text(&mut out, &report.comparison.per_sample);
    means_text(&mut out, &report.comparison);
    let verdict = if report.agrees {
        "GPU and reference agree"
    } else {
        "GPU and reference DIFFER"
    };
    let _ = writeln!(out, "verdict      {verdict}");
    out
}

/// `passed` or `FAILED`.
fn mark(passed: bool) -> &'static str {
    if passed { "passed" } else { "FAILED" }
}

// Writing into a String cannot fail.

fn per_sample_text(out: &mut String, c: &per_sample::PerSample) {
    let _ = writeln!(
        out,
        "per sample   {}: {} samples with the same random numbers; of {} that carry light {:.4} % agree within 1e-4, {:.4} % within 1e-3, {:.4} % within that or rounding of the camera ray ({} % needed)",
        mark(c.agrees()),
        c.samples,
        c.lit,
        100.0 * c.within_1e_4,
        100.0 * c.within_1e_3,
        100.0 * (1.0 - c.unexplained),
        100.0 * (1.0 - per_sample::MAX_BEYOND),
    );
    let _ = writeln!(
        out,
        "             rays met something else in {:.1e} of them ({:.0e} allowed): {} camera, {} shadow, {} BSDF",
        c.flip_rate,
        per_sample::MAX_FLIPS,
        c.flips.camera,
        c.flips.shadow,
        c.flips.bsdf,
    );
    for (what, worst) in [
        ("worst", &c.worst),
        ("worst with other rays", &c.worst_flip),
    ] {
        if let Some(w) = worst {
            let _ = writeln!(
                out,
                "             {what}: pixel ({}, {}), sample {}, off by {:.1e}: GPU {:?}, reference {:?}: {}",
                w.x, w.y, w.sample, w.difference, w.gpu, w.reference, w.cause
            );
        }
    }
    if c.not_finite > 0 {
        let _ = writeln!(
            out,
            "             {} GPU samples are not finite",
            c.not_finite
        );
    }
}

fn means_text(out: &mut String, c: &Comparison) {
    let _ = writeln!(
        out,
        "accumulation {}: film and its samples differ by {:.1e} of a pixel's largest sample at most; {} samples dropped",
        mark(c.accumulation.agrees()),
        c.accumulation.largest_deviation,
        c.accumulation.dropped,
    );
    let p = &c.per_pixel;
    let worst = p.worst.map_or_else(String::new, |w| {
        format!("; largest |z| {:.2} at pixel ({}, {})", w.t.abs(), w.x, w.y)
    });
    let _ = writeln!(
        out,
        "per pixel    {}: {} tests with other random numbers, {} rejected at the family-wise level {:.0e}{worst}",
        mark(p.agrees()),
        p.tests,
        p.rejected,
        p.family_level,
    );
    let _ = writeln!(
        out,
        "             z-scores: mean {:.3}, mean square {:.3}; {:>5} {:>7} {:>7}",
        p.mean_t, p.mean_t_squared, "z", "found", "N(0,1)"
    );
    for bin in &p.histogram {
        let bar = "#".repeat((bin.found * 100.0).round() as usize);
        let _ = writeln!(
            out,
            "             {:>5.1} {:>7.4} {:>7.4} {bar}",
            bin.t, bin.found, bin.expected
        );
    }
    let _ = writeln!(
        out,
        "whole image  {}: GPU minus reference, 95 % interval",
        mark(c.whole_image.agrees())
    );
    let channels = c.whole_image.channels;
    channels_text(
        out,
        channels.map(|c| [c.difference, c.half_width, c.reference, c.t, c.p_value]),
    );
    if let Some(exact) = &c.exact {
        let _ = writeln!(
            out,
            "exact        {}: GPU minus exact over {} samples, 95 % interval",
            mark(exact.agrees()),
            exact.samples
        );
        let channels = exact.channels;
        channels_text(
            out,
            channels.map(|c| [c.difference, c.half_width, c.exact, c.z, c.p_value]),
        );
    }
}

/// Per channel a line of difference, half width of its interval, reference, z and p-value.
fn channels_text(out: &mut String, channels: [[f64; 5]; 3]) {
    for (name, [difference, half_width, reference, z, p]) in
        ["red", "green", "blue"].into_iter().zip(channels)
    {
        let _ = writeln!(
            out,
            "             {name:>5} {difference:+.3e} ± {half_width:.1e} of {reference:.6} (z {z:.2}, p {p:.1e})"
        );
    }
}
