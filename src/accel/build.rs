//! Builds a binary BVH over primitives.

use super::flatten::{Bvh, MAX_DEPTH, MAX_LEAF_PRIMITIVES, flatten, flatten_all};
use super::grid::Grid;
use super::primitives::Primitive;
use crate::scene::normalize::Normalization;
use glam::{DVec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::ploc::{PlocSearchDistance, SortPrecision};
use obvhs::{Boundable, BvhBuildParams};

/// Primitives that count as few: none is large beside the others.
pub const FEW: usize = 64;
/// Large primitives at most.
const MOST_LARGE: usize = 32;
/// What part of the surface of the box around a scene that of a large primitive's box is at least.
const LEAST_PART: f32 = 1.0 / 256.0;

/// A primitive's box, rounded outwards.
struct Boxed(Aabb);

impl Boundable for Boxed {
    fn aabb(&self) -> Aabb {
        self.0
    }
}

fn boxed(p: &Primitive) -> Boxed {
    let (low, high) = p.geometry.bounds();
    let below = |x: f64| (x as f32).next_down();
    let above = |x: f64| (x as f32).next_up();
    let down = |v: DVec3| Vec3A::new(below(v.x), below(v.y), below(v.z));
    let up = |v: DVec3| Vec3A::new(above(v.x), above(v.y), above(v.z));
    Boxed(Aabb::new(down(low), up(high)))
}

/// Reorders `primitives` into leaf order and returns the hierarchy over them. Without primitives it
/// holds no node.
pub fn build(primitives: &mut Vec<Primitive>) -> Bvh {
    if primitives.is_empty() {
        return Bvh::default();
    }
    let boxes: Vec<Boxed> = primitives.iter().map(boxed).collect();
    let Some(least) = least_of_large(&boxes) else {
        return flatten(&[&hierarchy(primitives, &boxes)]);
    };
    let (large, small): (Vec<_>, Vec<_>) = primitives
        .drain(..)
        .zip(boxes)
        .partition(|(_, one)| one.0.half_area() >= least);
    let [small, large] = [small, large].map(|part| {
        let (mut of_part, boxes): (Vec<_>, Vec<_>) = part.into_iter().unzip();
        let bvh2 = hierarchy(&mut of_part, &boxes);
        primitives.append(&mut of_part);
        bvh2
    });
    flatten(&[&small, &large])
}

/// Reorders `primitives`, whose boxes are `boxes`, into leaf order and returns the hierarchy over
/// them.
fn hierarchy(primitives: &mut Vec<Primitive>, boxes: &[Boxed]) -> Bvh2 {
    let mut seconds = std::time::Duration::ZERO;
    let mut bvh2 = build_bvh2(boxes, parameters(boxes.len()), &mut seconds);
    // A part may hang one level below the root.
    if bvh2.depth(0) >= MAX_DEPTH {
        bvh2 = median_split(boxes);
    }
    sort_by_leaves(primitives, &bvh2);
    bvh2
}

/// Half the surface from which on a box is that of a large primitive: [`LEAST_PART`] of that of the
/// box around all `boxes`. `None` where all are few, none is large, or many are.
fn least_of_large(boxes: &[Boxed]) -> Option<f32> {
    if boxes.len() <= FEW {
        return None;
    }
    let all = boxes
        .iter()
        .fold(Aabb::INVALID, |all, one| all.union(&one.0));
    let least = LEAST_PART * all.half_area();
    let large = boxes.iter().filter(|one| one.0.half_area() >= least);
    (1..=MOST_LARGE).contains(&large.count()).then_some(least)
}

/// Distances from the centre that lie between two parts of an extreme scene, as a power of two.
const PART: f64 = 10.0;

/// The same for an extreme scene: primitives farther from the centre form parts of their own, each
/// split at its medians. The better builder sorts centres on a grid of 2²¹ cells per axis and
/// compares areas in f32, which is too coarse here.
pub fn build_extreme(primitives: &mut Vec<Primitive>, normalization: &Normalization) -> Bvh {
    if primitives.is_empty() {
        return Bvh::default();
    }
    let part = |p: &Primitive| {
        let (low, high) = p.geometry.bounds();
        let reach = low.abs().max(high.abs()).max_element();
        ((reach / normalization.radius).log2() / PART).max(0.0) as u32
    };
    primitives.sort_by_cached_key(part);
    let (mut parts, mut ordered) = (Vec::new(), Vec::with_capacity(primitives.len()));
    for same in primitives.chunk_by(|a, b| part(a) == part(b)) {
        let mut same = same.to_vec();
        let boxes: Vec<Boxed> = same.iter().map(boxed).collect();
        let bvh2 = median_split(&boxes);
        sort_by_leaves(&mut same, &bvh2);
        parts.push(bvh2);
        ordered.append(&mut same);
    }
    *primitives = ordered;
    let parts: Vec<&Bvh2> = parts.iter().collect();
    let grid = Grid::logarithmic(normalization.reach, normalization.radius);
    flatten_all(&parts, grid)
}

/// Brings `primitives` into the order of the leaves of `bvh2`.
fn sort_by_leaves(primitives: &mut Vec<Primitive>, bvh2: &Bvh2) {
    let order = bvh2.primitive_indices.iter();
    *primitives = order.map(|&i| primitives[i as usize]).collect();
}

fn parameters(count: usize) -> BvhBuildParams {
    let large = count > 500_000;
    BvhBuildParams {
        pre_split: false,
        ploc_search_distance: PlocSearchDistance::Medium,
        search_depth_threshold: 3,
        reinsertion_batch_ratio: if large { 0.05 } else { 1.0 },
        post_collapse_reinsertion_batch_ratio_multiplier: if large { 0.0 } else { 2.0 },
        sort_precision: SortPrecision::U64,
        max_prims_per_leaf: MAX_LEAF_PRIMITIVES,
        collapse_traversal_cost: 1.0,
    }
}

/// A balanced hierarchy by object median along the longest axis: for scenes on which the better
/// builder goes deeper than the traversal's stack. Its depth is ⌈log₂ n⌉.
fn median_split(boxes: &[Boxed]) -> Bvh2 {
    let mut bvh2 = Bvh2 {
        primitive_indices: (0..boxes.len() as u32).collect(),
        ..Bvh2::default()
    };
    bvh2.nodes.push(obvhs::bvh2::node::Bvh2Node::default());
    let mut indices = std::mem::take(&mut bvh2.primitive_indices);
    split_node(&mut bvh2, boxes, &mut indices, 0, 0);
    bvh2.primitive_indices = indices;
    bvh2
}

fn split_node(bvh2: &mut Bvh2, boxes: &[Boxed], indices: &mut [u32], first: u32, node: usize) {
    use obvhs::bvh2::node::Bvh2Node;
    let around = indices
        .iter()
        .fold(Aabb::INVALID, |a, &i| a.union(&boxes[i as usize].0));
    if indices.len() <= 2 {
        bvh2.nodes[node] = Bvh2Node::new(around, indices.len() as u32, first);
        return;
    }
    let size = around.max - around.min;
    let axis = if size.x >= size.y && size.x >= size.z {
        0
    } else if size.y >= size.z {
        1
    } else {
        2
    };
    let center = |i: &u32| {
        let b = &boxes[*i as usize].0;
        b.min[axis] + b.max[axis]
    };
    let half = indices.len() / 2;
    indices.select_nth_unstable_by(half, |a, b| center(a).total_cmp(&center(b)));
    let children = bvh2.nodes.len();
    bvh2.nodes[node] = Bvh2Node::new(around, 0, children as u32);
    bvh2.nodes
        .extend([Bvh2Node::default(), Bvh2Node::default()]);
    let (left, right) = indices.split_at_mut(half);
    split_node(bvh2, boxes, left, first, children);
    split_node(bvh2, boxes, right, first + half as u32, children + 1);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::PrimitiveGeometry;
    use crate::scene::{MaterialId, ShapeId};

    /// `small` unit squares in a row, and in turns with the first of them `large` ones with sides of
    /// half the row.
    fn squares(small: u32, large: u32) -> Vec<Primitive> {
        let square = |i: u32, side: f64| Primitive {
            geometry: PrimitiveGeometry::Rectangle {
                a: DVec3::new(0.0, f64::from(2 * i), 0.0),
                u: side * DVec3::X,
                v: side * DVec3::Y,
            },
            material: MaterialId(0),
            shape: ShapeId(0),
            part: i,
        };
        let of_large = |i: u32| (i < large).then(|| square(i, f64::from(small)));
        let both = (0..small).flat_map(|i| of_large(i).into_iter().chain([square(i, 1.0)]));
        both.collect()
    }

    #[test]
    fn few_large_primitives_come_last() {
        let mut primitives = squares(500, 2);
        let bvh = build(&mut primitives);
        let small = bvh.small.expect("two are large");
        assert_eq!((small.count, primitives.len()), (500, 502));
        let side = |p: &Primitive| {
            let (low, high) = p.geometry.bounds();
            (high - low).x
        };
        assert!(
            primitives[..500]
                .iter()
                .all(|p| (side(p) - 1.0).abs() < 1e-9)
        );
        assert!(
            primitives[500..]
                .iter()
                .all(|p| (side(p) - 500.0).abs() < 1e-9)
        );
        let mut parts: Vec<_> = primitives[..500].iter().map(|p| p.part).collect();
        parts.sort_unstable();
        assert_eq!(parts, Vec::from_iter(0..500));
        let [low, high] = small.bounds;
        assert!(low.x < 0.0 && low.x > -1e-3 && high.x > 1.0 && high.x < 1.001);
        assert_ne!(small.root, bvh.root);
    }

    #[test]
    fn where_all_are_few_or_many_are_large_none_is_set_apart() {
        for (small, large) in [(62, 2), (500, 0), (500, MOST_LARGE as u32 + 1)] {
            let mut primitives = squares(small, large);
            assert_eq!(build(&mut primitives).small, None, "{small}, {large}");
            assert_eq!(primitives.len() as u32, small + large);
        }
    }
}
