//! The types of a material's textures. Their doc comments are the descriptions in the JSON Schema.

use crate::scene::Wrap;
use crate::scene::environment::Interpolation;
use schemars::JsonSchema;
use serde::Deserialize;

/// The textures of a material.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct TexturesTable {
    /// Factor on `reflectance` or `base_color`.
    pub(super) color: Option<TextureTable>,
    /// Factors on `roughness` (green) and `metallic` (blue).
    pub(super) metallic_roughness: Option<TextureTable>,
    /// A normal map: tangent-space normals, 2·rgb − 1, x along growing u and y up in the image.
    pub(super) normal: Option<TextureTable>,
    /// Factor on x and y of the normal map; 1 when left out.
    pub(super) normal_scale: Option<f64>,
    /// Factor on `opacity`: the image's alpha channel, or of an image with one channel that one, as
    /// it is.
    pub(super) opacity: Option<TextureTable>,
}

/// A texture.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct TextureTable {
    /// An image in .png, .jpg, .hdr, .exr, .bmp, .tga, .tif or .webp. Of a `color` 8 and 16 bits
    /// are sRGB, floats linear.
    pub(super) file: String,
    /// The layer of an OpenEXR file, such as `ViewLayer.Combined`; the colours without a layer, or
    /// those of the only one, when left out.
    pub(super) layer: Option<String>,
    /// What lies outside of the image, along u and v.
    #[serde(default)]
    pub(super) wrap: [Wrap; 2],
    /// What lies between texel centres.
    #[serde(default = "linear")]
    pub(super) interpolation: Interpolation,
    /// How often the image repeats over the surface, along u and v.
    #[serde(default = "once")]
    pub(super) repeat: [f64; 2],
}

fn linear() -> Interpolation {
    Interpolation::Linear
}

fn once() -> [f64; 2] {
    [1.0; 2]
}
