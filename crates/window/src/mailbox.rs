//! What goes between the window and the renderer: the newest request one way, pictures and status
//! the other.

use super::picture::{Inspected, Picture};
use super::request::{MAX_VIEWS, RenderRequest};
use direkt::low_level::gpu::AdapterFacts;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

/// A request and its number; later ones have larger numbers.
#[derive(Debug, Clone)]
pub struct Posted {
    /// Its number.
    pub version: u64,
    /// The request.
    pub request: Arc<RenderRequest>,
}

/// What the renderer is doing.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum State {
    /// Preparing the scene and compiling.
    #[default]
    Compiling,
    /// Rendering.
    Rendering,
    /// Waiting, as it was told to.
    Paused,
    /// Waiting for another request, because of this.
    Failed(String),
}

/// What the window shows of the renderer's work.
#[derive(Debug, Clone, Default)]
pub struct RenderStatus {
    /// The newest picture of each view; those of a failed request stay.
    pub pictures: [Option<Arc<Picture>>; MAX_VIEWS],
    /// What is being done.
    pub state: State,
    /// What the device is.
    pub adapter: Option<AdapterFacts>,
    /// What lies under the point that was asked about.
    pub inspected: Option<Arc<Inspected>>,
}

#[derive(Debug, Default)]
struct Inner {
    posted: Option<Posted>,
    quit: bool,
    status: RenderStatus,
}

/// The mailbox.
pub struct Mailbox {
    inner: Mutex<Inner>,
    arrived: Condvar,
    newest: AtomicU64,
    /// Called when there is something new to show.
    wake: Box<dyn Fn() + Send + Sync>,
}

impl Mailbox {
    /// An empty one; `wake` is called whenever the renderer has something to show.
    pub fn new(wake: impl Fn() + Send + Sync + 'static) -> Self {
        Self {
            inner: Mutex::default(),
            arrived: Condvar::new(),
            newest: AtomicU64::new(0),
            wake: Box::new(wake),
        }
    }

    fn lock(&self) -> MutexGuard<'_, Inner> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Posts a request, which takes the place of those before it, and returns its number.
    pub fn post(&self, request: RenderRequest) -> u64 {
        let mut inner = self.lock();
        let version = self.newest.load(Ordering::Relaxed) + 1;
        inner.posted = Some(Posted {
            version,
            request: Arc::new(request),
        });
        self.newest.store(version, Ordering::Release);
        self.arrived.notify_all();
        version
    }

    /// Asks the renderer to end.
    pub fn quit(&self) {
        self.lock().quit = true;
        self.newest.fetch_add(1, Ordering::Release);
        self.arrived.notify_all();
    }

    /// What there is to show.
    pub fn status(&self) -> RenderStatus {
        self.lock().status.clone()
    }

    /// Whether there is a newer request than `version`, or the end.
    pub fn is_newer_than(&self, version: u64) -> bool {
        self.newest.load(Ordering::Acquire) > version
    }

    /// The newest request, if it is newer than `version`; where `wait` says so, waits for one. An
    /// error is the end.
    pub fn take(&self, version: u64, wait: bool) -> Result<Option<Posted>, Quit> {
        let mut inner = self.lock();
        loop {
            if inner.quit {
                return Err(Quit);
            }
            let newer = inner.posted.as_ref().filter(|p| p.version > version);
            if newer.is_some() || !wait {
                return Ok(newer.cloned());
            }
            inner = self
                .arrived
                .wait(inner)
                .unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Changes what there is to show, and says so.
    pub fn tell(&self, change: impl FnOnce(&mut RenderStatus)) {
        change(&mut self.lock().status);
        (self.wake)();
    }
}

/// The window was closed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Quit;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example;
    use direkt::scene::load::{LoadOptions, load};

    fn request() -> RenderRequest {
        let scene = load(&example("cornell"), &LoadOptions::default()).expect("Cornell");
        RenderRequest {
            camera: scene.camera,
            film: scene.film,
            scene: Arc::new(scene),
            methods: Vec::new(),
            pacing: Default::default(),
            layer: Default::default(),
            display: Default::default(),
            moving: false,
            paused: false,
            inspected: None,
        }
    }

    #[test]
    fn the_newest_job_takes_the_place_of_the_others() {
        let mailbox = Mailbox::new(|| ());
        assert!(mailbox.take(0, false).expect("open").is_none());
        mailbox.post(request());
        let second = mailbox.post(request());
        let taken = mailbox.take(0, true).expect("open").expect("posted");
        assert_eq!(taken.version, second);
        assert!(!mailbox.is_newer_than(second));
        assert!(mailbox.take(second, false).expect("open").is_none());
    }

    #[test]
    fn the_end_wakes_who_waits() {
        let mailbox = Arc::new(Mailbox::new(|| ()));
        let other = Arc::clone(&mailbox);
        let waiting = std::thread::spawn(move || other.take(0, true).err());
        mailbox.quit();
        assert_eq!(waiting.join().expect("no panic"), Some(Quit));
        assert!(mailbox.is_newer_than(0));
    }
}
