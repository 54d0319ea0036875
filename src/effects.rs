//! What a scene calls for: every piece of shader code that is not always there, and the reason why it is.
//!
//! An effect is derived from the scene, never declared by the user. Each maps to a WESL feature: code under
//! `@if(GLOSSY)` is not in the WGSL unless some material has a microfacet lobe.

use crate::accel::{Primitive, PrimitiveGeometry};
use crate::emitters::{Emitter, Emitters, Selection};
use crate::scene::light::Interpolation;
use crate::scene::{
    EnvironmentRadiance, Light, LightSampling, RenderSettings, Sampler, Scene, ShadowPattern,
    Strategy,
};
use std::collections::BTreeMap;

macro_rules! effects {
    ($($(#[$doc:meta])* $variant:ident $feature:literal $name:literal,)*) => {
        /// A piece of the renderer that only some scenes need.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Effect { $($(#[$doc])* $variant,)* }

        impl Effect {
            /// All of them.
            pub const ALL: &'static [Self] = &[$(Self::$variant,)*];

            /// The WESL feature that compiles it in.
            pub fn feature(self) -> &'static str {
                match self { $(Self::$variant => $feature,)* }
            }

            /// Its name for people and JSON.
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $name,)* }
            }
        }
    };
}

effects! {
    /// There is something for rays to hit.
    Geometry "GEOMETRY" "geometry",
    /// Triangle meshes.
    Triangles "TRIANGLES" "triangles",
    /// Analytic rectangles.
    Rectangles "RECTANGLES" "rectangles",
    /// Analytic disks.
    Disks "DISKS" "disks",
    /// Analytic spheres.
    Spheres "SPHERES" "spheres",
    /// Surfaces whose back does not exist.
    OneSided "ONE_SIDED" "one-sided-surfaces",
    /// A microfacet lobe.
    Glossy "GLOSSY" "glossy",
    /// Surfaces that emit.
    AreaLights "AREA_LIGHTS" "area-lights",
    /// Triangles, rectangles or disks that emit and are sampled.
    PlanarLights "LIGHT_PLANAR" "planar-lights",
    /// Triangles that emit.
    TriangleLights "LIGHT_TRIANGLES" "triangle-lights",
    /// Disks that emit.
    DiskLights "LIGHT_DISKS" "disk-lights",
    /// Parallelograms that emit and are not rectangles, and ellipses whose half axes are not orthogonal.
    SkewedLights "LIGHT_SKEWED" "skewed-lights",
    /// Spheres that emit.
    SphereLights "LIGHT_SPHERES" "sphere-lights",
    /// Point and spot lights.
    PointLights "LIGHT_POINTS" "point-lights",
    /// Directional lights.
    DirectionalLights "LIGHT_DIRECTIONALS" "directional-lights",
    /// Light from everywhere.
    Environment "ENVIRONMENT" "environment",
    /// An image of the environment.
    EnvironmentMap "ENVIRONMENT_MAP" "environment-map",
    /// An image of the environment that is interpolated between its texels.
    EnvironmentLinear "ENVIRONMENT_LINEAR" "environment-interpolation",
    /// More than one light to choose from.
    LightChoice "LIGHT_CHOICE" "light-choice",
    /// Every light has shadow rays of its own.
    AllLights "LIGHT_ALL" "all-lights",
    /// Several shadow rays per camera ray.
    ShadowRays "SHADOW_RAYS" "shadow-rays",
    /// Shadow rays end in the middle of lights.
    CenterPattern "SHADOW_CENTER" "center-pattern",
    /// Shadow rays end on a grid over lights.
    GridPattern "SHADOW_GRID" "grid-pattern",
    /// Shadow rays end in the cells of a grid over lights.
    StratifiedPattern "SHADOW_STRATIFIED" "stratified-pattern",
    /// Directions are chosen towards lights.
    SampleLights "SAMPLE_LIGHTS" "light-sampling",
    /// Directions are chosen in proportion to the BSDF.
    SampleBsdf "SAMPLE_BSDF" "bsdf-sampling",
    /// Directions are chosen uniformly over the hemisphere.
    UniformHemisphere "HEMISPHERE_UNIFORM" "uniform-hemisphere",
    /// Directions are chosen in proportion to the cosine.
    CosineHemisphere "HEMISPHERE_COSINE" "cosine-hemisphere",
    /// Lights are sampled over the solid angle in which they are seen.
    SolidAngleLights "LIGHT_SOLID_ANGLE" "solid-angle-sampling",
    /// Polygon lights are sampled over their projected solid angles.
    ProjectedLights "LIGHT_PROJECTED" "projected-solid-angle-sampling",
    /// Strategies are weighted by the balance heuristic.
    BalanceHeuristic "MIS_BALANCE" "balance-heuristic",
    /// Random numbers on jittered grids.
    StratifiedSampler "SAMPLER_STRATIFIED" "stratified-sampler",
    /// Random numbers by Sobol's sequence.
    SobolSampler "SAMPLER_SOBOL" "sobol-sampler",
    /// Random numbers by Sobol's sequence, shared by neighbouring pixels.
    BlueNoiseSampler "SAMPLER_BLUE_NOISE" "blue-noise-sampler",
    /// A lens with an extent.
    DepthOfField "DEPTH_OF_FIELD" "depth-of-field",
    /// A camera whose rays are parallel.
    Orthographic "ORTHOGRAPHIC" "orthographic",
    /// Pixels that show something else than their own squares.
    PixelFilter "PIXEL_FILTER" "pixel-filter",
}

