//! What accuracy costs in time: the error of every estimator against its time, on one scene.
//!
//! All estimators are compiled first. Then they take turns: two independent images (*replicates*,
//! other seeds) of 1 sample per pixel each, then of 2, of 4 and so on, every run with random
//! numbers of its own, until the budget does not pay for the next doubling; what is left of it goes
//! into more replicates of the largest count. Because they take turns, a machine that slows down
//! slows them all alike.
//!
//! | measure | definition |
//! |---|---|
//! | error | [`error`]: relMSE and MSE against a [`reference`](mod@reference), whose own error is subtracted; intervals from replicates, pixel by pixel |
//! | time | seconds of rendering alone; intervals from the scatter of log-times over all replicates of the estimator |
//! | slope | of ln relMSE against ln samples and ln seconds, by least squares over all counts whose error is known to a factor of two ([`fit`]) |
//! | efficiency | 1/(V·T) with V = relMSE · n, the relative variance of one sample, and T = seconds/n: 1/(relMSE · seconds), at the largest count |
//! | time to a target | where the line through ln relMSE against ln seconds meets it |
//! | rank | 1 plus the number of estimators whose efficiency's interval lies above; overlapping intervals are ties |
//! | effects | the same estimator with unneeded effects ([`effects`]): same random numbers, images compared bit for bit, times in pairs, hence ranks by the ratio's interval |

pub mod calibrate;
mod compile;
pub mod effects;
pub mod error;
pub mod estimator;
pub mod fit;
pub mod interrupted;
mod rank;
pub use direkt::low_level::stats::interval;
mod budget;
mod interleave;
pub mod measures;
pub mod reference;
pub mod runner;

pub use effects::{Compiled, WithoutNeed};
pub use estimator::{Estimator, NotApplicable};
pub use interval::Interval;
pub use measures::{Point, Rank, Reached};

use direkt::error::Error;
use direkt::low_level::gpu::Context;
use direkt::low_level::render::{Film, RayCounts};
use direkt::scene::Scene;
use fit::Slope;
use interrupted::Interrupted;
use serde::Serialize;
use std::path::PathBuf;

/// What to measure.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// The estimators to compare.
    pub estimators: Vec<Estimator>,
    /// Seconds of rendering on each scene; compiling comes on top.
    pub budget: f64,
    /// Target relMSE; the report gives the time to reach it.
    pub target: f64,
    /// An EXR to compare with; none: what the scene states, or a run of one's own.
    pub reference: Option<PathBuf>,
    /// All seeds are derived from it.
    pub seed: u32,
}

/// What accuracy costs on a scene.
#[derive(Debug, Clone, Serialize)]
pub struct SceneCost {
    /// The scene's file.
    pub scene: String,
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Primitives.
    pub primitives: usize,
    /// Seconds of rendering that were allowed.
    pub budget: f64,
    /// Seconds of rendering that were used.
    pub seconds: f64,
    /// Whether measuring ended before its time.
    pub interrupted: bool,
    /// Seed of all.
    pub seed: u32,
    /// What images were compared with.
    pub reference: ReferenceFacts,
    /// The estimators, in the order in which they were named.
    pub estimators: Vec<EstimatorCost>,
    /// Those that the scene cannot use.
    pub not_applicable: Vec<NotApplicable>,
    /// Target relMSE; the report gives the time to reach it.
    pub target: f64,
    /// Seconds that each image of the comparison at equal time was to take.
    pub equal_seconds: f64,
    /// The reference image.
    #[serde(skip)]
    pub reference_image: Vec<[f64; 3]>,
}

/// What is known of the reference.
#[derive(Debug, Clone, Serialize)]
pub struct ReferenceFacts {
    /// Where it comes from.
    #[serde(flatten)]
    pub source: reference::Source,
    /// Its own MSE, which was subtracted; none where it is not known.
    pub mse: Option<Interval>,
    /// Its own relMSE, likewise.
    pub rel_mse: Option<Interval>,
}

/// What accuracy costs with one estimator.
#[derive(Debug, Clone, Serialize)]
pub struct EstimatorCost {
    /// Its name among those that are compared.
    pub name: String,
    /// The estimator.
    #[serde(flatten)]
    pub estimator: Estimator,
    /// Why its images do not converge to direct lighting, so that its error does not fall to zero;
    /// none where they do.
    pub biased: Option<String>,
    /// Seconds that compiling its kernel took once, the driver's part included, nothing kept from
    /// before.
    pub compile_seconds: f64,
    /// Seconds per sample of one pixel, at the largest count.
    pub seconds_per_sample: Interval,
    /// Samples of one pixel per second, likewise.
    pub samples_per_second: f64,
    /// Errors and times, from few samples to many.
    pub points: Vec<Point>,
    /// d ln relMSE / d ln samples; none where too few errors are known.
    pub slope_samples: Option<Slope>,
    /// d ln relMSE / d ln seconds, likewise.
    pub slope_time: Option<Slope>,
    /// 1/(relMSE · seconds) at the largest count.
    pub efficiency: Interval,
    /// Its place.
    #[serde(flatten)]
    pub rank: Rank,
    /// When the target is reached, and ten times and a tenth of it; those that are not are left
    /// out.
    pub reached: Vec<Reached>,
    /// Samples that were not finite and were dropped.
    pub dropped: u64,
    /// An image of about the same time as the others'; none where measuring ended before it was
    /// rendered.
    pub equal_time: Option<EqualTime>,
    /// What unneeded effects cost; none where there are none.
    pub without_need: Option<WithoutNeed>,
}

/// An image at equal time.
#[derive(Debug, Clone, Serialize)]
pub struct EqualTime {
    /// Samples per pixel.
    pub samples: u64,
    /// Seconds of rendering.
    pub seconds: f64,
    /// Passes over the image.
    pub passes: u64,
    /// Rays traced.
    pub rays: RayCounts,
    /// Rays per second.
    pub rays_per_second: f64,
    /// Relative mean squared error of this one image, the reference's subtracted.
    pub rel_mse: f64,
    /// The image.
    #[serde(skip)]
    pub film: Film,
    /// √ of each pixel's relative squared error.
    #[serde(skip)]
    pub relative_errors: Vec<f64>,
}

/// What is going on, and which part of the budget is used.
pub type Progress<'p> = &'p mut dyn FnMut(&str, f64);

/// Measures the estimators on `scene`. Once `stop` says so, it ends with what it has; with nothing
/// where the least that a result takes, 1, 2 and 4 samples per pixel by every estimator, is not
/// there yet.
///
/// # Errors
/// The budget is too small for a result, the reference cannot be used, no estimator is applicable,
/// or the driver fails.
pub fn measure(
    context: &Context,
    scene: &Scene,
    settings: &Settings,
    progress: Progress<'_>,
    stop: &dyn Fn() -> bool,
) -> Result<Option<SceneCost>, Error> {
    match budget::measure(context, scene, settings, progress, stop) {
        Ok(cost) => Ok(Some(cost)),
        Err(Interrupted::Stopped) => Ok(None),
        Err(Interrupted::Failed(error)) => Err(error),
    }
}
