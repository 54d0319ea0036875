//! The triangles that a scene may have: counted by what its files promise, before these are read.

use crate::error::InputError;
use crate::scene::{Geometry, Scene};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Most triangles that a scene may have.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Capacity {
    /// Their number.
    pub triangles: u64,
    /// Whose limit that is, as messages say it behind their number.
    pub reason: String,
}

/// What is left of a capacity, shared by all that reads a scene's files.
#[derive(Debug, Clone, Default)]
pub(super) struct Room {
    capacity: Option<Capacity>,
    taken: Arc<AtomicU64>,
}

impl Room {
    pub(super) fn new(capacity: Option<Capacity>) -> Self {
        Self {
            capacity,
            taken: Arc::default(),
        }
    }

    /// Whether `triangles` more could be too many: where they cannot, nothing needs to be counted.
    pub(super) fn may_lack(&self, triangles: u64) -> bool {
        let taken = self.taken.load(Ordering::Relaxed);
        let capacity = self.capacity.as_ref();
        capacity.is_some_and(|c| taken.saturating_add(triangles) > c.triangles)
    }

    /// Takes room for `triangles` of `path`, which `field` promises.
    ///
    /// # Errors
    /// With those of the files before they are more than there is room for.
    pub(super) fn take(&self, path: &Path, field: &str, triangles: u64) -> Result<(), InputError> {
        let before = self.taken.fetch_add(triangles, Ordering::Relaxed);
        let Some(capacity) = &self.capacity else {
            return Ok(());
        };
        let all = before.saturating_add(triangles);
        if all <= capacity.triangles {
            return Ok(());
        }
        let others = if before > 0 {
            format!(", with those before them {all}")
        } else {
            String::new()
        };
        let problem = format!("makes {triangles} triangles{others}");
        let expected = format!(
            "at most {} in a scene, {}",
            capacity.triangles, capacity.reason
        );
        Err(InputError::new(path, field, problem, expected))
    }
}

/// Refuses a scene whose meshes make more triangles than its files promised and there is room for,
/// as polygons do.
///
/// # Errors
/// They do.
pub(super) fn check(scene: &Scene, capacity: Option<&Capacity>) -> Result<(), InputError> {
    let room = Room::new(capacity.cloned());
    for shape in &scene.shapes {
        if let Geometry::Mesh(mesh) = &shape.geometry {
            room.take(&scene.source, &shape.name, mesh.triangles.len() as u64)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn room(triangles: u64) -> Room {
        Room::new(Some(Capacity {
            triangles,
            reason: "which is what a GPU takes".to_owned(),
        }))
    }

    #[test]
    fn room_is_taken_until_none_is_left() {
        let room = room(10);
        let take = |triangles| room.take(Path::new("m.ply"), "element face", triangles);
        assert!(!room.may_lack(10) && room.may_lack(11));
        assert!(take(6).is_ok() && take(4).is_ok());
        let message = take(1).expect_err("no room").to_string();
        for part in [
            "m.ply",
            "element face",
            "1 triangles",
            "11",
            "at most 10",
            "a GPU",
        ] {
            assert!(message.contains(part), "{message}");
        }
    }

    #[test]
    fn without_a_capacity_there_is_room_for_all() {
        let room = Room::default();
        assert!(!room.may_lack(u64::MAX));
        assert!(
            room.take(Path::new("m.ply"), "element face", u64::MAX)
                .is_ok()
        );
        assert!(
            room.take(Path::new("m.ply"), "element face", u64::MAX)
                .is_ok()
        );
    }
}
