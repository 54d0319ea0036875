//! Images that vary what a surface does over it.

use super::environment::Interpolation;
use super::ids::TextureId;
use glam::{DAffine2, DVec2, DVec3, DVec4};
use half::f16;
use schemars::JsonSchema;
use serde::Deserialize;

/// An image in linear light, row 0 at the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Texture {
    /// Name of the file or of the glTF image, for messages.
    pub source: String,
    /// Texels per row, 1 to [`MAX_SIDE`](Self::MAX_SIDE).
    pub width: u32,
    /// Rows, 1 to [`MAX_SIDE`](Self::MAX_SIDE).
    pub height: u32,
    /// Its values, row by row; finite and not negative.
    pub texels: Texels,
}

/// The values of an image: red, green, blue and alpha of each texel.
#[derive(Debug, Clone, PartialEq)]
pub enum Texels {
    /// n stands for n/255.
    Bytes(Vec<[u8; 4]>),
    /// Colours decoded to linear light; all 256 levels of an 8-bit sRGB image stay apart.
    Halves(Vec<[f16; 4]>),
}

impl Texture {
    /// Longest side.
    pub const MAX_SIDE: u32 = 16_384;

    /// The texel in column `x` of row `y`.
    pub fn texel(&self, x: u32, y: u32) -> DVec4 {
        let index = y as usize * self.width as usize + x as usize;
        match &self.texels {
            Texels::Bytes(texels) => DVec4::from_array(texels[index].map(|c| f64::from(c) / 255.0)),
            Texels::Halves(texels) => DVec4::from_array(texels[index].map(f64::from)),
        }
    }

    /// Largest red, green or blue.
    pub fn largest(&self) -> f64 {
        self.fold(0.0, |largest, [r, g, b, _]| largest.max(r).max(g).max(b))
    }

    /// Red, green and blue of all its texels, where they are the same.
    pub fn constant(&self) -> Option<DVec3> {
        let same = match &self.texels {
            Texels::Bytes(texels) => texels.iter().all(|t| t[..3] == texels[0][..3]),
            Texels::Halves(texels) => texels.iter().all(|t| t[..3] == texels[0][..3]),
        };
        same.then(|| self.texel(0, 0).truncate())
    }

    /// The least and the largest alpha of its texels.
    pub fn alpha_range(&self) -> [f64; 2] {
        self.range(3)
    }

    /// The least and the largest value of channel `channel`, 0 red to 3 alpha.
    pub fn range(&self, channel: usize) -> [f64; 2] {
        let all = [f64::INFINITY, f64::NEG_INFINITY];
        self.fold(all, |[low, high], texel| {
            [texel[channel].min(low), texel[channel].max(high)]
        })
    }

    fn fold<T>(&self, start: T, add: impl Fn(T, [f64; 4]) -> T) -> T {
        match &self.texels {
            Texels::Bytes(texels) => {
                let texels = texels.iter().map(|t| t.map(|c| f64::from(c) / 255.0));
                texels.fold(start, add)
            }
            Texels::Halves(texels) => texels.iter().map(|t| t.map(f64::from)).fold(start, add),
        }
    }
}

/// What a texture shows outside of [0, 1]: glTF's wrapping modes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Wrap {
    /// The image again.
    #[default]
    Repeat,
    /// The image mirrored, then again.
    Mirror,
    /// The texels of its edge.
    Clamp,
}

/// How a material reads a texture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TextureUse {
    /// The texture.
    pub texture: TextureId,
    /// From a surface's texture coordinates, (0, 0) the upper left corner of the image and (1, 1)
    /// the lower right one, to those at which the image is read (KHR_texture_transform).
    pub transform: DAffine2,
    /// Along u and v.
    pub wrap: [Wrap; 2],
    /// Between texel centres.
    pub interpolation: Interpolation,
    /// Whether it is read with a mesh's second texture coordinates.
    pub second_uvs: bool,
}

/// A normal map: tangent-space normals, `2·rgb − 1`, x along growing u and y along falling v.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NormalMap {
    /// How it is read.
    pub texture: TextureUse,
    /// Factor on x and y.
    pub scale: f64,
}

/// The textures of a material.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MaterialTextures {
    /// Factor on the reflectance or base colour.
    pub color: Option<TextureUse>,
    /// Factors on roughness (green) and metallic (blue).
    pub metallic_roughness: Option<TextureUse>,
    /// Factors on reflectance at normal incidence (red, green, blue) and glossiness (alpha).
    pub specular_glossiness: Option<TextureUse>,
    /// Shading normals.
    pub normal: Option<NormalMap>,
}

impl MaterialTextures {
    /// Whether there is any.
    pub fn any(&self) -> bool {
        self.uses().next().is_some()
    }

    /// All of them.
    pub fn uses(&self) -> impl Iterator<Item = TextureUse> {
        let normal = self.normal.map(|n| n.texture);
        let [color, metallic, specular] = [
            self.color,
            self.metallic_roughness,
            self.specular_glossiness,
        ];
        [color, metallic, specular, normal].into_iter().flatten()
    }
}

/// What textures say at one point of a surface: factors on what the material says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TexturedFactors {
    /// On reflectance or base colour.
    pub color: DVec3,
    /// On metallic.
    pub metallic: f64,
    /// On roughness.
    pub roughness: f64,
    /// On reflectance at normal incidence.
    pub specular: DVec3,
    /// On glossiness.
    pub glossiness: f64,
}

impl Default for TexturedFactors {
    fn default() -> Self {
        Self {
            color: DVec3::ONE,
            metallic: 1.0,
            roughness: 1.0,
            specular: DVec3::ONE,
            glossiness: 1.0,
        }
    }
}

/// The normal that a texel of a normal map stands for, in tangent space; not normalised.
pub fn tangent_normal(texel: DVec4, scale: f64) -> DVec3 {
    let n = 2.0 * texel.truncate() - DVec3::ONE;
    DVec3::new(n.x * scale, n.y * scale, n.z)
}

/// Texture coordinates of a rectangle's point `st`: its `u` runs along the image's rows, its `v`
/// up.
pub fn rectangle_uv(st: DVec2) -> DVec2 {
    DVec2::new(st.x, 1.0 - st.y)
}

/// Texture coordinates of the point `st` where those of a, a + u and a + v are `uvs`.
pub fn interpolate_uv(uvs: &[DVec2; 3], st: DVec2) -> DVec2 {
    uvs[0] + st.x * (uvs[1] - uvs[0]) + st.y * (uvs[2] - uvs[0])
}

/// Texture coordinates of a disk's point `st`, s² + t² ≤ 1: the image's largest ellipse.
pub fn disk_uv(st: DVec2) -> DVec2 {
    DVec2::new(0.5 + 0.5 * st.x, 0.5 - 0.5 * st.y)
}
