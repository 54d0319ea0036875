//! Nodes as the GPU reads them: three words of 16 bytes for both children of a node, 24 bytes each
//! like pbrt-4's compact bounds, with a sphere beside the box.
//!
//! | 32-bit word of a child | bits |
//! |---|---|
//! | 0 | centre x, y: 16 bits each, on a grid over all lights |
//! | 1 | centre z: 16 bits; radius of the sphere: the upper 16 bits of an f32, rounded up |
//! | 2 | axis: 16 bits for each octahedral coordinate |
//! | 3 | cosθ_o: 16 bits over [−1, 1]; cosθ_e: 15 bits over [0, 1]; two-sided: 1 bit |
//! | 4 | half size of the box: x, y, z as 5 bits k each, for radius · 2^(−k/2); intensity, of all lights 1: the upper half of an f32 |
//! | 5 | reference: a node, or a light with `TREE_LEAF` |
//!
//! A node's first 16 bytes are words 0 to 3 of the left child, then those of the right, then words
//! 4 of both and words 5 of both. What is rounded is rounded so that the record bounds at least
//! what it stands for.

use super::bounds::LightBounds;
use crate::accel::octahedral::{from_octahedral, octahedral};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// Marks a reference to a light.
pub const TREE_LEAF: u32 = 0x8000_0000;

/// The words of a node.
pub type NodeWords = [[u32; 4]; 3];

/// Largest coordinate on the grid, and largest encoded cosine θ_o.
const LAST: f64 = 65_535.0;

/// Largest encoded cosine θ_e.
const LAST_EMISSION: f64 = 32_767.0;

/// How far rounding in f32 may move points, relative to their coordinates and the scene's size of 1.
const PADDING: f64 = 1.0 / 1_048_576.0;

/// How far it may turn an axis.
const TURN: f64 = 1e-6;

/// Least intensity, of all lights 1: in f32 what comes of it is not 0.
const MIN_INTENSITY: f64 = 1e-20;

/// The grid on which centres lie.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Grid {
    /// Its lower corner.
    pub origin: [f32; 3],
    /// Size of a cell.
    pub step: [f32; 3],
    /// Intensity of all lights.
    pub intensity: f64,
}

/// A child of a node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Child {
    /// Its lights' bounds.
    pub bounds: LightBounds,
    /// The centre of the sphere around them on the grid.
    pub cell: [u32; 3],
    /// Distance of their farthest point from there.
    pub reach: f64,
    /// Its node or light.
    pub reference: u32,
}

impl Grid {
    /// The grid over lights with these bounds.
    pub fn new(all: &LightBounds) -> Self {
        let origin = all.low.as_vec3();
        let extent = (all.high - origin.as_dvec3()).max(DVec3::ZERO);
        let step = (extent / LAST).to_array().map(|s| {
            let step = s as f32;
            if s > 0.0 { step.next_up() } else { 0.0 }
        });
        Self {
            origin: origin.to_array(),
            step,
            intensity: all.intensity,
        }
    }

    /// The cell nearest to `p`.
    pub fn cell(&self, p: DVec3) -> [u32; 3] {
        [0, 1, 2].map(|axis| {
            let step = f64::from(self.step[axis]);
            let place = (p[axis] - f64::from(self.origin[axis])) / step;
            if step > 0.0 {
                place.round().clamp(0.0, LAST) as u32
            } else {
                0
            }
        })
    }

    /// Its point.
    pub fn point(&self, cell: [u32; 3]) -> DVec3 {
        let at =
            |i: usize| f64::from(self.origin[i]) + f64::from(cell[i]) * f64::from(self.step[i]);
        DVec3::new(at(0), at(1), at(2))
    }

    /// The record of a node.
    pub fn encode(&self, children: [&Child; 2]) -> NodeWords {
        let [(left, a), (right, b)] = children.map(|c| self.encode_child(c));
        let references = children.map(|c| c.reference);
        [left, right, [a, b, references[0], references[1]]]
    }

