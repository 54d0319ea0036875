//! The questions that the rules of the table of effects ask.

use super::{Effect, Effects};
use crate::accel::{Attributed, Attributes, Primitive, PrimitiveGeometry};
use crate::emitters::{Emitter, Emitters, Selection};
use crate::scene::environment::Interpolation;
use crate::scene::material::Fresnel;
use crate::scene::settings::{DirectionSampling, Heuristic, Techniques};
use crate::scene::shadow_rays::MAX_LIGHT_SAMPLES;
use crate::scene::{
    Camera, EnvironmentMap, EnvironmentRadiance, LightSampling, Material, MaterialTextures,
    RenderSettings, Sampler, Scene, ShadowPattern, ShadowRays, TextureUse,
};
use std::ops::Deref;

/// The width of a material's microfacet lobe.
pub(super) fn microfacets(material: &Material) -> Option<String> {
    let own = material.bsdf.parameters().specular.map(|lobe| lobe.alpha);
    let alpha = material.bsdf.masked_alpha().or(own)?;
    (alpha > 0.0).then(|| format!("GGX with α = {alpha:.4}"))
}

/// Why camera rays go on from a material.
pub(super) fn goes_on(material: &Material) -> Option<String> {
    let parameters = material.bsdf.parameters();
    let kind = if parameters.transmission.is_some() {
        "transparent"
    } else {
        "a mirror"
    };
    parameters.is_specular().then(|| kind.to_owned())
}

/// What passes through a material.
pub(super) fn passes_through(material: &Material) -> Option<String> {
    let through = material.bsdf.parameters().transmission?;
    Some(if through.thin {
        "a pane without thickness".to_owned()
    } else {
        format!("index of refraction {}", through.ior)
    })
}

/// The index of refraction in a material's Fresnel terms.
pub(super) fn dielectric(material: &Material) -> Option<String> {
    match material.bsdf.parameters().specular?.fresnel {
        Fresnel::Dielectric { ior } => Some(format!("index of refraction {ior}")),
        _ => None,
    }
}

/// The complex index of refraction in a material's Fresnel terms.
pub(super) fn conductor(material: &Material) -> Option<String> {
    match material.bsdf.parameters().specular?.fresnel {
        Fresnel::Conductor { eta, k } => Some(format!("index of refraction {eta} + i·{k}")),
        _ => None,
    }
}

/// The width of a lobe that loses energy by leaving out what meets several facets; a coat's is not
/// compensated.
fn rough_metal(material: &Material) -> Option<String> {
    let lobe = material.bsdf.parameters().specular?;
    let masked = material.bsdf.masked_alpha();
    let coat = masked.is_none() && matches!(lobe.fresnel, Fresnel::Dielectric { .. });
    let alpha = masked.unwrap_or(lobe.alpha);
    (alpha > 0.0 && !coat).then(|| format!("energy_compensation = true, GGX with α = {alpha:.4}"))
}

/// A scene as an estimator renders it, of which the rules ask what it calls for.
#[derive(Debug, Clone, Copy)]
pub struct EffectQuery<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The camera, which may be another than the scene's.
    pub camera: &'a Camera,
    /// The estimator and all else that the table `[render]` holds.
    pub settings: &'a RenderSettings,
    /// The scene's primitives.
    pub primitives: &'a [Primitive],
    /// Their vertex normals, texture coordinates and colours.
    pub attributes: &'a Attributes,
    /// Its lights.
    pub emitters: &'a Emitters,
}

/// A query, and the effects that were found to be called for so far.
pub(super) struct Rules<'a> {
    pub(super) query: &'a EffectQuery<'a>,
    pub(super) found: Effects,
}

impl<'a> Deref for Rules<'a> {
    type Target = EffectQuery<'a>;

    fn deref(&self) -> &EffectQuery<'a> {
        self.query
    }
}

