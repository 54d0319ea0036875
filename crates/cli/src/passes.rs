//! The passes of a render, until something ends them.

use super::interrupt::Interrupt;
use super::progress::Progress;
use direkt::error::Error;
use direkt::render::goal::{ErrorGoal, Look, Watch};
use direkt::render::{Session, StopReason};
use direkt::scene::Scene;
use serde::Serialize;
use std::time::{Duration, Instant};

/// What ended a render.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum StoppedBy {
    /// It has the samples that were asked for.
    Samples,
    /// The time was over.
    Time,
    /// Its error is small enough.
    Error,
    /// No error can become small enough: no sample found any light.
    Black,
    /// The user.
    Interrupt,
    /// The driver, which failed.
    Failure,
}

/// As long as `seconds`, which are positive; more than any clock counts is forever.
pub fn duration(seconds: f64) -> Duration {
    Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX)
}

/// How the passes went.
pub struct Progressed {
    /// Passes over the image.
    pub passes: u64,
    /// Seconds that they took.
    pub seconds: f64,
    /// What ended them.
    pub stopped_by: StoppedBy,
}

/// The passes of one render, on one device or on several that follow each other.
pub struct Passes<'a> {
    scene: &'a Scene,
    interrupt: Interrupt,
    time: Option<Duration>,
    progress: Progress,
    start: Instant,
    watch: Option<Watch>,
    passes: u64,
}

impl<'a> Passes<'a> {
    /// Those of `scene`, from now on, until `interrupt` comes.
    pub fn new(scene: &'a Scene, interrupt: Interrupt, quiet: bool) -> Self {
        interrupt.defer();
        let settings = scene.render;
        let time = settings.time.map(duration);
        let goal = settings.error.map(|relative| ErrorGoal {
            relative,
            confidence: settings.confidence,
        });
        Self {
            scene,
            interrupt,
            time,
            progress: Progress::new(settings.spp, time, quiet),
            start: Instant::now(),
            watch: goal.map(Watch::new),
            passes: 0,
        }
    }

    /// Takes passes until the samples, the time or the user's patience run out, or the image is right enough; `after` is called
    /// after each.
    pub fn take(
        &mut self,
        session: &mut Session<'_>,
        mut after: impl FnMut(&Session<'_>) -> Result<(), Error>,
    ) -> Result<Progressed, Error> {
        let spp = self.scene.render.spp;
        let mut stopped_by = StoppedBy::Samples;
        while session.samples() < spp {
            let until = self.watch.map_or(spp, |w| spp.min(w.next()));
            let samples = session.pass_samples(until - session.samples());
            // The first pass is finished whatever the time, so that there is an image.
            let first = session.samples() == 0;
            let out_of_time = || !first && self.time.is_some_and(|t| self.start.elapsed() >= t);
            let stop = || self.interrupt.came() || out_of_time();
            if session.pass(samples, stop)? == StopReason::Interrupted {
                stopped_by = if self.interrupt.came() {
                    StoppedBy::Interrupt
                } else {
                    StoppedBy::Time
                };
                break;
            }
            self.passes += 1;
            let pixels = self.scene.film.pixels();
            self.progress.update(session, self.passes, pixels)?;
            after(session)?;
            let look = self.watch.as_mut().map(|w| w.look(session)).transpose()?;
            stopped_by = match look {
                Some(Look::Reached) => StoppedBy::Error,
                Some(Look::Black) => StoppedBy::Black,
                Some(Look::NotYet) | None => continue,
            };
            break;
        }
        Ok(self.end(stopped_by))
    }

    /// How they went until `stopped_by` ended them.
    pub fn end(&self, stopped_by: StoppedBy) -> Progressed {
        self.progress.finish();
        Progressed {
            passes: self.passes,
            seconds: self.start.elapsed().as_secs_f64(),
            stopped_by,
        }
    }
}
