//! What each unneeded effect costs: compile time, and time per sample.
//!
//! The kernel that the scene calls for, kernels with one further effect each, and one with all that
//! can be compiled in take turns. In every round each is compiled anew; then they render the same
//! samples, one after the other, several times. Because they take turns, a machine that slows down
//! slows them all alike, and each turn gives a ratio by itself. Effects that are ways of sampling
//! cannot be forced, for they change the image's noise.

use super::sample::Rays;
use super::shader::ShaderSize;
use crate::cost::interrupted::Interrupted;
use crate::cost::{Interval, Progress};
use direkt::error::{Error, GpuError};
use direkt::low_level::effects::{Effect, Effects};
use direkt::low_level::gpu::Context;
use direkt::low_level::prepare::Prepared;
use direkt::low_level::render::{CacheBuster, RayCounts, Session, StopReason};
use direkt::low_level::stats::interval::student_95;
use direkt::low_level::stats::moments::Moments;
use direkt::scene::FilmSize;
use serde::Serialize;
use std::time::Instant;

/// Seconds of rendering by one kernel in one turn.
const SLICE: f64 = 0.1;
/// Turns of rendering in one round, at least and at most.
const TURNS: std::ops::RangeInclusive<usize> = 4..=32;
/// Rounds at least: without two there is no interval, and of two it is wide.
const MIN_ROUNDS: usize = 3;
/// Samples per pixel of one run at most.
const MAX_SAMPLES: u64 = 256;
/// Pixels of the image at most: all kernels keep theirs at the same time.
const MAX_PIXELS: f64 = 65_536.0;

/// The price of one kernel.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Price {
    /// `called for`, `+` and the name of one effect, or `all together`.
    pub kernel: String,
    /// Its size.
    #[serde(flatten)]
    pub size: ShaderSize,
    /// Seconds of linking and compiling, the driver's part included.
    pub compile_seconds: Interval,
    /// Seconds per sample of one pixel.
    pub sample_seconds: Interval,
    /// Samples of one pixel per second.
    pub samples_per_second: f64,
    /// Compile time over that of what is called for.
    pub compile_ratio: Interval,
    /// Time per sample over that of what is called for.
    pub sample_ratio: Interval,
}

/// What was measured.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Prices {
    /// Pixels per row of the image that was rendered: the scene's, or a smaller one of its aspect.
    pub width: u32,
    /// Its rows.
    pub height: u32,
    /// Rounds that were finished, in each of which every kernel was compiled once.
    pub rounds: usize,
    /// Images by every kernel.
    pub turns: usize,
    /// Seconds that they took.
    pub seconds: f64,
    /// Whether it ended before its time.
    pub interrupted: bool,
    /// Samples per pixel of every run.
    pub samples: u64,
    /// Rays per sample, measured.
    pub rays_per_sample: Rays,
    /// The kernels: what is called for first, all together last.
    pub kernels: Vec<Price>,
}

/// A kernel and what was measured of it, round by round.
#[derive(Debug)]
struct Candidate<'a> {
    name: String,
    effects: Effects,
    session: Option<Session<'a>>,
    compile: Vec<f64>,
    sample: Vec<f64>,
}

/// Measures what those of `effects` cost that can be forced and are not called for, for about
/// `budget` seconds, compiling included, and three rounds at least. Once `stop` says so, it ends
/// with the
/// rounds that are finished; with nothing where none is.
///
/// # Errors
/// The driver fails.
pub fn measure(
    context: &Context,
    prepared: &mut Prepared,
    (effects, budget): (&[Effect], f64),
    progress: Progress<'_>,
    stop: &dyn Fn() -> bool,
) -> Result<Option<Prices>, Error> {
    let called_for = prepared.effects.clone();
    let mut rounds = Rounds {
        context,
        film: measured_film(prepared.film),
        seed: prepared.settings.seed,
        prepared,
        candidates: candidates(&called_for, effects),
        samples: 1,
        stamps: CacheBuster::now(),
        stop,
    };
    let outcome = rounds.run(budget, progress);
    rounds.prepared.effects = called_for;
    match outcome {
        Ok(prices) => Ok(prices),
        Err(Interrupted::Stopped) => Ok(None),
        Err(Interrupted::Failed(error)) => Err(error),
    }
}

/// `film`, or where it is large a smaller one of its aspect.
fn measured_film(film: FilmSize) -> FilmSize {
    let scale = (MAX_PIXELS / film.pixels() as f64).sqrt().min(1.0);
    let side = |length: u32| ((f64::from(length) * scale).round() as u32).max(1);
    FilmSize {
        width: side(film.width),
        height: side(film.height),
    }
}

