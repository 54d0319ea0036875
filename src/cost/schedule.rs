//! How the budget is spent.

use super::error::{Errors, ImageError, rel_mse, relative_errors};
use super::estimator::{self, Estimator, NotApplicable};
use super::measures::{Point, time_spread};
use super::reference::{self, Reference, Source};
use super::runner::{Replicates, Runner, Seeds, prepare};
use super::{EqualTime, Progress, SceneCost, Settings};
use crate::error::{Error, GpuError};
use crate::gpu::Context;
use crate::render::Prepared;
use crate::scene::{Sampler, Scene, ShadowPattern, Strategy};

/// Part of the budget for a reference of one's own.
const REFERENCE_SHARE: f64 = 0.3;
/// Part of the budget for the images at equal time.
const EQUAL_TIME_SHARE: f64 = 0.1;
/// Images at every number of samples.
const REPLICATES: u32 = 2;
/// Most images at the largest number of samples.
const MAX_REPLICATES: usize = 64;
/// Fewest numbers of samples that a slope is told from: 1, 2 and 4.
const MIN_COUNTS: u32 = 3;
/// Logarithm of the largest number of samples.
const MAX_LOG_SAMPLES: u32 = 16;

/// All estimators of one scene, at work.
pub(super) struct Work<'a, 's> {
    pub(super) scene: &'s Scene,
    pub(super) settings: &'s Settings,
    pub(super) runners: Vec<Runner<'a>>,
    /// Renders the reference, where there is no other.
    pub(super) own: Option<Runner<'a>>,
    pub(super) not_applicable: Vec<NotApplicable>,
    pub(super) seeds: Seeds,
    /// Seconds of rendering so far.
    pub(super) spent: f64,
}

