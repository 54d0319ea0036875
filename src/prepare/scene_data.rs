//! What a render needs of a scene whatever the estimator is.

use crate::accel::parts::Split;
use crate::accel::{self, Attributes, Bvh, Primitive};
use crate::scene::Scene;
use crate::scene::enlarge::enlarge;
use crate::scene::normalize::Normalization;
use crate::scene::refine::refine;

/// A scene in normalised space, with its acceleration structure. It is the same for all estimators,
/// and for all cameras that call for the same normalisation.
#[derive(Debug)]
pub struct SceneData {
    /// The scene, world space.
    pub scene: Scene,
    /// From world space to the space of everything below.
    pub normalization: Normalization,
    /// Primitives in leaf order.
    pub primitives: Vec<Primitive>,
    /// Their vertex normals and texture coordinates.
    pub attributes: Attributes,
    /// The hierarchy over them.
    pub bvh: Bvh,
    /// How nodes, primitives and attributes are split, where one of them is too long for a binding.
    pub split: Option<Split>,
    /// Seconds that building the hierarchy took.
    pub accel_seconds: f64,
}

impl SceneData {
    /// Normalises `scene` for its camera and builds the hierarchy over its primitives.
    pub fn new(mut scene: Scene) -> Self {
        let start = std::time::Instant::now();
        let normalization = Normalization::of(&scene);
        let extreme = normalization.is_extreme();
        enlarge(&mut scene, &normalization);
        if extreme {
            refine(&mut scene, &normalization);
        }
        let mut primitives = accel::primitives(&scene, &normalization);
        let bvh = if extreme {
            accel::build_extreme(&mut primitives, &normalization)
        } else {
            accel::build(&mut primitives)
        };
        let accel_seconds = start.elapsed().as_secs_f64();
        let attributes = Attributes::new(&scene, &primitives);
        let split = Split::of(bvh.nodes.len(), primitives.len(), attributes.words.len());
        Self {
            scene,
            normalization,
            primitives,
            attributes,
            bvh,
            split,
            accel_seconds,
        }
    }

    /// Entries of the traversal's stack, in steps of four so that few kernels differ by it alone.
    pub fn stack_depth(&self) -> u32 {
        (self.bvh.depth.max(1) as u32).next_multiple_of(4)
    }
}
