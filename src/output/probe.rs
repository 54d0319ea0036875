//! Whether a file could be written, before there is anything to write.

use super::{Destination, temporary};
use std::fs::OpenOptions;
use std::io::{ErrorKind, Write};
use std::path::Path;

/// What is written as a probe: a full disk takes empty files.
const PROBE: [u8; 1] = [0];

/// What `path` denotes, if it can be written now. Temporary files that killed runs left in its
/// folder are removed.
///
/// # Errors
/// It cannot be written; the text says why, and what would be right.
pub fn probe(path: &Path) -> Result<Destination, String> {
    let destination = Destination::of(path)?;
    match &destination {
        Destination::Stdout | Destination::Stderr => {}
        Destination::Stream(stream) => probe_stream(stream)?,
        Destination::File(file) => probe_file(file)?,
    }
    Ok(destination)
}

/// Opens a device; a pipe has to wait for its reader.
fn probe_stream(stream: &Path) -> Result<(), String> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        let found = std::fs::metadata(stream).map_err(|e| e.to_string())?;
        if found.file_type().is_fifo() {
            return Ok(());
        }
    }
    let opened = OpenOptions::new().append(true).open(stream);
    opened.map(|_| ()).map_err(|e| e.to_string())
}

fn probe_file(file: &Path) -> Result<(), String> {
    let exists = file.exists();
    if exists {
        let found = std::fs::metadata(file).map_err(|e| e.to_string())?;
        if found.permissions().readonly() {
            return Err("is write-protected; name another file".to_owned());
        }
        let opened = OpenOptions::new().write(true).open(file);
        opened.map_err(|e| e.to_string())?;
    }
    let folder = file.parent().expect("a located file has a folder");
    match probe_folder(folder) {
        // A file that takes bytes is enough: it is overwritten.
        Err((ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem, _)) if exists => Ok(()),
        found => found.map_err(|(_, text)| text),
    }
}

/// Whether `folder` takes new files. Those that killed runs left there are removed.
///
/// # Errors
/// It does not: of what kind the failure is, and a text that says so.
pub fn probe_folder(folder: &Path) -> Result<(), (ErrorKind, String)> {
    temporary::sweep(folder);
    let made = temporary::create(folder);
    let written = made.and_then(|mut file| file.write_all(&PROBE));
    written.map_err(|e| {
        let text = format!("the folder {} takes no new files: {e}", folder.display());
        (e.kind(), text)
    })
}
