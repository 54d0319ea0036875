//! Sets of texture coordinates: glTF has any number, and a mesh carries the two that its material
//! reads.

use super::document::Document;
use super::textures::Named;
use gltf::json::material::Material;
use gltf::json::mesh::{Primitive, Semantic};
use gltf::json::validation::Checked;

/// The sets that a primitive brings to the textures of its material: n of TEXCOORD_n.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct CoordinateSets {
    pub(super) first: u32,
    pub(super) second: Option<u32>,
}

impl CoordinateSets {
    /// Those that the material of `primitive` asks for first. Where it has one of two, that is the
    /// first; where it has neither, its textures are not read.
    pub(super) fn of(document: &Document, primitive: &Primitive) -> Self {
        let material = primitive.material.map(|m| m.value());
        let material = material.and_then(|index| document.root.materials.get(index));
        let asked = material.map_or_else(Vec::new, asked_sets);
        let Some(&first) = asked.first() else {
            return Self {
                first: 0,
                second: None,
            };
        };
        let second = asked.get(1).copied();
        match second {
            Some(second) if has_set(primitive, first) != has_set(primitive, second) => Self {
                first: if has_set(primitive, first) {
                    first
                } else {
                    second
                },
                second: None,
            },
            _ => Self { first, second },
        }
    }

    /// The texture `named`, told which of the sets it is read with; `None` where that is neither.
    pub(super) fn choose(self, mut named: Named) -> Option<Named> {
        named.second_uvs = self.second == Some(named.coordinates);
        let chosen = named.second_uvs || self.first == named.coordinates;
        chosen.then_some(named)
    }
}

/// The sets that the textures of `material` are read with, each once, in the order in which
/// textures name them.
pub(super) fn asked_sets(material: &Material) -> Vec<u32> {
    let mut sets = Vec::new();
    for named in Named::all(material) {
        if !sets.contains(&named.coordinates) {
            sets.push(named.coordinates);
        }
    }
    sets
}

/// Whether `primitive` has TEXCOORD_`set`.
pub(super) fn has_set(primitive: &Primitive, set: u32) -> bool {
    let attributes = &primitive.attributes;
    attributes.contains_key(&Checked::Valid(Semantic::TexCoords(set)))
}