impl Effect {
    /// Whether it is a way of sampling: compiled in without need it changes the image's noise.
    pub fn is_way_of_sampling(self) -> bool {
        matches!(
            self,
            Self::AllLights
                | Self::ShadowRays
                | Self::CenterPattern
                | Self::GridPattern
                | Self::StratifiedPattern
                | Self::SampleLights
                | Self::SampleBsdf
                | Self::UniformHemisphere
                | Self::CosineHemisphere
                | Self::SolidAngleLights
                | Self::ProjectedLights
                | Self::BalanceHeuristic
                | Self::StratifiedSampler
                | Self::SobolSampler
                | Self::BlueNoiseSampler
        )
    }
}

impl Effect {
    /// Whether it can be compiled in without need, and changes no bit of the image then: it is no way of sampling, and needs
    /// nothing that only a scene that calls for it has, as the environment does.
    pub fn can_be_forced(self) -> bool {
        let environment = [
            Self::Environment,
            Self::EnvironmentMap,
            Self::EnvironmentLinear,
        ];
        !self.is_way_of_sampling() && !environment.contains(&self)
    }
}

/// The effects that a render calls for, each with its reason.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Effects(BTreeMap<Effect, String>);

impl Effects {
    /// Adds an effect; the first reason stays.
    pub fn call_for(&mut self, effect: Effect, reason: impl FnOnce() -> String) {
        self.0.entry(effect).or_insert_with(reason);
    }

    /// Whether the effect is called for.
    pub fn contains(&self, effect: Effect) -> bool {
        self.0.contains_key(&effect)
    }

    /// The effects and their reasons, in the order of [`Effect::ALL`].
    pub fn iter(&self) -> impl Iterator<Item = (Effect, &str)> {
        self.0.iter().map(|(e, r)| (*e, r.as_str()))
    }

    /// WESL features with their values: every effect's feature is named.
    pub fn features(&self) -> impl Iterator<Item = (&'static str, bool)> {
        Effect::ALL.iter().map(|e| (e.feature(), self.contains(*e)))
    }
}

/// Finds what `scene` calls for under `strategy`.
pub fn called_for(
    scene: &Scene,
    primitives: &[Primitive],
    emitters: &Emitters,
    strategy: Strategy,
) -> Effects {
    let mut effects = Effects::default();
    of_camera(&mut effects, scene);
    of_surfaces(&mut effects, scene, primitives);
    let sampled = |index: usize| emitters.probability(index) > 0.0;
    for (index, light) in emitters.lights.iter().enumerate() {
        of_light(&mut effects, scene, primitives, light, sampled(index));
    }
    if let Some(selection) = &emitters.selection {
        of_light_sampling(&mut effects, emitters, selection, strategy);
        of_shadow_rays(&mut effects, emitters, &scene.render);
    }
    of_strategy(&mut effects, strategy, scene.render.light_sampling);
    let sampler = scene.render.sampler;
    let effect = match sampler {
        Sampler::Independent => None,
        Sampler::Stratified => Some(Effect::StratifiedSampler),
        Sampler::Sobol => Some(Effect::SobolSampler),
        Sampler::BlueNoise => Some(Effect::BlueNoiseSampler),
    };
    if let Some(effect) = effect {
        effects.call_for(effect, || format!("sampler {sampler}"));
    }
    effects
}

