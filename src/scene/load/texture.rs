//! Images that materials read.

use super::cutoff::{self, Alpha};
use super::decode::{self, Wanted};
use crate::error::InputError;
use crate::scene::{Opacity, Texels, Texture, TextureId};
use glam::DVec3;
use half::f16;
use image::{ColorType, DynamicImage};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// What the numbers of an image mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Meaning {
    /// A colour: 8 and 16 bits are encoded as sRGB, floats are linear.
    Color,
    /// Numbers as they are.
    Data,
    /// The same, of three components.
    Vector,
    /// An opacity: the alpha channel, or the only one.
    Opacity,
}

/// Most that an f16 holds.
const MAX_HALF: f32 = 65_504.0;

/// An image by its file, its layer and its meaning.
type Key = (PathBuf, Option<String>, Meaning);

/// The textures of a scene, each image once for each of its meanings.
pub(super) struct Textures {
    first: usize,
    list: Vec<Texture>,
    /// The alphas of images whose channels have more than 8 bits.
    fine_alphas: HashMap<TextureId, Vec<f32>>,
    known: HashMap<Key, TextureId>,
    warnings: Vec<String>,
}

impl Textures {
    /// Textures whose ids start at `first`.
    pub(super) fn new(first: usize) -> Self {
        Self {
            first,
            list: Vec::new(),
            fine_alphas: HashMap::new(),
            known: HashMap::new(),
            warnings: Vec::new(),
        }
    }

    /// The texture called `name`, of an OpenEXR file its layer `layer`, made of what `bytes`
    /// returns unless it is known.
    pub(super) fn get(
        &mut self,
        name: &Path,
        layer: Option<&str>,
        meaning: Meaning,
        bytes: impl FnOnce() -> Result<Vec<u8>, InputError>,
    ) -> Result<TextureId, InputError> {
        let key = |meaning| (name.to_path_buf(), layer.map(str::to_owned), meaning);
        if let Some(&id) = self.known.get(&key(meaning)) {
            return Ok(id);
        }
        let Decoded {
            texture,
            fine_alphas,
            meaning: decoded,
        } = decode(name, layer, &bytes()?, meaning, &mut self.warnings)?;
        // An image that is read as a colour and as an opacity is held once.
        let decoded = key(decoded);
        let id = if let Some(&id) = self.known.get(&decoded) {
            id
        } else {
            let id = u32::try_from(self.first + self.list.len()).expect("fewer than 2³² textures");
            self.list.push(texture);
            self.known.insert(decoded, TextureId(id));
            if let Some(alphas) = fine_alphas {
                self.fine_alphas.insert(TextureId(id), alphas);
            }
            TextureId(id)
        };
        self.known.insert(key(meaning), id);
        Ok(id)
    }

    /// Moves the cutoff of `opacity`, whose texture is one of these, to where it divides the
    /// texture's values as it divides the image's.
    pub(super) fn settle_cutoff(&mut self, opacity: &mut Opacity) {
        let Some(used) = opacity.texture else { return };
        let texture = &mut self.list[used.texture.index() - self.first];
        let Texels::Halves(texels) = &mut texture.texels else {
            return;
        };
        let fine = self.fine_alphas.get(&used.texture);
        let alpha = |index: usize, held: f16| match fine {
            Some(alphas) => Alpha {
                exact: alphas[index].into(),
                held,
            },
            None => Alpha::of_byte(held),
        };
        let alphas = texels.iter().enumerate().map(|(i, t)| alpha(i, t[3]));
        if let Some(divided) = cutoff::settle(opacity, alphas) {
            for (index, texel) in texels.iter_mut().enumerate() {
                texel[3] = divided.apart(alpha(index, texel[3]));
            }
        }
    }

    /// Red, green and blue of the texture `id`, which is one of these, where they are the same
    /// everywhere.
    pub(super) fn constant(&self, id: TextureId) -> Option<DVec3> {
        self.list[id.index() - self.first].constant()
    }

    /// The least and the largest alpha of the texture `id`, which is one of these.
    pub(super) fn alpha_range(&self, id: TextureId) -> [f64; 2] {
        self.list[id.index() - self.first].alpha_range()
    }

    /// Adds what is to be said, once.
    pub(super) fn warn(&mut self, warning: String) {
        if !self.warnings.contains(&warning) {
            self.warnings.push(warning);
        }
    }

    /// All of them in the order of their ids, and what is to be said of them.
    pub(super) fn into_parts(self) -> (Vec<Texture>, Vec<String>) {
        (self.list, self.warnings)
    }
}

/// What an image was decoded into.
struct Decoded {
    texture: Texture,
    /// The alphas of an image whose channels have more than 8 bits.
    fine_alphas: Option<Vec<f32>>,
    /// As what: an opacity with an alpha channel is that of a colour.
    meaning: Meaning,
}

/// Decodes an image; `name` is for messages.
fn decode(
    name: &Path,
    layer: Option<&str>,
    bytes: &[u8],
    meaning: Meaning,
    warnings: &mut Vec<String>,
) -> Result<Decoded, InputError> {
    let wanted = Wanted {
        file: name,
        is_color: meaning == Meaning::Color,
        layer,
        max_side: Texture::MAX_SIDE,
        is_radiance: false,
    };
    let image = decode::decode(&wanted, bytes, warnings)?;
    let meaning = match meaning {
        Meaning::Opacity if image.color().has_alpha() => Meaning::Color,
        other => other,
    };
    check_channels(name, &image, meaning, warnings)?;
    let fine_alphas = fine_alphas(&image, meaning);
    let texture = Texture {
        source: name.display().to_string(),
        width: image.width(),
        height: image.height(),
        texels: texels(name, image, meaning, warnings),
    };
    Ok(Decoded {
        texture,
        fine_alphas,
        meaning,
    })
}

