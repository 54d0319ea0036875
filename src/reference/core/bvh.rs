//! The reference's own hierarchy: a binary BVH of f64 boxes by binned surface-area heuristic, over
//! the same primitives as the renderer's but not built from it.

use glam::DVec3;

/// Primitives in a leaf at most, unless they cannot be told apart.
const LEAF_SIZE: usize = 4;
/// Candidate planes per axis.
const BINS: usize = 16;

/// An axis-parallel box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aabb {
    /// Corner with the smallest coordinates.
    pub low: DVec3,
    /// Corner with the largest coordinates.
    pub high: DVec3,
}

impl Aabb {
    const EMPTY: Self = Self {
        low: DVec3::INFINITY,
        high: DVec3::NEG_INFINITY,
    };

    fn union(self, other: Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }

    fn half_area(&self) -> f64 {
        let d = (self.high - self.low).max(DVec3::ZERO);
        d.x * d.y + d.y * d.z + d.z * d.x
    }

    fn center(&self) -> DVec3 {
        0.5 * (self.low + self.high)
    }
}

/// Where the ray `origin + t / inv_direction` enters the box within [0, t_max]; `None` where it
/// misses. Boxes are padded by the build, so rounding loses nothing; a NaN of 0·∞ counts as inside,
/// since `max` and `min` drop it.
pub fn enter_box(origin: DVec3, inv_direction: DVec3, aabb: &Aabb, t_max: f64) -> Option<f64> {
    let (mut enter, mut leave) = (0.0_f64, t_max);
    for axis in 0..3 {
        let a = (aabb.low[axis] - origin[axis]) * inv_direction[axis];
        let b = (aabb.high[axis] - origin[axis]) * inv_direction[axis];
        enter = enter.max(a.min(b));
        leave = leave.min(a.max(b));
    }
    (enter <= leave).then_some(enter)
}

/// What a node holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Children {
    /// Indices of two nodes.
    Inner(u32, u32),
    /// A range of [`Bvh::order`].
    Leaf(u32, u32),
}

/// A node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node {
    /// Box around everything below.
    pub aabb: Aabb,
    /// What is below.
    pub children: Children,
}

/// A hierarchy; node 0 is the root.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Bvh {
    /// The nodes; none where there is no primitive.
    pub nodes: Vec<Node>,
    /// Indices of primitives, grouped by leaf.
    pub order: Vec<u32>,
}

impl Bvh {
    /// Builds a hierarchy over the boxes of primitives 0, 1, 2, ….
    pub fn new(boxes: &[(DVec3, DVec3)]) -> Self {
        let padded: Vec<Aabb> = boxes
            .iter()
            .map(|&(low, high)| {
                let pad = DVec3::splat(1e-12 * low.abs().max(high.abs()).max_element());
                Aabb {
                    low: low - pad,
                    high: high + pad,
                }
            })
            .collect();
        let mut bvh = Self {
            nodes: Vec::new(),
            order: (0..boxes.len() as u32).collect(),
        };
        if !boxes.is_empty() {
            let mut order = std::mem::take(&mut bvh.order);
            bvh.split(&padded, &mut order, 0);
            bvh.order = order;
        }
        bvh
    }

    /// Appends the subtree over `order`, which starts at `first`; returns its root.
    fn split(&mut self, boxes: &[Aabb], order: &mut [u32], first: u32) -> u32 {
        let node = self.nodes.len() as u32;
        let around = order
            .iter()
            .fold(Aabb::EMPTY, |a, &i| a.union(boxes[i as usize]));
        self.nodes.push(Node {
            aabb: around,
            children: Children::Leaf(first, first + order.len() as u32),
        });
        if order.len() <= LEAF_SIZE {
            return node;
        }
        let Some(middle) = partition(boxes, order) else {
            return node;
        };
        let (left, right) = order.split_at_mut(middle);
        let a = self.split(boxes, left, first);
        let b = self.split(boxes, right, first + middle as u32);
        self.nodes[node as usize].children = Children::Inner(a, b);
        node
    }
}

/// Reorders `order` into two halves and returns where the second begins; `None` where all centres
/// coincide.
fn partition(boxes: &[Aabb], order: &mut [u32]) -> Option<usize> {
    let centers = order.iter().fold(Aabb::EMPTY, |a, &i| {
        let c = boxes[i as usize].center();
        a.union(Aabb { low: c, high: c })
    });
    let size = centers.high - centers.low;
    let axis = (0..3).max_by(|&a, &b| size[a].total_cmp(&size[b]))?;
    if size[axis] <= 0.0 {
        return None;
    }
    let bin = |i: u32| {
        let x = (boxes[i as usize].center()[axis] - centers.low[axis]) / size[axis];
        ((x * BINS as f64) as usize).min(BINS - 1)
    };
    let mut bins = [(Aabb::EMPTY, 0_usize); BINS];
    for &i in order.iter() {
        let b = &mut bins[bin(i)];
        *b = (b.0.union(boxes[i as usize]), b.1 + 1);
    }
    let cost = |range: &[(Aabb, usize)]| {
        let (aabb, count) = range
            .iter()
            .fold((Aabb::EMPTY, 0), |a, b| (a.0.union(b.0), a.1 + b.1));
        if count == 0 {
            f64::INFINITY
        } else {
            aabb.half_area() * count as f64
        }
    };
    let plane = (1..BINS).min_by(|&a, &b| {
        let of = |p: usize| cost(&bins[..p]) + cost(&bins[p..]);
        of(a).total_cmp(&of(b))
    })?;
    order.sort_unstable_by_key(|&i| bin(i) >= plane);
    let middle = order.iter().filter(|&&i| bin(i) < plane).count();
    (middle > 0 && middle < order.len()).then_some(middle)
}
