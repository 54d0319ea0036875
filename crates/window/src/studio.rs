//! The views of a job on one device.

use super::job::{Job, Layer, Turns};
use super::mailbox::{Mailbox, Posted, Quit, State};
use super::view::{Rescued, View};
use direkt::error::{Error, GpuError};
use direkt::gpu::Context;
use std::sync::Arc;
use std::time::Instant;

/// Why a studio closed.
pub enum Closed {
    /// The window was closed.
    Quit,
    /// The device was lost.
    Lost(GpuError),
}

impl From<Quit> for Closed {
    fn from(_: Quit) -> Self {
        Self::Quit
    }
}

/// A device at work.
pub struct Studio<'a> {
    context: &'a Context,
    mailbox: &'a Mailbox,
    views: Vec<View<'a>>,
    posted: Option<Posted>,
    /// Whether the newest job cannot be done.
    failed: bool,
    /// Runs so far.
    runs: &'a mut u64,
    rescued: Vec<Rescued>,
}

impl<'a> Studio<'a> {
    /// A device without views; `rescued` are those of one that was lost.
    pub fn new(
        context: &'a Context,
        mailbox: &'a Mailbox,
        runs: &'a mut u64,
        rescued: Vec<Rescued>,
    ) -> Self {
        Self {
            context,
            mailbox,
            views: Vec::new(),
            posted: None,
            failed: false,
            runs,
            rescued,
        }
    }

    /// Works off jobs until there are no more, or the device is lost.
    pub fn run(&mut self) -> Closed {
        loop {
            match self.turn() {
                Ok(()) => {}
                Err(Stop::Closed(closed)) => return closed,
                Err(Stop::Failed(error)) => {
                    self.failed = true;
                    let message = error.to_string();
                    self.mailbox
                        .tell(|news| news.state = State::Failed(message));
                }
            }
        }
    }

    /// What another device needs to go on.
    pub fn rescue(self) -> Vec<Rescued> {
        self.views.into_iter().map(View::rescue).collect()
    }

    fn version(&self) -> u64 {
        self.posted.as_ref().map_or(0, |posted| posted.version)
    }

    /// Takes a newer job if there is one, and gets on with the job.
    fn turn(&mut self) -> Result<(), Stop> {
        let idle = self.failed || self.posted.as_ref().is_none_or(|p| p.job.paused);
        let newer = self.mailbox.take(self.version(), idle);
        if let Some(posted) = newer.map_err(|quit| Stop::Closed(quit.into()))? {
            self.accept(posted)?;
        }
        let Some(posted) = self.posted.clone().filter(|_| !self.failed) else {
            return Ok(());
        };
        if !posted.job.paused {
            let next = self.next_view(&posted.job);
            let (mailbox, version) = (self.mailbox, posted.version);
            let newer = || mailbox.is_newer_than(version);
            self.views[next].pass(newer)?;
            // While the camera moves there is always something newer, and an old picture is better than none.
            if self.views[next].is_due() && (posted.job.moving || !newer()) {
                self.show(next, &posted)?;
            }
        }
        Ok(())
    }

    /// Whose turn it is.
    fn next_view(&self, job: &Job) -> usize {
        let behind = |a: &View<'_>, b: &View<'_>| match job.turns {
            Turns::EqualTime => b.seconds() < a.seconds(),
            Turns::EqualSamples => b.samples() < a.samples(),
        };
        match self.views.as_slice() {
            [a, b] if behind(a, b) => 1,
            _ => 0,
        }
    }

