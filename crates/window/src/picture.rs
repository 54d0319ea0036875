//! From a film to the colours of a screen.

use super::density::Density;
use super::request::{Layer, Method};
use direkt::low_level::effects::Effect;
use direkt::low_level::image::heat::{heat, ramp};
use direkt::low_level::image::png::Display;
use direkt::low_level::image::signed;
use direkt::low_level::render::{Film, ImageError, RayCounts};
use direkt::scene::{EstimatorSettings, FilmSize};
use eframe::egui::{Color32, ColorImage};
use glam::DVec3;
use rayon::prelude::*;
use std::sync::Arc;

/// Relative differences at the ends of their colours.
const DIFFERENCE: f64 = 0.5;

/// An image as it stood, and what is known of it.
#[derive(Debug, Clone)]
pub struct Picture {
    /// The request that it belongs to.
    pub version: u64,
    /// The run: a new one begins whenever the samples begin anew.
    pub run: u64,
    /// How it was rendered.
    pub method: Arc<Method>,
    /// The method's estimator as it was used: large scenes are loaded, whatever `specialize` says.
    pub estimator: EstimatorSettings,
    /// Its colours.
    pub colours: Arc<ColorImage>,
    /// The image.
    pub film: Arc<Film>,
    /// Whether it has the size that was asked for, not a smaller one.
    pub full: bool,
    /// Samples that every pixel has.
    pub samples: u64,
    /// Seconds of rendering.
    pub seconds: f64,
    /// Seconds of a pass over the image, the last one.
    pub pass_seconds: f64,
    /// Seconds that compiling took.
    pub compile_seconds: f64,
    /// Rays traced.
    pub rays: RayCounts,
    /// The image's error, when it was last looked at.
    pub error: Option<ImageError>,
    /// Seconds and √NMSE, as often as it was looked at.
    pub curve: Arc<Vec<[f64; 2]>>,
    /// What is compiled in, and why.
    pub effects: Arc<Vec<(Effect, String)>>,
    /// Why the image does not converge to direct lighting; none where it does.
    pub bias: Option<String>,
}

/// What lies under a point of the image.
#[derive(Debug, Clone, PartialEq)]
pub struct Inspected {
    /// The point, in fractions of the image's width and height.
    pub at: [f64; 2],
    /// What the ray through it meets; none beyond everything.
    pub surface: Option<InspectedSurface>,
}

/// A surface that was asked about.
#[derive(Debug, Clone, PartialEq)]
pub struct InspectedSurface {
    /// Name of the shape.
    pub shape: String,
    /// Name of its material.
    pub material: String,
    /// The point, world space.
    pub position: DVec3,
    /// Distance from the plane through the eye, along the viewing direction.
    pub depth: f64,
    /// The box around the shape.
    pub bounds: (DVec3, DVec3),
    /// How directions are chosen there.
    pub densities: Vec<Density>,
}

/// The colours of `film`. A difference needs the `other` film, of the same size; without it
/// radiance is shown.
pub fn colours(film: &Film, other: Option<&Film>, layer: Layer, display: &Display) -> ColorImage {
    let pixels = match (layer, other.filter(|other| other.size == film.size)) {
        (Layer::StandardError, _) => standard_error(film),
        (Layer::Difference, Some(other)) => difference(film, other),
        (Layer::Samples, _) => samples(film),
        _ => radiance(film, display),
    };
    let FilmSize { width, height } = film.size;
    ColorImage::new([width as usize, height as usize], pixels)
}

fn colour([r, g, b]: [u8; 3]) -> Color32 {
    Color32::from_rgb(r, g, b)
}

fn radiance(film: &Film, display: &Display) -> Vec<Color32> {
    let pixels = film.pixels.par_iter();
    pixels.map(|p| colour(display.encode(p.mean))).collect()
}

