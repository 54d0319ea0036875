//! How the budget is spent.

use super::error::{Errors, MeasuredError, mean_errors, relative_errors};
use super::estimator::NotApplicable;
use super::interrupted::Interrupted;
use super::measures::{Point, time_spread};
use super::reference::{self, Reference, Source};
use super::runner::{Replicates, Runner, Seeds};
use super::{EqualTime, Progress, SceneCost, Settings};
use direkt::error::Error;
use direkt::low_level::gpu::Context;
use direkt::low_level::prepare::SceneData;
use direkt::low_level::render::CacheBuster;
use direkt::scene::{Sampler, Scene};
use std::sync::Arc;

/// Part of the budget for a reference of one's own.
const REFERENCE_SHARE: f64 = 0.3;
/// Part of the budget for the images at equal time.
const EQUAL_TIME_SHARE: f64 = 0.1;
/// Images at every number of samples.
const REPLICATES: u32 = 2;
/// Most images at the largest number of samples.
const MAX_REPLICATES: usize = 64;
/// Most pilots that have to say that a budget is too small before it is refused.
const PILOTS: u32 = 5;
/// Fewest numbers of samples that a slope is told from: 1, 2 and 4.
const MIN_COUNTS: u32 = 3;
/// Largest number of samples.
const MAX_SAMPLES: u64 = 1 << 16;

/// All estimators of one scene, at work.
pub(super) struct Work<'a, 's> {
    pub(super) scene: &'s Scene,
    /// What all estimators share.
    pub(super) data: Arc<SceneData>,
    pub(super) settings: &'s Settings,
    pub(super) runners: Vec<Runner<'a>>,
    /// Renders the reference, where there is no other.
    pub(super) own: Option<Runner<'a>>,
    pub(super) not_applicable: Vec<NotApplicable>,
    pub(super) seeds: Seeds,
    pub(super) stamps: CacheBuster,
    /// Seconds of rendering so far.
    pub(super) spent: f64,
    /// Whether to end.
    pub(super) stop: &'s dyn Fn() -> bool,
}

/// What one estimator gave at growing numbers of samples.
type Finished = Vec<(Replicates, MeasuredError)>;

/// What a result is told from.
pub(super) struct Measured {
    /// Per estimator the points.
    pub(super) curves: Vec<Vec<Point>>,
    /// Per estimator and number of samples the seconds of each image.
    pub(super) times: Vec<Vec<Vec<f64>>>,
    /// Seconds that an image at equal time takes.
    pub(super) equal_seconds: f64,
    /// Per estimator the image; none once it was interrupted.
    pub(super) equal_time: Vec<Option<EqualTime>>,
    /// Whether it was.
    pub(super) interrupted: bool,
}

/// See [`super::measure`].
pub fn measure(
    context: &Context,
    scene: &Scene,
    settings: &Settings,
    progress: Progress<'_>,
    stop: &dyn Fn() -> bool,
) -> Result<SceneCost, Interrupted> {
    let given = given_reference(scene, settings)?;
    let mut work = Work::new(scene, settings, stop);
    work.compile(context, given.is_none(), progress)?;
    // The first run warms up.
    work.pilot()?;
    work.pilot()?;
    work.check_budget()?;
    let (reference, source) = match given {
        Some(given) => given,
        None => {
            progress("reference", work.spent);
            work.render_reference()?
        }
    };
    if reference.is_black() {
        let source = scene.source.display();
        let message = format!(
            "{source}: the reference is black; relative errors need an image with light in it"
        );
        return Err(Error::Usage(message).into());
    }
    let measured = work.measure(&reference, progress)?;
    Ok(work.finish(reference, source, measured))
}

/// The reference that there is before anything is rendered.
fn given_reference(
    scene: &Scene,
    settings: &Settings,
) -> Result<Option<(Reference, Source)>, Error> {
    match &settings.reference {
        None => Ok(reference::stated(scene)),
        Some(path) => {
            let source = Source::File {
                path: path.display().to_string(),
            };
            Ok(Some((reference::from_file(path, scene.film)?, source)))
        }
    }
}

impl<'a, 's> Work<'a, 's> {
    fn new(scene: &'s Scene, settings: &'s Settings, stop: &'s dyn Fn() -> bool) -> Self {
        Self {
            scene,
            data: Arc::new(SceneData::new(scene.clone())),
            settings,
            runners: Vec::new(),
            own: None,
            not_applicable: Vec::new(),
            seeds: Seeds::new(settings.seed),
            stamps: CacheBuster::now(),
            spent: 0.0,
            stop,
        }
    }

