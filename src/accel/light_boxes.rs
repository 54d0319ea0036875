//! Boxes around what emits.
//!
//! A ray that looks for direct light need not be traced where it enters none of them: whatever it
//! meets is dark. Most BSDF-sampled rays are such, as lights are small.

use super::flatten::Bvh;
use glam::DVec3;

/// Boxes at most: each costs every BSDF-sampled ray a test.
pub const MAX_LIGHT_BOXES: usize = 8;

/// Lower and upper corner of a box.
type Box3 = (DVec3, DVec3);

/// At most [`MAX_LIGHT_BOXES`] boxes, in words as those of the nodes of `bvh`, around the boxes
/// `emitting`: each by itself, or where they are too many, neighbours together.
pub fn light_boxes(bvh: &Bvh, mut emitting: Vec<Box3>) -> Vec<[u32; 3]> {
    let mut around = Vec::new();
    cluster(&mut emitting, MAX_LIGHT_BOXES, &mut around);
    let words = around
        .iter()
        .map(|&(low, high)| bvh.grid.box_words_with_margin(low, high));
    words.collect()
}

/// Puts all of `boxes` into `parts` boxes at most, by halving them along the axis on which their
/// middles differ most.
fn cluster(boxes: &mut [Box3], parts: usize, out: &mut Vec<Box3>) {
    let union = |(low, high): Box3, b: &Box3| (low.min(b.0), high.max(b.1));
    let Some((&first, others)) = boxes.split_first() else {
        return;
    };
    if others.is_empty() || parts == 1 {
        out.push(others.iter().fold(first, union));
        return;
    }
    let middle = |b: &Box3| 0.5 * (b.0 + b.1);
    let start = (middle(&first), middle(&first));
    let (low, high) = others
        .iter()
        .map(middle)
        .fold(start, |(low, high), m| (low.min(m), high.max(m)));
    let axis = (high - low).max_position();
    let half = boxes.len() / 2;
    boxes.select_nth_unstable_by(half, |a, b| middle(a)[axis].total_cmp(&middle(b)[axis]));
    let (left, right) = boxes.split_at_mut(half);
    cluster(left, parts / 2, out);
    cluster(right, parts / 2, out);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn small(x: f64) -> Box3 {
        let low = DVec3::new(x, 0.0, 0.0);
        (low, low + DVec3::splat(0.01))
    }

    fn clustered(count: u32) -> Vec<Box3> {
        let mut boxes: Vec<_> = (0..count)
            .map(|i| small(f64::from(i * 7 % count)))
            .collect();
        let mut out = Vec::new();
        cluster(&mut boxes, MAX_LIGHT_BOXES, &mut out);
        out
    }

    #[test]
    fn few_have_a_box_each_and_many_share() {
        assert!(clustered(0).is_empty());
        for count in 1..=8 {
            assert_eq!(clustered(count).len(), count as usize);
        }
        let shared = clustered(100);
        assert_eq!(shared.len(), MAX_LIGHT_BOXES);
        for i in 0..100 {
            let (low, high) = small(f64::from(i));
            let inside = |b: &&Box3| b.0.cmple(low).all() && b.1.cmpge(high).all();
            assert_eq!(shared.iter().filter(inside).count(), 1, "{i}");
        }
    }
}