    /// Makes the views those of a newer job.
    fn accept(&mut self, posted: Posted) -> Result<(), Stop> {
        let (job, before) = (Arc::clone(&posted.job), self.posted.replace(posted));
        self.failed = false;
        self.views.truncate(job.methods.len());
        let mut begun = false;
        for (index, method) in job.methods.iter().enumerate() {
            let view = self.views.get_mut(index);
            match view.filter(|view| view.fits(&job, method)) {
                Some(view) if view.is_of(&job) => {}
                Some(view) => {
                    *self.runs += 1;
                    view.begin(&job, *self.runs)?;
                    begun = true;
                }
                None => {
                    self.mailbox.tell(|news| news.state = State::Compiling);
                    *self.runs += 1;
                    let data = self.views.iter().find_map(|view| view.data_for(&job));
                    let mut view = View::new(self.context, &job, method, data, *self.runs)?;
                    if let Some(rescued) = self.rescued.get(index) {
                        view.resume(rescued)?;
                    }
                    if index < self.views.len() {
                        self.views[index] = view;
                    } else {
                        self.views.push(view);
                    }
                    begun = true;
                }
            }
        }
        self.rescued.clear();
        self.begin_together(&job, begun)?;
        let state = if job.paused {
            State::Paused
        } else {
            State::Rendering
        };
        let views = self.views.len();
        self.mailbox.tell(|news| {
            news.state = state;
            news.pictures.iter_mut().skip(views).for_each(|p| *p = None);
        });
        self.answer(&job, before.as_ref().map(|p| &*p.job));
        self.show_again(before.as_ref())
    }

    /// Two views are compared from their beginnings.
    fn begin_together(&mut self, job: &Job, begun: bool) -> Result<(), GpuError> {
        if begun && self.views.len() > 1 {
            for view in self.views.iter_mut().filter(|v| v.samples() > 0) {
                *self.runs += 1;
                view.begin(job, *self.runs)?;
            }
        }
        Ok(())
    }

    /// Answers what is asked about a point.
    fn answer(&self, job: &Job, before: Option<&Job>) {
        let same = |old: &Job| {
            old.inspected == job.inspected
                && old.camera == job.camera
                && Arc::ptr_eq(&old.scene, &job.scene)
        };
        if before.is_some_and(same) {
            return;
        }
        let found = job.inspected.zip(self.views.first());
        let found = found.map(|(at, view)| Arc::new(view.inspect(at)));
        self.mailbox.tell(|news| news.inspected = found);
    }

    /// Shows the same images in another way, where that is what the newer job asks for.
    fn show_again(&mut self, before: Option<&Posted>) -> Result<(), Stop> {
        let Some(posted) = self.posted.clone() else {
            return Ok(());
        };
        let shown = |job: &Job| (job.layer, job.display);
        if before.is_none_or(|old| shown(&old.job) == shown(&posted.job)) {
            return Ok(());
        }
        for index in 0..self.views.len() {
            if self.views[index].samples() > 0 {
                self.show(index, &posted)?;
            }
        }
        Ok(())
    }

    /// Posts a picture of view `index`.
    fn show(&mut self, index: usize, posted: &Posted) -> Result<(), Stop> {
        let start = Instant::now();
        let snapshot = self.views[index].snapshot()?;
        let is_difference = posted.job.layer == Layer::Difference;
        let other = self.views.get(1 - index).filter(|_| is_difference);
        let other = other.map(View::snapshot).transpose()?;
        let other = other.map(|(film, _)| film);
        let view = &mut self.views[index];
        let (mailbox, version) = (self.mailbox, posted.version);
        let picture = view.picture(snapshot, other.as_ref(), (&posted.job, version), || {
            mailbox.is_newer_than(version)
        });
        let picture = Some(Arc::new(picture));
        view.shown(start.elapsed().as_secs_f64());
        self.mailbox.tell(|news| news.pictures[index] = picture);
        Ok(())
    }
}

/// Why a turn ended early.
enum Stop {
    Closed(Closed),
    Failed(Error),
}

impl From<GpuError> for Stop {
    fn from(error: GpuError) -> Self {
        match error {
            GpuError::Lost { .. } => Self::Closed(Closed::Lost(error)),
            other => Self::Failed(other.into()),
        }
    }
}

impl From<Error> for Stop {
    fn from(error: Error) -> Self {
        match error {
            Error::Gpu(error) => error.into(),
            other => Self::Failed(other),
        }
    }
}
