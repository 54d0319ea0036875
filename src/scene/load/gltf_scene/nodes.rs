//! The node hierarchy: every node of the default scene with its transform to the world.

use super::document::Document;
use crate::error::InputError;
use glam::{DAffine3, DMat4, DQuat, DVec3};
use gltf::json::scene::Node;
use std::collections::HashSet;

/// A node of the default scene.
pub(super) struct Placed {
    /// Its index in the file.
    pub(super) index: usize,
    /// From the node's space to the file's world.
    pub(super) to_world: DAffine3,
}

/// The nodes of the default scene, parents before children; all nodes of a file without scenes.
///
/// A node that is reached twice (a cycle, or two parents, which glTF forbids) is an error; that also bounds the work.
pub(super) fn of_default_scene(document: &Document) -> Result<Vec<Placed>, InputError> {
    let root = &document.root;
    let mut reached = vec![false; root.nodes.len()];
    let mut placed = Vec::new();
    let mut open = roots(document)?;
    while let Some((index, parent, from)) = open.pop() {
        let node = document.get(&root.nodes, index, "node", || from.clone())?;
        if std::mem::replace(&mut reached[index], true) {
            return Err(document.error(
                from,
                format!("node {index} is reached twice"),
                "a tree: no cycle, and one parent for each node",
            ));
        }
        let to_world = parent * local(node);
        for child in node.children.iter().flatten().rev() {
            open.push((child.value(), to_world, format!("nodes[{index}].children")));
        }
        placed.push(Placed { index, to_world });
    }
    Ok(placed)
}

/// The nodes at which the default scene begins, last first.
fn roots(document: &Document) -> Result<Vec<(usize, DAffine3, String)>, InputError> {
    let root = &document.root;
    let (indices, from): (Vec<usize>, _) = if root.scene.is_none() && root.scenes.is_empty() {
        let children = root.nodes.iter().flat_map(|n| n.children.iter().flatten());
        let children: HashSet<usize> = children.map(|c| c.value()).collect();
        let all = 0..root.nodes.len();
        let parentless = all.filter(|index| !children.contains(index));
        (parentless.collect(), "nodes".to_owned())
    } else {
        let (number, field) = match root.scene {
            Some(index) => (index.value(), "scene"),
            None => (0, "scenes"),
        };
        let scene = document.get(&root.scenes, number, "scene", || field.to_owned())?;
        let indices = scene.nodes.iter().map(|n| n.value());
        (indices.collect(), format!("scenes[{number}].nodes"))
    };
    let reached = |index| (index, DAffine3::IDENTITY, from.clone());
    Ok(indices.into_iter().rev().map(reached).collect())
}

fn local(node: &Node) -> DAffine3 {
    if let Some(matrix) = node.matrix {
        let matrix = DMat4::from_cols_array(&matrix.map(f64::from));
        return DAffine3::from_mat4(matrix);
    }
    let vector = |v: Option<[f32; 3]>, default: DVec3| {
        v.map_or(default, |v| DVec3::from_array(v.map(f64::from)))
    };
    let rotation = node
        .rotation
        .map(|q| DQuat::from_array(q.0.map(f64::from)))
        .filter(|q| q.length_squared() > 0.0 && q.is_finite())
        .map_or(DQuat::IDENTITY, DQuat::normalize);
    DAffine3::from_scale_rotation_translation(
        vector(node.scale, DVec3::ONE),
        rotation,
        vector(node.translation, DVec3::ZERO),
    )
}
