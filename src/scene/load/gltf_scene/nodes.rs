//! The node hierarchy: every node of the default scene with its transform to the world.

use super::document::Document;
use crate::error::InputError;
use glam::{DAffine3, DMat4, DQuat, DVec3};
use gltf::json::scene::Node;
use serde_json::Value;
use std::collections::HashSet;

/// A node of the default scene.
pub(super) struct Placed {
    /// Its index in the file.
    pub(super) index: usize,
    /// From the node's space to the file's world.
    pub(super) to_world: DAffine3,
    /// Whether its mesh and its light are there: neither it nor a node above it is hidden by
    /// KHR_node_visibility.
    pub(super) visible: bool,
}

/// A node that is reached and not yet placed.
struct Reached {
    index: usize,
    parent: DAffine3,
    visible: bool,
    /// The list that names it.
    from: String,
}

/// The nodes of the default scene, parents before children; all nodes of a file without scenes.
///
/// A node that is reached twice (a cycle, or two parents, which glTF forbids) is an error; that
/// also bounds the work.
pub(super) fn of_default_scene(document: &Document) -> Result<Vec<Placed>, InputError> {
    let nodes = &document.root.nodes;
    let mut reached = vec![false; nodes.len()];
    let mut placed = Vec::new();
    let mut open = roots(document)?;
    while let Some(Reached {
        index,
        parent,
        visible,
        from,
    }) = open.pop()
    {
        let node = document.get(nodes, index, "node", || from.clone())?;
        if std::mem::replace(&mut reached[index], true) {
            return Err(document.error(
                from,
                format!("node {index} is reached twice"),
                "a tree: no cycle, and one parent for each node",
            ));
        }
        let to_world = parent * local(node);
        let visible = visible && !is_hidden(document, index)?;
        for child in node.children.iter().flatten().rev() {
            open.push(Reached {
                index: child.value(),
                parent: to_world,
                visible,
                from: format!("nodes[{index}].children"),
            });
        }
        placed.push(Placed {
            index,
            to_world,
            visible,
        });
    }
    Ok(placed)
}

/// The nodes at which the default scene begins, last first.
fn roots(document: &Document) -> Result<Vec<Reached>, InputError> {
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
    let reached = |index| Reached {
        index,
        parent: DAffine3::IDENTITY,
        visible: true,
        from: from.clone(),
    };
    Ok(indices.into_iter().rev().map(reached).collect())
}

/// What KHR_node_visibility says of node `index` itself.
fn is_hidden(document: &Document, index: usize) -> Result<bool, InputError> {
    const NAME: &str = "KHR_node_visibility";
    let extensions = document.root.nodes[index].extensions.as_ref();
    let visible = extensions.and_then(|e| e.others.get(NAME)?.get("visible"));
    match visible {
        None | Some(Value::Bool(true)) => Ok(false),
        Some(Value::Bool(false)) => Ok(true),
        Some(other) => Err(document.error(
            format!("nodes[{index}].extensions.{NAME}.visible"),
            format!("is {other}"),
            "true or false",
        )),
    }
}

/// Node `index` and those above it, outermost first, with their transforms to the world.
pub(super) fn above(
    document: &Document,
    index: usize,
) -> Result<Vec<(usize, DAffine3)>, InputError> {
    let nodes = &document.root.nodes;
    let mut parents = vec![None; nodes.len()];
    for (parent, node) in nodes.iter().enumerate() {
        for child in node.children.iter().flatten() {
            if let Some(slot) = parents.get_mut(child.value()) {
                *slot = Some(parent);
            }
        }
    }
    let mut chain = vec![index];
    while let Some(parent) = parents[chain[chain.len() - 1]] {
        if chain.len() == nodes.len() {
            return Err(document.error(
                format!("nodes[{parent}].children"),
                format!("node {index} is below itself"),
                "a tree: no cycle, and one parent for each node",
            ));
        }
        chain.push(parent);
    }
    let mut to_world = DAffine3::IDENTITY;
    let placed = chain.into_iter().rev().map(|node| {
        to_world *= local(&nodes[node]);
        (node, to_world)
    });
    Ok(placed.collect())
}

fn local(node: &Node) -> DAffine3 {
    if let Some(matrix) = node.matrix {
        let matrix = DMat4::from_cols_array(&matrix.map(f64::from));
        return DAffine3::from_mat4(matrix);
    }
    let vector = |v: Option<[f32; 3]>, default: DVec3| {
        v.map_or(default, |v| DVec3::from_array(v.map(f64::from)))
    };
    compose(
        vector(node.translation, DVec3::ZERO),
        node.rotation.map(|q| DQuat::from_array(q.0.map(f64::from))),
        vector(node.scale, DVec3::ONE),
    )
}

/// Scale, then rotation, then translation; a rotation that is none does nothing.
pub(super) fn compose(translation: DVec3, rotation: Option<DQuat>, scale: DVec3) -> DAffine3 {
    let rotation = rotation
        .filter(|q| q.length_squared() > 0.0 && q.is_finite())
        .map_or(DQuat::IDENTITY, DQuat::normalize);
    DAffine3::from_scale_rotation_translation(scale, rotation, translation)
}
