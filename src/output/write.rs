//! Writes whole files.

use super::{Destination, temporary};
use crate::console;
use crate::error::Error;
use std::fs::{File, OpenOptions};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

/// Characters of a name that are kept where it may be what is wrong.
const KEPT_OF_NAME: usize = 48;

/// Writes `bytes` to what `path` denotes: a regular file is replaced as a whole, and keeps its
/// permissions; a pipe or a device is written straight.
///
/// # Errors
/// It cannot be written; a regular file is as it was then.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let written = match Destination::of(path).map_err(io::Error::other) {
        Ok(Destination::Stdout) => console::write_stdout(bytes),
        Ok(Destination::Stderr) => io::stderr().write_all(bytes),
        Ok(Destination::Stream(stream)) => append(&stream, bytes),
        Ok(Destination::File(file)) => replace(&file, bytes),
        Err(error) => Err(error),
    };
    written.map_err(|source| Error::write(path, source))
}

/// Like [`write`](write()); what cannot be written there is saved under a new name in the same
/// folder, the current one, that of temporary files or the user's own, whichever takes it first.
///
/// # Errors
/// It could not be written to `path`; the error names where it is saved.
pub fn write_or_save_elsewhere(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    match write(path, bytes) {
        Err(Error::Write { path, source, .. }) => Err(Error::Write {
            saved_as: save_elsewhere(&path, bytes),
            path,
            source,
        }),
        done => done,
    }
}

/// A new folder for the files that were meant for `folder`, made where one can be made.
pub fn rescue_folder(folder: &Path) -> Option<PathBuf> {
    let name = folder.file_name().unwrap_or_default().to_string_lossy();
    let prefix = format!("{}-", shortened(&name));
    let make = |place: &PathBuf| {
        let made = tempfile::Builder::new().prefix(&prefix).tempdir_in(place);
        made.ok().map(tempfile::TempDir::keep)
    };
    places(folder).iter().find_map(make)
}

/// Where files go that cannot be written to `path`.
fn places(path: &Path) -> Vec<PathBuf> {
    let mut places = Vec::new();
    // Beside a device is no place for files.
    if matches!(Destination::of(path), Ok(Destination::File(_)) | Err(_)) {
        let own = path
            .parent()
            .filter(|folder| !folder.as_os_str().is_empty());
        places.extend(own.map(Path::to_path_buf));
    }
    places.extend(std::env::current_dir());
    places.push(std::env::temp_dir());
    places.extend(std::env::home_dir());
    places
}

/// Writes `bytes` to a new file that is called much as `path` is, in its folder or the next that
/// takes it, and returns its name.
pub fn save_elsewhere(path: &Path, bytes: &[u8]) -> Option<PathBuf> {
    let part = |part: Option<&std::ffi::OsStr>| {
        part.map_or_else(String::new, |text| shortened(&text.to_string_lossy()))
    };
    let prefix = format!("{}-", part(path.file_stem()));
    let suffix = match part(path.extension()) {
        extension if extension.is_empty() => extension,
        extension => format!(".{extension}"),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(&suffix);
    temporary::readable_by_all(&mut builder);
    let save = |place: &PathBuf| {
        let mut file = builder.tempfile_in(place).ok()?;
        file.write_all(bytes).ok()?;
        sync(file.as_file()).ok()?;
        Some(file.keep().ok()?.1)
    };
    places(path).iter().find_map(save)
}

/// The beginning of a name, without what ends a folder's.
fn shortened(name: &str) -> String {
    let kept = name.chars().filter(|&c| !std::path::is_separator(c));
    kept.take(KEPT_OF_NAME).collect()
}

fn append(stream: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut stream = OpenOptions::new().append(true).open(stream)?;
    match stream.write_all(bytes) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        written => written,
    }
}

/// Replaces `file` as a whole, or overwrites it where its folder takes no other.
fn replace(file: &Path, bytes: &[u8]) -> io::Result<()> {
    let folder = file.parent().expect("a located file has a folder");
    let existing = std::fs::metadata(file).ok().filter(|m| m.is_file());
    let mut temporary = match temporary::create(folder) {
        Ok(temporary) => temporary,
        Err(_) if existing.is_some() => return overwrite(file, bytes),
        Err(error) => return Err(error),
    };
    temporary.write_all(bytes)?;
    if let Some(existing) = &existing {
        // Those of a file that belongs to another user cannot be given.
        let _ = std::fs::set_permissions(temporary.path(), existing.permissions());
    }
    sync(temporary.as_file())?;
    match temporary.persist(file) {
        Ok(_) => Ok(()),
        // It is mounted by itself, or another user's in a folder for all.
        Err(failed) if existing.is_some() => overwrite(file, bytes).map_err(|_| failed.error),
        Err(failed) => Err(failed.error),
    }
}

fn overwrite(file: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = OpenOptions::new().write(true).truncate(true).open(file)?;
    file.write_all(bytes)?;
    sync(&file)
}

/// Waits until the bytes are on the disk: some file systems tell only then that they have no room.
fn sync(file: &File) -> io::Result<()> {
    match file.sync_all() {
        Err(e) if matches!(e.kind(), ErrorKind::InvalidInput | ErrorKind::Unsupported) => Ok(()),
        done => done,
    }
}
