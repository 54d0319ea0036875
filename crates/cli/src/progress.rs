//! Progress bars, on stderr.

use direkt::error::GpuError;
use direkt::low_level::render::{ImageError, Session};
use direkt_instruments::report::format::seconds as in_unit;
use indicatif::{ProgressBar, ProgressStyle};
use std::time::{Duration, Instant};

/// Shortest time between two looks at the image's error.
const LOOK_INTERVAL: Duration = Duration::from_secs(1);
/// Looking at the error may take this fraction of the time.
const LOOK_SHARE: u32 = 50;

/// A bar of `length` that is drawn by `template`; none where `quiet` or where stderr is no
/// terminal.
pub fn bar(length: u64, template: &str, quiet: bool) -> ProgressBar {
    if quiet {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template(template);
    let bar = ProgressBar::new(length);
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar
}

/// The progress bar: how much of the budget is spent.
pub struct Bar(ProgressBar);

impl Bar {
    /// An empty one for `budget`; none where `quiet`.
    pub fn new(budget: f64, quiet: bool) -> Self {
        let length = (1000.0 * budget) as u64;
        Self(bar(length, "{bar:24} {percent:>3} % {msg}", quiet))
    }

    /// Tells what is done now, and how much is spent.
    pub fn show(&self, what: &str, spent: f64) {
        self.0.set_position((1000.0 * spent) as u64);
        self.0.set_message(what.to_owned());
        self.0.tick();
    }

    /// Removes it.
    pub fn finish(&self) {
        self.0.finish_and_clear();
    }
}

/// Shows pass, samples/s, rays/s, error so far and the time left. Silent where stderr is no
/// terminal.
pub struct Progress {
    bar: ProgressBar,
    start: Instant,
    spp: u64,
    time: Option<Duration>,
    next_look: Instant,
    error: Option<ImageError>,
    rays_per_sample: f64,
}

impl Progress {
    /// A bar for `spp` samples per pixel or `time`, whichever comes first.
    pub fn new(spp: u64, time: Option<Duration>, quiet: bool) -> Self {
        let bar = bar(1000, "{bar:24} {percent:>3} % {msg}", quiet);
        let start = Instant::now();
        Self {
            bar,
            start,
            spp,
            time,
            next_look: start + LOOK_INTERVAL,
            error: None,
            rays_per_sample: 1.0,
        }
    }

    /// Tells how far `session` is after `passes` passes over `pixels` pixels.
    pub fn update(
        &mut self,
        session: &Session<'_>,
        passes: u64,
        pixels: usize,
    ) -> Result<(), GpuError> {
        if self.bar.is_hidden() {
            return Ok(());
        }
        let now = Instant::now();
        if now >= self.next_look {
            let (film, rays) = session.snapshot()?;
            self.error = film.error();
            self.rays_per_sample = rays.total() as f64 / rays.camera.max(1) as f64;
            self.next_look = now + LOOK_INTERVAL.max(now.elapsed() * LOOK_SHARE);
        }
        let seconds = self.start.elapsed().as_secs_f64();
        let by_samples = session.samples() as f64 / self.spp as f64;
        let by_time = self.time.map_or(0.0, |t| seconds / t.as_secs_f64());
        let done = by_samples.max(by_time).clamp(0.0, 1.0);
        let rate = session.samples() as f64 * pixels as f64 / seconds / 1e6;
        let error = self.error.map_or_else(String::new, |e| {
            format!(" · √NMSE {:.2} %", e.nmse.percent()[0])
        });
        let left = seconds / done.max(1e-9) * (1.0 - done);
        self.bar.set_position((done * 1000.0) as u64);
        self.bar.set_message(format!(
            "pass {passes} · {} spp · {rate:.1} M samples/s · {:.1} M rays/s{error} · {} left",
            session.samples(),
            rate * self.rays_per_sample,
            in_unit(left),
        ));
        Ok(())
    }

    /// Removes the bar.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}
