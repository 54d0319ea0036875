//! `direkt cost`: what accuracy costs in time, for every estimator.

use super::settings::SceneListArguments;
use super::{AdapterArgument, JsonArgument, print};
use crate::cost::estimator::{self, Choices};
use crate::cost::{SceneCost, Settings, measure};
use crate::error::Error;
use crate::gpu::Context;
use crate::report::format::{number, seconds, short};
use crate::report::{self, csv, machine::Machine};
use crate::scene::{FilmSize, LightSelection, Sampler, Scene, ShadowPattern, Strategy, validate};
use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `direkt cost`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    scenes: SceneListArguments,
    /// Folder for report.html and the plots (SVG and PNG); made if need be
    #[arg(short, long = "output", value_name = "DIR")]
    output: PathBuf,
    /// Rendering time on each scene, such as 30s, 2m or 1m30s; compiling comes on top
    #[arg(long, value_name = "DURATION", default_value = "60s", value_parser = parse_duration)]
    budget: f64,
    /// Strategies to compare [default: all]
    #[arg(long, value_name = "LIST", value_enum, value_delimiter = ',')]
    strategies: Vec<Strategy>,
    /// Light selections to compare [default: the scene's]
    #[arg(long, value_name = "LIST", value_enum, value_delimiter = ',')]
    light_selections: Vec<LightSelection>,
    /// Numbers of shadow rays per camera ray to compare, each 1 to 1024 [default: the scene's]
    #[arg(long, value_name = "LIST", value_parser = super::settings::shadow_rays(), value_delimiter = ',')]
    shadow_rays: Vec<u32>,
    /// Patterns of their points to compare [default: the scene's]
    #[arg(long, value_name = "LIST", value_enum, value_delimiter = ',')]
    shadow_patterns: Vec<ShadowPattern>,
    /// Samplers to compare
    #[arg(
        long,
        value_name = "LIST",
        value_enum,
        value_delimiter = ',',
        default_values_t = [Sampler::Independent, Sampler::Sobol]
    )]
    samplers: Vec<Sampler>,
    /// Relative mean squared error whose price is told
    #[arg(long, value_name = "RELMSE", default_value_t = 1e-3)]
    target_error: f64,
    /// Image to compare with, an EXR of the same size; otherwise the scene's exact values or a long run of direkt's own
    #[arg(long, value_name = "FILE")]
    reference: Option<PathBuf>,
    /// Size of the images
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = super::settings::parse_size)]
    size: Option<FilmSize>,
    /// Seed that all seeds are derived from
    #[arg(long)]
    seed: Option<u32>,
    /// Write every measured point as a line of CSV to this file
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
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
    scenes: &'a [SceneCost],
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<ExitCode, Error> {
    arguments.check()?;
    let mut scenes = arguments.scenes.load()?;
    for scene in &mut scenes {
        arguments.apply(scene)?;
    }
    let context = Context::new(arguments.adapter.adapter.as_deref())?;
    let machine = Machine::this(&context.adapter);
    let quiet = arguments.quiet || arguments.json.is_stdout();
    let mut costs = Vec::new();
    for scene in &scenes {
        let settings = arguments.settings(scene);
        let progress = Bar::new(settings.budget, quiet);
        let source = scene.source.display();
        let mut show = |what: &str, spent: f64| progress.show(&format!("{source}: {what}"), spent);
        let cost = measure(&context, scene, &settings, &mut show)?;
        progress.finish();
        if !quiet {
            print(&summary(&cost))?;
        }
        costs.push(cost);
    }
    report::write(&arguments.output, &costs, &machine)?;
    if let Some(path) = &arguments.csv {
        crate::image::write_atomically(path, csv::table(&costs).as_bytes())?;
    }
    arguments.json.write(&Report {
        machine: &machine,
        scenes: &costs,
    })?;
    if !quiet {
        let page = arguments.output.join("report.html");
        print(&format!("{}\n", page.display()))?;
    }
    Ok(ExitCode::SUCCESS)
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
        if self.output.is_file() {
            return Err(Error::Usage(format!(
                "{} is a file; name a folder for the report",
                self.output.display()
            )));
        }
        if self.reference.is_some() && self.scenes.scenes.len() > 1 {
            return Err(Error::Usage(
                "--reference is for one scene; name one".to_owned(),
            ));
        }
        Ok(())
    }

    fn apply(&self, scene: &mut Scene) -> Result<(), Error> {
        scene.render.seed = self.seed.unwrap_or(scene.render.seed);
        if let Some(size) = self.size.filter(|&size| size != scene.film) {
            scene.film = size;
            // What it says holds for the film of the file.
            scene.expect = None;
        }
        validate::validate(scene)
    }

    fn settings(&self, scene: &Scene) -> Settings {
        let render = &scene.render;
        let choices = Choices {
            strategies: or(&self.strategies, Strategy::value_variants()),
            light_selections: or(&self.light_selections, &[render.light_selection]),
            shadow_rays: or(&self.shadow_rays, &[render.shadow_rays]),
            shadow_patterns: or(&self.shadow_patterns, &[render.shadow_pattern]),
            samplers: self.samplers.clone(),
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

/// `list`, or `default` where it is empty.
fn or<T: Clone>(list: &[T], default: &[T]) -> Vec<T> {
    if list.is_empty() { default } else { list }.to_vec()
}

/// The table that is printed.
fn summary(cost: &SceneCost) -> String {
    let mut out = format!(
        "{}: {} × {}, {:.1} s of rendering\n  rank  {:<40}{:>34}{:>12}{:>16}{:>12}\n",
        cost.scene,
        cost.width,
        cost.height,
        cost.seconds,
        "estimator",
        "efficiency 1/(relMSE·s)",
        "per sample",
        "slope",
        format!("to {}", short(cost.target)),
    );
    for e in report::ranked(cost) {
        let interval = e.efficiency;
        let efficiency = format!(
            "{} [{}, {}]",
            number(interval.value),
            number(interval.low),
            number(interval.high)
        );
        let slope = e.slope_samples.map_or_else(
            || "—".to_owned(),
            |s| format!("{:.2} ± {:.2}", s.value, s.standard_error),
        );
        let reached = e.reached.iter();
        let reached = reached.filter(|r| (r.target / cost.target - 1.0).abs() < 1e-9);
        let reached = reached.map(|r| r.seconds.value).next();
        out.push_str(&format!(
            "  {:>3}{}  {:<40}{efficiency:>34}{:>12}{slope:>16}{:>12}\n",
            e.rank.rank,
            if e.rank.ties.is_empty() { " " } else { "=" },
            e.name,
            seconds(e.seconds_per_sample.value),
            reached.map_or_else(|| "—".to_owned(), seconds),
        ));
    }
    for n in &cost.not_applicable {
        out.push_str(&format!("     —  {}: {}\n", n.estimator, n.reason));
    }
    out
}

/// The progress bar: how much of the budget is spent.
struct Bar(ProgressBar);

impl Bar {
    fn new(budget: f64, quiet: bool) -> Self {
        let bar = if quiet {
            ProgressBar::hidden()
        } else {
            ProgressBar::new((1000.0 * budget) as u64)
        };
        let style = ProgressStyle::with_template("{bar:24} {percent:>3} % {msg}");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        Self(bar)
    }

    fn show(&self, what: &str, spent: f64) {
        self.0.set_position((1000.0 * spent) as u64);
        self.0.set_message(what.to_owned());
        self.0.tick();
    }

    fn finish(&self) {
        self.0.finish_and_clear();
    }
}

/// Seconds of a duration such as `90s`, `1m30s`, `500ms` or `2h`.
fn parse_duration(text: &str) -> Result<f64, String> {
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
