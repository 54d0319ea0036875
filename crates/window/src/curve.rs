//! Errors against time, of this run and those before it.

use super::picture::Picture;
use direkt::scene::ShadowRays;
use std::sync::Arc;

/// Runs that are kept at most.
const MAX_RUNS: usize = 8;
/// Points without which a run tells nothing.
const FEWEST_POINTS: usize = 3;

/// The error of one run while it fell.
#[derive(Debug, Clone)]
pub struct Run {
    number: u64,
    /// How it was rendered, in words.
    pub label: String,
    /// Seconds and √NMSE.
    pub points: Arc<Vec<[f64; 2]>>,
}

/// The runs of this session of the window, oldest first; the newest ones are those on screen.
#[derive(Debug, Default)]
pub struct Runs(Vec<Run>);

impl Runs {
    /// Enters what a picture tells.
    pub fn enter(&mut self, picture: &Picture) {
        if !picture.full {
            return;
        }
        let run = Run {
            number: picture.run,
            label: label(picture),
            points: Arc::clone(&picture.curve),
        };
        if let Some(known) = self.0.iter_mut().find(|r| r.number == run.number) {
            *known = run;
            return;
        }
        self.0.retain(|r| r.points.len() >= FEWEST_POINTS);
        self.0.push(run);
        if self.0.len() > MAX_RUNS {
            self.0.remove(0);
        }
    }

    /// The runs, oldest first.
    pub fn iter(&self) -> impl Iterator<Item = &Run> {
        self.0.iter()
    }

    /// Forgets all but those on screen.
    pub fn clear_but(&mut self, shown: &[u64]) {
        self.0.retain(|r| shown.contains(&r.number));
    }
}

impl Run {
    /// Whether it is the run `number`.
    pub fn is(&self, number: u64) -> bool {
        self.number == number
    }
}

/// What tells this run from others.
fn label(picture: &Picture) -> String {
    let settings = picture.method.settings;
    let mut label = format!(
        "{}, {}",
        settings.estimator.strategy, settings.estimator.sampler
    );
    if settings.estimator.shadow_rays != ShadowRays::default() {
        label += &format!(", {} shadow rays", settings.estimator.shadow_rays);
    }
    if settings.estimator.light_selection != Default::default() {
        label += &format!(", lights: {}", settings.estimator.light_selection);
    }
    if !picture.method.forced.is_empty() {
        label += &format!(", {} forced", picture.method.forced.len());
    }
    label
}
