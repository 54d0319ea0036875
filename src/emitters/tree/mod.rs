//! The light tree: a binary tree over the lights, from which one is chosen by what it may
//! contribute to a surface.
//!
//! After Conty Estevez & Kulla 2018, "Importance Sampling of Many Lights with Adaptive Tree
//! Splitting", as pbrt-4's `BVHLightSampler` has it: nodes bound position, orientation and
//! intensity of their lights; a descent from the root takes each child in proportion to its
//! importance for the surface. `shaders/light/tree.wesl` descends, `docs/sampling.md` tells the
//! formulas. Lights that are infinitely far away stay outside: each of them, and the tree as a
//! whole, is chosen with the same probability.

mod bounds;
mod build;
mod record;

pub use bounds::{Cone, LightBounds, TreeLight};
pub use record::{Child, Grid, NodeWords, TREE_LEAF};

use build::{Placed, build};

/// A tree over two or more lights.
#[derive(Debug, Clone, PartialEq)]
pub struct LightTree {
    /// Its nodes; the first is the root.
    pub nodes: Vec<NodeWords>,
    /// Where the nodes' spheres lie.
    pub grid: Grid,
    /// Per emitter its way from the root: bit k is the child that it takes at level k. 0 outside
    /// the tree.
    pub trails: Vec<u32>,
    /// The sampled lights outside the tree.
    pub infinite: Vec<u32>,
    /// Per emitter its probability averaged over all surfaces, as far as that is known without
    /// one: in the tree, by its intensity.
    means: Vec<f64>,
}

impl LightTree {
    /// The tree over `lights` beside the lights `infinite`, of `count` emitters. `None` for fewer
    /// than two lights: then there is nothing to choose by.
    pub fn new(lights: &[TreeLight], infinite: Vec<u32>, count: usize) -> Option<Self> {
        if lights.len() < 2 {
            return None;
        }
        let bounds = lights.iter().map(|light| light.bounds);
        let all = bounds.reduce(LightBounds::union)?;
        let grid = Grid::new(&all);
        let mut placed: Vec<Placed> = lights
            .iter()
            .map(|&light| Placed { light, trail: 0 })
            .collect();
        let mut nodes = vec![NodeWords::default(); lights.len() - 1];
        build(&mut placed, &mut nodes, 0, 0, &grid);
        let mut trails = vec![0; count];
        let mut means = vec![0.0; count];
        let share = 1.0 / (infinite.len() + 1) as f64;
        for p in &placed {
            let index = p.light.index as usize;
            trails[index] = p.trail;
            means[index] = share * p.light.bounds.intensity / all.intensity;
        }
        for &index in &infinite {
            means[index as usize] = share;
        }
        Some(Self {
            nodes,
            grid,
            trails,
            infinite,
            means,
        })
    }

    /// Probability with which the tree is chosen, and each light outside of it (as in pbrt-4).
    pub fn share(&self) -> f64 {
        1.0 / (self.infinite.len() + 1) as f64
    }

    /// Probability of light `index` averaged over surfaces, where it is in the tree by its
    /// intensity alone; exact outside of it. 0 where it is never sampled.
    pub fn mean_probability(&self, index: usize) -> f64 {
        self.means[index]
    }
}

#[cfg(test)]
mod tests;
