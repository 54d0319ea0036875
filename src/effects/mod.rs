//! What a scene calls for: every piece of shader code that is not always there, and the reason why
//! it is.
//!
//! An effect is derived from the scene, never declared by the user. Each maps to a WESL feature:
//! code under `@if(GLOSSY)` is not in the WGSL unless some material has a microfacet lobe. The
//! table below is the whole list: an entry per effect, with the rule that calls for it; what the
//! scale of a scene calls for is decided where that is measured, in
//! [`Prepared`](crate::prepare::Prepared).

mod rules;

use crate::accel::PrimitiveGeometry as Shape;
use crate::emitters::Emitter;
use crate::scene::settings::{DirectionSampling, Heuristic};
use crate::scene::{Light, Sampler, ShadowPattern};
pub use rules::EffectQuery;
use rules::Rules;
use std::collections::BTreeMap;

/// What an unneeded effect does to an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// Nothing, bit for bit.
    Simulation,
    /// Changes how samples are drawn: same expected image, different noise.
    Sampling,
    /// Changes how numbers are rounded: the same image but for the last digits.
    Arithmetic,
}

macro_rules! effects {
    ($($(#[$doc:meta])* $variant:ident $feature:literal $name:literal $kind:ident $rule:expr;)*) => {
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

            /// Whether it is a way of sampling: compiled in without need it changes the image's
            /// noise.
            pub fn is_way_of_sampling(self) -> bool {
                let kind = match self { $(Self::$variant => Kind::$kind,)* };
                kind == Kind::Sampling
            }

            /// Whether it can be compiled in without need, and changes no bit of the image then.
            pub fn can_be_forced(self) -> bool {
                let kind = match self { $(Self::$variant => Kind::$kind,)* };
                kind == Kind::Simulation
            }

            /// Why the scene calls for it, where it does.
            fn reason(self, rules: &Rules<'_>) -> Option<String> {
                type Rule = fn(&Rules<'_>) -> Option<String>;
                match self { $(Self::$variant => { let rule: Rule = $rule; rule(rules) })* }
            }
        }
    };
}

// A rule may ask for the effects above its own.
effects! {
    /// There is something for rays to hit.
    Geometry "GEOMETRY" "geometry" Simulation |r| r.shape(|_| true);
    /// Triangle meshes.
    Triangles "TRIANGLES" "triangles" Simulation |r| r.shape(|s| matches!(s, Shape::Triangle { .. }));
    /// Analytic rectangles.
    Rectangles "RECTANGLES" "rectangles" Simulation |r| r.shape(|s| matches!(s, Shape::Rectangle { .. }));
    /// Analytic disks.
    Disks "DISKS" "disks" Simulation |r| r.shape(|s| matches!(s, Shape::Disk { .. }));
    /// Analytic spheres.
    Spheres "SPHERES" "spheres" Simulation |r| r.shape(|s| matches!(s, Shape::Sphere { .. }));
    /// Analytic ellipsoids.
    Ellipsoids "ELLIPSOIDS" "ellipsoids" Simulation |r| r.shape(|s| matches!(s, Shape::Ellipsoid { .. }));
    /// Boxes of the hierarchy on a logarithmic grid: detail in a scene that is much larger.
    LogarithmicGrid "LOGARITHMIC_GRID" "logarithmic-grid" Simulation |_| None;
    /// A small scene, or a few large primitives, for which the kernel is specialized: these are not
    /// loaded.
    SpecializedScene "SPECIALIZED_SCENE" "specialized-scene" Arithmetic |_| None;
    /// Surfaces whose back does not exist.
    OneSided "ONE_SIDED" "one-sided-surfaces" Simulation
        |r| r.material(|m| (!m.double_sided).then(|| "double_sided = false".to_owned()));
    /// A microfacet lobe.
    Glossy "GLOSSY" "glossy" Simulation |r| r.material(rules::microfacets);
    /// Mirrors and glass, in which camera rays go on.
    Specular "SPECULAR" "specular" Simulation |r| r.material(rules::goes_on);
    /// Surfaces that light passes through.
    Refraction "REFRACTION" "refraction" Simulation |r| r.material(rules::passes_through);
    /// Fresnel's equations for dielectrics.
    ExactDielectric "EXACT_DIELECTRIC" "dielectric-fresnel" Simulation |r| r.material(rules::dielectric);
    /// Fresnel's equations for conductors.
    ExactConductor "EXACT_CONDUCTOR" "conductor-fresnel" Simulation |r| r.material(rules::conductor);
    /// Light that meets several facets of a rough metal.
    EnergyCompensation "ENERGY_COMPENSATION" "energy-compensation" Simulation |r| r.energy_compensation();
    /// Vertex normals between which shading normals are interpolated.
    SmoothNormals "SMOOTH_NORMALS" "smooth-normals" Simulation |r| r.attributed(|a| a.normals);
    /// Vertex colours: factors on reflectance or base colour, and on opacity.
    VertexColors "VERTEX_COLORS" "vertex-colors" Simulation |r| r.attributed(|a| a.colors);
    /// Textures of reflectance or base colour.
    ColorTexture "COLOR_TEXTURE" "color-texture" Simulation |r| r.texture(|t| t.color);
    /// Textures of metallic and roughness.
    RoughnessTexture "ROUGHNESS_TEXTURE" "roughness-texture" Simulation |r| r.texture(|t| t.metallic_roughness);
    /// Textures of reflectance at normal incidence and glossiness.
    GlossinessTexture "GLOSSINESS_TEXTURE" "glossiness-texture" Simulation |r| r.texture(|t| t.specular_glossiness);
    /// Textures that make metal of parts of a glass.
    MetalMask "METAL_MASK" "metal-mask" Simulation
        |r| r.material(|m| m.bsdf.is_masked().then(|| "metal in parts, glass elsewhere".to_owned()));
    /// Surfaces that show their colour whatever lights there are.
    Unlit "UNLIT" "unlit" Simulation
        |r| r.material(|m| m.bsdf.parameters().unlit.then(|| "shows its colour".to_owned()));
    /// Textures of shading normals.
    NormalMap "NORMAL_MAP" "normal-map" Simulation |r| r.texture(|t| t.normal.map(|map| map.texture));
    /// Textures of one material that are read with two sets of texture coordinates.
    SecondUvs "SECOND_UVS" "second-texture-coordinates" Simulation |r| r.attributed(|a| a.second_uvs);
    /// Tangents of vertices for normal maps.
    Tangents "TANGENTS" "tangents" Simulation |r| r.attributed(|a| a.tangents);
    /// Surfaces that stop a ray by chance, or where a mask is.
    Alpha "ALPHA" "alpha" Simulation |r| r.opacity();
    /// Textures of opacity.
    AlphaTexture "ALPHA_TEXTURE" "alpha-texture" Simulation |r| r.opacity_texture();
    /// Surfaces that emit.
    AreaLights "AREA_LIGHTS" "area-lights" Simulation |r| r.emitting_shape(|_, _| true);
    /// Textures of what surfaces emit.
    EmissiveTexture "EMISSIVE_TEXTURE" "emissive-texture" Simulation |r| r.emissive_texture();
    /// Triangles, rectangles or disks that emit and are sampled.
    PlanarLights "LIGHT_PLANAR" "planar-lights" Simulation
        |r| r.emitting_shape(|s, sampled| sampled && !matches!(s, Shape::Sphere { .. } | Shape::Ellipsoid { .. }));
    /// Triangles that emit.
    TriangleLights "LIGHT_TRIANGLES" "triangle-lights" Simulation
        |r| r.emitting_shape(|s, sampled| sampled && matches!(s, Shape::Triangle { .. }));
    /// Disks that emit.
    DiskLights "LIGHT_DISKS" "disk-lights" Simulation
        |r| r.emitting_shape(|s, sampled| sampled && matches!(s, Shape::Disk { .. }));
    /// Parallelograms that emit and are not rectangles, and ellipses whose half axes are not
    /// orthogonal.
    SkewedLights "LIGHT_SKEWED" "skewed-lights" Simulation |r| r.emitting_shape(|s, sampled| sampled && s.is_skewed());
    /// Spheres that emit.
    SphereLights "LIGHT_SPHERES" "sphere-lights" Simulation
        |r| r.emitting_shape(|s, sampled| sampled && matches!(s, Shape::Sphere { .. }));
    /// Ellipsoids that emit.
    EllipsoidLights "LIGHT_ELLIPSOIDS" "ellipsoid-lights" Simulation
        |r| r.emitting_shape(|s, sampled| sampled && matches!(s, Shape::Ellipsoid { .. }));
    /// Point lights.
    PointLights "LIGHT_POINTS" "point-lights" Simulation
        |r| r.light(|light| matches!(light, Emitter::Delta(Light::Point(_))).then_some("a point light"));
    /// Spot lights.
    SpotLights "LIGHT_SPOTS" "spot-lights" Simulation
        |r| r.light(|light| matches!(light, Emitter::Delta(Light::Spot(_))).then_some("a spot light"));
    /// Directional lights.
    DirectionalLights "LIGHT_DIRECTIONALS" "directional-lights" Simulation
        |r| r.light(|light| matches!(light, Emitter::Delta(Light::Directional(_))).then_some("a directional light"));
    /// Directional lights with an extent.
    Suns "SUNS" "suns" Simulation |r| r.light(|light| matches!(light, Emitter::Sun(_)).then_some("a sun"));
    /// Light from everywhere.
    Environment "ENVIRONMENT" "environment" Simulation
        |r| r.light(|light| (*light == Emitter::Environment).then_some("[environment]"));
    /// An image of the environment.
    EnvironmentMap "ENVIRONMENT_MAP" "environment-map" Simulation |r| r.environment_map();
    /// An image of the environment that is interpolated between its texels.
    EnvironmentLinear "ENVIRONMENT_LINEAR" "environment-interpolation" Simulation |r| r.environment_interpolation();
    /// More than one light to choose from.
    LightChoice "LIGHT_CHOICE" "light-choice" Simulation |r| r.light_choice();
    /// A light is chosen by a tree over the lights.
    LightTree "LIGHT_TREE" "light-tree" Sampling |r| r.light_tree();
    /// Every light has shadow rays of its own.
    AllLights "LIGHT_ALL" "all-lights" Sampling |r| r.all_lights();
    /// Several shadow rays per camera ray.
    ShadowRays "SHADOW_RAYS" "shadow-rays" Sampling |r| r.shadow_rays();
    /// Shadow rays end in the middle of lights.
    CenterPattern "SHADOW_CENTER" "center-pattern" Sampling |r| r.shadow_pattern(ShadowPattern::Center);
    /// Shadow rays end on a grid over lights.
    GridPattern "SHADOW_GRID" "grid-pattern" Sampling |r| r.shadow_pattern(ShadowPattern::Grid);
    /// Shadow rays end in the cells of a grid over lights.
    StratifiedPattern "SHADOW_STRATIFIED" "stratified-pattern" Sampling |r| r.shadow_pattern(ShadowPattern::Stratified);
    /// Directions are chosen towards lights.
    SampleLights "SAMPLE_LIGHTS" "light-sampling" Sampling |r| r.light_sampling();
    /// Surfaces with an opacity that emit and are sampled.
    AlphaLights "ALPHA_LIGHTS" "alpha-lights" Simulation |r| r.alpha_lights();
    /// Directions are chosen in proportion to the BSDF.
    SampleBsdf "SAMPLE_BSDF" "bsdf-sampling" Sampling |r| r.bsdf_sampling();
    /// BSDF-sampled rays that may find light beyond all surfaces: without, only those are traced
    /// that come near a surface that emits.
    EscapingRays "ESCAPING_RAYS" "escaping-rays" Simulation |r| r.escaping_rays();
    /// Directions are chosen uniformly over the hemisphere.
    UniformHemisphere "HEMISPHERE_UNIFORM" "uniform-hemisphere" Sampling |r| r.directions(DirectionSampling::UniformHemisphere);
    /// Directions are chosen in proportion to the cosine.
    CosineHemisphere "HEMISPHERE_COSINE" "cosine-hemisphere" Sampling |r| r.directions(DirectionSampling::CosineHemisphere);
    /// Lights are sampled over the solid angle in which they are seen.
    SolidAngleLights "LIGHT_SOLID_ANGLE" "solid-angle-sampling" Sampling |r| r.solid_angle_sampling();
    /// Polygon lights are sampled over their projected solid angles.
    ProjectedLights "LIGHT_PROJECTED" "projected-solid-angle-sampling" Sampling |r| r.projected_sampling();
    /// Strategies are weighted by the balance heuristic.
    BalanceHeuristic "MIS_BALANCE" "balance-heuristic" Sampling |r| r.heuristic(Heuristic::Balance);
    /// Random numbers on jittered grids.
    StratifiedSampler "SAMPLER_STRATIFIED" "stratified-sampler" Sampling |r| r.sampler(Sampler::Stratified);
    /// Random numbers by Sobol's sequence.
    SobolSampler "SAMPLER_SOBOL" "sobol-sampler" Sampling |r| r.sampler(Sampler::Sobol);
    /// Random numbers by Sobol's sequence, shared by neighbouring pixels.
    BlueNoiseSampler "SAMPLER_BLUE_NOISE" "blue-noise-sampler" Sampling |r| r.sampler(Sampler::BlueNoise);
    /// A lens with an extent.
    DepthOfField "DEPTH_OF_FIELD" "depth-of-field" Simulation |r| r.depth_of_field();
    /// A camera whose rays are parallel.
    Orthographic "ORTHOGRAPHIC" "orthographic" Simulation |r| r.orthographic();
    /// A camera that is so far away that its rays begin nearer.
    DistantCamera "DISTANT_CAMERA" "distant-camera" Simulation |_| None;
    /// Pixels that show something else than their own squares.
    PixelFilter "PIXEL_FILTER" "pixel-filter" Simulation |r| r.pixel_filter();
    /// Lights that the camera sees: small ones and the edges of larger ones are sampled there.
    LightsInView "LIGHTS_IN_VIEW" "lights-in-view" Sampling |_| None;
    /// Lights that camera rays meet by chance alone, in mirrors and glass for the most part, but which
    /// they nearly meet more often.
    NearMisses "NEAR_MISSES" "near-misses" Simulation |_| None;
    /// The light of groups of lights apart.
    LightGroups "LIGHT_GROUPS" "light-groups" Simulation |r| r.light_groups();
}

/// The effects that a render calls for, each with its reason.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Effects(BTreeMap<Effect, String>);

impl Effects {
    /// The effects that a scene calls for.
    pub fn called_for(query: &EffectQuery<'_>) -> Self {
        let mut rules = Rules {
            query,
            found: Self::default(),
        };
        for &effect in Effect::ALL {
            if let Some(reason) = effect.reason(&rules) {
                rules.found.call_for(effect, || reason);
            }
        }
        rules.found
    }

    /// Adds an effect; the first reason stays.
    pub fn call_for(&mut self, effect: Effect, reason: impl FnOnce() -> String) {
        self.0.entry(effect).or_insert_with(reason);
    }

    /// Takes an effect out.
    pub(crate) fn remove(&mut self, effect: Effect) {
        self.0.remove(&effect);
    }

    /// Whether `effect` is not among them and can be compiled in all the same; see
    /// [`Effect::can_be_forced`].
    pub fn can_force(&self, effect: Effect) -> bool {
        effect.can_be_forced() && !self.contains(effect)
    }

    /// Adds an effect that nothing calls for.
    pub fn force(&mut self, effect: Effect) {
        self.call_for(effect, || "forced".to_owned());
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
