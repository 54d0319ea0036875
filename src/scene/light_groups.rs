//! Groups of lights whose light is kept apart in an image.

use super::ids::ShapeId;
use std::collections::BTreeMap;

/// The group of all lights that name none.
pub const DEFAULT_GROUP: &str = "default";
/// Most groups of a scene.
pub const MAX_LIGHT_GROUPS: usize = 64;

/// Which light belongs to which group. Lights that are not in here belong to [`DEFAULT_GROUP`].
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct LightGroups {
    names: Vec<String>,
    shapes: BTreeMap<ShapeId, u32>,
    lights: BTreeMap<usize, u32>,
    environment: Option<u32>,
}

impl LightGroups {
    /// The groups that are named, in the order in which they were first.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    fn group(&mut self, name: &str) -> u32 {
        let found = self.names.iter().position(|known| known == name);
        let index = found.unwrap_or_else(|| {
            self.names.push(name.to_owned());
            self.names.len() - 1
        });
        u32::try_from(index).expect("fewer than 2³² groups")
    }

    /// Puts a shape that emits into the group `name`.
    pub fn add_shape(&mut self, shape: ShapeId, name: &str) {
        let group = self.group(name);
        self.shapes.insert(shape, group);
    }

    /// Puts the light `index` of those without a surface into the group `name`.
    pub fn add_light(&mut self, index: usize, name: &str) {
        let group = self.group(name);
        self.lights.insert(index, group);
    }

    /// Puts the environment into the group `name`.
    pub fn set_environment(&mut self, name: &str) {
        self.environment = Some(self.group(name));
    }

    /// The group of a shape.
    pub fn of_shape(&self, shape: ShapeId) -> Option<u32> {
        self.shapes.get(&shape).copied()
    }

    /// The group of a light without a surface.
    pub fn of_light(&self, index: usize) -> Option<u32> {
        self.lights.get(&index).copied()
    }

    /// The group of the environment.
    pub fn of_environment(&self) -> Option<u32> {
        self.environment
    }

    /// Why `name` is no name of a group; `None` where it is one. It becomes a part of channels'
    /// names.
    pub fn problem(name: &str) -> Option<String> {
        let fits = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-');
        let fine = !name.is_empty() && name.len() <= 64 && name.chars().all(fits);
        (!fine).then(|| format!("is \"{name}\""))
    }

    /// What a name of a group is.
    pub const NAME: &str = "a name of 1 to 64 letters, digits, `_` or `-`";
}
