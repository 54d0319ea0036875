//! From a scene to everything that the GPU and the reference need: what depends on the scene alone
//! ([`SceneData`]), and what depends on the estimator as well ([`Prepared`]).

pub mod lights_in_view;
pub mod near_plane;
mod scene_data;
mod shiny;
pub mod small_lights;
mod specialize;
mod view;

pub use scene_data::SceneData;

use crate::accel;
use crate::effects::{Effect, EffectQuery, Effects};
use crate::emitters::{Emitter, Emitters};
use crate::scene::{Camera, FilmSize, RenderSettings, Sampler, Scene, ShadowGrid, ShadowPattern};
use lights_in_view::{LightInView, lights_in_view};
use shiny::{Shiny, shiny_materials};
use small_lights::{SmallLight, bright_texels, small_lights};
use std::sync::Arc;
use view::View;

/// A scene made ready for one estimator: its lights, how they are chosen, and the effects that are
/// compiled in.
#[derive(Debug, Clone)]
pub struct Prepared {
    /// What other estimators share.
    pub data: Arc<SceneData>,
    /// The camera, world space.
    pub camera: Camera,
    /// Size of the image.
    pub film: FilmSize,
    /// The estimator and all else that the table `[render]` holds.
    pub settings: RenderSettings,
    /// The lights and how they are chosen.
    pub emitters: Emitters,
    /// Boxes around the primitives that emit; see
    /// [`accel::light_boxes`](crate::accel::light_boxes()).
    pub light_boxes: Vec<[u32; 3]>,
    /// Small lights that the camera sees, which are sampled there.
    pub lights_in_view: Vec<LightInView>,
    /// Small lights that camera rays meet by chance alone.
    pub small_lights: Vec<SmallLight>,
    /// What of the environment may be among these, whatever the camera.
    bright_texels: Vec<SmallLight>,
    /// What shows them.
    shiny: Vec<Shiny>,
    /// Largest coordinate of what rays come from and go to, normalised space, as a power of two.
    ray_reach: f64,
    /// What is compiled in, and why.
    pub effects: Effects,
}

impl Prepared {
    /// Makes `scene` ready for its own settings.
    pub fn of(scene: Scene) -> Self {
        let settings = scene.render;
        Self::new(&Arc::new(SceneData::new(scene)), settings)
    }

    /// Makes `data` ready for `settings`, with the camera and the size of its scene.
    pub fn new(data: &Arc<SceneData>, settings: RenderSettings) -> Self {
        Self::seen_by(data, (data.scene.camera, data.scene.film), settings)
    }

    /// Makes `data` ready for `settings` and an image that `camera` takes. The scene has to be
    /// normalised as that camera calls for.
    pub fn seen_by(
        data: &Arc<SceneData>,
        (camera, film): (Camera, FilmSize),
        settings: RenderSettings,
    ) -> Self {
        let SceneData {
            scene,
            normalization,
            primitives,
            attributes,
            bvh,
            ..
        } = &**data;
        let emitters = Emitters::new(scene, normalization, primitives, &settings);
        let emitting = emitters.primitives();
        let emitting = emitting.map(|index| primitives[index as usize].geometry.bounds());
        let light_boxes = accel::light_boxes(bvh, emitting.collect());
        let effects = Effects::called_for(&EffectQuery {
            scene,
            camera: &camera,
            settings: &settings,
            primitives,
            attributes,
            emitters: &emitters,
        });
        let mut prepared = Self {
            data: Arc::clone(data),
            camera,
            film,
            settings,
            emitters,
            light_boxes,
            lights_in_view: Vec::new(),
            small_lights: Vec::new(),
            bright_texels: Vec::new(),
            shiny: shiny_materials(data),
            ray_reach: specialize::ray_reach(normalization, &camera),
            effects,
        };
        prepared.call_for_scale();
        prepared.bright_texels = bright_texels(&prepared);
        prepared.look_from(camera, film);
        prepared.call_for_lights();
        prepared.call_for_specialization();
        prepared
    }

