//! Files that are read again when they change.

use direkt::low_level::gpu::shader::SHADERS_VARIABLE;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, SystemTime};

/// How often files are looked at.
const INTERVAL: Duration = Duration::from_millis(300);

/// Looks at files, and at shaders that are read from a folder, for as long as it lives.
#[derive(Debug)]
pub struct Watch {
    shared: Arc<Shared>,
}

#[derive(Debug, Default)]
struct Shared {
    files: Mutex<BTreeSet<PathBuf>>,
    changed: AtomicBool,
}

impl Shared {
    fn files(&self) -> MutexGuard<'_, BTreeSet<PathBuf>> {
        self.files.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Watch {
    /// Looks at `files` from now on, and calls `wake` when something has changed.
    pub fn new(files: BTreeSet<PathBuf>, wake: impl Fn() + Send + 'static) -> Self {
        let mut known = Known {
            shader_folder: std::env::var_os(SHADERS_VARIABLE).map(PathBuf::from),
            ..Known::default()
        };
        known.have_changed(&files);
        let shared = Arc::new(Shared {
            files: Mutex::new(files),
            ..Shared::default()
        });
        let still_asked_for = Arc::downgrade(&shared);
        std::thread::spawn(move || {
            loop {
                std::thread::sleep(INTERVAL);
                let Some(shared) = still_asked_for.upgrade() else {
                    return;
                };
                let files = shared.files().clone();
                if known.have_changed(&files) {
                    shared.changed.store(true, Ordering::Release);
                    wake();
                }
            }
        });
        Self { shared }
    }

    /// Looks at `files` instead of those before.
    pub fn follow(&self, files: BTreeSet<PathBuf>) {
        *self.shared.files() = files;
    }

    /// Whether something has changed since it was last asked.
    pub fn has_changed(&self) -> bool {
        self.shared.changed.swap(false, Ordering::AcqRel)
    }
}

/// What files were like.
#[derive(Debug, Default)]
struct Known {
    files: BTreeMap<PathBuf, SystemTime>,
    shader_folder: Option<PathBuf>,
    /// The newest shader and how many there are, once they were looked at.
    shaders: Option<(Option<SystemTime>, usize)>,
}

impl Known {
    /// Whether one of `files`, or a shader, is not what it was when it was last looked at.
    fn have_changed(&mut self, files: &BTreeSet<PathBuf>) -> bool {
        let mut changed = false;
        for file in files {
            // An editor may have taken it away to write a new one.
            let Some(now) = modified(file) else {
                continue;
            };
            let before = self.files.insert(file.clone(), now);
            changed |= before.is_some_and(|before| before != now);
        }
        let mut shaders = (None, 0);
        if let Some(folder) = &self.shader_folder {
            newest(folder, &mut shaders);
        }
        let before = self.shaders.replace(shaders);
        changed || before.is_some_and(|before| before != shaders)
    }
}

fn modified(path: &Path) -> Option<SystemTime> {
    path.metadata().and_then(|m| m.modified()).ok()
}

/// Enters all files below `folder`.
fn newest(folder: &Path, found: &mut (Option<SystemTime>, usize)) {
    let Ok(entries) = folder.read_dir() else {
        return;
    };
    for path in entries.flatten().map(|entry| entry.path()) {
        if path.is_dir() {
            newest(&path, found);
        } else {
            found.0 = found.0.max(modified(&path));
            found.1 += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_is_seen_once_and_a_missing_file_is_none() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("scene.toml");
        std::fs::write(&path, "a").expect("written");
        let files = BTreeSet::from([path.clone()]);
        let mut known = Known::default();
        assert!(!known.have_changed(&files));
        assert!(!known.have_changed(&files));
        let later = SystemTime::now() + Duration::from_secs(5);
        let file = std::fs::File::options().write(true).open(&path);
        file.and_then(|f| f.set_modified(later)).expect("a time");
        assert!(known.have_changed(&files));
        assert!(!known.have_changed(&files));
        std::fs::remove_file(&path).expect("removed");
        assert!(!known.have_changed(&files));
    }

    #[test]
    fn shaders_that_come_change_and_go_are_seen() {
        let folder = tempfile::tempdir().expect("a folder");
        let none = BTreeSet::new();
        let mut known = Known {
            shader_folder: Some(folder.path().to_owned()),
            ..Known::default()
        };
        assert!(!known.have_changed(&none));
        let path = folder.path().join("kernel/direct.wesl");
        std::fs::create_dir(folder.path().join("kernel")).expect("a folder");
        std::fs::write(&path, "a").expect("written");
        assert!(known.have_changed(&none), "the first shader");
        assert!(!known.have_changed(&none));
        let later = SystemTime::now() + Duration::from_secs(5);
        let file = std::fs::File::options().write(true).open(&path);
        file.and_then(|f| f.set_modified(later)).expect("a time");
        assert!(known.have_changed(&none));
        std::fs::remove_file(&path).expect("removed");
        assert!(known.have_changed(&none), "the last shader");
        assert!(!known.have_changed(&none));
    }
}
