//! Environment maps: Radiance HDR and OpenEXR.

use super::{exr, files};
use crate::error::InputError;
use crate::scene::EnvironmentMap;
use crate::scene::light::Interpolation;
use image::{ImageFormat, ImageReader, Limits};
use std::io::Cursor;
use std::path::Path;

/// Longest side of a map.
const MAX_SIDE: u32 = 32_768;
/// Most texels per byte of a file, so that a short file cannot ask for memory: zlib packs 1032 to 1, and a texel is three
/// numbers of two bytes.
const MAX_TEXELS_PER_BYTE: u64 = 172;

/// Reads a latitude-longitude map. Texels that are negative or not finite become black; `warnings` gets their number.
pub(super) fn read_environment(
    path: &Path,
    warnings: &mut Vec<String>,
) -> Result<EnvironmentMap, InputError> {
    let format = match files::extension(path).as_str() {
        "hdr" => ImageFormat::Hdr,
        "exr" => ImageFormat::OpenExr,
        other => {
            return Err(InputError::file(
                path,
                format!("`.{other}` is not a format of environment maps"),
                "a latitude-longitude map in .hdr or .exr",
            ));
        }
    };
    let bytes = files::read(path)?;
    let failed = |e: image::ImageError| unreadable(path, &e.to_string());
    let reader = || ImageReader::with_format(Cursor::new(&bytes), format);
    if format == ImageFormat::OpenExr {
        exr::check(path, &bytes)?;
    }
    let (width, height) = reader().into_dimensions().map_err(failed)?;
    if width == 0 || height == 0 || width > MAX_SIDE || height > MAX_SIDE {
        return Err(InputError::file(
            path,
            format!("is an image of {width} x {height} texels"),
            format!("1 to {MAX_SIDE} texels per side"),
        ));
    }
    if u64::from(width) * u64::from(height) > MAX_TEXELS_PER_BYTE * bytes.len() as u64 {
        return Err(InputError::file(
            path,
            format!(
                "is truncated: {width} x {height} texels in {} bytes",
                bytes.len()
            ),
            "the whole image",
        ));
    }
    let mut decoder = reader();
    decoder.limits(Limits::no_limits());
    let image = decoder.decode().map_err(failed)?.into_rgb32f();
    let mut texels: Vec<[f32; 3]> = image.pixels().map(|p| p.0).collect();
    let mut bad = 0usize;
    for texel in &mut texels {
        if texel.iter().any(|c| !c.is_finite() || *c < 0.0) {
            bad += 1;
            *texel = texel.map(|c| if c.is_finite() { c.max(0.0) } else { 0.0 });
        }
    }
    if bad > 0 {
        warnings.push(format!(
            "{}: {bad} {} negative or not finite; such channels are taken as 0",
            path.display(),
            if bad == 1 { "texel is" } else { "texels are" }
        ));
    }
    Ok(EnvironmentMap {
        source: path.display().to_string(),
        width,
        height,
        texels,
        interpolation: Interpolation::default(),
    })
}

/// The error for what a decoder says.
pub(super) fn unreadable(path: &Path, message: &str) -> InputError {
    let truncated = ["failed to fill whole buffer", "reference to missing bytes"];
    if truncated.iter().any(|t| message.contains(t)) {
        return InputError::file(path, "is truncated", "the whole image");
    }
    InputError::file(path, format!("is not a readable image: {message}"), "")
}
