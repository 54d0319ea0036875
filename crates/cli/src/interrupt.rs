//! Ctrl-C, and the signals by which a process is asked to end or told that its terminal is closed.
//!
//! Until a command has something to save, the first one ends the process. From then on it asks the
//! command to end soon, and a second Ctrl-C ends the process at once. A signal that is ignored when
//! the process starts, as `nohup` has it, stays ignored.

use direkt::low_level::console::say;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Time in which a second Ctrl-C counts as the first: some wrappers pass on what the terminal has
/// sent to all.
const SAME: Duration = Duration::from_millis(100);

/// Listens for signals.
#[derive(Debug, Clone)]
pub struct Interrupt(Arc<State>);

#[derive(Debug, Default)]
struct State {
    /// Whether the command has something to save.
    deferred: AtomicBool,
    came: AtomicBool,
    first: Mutex<Option<Instant>>,
}

/// Makes a file beyond the limit of its size an error of writing, which ends the process otherwise.
pub fn survive_size_limit() {
    system::survive_size_limit();
}

impl Interrupt {
    /// Listens from now on. To be called once.
    pub fn listen() -> Self {
        let state = Arc::new(State::default());
        let listening = Arc::clone(&state);
        system::listen(move |signal| listening.receive(signal));
        Self(state)
    }

    /// From now on the command asks whether a signal came.
    pub fn defer(&self) {
        self.0.deferred.store(true, Ordering::Relaxed);
    }

    /// Whether one came.
    pub fn came(&self) -> bool {
        self.0.came.load(Ordering::Relaxed)
    }
}

impl State {
    fn receive(&self, signal: i32) {
        if !self.deferred.load(Ordering::Relaxed) {
            say("direkt: interrupted before the first sample, nothing was written");
            system::exit(1);
        }
        let mut first = self.first.lock().unwrap_or_else(PoisonError::into_inner);
        let again = first.is_some_and(|at| at.elapsed() > SAME);
        if again && system::is_ctrl_c(signal) {
            system::end_by(signal);
        }
        first.get_or_insert_with(Instant::now);
        self.came.store(true, Ordering::Relaxed);
    }
}

#[cfg(unix)]
mod system {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
    use signal_hook::iterator::Signals;
    use signal_hook::low_level;
    use std::mem::MaybeUninit;
    use std::sync::Arc;

    /// Calls `receive` with each signal, in a thread of its own. Where that cannot be, signals end
    /// the process as ever.
    pub fn listen(receive: impl Fn(i32) + Send + 'static) {
        let signals = [SIGINT, SIGTERM, SIGHUP].into_iter();
        let Ok(mut signals) = Signals::new(signals.filter(|&s| !is_ignored(s))) else {
            return;
        };
        let listening = std::thread::Builder::new().name("signals".to_owned());
        let _ = listening.spawn(move || signals.forever().for_each(receive));
    }

    pub fn survive_size_limit() {
        // Where it cannot be, the signal ends the process as ever.
        let _ = signal_hook::flag::register(SIGXFSZ, Arc::default());
    }

    fn is_ignored(signal: i32) -> bool {
        let mut current = MaybeUninit::<libc::sigaction>::zeroed();
        // SAFETY: without a new action nothing is changed, and the current one is written to a
        // place of its size.
        let asked = unsafe { libc::sigaction(signal, std::ptr::null(), current.as_mut_ptr()) };
        // SAFETY: all bits zero are a `sigaction`, and so is what the call wrote.
        let current = unsafe { current.assume_init() };
        asked == 0 && current.sa_sigaction == libc::SIG_IGN
    }

    pub fn is_ctrl_c(signal: i32) -> bool {
        signal == SIGINT
    }

    /// Ends the process without what libraries do at its end, which another thread may be in the
    /// middle of.
    pub fn exit(code: i32) -> ! {
        low_level::exit(code)
    }

    /// Ends the process as `signal` does by itself, so that shells see it.
    pub fn end_by(signal: i32) {
        let _ = low_level::emulate_default_handler(signal);
    }
}

#[cfg(not(unix))]
mod system {
    /// Exit code of a process that Ctrl-C ended.
    const KILLED: i32 = 130;

    /// Calls `receive` at each Ctrl-C and when the console is closed. A handler that cannot be
    /// installed leaves the default.
    pub fn listen(receive: impl Fn(i32) + Send + 'static) {
        let _ = ctrlc::set_handler(move || receive(0));
    }

    pub fn survive_size_limit() {}

    pub fn is_ctrl_c(_: i32) -> bool {
        true
    }

    pub fn exit(code: i32) -> ! {
        std::process::exit(code)
    }

    pub fn end_by(_: i32) {
        exit(KILLED);
    }
}
