//! The types of a scene file's materials. Their doc comments are the descriptions in the JSON
//! Schema.

use super::format_shapes::one;
use super::format_textures::TexturesTable;
use crate::scene::material::DielectricLayer;
use crate::scene::metals::Metal;
use crate::scene::rgb::Rgb;
use schemars::JsonSchema;
use serde::Deserialize;
use strum::VariantNames;

/// A material.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct MaterialTable {
    /// How it scatters.
    #[schemars(flatten)]
    pub(super) kind: MaterialKind,
    /// Whether the back of the surface scatters like its front; with false it does not exist and
    /// rays pass through.
    #[serde(default = "yes")]
    pub(super) double_sided: bool,
    /// What varies over the surface: a rectangle's image lies with its upper left corner at v = 1,
    /// a disk shows the largest ellipse of it, a mesh has texture coordinates; spheres have none.
    #[serde(default)]
    pub(super) textures: TexturesTable,
    /// Probability with which the surface stops a ray that meets it, 0 to 1; else the ray passes
    /// straight through. 1 when left out.
    #[serde(default = "one")]
    pub(super) opacity: f64,
    /// Makes a mask of the opacity: where it reaches this number the surface is opaque, elsewhere
    /// it does not exist.
    pub(super) alpha_cutoff: Option<f64>,
}

fn yes() -> bool {
    true
}

/// How a material scatters.
#[derive(Debug, Deserialize, JsonSchema, VariantNames)]
#[strum(serialize_all = "kebab-case")]
#[serde(rename_all = "kebab-case")]
#[schemars(tag = "type")]
pub(super) enum MaterialKind {
    /// Ideal diffuse reflection.
    Lambert(LambertTable),
    /// Ideal specular reflection, the same at every angle: direct lighting is seen in it.
    Mirror(MirrorTable),
    /// Smooth glass, water, …: direct lighting is seen in it and through it. Shadow rays do not
    /// pass.
    Dielectric(DielectricTable),
    /// A rough conductor with GGX microfacets: `reflectance` with Schlick's Fresnel term, or `eta`
    /// and `k`, or `metal`, with Fresnel's equations. Below a width of 1e-4 it is a mirror.
    Conductor(ConductorTable),
    /// A diffuse base under a rough dielectric coat with GGX microfacets and Fresnel's equations.
    Plastic(PlasticTable),
    /// glTF 2.0's metallic-roughness model.
    MetallicRoughness(MetallicRoughnessTable),
    /// A surface that shows its colour whatever lights there are, and lights nothing.
    Unlit(UnlitTable),
}

/// A surface that shows its colour.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct UnlitTable {
    /// Radiance, each channel from 0 to 1.
    pub(super) color: Rgb,
}

/// Ideal diffuse reflection.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct LambertTable {
    /// Albedo, each channel from 0 to 1.
    pub(super) reflectance: Rgb,
}

/// A mirror.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct MirrorTable {
    /// Reflectance, each channel from 0 to 1; 1 when left out.
    #[serde(default = "white")]
    pub(super) reflectance: Rgb,
}

/// A smooth dielectric.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct DielectricTable {
    /// Index of refraction inside over that outside, 0.001 to 1000, of a thin pane from 1; 1.5 when
    /// left out. The inside is behind the surface's front.
    #[serde(default = "glass")]
    pub(super) ior: f64,
    /// Factor on light each time that it passes through the surface, each channel from 0 to 1; 1
    /// when left out.
    #[serde(default = "white")]
    pub(super) transmittance: Rgb,
    /// Whether the surface is a pane of its own: light passes straight through, and reflections
    /// between its sides count.
    #[serde(default)]
    pub(super) thin: bool,
}

/// A rough conductor: `reflectance`, or `eta` and `k`, or `metal`.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ConductorTable {
    /// Reflectance at normal incidence (F0), each channel from 0 to 1.
    pub(super) reflectance: Option<Rgb>,
    /// Index of refraction, real part, above 0 and up to 1000.
    pub(super) eta: Option<Rgb>,
    /// Extinction coefficient, 0 to 1000.
    pub(super) k: Option<Rgb>,
    /// A metal whose `eta` and `k` are known.
    pub(super) metal: Option<Metal>,
    /// GGX width, 0 to 1.
    pub(super) alpha: f64,
}

/// A diffuse base under a rough dielectric coat.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct PlasticTable {
    /// Albedo of the base, each channel from 0 to 1.
    pub(super) reflectance: Rgb,
    /// Index of refraction of the coat, 1 to 1000; 1.5 when left out.
    #[serde(default = "glass")]
    pub(super) ior: f64,
    /// GGX width, 0 to 1; below 1e-4 the coat is a mirror.
    pub(super) alpha: f64,
}

/// glTF 2.0's metallic-roughness model.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct MetallicRoughnessTable {
    /// Base colour, each channel from 0 to 1.
    pub(super) base_color: Rgb,
    /// 0 (dielectric) to 1 (metal).
    pub(super) metallic: f64,
    /// Perceptual roughness, 0 to 1; the GGX width is its square, below 1e-4 a mirror.
    pub(super) roughness: f64,
    /// Index of refraction of the dielectric, 1 to 1000, or 0 for full reflection
    /// (KHR_materials_ior); 1.5 when left out.
    #[serde(default = "glass")]
    pub(super) ior: f64,
    /// Factor on the dielectric's reflectance, 0 to 1 (KHR_materials_specular); 1 when left out.
    #[serde(default = "one")]
    pub(super) specular: f64,
    /// Factor on the dielectric's reflectance at normal incidence, not negative
    /// (KHR_materials_specular); 1 when left out.
    #[serde(default = "white")]
    pub(super) specular_color: Rgb,
    /// The part of what enters the dielectric that passes through, 0 to 1
    /// (KHR_materials_transmission); 0 when left out. Above 0 the surface is smooth.
    #[serde(default)]
    pub(super) transmission: f64,
    /// Whether what passes through is not refracted; true when left out.
    #[serde(default = "yes")]
    pub(super) thin: bool,
}

fn glass() -> f64 {
    DielectricLayer::default().ior
}

fn white() -> Rgb {
    Rgb([1.0; 3])
}
