//! The hierarchy as the GPU reads it: boxes on a 16-bit grid over the scene, two children per 32-byte node.

use glam::{DVec3, Vec3};
use obvhs::bvh2::Bvh2;

/// Deepest hierarchy that the traversal's stack takes.
pub const MAX_DEPTH: usize = 64;
/// Most primitives in one leaf: the reference has three bits for the count.
pub const MAX_LEAF_PRIMITIVES: u32 = 8;
/// Marks a reference as a leaf.
pub const LEAF: u32 = 0x8000_0000;
/// Cells of the grid per axis.
const CELLS: f64 = 65_535.0;
/// Boxes grow by this many cells before they are rounded outwards: more than the slab test's rounding, which is at
/// most 2⁻²⁴ of the grid per operation.
const PADDING: f64 = 0.0625;

/// An inner node. Per child three words, one per axis (lower plane in the low half), and a reference.
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
    /// Lower corner of the grid, normalised space.
    pub grid_origin: Vec3,
    /// Grid cells per unit length.
    pub grid_scale: Vec3,
}

impl Default for Bvh {
    fn default() -> Self {
        Self {
            nodes: Vec::new(),
            root: LEAF,
            depth: 0,
            grid_origin: Vec3::ZERO,
            grid_scale: Vec3::ONE,
        }
    }
}

impl Bvh {
    /// The words of a box of normalised space, as a node has them, with a cell of margin.
    pub fn box_words(&self, low: DVec3, high: DVec3) -> [u32; 3] {
        let grid = Grid {
            origin: self.grid_origin.as_dvec3(),
            scale: self.grid_scale.as_dvec3(),
        };
        let cell = DVec3::ONE / grid.scale;
        let (low, high) = ((low - cell).as_vec3(), (high + cell).as_vec3());
        [0, 1, 2].map(|axis| grid.axis_word(axis, low[axis], high[axis]))
    }
}

/// The grid that the boxes are rounded to. Its origin and scale are those of the GPU, in f32.
struct Grid {
    origin: DVec3,
    scale: DVec3,
}

impl Grid {
    fn axis_word(&self, axis: usize, low: f32, high: f32) -> u32 {
        let cell = |x: f32| (f64::from(x) - self.origin[axis]) * self.scale[axis];
        let low = (cell(low) - PADDING).floor().clamp(0.0, CELLS) as u32;
        let high = (cell(high) + PADDING).ceil().clamp(0.0, CELLS) as u32;
        low | high << 16
    }
}

/// Flattens `bvh2`, whose primitives are already in the order of its leaves.
pub fn flatten(bvh2: &Bvh2) -> Bvh {
    let root_box = bvh2.nodes[0].aabb();
    let low = Vec3::from(root_box.min).as_dvec3();
    let high = Vec3::from(root_box.max).as_dvec3();
    // One cell of margin on each side, and no axis without extent.
    let extent = (high - low).max(DVec3::splat((high - low).max_element() * 1e-3 + 1e-30));
    let grid_scale = (DVec3::splat(CELLS - 2.0) / extent).as_vec3();
    let grid_origin = (low - DVec3::ONE / grid_scale.as_dvec3()).as_vec3();
    let grid = Grid {
        origin: grid_origin.as_dvec3(),
        scale: grid_scale.as_dvec3(),
    };
    let mut out = Bvh {
        nodes: Vec::with_capacity(bvh2.nodes.len() / 2),
        root: 0,
        depth: 0,
        grid_origin,
        grid_scale,
    };
    out.root = flatten_node(bvh2, &grid, 0, 0, &mut out.nodes, &mut out.depth);
    assert!(out.depth <= MAX_DEPTH, "the builder caps the depth");
    out
}

fn flatten_node(
    bvh2: &Bvh2,
    grid: &Grid,
    index: usize,
    depth: usize,
    nodes: &mut Vec<Node>,
    deepest: &mut usize,
) -> u32 {
    let node = &bvh2.nodes[index];
    if node.prim_count > 0 {
        assert!(node.prim_count <= MAX_LEAF_PRIMITIVES && node.first_index < 1 << 28);
        return LEAF | (node.prim_count - 1) << 28 | node.first_index;
    }
    *deepest = (*deepest).max(depth + 1);
    let children = [node.first_index as usize, node.first_index as usize + 1];
    let [first_box, second_box] = children.map(|c| {
        let b = bvh2.nodes[c].aabb();
        [0, 1, 2].map(|axis| grid.axis_word(axis, b.min[axis], b.max[axis]))
    });
    let place = nodes.len();
    nodes.push(Node {
        first_box,
        first: 0,
        second_box,
        second: 0,
    });
    let [first, second] = children.map(|c| flatten_node(bvh2, grid, c, depth + 1, nodes, deepest));
    nodes[place].first = first;
    nodes[place].second = second;
    place as u32
}
