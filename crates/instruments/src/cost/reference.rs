//! What images are compared with.

use super::estimator::Estimator;
use ::exr::prelude::{ReadChannels, ReadLayers, read};
use direkt::error::{Error, InputError};
use direkt::low_level::render::Film;
use direkt::scene::{ExpectedRadiance, FilmSize, Scene};
use serde::Serialize;
use std::path::Path;

/// Where a reference comes from.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Source {
    /// A file; its own error is not known, and nothing is subtracted.
    File {
        /// The file.
        path: String,
    },
    /// The exact radiance that the scene states.
    Exact {
        /// Where that comes from.
        source: String,
    },
    /// A render of two independent halves.
    OwnRun {
        /// What rendered it.
        estimator: Estimator,
        /// Samples per pixel of both halves together.
        samples: u64,
        /// Seconds that it took.
        seconds: f64,
    },
}

/// The reference's own error: mean squared and relative.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct OwnError {
    /// Estimate, zero where nothing is known.
    pub value: [f64; 2],
    /// Its standard error.
    pub standard_error: [f64; 2],
}

/// An image that others are compared with.
#[derive(Debug, Clone)]
pub struct Reference {
    /// Radiance per pixel, row by row.
    pub mean: Vec<[f64; 3]>,
    /// 0.01·mean², what keeps relative errors finite.
    floor: f64,
    own: OwnError,
}

impl Reference {
    /// An image without error.
    pub fn exact(mean: Vec<[f64; 3]>) -> Self {
        let sum: f64 = mean.iter().flatten().sum();
        let overall = sum / (3 * mean.len()) as f64;
        Self {
            floor: 0.01 * overall * overall,
            mean,
            own: OwnError::default(),
        }
    }

    /// The mean of two independent halves, whose difference tells its error.
    pub fn from_halves(a: &Film, b: &Film) -> Self {
        let pairs = || a.pixels.iter().zip(&b.pixels);
        let mean = |(a, b): (
            &direkt::low_level::render::film::Pixel,
            &direkt::low_level::render::film::Pixel,
        )| { [0, 1, 2].map(|c| 0.5 * (a.mean[c] + b.mean[c])) };
        let mut reference = Self::exact(pairs().map(mean).collect());
        let (mut sum, mut squares) = ([0.0; 2], [0.0; 2]);
        for ((a, b), r) in pairs().zip(&reference.mean) {
            let mut pixel = [0.0; 2];
            for ((a, b), r) in a.mean.iter().zip(b.mean).zip(r) {
                let variance = 0.25 * (a - b).powi(2);
                pixel[0] += variance / 3.0;
                pixel[1] += variance * reference.weight(*r) / 3.0;
            }
            for k in 0..2 {
                sum[k] += pixel[k];
                // A normal variable's square has a variance below its own mean square.
                squares[k] += pixel[k] * pixel[k];
            }
        }
        let pixels = reference.mean.len() as f64;
        reference.own = OwnError {
            value: sum.map(|s| s / pixels),
            standard_error: squares.map(|s| s.sqrt() / pixels),
        };
        reference
    }

    /// What squared errors of a channel are multiplied with to be relative; `r` is the reference
    /// there.
    pub fn weight(&self, r: f64) -> f64 {
        1.0 / (r * r + self.floor)
    }

    /// The reference's own error, which is subtracted from that of others.
    pub fn own_error(&self) -> OwnError {
        self.own
    }

    /// Whether nothing is to be seen: relative errors do not exist.
    pub fn is_black(&self) -> bool {
        self.floor <= 0.0
    }
}

/// The exact image that `scene` states, with its source: one value per pixel, or the mean of a
/// single pixel.
pub fn stated(scene: &Scene) -> Option<(Reference, Source)> {
    let expect = scene.expect.as_ref()?;
    let mean = match &expect.radiance {
        ExpectedRadiance::Pixels(pixels) => pixels.iter().map(|p| p.to_array()).collect(),
        ExpectedRadiance::Mean(mean) if scene.film.pixels() == 1 => vec![mean.to_array()],
        ExpectedRadiance::Mean(_) => return None,
    };
    // A rounded value is no exact one.
    let source = Source::Exact {
        source: expect.source.clone(),
    };
    (expect.tolerance <= 0.0).then(|| (Reference::exact(mean), source))
}

/// Reads the channels `R`, `G` and `B` of an EXR.
///
/// # Errors
/// The file cannot be read, is no EXR with these channels, has another size than `size`, or holds
/// values that are not finite.
pub fn from_file(path: &Path, size: FilmSize) -> Result<Reference, Error> {
    let wrong = |problem: String| {
        let expected = format!(
            "an EXR image with channels R, G and B of {} × {} pixels, as `direkt render` writes it",
            size.width, size.height
        );
        Error::from(InputError::file(path, problem, expected))
    };
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| (size.width(), vec![[0.0_f64; 3]; size.area()]),
            |(width, pixels), at, (r, g, b): (f32, f32, f32)| {
                pixels[at.y() * *width + at.x()] = [r, g, b].map(f64::from);
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_file(path)
        .map_err(|e| wrong(e.to_string()))?;
    let layer = image.layer_data;
    let found = (layer.size.width(), layer.size.height());
    if found != (size.width as usize, size.height as usize) {
        return Err(wrong(format!("it has {} × {} pixels", found.0, found.1)));
    }
    let pixels = layer.channel_data.pixels.1;
    if pixels.iter().flatten().any(|x| !x.is_finite()) {
        return Err(wrong("it holds values that are not finite".to_owned()));
    }
    Ok(Reference::exact(pixels))
}
