//! The hierarchy as the GPU reads it: boxes on a 16-bit grid over the scene, two children per
//! 32-byte node.

use super::grid::Grid;
use glam::DVec3;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;

/// Deepest hierarchy that the traversal's stack takes.
pub const MAX_DEPTH: usize = 64;
/// Most primitives in one leaf: the reference has three bits for the count.
pub const MAX_LEAF_PRIMITIVES: u32 = 8;
/// Most primitives: a leaf's reference has 28 bits for the first one.
pub const MAX_PRIMITIVES: u64 = 1 << 28;
/// Marks a reference as a leaf.
pub const LEAF: u32 = 0x8000_0000;
/// An inner node. Per child three words, one per axis (lower plane in the low half), and a
/// reference.
#[derive(Debug, Clone, Copy, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Node {
    /// Box of the first child.
    pub first_box: [u32; 3],
    /// Reference to the first child.
    pub first: u32,
    /// Box of the second child.
    pub second_box: [u32; 3],
    /// Reference to the second child.
    pub second: u32,
}

/// A flattened hierarchy.
#[derive(Debug, Clone, PartialEq)]
pub struct Bvh {
    /// Inner nodes, parents before children.
    pub nodes: Vec<Node>,
    /// Reference to the root: a node, or a leaf when there are few primitives.
    pub root: u32,
    /// Entries that a traversal's stack needs at most.
    pub depth: usize,
    /// The grid that the boxes are rounded to.
    pub grid: Grid,
    /// What is not large, where a few primitives are large beside the others.
    pub small: Option<Small>,
}

/// All primitives but a few that are large, which come after them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Small {
    /// How many they are.
    pub count: usize,
    /// Reference to the root of the hierarchy over them.
    pub root: u32,
    /// The box around them on the grid.
    pub grid_box: [u32; 3],
    /// The box around them.
    pub bounds: [DVec3; 2],
}

impl Default for Bvh {
    fn default() -> Self {
        Self {
            nodes: Vec::new(),
            root: LEAF,
            depth: 0,
            grid: Grid::default(),
            small: None,
        }
    }
}

/// Flattens `parts`, whose primitives are already in the order of their leaves, one part after the
/// other: all primitives, or the small and the large ones.
pub fn flatten(parts: &[&Bvh2]) -> Bvh {
    let boxes = parts.iter().map(|part| *part.nodes[0].aabb());
    let [low, high] = corners(&boxes.fold(Aabb::INVALID, |a, b| a.union(&b)));
    let mut bvh = flatten_all(parts, Grid::even(low, high));
    if let [small, _] = parts {
        let top = &bvh.nodes[bvh.root as usize];
        bvh.small = Some(Small {
            count: small.primitive_indices.len(),
            root: top.first,
            grid_box: top.first_box,
            bounds: corners(small.nodes[0].aabb()),
        });
    }
    bvh
}

/// The lower and the upper corner of a box.
fn corners(of: &Aabb) -> [DVec3; 2] {
    [of.min, of.max].map(|corner| glam::Vec3::from(corner).as_dvec3())
}

/// The hierarchy that holds all of `parts`, whose primitives are already in the order of their
/// leaves, one part after the other.
pub fn flatten_all(parts: &[&Bvh2], grid: Grid) -> Bvh {
    let nodes = parts.iter().map(|part| part.nodes.len() / 2 + 1).sum();
    let mut out = Bvh {
        nodes: Vec::with_capacity(nodes),
        grid,
        ..Bvh::default()
    };
    out.root = flatten_parts(parts, 0, 0, &mut out);
    assert!(out.depth <= MAX_DEPTH, "the builder caps the depth");
    out
}

/// The reference to the hierarchy of `parts`, the first of whose primitives is `first`.
fn flatten_parts(parts: &[&Bvh2], first: u32, depth: usize, out: &mut Bvh) -> u32 {
    let (part, others) = parts.split_first().expect("there is a primitive");
    if others.is_empty() {
        return flatten_node(part, first, 0, depth, out);
    }
    let of_others = others.iter().map(|p| p.nodes[0].aabb());
    let of_others = of_others.fold(Aabb::INVALID, |a, b| a.union(b));
    let place = out.open_node(depth, [part.nodes[0].aabb(), &of_others]);
    let count = part.primitive_indices.len() as u32;
    out.nodes[place].first = flatten_node(part, first, 0, depth + 1, out);
    out.nodes[place].second = flatten_parts(others, first + count, depth + 1, out);
    place as u32
}

fn flatten_node(bvh2: &Bvh2, first: u32, index: usize, depth: usize, out: &mut Bvh) -> u32 {
    let node = &bvh2.nodes[index];
    if node.prim_count > 0 {
        let first = first + node.first_index;
        assert!(node.prim_count <= MAX_LEAF_PRIMITIVES && u64::from(first) < MAX_PRIMITIVES);
        return LEAF | (node.prim_count - 1) << 28 | first;
    }
    let children = [node.first_index as usize, node.first_index as usize + 1];
    let place = out.open_node(depth, children.map(|c| bvh2.nodes[c].aabb()));
    let [left, right] = children.map(|c| flatten_node(bvh2, first, c, depth + 1, out));
    out.nodes[place].first = left;
    out.nodes[place].second = right;
    place as u32
}

impl Bvh {
    /// Adds a node with the boxes of its children, at `depth`; returns its index.
    fn open_node(&mut self, depth: usize, children: [&Aabb; 2]) -> usize {
        self.depth = self.depth.max(depth + 1);
        let [first_box, second_box] =
            children.map(|b| self.grid.box_words(b.min.into(), b.max.into()));
        self.nodes.push(Node {
            first_box,
            first: 0,
            second_box,
            second: 0,
        });
        self.nodes.len() - 1
    }
}
