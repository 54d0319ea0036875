//! Structs shared with the lab's kernels. `tests/layout.rs` compares every member with
//! `shaders/lab/types.wesl`.

use bytemuck::{Pod, Zeroable};
use direkt::low_level::stats::moments::Moments;

/// `LabRun` of `shaders/lab/types.wesl`: what one dispatch does. Each kernel says what `variant`,
/// `size` and `constants` mean to it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct LabRun {
    /// Which of the kernel's cases.
    pub variant: u32,
    /// Items of this dispatch; an invocation works on one.
    pub items: u32,
    /// Number of the first of them.
    pub first_item: u32,
    /// Samples per item.
    pub samples: u32,
    /// Seed of the random numbers.
    pub seed: u32,
    /// Tells runs of one seed apart.
    pub stream: u32,
    /// Panels along an axis, or entries of a table.
    pub size: u32,
    /// Dimensions of the integrand.
    pub dimensions: u32,
    /// Densities and the like.
    pub constants: [f32; 4],
}

/// `LabBlock` of `shaders/lab/types.wesl`: what an item found.
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct LabBlock {
    /// Mean of its samples.
    pub mean: f32,
    /// Sum of their squared deviations from it.
    pub m2: f32,
    /// Their number.
    pub samples: u32,
    /// Attempts that they took.
    pub tries: u32,
}

impl LabBlock {
    /// The block in f64.
    pub fn moments(&self) -> Moments {
        Moments {
            count: u64::from(self.samples),
            mean: f64::from(self.mean),
            m2: f64::from(self.m2),
        }
    }
}

/// All blocks as one.
pub fn merged(blocks: &[LabBlock]) -> Moments {
    let mut all = Moments::default();
    for block in blocks {
        all.merge(&block.moments());
    }
    all
}
