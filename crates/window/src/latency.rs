//! How fast the window answers: reported on stderr where the user asks for it.

use direkt::low_level::console::say;
use std::time::Instant;

/// Requests without a picture yet, and frames since the last report.
pub(super) struct Latency {
    /// Whether anything is reported.
    verbose: bool,
    waiting: Vec<Waiting>,
    frames: u32,
    /// Since when they are counted.
    since: Instant,
}

/// A request without a picture yet.
#[derive(Debug, Clone, Copy)]
struct Waiting {
    version: u64,
    posted: Instant,
    /// Whether the camera moves.
    moving: bool,
}

impl Latency {
    /// Nothing yet.
    pub(super) fn new(verbose: bool) -> Self {
        Self {
            verbose,
            waiting: Vec::new(),
            frames: 0,
            since: Instant::now(),
        }
    }

    /// Notes that the request `version` was posted.
    pub(super) fn posted(&mut self, version: u64, moving: bool) {
        self.waiting.push(Waiting {
            version,
            posted: Instant::now(),
            moving,
        });
    }

    /// Reports how long the request `version` waited for its first picture.
    pub(super) fn answered(&mut self, version: u64) {
        let answered = |posted: &Waiting| posted.version <= version;
        let last = self.waiting.iter().rfind(|p| answered(p)).copied();
        self.waiting.retain(|p| !answered(p));
        if let Some(request) = last.filter(|_| self.verbose) {
            let milliseconds = request.posted.elapsed().as_secs_f64() * 1e3;
            let kind = if request.moving { "moving" } else { "at rest" };
            let version = request.version;
            say(format_args!(
                "direkt: request {version}, {kind}: first picture after {milliseconds:.1} ms"
            ));
        }
    }

    /// Reports about every second how many frames were drawn.
    pub(super) fn count_frame(&mut self) {
        self.frames += 1;
        let seconds = self.since.elapsed().as_secs_f64();
        if seconds < 1.0 {
            return;
        }
        if self.verbose {
            let frames = self.frames;
            say(format_args!("direkt: {frames} frames in {seconds:.2} s"));
        }
        (self.frames, self.since) = (0, Instant::now());
    }
}