    /// Renders one sample per pixel, which tells how fast each estimator is.
    fn pilot(&mut self) -> Result<(), Interrupted> {
        for runner in self.runners.iter_mut().chain(&mut self.own) {
            self.spent += runner.run(self.seeds.draw(), 1, self.stop)?.seconds;
        }
        Ok(())
    }

    /// Seconds that one sample per pixel of all estimators takes.
    fn seconds_per_count(&self) -> f64 {
        self.runners.iter().map(|r| r.seconds_per_count).sum()
    }

    /// Part of the budget for the reference.
    fn reference_share(&self) -> f64 {
        if self.own.is_some() {
            REFERENCE_SHARE
        } else {
            0.0
        }
    }

    /// Seconds that the curves may take, together with what has been spent before them.
    fn curves_until(&self) -> f64 {
        (1.0 - EQUAL_TIME_SHARE) * self.settings.budget
    }

    /// Says what a result would need, where the budget pays for it by none of several pilots: what
    /// else a machine does makes a pilot slower, never faster.
    fn check_budget(&mut self) -> Result<(), Interrupted> {
        let mut needed = self.needed();
        for _ in 1..PILOTS {
            if needed > self.settings.budget {
                self.pilot()?;
                needed = needed.min(self.needed());
            }
        }
        if needed <= self.settings.budget {
            return Ok(());
        }
        let size = self.scene.film;
        let message = format!(
            "--budget {}: {} needs at least about {} for {} estimators at {} × {} pixels (1, 2 and 4 samples per pixel \
             twice each, the reference, images at equal time); give that, or fewer --strategies and --samplers, or a \
             smaller --size",
            duration(self.settings.budget),
            self.scene.source.display(),
            // A pilot run is only so exact.
            duration((1.3 * needed).ceil()),
            self.runners.len(),
            size.width,
            size.height,
        );
        Err(Error::Usage(message).into())
    }

    /// Seconds that a result needs, as fast as the estimators were in the latest pilot.
    fn needed(&self) -> f64 {
        let per_count = self.seconds_per_count();
        let own = self.own.as_ref().map_or(0.0, |own| own.seconds_per_count);
        let pilots = 2.0 * (per_count + own);
        let curves = f64::from(REPLICATES) * f64::from((1_u32 << MIN_COUNTS) - 1) * per_count;
        let share = 1.0 - EQUAL_TIME_SHARE - self.reference_share();
        // Two halves of eight times as many samples as the curves' largest count.
        let reference = 16.0 * f64::from(1_u32 << (MIN_COUNTS - 1)) * own;
        ((pilots + curves) / share).max(reference / REFERENCE_SHARE)
    }

    /// Two independent halves, of as many samples as the share pays for.
    fn render_reference(&mut self) -> Result<(Reference, Source), Interrupted> {
        let budget = self.reference_share() * self.settings.budget;
        let runner = self.own.as_mut().expect("compiled when none is given");
        // More exact than the pilot, where what a run takes besides its samples counts.
        self.spent += runner.run(self.seeds.draw(), 8, self.stop)?.seconds;
        let affordable = (0.5 * budget / runner.seconds_per_count).max(1.0) as u64;
        // Sobol's points are best in powers of two and sums of two neighbouring ones.
        let half = affordable.min(1 << 20);
        let half = half & (0b11 << half.ilog2().saturating_sub(1));
        let a = runner.run(self.seeds.draw(), half, self.stop)?;
        let b = runner.run(self.seeds.draw(), half, self.stop)?;
        let seconds = a.seconds + b.seconds;
        let source = Source::OwnRun {
            estimator: runner.estimator,
            samples: 2 * half,
            seconds,
        };
        self.spent += seconds;
        self.own = None;
        Ok((Reference::from_halves(&a.film, &b.film), source))
    }

    /// The curves, then the images at equal time: as far as it gets.
    fn measure(
        &mut self,
        reference: &Reference,
        progress: Progress<'_>,
    ) -> Result<Measured, Interrupted> {
        let (finished, mut interrupted) = self.curves(reference, progress)?;
        let times: Vec<_> = finished.iter().map(|of_one| times(of_one)).collect();
        let share = EQUAL_TIME_SHARE * self.settings.budget / self.runners.len() as f64;
        let slowest = self.runners.iter().map(|r| r.seconds_per_count);
        let equal_seconds = slowest.fold(share, f64::max);
        progress("images at equal time", self.spent);
        let mut equal_time = Vec::new();
        for i in 0..self.runners.len() {
            let image = match self.equal_time(i, equal_seconds, reference) {
                Ok(image) => Some(image),
                Err(Interrupted::Stopped) => None,
                Err(failed) => return Err(failed),
            };
            interrupted |= image.is_none();
            equal_time.push(image);
        }
        let curves = finished.iter().zip(&times);
        Ok(Measured {
            curves: curves
                .map(|(of_one, times)| points(of_one, times))
                .collect(),
            times,
            equal_seconds,
            equal_time,
            interrupted,
        })
    }

