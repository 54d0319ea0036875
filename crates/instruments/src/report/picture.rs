//! Images inside a page: reduced to the size at which the page shows them, and compressed.

use base64::Engine;
use direkt::error::Error;
use direkt::low_level::image::heat::heat;
use direkt::low_level::image::png::Display;
use direkt::low_level::image::tone::srgb_8_bit;
use direkt::scene::FilmSize;
use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::{CompressionType, FilterType as PngFilter, PngEncoder};
use image::imageops::{self, FilterType};
use image::{ExtendedColorType, ImageBuffer, ImageEncoder, ImageResult, Luma, Rgb};

/// Pixels per row of an image at most; a page shows it about 300 wide.
const IMAGE_WIDTH: u32 = 360;
/// Of a heat map, in which single pixels say little.
const HEAT_WIDTH: u32 = 256;
/// Images of at most so many pixels are kept as they are; noise in larger ones takes too much room.
const SMALL: u32 = 1 << 14;
/// Of JPEG, from 1 to 100. At the size at which a page shows them, 70 cannot be told from 90.
const QUALITY: u8 = 75;

/// A `data:` address of the heat map of relative errors; where it is reduced, of their root mean
/// square.
pub fn heat_map(size: FilmSize, errors: &[f64]) -> Result<String, Error> {
    let squares = errors.iter().map(|e| (e * e) as f32).collect();
    let squares: ImageBuffer<Luma<f32>, Vec<f32>> =
        ImageBuffer::from_raw(size.width, size.height, squares).expect("one error per pixel");
    let reduced = reduced(&squares, HEAT_WIDTH);
    let colours = reduced
        .pixels()
        .flat_map(|p| heat(f64::from(p.0[0].max(0.0)).sqrt()));
    data_address(reduced.dimensions(), &colours.collect::<Vec<_>>())
}

/// A `data:` address of radiance as it would be shown. Where it is reduced, the light of the
/// display's pixels is averaged.
pub fn radiance(size: FilmSize, pixels: impl Iterator<Item = [f64; 3]>) -> Result<String, Error> {
    let display = Display::default();
    let light = pixels
        .flat_map(|p| display.linear(p).map(|x| x as f32))
        .collect();
    let light: ImageBuffer<Rgb<f32>, Vec<f32>> =
        ImageBuffer::from_raw(size.width, size.height, light).expect("one radiance per pixel");
    let reduced = reduced(&light, IMAGE_WIDTH);
    let bytes = reduced
        .as_raw()
        .iter()
        .map(|x| srgb_8_bit(f64::from(x.clamp(0.0, 1.0))));
    data_address(reduced.dimensions(), &bytes.collect::<Vec<_>>())
}

/// `image` with at most `width` pixels per row.
fn reduced<P>(image: &ImageBuffer<P, Vec<f32>>, width: u32) -> ImageBuffer<P, Vec<f32>>
where
    P: image::Pixel<Subpixel = f32> + 'static,
{
    if image.width() <= width {
        return image.clone();
    }
    let height = (f64::from(image.height()) * f64::from(width) / f64::from(image.width())).round();
    imageops::resize(image, width, (height as u32).max(1), FilterType::Triangle)
}

fn data_address((width, height): (u32, u32), rgb: &[u8]) -> Result<String, Error> {
    let (kind, bytes) = encode(width, height, rgb)
        .map_err(|e| Error::write("image of the page", std::io::Error::other(e)))?;
    let text = base64::engine::general_purpose::STANDARD.encode(bytes);
    Ok(format!("data:image/{kind};base64,{text}"))
}

/// Kind of file, and what is in it.
fn encode(width: u32, height: u32, rgb: &[u8]) -> ImageResult<(&'static str, Vec<u8>)> {
    let mut bytes = Vec::new();
    let colour = ExtendedColorType::Rgb8;
    if width * height <= SMALL {
        PngEncoder::new_with_quality(&mut bytes, CompressionType::Best, PngFilter::Adaptive)
            .write_image(rgb, width, height, colour)?;
        return Ok(("png", bytes));
    }
    JpegEncoder::new_with_quality(&mut bytes, QUALITY).write_image(rgb, width, height, colour)?;
    Ok(("jpeg", bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What an address holds.
    fn decoded(address: &str, kind: &str) -> image::RgbImage {
        let text = address.strip_prefix(&format!("data:image/{kind};base64,"));
        let text = text.expect("its kind");
        let bytes = base64::engine::general_purpose::STANDARD.decode(text);
        let image = image::load_from_memory(&bytes.expect("base64"));
        image.expect("an image").into_rgb8()
    }

    #[test]
    fn small_images_are_kept_as_they_are() {
        let size = FilmSize {
            width: 2,
            height: 1,
        };
        let address = radiance(size, [[0.0; 3], [1.0, 0.2, 7.0]].into_iter()).expect("an image");
        let image = decoded(&address, "png");
        let expected = Display::default().encode([1.0, 0.2, 7.0]);
        assert_eq!(
            (image.get_pixel(0, 0).0, image.get_pixel(1, 0).0),
            ([0; 3], expected)
        );
    }

    /// Columns of light 1 and 0 by turns are as bright as light ½, and columns of errors 1 and 0
    /// have the RMS √½.
    #[test]
    fn reduced_images_have_the_mean_light_and_the_mean_square() {
        let size = FilmSize {
            width: 720,
            height: 200,
        };
        let column = |i: usize| f64::from(i as u32 % 2);
        let columns = || (0..).map(column);
        let address =
            radiance(size, columns().take(size.pixels()).map(|x| [x; 3])).expect("an image");
        let image = decoded(&address, "jpeg");
        assert_eq!(image.dimensions(), (IMAGE_WIDTH, 100));
        let half = srgb_8_bit(0.5);
        assert!(
            image
                .get_pixel(180, 50)
                .0
                .iter()
                .all(|c| c.abs_diff(half) <= 2)
        );

        let size = FilmSize {
            width: 2 * HEAT_WIDTH,
            height: 200,
        };
        let errors: Vec<f64> = columns().take(size.pixels()).collect();
        let image = decoded(&heat_map(size, &errors).expect("an image"), "jpeg");
        assert_eq!(image.dimensions(), (HEAT_WIDTH, 100));
        let expected = heat(0.5_f64.sqrt());
        let pixel = image.get_pixel(128, 50).0;
        assert!(
            pixel.iter().zip(expected).all(|(c, e)| c.abs_diff(e) <= 4),
            "{pixel:?}"
        );
    }
}
