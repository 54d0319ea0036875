//! 32-bit float images: radiance (`R`, `G`, `B`), and in layers of their own the number of samples
//! (`samples.X`), the standard error of each mean (`standard_error.R`, …) and AOVs where some are
//! asked for, with what produced them as attributes.
//!
//! A layer is what stands before the last dot of channels' names (OpenEXR's convention); what has
//! no dot is the layer of colours. Readers of colours, such as Mitsuba's, refuse one that holds
//! anything else.

use crate::error::Error;
use crate::output;
use crate::render::{Film, ImageError, StatedError};
use crate::scene::FilmSize;
use ::exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Encoding, FlatSamples, Image, ImageAttributes, Layer,
    LayerAttributes, Text, WritableImage,
};
use rayon::prelude::*;
use std::io;
use std::path::Path;

/// A channel: its name, and its values row by row.
pub type Channel = (String, Vec<f32>);

/// Stands in the standard-error channels while a pixel has fewer than two samples.
pub const UNKNOWN_ERROR: f32 = -1.0;

/// Writes the film with `further` channels and with `attributes` (name, text); see [`encode`].
///
/// # Errors
/// The file cannot be written.
pub fn write(
    path: &Path,
    film: &Film,
    further: &[Channel],
    attributes: &[(&str, String)],
) -> Result<(), Error> {
    let bytes = encode(film, further, attributes).map_err(|e| Error::write(path, e))?;
    output::write(path, &bytes)
}

/// The film with its standard errors, its numbers of samples, `further` channels and `attributes`
/// (name, text), to which the error is added that the image states, as an EXR.
///
/// While a pixel has fewer than two samples standard errors are not known: there stands
/// [`UNKNOWN_ERROR`].
///
/// # Errors
/// The format cannot hold it.
pub fn encode(
    film: &Film,
    further: &[Channel],
    attributes: &[(&str, String)],
) -> io::Result<Vec<u8>> {
    let variances = film.variances();
    let mut channels = radiance(film);
    for (c, name) in RGB.into_iter().enumerate() {
        let error = |i: usize| {
            let variances = variances.as_ref();
            variances.map_or(UNKNOWN_ERROR, |v| single(v[i][c].sqrt()))
        };
        channels.push(channel(film, &format!("standard_error.{name}"), error));
    }
    let samples = |i: usize| film.pixels[i].samples as f32;
    channels.push(channel(film, "samples.X", samples));
    channels.extend(further.iter().cloned());
    let mut attributes = attributes.to_vec();
    for (name, stated) in film.error().into_iter().flat_map(error_attributes) {
        attributes.push((name, stated));
    }
    encode_channels(film.size, channels, &attributes)
}

/// The error that the image states, with its interval of 95 %, and why it cannot be told where that
/// is so.
fn error_attributes(error: ImageError) -> Vec<(&'static str, String)> {
    let metrics = [
        (["nmse", "nmse_doubt"], error.nmse),
        (["rel_mse", "rel_mse_doubt"], error.rel_mse),
    ];
    let of_metric = |([name, name_of_doubt], e): ([&'static str; 2], StatedError)| {
        let doubt = e.doubt.map(|doubt| (name_of_doubt, doubt.to_string()));
        let stated = format!("{:e} [{:e}, {:e}]", e.value, e.low, e.high);
        std::iter::once((name, stated)).chain(doubt)
    };
    metrics.into_iter().flat_map(of_metric).collect()
}

/// The film's radiance alone with `attributes` (name, text), as an EXR: for readers that take no
/// further layers.
///
/// # Errors
/// The format cannot hold it.
pub fn encode_plain(film: &Film, attributes: &[(&str, String)]) -> io::Result<Vec<u8>> {
    encode_channels(film.size, radiance(film), attributes)
}

const RGB: [&str; 3] = ["R", "G", "B"];

/// `x` in 32 bits. What is beyond their range, which a film in f64 may hold, is their largest
/// number: an image has no infinity.
pub fn single(x: f64) -> f32 {
    (x as f32).clamp(-f32::MAX, f32::MAX)
}

fn radiance(film: &Film) -> Vec<Channel> {
    let channels = RGB.into_iter().enumerate();
    let channels =
        channels.map(|(c, name)| channel(film, name, |i| single(film.pixels[i].mean[c])));
    channels.collect()
}

fn channel(film: &Film, name: &str, value: impl Fn(usize) -> f32 + Send + Sync) -> Channel {
    let values = (0..film.pixels.len()).into_par_iter().map(value);
    (name.to_owned(), values.collect())
}

/// Named channels of 32-bit floats, row by row, with `attributes` (name, text), as an EXR.
///
/// # Errors
/// The format cannot hold them.
pub fn encode_channels(
    size: FilmSize,
    channels: Vec<Channel>,
    attributes: &[(&str, String)],
) -> io::Result<Vec<u8>> {
    let channels = channels.into_iter().map(|(name, values)| AnyChannel {
        name: text(&name),
        sample_data: FlatSamples::F32(values),
        quantize_linearly: false,
        sampling: ::exr::math::Vec2(1, 1),
    });
    let size = (size.width as usize, size.height as usize);
    let mut layer = LayerAttributes {
        software_name: Some(text(concat!("direkt ", env!("CARGO_PKG_VERSION")))),
        ..LayerAttributes::default()
    };
    for (name, value) in attributes {
        let value = AttributeValue::Text(text(value));
        layer.other.insert(text(name), value);
    }
    let layer = Layer::new(
        size,
        layer,
        Encoding::FAST_LOSSLESS,
        AnyChannels::sort(channels.collect()),
    );
    let mut bytes = io::Cursor::new(Vec::new());
    Image::empty(ImageAttributes::with_size(size))
        .with_layer(layer)
        .write()
        .to_buffered(&mut bytes)
        .map_err(io::Error::other)?;
    Ok(bytes.into_inner())
}

/// `text` in UTF-8, as OpenEXR's own tools write it.
fn text(text: &str) -> Text {
    Text::from_slice_unchecked(text.as_bytes())
}
