//! Opacity: how likely a surface stops a ray.

use super::texture::TextureUse;

/// The opacity α of a surface. A ray that meets it is stopped with probability α, else it passes
/// straight through as if nothing were there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Opacity {
    /// In [0, 1].
    pub factor: f64,
    /// The alpha channel of a texture, a factor as well.
    pub texture: Option<TextureUse>,
    /// Where the product reaches it α is 1, elsewhere 0 (glTF 2.0, section 3.9.4, `MASK`). Finite
    /// and not negative.
    pub cutoff: Option<f64>,
}

impl Default for Opacity {
    fn default() -> Self {
        Self::constant(1.0)
    }
}

impl Opacity {
    /// The same everywhere.
    pub fn constant(factor: f64) -> Self {
        Self {
            factor,
            texture: None,
            cutoff: None,
        }
    }

    /// α where the texture is `texel`.
    pub fn at(&self, texel: f64) -> f64 {
        let product = self.factor * texel;
        match self.cutoff {
            // As the GPU compares them: what a file says in 8 bits or in f32 reaches a cutoff that
            // it is meant to be.
            Some(cutoff) if product as f32 >= cutoff as f32 => 1.0,
            Some(_) => 0.0,
            None => product,
        }
    }

    /// The same opacity without what makes no difference; the texture's values lie between
    /// `texels`. Between texels it is interpolated, and α grows with it.
    #[must_use]
    pub fn folded(self, texels: [f64; 2]) -> Self {
        let [least, most] = texels.map(|texel| self.at(texel));
        if least >= most {
            Self::constant(least)
        } else {
            self
        }
    }

    /// α on a surface without texture coordinates, where textures are not read.
    pub fn untextured(&self) -> f64 {
        self.at(1.0)
    }

    /// Whether no ray meets the surface.
    pub fn is_never_met(&self) -> bool {
        self.texture.is_none() && self.untextured() <= 0.0
    }
}
