//! The passes of a render, with a progress bar, until something or the user ends them.

use super::interrupt::Interrupt;
use super::progress::Progress;
use direkt::error::Error;
use direkt::low_level::render::passes::duration;
use direkt::low_level::render::{Session, StoppedBy};
use direkt::scene::Scene;

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
pub struct Passes {
    passes: direkt::low_level::render::Passes,
    interrupt: Interrupt,
    progress: Progress,
    pixels: usize,
}

impl Passes {
    /// Those of `scene`, from now on, until `interrupt` comes.
    pub fn new(scene: &Scene, interrupt: Interrupt, quiet: bool) -> Self {
        interrupt.defer();
        let settings = scene.render;
        Self {
            passes: direkt::low_level::render::Passes::new(&settings),
            interrupt,
            progress: Progress::new(settings.stop.spp, settings.stop.time.map(duration), quiet),
            pixels: scene.film.pixels(),
        }
    }

    /// Takes passes until the samples, the time or the user's patience run out, or the image is
    /// right enough; `after` is called after each.
    pub fn take(
        &mut self,
        session: &mut Session<'_>,
        mut after: impl FnMut(&Session<'_>) -> Result<(), Error>,
    ) -> Result<Progressed, Error> {
        let stopped_by = loop {
            let interrupted = || self.interrupt.came();
            if let Some(by) = self.passes.take(session, interrupted)? {
                break by;
            }
            let taken = self.passes.taken();
            self.progress.update(session, taken, self.pixels)?;
            after(session)?;
            if let Some(by) = self.passes.judge(session)? {
                break by;
            }
        };
        Ok(self.end(stopped_by))
    }

    /// How they went until `stopped_by` ended them.
    pub fn end(&self, stopped_by: StoppedBy) -> Progressed {
        self.progress.finish();
        Progressed {
            passes: self.passes.taken(),
            seconds: self.passes.elapsed().as_secs_f64(),
            stopped_by,
        }
    }
}
