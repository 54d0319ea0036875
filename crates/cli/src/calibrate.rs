//! `direkt cost --calibrate`: do images know their own error?

use super::cost::or;
use clap::ValueEnum;
use direkt::low_level::console::print;
use direkt::scene::{Sampler, Scene, Strategy};
use direkt_instruments::cost::calibrate::{Calibration, Estimate, Settings};
use direkt_instruments::cost::estimator::{Choices, combinations};
use direkt_instruments::report::format::short;

/// What `--calibrate` takes besides the scenes.
#[derive(Debug, clap::Args)]
pub struct CalibrateArguments {
    /// Compare the errors that images report with their actual ones, over many seeds; no report is
    /// written
    #[arg(long)]
    pub calibrate: bool,
    /// Images of each sampler for --calibrate
    #[arg(long, value_name = "N", default_value_t = 200, requires = "calibrate", value_parser = clap::value_parser!(u32).range(10..=10_000))]
    images: u32,
    /// Samples per pixel of these images, one number or several [default: the scene's]
    #[arg(long, value_name = "LIST", requires = "calibrate", value_delimiter = ',', value_parser = clap::value_parser!(u64).range(2..))]
    spp: Vec<u64>,
    /// Whether they are sampled adaptively, `false,true` for both [default: the scene's]
    #[arg(
        long,
        value_name = "LIST",
        requires = "calibrate",
        value_delimiter = ','
    )]
    adaptive: Vec<bool>,
}

impl CalibrateArguments {
    /// What to calibrate on `scene`: `strategies`, or its own where there are none, with
    /// `samplers`, or all.
    pub fn settings(
        &self,
        scene: &Scene,
        strategies: &[Strategy],
        samplers: &[Sampler],
    ) -> Settings {
        Settings {
            estimators: combinations(&Choices {
                strategies: or(strategies, &[scene.render.estimator.strategy]),
                samplers: or(samplers, Sampler::value_variants()),
                adaptive: or(&self.adaptive, &[scene.render.estimator.adaptive]),
                ..Choices::of(&scene.render)
            }),
            images: self.images,
            samples: or(&self.spp, &[scene.render.stop.spp]),
            seed: scene.render.seed,
        }
    }
}

/// Prints the table.
pub fn print_table(calibrations: &[Calibration]) {
    let Some(first) = calibrations.first() else {
        return;
    };
    print(&format!(
        "{}: {} × {}, {} images each\n  {:<44}{:>6}{:>10}{:>18}{:>9}{:>15}{:>18}{:>9}{:>15}  stopped at √NMSE{:>18}{:>15}\n",
        first.scene,
        first.width,
        first.height,
        first.images,
        "estimator",
        "spp",
        "√NMSE",
        "reported/actual",
        "told",
        "in 95 %",
        "relMSE: rep./act.",
        "told",
        "in 95 %",
        "reported/actual",
        "below target",
    ));
    for c in calibrations {
        let (nmse, rel_mse, stopped) = (&c.nmse, &c.rel_mse, &c.stopped);
        print(&format!(
            "  {:<44}{:>6}{:>8} %{:>18}{:>9}{:>15}{:>18}{:>9}{:>15}  {:>6} % in {:>5.0}{:>18}{:>15}\n",
            c.estimator.to_string(),
            c.samples,
            short(100.0 * nmse.actual.sqrt()),
            plus_minus(nmse.ratio, 3),
            format!("{:.0} %", 100.0 * nmse.told.value),
            percent(nmse.coverage),
            plus_minus(rel_mse.ratio, 3),
            format!("{:.0} %", 100.0 * rel_mse.told.value),
            percent(rel_mse.coverage),
            short(100.0 * stopped.target),
            stopped.samples,
            plus_minus(stopped.ratio, 3),
            percent(stopped.below_target),
        ));
    }
}

fn plus_minus(e: Estimate, digits: usize) -> String {
    format!("{:.digits$} ± {:.digits$}", e.value, e.standard_error)
}

fn percent(e: Estimate) -> String {
    format!("{:.1} ± {:.1} %", 100.0 * e.value, 100.0 * e.standard_error)
}
