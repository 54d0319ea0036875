//! A thread that ends the process when one input takes too long.

use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

/// Longest time that one input may take.
pub const MAX_SECONDS: u64 = 5;

/// Milliseconds at which the input at hand was begun, plus 1; 0 between inputs.
static BEGUN: AtomicU64 = AtomicU64::new(0);
static WATCHED: Mutex<Option<(PathBuf, PathBuf)>> = Mutex::new(None);
static CLOCK: OnceLock<Instant> = OnceLock::new();

fn now() -> u64 {
    let clock = CLOCK.get_or_init(Instant::now);
    1 + clock.elapsed().as_millis() as u64
}

/// An input begins.
pub fn begin() {
    BEGUN.store(now(), Relaxed);
}

/// It has ended.
pub fn end() {
    BEGUN.store(0, Relaxed);
}

/// Watches from now on: when an input hangs, copies `input`, the file that holds it, to `kept` and
/// exits with 1. What was watched before is not any more.
pub fn start(input: PathBuf, kept: PathBuf) {
    let mut watched = WATCHED.lock().unwrap_or_else(PoisonError::into_inner);
    if watched.replace((input, kept)).is_none() {
        std::thread::spawn(watch);
    }
}

fn watch() {
    loop {
        std::thread::sleep(Duration::from_millis(200));
        let begun = BEGUN.load(Relaxed);
        if begun == 0 || now() <= begun + 1000 * MAX_SECONDS {
            continue;
        }
        let watched = WATCHED.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((input, kept)) = &*watched {
            let copied = std::fs::copy(input, kept);
            eprintln!(
                "{}: took more than {MAX_SECONDS} s ({copied:?} bytes)",
                kept.display()
            );
        }
        std::process::exit(1);
    }
}
