//! Files that are read again when they change.

use crate::gpu::shader::SHADERS_VARIABLE;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

/// How often files are looked at.
const INTERVAL: Duration = Duration::from_millis(300);

/// Looks at a scene file, and at shaders that are read from a folder.
#[derive(Debug)]
pub struct Watch {
    scene: PathBuf,
    shaders: Option<PathBuf>,
    known: State,
    looked: Instant,
}

/// What the files were like.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
struct State {
    scene: Option<SystemTime>,
    /// The newest shader, and how many there are.
    shaders: (Option<SystemTime>, usize),
}

impl Watch {
    /// Looks at `scene` from now on.
    pub fn new(scene: &Path) -> Self {
        let mut watch = Self {
            scene: scene.to_path_buf(),
            shaders: std::env::var_os(SHADERS_VARIABLE).map(PathBuf::from),
            known: State::default(),
            looked: Instant::now(),
        };
        watch.known = watch.look();
        watch
    }

    /// Whether something has changed since it was last asked; looks at the files now and then.
    pub fn has_changed(&mut self) -> bool {
        if self.looked.elapsed() < INTERVAL {
            return false;
        }
        self.looked = Instant::now();
        let state = self.look();
        // An editor may have taken the file away to write a new one.
        let changed = state.scene.is_some() && state != self.known;
        if changed {
            self.known = state;
        }
        changed
    }

    /// How long until it looks again.
    pub fn interval(&self) -> Duration {
        INTERVAL
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
fn newest(folder: &Path, (time, count): &mut (Option<SystemTime>, usize)) {
    let Ok(entries) = folder.read_dir() else {
        return;
    };
    for path in entries.flatten().map(|entry| entry.path()) {
        if path.is_dir() {
            let mut below = (*time, *count);
            newest(&path, &mut below);
            (*time, *count) = below;
        } else {
            *time = (*time).max(modified(&path));
            *count += 1;
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
        let mut watch = Watch::new(&path);
        let look = |watch: &mut Watch| {
            watch.looked -= INTERVAL;
            watch.has_changed()
        };
        assert!(!look(&mut watch));
        let later = SystemTime::now() + Duration::from_secs(5);
        let file = std::fs::File::options().write(true).open(&path);
        file.and_then(|f| f.set_modified(later)).expect("a time");
        assert!(look(&mut watch));
        assert!(!look(&mut watch));
        std::fs::remove_file(&path).expect("removed");
        assert!(!look(&mut watch));
    }
}
