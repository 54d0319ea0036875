//! 32-bit float images: radiance (`R`, `G`, `B`), the number of samples (`samples`) and the standard error of
//! each mean (`standard_error.R`, …), with what produced them as attributes; AOVs beside them where some are asked for.

use super::write_atomically;
use crate::error::Error;
use crate::render::Film;
use crate::scene::FilmSize;
use ::exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Encoding, FlatSamples, Image, ImageAttributes, Layer,
    LayerAttributes, Text, WritableImage,
};
use rayon::prelude::*;
use std::path::Path;

/// A channel: its name, and its values row by row.
pub type Channel = (String, Vec<f32>);

/// Writes the film with `further` channels and with `attributes` (name, text).
///
/// While a pixel has fewer than two samples standard errors are not known: there stands [`UNKNOWN_ERROR`].
///
/// # Errors
/// The file cannot be written.
pub fn write(
    path: &Path,
    film: &Film,
    further: &[Channel],
    attributes: &[(&str, String)],
) -> Result<(), Error> {
    let channel = |name: &str, value: &(dyn Fn(usize) -> f32 + Sync)| {
        let values: Vec<f32> = (0..film.pixels.len()).into_par_iter().map(value).collect();
        (name.to_owned(), values)
    };
    let variances = film.variances();
    let mut channels = Vec::new();
    for (c, name) in ["R", "G", "B"].into_iter().enumerate() {
        channels.push(channel(name, &|i| film.pixels[i].mean[c] as f32));
        channels.push(channel(&format!("standard_error.{name}"), &|i| {
            variances
                .as_ref()
                .map_or(UNKNOWN_ERROR, |v| v[i][c].sqrt() as f32)
        }));
    }
    channels.push(channel("samples", &|i| film.pixels[i].samples as f32));
    channels.extend(further.iter().cloned());
    write_channels(path, film.size, channels, attributes)
}

/// Writes named channels of 32-bit floats, row by row, with `attributes` (name, text).
///
/// # Errors
/// The file cannot be written.
pub fn write_channels(
    path: &Path,
    size: FilmSize,
    channels: Vec<Channel>,
    attributes: &[(&str, String)],
) -> Result<(), Error> {
    let fail = |e: ::exr::error::Error| Error::Write {
        path: path.to_path_buf(),
        source: std::io::Error::other(e),
    };
    let channels = channels
        .into_iter()
        .map(|(name, values)| AnyChannel::new(name.as_str(), FlatSamples::F32(values)));
    let size = (size.width as usize, size.height as usize);
    let mut layer = LayerAttributes {
        software_name: Some(Text::from(concat!("direkt ", env!("CARGO_PKG_VERSION")))),
        ..LayerAttributes::default()
    };
    for (name, text) in attributes {
        layer.other.insert(
            Text::from(*name),
            AttributeValue::Text(Text::from(text.as_str())),
        );
    }
    let layer = Layer::new(
        size,
        layer,
        Encoding::FAST_LOSSLESS,
        AnyChannels::sort(channels.collect()),
    );
    let mut bytes = std::io::Cursor::new(Vec::new());
    Image::empty(ImageAttributes::with_size(size))
        .with_layer(layer)
        .write()
        .to_buffered(&mut bytes)
        .map_err(fail)?;
    write_atomically(path, &bytes.into_inner())
}

/// Stands in the standard-error channels while a pixel has fewer than two samples.
pub const UNKNOWN_ERROR: f32 = -1.0;
