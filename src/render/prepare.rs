//! From a scene to everything that the GPU needs.

use crate::accel::parts::Split;
use crate::accel::{self, Attributes, Bvh, Primitive};
use crate::effects::{self, Effect, Effects};
use crate::emitters::Emitters;
use crate::scene::enlarge::enlarge;
use crate::scene::normalize::Normalization;
use crate::scene::refine::refine;
use crate::scene::{LightSelection, Sampler, Scene, ShadowGrid, ShadowPattern, Strategy};

/// A scene made ready: normalised, with its acceleration structure, lights and effects.
#[derive(Debug)]
pub struct Prepared {
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
    /// The lights and how they are chosen.
    pub emitters: Emitters,
    /// Boxes around the primitives that emit; see [`accel::light_boxes`](crate::accel::light_boxes()).
    pub light_boxes: Vec<[u32; 3]>,
    /// How nodes, primitives and attributes are split, where one of them is too long for a binding.
    pub split: Option<Split>,
    /// What is compiled in, and why.
    pub effects: Effects,
    /// Seconds that building the hierarchy took.
    pub accel_seconds: f64,
}

impl Prepared {
    /// Makes `scene` ready for `strategy` with lights chosen by `selection`.
    pub fn new(mut scene: Scene, strategy: Strategy, selection: LightSelection) -> Self {
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
        let emitters = Emitters::new(&scene, &normalization, &primitives, strategy, selection);
        let emitting = emitters.primitives();
        let emitting = emitting.map(|index| primitives[index as usize].geometry.bounds());
        let split = Split::of(bvh.nodes.len(), primitives.len(), attributes.words.len());
        let light_boxes = accel::light_boxes(&bvh, emitting.collect());
        let effects = effects::called_for(&scene, &primitives, &attributes, &emitters, strategy);
        let mut prepared = Self {
            scene,
            normalization,
            primitives,
            attributes,
            bvh,
            emitters,
            light_boxes,
            split,
            effects,
            accel_seconds,
        };
        prepared.call_for_scale();
        prepared
    }

    /// Adds the effects that the scale of the scene calls for.
    fn call_for_scale(&mut self) {
        let (near_plane, normalization) = (self.near_plane(), self.normalization);
        if self.bvh.grid.logarithmic {
            self.effects.call_for(Effect::LogarithmicGrid, || {
                let ratio = normalization.reach / normalization.radius;
                format!("the scene is {ratio:.1e} times as large as what is in view")
            });
        }
        if near_plane > 0.0 {
            self.effects.call_for(Effect::DistantCamera, || {
                let ratio = near_plane / normalization.radius;
                format!("the camera is {ratio:.1e} times as far away as what it sees is large")
            });
        }
    }

    /// Entries of the traversal's stack, in steps of four so that few kernels differ by it alone.
    pub fn stack_depth(&self) -> u32 {
        (self.bvh.depth.max(1) as u32).next_multiple_of(4)
    }

    /// What the sampler's patterns are made for.
    pub fn patterns(&self) -> Patterns {
        let settings = self.scene.render;
        Patterns::new(settings.sampler, settings.spp, self.shadow_rays())
    }

    /// Shadow rays per camera ray, with light selection `all` per light: 1 where a second would be the same.
    pub fn shadow_rays(&self) -> u32 {
        if self.effects.contains(Effect::ShadowRays) {
            self.scene.render.shadow_rays
        } else {
            1
        }
    }

    /// Where on the lights their points lie: `random` where a pattern makes no difference.
    pub fn shadow_pattern(&self) -> ShadowPattern {
        let patterns = [
            (Effect::CenterPattern, ShadowPattern::Center),
            (Effect::GridPattern, ShadowPattern::Grid),
            (Effect::StratifiedPattern, ShadowPattern::Stratified),
        ];
        let mut patterns = patterns.into_iter();
        let called_for = patterns.find(|(effect, _)| self.effects.contains(*effect));
        called_for.map_or(ShadowPattern::Random, |(_, pattern)| pattern)
    }

    /// The grid that they lie on, where there is a pattern, and the lattice of their choices.
    pub fn shadow_grid(&self) -> ShadowGrid {
        ShadowGrid::new(self.shadow_rays())
    }

    /// Light samples of a camera ray that go to light `index`, in the mean; see [`Emitters::samples`].
    pub fn light_samples(&self, index: usize) -> f64 {
        self.emitters.samples(index, self.shadow_rays())
    }

    /// Most light samples of a camera ray.
    pub fn most_light_samples(&self) -> f64 {
        let lights = 0..self.emitters.lights.len();
        lights.map(|index| self.light_samples(index)).sum()
    }

    /// Why images do not converge to direct lighting; `None` where they do.
    pub fn bias(&self) -> Option<String> {
        let fixed = [ShadowPattern::Center, ShadowPattern::Grid];
        fixed.contains(&self.shadow_pattern()).then(|| {
            let pattern = self.scene.render.shadow_pattern;
            format!(
                "shadow_pattern = \"{pattern}\": shadow rays end at the same points of the lights in all samples, so that the image \
                 converges to a quadrature, not to direct lighting"
            )
        })
    }
}

/// Numbers that the sampler's patterns are made for; see [`Sampler::pattern`](crate::scene::Sampler::pattern).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Patterns {
    /// For the samples of a pixel.
    pub pixel: [u32; 2],
    /// For the light samples of a pixel.
    pub light: [u32; 2],
}

impl Patterns {
    /// Those of `sampler` for `spp` samples per pixel with `rays` shadow rays each.
    pub fn new(sampler: Sampler, spp: u64, rays: u32) -> Self {
        Self {
            pixel: sampler.pattern(spp),
            light: sampler.light_pattern(spp, rays),
        }
    }
}
