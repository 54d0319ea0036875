//! The group of every light.

use crate::scene::light_groups::DEFAULT_GROUP;
use crate::scene::{Aov, RenderSettings, Scene};

/// The groups of a render's lights.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct EmitterGroups {
    /// Their names; none where no image keeps them apart.
    pub names: Vec<String>,
    of_light: Vec<u32>,
}

impl EmitterGroups {
    /// The groups of lights that name them in `scene`, or name none. Empty unless
    /// [`Aov::LightGroups`] is asked for.
    pub(super) fn new(scene: &Scene, settings: &RenderSettings, of_light: &[Option<u32>]) -> Self {
        if !settings.aovs.contains(Aov::LightGroups) {
            return Self::default();
        }
        let mut names = scene.light_groups.names().to_vec();
        let known = names.iter().position(|name| name == DEFAULT_GROUP);
        let others = known.unwrap_or(names.len());
        if known.is_none() && (names.is_empty() || of_light.iter().any(Option::is_none)) {
            names.push(DEFAULT_GROUP.to_owned());
        }
        let group = |group: &Option<u32>| group.unwrap_or(others as u32);
        Self {
            names,
            of_light: of_light.iter().map(group).collect(),
        }
    }

    /// How many a render keeps apart; at least one, so that there is an array of them.
    pub fn count(&self) -> u32 {
        self.names.len().max(1) as u32
    }

    /// The group of light `index`.
    pub fn of_light(&self, index: usize) -> u32 {
        self.of_light.get(index).copied().unwrap_or(0)
    }
}
