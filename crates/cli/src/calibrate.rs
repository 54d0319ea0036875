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
    /// Samples per pixel of these images [default: the scene's]
    #[arg(long, value_name = "N", requires = "calibrate", value_parser = clap::value_parser!(u64).range(2..))]
    spp: Option<u64>,
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
                ..Choices::of(&scene.render)
            }),
            images: self.images,
            samples: self.spp.unwrap_or(scene.render.stop.spp),
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
        "{}: {} × {}, {} images of {} samples per pixel each\n  {:<44}{:>10}{:>22}{:>18}   stopped at √relMSE{:>22}{:>18}{:>26}\n",
        first.scene,
        first.width,
        first.height,
        first.images,
        first.samples,
        "estimator",
        "relMSE",
        "reported/actual",
        "in 95 % interval",
        "reported/actual",
        "below target",
        "bias of the mean",
    ));
    for c in calibrations {
        let s = &c.stopped;
        let bias = s.bias_of_mean[1];
        print(&format!(
            "  {:<44}{:>10}{:>22}{:>18}   {:>7} after {:>7.1}{:>22}{:>18}{:>26}\n",
            c.estimator.to_string(),
            short(c.actual),
            plus_minus(c.ratio, 3),
            percent(c.coverage),
            short(s.target),
            s.samples,
            plus_minus(s.ratio, 3),
            percent(s.below_target),
            format!("{:+.1e} ± {:.1e}", bias.value, bias.standard_error),
        ));
    }
}

fn plus_minus(e: Estimate, digits: usize) -> String {
    format!("{:.digits$} ± {:.digits$}", e.value, e.standard_error)
}

fn percent(e: Estimate) -> String {
    format!("{:.1} ± {:.1} %", 100.0 * e.value, 100.0 * e.standard_error)
}
