//! Ctrl-C: the first asks a command to end soon, a second ends the process at once.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Exit code of a process that Ctrl-C ended, as shells tell it: 128 + SIGINT.
const KILLED: i32 = 130;

/// Listens for Ctrl-C.
#[derive(Debug)]
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Listens from now on.
    pub fn listen() -> Self {
        let came = Arc::new(AtomicBool::new(false));
        let seen = Arc::clone(&came);
        // A handler that cannot be installed leaves the default: Ctrl-C ends the process.
        let _ = ctrlc::set_handler(move || {
            if seen.swap(true, Ordering::Relaxed) {
                std::process::exit(KILLED);
            }
        });
        Self(came)
    }

    /// Whether it came.
    pub fn came(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
