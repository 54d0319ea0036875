//! Materials: the factors of the metallic-roughness model, opacity and emission.

use super::coordinates::CoordinateSets;
use super::document::Document;
use super::layers;
use super::textures::{Named, is_unlit, specular_glossiness, texture_use};
use crate::error::InputError;
use crate::scene::load::texture::{Meaning, Textures};
use crate::scene::material::DielectricLayer;
use crate::scene::{
    Bsdf, Emission, Material, MaterialId, MaterialTextures, NormalMap, Opacity, TextureUse,
};
use glam::DVec3;
use gltf::json::material::AlphaMode;
use gltf::json::validation::Checked;
use std::collections::{BTreeMap, BTreeSet};

/// The materials that shapes use, converted when the first does.
pub(super) struct Materials<'a> {
    document: &'a Document,
    first: usize,
    textures: Textures,
    used: Vec<Material>,
    /// From the file's index (`None`: glTF's default material) and the texture coordinates that
    /// there are, to the place in `used`, and the emission.
    places: BTreeMap<(Option<usize>, CoordinateSets), (usize, Option<Emission>)>,
}

impl<'a> Materials<'a> {
    /// Materials and textures whose ids start at `first`.
    pub(super) fn new(document: &'a Document, first: FirstIds) -> Self {
        Self {
            document,
            first: first.material,
            textures: Textures::new(first.texture),
            used: Vec::new(),
            places: BTreeMap::new(),
        }
    }

    /// The id and the emission of the material that the primitive `field`, which has the texture
    /// coordinates `sets`, names.
    pub(super) fn use_material(
        &mut self,
        index: Option<usize>,
        sets: CoordinateSets,
        field: &str,
    ) -> Result<(MaterialId, Option<Emission>), InputError> {
        let (place, emission) = match self.places.get(&(index, sets)) {
            Some(known) => *known,
            None => {
                let (material, emission) = match index {
                    Some(index) => self.convert(index, sets, field)?,
                    None => (default_material(), None),
                };
                let place = self.used.len();
                self.used.push(material);
                self.places.insert((index, sets), (place, emission));
                (place, emission)
            }
        };
        let id = u32::try_from(self.first + place).expect("there are fewer than 2³² materials");
        Ok((MaterialId(id), emission))
    }

    /// Indices in the file of the materials that are used.
    pub(super) fn used_indices(&self) -> impl Iterator<Item = usize> + '_ {
        let indices = self.places.keys().filter_map(|(index, _)| *index);
        indices.collect::<BTreeSet<usize>>().into_iter()
    }

    /// The converted materials and their textures, in the order of their ids.
    pub(super) fn into_used(self) -> (Vec<Material>, Textures) {
        (self.used, self.textures)
    }

    fn convert(
        &mut self,
        index: usize,
        sets: CoordinateSets,
        field: &str,
    ) -> Result<(Material, Option<Emission>), InputError> {
        let document = self.document;
        let json = document.get(&document.root.materials, index, "material", || {
            format!("{field}.material")
        })?;
        let name = format!("materials[{index}]");
        let mut layer = dielectric_layer(document, json, &name)?;
        layers::fold(document, json, &name, &mut layer, &mut self.textures)?;
        let bsdf = bsdf(document, json, &name, layer)?;
        let textures = self.textures_of(json, sets, &name)?;
        let mut opacity = opacity(document, json, &name, textures.color)?;
        self.textures.settle_cutoff(&mut opacity);
        let material = Material {
            name: json.name.clone().unwrap_or_else(|| name.clone()),
            bsdf,
            // Light leaves a body of glass through the back of its surface.
            double_sided: json.double_sided || (layer.transmission > 0.0 && !layer.thin),
            textures,
            opacity,
        };
        let mut emission = emission(document, json, &name)?;
        let emitted = Named::of_emission(json).and_then(|named| sets.choose(named));
        if let (Some(emission), Some(named)) = (&mut emission, emitted) {
            let read = texture_use(document, &named, &name, Meaning::Color, &mut self.textures)?;
            emission.texture = read;
        }
        Ok((material, emission.filter(|_| !is_unlit(json))))
    }

    fn textures_of(
        &mut self,
        json: &gltf::json::Material,
        sets: CoordinateSets,
        name: &str,
    ) -> Result<MaterialTextures, InputError> {
        let named = Named::of_material(json);
        let [color, rough, normal] = named.map(|named| named.and_then(|named| sets.choose(named)));
        let document = self.document;
        let mut read = |named: Option<Named>, meaning| {
            let Some(named) = named else { return Ok(None) };
            texture_use(document, &named, name, meaning, &mut self.textures)
        };
        let color = read(color, Meaning::Color)?;
        let metallic_roughness = read(rough, Meaning::Data)?;
        let glossiness = Named::of_specular_glossiness(json).and_then(|named| sets.choose(named));
        let specular_glossiness = read(glossiness, Meaning::Color)?;
        let normal = read(normal, Meaning::Vector)?;
        let scale = json.normal_texture.as_ref().map_or(1.0, |n| n.scale);
        if !scale.is_finite() {
            let field = format!("{name}.normalTexture.scale");
            return Err(document.error(field, format!("is {scale}"), "a finite number"));
        }
        Ok(MaterialTextures {
            color,
            metallic_roughness,
            specular_glossiness,
            normal: normal.map(|texture| NormalMap {
                texture,
                scale: scale.into(),
            }),
        })
    }
}