fn of_camera(effects: &mut Effects, scene: &Scene) {
    let further = [
        (Effect::DepthOfField, depth_of_field(scene)),
        (Effect::Orthographic, orthographic(scene)),
        (Effect::PixelFilter, pixel_filter(scene)),
    ];
    for (effect, reason) in further {
        if let Some(reason) = reason {
            effects.call_for(effect, || reason);
        }
    }
}

fn depth_of_field(scene: &Scene) -> Option<String> {
    let radius = scene.camera.lens.radius;
    (radius > 0.0).then(|| format!("camera.lens_radius = {radius}"))
}

fn orthographic(scene: &Scene) -> Option<String> {
    let orthographic = scene.camera.is_orthographic();
    orthographic.then(|| "camera.type = \"orthographic\"".to_owned())
}

fn pixel_filter(scene: &Scene) -> Option<String> {
    let filter = scene.filter;
    let reason = || {
        format!(
            "film.filter = \"{}\" of radius {}",
            filter.kind, filter.radius
        )
    };
    (!filter.is_pixel()).then(reason)
}

fn of_light_sampling(
    effects: &mut Effects,
    emitters: &Emitters,
    selection: &Selection,
    strategy: Strategy,
) {
    let lights = emitters.lights.len();
    match selection {
        Selection::One(_) if lights > 1 => {
            effects.call_for(Effect::LightChoice, || format!("{lights} lights"));
        }
        Selection::One(_) => {}
        Selection::All(_) => effects.call_for(Effect::AllLights, || {
            format!("light selection all, {lights} lights")
        }),
    }
    effects.call_for(Effect::SampleLights, || {
        if strategy.samples_lights() {
            format!("strategy {strategy}")
        } else {
            "lights without a surface, which no other strategy reaches".to_owned()
        }
    });
}

/// Several shadow rays are called for where a second one can differ from the first, a pattern where its points can.
fn of_shadow_rays(effects: &mut Effects, emitters: &Emitters, settings: &RenderSettings) {
    let pattern = settings.shadow_pattern;
    let extended = emitters.sampled().any(|l| !matches!(l, Emitter::Delta(_)));
    let has_texels =
        emitters.environment.is_some() && emitters.sampled().any(|l| *l == Emitter::Environment);
    let chosen = effects.contains(Effect::LightChoice) && emitters.sampled().count() > 1;
    let differ = chosen || has_texels || (extended && pattern != ShadowPattern::Center);
    let several = settings.shadow_rays > 1 && differ;
    if several {
        effects.call_for(Effect::ShadowRays, || {
            format!("shadow_rays = {}", settings.shadow_rays)
        });
    }
    let effect = match pattern {
        ShadowPattern::Stratified if several => Effect::StratifiedPattern,
        ShadowPattern::Grid if extended && several => Effect::GridPattern,
        ShadowPattern::Grid | ShadowPattern::Center if extended => Effect::CenterPattern,
        _ => return,
    };
    effects.call_for(effect, || format!("shadow_pattern = \"{pattern}\""));
}

