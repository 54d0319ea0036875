//! What a render tells: on stderr, as JSON and in the attributes of an EXR.

use super::Rendered;
use direkt::low_level::gpu::AdapterFacts;
use direkt::low_level::prepare::Prepared;
use direkt::low_level::render::{Check, ImageError, Ledger, RayCounts, StoppedBy};
use direkt::scene::{Aovs, ErrorMetric, EstimatorSettings};
use direkt_instruments::report::format::number;
use serde::Serialize;
use std::ffi::OsStr;
use std::path::Path;

/// What `--json` writes.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    direkt: &'static str,
    scene: String,
    adapter: AdapterFacts,
    width: u32,
    height: u32,
    spp: u64,
    /// Fewest and most samples of a pixel.
    samples: [u64; 2],
    passes: u64,
    /// What ended it.
    pub(super) stopped_by: StoppedBy,
    seconds: Seconds,
    rays: RayCounts,
    samples_per_second: f64,
    rays_per_second: f64,
    error: Option<ImageError>,
    pub(super) non_finite: Ledger,
    effects: Vec<EffectReport>,
    #[serde(flatten)]
    estimator: EstimatorSettings,
    biased: Option<String>,
    seed: u32,
    aovs: Aovs,
    light_groups: Vec<String>,
    image_mean: [f64; 3],
    image_mean_standard_error: Option<[f64; 3]>,
    pub(super) check: Option<Check>,
    warnings: Vec<String>,
}

#[derive(Debug, Serialize)]
pub(super) struct Seconds {
    pub(super) load: f64,
    pub(super) accel: f64,
    pub(super) compile: f64,
    pub(super) render: f64,
    pub(super) aovs: f64,
    pub(super) total: f64,
}

#[derive(Debug, Serialize)]
struct EffectReport {
    name: &'static str,
    reason: String,
}

/// What is known of the image in the end.
pub(super) fn report(prepared: &Prepared, rendered: &Rendered, seconds: Seconds) -> Report {
    let settings = prepared.settings;
    let Rendered {
        film,
        rays,
        progressed,
        device,
        ..
    } = rendered;
    let rays = *rays;
    Report {
        direkt: env!("CARGO_PKG_VERSION"),
        scene: prepared.data.scene.source.display().to_string(),
        adapter: device.adapter.clone(),
        width: film.size.width,
        height: film.size.height,
        spp: film.mean_samples(),
        samples: film.sample_range().into(),
        passes: progressed.passes,
        stopped_by: progressed.stopped_by,
        samples_per_second: rays.camera as f64 / seconds.render,
        rays_per_second: rays.total() as f64 / seconds.render,
        seconds,
        rays,
        error: film.error(),
        non_finite: film.ledger,
        effects: effect_reports(prepared),
        estimator: film.settings_of(settings.estimator),
        biased: prepared.bias(),
        seed: settings.seed,
        aovs: settings.aovs,
        light_groups: prepared.emitters.groups.names.clone(),
        image_mean: film.mean(),
        image_mean_standard_error: film.standard_error_of_mean(),
        check: None,
        warnings: prepared.data.scene.warnings.clone(),
    }
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

/// The command line as UTF-8: what is none has replacement characters.
pub(super) fn command_line() -> String {
    let arguments: Vec<_> = std::env::args_os().collect();
    arguments
        .join(OsStr::new(" "))
        .to_string_lossy()
        .into_owned()
}

/// One line about the image in `files`.
pub(super) fn summary(files: &[&Path], report: &Report) -> String {
    let files: Vec<String> = match files {
        [] => vec![report.scene.clone()],
        files => files.iter().map(|p| p.display().to_string()).collect(),
    };
    let unknown = "error unknown".to_owned();
    let error = report.error.as_ref().map_or(unknown, error_sentence);
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

/// The error in both metrics; what cannot be told has its reason.
fn error_sentence(error: &ImageError) -> String {
    let in_metric = |metric: ErrorMetric| {
        let (symbol, stated) = (metric.symbol(), error.in_metric(metric));
        let [percent, low, high] = stated.percent().map(number);
        match stated.doubt {
            None => format!("√{symbol} {percent} % [{low}, {high}]"),
            Some(doubt) => {
                format!("√{symbol} cannot be told (perhaps {percent} % [{low}, {high}]: {doubt})")
            }
        }
    };
    [ErrorMetric::Nmse, ErrorMetric::RelMse]
        .map(in_metric)
        .join(", ")
}

/// What was dropped.
pub(super) fn ledger_sentence(ledger: &Ledger) -> String {
    let first = |kind: &str, bad: Option<direkt::low_level::render::FirstBad>| {
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
