//! Files that are read again when they change.

use crate::gpu::shader::SHADERS_VARIABLE;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, SystemTime};

/// How often files are looked at.
const INTERVAL: Duration = Duration::from_millis(300);

/// Looks at a scene file, and at shaders that are read from a folder, for as long as it lives.
#[derive(Debug)]
pub struct Watch {
    changed: Arc<AtomicBool>,
}

impl Watch {
    /// Looks at `scene` from now on, and calls `wake` when something has changed.
    pub fn new(scene: &Path, wake: impl Fn() + Send + 'static) -> Self {
        let changed = Arc::new(AtomicBool::new(false));
        let still_asked_for = Arc::downgrade(&changed);
        let mut files = Files::new(scene);
        std::thread::spawn(move || {
            loop {
                std::thread::sleep(INTERVAL);
                let Some(changed) = still_asked_for.upgrade() else {
                    return;
                };
                if files.have_changed() {
                    changed.store(true, Ordering::Release);
                    wake();
                }
            }
        });
        Self { changed }
    }

    /// Whether something has changed since it was last asked.
    pub fn has_changed(&self) -> bool {
        self.changed.swap(false, Ordering::AcqRel)
    }
}

/// The files, and what they were like.
#[derive(Debug)]
struct Files {
    scene: PathBuf,
    shaders: Option<PathBuf>,
    known: State,
}

#[derive(Debug, Clone, PartialEq, Eq, Default)]
struct State {
    scene: Option<SystemTime>,
    /// The newest shader, and how many there are.
    shaders: (Option<SystemTime>, usize),
}

impl Files {
    fn new(scene: &Path) -> Self {
        let mut files = Self {
            scene: scene.to_path_buf(),
            shaders: std::env::var_os(SHADERS_VARIABLE).map(PathBuf::from),
            known: State::default(),
        };
        files.known = files.look();
        files
    }

    fn have_changed(&mut self) -> bool {
        let state = self.look();
        // An editor may have taken the file away to write a new one.
        let changed = state.scene.is_some() && state != self.known;
        if changed {
            self.known = state;
        }
        changed
    }

    fn look(&self) -> State {
        let mut shaders = (None, 0);
        if let Some(folder) = &self.shaders {
            newest(folder, &mut shaders);
        }
        State {
            scene: modified(&self.scene),
            shaders,
        }
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
        let mut files = Files::new(&path);
        assert!(!files.have_changed());
        let later = SystemTime::now() + Duration::from_secs(5);
        let file = std::fs::File::options().write(true).open(&path);
        file.and_then(|f| f.set_modified(later)).expect("a time");
        assert!(files.have_changed());
        assert!(!files.have_changed());
        std::fs::remove_file(&path).expect("removed");
        assert!(!files.have_changed());
    }
}
