//! OpenEXR: colours, or luminance, of one layer of a file.

mod check;
mod layers;

use super::chromaticities::{Primaries, REC709};
use super::decode::unreadable;
use crate::error::InputError;
use exr::block::UncompressedBlock;
use exr::block::lines::LineRef;
use exr::block::reader::ChunksReader;
use exr::error::UnitResult;
use exr::meta::MetaData;
use exr::meta::attribute::SampleType;
use exr::meta::header::Header;
use exr::prelude::Vec2;
use glam::{DMat3, DVec2, DVec3};
use half::f16;
use image::{DynamicImage, Rgb32FImage, Rgba32FImage};
use layers::{Channels, Layer};
use std::io::Cursor;
use std::path::Path;

/// A file whose windows have been checked, and the layer of it that is wanted.
pub(super) struct Exr<'a> {
    file: &'a Path,
    bytes: &'a [u8],
    layer: Layer,
    /// Of the display window.
    pub(super) size: [u32; 2],
    primaries: Primaries,
}

/// Reads what a file announces, and chooses the layer called `name` in it, or the only one. What is
/// not obvious in that choice goes to `warnings`.
pub(super) fn open<'a>(
    file: &'a Path,
    bytes: &'a [u8],
    name: Option<&str>,
    warnings: &mut Vec<String>,
) -> Result<Exr<'a>, InputError> {
    let meta = MetaData::read_from_buffered(bytes, false).map_err(|e| refusal(file, &e))?;
    check::check(file, bytes, &meta)?;
    let layer = layers::choose(file, &meta, name, warnings)?;
    let shared = &meta.headers[layer.part].shared_attributes;
    let size = shared.display_window.size;
    let side = |side: usize| u32::try_from(side).unwrap_or(u32::MAX);
    let point = |v: Vec2<f32>| DVec2::new(v.x().into(), v.y().into());
    let primaries = shared.chromaticities.map_or(REC709, |c| Primaries {
        red: point(c.red),
        green: point(c.green),
        blue: point(c.blue),
        white: point(c.white),
    });
    Ok(Exr {
        file,
        bytes,
        layer,
        size: [side(size.width()), side(size.height())],
        primaries,
    })
}

/// What the decoder says, in our words where that is common.
fn refusal(file: &Path, error: &exr::error::Error) -> InputError {
    let message = error.to_string();
    if message.contains("subsampling") {
        return InputError::file(
            file,
            "has channels of fewer samples than texels (luminance and subsampled chroma)",
            "channels of one sample per texel, such as R, G and B",
        );
    }
    unreadable(file, &message)
}

impl Exr<'_> {
    /// Decodes the layer into its display window; its sides have been checked. A file's
    /// chromaticities count where `is_color`.
    pub(super) fn decode(
        &self,
        is_color: bool,
        warnings: &mut Vec<String>,
    ) -> Result<DynamicImage, InputError> {
        let reader = exr::block::read(Cursor::new(self.bytes), false);
        let reader = reader.map_err(|e| refusal(self.file, &e))?;
        let part = self.layer.part;
        let wanted = self.layer.channels.indices();
        let [width, height] = self.size.map(|side| side as usize);
        let has_alpha = wanted[3].is_some();
        let stride = if has_alpha { 4 } else { 3 };
        let mut texels = vec![0.0f32; width * height * stride];
        let chunks = reader.filter_chunks(false, |_, tile, block| {
            block.layer == part && tile.level_index == Vec2(0, 0)
        });
        let decoded = chunks.and_then(|chunks| {
            chunks.decompress_parallel(false, |meta, block| {
                // Tables of damaged files point at other blocks.
                if block.index.layer != part || block.index.level != Vec2(0, 0) {
                    return Err(exr::error::Error::Invalid("offset table".into()));
                }
                let header = &meta.headers[part];
                insert(
                    header,
                    &block,
                    &wanted,
                    &mut texels,
                    [width, height, stride],
                )
            })
        });
        decoded.map_err(|e| refusal(self.file, &e))?;
        let map = if is_color { self.map(warnings)? } else { None };
        self.convert(&mut texels, stride, map);
        let [width, height] = self.size;
        let image = if has_alpha {
            Rgba32FImage::from_raw(width, height, texels).map(DynamicImage::ImageRgba32F)
        } else {
            Rgb32FImage::from_raw(width, height, texels).map(DynamicImage::ImageRgb32F)
        };
        Ok(image.expect("as many texels as the window has"))
    }

    /// From the file's colours to linear BT.709; none where they are that.
    fn map(&self, warnings: &mut Vec<String>) -> Result<Option<DMat3>, InputError> {
        let grey = matches!(self.layer.channels, Channels::Luminance { .. });
        if grey || self.primaries.are(&REC709) {
            return Ok(None);
        }
        let map = self.primaries.to_rec709().ok_or_else(|| {
            let problem = "are no triangle with white inside";
            InputError::new(
                self.file,
                "chromaticities",
                problem,
                "those of a colour space",
            )
        })?;
        warnings.push(format!(
            "{}: its chromaticities are converted to those of BT.709",
            self.file.display()
        ));
        Ok(Some(map))
    }

    /// Makes red, green and blue of luminance and chroma, and maps colours.
    fn convert(&self, texels: &mut [f32], stride: usize, map: Option<DMat3>) {
        let chroma = matches!(self.layer.channels, Channels::Chroma { .. });
        let weights = self.primaries.to_xyz().map(|to_xyz| to_xyz.row(1));
        let weights = weights.filter(|w| w.y > 0.0).unwrap_or(DVec3::ONE / 3.0);
        if !chroma && map.is_none() {
            return;
        }
        for texel in texels.chunks_exact_mut(stride) {
            let mut color = DVec3::new(texel[0].into(), texel[1].into(), texel[2].into());
            if chroma {
                color = from_chroma(color, weights);
            }
            let color = map.map_or(color, |map| map * color);
            texel[..3].copy_from_slice(&color.as_vec3().to_array());
        }
    }
}