impl Rules<'_> {
    fn has(&self, effect: Effect) -> bool {
        self.found.contains(effect)
    }

    fn name_of(&self, primitive: &Primitive) -> String {
        self.scene.shapes[primitive.shape.index()].name.clone()
    }

    /// The first shape for which `wanted` holds.
    pub(super) fn shape(&self, wanted: fn(&PrimitiveGeometry) -> bool) -> Option<String> {
        let found = self.primitives.iter().find(|p| wanted(&p.geometry));
        found.map(|p| self.name_of(p))
    }

    /// The first material of a surface for which `why` says something.
    pub(super) fn material(&self, why: fn(&Material) -> Option<String>) -> Option<String> {
        let mut asked = vec![false; self.scene.materials.len()];
        self.primitives.iter().find_map(|p| {
            let index = p.material.index();
            if std::mem::replace(&mut asked[index], true) {
                return None;
            }
            let material = &self.scene.materials[index];
            why(material).map(|why| format!("materials.{}: {why}", material.name))
        })
    }

    /// The first primitive for whose attributes `wanted` holds.
    pub(super) fn attributed(&self, wanted: fn(&Attributed) -> bool) -> Option<String> {
        let primitives = self.primitives.iter().zip(&self.attributes.of_primitive);
        let mut primitives = primitives.filter(|(_, attributes)| wanted(attributes));
        primitives.next().map(|(p, _)| self.name_of(p))
    }

    /// The first texture that `which` names and that a surface with texture coordinates reads.
    pub(super) fn texture(
        &self,
        which: fn(&MaterialTextures) -> Option<TextureUse>,
    ) -> Option<String> {
        self.texture_of(|material| which(&material.textures))
    }

    /// The same of all that a material reads.
    fn texture_of(&self, which: impl Fn(&Material) -> Option<TextureUse>) -> Option<String> {
        let primitives = self.primitives.iter().zip(&self.attributes.of_primitive);
        let mut primitives = primitives.filter(|(_, attributes)| attributes.uvs);
        primitives.find_map(|(p, _)| {
            let material = &self.scene.materials[p.material.index()];
            let texture = &self.scene.textures[which(material)?.texture.index()];
            Some(format!(
                "materials.{}: {} ({} × {})",
                material.name, texture.source, texture.width, texture.height
            ))
        })
    }

    /// The first opacity of a primitive that is not 1 everywhere.
    pub(super) fn opacity(&self) -> Option<String> {
        let primitives = self.primitives.iter().zip(&self.attributes.of_primitive);
        let mut primitives = primitives.filter(|(_, attributes)| attributes.opacity);
        primitives.next().map(|(p, attributes)| {
            let material = &self.scene.materials[p.material.index()];
            let opacity = &material.opacity;
            let mut said = format!("materials.{}: opacity {}", material.name, opacity.factor);
            if let Some(used) = opacity.texture.filter(|_| attributes.uvs) {
                said += &format!(" × {}", self.scene.textures[used.texture.index()].source);
            }
            if attributes.colors {
                said += " × vertex alpha";
            }
            if let Some(cutoff) = opacity.cutoff {
                // Rounded: it may have been moved by what a texture's rounding asks for.
                said += &format!(", cutoff {}", (cutoff * 1000.0).round() / 1000.0);
            }
            said
        })
    }

    /// The first shape with an opacity that emits and is sampled.
    pub(super) fn alpha_lights(&self) -> Option<String> {
        let mut lights = self.emitters.lights.iter().enumerate();
        lights.find_map(|(index, light)| {
            let Emitter::Area { primitive, .. } = light else {
                return None;
            };
            let opacity = self.attributes.of_primitive[*primitive as usize].opacity;
            let sampled = self.emitters.probability(index) > 0.0;
            let name = || self.name_of(&self.primitives[*primitive as usize]);
            (opacity && sampled).then(|| format!("{} emits and has an opacity", name()))
        })
    }

    pub(super) fn opacity_texture(&self) -> Option<String> {
        self.texture_of(|material| material.opacity.texture)
    }

    pub(super) fn energy_compensation(&self) -> Option<String> {
        let wanted = self.settings.estimator.energy_compensation;
        wanted.then(|| self.material(rough_metal)).flatten()
    }

    /// The first shape that emits and for which `wanted` holds; the second argument tells whether
    /// light sampling chooses it.
    pub(super) fn emitting_shape(
        &self,
        wanted: fn(&PrimitiveGeometry, bool) -> bool,
    ) -> Option<String> {
        let mut lights = self.emitters.lights.iter().enumerate();
        lights.find_map(|(index, light)| {
            let Emitter::Area { primitive, .. } = light else {
                return None;
            };
            let primitive = &self.primitives[*primitive as usize];
            let sampled = self.emitters.probability(index) > 0.0;
            wanted(&primitive.geometry, sampled)
                .then(|| format!("{} emits", self.name_of(primitive)))
        })
    }

    /// The first texture that varies a light.
    pub(super) fn emissive_texture(&self) -> Option<String> {
        let map = self.emitters.maps.first()?;
        let texture = &self.scene.textures[map.texture.texture.index()];
        Some(format!(
            "{} emits {} ({} × {})",
            self.scene.shapes[map.shape.index()].name,
            texture.source,
            texture.width,
            texture.height
        ))
    }

    /// The first light for which `name` says something.
    pub(super) fn light(&self, name: fn(&Emitter) -> Option<&'static str>) -> Option<String> {
        self.query
            .emitters
            .lights
            .iter()
            .find_map(name)
            .map(str::to_owned)
    }

    fn map(&self) -> Option<&EnvironmentMap> {
        let environment = self.scene.environment.as_ref()?;
        match &environment.radiance {
            EnvironmentRadiance::Map(map) if self.has(Effect::Environment) => Some(map),
            _ => None,
        }
    }

    /// Whether BSDF-sampled rays find light where they leave the scene.
    pub(super) fn escaping_rays(&self) -> Option<String> {
        let beyond = self.light(|light| match light {
            Emitter::Environment => Some("[environment]"),
            Emitter::Sun(_) => Some("a sun"),
            Emitter::Area { .. } | Emitter::Delta(_) => None,
        });
        beyond.filter(|_| self.has(Effect::SampleBsdf))
    }

    pub(super) fn environment_map(&self) -> Option<String> {
        self.map().map(|map| {
            format!(
                "environment.file = {} ({} × {})",
                map.source, map.width, map.height
            )
        })
    }

    pub(super) fn environment_interpolation(&self) -> Option<String> {
        let linear = self.map()?.interpolation == Interpolation::Linear;
        linear.then(|| "environment.interpolation = \"linear\"".to_owned())
    }

    pub(super) fn light_choice(&self) -> Option<String> {
        let lights = self.emitters.lights.len();
        let one = matches!(self.emitters.selection, Some(Selection::One(_)));
        (one && lights > 1).then(|| format!("{lights} lights"))
    }

    pub(super) fn light_tree(&self) -> Option<String> {
        let tree = matches!(self.emitters.selection, Some(Selection::Tree(_)));
        tree.then(|| self.by_selection())
    }

    pub(super) fn all_lights(&self) -> Option<String> {
        let all = matches!(self.emitters.selection, Some(Selection::All(_)));
        all.then(|| self.by_selection())
    }

    fn by_selection(&self) -> String {
        let asked = self.settings.estimator.light_selection;
        let lights = self.emitters.lights.len();
        format!("light_selection = \"{asked}\", {lights} lights")
    }

    /// Whether some light that is sampled has a surface, or is the environment.
    fn samples_extended_lights(&self) -> bool {
        let mut sampled = self.emitters.sampled();
        sampled.any(|light| !matches!(light, Emitter::Delta(_)))
    }

    /// Called for where a second ray can differ from the first.
    pub(super) fn shadow_rays(&self) -> Option<String> {
        let (rays, pattern) = (
            self.settings.estimator.shadow_rays,
            self.settings.estimator.shadow_pattern,
        );
        let center = pattern == ShadowPattern::Center;
        let has_texels = self.emitters.environment.is_some()
            && self.emitters.sampled().any(|l| *l == Emitter::Environment);
        let chooses = self.has(Effect::LightChoice) || self.has(Effect::LightTree);
        let chosen = chooses && self.emitters.sampled().count() > 1;
        let differ = chosen || has_texels || (self.samples_extended_lights() && !center);
        let lights = 0..self.emitters.lights.len();
        let most: f64 = lights
            .map(|light| self.emitters.samples(light, rays.most()))
            .sum();
        let fit = most <= MAX_LIGHT_SAMPLES as f64;
        match rays {
            ShadowRays::Auto => (differ && fit && pattern == ShadowPattern::Random)
                .then(|| format!("shadow_rays = \"auto\": 1 or {}", rays.most())),
            ShadowRays::Number(_) => {
                (rays.most() > 1 && differ).then(|| format!("shadow_rays = {rays}"))
            }
        }
    }

    /// Called for where its points can differ from others. A grid of one cell is its centre.
    pub(super) fn shadow_pattern(&self, effect: ShadowPattern) -> Option<String> {
        let asked = self.settings.estimator.shadow_pattern;
        let extended = self.samples_extended_lights();
        let several = self.has(Effect::ShadowRays);
        let used = match asked {
            ShadowPattern::Stratified if several => ShadowPattern::Stratified,
            ShadowPattern::Grid if extended && several => ShadowPattern::Grid,
            ShadowPattern::Grid | ShadowPattern::Center if extended => ShadowPattern::Center,
            _ => return None,
        };
        (used == effect).then(|| format!("shadow_pattern = \"{asked}\""))
    }

    pub(super) fn light_sampling(&self) -> Option<String> {
        self.emitters.selection.as_ref()?;
        Some(if self.techniques().lights.is_some() {
            self.by_strategy()
        } else {
            "lights without a surface, which no other strategy reaches".to_owned()
        })
    }

    fn by_strategy(&self) -> String {
        format!("strategy {}", self.settings.estimator.strategy)
    }

    pub(super) fn bsdf_sampling(&self) -> Option<String> {
        let can_be_hit = [Effect::AreaLights, Effect::Suns, Effect::Environment];
        let reachable = can_be_hit.into_iter().any(|effect| self.has(effect));
        (self.techniques().directions.is_some() && reachable).then(|| self.by_strategy())
    }

    pub(super) fn directions(&self, sampling: DirectionSampling) -> Option<String> {
        let asked = self.techniques().directions == Some(sampling);
        (self.has(Effect::SampleBsdf) && asked).then(|| self.by_strategy())
    }

    pub(super) fn heuristic(&self, heuristic: Heuristic) -> Option<String> {
        let asked = self.techniques().heuristic == Some(heuristic);
        (self.has(Effect::SampleBsdf) && asked).then(|| self.by_strategy())
    }

    fn techniques(&self) -> Techniques {
        self.settings.estimator.techniques()
    }

    /// How points of lights are sampled: also where no light with a surface is.
    fn sampling_of_lights(&self) -> LightSampling {
        let estimator = &self.settings.estimator;
        self.techniques().lights.unwrap_or(estimator.light_sampling)
    }

    pub(super) fn solid_angle_sampling(&self) -> Option<String> {
        let area_lights = [
            Effect::PlanarLights,
            Effect::SphereLights,
            Effect::EllipsoidLights,
        ];
        let sampled = area_lights.into_iter().any(|effect| self.has(effect));
        let wanted = self.sampling_of_lights() != LightSampling::Area;
        (sampled && wanted).then(|| self.by_strategy())
    }

    pub(super) fn projected_sampling(&self) -> Option<String> {
        let wanted = self.sampling_of_lights() == LightSampling::ProjectedSolidAngle;
        (self.has(Effect::PlanarLights) && wanted).then(|| self.by_strategy())
    }

    pub(super) fn depth_of_field(&self) -> Option<String> {
        let radius = self.camera.lens.radius;
        (radius > 0.0).then(|| format!("camera.lens_radius = {radius}"))
    }

    pub(super) fn orthographic(&self) -> Option<String> {
        let orthographic = self.camera.is_orthographic();
        orthographic.then(|| "camera.type = \"orthographic\"".to_owned())
    }

    pub(super) fn pixel_filter(&self) -> Option<String> {
        let filter = self.scene.filter;
        let (kind, radius) = (filter.kind, filter.radius);
        (!filter.is_pixel()).then(|| format!("film.filter = \"{kind}\" of radius {radius}"))
    }

    pub(super) fn light_groups(&self) -> Option<String> {
        let names = &self.emitters.groups.names;
        (!names.is_empty()).then(|| format!("AOV light-groups: {}", names.join(", ")))
    }

    pub(super) fn sampler(&self, sampler: Sampler) -> Option<String> {
        (self.settings.estimator.sampler == sampler).then(|| format!("sampler {sampler}"))
    }
}