    /// Takes another camera, which calls for the same normalisation, and another size of the image.
    /// Effects stay: see [`Prepared::has_effects_for`].
    pub fn look_from(&mut self, camera: Camera, film: FilmSize) {
        (self.lights_in_view, self.small_lights) = self.lights_seen_by(&camera, film);
        (self.camera, self.film) = (camera, film);
    }

    /// Whether the effects are among its own that lights call for which `camera` sees, or samples meet
    /// by chance.
    pub fn has_effects_for(&self, camera: &Camera, film: FilmSize) -> bool {
        let (in_view, small) = self.lights_seen_by(camera, film);
        let has = |effect| self.effects.contains(effect);
        (in_view.is_empty() || has(Effect::LightsInView))
            && (small.is_empty() || has(Effect::NearMisses))
            && self.is_specialized_for(camera)
    }

    /// The lights that are sampled in view of `camera`, and the small ones that samples meet by chance.
    fn lights_seen_by(
        &self,
        camera: &Camera,
        film: FilmSize,
    ) -> (Vec<LightInView>, Vec<SmallLight>) {
        let view = View::new(camera, film, &self.data);
        let in_view = lights_in_view(&view, &self.data, &self.emitters);
        let small = small_lights(self, &view, &in_view.left_to_chance);
        (in_view.sampled, small)
    }

    /// The same where camera rays find lights in view by chance alone.
    #[must_use]
    pub fn with_lights_in_view_by_chance(mut self) -> Self {
        self.lights_in_view.clear();
        self.effects.remove(Effect::LightsInView);
        self
    }

    /// Adds the effects that the scale of the scene calls for.
    fn call_for_scale(&mut self) {
        let (near_plane, normalization) = (self.near_plane(), self.data.normalization);
        if self.data.bvh.grid.logarithmic {
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

    /// Adds the effects that lights call for which the camera sees, or samples meet by chance.
    fn call_for_lights(&mut self) {
        if let Some(first) = self.lights_in_view.first() {
            let name = self.name_of_light(first.light);
            let reason = match self.lights_in_view.len() {
                1 => name,
                lights => format!("{name} and {} more", lights - 1),
            };
            self.effects.call_for(Effect::LightsInView, || reason);
        }
        if let Some(first) = self.small_lights.first() {
            let name = first.light.map_or_else(
                || "the brightest texels of the environment".to_owned(),
                |light| self.name_of_light(light),
            );
            self.effects.call_for(Effect::NearMisses, || {
                format!("mirrors, glass, narrow lobes or pixels show {name} by chance")
            });
        }
    }

    fn name_of_light(&self, index: u32) -> String {
        match self.emitters.lights[index as usize] {
            Emitter::Area { primitive, .. } => {
                let shape = self.data.primitives[primitive as usize].shape;
                self.data.scene.shapes[shape.index()].name.clone()
            }
            Emitter::Delta(light) => format!("a {} light", light.name()),
            _ => "a sun".to_owned(),
        }
    }

    /// What the sampler's patterns are made for.
    pub fn patterns(&self) -> Patterns {
        let settings = self.settings;
        Patterns::new(
            settings.estimator.sampler,
            settings.stop.spp,
            self.shadow_rays(),
        )
    }

    /// Shadow rays per camera ray, with light selection `all` per light: 1 where a second would be
    /// the same, and with `auto`, until a render has asked its pixels.
    pub fn shadow_rays(&self) -> u32 {
        if self.effects.contains(Effect::ShadowRays) {
            self.settings.estimator.shadow_rays.least()
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

    /// Light samples of a camera ray that go to light `index`, on average; see
    /// [`Emitters::samples`].
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
            let pattern = self.settings.estimator.shadow_pattern;
            format!(
                "shadow_pattern = \"{pattern}\": shadow rays end at the same points of the lights in all samples, so that the image \
                 converges to a quadrature, not to direct lighting"
            )
        })
    }
}

/// Numbers that the sampler's patterns are made for; see
/// [`Sampler::pattern`](crate::scene::Sampler::pattern).
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