    /// Words 0 to 3, and word 4.
    fn encode_child(&self, child: &Child) -> ([u32; 4], u32) {
        let centre = self.point(child.cell);
        let padding = PADDING * (1.0 + centre.abs().max_element() + child.reach);
        let radius = round_up(child.reach + padding);
        let half_size = (child.bounds.high - centre).max(centre - child.bounds.low) + padding;
        let reach = f64::from(f32::from_bits(radius << 16));
        let [a, b, c] = half_size.to_array().map(|h| encode_ratio(h / reach));
        let share = (child.bounds.intensity / self.intensity).max(MIN_INTENSITY);
        let intensity = (share as f32).to_bits() & 0xffff_0000;
        let axis = encode_axis(child.bounds.normals.axis);
        let turned = decode_axis(axis).angle_between(child.bounds.normals.axis);
        let spread = (child.bounds.normals.angle + turned + TURN).min(PI);
        let spread = (0.5 * (spread.cos() + 1.0) * LAST).floor() as u32;
        let emission = (child.bounds.emission.cos().max(0.0) * LAST_EMISSION).floor() as u32;
        let [x, y, z] = child.cell;
        let words = [
            x | y << 16,
            z | radius << 16,
            axis[0] | axis[1] << 16,
            spread | emission << 16 | u32::from(child.bounds.two_sided) << 31,
        ];
        (words, intensity | a | b << 5 | c << 10)
    }
}

/// The largest k up to 31 with 2^(−k/2) at least `ratio` ≤ 1.
fn encode_ratio(ratio: f64) -> u32 {
    let halves = -2.0 * ratio.log2() - 1e-6;
    halves.floor().clamp(0.0, 31.0) as u32
}

/// The upper half of the smallest f32 that is at least `x` > 0 and whose lower half is zero.
fn round_up(x: f64) -> u32 {
    let bits = (x as f32).next_up().to_bits();
    bits.div_ceil(1 << 16)
}

/// Octahedral coordinates of a unit vector, 16 bits each.
fn encode_axis(axis: DVec3) -> [u32; 2] {
    let coordinates = octahedral(axis).to_array();
    coordinates.map(|c| (0.5 * (c + 1.0) * LAST).round().clamp(0.0, LAST) as u32)
}

/// The unit vector that they stand for.
fn decode_axis(words: [u32; 2]) -> DVec3 {
    let coordinates = words.map(|q| f64::from(q) * 2.0 / LAST - 1.0);
    from_octahedral(DVec2::from_array(coordinates)).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Half a step of 2/65,535 in two coordinates, a whole one in the third, of a vector of length
    /// 1/√3 or more.
    const AXIS_ERROR: f64 = 6.5e-5;

    #[test]
    fn axes_come_back() {
        let golden = 2.399_963_229_728_653;
        for i in 0..10_000_i32 {
            let z = 1.0 - 2.0 * (f64::from(i) + 0.5) / 1e4;
            let (sin, cos) = (golden * f64::from(i)).sin_cos();
            let axis = DVec3::new((1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z);
            assert!(
                decode_axis(encode_axis(axis)).distance(axis) < AXIS_ERROR,
                "{axis}"
            );
        }
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            assert!(decode_axis(encode_axis(axis)).distance(axis) < AXIS_ERROR);
            assert!(decode_axis(encode_axis(-axis)).distance(-axis) < AXIS_ERROR);
        }
    }

    #[test]
    fn ratios_are_rounded_up_by_less_than_a_half() {
        for ratio in [1.0, 0.999, 0.71, 0.7, 0.5, 0.1, 1e-3, 4e-5] {
            let decoded = (-0.5 * f64::from(encode_ratio(ratio))).exp2();
            assert!(
                decoded >= ratio * (1.0 - 1e-12) && decoded < 1.5 * ratio,
                "{ratio}"
            );
        }
    }

    #[test]
    fn radii_are_rounded_up_by_less_than_a_hundredth() {
        for x in [1e-6, 0.1, 0.3, 1.0, 1.5, 3e4] {
            let y = f64::from(f32::from_bits(round_up(x) << 16));
            assert!(y > x && y < 1.01 * x, "{x} became {y}");
        }
    }

    #[test]
    fn the_grid_covers_the_lights() {
        let bounds = LightBounds {
            low: DVec3::new(-0.3, 0.7, 2.0),
            high: DVec3::new(0.9, 0.7, 2.5),
            intensity: 1.0,
            normals: super::super::bounds::Cone::SPHERE,
            emission: 1.0,
            two_sided: false,
        };
        let grid = Grid::new(&bounds);
        for p in [bounds.low, bounds.high, bounds.centre()] {
            assert!(grid.point(grid.cell(p)).distance(p) < 2e-5, "{p}");
        }
    }
}