/// How a material scatters: by metallic and roughness with `layer`, by specular and glossiness, or
/// not at all.
fn bsdf(
    document: &Document,
    json: &gltf::json::Material,
    name: &str,
    layer: DielectricLayer,
) -> Result<Bsdf, InputError> {
    let unit = |value: f32, field: &str| {
        let value = f64::from(value);
        let holds = (0.0..=1.0).contains(&value);
        holds.then_some(value).ok_or_else(|| {
            let field = format!("{name}.{field}");
            document.error(field, format!("is {value}"), "a number from 0 to 1")
        })
    };
    let color = |rgb: [f32; 3], field: &str| -> Result<DVec3, InputError> {
        let [r, g, b] = rgb.map(|channel| unit(channel, field));
        Ok(DVec3::new(r?, g?, b?))
    };
    if let Some(glossy) = specular_glossiness(json) {
        let field = |name: &str| format!("extensions.KHR_materials_pbrSpecularGlossiness.{name}");
        let [r, g, b, _] = glossy.diffuse_factor.0;
        let glossiness = glossy.glossiness_factor.0;
        return Ok(Bsdf::SpecularGlossiness {
            diffuse: color([r, g, b], &field("diffuseFactor"))?,
            specular: color(glossy.specular_factor.0, &field("specularFactor"))?,
            glossiness: unit(glossiness, &field("glossinessFactor"))?,
            textured: glossy.specular_glossiness_texture.is_some(),
        });
    }
    let pbr = &json.pbr_metallic_roughness;
    let [r, g, b, _] = pbr.base_color_factor.0;
    let base_color = color([r, g, b], "pbrMetallicRoughness.baseColorFactor")?;
    if is_unlit(json) {
        return Ok(Bsdf::Unlit { color: base_color });
    }
    Ok(Bsdf::MetallicRoughness {
        base_color,
        metallic: unit(pbr.metallic_factor.0, "pbrMetallicRoughness.metallicFactor")?,
        roughness: unit(
            pbr.roughness_factor.0,
            "pbrMetallicRoughness.roughnessFactor",
        )?,
        layer,
    })
}

/// The ids that the first material and the first texture of a file get.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::scene::load) struct FirstIds {
    pub(in crate::scene::load) material: usize,
    pub(in crate::scene::load) texture: usize,
}

/// The extensions about the dielectric: its index of refraction, its reflectance and what passes
/// through it.
fn dielectric_layer(
    document: &Document,
    json: &gltf::json::Material,
    name: &str,
) -> Result<DielectricLayer, InputError> {
    let mut layer = DielectricLayer::default();
    let Some(extensions) = &json.extensions else {
        return Ok(layer);
    };
    let check = |holds: bool, value: f64, what: &str, expected: &str| {
        let field = || format!("{name}.extensions.{what}");
        holds
            .then_some(value)
            .ok_or_else(|| document.error(field(), format!("is {value}"), expected))
    };
    let unit = |value: f32, what: &str| {
        let value = f64::from(value);
        check(
            (0.0..=1.0).contains(&value),
            value,
            what,
            "a number from 0 to 1",
        )
    };
    if let Some(ior) = &extensions.ior {
        // 0 stands for full reflection.
        let value = f64::from(ior.ior.0);
        let holds = value == 0.0 || (1.0..=1000.0).contains(&value);
        let expected = "an index of refraction from 1 to 1000, or 0";
        layer.ior = check(holds, value, "KHR_materials_ior.ior", expected)?;
    }
    if let Some(specular) = &extensions.specular {
        let what = "KHR_materials_specular.specularFactor";
        layer.specular = unit(specular.specular_factor.0, what)?;
        for channel in 0..3 {
            let value = f64::from(specular.specular_color_factor.0[channel]);
            let what = "KHR_materials_specular.specularColorFactor";
            let holds = value.is_finite() && value >= 0.0;
            layer.specular_color[channel] =
                check(holds, value, what, "a finite number, not negative")?;
        }
    }
    if let Some(transmission) = &extensions.transmission {
        let what = "KHR_materials_transmission.transmissionFactor";
        layer.transmission = unit(transmission.transmission_factor.0, what)?;
        check(
            layer.transmission <= 0.0 || layer.ior >= 1.0,
            layer.ior,
            "KHR_materials_ior.ior",
            "at least 1 beside KHR_materials_transmission",
        )?;
    }
    if let Some(volume) = &extensions.volume {
        layer.thin = volume.thickness_factor.0 <= 0.0;
    }
    Ok(layer)
}

