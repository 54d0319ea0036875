//! Where the files that a scene names are looked up, and which of them it may read.
//!
//! A scene may be a stranger's: the files it names lie in its own folder or in a folder that the
//! user named with `--assets`, symbolic links resolved, and nowhere else.

use super::LoadOptions;
use super::room::Room;
use crate::error::InputError;
use std::io::ErrorKind;
use std::path::{Component, Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The folders in which names are looked up, in order, and those that a file may lie in.
#[derive(Debug, Clone)]
pub(super) struct Folders {
    lookup: Vec<PathBuf>,
    allowed: Vec<PathBuf>,
    /// Files that were found, here and for files that the scene includes.
    found: Arc<Mutex<Vec<PathBuf>>>,
    /// For the triangles of all of them.
    pub(super) room: Room,
}

impl Folders {
    /// The folder of the scene file `path`, then those of `options`. Fails when one of them does
    /// not exist.
    pub(super) fn of_scene(path: &Path, options: &LoadOptions) -> Result<Self, InputError> {
        let file = std::fs::canonicalize(path).map_err(|e| unreadable(path, &e))?;
        let own = file
            .parent()
            .expect("a canonical path of a file has a parent")
            .to_path_buf();
        let mut lookup = vec![own];
        for folder in &options.assets {
            let canonical = std::fs::canonicalize(folder)
                .ok()
                .filter(|f| f.is_dir())
                .ok_or_else(|| {
                    InputError::file(
                        folder,
                        "there is no such folder",
                        "`--assets` to name an existing folder",
                    )
                })?;
            lookup.push(canonical);
        }
        Ok(Self {
            allowed: lookup.clone(),
            lookup,
            found: Arc::default(),
            room: Room::new(options.capacity.clone()),
        })
    }

    /// The files that have been found so far, each as often as it was asked for.
    pub(super) fn found(&self) -> Vec<PathBuf> {
        self.locked().clone()
    }

    fn locked(&self) -> MutexGuard<'_, Vec<PathBuf>> {
        self.found.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The folders for a file that the scene includes: its own folder first, then the assets.
    pub(super) fn of_included(&self, file: &Path) -> Self {
        let own = file.parent().unwrap_or(Path::new("/")).to_path_buf();
        let mut included = self.clone();
        included.lookup[0] = own.clone();
        included.allowed.push(own);
        included
    }

    /// The file that `field` of `scene_file` calls `name`.
    pub(super) fn resolve(
        &self,
        name: &str,
        scene_file: &Path,
        field: &str,
    ) -> Result<PathBuf, InputError> {
        if name.is_empty() {
            return Err(InputError::new(
                scene_file,
                field,
                "the file name is empty",
                "the name of a file",
            ));
        }
        let mut left_all = true;
        for folder in &self.lookup {
            let candidate = normalized(&folder.join(name));
            if !self.is_allowed(&candidate) {
                continue;
            }
            left_all = false;
            if let Ok(canonical) = std::fs::canonicalize(&candidate) {
                if self.is_allowed(&canonical) && canonical.is_dir() {
                    let problem = format!("`{name}` is a folder");
                    return Err(InputError::new(scene_file, field, problem, "a file"));
                }
                if self.is_allowed(&canonical) {
                    self.locked().push(canonical.clone());
                    return Ok(canonical);
                }
                left_all = true;
                break;
            }
        }
        Err(if left_all {
            InputError::new(
                scene_file,
                field,
                format!("`{name}` leaves the scene's folder"),
                "a file in that folder; put it there or name its folder with --assets",
            )
        } else {
            InputError::new(
                scene_file,
                field,
                format!("`{name}` does not exist"),
                if self.lookup.len() == 1 {
                    "a file in the scene's folder, or in one named with --assets".to_owned()
                } else {
                    "a file in the scene's folder or in one of the --assets folders".to_owned()
                },
            )
        })
    }

    fn is_allowed(&self, path: &Path) -> bool {
        self.allowed.iter().any(|folder| path.starts_with(folder))
    }
}

/// `path` without `.` and `..`, taken textually: nothing outside the allowed folders is ever
/// touched.
fn normalized(path: &Path) -> PathBuf {
    let mut out = PathBuf::new();
    for component in path.components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir => {
                out.pop();
            }
            other => out.push(other),
        }
    }
    out
}

/// The extension in lower case, empty when there is none.
pub(super) fn extension(path: &Path) -> String {
    path.extension()
        .map(|e| e.to_string_lossy().to_lowercase())
        .unwrap_or_default()
}

/// All bytes of a file.
pub(super) fn read(path: &Path) -> Result<Vec<u8>, InputError> {
    // Reading a pipe may never end.
    let metadata = std::fs::metadata(path).map_err(|e| unreadable(path, &e))?;
    if !metadata.is_file() && !metadata.is_dir() {
        return Err(InputError::file(path, "is a pipe or a device", "a file"));
    }
    std::fs::read(path).map_err(|e| unreadable(path, &e))
}

/// What the operating system says about a file that cannot be read, in our words where it is
/// common.
pub(super) fn unreadable(path: &Path, error: &std::io::Error) -> InputError {
    match error.kind() {
        ErrorKind::NotFound => InputError::file(path, "there is no such file", ""),
        ErrorKind::IsADirectory => InputError::file(path, "is a folder", "a file"),
        ErrorKind::PermissionDenied => {
            InputError::file(path, "may not be read by this user", "read permission")
        }
        _ => InputError::file(path, format!("cannot be read: {error}"), ""),
    }
}
