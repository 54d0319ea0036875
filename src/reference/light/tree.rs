//! The light tree; see `shaders/light/tree.wesl`. Nodes are decoded from the words that the GPU
//! reads, so that both know the same bounds.

use super::alias_table::Choice;
use crate::emitters::tree::{Grid, LightTree, NodeWords, TREE_LEAF};
use crate::reference::core::math::multiply_high;
use crate::reference::core::octahedral::from_octahedral;
use crate::reference::core::pdf::PdfDiscrete;
use crate::reference::core::rng::pcg4d;
use glam::{DVec2, DVec3};

/// Least probability of a child that may contribute beside another that may.
pub const MIN_CHILD: f64 = 1.0 / 1024.0;

/// By how much cosines may be wrong that decide whether a light shines on a point.
const COSINE_ERROR: f64 = 1.0 / 4096.0;

/// The same of a height above a surface, relative to the distance.
const HEIGHT_ERROR: f64 = 1.0 / 1_048_576.0;

/// Importance of what may contribute, at least.
const MIN_IMPORTANCE: f64 = 1e-30;

/// The words that a random word has to be one of, to decide again.
const MIN_RANGE: u32 = 1 << 24;

/// A child's bounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TreeChild {
    /// Centre of the sphere and of the box around its lights.
    pub center: DVec3,
    /// The sphere's radius.
    pub radius: f64,
    /// Half the box's size.
    pub half_size: DVec3,
    /// Unit axis of their normals.
    pub axis: DVec3,
    /// θ_o, the normals' largest angle from it.
    pub spread: f64,
    /// θ_e, the largest angle from a normal at which light is emitted.
    pub emission: f64,
    /// Whether any of them is two-sided.
    pub two_sided: bool,
    /// Radiant intensity, of all lights 1.
    pub intensity: f64,
}

/// A unit vector from its octahedral coordinates, 16 bits each.
pub fn decode_axis(word: u32) -> DVec3 {
    let coordinate = |q: u32| f64::from(q) * 2.0 / 65_535.0 - 1.0;
    let e = DVec2::new(coordinate(word & 0xffff), coordinate(word >> 16));
    from_octahedral(e).normalize()
}

/// The bounds of a child.
pub fn decode_child(grid: &Grid, words: [u32; 4], further: u32) -> TreeChild {
    let cell = [words[0] & 0xffff, words[0] >> 16, words[1] & 0xffff];
    let spread = f64::from(words[3] & 0xffff) * 2.0 / 65_535.0 - 1.0;
    let emission = f64::from(words[3] >> 16 & 0x7fff) / 32_767.0;
    let radius = f64::from(f32::from_bits(words[1] & 0xffff_0000));
    let half_size = [0, 5, 10].map(|at| radius * (-0.5 * f64::from(further >> at & 31)).exp2());
    TreeChild {
        center: grid.point(cell),
        radius,
        half_size: DVec3::from_array(half_size),
        axis: decode_axis(words[2]),
        spread: spread.acos(),
        emission: emission.acos(),
        two_sided: words[3] >> 31 == 1,
        intensity: f64::from(f32::from_bits(further & 0xffff_0000)),
    }
}

/// The largest cosine that a vector of this component may have which is at least `nearest` long and
/// about `distance`.
pub fn cosine_bound(component: f64, nearest: f64, distance: f64) -> f64 {
    let length = if component > 0.0 { nearest } else { distance };
    component / component.abs().max(length).max(1e-18)
}

/// Estimate of what the lights of a child contribute to the surface at `x` with the normal
/// `normal`; 0 only where none of them can.
pub fn tree_importance(child: &TreeChild, x: DVec3, normal: DVec3) -> f64 {
    let to = child.center - x;
    let distance = to.length();
    let height = normal.dot(to) + normal.abs().dot(child.half_size);
    if height <= -HEIGHT_ERROR * distance {
        return 0.0;
    }
    let nearest = (to.abs() - child.half_size).max(DVec3::ZERO).length();
    let d = distance.max(child.radius);
    let signed = -child.axis.dot(to);
    let along = if child.two_sided {
        signed.abs()
    } else {
        signed
    };
    let foremost = along + child.axis.abs().dot(child.half_size);
    let mut emitted = cosine_bound(foremost, nearest, distance).acos() - child.spread;
    if distance > child.radius {
        let angle = child.axis.cross(to).length().atan2(along);
        let seen = (child.radius / d).asin();
        let bound = f64::max(f64::max(angle - child.spread, 0.0) - seen, 0.0);
        if bound.cos() < child.emission.cos() - COSINE_ERROR {
            return 0.0;
        }
        emitted = emitted.max(bound);
    }
    let emitted = emitted.max(0.0).cos().max(0.0);
    let received = cosine_bound(height, nearest, distance).max(0.0);
    (child.intensity * emitted * received / (d * d)).max(MIN_IMPORTANCE)
}

