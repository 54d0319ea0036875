//! The devices that tests share: as many as run at once, each with the kernels that it compiled.

use direkt::low_level::gpu::Context;
use std::process::Command;
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

/// A device that this test has for itself until it ends. Tests that lose their device open one of
/// their own. No adapter is a failure.
pub fn context() -> &'static Context {
    LEASE.with(|lease| lease.0)
}

fn open() -> Context {
    Context::new(None).unwrap_or_else(|e| {
        panic!("the tests need a GPU adapter, run them by `./lavapipe cargo test --release`: {e}")
    })
}

/// Runs the test `name` in a process of its own, in which lavapipe compiles kernels without
/// optimising them: for kernels that take long to compile and render little. `test` is its body.
pub fn in_a_process_that_compiles_fast(name: &str, test: impl FnOnce()) {
    const VARIABLE: &str = "GALLIVM_PERF";
    if std::env::var_os(VARIABLE).is_some() {
        return test();
    }
    let mut command = Command::new(std::env::current_exe().unwrap());
    let output = command
        .args([name, "--exact"])
        .env(VARIABLE, "nopt")
        .output();
    let output = output.unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{said}");
    assert!(said.contains("1 passed"), "{name} is no test: {said}");
}