/// What is called for, each of `effects` with it, and all of them.
fn candidates<'a>(called_for: &Effects, effects: &[Effect]) -> Vec<Candidate<'a>> {
    let candidate = |name: String, effects: Effects| Candidate {
        name,
        effects,
        session: None,
        compile: Vec::new(),
        sample: Vec::new(),
    };
    let forced = effects.iter().copied().filter(|e| called_for.can_force(*e));
    let with = |effects: &Effects, effect: Effect| {
        let mut effects = effects.clone();
        effects.force(effect);
        effects
    };
    let mut all = vec![candidate("called for".to_owned(), called_for.clone())];
    let mut everything = called_for.clone();
    for effect in forced {
        let name = format!("+ {}", effect.name());
        all.push(candidate(name, with(called_for, effect)));
        everything = with(&everything, effect);
    }
    if all.len() > 2 {
        all.push(candidate("all together".to_owned(), everything));
    }
    all
}

/// The rounds at work.
struct Rounds<'a, 's> {
    context: &'a Context,
    prepared: &'s mut Prepared,
    film: FilmSize,
    seed: u32,
    candidates: Vec<Candidate<'a>>,
    /// Samples per pixel of every run.
    samples: u64,
    stamps: CacheBuster,
    stop: &'s dyn Fn() -> bool,
}

impl Rounds<'_, '_> {
    fn run(&mut self, budget: f64, progress: Progress<'_>) -> Result<Option<Prices>, Interrupted> {
        let start = Instant::now();
        let spent = || start.elapsed().as_secs_f64();
        let mut rounds = 0;
        while rounds < MIN_ROUNDS || spent() < budget {
            progress(&format!("round {}", rounds + 1), spent().min(budget));
            match self.round(rounds) {
                Ok(()) => rounds += 1,
                Err(Interrupted::Stopped) => break,
                Err(failed) => return Err(failed),
            }
        }
        // What every kernel did: Ctrl-C may have come in the middle of a round.
        let compiled = self.candidates.iter().map(|c| c.compile.len()).min();
        let turns = self.candidates.iter().map(|c| c.sample.len()).min();
        let (Some(compiled @ 1..), Some(turns @ 1..)) = (compiled, turns) else {
            return Ok(None);
        };
        Ok(Some(Prices {
            width: self.film.width,
            height: self.film.height,
            rounds: compiled,
            turns,
            seconds: spent(),
            interrupted: (self.stop)(),
            samples: self.samples,
            rays_per_sample: self.rays()?,
            kernels: self.prices(compiled, turns)?,
        }))
    }

    /// Compiles every kernel once, then renders by all of them in turn for as long; each round
    /// begins with another kernel.
    fn round(&mut self, round: usize) -> Result<(), Interrupted> {
        let start = Instant::now();
        let count = self.candidates.len();
        for i in (0..count).map(|i| (i + round) % count) {
            self.compile(i)?;
        }
        let compiling = start.elapsed();
        let start = Instant::now();
        let mut turns = 0;
        while turns < *TURNS.start() || (turns < *TURNS.end() && start.elapsed() < compiling) {
            for i in (0..count).map(|i| (i + round + turns) % count) {
                self.render(i)?;
            }
            turns += 1;
        }
        Ok(())
    }

    /// Compiles kernel `i` anew, and lets it find out how much fits a dispatch.
    fn compile(&mut self, i: usize) -> Result<(), Interrupted> {
        if (self.stop)() {
            return Err(Interrupted::Stopped);
        }
        self.prepared.effects = self.candidates[i].effects.clone();
        let place = (self.film, self.seed, self.stamps.draw());
        let mut session =
            Session::compiled_anew(self.context, self.prepared, place.0, place.1, place.2)?;
        advance(&mut session, 1, self.stop)?;
        if self.candidates.iter().all(|c| c.sample.is_empty()) {
            let start = Instant::now();
            advance(&mut session, 1, self.stop)?;
            let fit = SLICE / start.elapsed().as_secs_f64();
            self.samples = (fit.round() as u64).clamp(1, MAX_SAMPLES);
        }
        let candidate = &mut self.candidates[i];
        candidate.compile.push(session.compile_seconds);
        candidate.session = Some(session);
        Ok(())
    }

    /// Renders by kernel `i`.
    fn render(&mut self, i: usize) -> Result<(), Interrupted> {
        let candidate = &mut self.candidates[i];
        let Some(session) = &mut candidate.session else {
            return Ok(());
        };
        session.restart(self.seed, self.prepared.settings.stop.spp)?;
        let start = Instant::now();
        advance(session, self.samples, self.stop)?;
        let seconds = start.elapsed().as_secs_f64() / self.samples as f64;
        candidate.sample.push(seconds);
        Ok(())
    }

