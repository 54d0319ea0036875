//! The passes of a render, until something ends them.

use super::goal::{ErrorGoal, ErrorMonitor, Verdict};
use super::session::{Session, StopReason};
use crate::error::GpuError;
use crate::scene::RenderSettings;
use std::time::{Duration, Instant};

/// What ended a render.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
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

/// The passes of one render, on one device or on several that follow each other, until samples,
/// time or error are what its settings ask for.
#[derive(Debug, Clone)]
pub struct Passes {
    spp: u64,
    time: Option<Duration>,
    monitor: Option<ErrorMonitor>,
    start: Instant,
    taken: u64,
}

impl Passes {
    /// Those of a render by `settings`, whose time begins now.
    pub fn new(settings: &RenderSettings) -> Self {
        let goal = settings.stop.error.map(|relative| ErrorGoal {
            metric: settings.stop.error_metric,
            relative,
            confidence: settings.stop.confidence,
        });
        Self {
            spp: settings.stop.spp,
            time: settings.stop.time.map(duration),
            monitor: goal.map(ErrorMonitor::new),
            start: Instant::now(),
            taken: 0,
        }
    }

    /// Passes taken so far.
    pub fn taken(&self) -> u64 {
        self.taken
    }

    /// Time since the first could begin.
    pub fn elapsed(&self) -> Duration {
        self.start.elapsed()
    }

    /// Takes one pass, which [`judge`](Self::judge) may follow, unless there is nothing left to do.
    /// The first is finished whatever the time, so that there is an image; `interrupted` is asked
    /// between dispatches.
    ///
    /// # Errors
    /// The driver fails.
    pub fn take(
        &mut self,
        session: &mut Session<'_>,
        interrupted: impl Fn() -> bool,
    ) -> Result<Option<StoppedBy>, GpuError> {
        if session.samples() >= self.spp {
            return Ok(Some(StoppedBy::Samples));
        }
        let until = self.monitor.map_or(self.spp, |w| self.spp.min(w.next()));
        let samples = session.pass_samples(until.saturating_sub(session.samples()));
        let first = session.samples() == 0;
        let (time, start) = (self.time, self.start);
        let out_of_time = || !first && time.is_some_and(|t| start.elapsed() >= t);
        let stop = || interrupted() || out_of_time();
        if session.pass(samples, stop)? == StopReason::Interrupted {
            return Ok(Some(if interrupted() {
                StoppedBy::Interrupt
            } else {
                StoppedBy::Time
            }));
        }
        self.taken += 1;
        Ok(None)
    }

    /// Whether the error of the image so far ends the render.
    ///
    /// # Errors
    /// The driver fails.
    pub fn judge(&mut self, session: &Session<'_>) -> Result<Option<StoppedBy>, GpuError> {
        let verdict = self
            .monitor
            .as_mut()
            .map(|w| w.verdict(session))
            .transpose()?;
        Ok(match verdict {
            Some(Verdict::Reached) => Some(StoppedBy::Error),
            Some(Verdict::Black) => Some(StoppedBy::Black),
            Some(Verdict::NotYet) | None => None,
        })
    }
}
