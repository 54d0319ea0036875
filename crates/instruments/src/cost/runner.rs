//! Renders of one estimator, and the clock.

use super::effects::Agreement;
use super::error::Errors;
use super::estimator::Estimator;
use super::interrupted::Interrupted;
use direkt::error::{GpuError, InputError};
use direkt::low_level::effects::Effect;
use direkt::low_level::gpu::Context;
use direkt::low_level::prepare::{Prepared, SceneData};
use direkt::low_level::render::goal::{ErrorMonitor, Verdict};
use direkt::low_level::render::{ErrorGoal, Film, RayCounts, Session, StopReason};
use direkt::scene::{FilmSize, RenderSettings, Scene, validate};
use std::sync::Arc;
use std::time::Instant;

/// Seeds that differ from each other, all derived from one.
#[derive(Debug)]
pub struct Seeds {
    base: u32,
    next: u32,
}

impl Seeds {
    /// Seeds derived from `base`.
    pub fn new(base: u32) -> Self {
        Self { base, next: 0 }
    }

    /// The next one: a bijection of a counter, so that none comes twice.
    pub fn draw(&mut self) -> u32 {
        self.next += 1;
        // The finalizer of MurmurHash3 (Appleby 2011).
        let mut x = self.next;
        x = (x ^ (x >> 16)).wrapping_mul(0x85eb_ca6b);
        x = (x ^ (x >> 13)).wrapping_mul(0xc2b2_ae35);
        (x ^ (x >> 16)).wrapping_add(self.base)
    }
}

/// An image and what it took.
#[derive(Debug)]
pub struct Run {
    /// The image.
    pub film: Film,
    /// Rays traced.
    pub rays: RayCounts,
    /// Seconds between the first dispatch and the end of the last: neither compiling nor reading
    /// the image is in it.
    pub seconds: f64,
    /// Passes over the image.
    pub passes: u64,
    /// Samples per pixel.
    pub samples: u64,
}

/// An estimator that is compiled and ready.
#[derive(Debug)]
pub struct Runner<'a> {
    /// The estimator.
    pub estimator: Estimator,
    session: Session<'a>,
    /// Why its images do not converge to direct lighting; none where they do.
    pub biased: Option<String>,
    /// Seconds that compiling took.
    pub compile_seconds: f64,
    /// Primitives of the scene.
    pub primitives: usize,
    /// Seconds per sample of every pixel, by the latest run.
    pub seconds_per_count: f64,
    /// Samples that were not finite and were dropped.
    pub dropped: u64,
    /// Unneeded effects.
    pub without_need: Vec<Effect>,
    /// Whether its images are those that it gives without them.
    pub agreement: Agreement,
}

impl<'a> Runner<'a> {
    /// Compiles `estimator` for what `prepared` was made from; anew where there is a `stamp`, as
    /// [`Session::compiled_anew`] says.
    ///
    /// # Errors
    /// The scene is too large for the adapter, or the driver fails.
    pub fn new(
        context: &'a Context,
        mut prepared: Prepared,
        size: FilmSize,
        estimator: Estimator,
        stamp: Option<u32>,
    ) -> Result<Self, GpuError> {
        let without_need = estimator.effects.without_need(&prepared.effects);
        for &effect in &without_need {
            prepared.effects.force(effect);
        }
        let session = match stamp {
            Some(stamp) => Session::compiled_anew(context, &prepared, size, 0, stamp)?,
            None => Session::new(context, &prepared, size, 0)?,
        };
        Ok(Self {
            estimator,
            compile_seconds: session.compile_seconds,
            session,
            biased: prepared.bias(),
            primitives: prepared.data.primitives.len(),
            seconds_per_count: f64::INFINITY,
            dropped: 0,
            without_need,
            agreement: Agreement::default(),
        })
    }

    /// Renders until the image's error is below `goal`, or the image counts as black; `None` where
    /// that takes more than `most` samples per pixel.
    ///
    /// # Errors
    /// It was stopped, or the driver fails.
    pub fn run_to(
        &mut self,
        seed: u32,
        goal: ErrorGoal,
        most: u64,
        stop: &dyn Fn() -> bool,
    ) -> Result<Option<Run>, Interrupted> {
        let (mut monitor, mut reached) = (ErrorMonitor::new(goal), false);
        let run = self.run_while(seed, u64::MAX, stop, |session| {
            reached = monitor.verdict(session)? != Verdict::NotYet;
            let goes_on = !reached && session.samples() < most;
            Ok(goes_on.then(|| monitor.next().min(most)))
        })?;
        Ok(reached.then_some(run))
    }

    /// Renders `samples` samples of every pixel, unless `stop` asks to end before.
    ///
    /// # Errors
    /// It was stopped, or the driver fails.
    pub fn run(
        &mut self,
        seed: u32,
        samples: u64,
        stop: &dyn Fn() -> bool,
    ) -> Result<Run, Interrupted> {
        self.run_while(seed, samples, stop, |session| {
            Ok((session.samples() < samples).then_some(samples))
        })
    }

    /// Renders with patterns for `planned` samples per pixel as long as `due` tells how many there
    /// are to be.
    fn run_while(
        &mut self,
        seed: u32,
        planned: u64,
        stop: &dyn Fn() -> bool,
        mut due: impl FnMut(&Session<'_>) -> Result<Option<u64>, GpuError>,
    ) -> Result<Run, Interrupted> {
        let session = &mut self.session;
        session.restart(seed, planned)?;
        let start = Instant::now();
        let mut passes = 0;
        while let Some(until) = due(session)? {
            let pass = session.pass_samples(until - session.samples());
            if session.pass(pass, stop)? == StopReason::Interrupted {
                return Err(Interrupted::Stopped);
            }
            passes += 1;
        }
        let seconds = start.elapsed().as_secs_f64();
        let (film, rays) = session.snapshot()?;
        let samples = session.samples();
        self.dropped += film.ledger.dropped;
        self.seconds_per_count = seconds / samples as f64;
        Ok(Run {
            film,
            rays,
            seconds,
            passes,
            samples,
        })
    }
}

/// The replicates of one estimator at one number of samples.
#[derive(Debug, Clone)]
pub struct Replicates {
    /// Samples per pixel.
    pub samples: u64,
    /// Seconds of each.
    pub seconds: Vec<f64>,
    /// Their squared errors.
    pub errors: Errors,
}

/// `data` made ready for `estimator`, with the effects that it calls for; all else as `scene` says,
/// which `data` was made of.
///
/// # Errors
/// It has too many lights for the estimator.
pub fn prepare(
    scene: &Scene,
    data: &Arc<SceneData>,
    estimator: Estimator,
) -> Result<Prepared, InputError> {
    let settings = RenderSettings {
        estimator: estimator.settings,
        ..scene.render
    };
    validate::settings(scene, &settings)?;
    Ok(Prepared::new(data, settings))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_seed_comes_twice() {
        let mut seeds = Seeds::new(7);
        let mut all: Vec<u32> = (0..100_000).map(|_| seeds.draw()).collect();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), 100_000);
    }
}