fn of_strategy(effects: &mut Effects, strategy: Strategy, light_sampling: LightSampling) {
    let reason = || format!("strategy {strategy}");
    let reachable = effects.contains(Effect::AreaLights) || effects.contains(Effect::Environment);
    if strategy.samples_directions() && reachable {
        effects.call_for(Effect::SampleBsdf, reason);
        match strategy {
            Strategy::UniformHemisphere => effects.call_for(Effect::UniformHemisphere, reason),
            Strategy::CosineHemisphere => effects.call_for(Effect::CosineHemisphere, reason),
            Strategy::MisBalance => effects.call_for(Effect::BalanceHeuristic, reason),
            _ => {}
        }
    }
    let area_lights =
        effects.contains(Effect::PlanarLights) || effects.contains(Effect::SphereLights);
    let sampling = match strategy {
        Strategy::LightArea => LightSampling::Area,
        Strategy::LightSolidAngle => LightSampling::SolidAngle,
        Strategy::LightProjectedSolidAngle => LightSampling::ProjectedSolidAngle,
        _ => light_sampling,
    };
    if area_lights && sampling != LightSampling::Area {
        effects.call_for(Effect::SolidAngleLights, reason);
    }
    let polygons = effects.contains(Effect::PlanarLights);
    if polygons && sampling == LightSampling::ProjectedSolidAngle {
        effects.call_for(Effect::ProjectedLights, reason);
    }
}

fn of_surfaces(effects: &mut Effects, scene: &Scene, primitives: &[Primitive]) {
    for primitive in primitives {
        let shape = || scene.shapes[primitive.shape.index()].name.clone();
        let material = &scene.materials[primitive.material.index()];
        effects.call_for(Effect::Geometry, shape);
        let kind = match primitive.geometry {
            PrimitiveGeometry::Triangle { .. } => Effect::Triangles,
            PrimitiveGeometry::Rectangle { .. } => Effect::Rectangles,
            PrimitiveGeometry::Disk { .. } => Effect::Disks,
            PrimitiveGeometry::Sphere { .. } => Effect::Spheres,
        };
        effects.call_for(kind, shape);
        if !material.double_sided {
            effects.call_for(Effect::OneSided, || {
                format!("materials.{}: double_sided = false", material.name)
            });
        }
        if let Some(lobe) = material.bsdf.parameters().specular {
            effects.call_for(Effect::Glossy, || {
                format!(
                    "materials.{}: GGX with α = {:.4}",
                    material.name, lobe.alpha
                )
            });
        }
    }
}

fn of_light(
    effects: &mut Effects,
    scene: &Scene,
    primitives: &[Primitive],
    light: &Emitter,
    sampled: bool,
) {
    match light {
        Emitter::Area { primitive, .. } => {
            let primitive = &primitives[*primitive as usize];
            let reason = || format!("{} emits", scene.shapes[primitive.shape.index()].name);
            effects.call_for(Effect::AreaLights, reason);
            if !sampled {
                return;
            }
            let kind = match primitive.geometry {
                PrimitiveGeometry::Sphere { .. } => Effect::SphereLights,
                PrimitiveGeometry::Triangle { .. } => Effect::TriangleLights,
                PrimitiveGeometry::Disk { .. } => Effect::DiskLights,
                PrimitiveGeometry::Rectangle { .. } => Effect::PlanarLights,
            };
            effects.call_for(kind, reason);
            if kind != Effect::SphereLights {
                effects.call_for(Effect::PlanarLights, reason);
            }
            if primitive.geometry.is_skewed() {
                effects.call_for(Effect::SkewedLights, reason);
            }
        }
        Emitter::Delta(Light::Directional { .. }) => {
            effects.call_for(Effect::DirectionalLights, || {
                "a directional light".to_owned()
            });
        }
        Emitter::Delta(Light::Point { .. }) => {
            effects.call_for(Effect::PointLights, || "a point light".to_owned());
        }
        Emitter::Delta(Light::Spot { .. }) => {
            effects.call_for(Effect::PointLights, || "a spot light".to_owned());
        }
        Emitter::Environment => {
            effects.call_for(Effect::Environment, || "[environment]".to_owned());
            let radiance = scene.environment.as_ref().map(|e| &e.radiance);
            if let Some(EnvironmentRadiance::Map(map)) = radiance {
                effects.call_for(Effect::EnvironmentMap, || {
                    format!(
                        "environment.file = {} ({} × {})",
                        map.source, map.width, map.height
                    )
                });
                if map.interpolation == Interpolation::Linear {
                    effects.call_for(Effect::EnvironmentLinear, || {
                        "environment.interpolation = \"linear\"".to_owned()
                    });
                }
            }
        }
    }
}
