//! What the name of an output denotes.

use std::fs::Metadata;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Symbolic links, one behind the other, after which they count as a loop (Linux's own limit).
const MAX_LINKS: u32 = 40;

/// Where bytes that are written to a name arrive.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Destination {
    /// The standard output of this process, as `/dev/stdout` is.
    Stdout,
    /// Its standard error.
    Stderr,
    /// A pipe or a device that takes a stream of bytes, such as `/dev/null`.
    Stream(PathBuf),
    /// A regular file, there or not yet, in a folder that exists: absolute and without symbolic
    /// links.
    File(PathBuf),
}

impl Destination {
    /// What `path` denotes.
    ///
    /// # Errors
    /// Nothing can be written there; the text says why, and what would be right.
    pub fn of(path: &Path) -> Result<Self, String> {
        let mut at = path.to_path_buf();
        for _ in 0..=MAX_LINKS {
            let (folder, file) = located(&at)?;
            if let Some(stream) = open_descriptor(&folder, &file) {
                return Ok(stream);
            }
            match std::fs::symlink_metadata(&file) {
                Err(e) if e.kind() == ErrorKind::NotFound => return Ok(Self::File(file)),
                Err(e) => return Err(e.to_string()),
                Ok(found) if found.is_symlink() => {
                    let target = std::fs::read_link(&file).map_err(|e| e.to_string())?;
                    at = folder.join(target);
                }
                Ok(found) => return Self::of_existing(file, &found),
            }
        }
        Err("is a loop of symbolic links".to_owned())
    }

    fn of_existing(file: PathBuf, found: &Metadata) -> Result<Self, String> {
        if found.is_file() {
            Ok(Self::File(file))
        } else if found.is_dir() {
            Err("is a folder; name a file".to_owned())
        } else if takes_a_stream(found) {
            Ok(Self::Stream(file))
        } else {
            Err("is a disk or a socket; name a file".to_owned())
        }
    }
}

/// The folder of `path`, without symbolic links, and `path` in it.
fn located(path: &Path) -> Result<(PathBuf, PathBuf), String> {
    let ends_as_folder = |c: char| std::path::is_separator(c);
    let is_folder = path.to_string_lossy().ends_with(ends_as_folder);
    let Some(name) = path.file_name().filter(|_| !is_folder) else {
        return Err("is a folder; name a file".to_owned());
    };
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let shown = folder.display();
    let found = std::fs::canonicalize(folder).map_err(|e| match e.kind() {
        ErrorKind::NotFound => format!("there is no folder {shown}"),
        _ => format!("{shown}: {e}"),
    })?;
    if !found.is_dir() {
        return Err(format!("{shown} is no folder"));
    }
    let file = found.join(name);
    Ok((found, file))
}

/// One of this process's own open files, which `/dev/stdout` and `/dev/fd/1` name by links that
/// lead to the file, but not to where it is written next.
fn open_descriptor(folder: &Path, file: &Path) -> Option<Destination> {
    let own = ["/proc/self/fd", "/dev/fd"].map(|f| std::fs::canonicalize(f).ok());
    if !own.iter().flatten().any(|own| own == folder) {
        return None;
    }
    match file.file_name()?.to_str()? {
        "1" => Some(Destination::Stdout),
        "2" => Some(Destination::Stderr),
        number => {
            number.parse::<u32>().ok()?;
            Some(Destination::Stream(file.to_path_buf()))
        }
    }
}

#[cfg(unix)]
fn takes_a_stream(found: &Metadata) -> bool {
    use std::os::unix::fs::FileTypeExt;
    found.file_type().is_fifo() || found.file_type().is_char_device()
}

#[cfg(not(unix))]
fn takes_a_stream(_: &Metadata) -> bool {
    false
}