/// See [`super::measure`].
pub fn measure(
    context: &Context,
    scene: &Scene,
    settings: &Settings,
    progress: Progress<'_>,
) -> Result<SceneCost, Error> {
    let given = given_reference(scene, settings)?;
    let mut work = Work::compile(context, scene, settings, given.is_none(), progress)?;
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
        return Err(Error::Usage(format!(
            "{source}: the reference is black; relative errors need an image with light in it"
        )));
    }
    let curves = work.curves(&reference, progress)?;
    progress("images at equal time", work.spent);
    let (equal_seconds, equal) = work.equal_time(&reference)?;
    Ok(work.finish(reference, source, &curves, equal_seconds, equal))
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
    fn compile(
        context: &'a Context,
        scene: &'s Scene,
        settings: &'s Settings,
        own_reference: bool,
        progress: Progress<'_>,
    ) -> Result<Self, Error> {
        let mut work = Self {
            scene,
            settings,
            runners: Vec::new(),
            own: None,
            not_applicable: Vec::new(),
            seeds: Seeds::new(settings.seed),
            spent: 0.0,
        };
        let mut compiled = Vec::new();
        for &estimator in &settings.estimators {
            progress(&format!("compiling {estimator}"), 0.0);
            let prepared = match usable(scene, estimator, &compiled) {
                Ok(prepared) => prepared,
                Err(reason) => {
                    work.not_applicable
                        .push(NotApplicable { estimator, reason });
                    continue;
                }
            };
            compiled.push((estimator.effective(&prepared), estimator));
            let runner = Runner::new(context, &prepared, scene.film, estimator)?;
            work.runners.push(runner);
        }
        if work.runners.is_empty() {
            let reasons = work.not_applicable.iter();
            let reasons: Vec<_> = reasons
                .map(|n| format!("{}: {}", n.estimator, n.reason))
                .collect();
            return Err(Error::Usage(format!(
                "{}: no estimator is applicable: {}",
                scene.source.display(),
                reasons.join("; ")
            )));
        }
        if own_reference {
            let estimator = Estimator {
                strategy: Strategy::MisPower,
                light_selection: settings.estimators[0].light_selection,
                shadow_rays: 1,
                shadow_pattern: ShadowPattern::Random,
                sampler: Sampler::Sobol,
            };
            progress("compiling the reference", 0.0);
            let prepared = prepare(scene, estimator)?;
            work.own = Some(Runner::new(context, &prepared, scene.film, estimator)?);
        }
        Ok(work)
    }

    /// Renders one sample per pixel twice: the first run warms up, the second tells how fast each estimator is.
    fn pilot(&mut self) -> Result<(), GpuError> {
        for _ in 0..2 {
            for runner in self.runners.iter_mut().chain(&mut self.own) {
                self.spent += runner.run(self.seeds.draw(), 1)?.seconds;
            }
        }
        Ok(())
    }

    /// Seconds that one sample per pixel of all estimators takes.
    fn seconds_per_count(&self) -> f64 {
        self.runners.iter().map(|r| r.seconds_per_count).sum()
    }

    fn reference_budget(&self) -> f64 {
        let share = if self.own.is_some() {
            REFERENCE_SHARE
        } else {
            0.0
        };
        share * self.settings.budget
    }

    /// Seconds that the curves may take, together with what has been spent before them.
    fn curves_until(&self) -> f64 {
        (1.0 - EQUAL_TIME_SHARE) * self.settings.budget
    }

    /// Says what a result would need.
    fn check_budget(&self) -> Result<(), Error> {
        let samples = f64::from(REPLICATES) * f64::from((1_u32 << MIN_COUNTS) - 1);
        let curves = samples * self.seconds_per_count();
        let share = if self.own.is_some() {
            REFERENCE_SHARE
        } else {
            0.0
        };
        let mut needed = (self.spent + curves) / (1.0 - EQUAL_TIME_SHARE - share);
        if let Some(own) = &self.own {
            // Two halves of eight times as many samples as the curves' largest count.
            let largest = f64::from(1_u32 << (MIN_COUNTS - 1));
            needed = needed.max(16.0 * largest * own.seconds_per_count / REFERENCE_SHARE);
        }
        if needed <= self.settings.budget {
            return Ok(());
        }
        let size = self.scene.film;
        Err(Error::Usage(format!(
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
        )))
    }

    /// Two independent halves, of as many samples as the share pays for.
    fn render_reference(&mut self) -> Result<(Reference, Source), Error> {
        let budget = self.reference_budget();
        let runner = self.own.as_mut().expect("compiled when none is given");
        // More exact than the pilot, where what a run takes besides its samples counts.
        self.spent += runner.run(self.seeds.draw(), 8)?.seconds;
        let affordable = (0.5 * budget / runner.seconds_per_count).max(1.0) as u64;
        // Sobol's points are best in powers of two and sums of two neighbouring ones.
        let half = affordable.min(1 << 20);
        let half = half & (0b11 << half.ilog2().saturating_sub(1));
        let a = runner.run(self.seeds.draw(), half)?;
        let b = runner.run(self.seeds.draw(), half)?;
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

    /// Errors at growing numbers of samples; per estimator its points.
    fn curves(
        &mut self,
        reference: &Reference,
        progress: Progress<'_>,
    ) -> Result<Vec<Vec<Point>>, Error> {
        let mut finished: Vec<Vec<(Replicates, ImageError)>> =
            self.runners.iter().map(|_| Vec::new()).collect();
        let mut round = 0_usize;
        for log in 0..=MAX_LOG_SAMPLES {
            let samples = 1_u64 << log;
            let mut current = self.empty(samples);
            let doubled = |work: &Self| {
                work.seconds_per_count() * (f64::from(REPLICATES) * 2.0 * samples as f64)
            };
            for _ in 0..REPLICATES {
                progress(&format!("{samples} samples per pixel"), self.spent);
                self.turn(&mut current, reference, round)?;
                round += 1;
            }
            let last = log + 1 >= MIN_COUNTS
                && (self.spent + doubled(self) > self.curves_until() || log == MAX_LOG_SAMPLES);
            if last {
                self.fill_up(&mut current, reference, round, progress)?;
            }
            for (finished, mut current) in finished.iter_mut().zip(current) {
                let error = current.errors.finish(reference);
                // The sums are large, and done with.
                current.errors = Errors::new(self.scene.film, Sampler::BlueNoise);
                finished.push((current, error));
            }
            if last {
                break;
            }
        }
        Ok(finished.iter().map(|of_one| points(of_one)).collect())
    }

    /// Spends what is left for the curves on more images of the largest count.
    fn fill_up(
        &mut self,
        current: &mut [Replicates],
        reference: &Reference,
        mut round: usize,
        progress: Progress<'_>,
    ) -> Result<(), GpuError> {
        let samples = current[0].samples;
        for image in current[0].seconds.len() + 1..=MAX_REPLICATES {
            let next = self.seconds_per_count() * samples as f64;
            if self.spent + next > self.curves_until() {
                break;
            }
            progress(
                &format!("{samples} samples per pixel, image {image}"),
                self.spent,
            );
            self.turn(current, reference, round)?;
            round += 1;
        }
        Ok(())
    }

    fn empty(&self, samples: u64) -> Vec<Replicates> {
        let of = |runner: &Runner<'_>| Replicates {
            samples,
            seconds: Vec::new(),
            errors: Errors::new(self.scene.film, runner.estimator.sampler),
        };
        self.runners.iter().map(of).collect()
    }

    /// One image by every estimator; each turn begins with another.
    fn turn(
        &mut self,
        current: &mut [Replicates],
        reference: &Reference,
        round: usize,
    ) -> Result<(), GpuError> {
        let count = self.runners.len();
        for i in (0..count).map(|i| (i + round) % count) {
            let run = self.runners[i].run(self.seeds.draw(), current[i].samples)?;
            self.spent += run.seconds;
            current[i].seconds.push(run.seconds);
            current[i].errors.add(&run.film, reference);
        }
        Ok(())
    }

    /// One image by every estimator, all of about the same time.
    fn equal_time(&mut self, reference: &Reference) -> Result<(f64, Vec<EqualTime>), GpuError> {
        let share = EQUAL_TIME_SHARE * self.settings.budget / self.runners.len() as f64;
        let slowest = self.runners.iter().map(|r| r.seconds_per_count);
        let seconds = slowest.fold(share, f64::max);
        let mut images = Vec::new();
        for runner in &mut self.runners {
            let samples = (seconds / runner.seconds_per_count).round().max(1.0) as u64;
            let run = runner.run(self.seeds.draw(), samples)?;
            self.spent += run.seconds;
            images.push(EqualTime {
                samples,
                seconds: run.seconds,
                passes: run.passes,
                rays: run.rays,
                rays_per_second: run.rays.total() as f64 / run.seconds,
                rel_mse: rel_mse(&run.film, reference),
                relative_errors: relative_errors(&run.film, reference),
                film: run.film,
            });
        }
        Ok((seconds, images))
    }
}

/// The scene made ready for `estimator`, or why it is of no use there: `compiled` are those before, each after what it
/// comes to.
fn usable(
    scene: &Scene,
    estimator: Estimator,
    compiled: &[(Estimator, Estimator)],
) -> Result<Prepared, String> {
    let prepared = prepare(scene, estimator)
        .map_err(|e| format!("{}: {}; expected {}", e.field, e.problem, e.expected))?;
    if let Some(reason) = estimator::why_not(estimator.strategy, &prepared.emitters) {
        return Err(reason);
    }
    let effective = estimator.effective(&prepared);
    match compiled.iter().find(|(e, _)| *e == effective) {
        Some((_, first)) => Err(format!("on this scene the same as {first}")),
        None => Ok(prepared),
    }
}

/// One estimator's points: how its times scatter is told from all of them together.
fn points(measured: &[(Replicates, ImageError)]) -> Vec<Point> {
    let times: Vec<_> = measured.iter().map(|(r, _)| r.seconds.clone()).collect();
    let spread = time_spread(&times);
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
