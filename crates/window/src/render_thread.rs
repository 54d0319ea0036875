//! The views of a request on one device.

use super::mailbox::{Mailbox, Posted, Quit, State};
use super::request::{Layer, Pacing, RenderRequest};
use super::view::{Rescued, View};
use direkt::error::{Error, GpuError};
use direkt::low_level::gpu::Context;
use std::sync::Arc;
use std::time::Instant;

/// Why a render_thread closed.
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
pub struct RenderThread<'a> {
    context: &'a Context,
    mailbox: &'a Mailbox,
    views: Vec<View<'a>>,
    posted: Option<Posted>,
    /// Whether the newest request cannot be done.
    failed: bool,
    /// Runs so far.
    runs: &'a mut u64,
    rescued: Vec<Rescued>,
}

impl<'a> RenderThread<'a> {
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

    /// Works off requests until there are no more, or the device is lost.
    pub fn run(&mut self) -> Closed {
        loop {
            match self.turn() {
                Ok(()) => {}
                Err(Stop::Closed(closed)) => return closed,
                Err(Stop::Failed(error)) => {
                    self.failed = true;
                    let message = error.to_string();
                    self.mailbox
                        .tell(|status| status.state = State::Failed(message));
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

    /// Takes a newer request if there is one, and gets on with the request.
    fn turn(&mut self) -> Result<(), Stop> {
        let idle = self.failed || self.posted.as_ref().is_none_or(|p| p.request.paused);
        let newer = self.mailbox.take(self.version(), idle);
        if let Some(posted) = newer.map_err(|quit| Stop::Closed(quit.into()))? {
            self.accept(posted)?;
        }
        let Some(posted) = self.posted.clone().filter(|_| !self.failed) else {
            return Ok(());
        };
        if !posted.request.paused {
            let next = self.next_view(&posted.request);
            let (mailbox, version) = (self.mailbox, posted.version);
            let newer = || mailbox.is_newer_than(version);
            self.views[next].pass(newer)?;
            // While the camera moves there is always something newer, and an old picture is better
            // than none.
            if self.views[next].is_due() && (posted.request.moving || !newer()) {
                self.show(next, &posted)?;
            }
        }
        Ok(())
    }

    /// Whose turn it is.
    fn next_view(&self, request: &RenderRequest) -> usize {
        let behind = |a: &View<'_>, b: &View<'_>| match request.pacing {
            Pacing::EqualTime => b.seconds() < a.seconds(),
            Pacing::EqualSamples => b.samples() < a.samples(),
        };
        match self.views.as_slice() {
            [a, b] if behind(a, b) => 1,
            _ => 0,
        }
    }

    /// Makes the views those of a newer request.
    fn accept(&mut self, posted: Posted) -> Result<(), Stop> {
        let (request, before) = (Arc::clone(&posted.request), self.posted.replace(posted));
        self.failed = false;
        self.views.truncate(request.methods.len());
        let mut begun = false;
        for (index, method) in request.methods.iter().enumerate() {
            let view = self.views.get_mut(index);
            match view.filter(|view| view.fits(&request, method)) {
                Some(view) if view.is_of(&request) => {}
                Some(view) => {
                    *self.runs += 1;
                    view.begin(&request, *self.runs)?;
                    begun = true;
                }
                None => {
                    self.mailbox.tell(|status| status.state = State::Compiling);
                    *self.runs += 1;
                    let data = self.views.iter().find_map(|view| view.data_for(&request));
                    let mut view = View::new(self.context, &request, method, data, *self.runs)?;
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
        self.begin_together(&request, begun)?;
        let state = if request.paused {
            State::Paused
        } else {
            State::Rendering
        };
        let views = self.views.len();
        self.mailbox.tell(|status| {
            status.state = state;
            status
                .pictures
                .iter_mut()
                .skip(views)
                .for_each(|p| *p = None);
        });
        self.answer(&request, before.as_ref().map(|p| &*p.request));
        self.show_again(before.as_ref())
    }

    /// Two views are compared from their beginnings.
    fn begin_together(&mut self, request: &RenderRequest, begun: bool) -> Result<(), GpuError> {
        if begun && self.views.len() > 1 {
            for view in self.views.iter_mut().filter(|v| v.samples() > 0) {
                *self.runs += 1;
                view.begin(request, *self.runs)?;
            }
        }
        Ok(())
    }

    /// Answers what is asked about a point.
    fn answer(&self, request: &RenderRequest, before: Option<&RenderRequest>) {
        let same = |old: &RenderRequest| {
            old.inspected == request.inspected
                && old.camera == request.camera
                && Arc::ptr_eq(&old.scene, &request.scene)
        };
        if before.is_some_and(same) {
            return;
        }
        let found = request.inspected.zip(self.views.first());
        let found = found.map(|(at, view)| Arc::new(view.inspect(at)));
        self.mailbox.tell(|status| status.inspected = found);
    }

    /// Shows the same images in another way, where that is what the newer request asks for.
    fn show_again(&mut self, before: Option<&Posted>) -> Result<(), Stop> {
        let Some(posted) = self.posted.clone() else {
            return Ok(());
        };
        let shown = |request: &RenderRequest| (request.layer, request.display);
        if before.is_none_or(|old| shown(&old.request) == shown(&posted.request)) {
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
        let is_difference = posted.request.layer == Layer::Difference;
        let other = self.views.get(1 - index).filter(|_| is_difference);
        let other = other.map(View::snapshot).transpose()?;
        let other = other.map(|(film, _)| film);
        let view = &mut self.views[index];
        let (mailbox, version) = (self.mailbox, posted.version);
        let picture = view.picture(snapshot, other.as_ref(), (&posted.request, version), || {
            mailbox.is_newer_than(version)
        });
        let picture = Some(Arc::new(picture));
        view.shown(start.elapsed().as_secs_f64());
        self.mailbox.tell(|status| status.pictures[index] = picture);
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