/// What `alphaMode` makes of the base colour's alpha (glTF 2.0, section 3.9.4); `color` is the base
/// colour's texture.
fn opacity(
    document: &Document,
    json: &gltf::json::Material,
    name: &str,
    color: Option<TextureUse>,
) -> Result<Opacity, InputError> {
    let error = |what: &str, value: f32, expected: &str| {
        document.error(format!("{name}.{what}"), format!("is {value}"), expected)
    };
    let cutoff = match json.alpha_mode {
        Checked::Valid(AlphaMode::Mask) => Some(json.alpha_cutoff.map_or(0.5, |cutoff| cutoff.0)),
        Checked::Valid(AlphaMode::Blend) => None,
        Checked::Valid(AlphaMode::Opaque) | Checked::Invalid => return Ok(Opacity::default()),
    };
    let (factor, field) = match specular_glossiness(json) {
        Some(glossy) => (
            glossy.diffuse_factor.0[3],
            "extensions.KHR_materials_pbrSpecularGlossiness.diffuseFactor",
        ),
        None => (
            json.pbr_metallic_roughness.base_color_factor.0[3],
            "pbrMetallicRoughness.baseColorFactor",
        ),
    };
    if !(0.0..=1.0).contains(&factor) {
        return Err(error(field, factor, "a number from 0 to 1"));
    }
    if let Some(cutoff) = cutoff.filter(|c| !(c.is_finite() && *c >= 0.0)) {
        return Err(error(
            "alphaCutoff",
            cutoff,
            "a finite number, not negative",
        ));
    }
    Ok(Opacity {
        factor: decimal(factor),
        texture: color,
        cutoff: cutoff.map(decimal),
    })
}

/// The shortest decimal number that is read as `value`: what a file says, so that 0.9 · 102/255
/// reaches 0.36.
fn decimal(value: f32) -> f64 {
    value.to_string().parse().unwrap_or_else(|_| value.into())
}

/// Emissive factor times strength; the back of a double-sided material emits as well.
fn emission(
    document: &Document,
    json: &gltf::json::Material,
    name: &str,
) -> Result<Option<Emission>, InputError> {
    let strength = json
        .extensions
        .as_ref()
        .and_then(|e| e.emissive_strength.as_ref())
        .map_or(1.0, |s| f64::from(s.emissive_strength.0));
    let factor = DVec3::from_array(json.emissive_factor.0.map(f64::from));
    for (value, what) in [
        (
            strength,
            "extensions.KHR_materials_emissive_strength.emissiveStrength",
        ),
        (factor.min_element(), "emissiveFactor"),
        (factor.max_element(), "emissiveFactor"),
    ] {
        if !(value.is_finite() && value >= 0.0) {
            return Err(document.error(
                format!("{name}.{what}"),
                format!("is {value}"),
                "a finite number, not negative",
            ));
        }
    }
    let radiance = factor * strength;
    Ok((radiance.max_element() > 0.0).then_some(Emission {
        radiance,
        texture: None,
        two_sided: json.double_sided,
    }))
}

/// What glTF 2.0 prescribes for a primitive without material: all properties at their defaults.
fn default_material() -> Material {
    Material {
        name: "glTF's default material".to_owned(),
        bsdf: Bsdf::MetallicRoughness {
            base_color: DVec3::ONE,
            metallic: 1.0,
            roughness: 1.0,
            layer: DielectricLayer::default(),
        },
        double_sided: false,
        textures: MaterialTextures::default(),
        opacity: Opacity::default(),
    }
}