/// What a node offers to a surface: the probability of its left child, `None` where neither child
/// may contribute.
pub fn tree_choice(grid: &Grid, node: &NodeWords, x: DVec3, normal: DVec3) -> Option<PdfDiscrete> {
    let importance = [0, 1].map(|side| {
        let child = decode_child(grid, node[side], node[2][side]);
        tree_importance(&child, x, normal)
    });
    let [left, right] = importance;
    match (left > 0.0, right > 0.0) {
        (false, false) => None,
        (true, false) => Some(PdfDiscrete(1.0)),
        (false, true) => Some(PdfDiscrete(0.0)),
        (true, true) => {
            let p = left / (left + right);
            Some(PdfDiscrete(p.clamp(MIN_CHILD, 1.0 - MIN_CHILD)))
        }
    }
}

/// A random word on its way down the tree: the interval of words in which it lies, of which every
/// decision leaves a part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TreeWalk {
    /// Position in the interval.
    pub code: u32,
    /// Its length.
    pub range: u32,
    /// What the next word is hashed from.
    pub words: [u32; 4],
    /// The least distance of a position from where the decision changes, relative to the interval.
    pub margin: f64,
}

impl TreeWalk {
    /// At the root, at `code` of all words.
    pub fn new(code: u32, words: [u32; 4]) -> Self {
        Self {
            code,
            range: u32::MAX,
            words,
            margin: 1.0,
        }
    }

    /// Whether the walk goes left, with probability `p`.
    pub fn walk_left(&mut self, p: PdfDiscrete) -> bool {
        if p.0 <= 0.0 || p.0 >= 1.0 {
            return p.0 >= 1.0;
        }
        let used_up = self.range < MIN_RANGE;
        if used_up {
            self.words = pcg4d(self.words);
            self.code = self.words[0];
            self.range = u32::MAX;
        }
        let split = multiply_high(self.range, (p.0 * 32_f64.exp2()) as u32);
        let left = self.code < split;
        let distance = f64::from(self.code.abs_diff(split)) / f64::from(self.range);
        self.margin = self.margin.min(distance);
        if left {
            self.range = split;
        } else {
            self.code -= split;
            self.range -= split;
        }
        if used_up {
            self.range = 0;
        }
        left
    }
}

/// What a walk down the tree found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TreeChosen {
    /// The light; `None` where no light of the tree can contribute.
    pub choice: Option<Choice>,
    /// See [`TreeWalk::margin`].
    pub margin: f64,
}

/// The light that the random word `u` and, where it does not suffice, words hashed from `words`
/// select for the surface at `x` with the normal `normal`.
pub fn choose_tree_light(
    tree: &LightTree,
    u: u32,
    words: [u32; 4],
    x: DVec3,
    normal: DVec3,
) -> TreeChosen {
    let infinite = tree.infinite.len() as u32;
    let group = multiply_high(u, infinite + 1);
    let mut walk = TreeWalk::new(u.wrapping_mul(infinite + 1), words);
    let outside = tree.infinite.get(group as usize).map(|&index| Choice {
        index,
        probability: PdfDiscrete(tree.share()),
    });
    let choice = outside.or_else(|| descend(tree, &mut walk, x, normal));
    TreeChosen {
        choice,
        margin: walk.margin,
    }
}

fn descend(tree: &LightTree, walk: &mut TreeWalk, x: DVec3, normal: DVec3) -> Option<Choice> {
    let mut probability = tree.share();
    let mut reference = 0;
    while reference & TREE_LEAF == 0 {
        let node = &tree.nodes[reference as usize];
        let left = tree_choice(&tree.grid, node, x, normal)?;
        if walk.walk_left(left) {
            probability *= left.0;
            reference = node[2][2];
        } else {
            probability *= 1.0 - left.0;
            reference = node[2][3];
        }
    }
    Some(Choice {
        index: reference & !TREE_LEAF,
        probability: PdfDiscrete(probability),
    })
}

/// Probability of the light whose way from the root is `trail`, for the surface at `x` with the
/// normal `normal`.
pub fn pdf_tree_light(tree: &LightTree, trail: u32, x: DVec3, normal: DVec3) -> PdfDiscrete {
    let mut probability = tree.share();
    let mut reference = 0;
    let mut rest = trail;
    while reference & TREE_LEAF == 0 {
        let node = &tree.nodes[reference as usize];
        let Some(left) = tree_choice(&tree.grid, node, x, normal) else {
            return PdfDiscrete(0.0);
        };
        let right = rest & 1;
        probability *= if right == 1 { 1.0 - left.0 } else { left.0 };
        reference = node[2][2 + right as usize];
        rest >>= 1;
    }
    PdfDiscrete(probability)
}
