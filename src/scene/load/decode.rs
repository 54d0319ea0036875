//! Image files of any format, decoded to their numbers. What a file holds counts, not what its name
//! says.

use super::{exr, radiance};
use crate::error::InputError;
use image::{DynamicImage, ImageFormat, ImageReader, Limits};
use std::io::Cursor;
use std::path::Path;

/// An image that is wanted.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wanted<'a> {
    /// Its name in messages; the extension decides where the content does not.
    pub(super) file: &'a Path,
    /// Whether its numbers are colours: of data the primaries do not count.
    pub(super) is_color: bool,
    /// The layer of an OpenEXR file.
    pub(super) layer: Option<&'a str>,
    /// Longest side in texels.
    pub(super) max_side: u32,
    /// Whether the image holds radiances: then it is a Radiance picture or an OpenEXR file.
    pub(super) is_radiance: bool,
}

/// What is expected where nothing else is wanted.
const FORMATS: &str = "a PNG, JPEG, Radiance HDR, OpenEXR, BMP, TGA, TIFF or WebP image";
const RADIANCE_FORMATS: &str = "a latitude-longitude map in .hdr or .exr";

/// Most texels per byte of a file of radiances, so that a short file cannot ask for memory: zlib
/// packs 1032 to 1, and a texel is at least one number of two bytes.
const MAX_TEXELS_PER_BYTE: u64 = 516;
/// The same of Radiance's older runs: a whole scanline of up to 2¹⁵ texels in twelve bytes.
const MAX_TEXELS_PER_BYTE_IN_RUNS: u64 = 2731;

/// Decodes the image that `bytes` hold. Its sides are checked before memory is taken for it.
pub(super) fn decode(
    wanted: &Wanted<'_>,
    bytes: &[u8],
    warnings: &mut Vec<String>,
) -> Result<DynamicImage, InputError> {
    let file = wanted.file;
    let format = format(wanted, bytes)?;
    if wanted.layer.is_some() && format != ImageFormat::OpenExr {
        let problem = "has no layers: it is no OpenEXR file";
        return Err(InputError::file(file, problem, "no `layer`"));
    }
    match format {
        ImageFormat::Hdr => {
            let header = radiance::header(file, bytes, warnings)?;
            let size = [header.width, header.height];
            check_size(wanted, size, bytes.len(), MAX_TEXELS_PER_BYTE_IN_RUNS)?;
            radiance::texels(file, bytes, &header).map(DynamicImage::ImageRgb32F)
        }
        ImageFormat::OpenExr => {
            let exr = exr::open(file, bytes, wanted.layer, warnings)?;
            check_size(wanted, exr.size, bytes.len(), MAX_TEXELS_PER_BYTE)?;
            exr.decode(wanted.is_color, warnings)
        }
        _ => {
            let failed = |e: image::ImageError| unreadable(file, &e.to_string());
            let reader = || ImageReader::with_format(Cursor::new(bytes), format);
            let (width, height) = reader().into_dimensions().map_err(failed)?;
            check_sides(wanted, [width, height])?;
            let mut decoder = reader();
            decoder.limits(Limits::no_limits());
            decoder.decode().map_err(failed)
        }
    }
}

fn format(wanted: &Wanted<'_>, bytes: &[u8]) -> Result<ImageFormat, InputError> {
    let file = wanted.file;
    let extension = super::files::extension(file);
    let is_tga = extension == "tga";
    let found = if radiance::is_radiance(bytes) {
        Some(ImageFormat::Hdr)
    } else {
        let by_name = is_tga.then_some(ImageFormat::Tga);
        image::guess_format(bytes).ok().or(by_name)
    };
    let expected = if wanted.is_radiance {
        RADIANCE_FORMATS
    } else {
        FORMATS
    };
    // A file of radiances is read by the format of its name, which knows what is wrong with it.
    let found = found.or(match extension.as_str() {
        "hdr" if wanted.is_radiance => Some(ImageFormat::Hdr),
        "exr" if wanted.is_radiance => Some(ImageFormat::OpenExr),
        _ => None,
    });
    match found {
        Some(format @ (ImageFormat::Hdr | ImageFormat::OpenExr)) => Ok(format),
        Some(
            format @ (ImageFormat::Png
            | ImageFormat::Jpeg
            | ImageFormat::Bmp
            | ImageFormat::Tga
            | ImageFormat::Tiff
            | ImageFormat::WebP),
        ) if !wanted.is_radiance => Ok(format),
        Some(other) => {
            let problem = format!("is of the format {other:?}");
            Err(InputError::file(file, problem, expected))
        }
        None => Err(InputError::file(
            file,
            "is not an image of a known format",
            expected,
        )),
    }
}

fn check_sides(wanted: &Wanted<'_>, [width, height]: [u32; 2]) -> Result<(), InputError> {
    let most = wanted.max_side;
    if width > 0 && height > 0 && width <= most && height <= most {
        return Ok(());
    }
    Err(InputError::file(
        wanted.file,
        format!("is an image of {width} x {height} texels"),
        format!("1 to {most} texels per side"),
    ))
}

/// Checks sides, and that a file of `length` bytes can hold that many texels.
fn check_size(
    wanted: &Wanted<'_>,
    [width, height]: [u32; 2],
    length: usize,
    texels_per_byte: u64,
) -> Result<(), InputError> {
    check_sides(wanted, [width, height])?;
    if u64::from(width) * u64::from(height) <= texels_per_byte * length as u64 {
        return Ok(());
    }
    Err(InputError::file(
        wanted.file,
        format!("is truncated: {width} x {height} texels in {length} bytes"),
        "the whole image",
    ))
}

/// The error for what a decoder says.
pub(super) fn unreadable(file: &Path, message: &str) -> InputError {
    let truncated = [
        "failed to fill whole buffer",
        "reference to missing bytes",
        "unexpected end of file",
        "unexpected EOF",
    ];
    let lower = message.to_lowercase();
    if truncated.iter().any(|t| lower.contains(&t.to_lowercase())) {
        return InputError::file(file, "is truncated", "the whole image");
    }
    InputError::file(file, format!("is not a readable image: {message}"), "")
}
