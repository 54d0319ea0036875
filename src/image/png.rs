//! 8-bit sRGB images.

use super::tone::{ToneMapper, srgb_8_bit};
use super::write_atomically;
use crate::error::Error;
use crate::render::Film;
use image::{ImageEncoder, codecs::png::PngEncoder};
use std::path::Path;

/// How a film becomes display values.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Display {
    /// Stops; radiance is multiplied by 2^exposure.
    pub exposure: f64,
    /// The tone mapper.
    pub tone: ToneMapper,
}

impl Display {
    /// Linear display values, in [0, 1], of linear radiance.
    pub fn linear(&self, radiance: [f64; 3]) -> [f64; 3] {
        let factor = self.exposure.exp2();
        self.tone.map(radiance.map(|x| x * factor))
    }

    /// 8-bit sRGB of linear radiance.
    pub fn encode(&self, radiance: [f64; 3]) -> [u8; 3] {
        self.linear(radiance).map(srgb_8_bit)
    }
}

/// Writes the film's means as a PNG.
///
/// # Errors
/// The file cannot be written.
pub fn write(path: &Path, film: &Film, display: &Display) -> Result<(), Error> {
    let bytes: Vec<u8> = film
        .pixels
        .iter()
        .flat_map(|p| display.encode(p.mean))
        .collect();
    let mut png = Vec::new();
    PngEncoder::new(&mut png)
        .write_image(
            &bytes,
            film.size.width,
            film.size.height,
            image::ExtendedColorType::Rgb8,
        )
        .map_err(|e| Error::Write {
            path: path.to_path_buf(),
            source: std::io::Error::other(e),
        })?;
    write_atomically(path, &png)
}
