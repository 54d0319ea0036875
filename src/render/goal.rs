//! Rendering until the image is right enough.

use super::error::CONFIDENCE;
use super::film::Film;
use super::session::Session;
use crate::error::GpuError;
use crate::scene::ErrorMetric;

/// Samples per pixel at which the error is looked at for the first time.
const FIRST_LOOK: u64 = 16;
/// Confidence of the interval that has to be below the goal where an image cannot tell its error.
const BEYOND_DOUBT: f64 = 0.999;
/// Samples per pixel after which an image without any light counts as black: it has no relative
/// error to reach.
const BLACK: u64 = 1024;

/// An error that an image is to have, and how sure it has to be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErrorGoal {
    /// What it is measured in.
    pub metric: ErrorMetric,
    /// The square root of the image's error in that metric.
    pub relative: f64,
    /// Confidence of the interval whose upper end has to be below it.
    pub confidence: f64,
}

impl ErrorGoal {
    /// With the usual confidence.
    pub fn new(metric: ErrorMetric, relative: f64) -> Self {
        Self {
            metric,
            relative,
            confidence: CONFIDENCE,
        }
    }
}

/// What a look at the image found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// The goal is reached.
    Reached,
    /// It is not.
    NotYet,
    /// There is no light in the image.
    Black,
}

/// Looks at an image's error in growing intervals.
///
/// A look costs time, and every look is another chance to stop because the error happens to be told
/// too small. So the next one is where the goal should be reached if the squared error falls with
/// the inverse of the samples, an eighth more samples away at least and twice as many at most.
#[derive(Debug, Clone, Copy)]
pub struct ErrorMonitor {
    goal: ErrorGoal,
    next: u64,
}

impl ErrorMonitor {
    /// A monitor for `goal`.
    pub fn new(goal: ErrorGoal) -> Self {
        Self {
            goal,
            next: FIRST_LOOK,
        }
    }

    /// Samples per pixel at which the image is to be looked at next.
    pub fn next(&self) -> u64 {
        self.next
    }

    /// Looks at the image of `session` if it has the samples for it.
    ///
    /// # Errors
    /// The driver fails.
    pub fn verdict(&mut self, session: &Session<'_>) -> Result<Verdict, GpuError> {
        let samples = session.samples();
        if samples < self.next {
            return Ok(Verdict::NotYet);
        }
        Ok(self.judge(&session.snapshot()?.0, samples))
    }

    fn judge(&mut self, film: &Film, samples: u64) -> Verdict {
        let goal = self.goal.relative * self.goal.relative;
        let Some(error) = film.error_at(self.goal.confidence) else {
            self.next = 2 * samples;
            return if samples < BLACK {
                Verdict::NotYet
            } else {
                Verdict::Black
            };
        };
        let stated = error.in_metric(self.goal.metric);
        let mut upper = stated.high;
        if upper <= goal && stated.doubt.is_some() {
            let surer = film.error_at(self.goal.confidence.max(BEYOND_DOUBT));
            upper = surer.map_or(f64::INFINITY, |e| e.in_metric(self.goal.metric).high);
        }
        if upper <= goal {
            return Verdict::Reached;
        }
        let due = samples as f64 * (upper / goal);
        let (least, most) = (samples + samples.div_ceil(8), 2 * samples);
        // Both replicates have the same number of samples where it is even.
        self.next = (due.min(most as f64) as u64)
            .clamp(least, most)
            .next_multiple_of(2);
        Verdict::NotYet
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::film::Pixel;
    use crate::scene::{FilmSize, Sampler};

    /// A film of 64 × 64 pixels with relMSE 1e-4, as its replicates tell it.
    fn film(brightness: f64) -> Film {
        let size = FilmSize {
            width: 64,
            height: 64,
        };
        let mut film = Film::new(size, Sampler::Sobol);
        // Of relMSE = 0.01²·1.01, since 1 % of the mean's square is in its denominator.
        let half = 0.01 * 1.01_f64.sqrt() * brightness;
        for (i, pixel) in film.pixels.iter_mut().enumerate() {
            let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
            *pixel = Pixel {
                samples: 64,
                mean: [brightness; 3],
                m2: [64.0 * 63.0 * half * half; 3],
                second_samples: 32,
                second_mean: [brightness + sign * half; 3],
                ..Pixel::default()
            };
        }
        film
    }

    #[test]
    fn the_goal_is_reached_when_the_interval_is_below_it() {
        // All pixels share the error alike: the interval's upper end is e^(1.96·√(4/64²)) = 1.063
        // times the estimate, that of √relMSE 1.031 times.
        for (relative, reached) in [(0.0103, false), (0.0104, true)] {
            let mut monitor = ErrorMonitor::new(ErrorGoal::new(ErrorMetric::RelMse, relative));
            let verdict = monitor.judge(&film(1.0), 64);
            assert_eq!(
                verdict == Verdict::Reached,
                reached,
                "{relative}: {verdict:?}"
            );
        }
        let surer = ErrorGoal {
            confidence: 0.9999,
            ..ErrorGoal::new(ErrorMetric::RelMse, 0.0104)
        };
        assert_eq!(
            ErrorMonitor::new(surer).judge(&film(1.0), 64),
            Verdict::NotYet
        );
    }

    #[test]
    fn the_next_look_is_where_the_goal_should_be_reached() {
        let next = |relative: f64| {
            let mut monitor = ErrorMonitor::new(ErrorGoal::new(ErrorMetric::RelMse, relative));
            monitor.judge(&film(1.0), 64);
            monitor.next()
        };
        assert_eq!(next(0.0101), 72, "an eighth more at least");
        assert_eq!(next(0.001), 128, "twice as many at most");
        let due = next(0.0085);
        assert!((92..=96).contains(&due), "{due}");
    }

    #[test]
    fn black_is_noticed() {
        let mut monitor = ErrorMonitor::new(ErrorGoal::new(ErrorMetric::Nmse, 0.01));
        assert_eq!(monitor.judge(&film(0.0), 512), Verdict::NotYet);
        assert_eq!(monitor.judge(&film(0.0), 1024), Verdict::Black);
    }
}