fn standard_error(film: &Film) -> Vec<Color32> {
    let floor = 0.1 * mean(film.mean());
    let Some(variances) = film.variances() else {
        return vec![Color32::GRAY; film.pixels.len()];
    };
    let pixels = film.pixels.par_iter().zip(variances);
    let relative = pixels.map(|(pixel, variance)| {
        let value = mean(pixel.mean).hypot(floor);
        let error = mean(variance).sqrt();
        if value > 0.0 { error / value } else { 0.0 }
    });
    relative.map(|error| colour(heat(error))).collect()
}

fn difference(film: &Film, other: &Film) -> Vec<Color32> {
    let floor = 0.1 * mean(film.mean());
    let pixels = film.pixels.par_iter().zip(&other.pixels);
    let relative = pixels.map(|(a, b)| {
        let (a, b) = (mean(a.mean), mean(b.mean));
        let scale = (0.5 * (a + b)).hypot(floor);
        if scale > 0.0 { (a - b) / scale } else { 0.0 }
    });
    relative
        .map(|x| colour(signed::colour(x / DIFFERENCE)))
        .collect()
}

fn samples(film: &Film) -> Vec<Color32> {
    let octaves = 16_f64.log2();
    let mean = film.mean_samples() as f64;
    let pixels = film.pixels.par_iter();
    let relative = pixels.map(|p| (p.samples as f64 / mean).log2() / octaves);
    relative.map(|x| colour(ramp(0.5 + 0.5 * x))).collect()
}

fn mean(rgb: [f64; 3]) -> f64 {
    (rgb[0] + rgb[1] + rgb[2]) / 3.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use direkt::low_level::render::Pixel;
    use direkt::scene::Sampler;

    fn film(values: &[f64]) -> Film {
        let size = FilmSize {
            width: values.len() as u32,
            height: 1,
        };
        let mut film = Film::new(size, Sampler::Independent);
        for (pixel, &value) in film.pixels.iter_mut().zip(values) {
            *pixel = Pixel {
                samples: 4,
                mean: [value; 3],
                m2: [12.0 * value * value; 3],
                second_samples: 2,
                second_mean: [value; 3],
                ..Pixel::default()
            };
        }
        film
    }

    #[test]
    fn radiance_is_what_a_png_shows() {
        let display = Display::default();
        let picture = colours(&film(&[0.0, 0.5, 7.0]), None, Layer::Radiance, &display);
        let expected = [0.0, 0.5, 7.0].map(|x| colour(display.encode([x; 3])));
        assert_eq!(picture.pixels, expected);
        assert_eq!(picture.size, [3, 1]);
    }

    #[test]
    fn equal_images_differ_in_nothing() {
        let (a, b) = (film(&[0.0, 1.0]), film(&[0.0, 2.0]));
        let picture = colours(&a, Some(&b), Layer::Difference, &Display::default());
        assert_eq!(picture.pixels[0], Color32::WHITE);
        assert_eq!(picture.pixels[1], colour(signed::colour(-1.0)));
    }

    #[test]
    fn more_samples_are_lighter() {
        let mut film = film(&[1.0, 1.0, 1.0]);
        for (pixel, samples) in film.pixels.iter_mut().zip([16, 32, 1024]) {
            pixel.samples = samples;
        }
        let picture = colours(&film, None, Layer::Samples, &Display::default());
        let light = |c: &Color32| u32::from(c.r()) + u32::from(c.g()) + u32::from(c.b());
        assert!(picture.pixels.is_sorted_by(|a, b| light(a) < light(b)));
    }

    #[test]
    fn a_larger_error_is_lighter() {
        // A standard error of the pixel's own value in both: beside the image's mean, that of the
        // dark one is small.
        let picture = colours(
            &film(&[0.01, 1.0]),
            None,
            Layer::StandardError,
            &Display::default(),
        );
        let luminance = |c: Color32| u32::from(c.r()) + u32::from(c.g()) + u32::from(c.b());
        assert!(luminance(picture.pixels[0]) < luminance(picture.pixels[1]));
    }
}
