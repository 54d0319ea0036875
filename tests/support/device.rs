//! The devices that tests share: as many as run at once, each with the kernels that it compiled.

use direkt::gpu::Context;
use std::sync::{Mutex, PoisonError};

/// Devices that no running test uses.
static FREE: Mutex<Vec<&'static Context>> = Mutex::new(Vec::new());

/// The device of one test: the harness runs each in a thread of its own.
struct Lease(&'static Context);

impl Lease {
    fn take() -> Self {
        let free = FREE.lock().unwrap_or_else(PoisonError::into_inner).pop();
        Self(free.unwrap_or_else(|| Box::leak(Box::new(open()))))
    }
}

impl Drop for Lease {
    fn drop(&mut self) {
        let mut free = FREE.lock().unwrap_or_else(PoisonError::into_inner);
        free.push(self.0);
    }
}

thread_local! {
    static LEASE: Lease = Lease::take();
}

/// A device that this test has for itself until it ends. Tests that lose their device open one of their own. No adapter is a
/// failure.
pub fn context() -> &'static Context {
    LEASE.with(|lease| lease.0)
}

fn open() -> Context {
    Context::new(None).unwrap_or_else(|e| {
        panic!("the tests need a GPU adapter, run them by `./lavapipe cargo test --release`: {e}")
    })
}