    /// Errors at growing numbers of samples, per estimator; and whether it was interrupted.
    fn curves(
        &mut self,
        reference: &Reference,
        progress: Progress<'_>,
    ) -> Result<(Vec<Finished>, bool), Interrupted> {
        let mut finished: Vec<Finished> = self.runners.iter().map(|_| Vec::new()).collect();
        let (mut samples, mut turns) = (1, 0);
        loop {
            let mut current = self.empty(samples);
            let next = self.count(&mut current, reference, &mut turns, progress);
            let interrupted = matches!(next, Err(Interrupted::Stopped));
            let complete = |of_one: &Replicates| of_one.errors.replicates() >= REPLICATES;
            if current.iter().all(complete) {
                for (finished, mut current) in finished.iter_mut().zip(current) {
                    let error = current.errors.finish(reference);
                    // The sums are large, and done with.
                    current.errors = Errors::new(self.scene.film, Sampler::BlueNoise);
                    finished.push((current, error));
                }
            }
            if interrupted && finished[0].len() < MIN_COUNTS as usize {
                return Err(Interrupted::Stopped);
            }
            if interrupted || !next? {
                return Ok((finished, interrupted));
            }
            samples *= 2;
        }
    }

    /// Images of one number of samples: as many as there have to be, and where the budget does not
    /// pay for twice that number, as many as it pays for. Whether it does.
    fn count(
        &mut self,
        current: &mut [Replicates],
        reference: &Reference,
        turns: &mut usize,
        progress: Progress<'_>,
    ) -> Result<bool, Interrupted> {
        let samples = current[0].samples;
        for _ in 0..REPLICATES {
            progress(&format!("{samples} samples per pixel"), self.spent);
            self.turn(current, reference, turns)?;
        }
        let doubled = f64::from(REPLICATES) * 2.0 * samples as f64 * self.seconds_per_count();
        let affordable = self.spent + doubled <= self.curves_until();
        if samples < 1 << (MIN_COUNTS - 1) || affordable && samples < MAX_SAMPLES {
            return Ok(true);
        }
        for image in current[0].seconds.len() + 1..=MAX_REPLICATES {
            let next = self.seconds_per_count() * samples as f64;
            if self.spent + next > self.curves_until() {
                break;
            }
            let what = format!("{samples} samples per pixel, image {image}");
            progress(&what, self.spent);
            self.turn(current, reference, turns)?;
        }
        Ok(false)
    }

    /// An image by estimator `i` of about `seconds`.
    fn equal_time(
        &mut self,
        i: usize,
        seconds: f64,
        reference: &Reference,
    ) -> Result<EqualTime, Interrupted> {
        let runner = &mut self.runners[i];
        let samples = (seconds / runner.seconds_per_count).round().max(1.0) as u64;
        let run = runner.run(self.seeds.draw(), samples, self.stop)?;
        self.spent += run.seconds;
        Ok(EqualTime {
            samples,
            seconds: run.seconds,
            passes: run.passes,
            rays: run.rays,
            rays_per_second: run.rays.total() as f64 / run.seconds,
            rel_mse: mean_errors(&run.film, reference)[1],
            relative_errors: relative_errors(&run.film, reference),
            film: run.film,
        })
    }
}

/// One estimator's seconds of each image.
fn times(measured: &[(Replicates, MeasuredError)]) -> Vec<Vec<f64>> {
    measured.iter().map(|(r, _)| r.seconds.clone()).collect()
}

/// One estimator's points: how its times scatter is told from all of them together.
fn points(measured: &[(Replicates, MeasuredError)], times: &[Vec<f64>]) -> Vec<Point> {
    let spread = time_spread(times);
    let point = |(r, error): &(Replicates, _)| Point::new(r.samples, &r.seconds, spread, *error);
    measured.iter().map(point).collect()
}

/// Seconds as a person writes them.
fn duration(seconds: f64) -> String {
    if seconds < 120.0 {
        format!("{seconds}s")
    } else {
        format!("{:.0}m", (seconds / 60.0).ceil())
    }
}