/// Red, green and blue of (RY, Y, BY) = ((R − Y)/Y, Y, (B − Y)/Y), where Y is `weights`·(R, G, B)
/// (OpenEXR's "Technical Introduction", luminance/chroma images).
fn from_chroma(chroma: DVec3, weights: DVec3) -> DVec3 {
    let y = chroma.y;
    let (r, b) = ((chroma.x + 1.0) * y, (chroma.z + 1.0) * y);
    DVec3::new(r, (y - weights.x * r - weights.z * b) / weights.y, b)
}

/// Puts the channels `wanted` of a block, by their places in the header, into texels of a display
/// window of `width` × `height` texels, `stride` numbers each.
fn insert(
    header: &Header,
    block: &UncompressedBlock,
    wanted: &[Option<usize>; 4],
    texels: &mut [f32],
    [width, height, stride]: [usize; 3],
) -> UnitResult {
    let offset =
        header.own_attributes.layer_position - header.shared_attributes.display_window.position;
    for line in block.lines(&header.channels) {
        let channel = line.location.channel;
        let y = line.location.position.y() as i64 + i64::from(offset.y());
        if !(0..height as i64).contains(&y) {
            continue;
        }
        let row = &mut texels[y as usize * width * stride..][..width * stride];
        let left = line.location.position.x() as i64 + i64::from(offset.x());
        let kind = header.channels.list[channel].sample_type;
        let components = (0..stride).filter(|c| wanted[*c] == Some(channel));
        for component in components {
            for (index, sample) in samples(&line, kind)?.enumerate() {
                let x = left + index as i64;
                if (0..width as i64).contains(&x) {
                    row[x as usize * stride + component] = sample?;
                }
            }
        }
    }
    Ok(())
}

/// The samples of a line as floats.
fn samples<'a>(
    line: &'a LineRef<'a>,
    kind: SampleType,
) -> Result<Box<dyn Iterator<Item = exr::error::Result<f32>> + 'a>, exr::error::Error> {
    Ok(match kind {
        SampleType::F16 => Box::new(line.read_samples::<f16>().map(|s| s.map(f16::to_f32))),
        SampleType::F32 => Box::new(line.read_samples::<f32>()),
        SampleType::U32 => Box::new(line.read_samples::<u32>().map(|s| s.map(|n| n as f32))),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chroma_is_taken_back() {
        let weights = DVec3::new(0.2126, 0.7152, 0.0722);
        let color = DVec3::new(0.9, 0.3, 0.05);
        let y = weights.dot(color);
        let chroma = DVec3::new((color.x - y) / y, y, (color.z - y) / y);
        assert!((from_chroma(chroma, weights) - color).length() < 1e-12);
    }
}
