//! Which file a name denotes, whatever it is called.

use super::Destination;
use std::path::{Path, PathBuf};

/// A file, there or not yet: names that differ by `.`, `..`, symbolic or hard links denote the same
/// one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Identity {
    /// Absolute and without symbolic links.
    path: PathBuf,
    /// Device and number on it; none where there is no such file yet, or no such numbers.
    number: Option<(u64, u64)>,
}

impl Identity {
    /// The file that `path` denotes; none where it denotes no regular file.
    pub fn of(path: &Path) -> Option<Self> {
        match Destination::of(path) {
            Ok(Destination::File(path)) => Some(Self {
                number: number(&path),
                path,
            }),
            _ => None,
        }
    }

    /// The file, absolute and without symbolic links.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The folder that it is in.
    pub fn folder(&self) -> Option<&Path> {
        self.path.parent()
    }

    /// Whether writing the one would change the other.
    pub fn is_same(&self, other: &Self) -> bool {
        self.path == other.path || (self.number.is_some() && self.number == other.number)
    }
}

#[cfg(unix)]
fn number(path: &Path) -> Option<(u64, u64)> {
    use std::os::unix::fs::MetadataExt;
    let found = std::fs::metadata(path).ok()?;
    Some((found.dev(), found.ino()))
}

#[cfg(not(unix))]
fn number(_: &Path) -> Option<(u64, u64)> {
    None
}