/// The alphas of an image whose channels have more than 8 bits.
fn fine_alphas(image: &DynamicImage, meaning: Meaning) -> Option<Vec<f32>> {
    let word = |n: u16| f32::from(n) / 65_535.0;
    match (image, meaning) {
        (DynamicImage::ImageLuma16(words), Meaning::Opacity) => {
            Some(words.pixels().map(|p| word(p.0[0])).collect())
        }
        (DynamicImage::ImageLumaA16(words), Meaning::Color) => {
            Some(words.pixels().map(|p| word(p.0[1])).collect())
        }
        (DynamicImage::ImageRgba16(words), Meaning::Color) => {
            Some(words.pixels().map(|p| word(p.0[3])).collect())
        }
        (DynamicImage::ImageRgba32F(floats), Meaning::Color) => {
            let alpha = |a: f32| if a > 0.0 { a.min(1.0) } else { 0.0 };
            Some(floats.pixels().map(|p| alpha(p.0[3])).collect())
        }
        _ => None,
    }
}

/// Checks that an image has the channels that its meaning asks for. Grey stands for equal red,
/// green and blue.
fn check_channels(
    name: &Path,
    image: &DynamicImage,
    meaning: Meaning,
    warnings: &mut Vec<String>,
) -> Result<(), InputError> {
    let channels = image.color().channel_count();
    if meaning == Meaning::Opacity && channels != 1 {
        let problem = format!("has {channels} channels and no alpha");
        let expected = "an alpha channel, or one channel alone";
        return Err(InputError::file(name, problem, expected));
    }
    if meaning == Meaning::Vector && channels < 3 {
        warnings.push(format!(
            "{}: a normal map of one channel has equal x, y and z; is it a height map?",
            name.display()
        ));
    }
    Ok(())
}

fn texels(
    name: &Path,
    image: DynamicImage,
    meaning: Meaning,
    warnings: &mut Vec<String>,
) -> Texels {
    let encoded = meaning == Meaning::Color;
    if meaning == Meaning::Opacity {
        // Of one channel, which becomes the alpha of white.
        let words = image.into_luma16();
        let texel = |p: &image::Luma<u16>| {
            let alpha = f16::from_f64(f64::from(p.0[0]) / 65_535.0);
            [f16::ONE, f16::ONE, f16::ONE, alpha]
        };
        return Texels::Halves(words.pixels().map(texel).collect());
    }
    match image.color() {
        ColorType::L8 | ColorType::La8 | ColorType::Rgb8 | ColorType::Rgba8 => {
            let bytes = image.into_rgba8();
            let bytes = bytes.pixels().map(|p| p.0);
            if !encoded {
                return Texels::Bytes(bytes.collect());
            }
            let linear =
                std::array::from_fn::<_, 256, _>(|n| f16::from_f64(srgb(n as f64 / 255.0)));
            Texels::Halves(
                bytes
                    .map(|[r, g, b, a]| {
                        let [r, g, b] = [r, g, b].map(|c| linear[usize::from(c)]);
                        [r, g, b, f16::from_f64(f64::from(a) / 255.0)]
                    })
                    .collect(),
            )
        }
        ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16 => {
            let words = image.into_rgba16();
            let decode = |n: u16| {
                let value = f64::from(n) / 65_535.0;
                f16::from_f64(if encoded { srgb(value) } else { value })
            };
            let texel = |[r, g, b, a]: [u16; 4]| {
                let alpha = f16::from_f64(f64::from(a) / 65_535.0);
                [decode(r), decode(g), decode(b), alpha]
            };
            Texels::Halves(words.pixels().map(|p| texel(p.0)).collect())
        }
        _ => {
            let mut bad = 0usize;
            let floats = image.into_rgba32f();
            let texel = |p: [f32; 4]| {
                bad += usize::from(p.iter().any(|c| !(0.0..=MAX_HALF).contains(c)));
                let [r, g, b, a] = p;
                [r, g, b, a.min(1.0)]
                    .map(|c| f16::from_f32(if c > 0.0 { c.min(MAX_HALF) } else { 0.0 }))
            };
            let halves = floats.pixels().map(|p| p.0).map(texel).collect();
            if bad > 0 {
                warnings.push(format!(
                    "{}: {bad} {} not from 0 to 65504; such channels are taken as the nearest of these",
                    name.display(),
                    if bad == 1 { "texel is" } else { "texels are" }
                ));
            }
            Texels::Halves(halves)
        }
    }
}

/// Linear value of an encoded one (IEC 61966-2-1).
pub(super) fn srgb(encoded: f64) -> f64 {
    if encoded <= 0.040_45 {
        encoded / 12.92
    } else {
        ((encoded + 0.055) / 1.055).powf(2.4)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_is_decoded() {
        for (encoded, linear) in [(0.0, 0.0), (1.0, 1.0), (0.5, 0.214_041_140_482)] {
            assert!((srgb(encoded) - linear).abs() < 1e-9, "{encoded}");
        }
        let below = srgb(0.040_45);
        assert!((below - srgb(0.040_450_001)).abs() < 1e-7, "{below}");
    }

    #[test]
    fn levels_of_8_bits_stay_apart() {
        let level = |n: u32| f16::from_f64(srgb(f64::from(n) / 255.0));
        assert!((0..255).all(|n| level(n) < level(n + 1)));
    }
}
