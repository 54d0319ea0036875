//! Images of signed values: differences and z-scores.

use super::{exr, png};
use crate::scene::FilmSize;
use std::io;
use std::path::Path;

/// Signed values, three per pixel, row by row, as the name `path` says: an EXR holds them as they
/// are; a PNG shows the value of largest size in each pixel, from blue at −`scale` over white at 0
/// to red at `scale`.
///
/// # Errors
/// The format cannot hold them.
pub fn encode(
    path: &Path,
    size: FilmSize,
    values: &[[f64; 3]],
    scale: f64,
    attributes: &[(&str, String)],
) -> io::Result<Vec<u8>> {
    if super::extension(path) == "exr" {
        let channel = |c: usize| -> Vec<f32> { values.iter().map(|v| v[c] as f32).collect() };
        let channels = ["R", "G", "B"].iter().enumerate();
        let channels = channels.map(|(c, name)| ((*name).to_owned(), channel(c)));
        return exr::encode_channels(size, channels.collect(), attributes);
    }
    let pixels = values.iter().map(|v| colour(largest(*v) / scale));
    png::encode_rgb(size, pixels)
}

/// The value of largest size.
fn largest(v: [f64; 3]) -> f64 {
    v.into_iter()
        .fold(0.0, |a, b| if b.abs() > a.abs() { b } else { a })
}

/// Blue at −1, white at 0, red at 1; 8-bit sRGB.
pub fn colour(x: f64) -> [u8; 3] {
    const BLUE: [f64; 3] = [5.0, 48.0, 97.0];
    const RED: [f64; 3] = [178.0, 24.0, 43.0];
    let end = if x < 0.0 { BLUE } else { RED };
    let part = x.abs().min(1.0);
    end.map(|e| (255.0 + (e - 255.0) * part).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_is_white_and_the_ends_are_blue_and_red() {
        assert_eq!(colour(0.0), [255; 3]);
        assert_eq!(colour(-7.0), [5, 48, 97]);
        assert_eq!(colour(1.0), [178, 24, 43]);
        assert_eq!(colour(0.5)[0], 217);
    }

    #[test]
    fn the_largest_value_keeps_its_sign() {
        assert!((largest([0.5, -2.0, 1.0]) + 2.0).abs() < 1e-15);
    }
}
