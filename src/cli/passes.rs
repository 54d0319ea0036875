//! The passes of a render, until something ends them.

use super::interrupt::Interrupt;
use super::progress::Progress;
use crate::error::Error;
use crate::render::goal::{ErrorGoal, Look, Watch};
use crate::render::{Session, StopReason};
use crate::scene::Scene;
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

/// Takes passes until the samples, the time or the user's patience run out, or the image is right enough.
pub fn take_passes(
    session: &mut Session<'_>,
    scene: &Scene,
    quiet: bool,
) -> Result<Progressed, Error> {
    let settings = scene.render;
    let interrupt = Interrupt::listen();
    let time = settings.time.map(Duration::from_secs_f64);
    let mut progress = Progress::new(settings.spp, time, quiet);
    let start = Instant::now();
    let goal = settings.error.map(|relative| ErrorGoal {
        relative,
        confidence: settings.confidence,
    });
    let mut watch = goal.map(Watch::new);
    let mut passes = 0;
    let mut stopped_by = StoppedBy::Samples;
    while session.samples() < settings.spp {
        let until = watch.map_or(settings.spp, |w| settings.spp.min(w.next()));
        let samples = session.pass_samples(until - session.samples());
        // The first pass is finished whatever the time, so that there is an image.
        let first = session.samples() == 0;
        let out_of_time = || !first && time.is_some_and(|t| start.elapsed() >= t);
        let stop = || interrupt.came() || out_of_time();
        if session.pass(samples, stop)? == StopReason::Interrupted {
            stopped_by = if interrupt.came() {
                StoppedBy::Interrupt
            } else {
                StoppedBy::Time
            };
            break;
        }
        passes += 1;
        progress.update(session, passes, scene.film.pixels())?;
        let look = watch.as_mut().map(|w| w.look(session)).transpose()?;
        stopped_by = match look {
            Some(Look::Reached) => StoppedBy::Error,
            Some(Look::Black) => StoppedBy::Black,
            Some(Look::NotYet) | None => continue,
        };
        break;
    }
    progress.finish();
    Ok(Progressed {
        passes,
        seconds: start.elapsed().as_secs_f64(),
        stopped_by,
    })
}
