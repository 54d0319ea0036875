//! Temporary files in the folders of what they become.
//!
//! Each is locked as long as the run that made it holds it open, so that a later run can tell those
//! of killed runs.

use std::fs::{File, OpenOptions, TryLockError};
use std::io;
use std::path::Path;
use std::time::Duration;
use tempfile::NamedTempFile;

const PREFIX: &str = ".direkt-";
const SUFFIX: &str = ".tmp";
/// How often a new file may be taken away before it is locked.
const TRIES: u32 = 8;
/// Age from which a file counts as left behind where the file system knows no locks: writing one
/// takes less.
const OLD: Duration = Duration::from_secs(3600);

/// A new file in `folder`, which is removed with the value unless it is persisted.
pub(super) fn create(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX).suffix(SUFFIX);
    readable_by_all(&mut builder);
    for _ in 0..TRIES {
        let file = builder.tempfile_in(folder).map_err(without_path)?;
        // Another run that sweeps may come between making and locking.
        match file.as_file().try_lock() {
            Err(TryLockError::WouldBlock) => {}
            _ if file.path().exists() => return Ok(file),
            _ => {}
        }
    }
    Err(io::Error::other(
        "temporary files vanish as soon as they are made",
    ))
}

/// What the system said, without the temporary name, which nobody has asked for.
fn without_path(error: io::Error) -> io::Error {
    let said = std::error::Error::source(&error);
    let said = said.and_then(|e| e.downcast_ref::<io::Error>());
    let code = said.and_then(io::Error::raw_os_error);
    code.map_or(error, io::Error::from_raw_os_error)
}

/// Lets the file have the permissions that the user's mask gives to new files.
pub(super) fn readable_by_all(builder: &mut tempfile::Builder<'_, '_>) {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    #[cfg(not(unix))]
    let _ = builder;
}

/// Removes the temporary files in `folder` whose runs have ended. What cannot be removed stays.
pub(super) fn sweep(folder: &Path) {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return;
    };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        let is_ours = name.starts_with(PREFIX) && name.ends_with(SUFFIX);
        let is_file = || entry.file_type().is_ok_and(|t| t.is_file());
        if is_ours && is_file() && is_left_behind(&entry.path()) {
            // Another run may have been faster.
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

/// Whether no run holds the file.
fn is_left_behind(path: &Path) -> bool {
    let Ok(file) = OpenOptions::new().read(true).write(true).open(path) else {
        return false;
    };
    match file.try_lock() {
        Ok(()) => true,
        Err(TryLockError::WouldBlock) => false,
        Err(TryLockError::Error(_)) => is_old(&file),
    }
}

fn is_old(file: &File) -> bool {
    let modified = file.metadata().and_then(|m| m.modified());
    modified.is_ok_and(|at| at.elapsed().is_ok_and(|age| age > OLD))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_killed_runs_left_is_swept() {
        let folder = tempfile::tempdir().expect("a folder");
        let in_use = create(folder.path()).expect("a file");
        let left = folder.path().join(".direkt-a1B2c3.tmp");
        let others = ["direkt-a.tmp", ".direkt-a.exr", "image.exr"];
        std::fs::write(&left, "half an image").expect("written");
        for name in others {
            std::fs::write(folder.path().join(name), "").expect("written");
        }
        std::fs::create_dir(folder.path().join(".direkt-folder.tmp")).expect("made");
        sweep(folder.path());
        assert!(!left.exists(), "what was left behind");
        assert!(in_use.path().exists(), "what is in use");
        assert!(others.iter().all(|name| folder.path().join(name).exists()));
        assert!(folder.path().join(".direkt-folder.tmp").exists());
        let name = in_use.path().to_path_buf();
        drop(in_use);
        assert!(!name.exists());
    }
}
