//! Lines on stderr and text on stdout. Where nobody can read them (a closed pipe, a full disk, a
//! terminal that is gone) the text is lost and nothing else; the macros of the standard library
//! panic there.

use std::fmt::Display;
use std::io::{Error, ErrorKind, Write};
use std::sync::OnceLock;

/// Why text on stdout was lost the first time.
static STDOUT_FAILURE: OnceLock<Error> = OnceLock::new();

/// Writes `line` to stderr.
pub fn say(line: impl Display) {
    // In one piece, so that the lines of several threads do not mix. There is nowhere to report a
    // failure.
    let _ = std::io::stderr().write_all(format!("{line}\n").as_bytes());
}

/// Writes `text` to stdout. A reader that went away is no failure; any other is kept for
/// [`stdout_failure`].
pub fn print(text: &str) {
    if let Err(error) = write_stdout(text.as_bytes()) {
        // The first one is kept.
        let _ = STDOUT_FAILURE.set(error);
    }
}

/// Writes `bytes` to stdout.
///
/// # Errors
/// It cannot be written, but not because its reader went away.
pub fn write_stdout(bytes: &[u8]) -> Result<(), Error> {
    let mut stdout = std::io::stdout().lock();
    let written = stdout.write_all(bytes);
    match written.and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(error),
        _ => Ok(()),
    }
}

/// Why text of [`print()`] was lost, if any was.
pub fn stdout_failure() -> Option<&'static Error> {
    STDOUT_FAILURE.get()
}
