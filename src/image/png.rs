//! 8-bit sRGB images.

use super::tone::{ToneMapper, srgb_8_bit};
use crate::error::Error;
use crate::output;
use crate::render::Film;
use crate::scene::FilmSize;
use image::{ImageEncoder, codecs::png::PngEncoder};
use std::io;
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
    let bytes = encode(film, display).map_err(|e| Error::write(path, e))?;
    output::write(path, &bytes)
}

/// The film's means as a PNG.
///
/// # Errors
/// The format cannot hold them.
pub fn encode(film: &Film, display: &Display) -> io::Result<Vec<u8>> {
    let pixels = film.pixels.iter();
    encode_rgb(film.size, pixels.map(|p| display.encode(p.mean)))
}

/// 8-bit colours, row by row, as a PNG.
///
/// # Errors
/// The format cannot hold them.
pub fn encode_rgb(size: FilmSize, pixels: impl Iterator<Item = [u8; 3]>) -> io::Result<Vec<u8>> {
    let bytes: Vec<u8> = pixels.flatten().collect();
    let mut png = Vec::new();
    PngEncoder::new(&mut png)
        .write_image(
            &bytes,
            size.width,
            size.height,
            image::ExtendedColorType::Rgb8,
        )
        .map_err(io::Error::other)?;
    Ok(png)
}