    /// Rays per sample of what is called for.
    fn rays(&self) -> Result<Rays, GpuError> {
        let session = self.candidates[0].session.as_ref();
        let rays = session.map_or_else(|| Ok(RayCounts::default()), |s| Ok(s.snapshot()?.1))?;
        let samples = rays.camera.max(1) as f64;
        Ok(Rays {
            camera: 1.0,
            shadow: rays.shadow as f64 / samples,
            bsdf: rays.bsdf as f64 / samples,
        })
    }

    fn prices(&self, compiled: usize, turns: usize) -> Result<Vec<Price>, GpuError> {
        let pixels = self.film.pixels() as f64;
        let called_for = &self.candidates[0];
        let ratio = |a: &[f64], b: &[f64], count| {
            let ratios = a.iter().zip(b).map(|(a, b)| a / b);
            geometric_mean(ratios.take(count))
        };
        let price = |c: &Candidate<'_>| {
            let per_count = geometric_mean(c.sample.iter().copied().take(turns));
            let wgsl = c.session.as_ref().map_or("", Session::wgsl);
            Ok(Price {
                kernel: c.name.clone(),
                size: ShaderSize::of(wgsl)?,
                compile_seconds: geometric_mean(c.compile.iter().copied().take(compiled)),
                sample_seconds: per_count.scaled(1.0 / pixels),
                samples_per_second: pixels / per_count.value,
                compile_ratio: ratio(&c.compile, &called_for.compile, compiled),
                sample_ratio: ratio(&c.sample, &called_for.sample, turns),
            })
        };
        self.candidates.iter().map(price).collect()
    }
}

/// Takes every pixel `samples` further.
fn advance(
    session: &mut Session<'_>,
    samples: u64,
    stop: &dyn Fn() -> bool,
) -> Result<(), Interrupted> {
    let until = session.samples() + samples;
    while session.samples() < until {
        let pass = session.pass_samples(until - session.samples());
        if session.pass(pass, stop)? == StopReason::Interrupted {
            return Err(Interrupted::Stopped);
        }
    }
    Ok(())
}

/// The geometric mean of positive values with its 95 % interval, by Student's distribution of their
/// logarithms; a single one bounds nothing.
fn geometric_mean(values: impl Iterator<Item = f64>) -> Interval {
    let logarithms: Moments = values.map(f64::ln).collect();
    let value = logarithms.mean.exp();
    let Some(variance) = logarithms.variance_of_mean() else {
        return Interval {
            value,
            low: 0.0,
            high: f64::INFINITY,
        };
    };
    let factor = (student_95(logarithms.count as f64 - 1.0) * variance.sqrt()).exp();
    Interval {
        value,
        low: value / factor,
        high: value * factor,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_are_of_ratios() {
        let mean = geometric_mean([2.0, 8.0].into_iter());
        assert!((mean.value - 4.0).abs() < 1e-12);
        // The logarithms are ln 4 ∓ ln 2, the mean's standard error is ln 2, and Student's quantile
        // 12.7062.
        assert!((mean.high / 4.0).ln() / 2.0_f64.ln() - 12.706_2 < 1e-3);
        assert!((mean.low * mean.high - 16.0).abs() < 1e-9);
        let one = geometric_mean([3.0].into_iter());
        assert!((one.value - 3.0).abs() < 1e-12 && one.high.is_infinite());
    }

    #[test]
    fn large_films_are_measured_small() {
        let film = |width, height| FilmSize { width, height };
        assert_eq!(measured_film(film(300, 200)), film(300, 200));
        assert_eq!(measured_film(film(2048, 512)), film(512, 128));
        assert_eq!(measured_film(film(32_768, 1)), film(32_768, 1));
    }

    #[test]
    fn each_further_effect_is_forced_alone_and_with_all() {
        let mut called_for = Effects::default();
        called_for.call_for(Effect::Spheres, || "a sphere".to_owned());
        let all = candidates(&called_for, Effect::ALL);
        assert_eq!(all[0].effects, called_for);
        let everything = &all[all.len() - 1];
        for candidate in &all[1..all.len() - 1] {
            assert_eq!(candidate.effects.iter().count(), 2, "{}", candidate.name);
            let effects = candidate.effects.iter();
            assert!(
                effects
                    .map(|(e, _)| e)
                    .all(|e| everything.effects.contains(e))
            );
        }
        assert_eq!(everything.effects.iter().count(), all.len() - 1);
        assert!(everything.effects.contains(Effect::EnvironmentMap));
        assert!(!everything.effects.contains(Effect::SobolSampler));
        let one = candidates(&called_for, &[Effect::Spheres, Effect::Disks]);
        let names: Vec<_> = one.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(names, ["called for", "+ disks"]);
    }
}
