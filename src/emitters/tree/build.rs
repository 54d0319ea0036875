//! Builds the tree: top down, by the surface-area-orientation heuristic.

use super::bounds::{LightBounds, TreeLight};
use super::record::{Child, Grid, NodeWords, TREE_LEAF};
use glam::DVec3;

/// Levels at most: a light's trail from the root is one word.
const MAX_DEPTH: u32 = 32;

/// Buckets per axis between which lights are divided, as in pbrt-4.
const BUCKETS: usize = 12;

/// Lights from which on both children are built at the same time.
const PARALLEL: usize = 4096;

/// A light and its way from the root.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Placed {
    /// The light.
    pub light: TreeLight,
    /// Bit k is the child that the way takes at level k.
    pub trail: u32,
}

/// Builds the node at level `depth` over two or more `lights` into `nodes`, one less than lights,
/// depth first; the first of them is node `first`. Gives the bounds of all.
pub(crate) fn build(
    lights: &mut [Placed],
    nodes: &mut [NodeWords],
    first: u32,
    depth: u32,
    grid: &Grid,
) -> LightBounds {
    let parallel = lights.len() >= PARALLEL;
    let half = split(lights, depth);
    let (left, right) = lights.split_at_mut(half);
    for placed in right.iter_mut() {
        placed.trail |= 1 << depth;
    }
    let (node, below) = nodes.split_at_mut(1);
    let (left_nodes, right_nodes) = below.split_at_mut(half - 1);
    let right_first = first + half as u32;
    let mut build_left = || child(left, left_nodes, first + 1, depth + 1, grid);
    let mut build_right = || child(right, right_nodes, right_first, depth + 1, grid);
    let children = if parallel {
        rayon::join(build_left, build_right)
    } else {
        (build_left(), build_right())
    };
    node[0] = grid.encode([&children.0, &children.1]);
    children.0.bounds.union(children.1.bounds)
}

fn child(
    lights: &mut [Placed],
    nodes: &mut [NodeWords],
    first: u32,
    depth: u32,
    grid: &Grid,
) -> Child {
    let (bounds, reference) = match lights {
        [only] => (only.light.bounds, TREE_LEAF | only.light.index),
        _ => (build(lights, nodes, first, depth, grid), first),
    };
    let cell = grid.cell(bounds.centre());
    let centre = grid.point(cell);
    let reach = lights.iter().map(|p| p.light.reach(centre));
    Child {
        bounds,
        cell,
        reach: reach.fold(0.0, f64::max),
        reference,
    }
}

/// Puts the left child's lights first and gives their number.
fn split(lights: &mut [Placed], depth: u32) -> usize {
    let levels = MAX_DEPTH - depth - 1;
    let fits = |n: usize| n.next_power_of_two().ilog2() <= levels;
    let best = Best::of(lights).filter(|best| {
        let half = lights.iter().filter(|p| best.is_left(p)).count();
        fits(half) && fits(lights.len() - half)
    });
    let Some(best) = best else {
        return median(lights);
    };
    let mut half = 0;
    for i in 0..lights.len() {
        if best.is_left(&lights[i]) {
            lights.swap(i, half);
            half += 1;
        }
    }
    half
}

/// Halves along the longest axis: where lights lie on a line, whose boxes have no surface, at one
/// point, or so unevenly that the tree would become too deep.
fn median(lights: &mut [Placed]) -> usize {
    let (low, high) = centres(lights);
    let axis = (high - low).max_position();
    let half = lights.len() / 2;
    let at = |p: &Placed| p.light.bounds.centre()[axis];
    lights.select_nth_unstable_by(half, |a, b| at(a).total_cmp(&at(b)));
    half
}

/// The box around the lights' centres.
fn centres(lights: &[Placed]) -> (DVec3, DVec3) {
    let around = |(low, high): (DVec3, DVec3), p: &Placed| {
        let centre = p.light.bounds.centre();
        (low.min(centre), high.max(centre))
    };
    lights
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), around)
}

/// The cheapest plane between two buckets.
#[derive(Debug, Clone, Copy)]
struct Best {
    axis: usize,
    low: f64,
    /// Buckets per unit length.
    scale: f64,
    /// The left child's last bucket.
    bucket: usize,
}

impl Best {
    /// `None` where no plane divides the lights, or all cost nothing.
    fn of(lights: &[Placed]) -> Option<Self> {
        let (low, high) = centres(lights);
        let mut size = DVec3::ZERO;
        for p in lights {
            size = size.max(p.light.bounds.high - low);
        }
        let mut best: Option<(f64, Self)> = None;
        for axis in 0..3 {
            let extent = high[axis] - low[axis];
            if extent <= 0.0 {
                continue;
            }
            let mut plane = Self {
                axis,
                low: low[axis],
                scale: BUCKETS as f64 / extent,
                bucket: 0,
            };
            // K_r of the paper: planes across the longest side are favoured, so that boxes do not
            // become thin.
            let factor = size.max_element() / size[axis];
            for (bucket, cost) in plane.costs(lights).into_iter().enumerate() {
                let cost = factor * cost;
                if cost > 0.0 && cost.is_finite() && best.is_none_or(|(least, _)| cost < least) {
                    plane.bucket = bucket;
                    best = Some((cost, plane));
                }
            }
        }
        best.map(|(_, plane)| plane)
    }

    fn bucket_of(&self, p: &Placed) -> usize {
        let place = (p.light.bounds.centre()[self.axis] - self.low) * self.scale;
        (place as usize).min(BUCKETS - 1)
    }

    fn is_left(&self, p: &Placed) -> bool {
        self.bucket_of(p) <= self.bucket
    }

    /// Costs of the planes after each bucket; infinite where one side is empty.
    fn costs(&self, lights: &[Placed]) -> [f64; BUCKETS - 1] {
        let mut buckets: [Option<LightBounds>; BUCKETS] = [None; BUCKETS];
        for p in lights {
            let bucket = &mut buckets[self.bucket_of(p)];
            *bucket = join(*bucket, Some(p.light.bounds));
        }
        let left = running_costs(buckets.iter());
        let right = running_costs(buckets.iter().rev());
        std::array::from_fn(|bucket| left[bucket] + right[BUCKETS - 2 - bucket])
    }
}

/// Cost of the first bucket, of the first two together, and so on; infinite while they are empty.
fn running_costs<'a>(buckets: impl Iterator<Item = &'a Option<LightBounds>>) -> Vec<f64> {
    let add = |side: &mut Option<LightBounds>, bucket: &Option<LightBounds>| {
        *side = join(*side, *bucket);
        Some(side.map_or(f64::INFINITY, |bounds| bounds.cost()))
    };
    buckets.scan(None, add).collect()
}

fn join(a: Option<LightBounds>, b: Option<LightBounds>) -> Option<LightBounds> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a.union(b)),
        (a, b) => a.or(b),
    }
}
