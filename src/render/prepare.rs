//! From a scene to everything that the GPU needs.

use crate::accel::{self, Bvh, Primitive};
use crate::effects::{self, Effects};
use crate::emitters::Emitters;
use crate::scene::normalize::Normalization;
use crate::scene::{LightSelection, Scene, Strategy};

/// A scene made ready: normalised, with its acceleration structure, lights and effects.
#[derive(Debug)]
pub struct Prepared {
    /// The scene, world space.
    pub scene: Scene,
    /// From world space to the space of everything below.
    pub normalization: Normalization,
    /// Primitives in leaf order.
    pub primitives: Vec<Primitive>,
    /// The hierarchy over them.
    pub bvh: Bvh,
    /// The lights and how they are chosen.
    pub emitters: Emitters,
    /// What is compiled in, and why.
    pub effects: Effects,
    /// Seconds that building the hierarchy took.
    pub accel_seconds: f64,
}

impl Prepared {
    /// Makes `scene` ready for `strategy` with lights chosen by `selection`.
    pub fn new(scene: Scene, strategy: Strategy, selection: LightSelection) -> Self {
        let start = std::time::Instant::now();
        let normalization = Normalization::of(&scene);
        let mut primitives = accel::primitives(&scene, &normalization);
        let bvh = accel::build(&mut primitives);
        let accel_seconds = start.elapsed().as_secs_f64();
        let emitters = Emitters::new(&scene, &normalization, &primitives, strategy, selection);
        let effects = effects::called_for(&scene, &primitives, &emitters, strategy);
        Self {
            scene,
            normalization,
            primitives,
            bvh,
            emitters,
            effects,
            accel_seconds,
        }
    }

    /// Entries of the traversal's stack, in steps of four so that few kernels differ by it alone.
    pub fn stack_depth(&self) -> u32 {
        (self.bvh.depth.max(1) as u32).next_multiple_of(4)
    }

    /// What the sampler's pattern is made for; see [`Sampler::pattern`](crate::scene::Sampler::pattern).
    pub fn pattern(&self) -> [u32; 2] {
        let settings = self.scene.render;
        settings.sampler.pattern(settings.spp)
    }
}
