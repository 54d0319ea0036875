//! A render in one call: a [`Renderer`] renders a [`Scene`] to an [`Image`] that says how right it
//! is.

use crate::error::Error;
use crate::gpu::Context;
use crate::image::png::Display;
use crate::image::{exr, extension, layers, png};
use crate::prepare::Prepared;
use crate::render::{Film, ImageError, Passes, Session, StoppedBy, render_aovs};
use crate::scene::Scene;
use crate::scene::load::validate_and_fold;
use half::f16;
use std::path::Path;

/// Renders scenes on one device, which keeps the kernels that it compiled.
#[derive(Debug)]
pub struct Renderer {
    context: Context,
}

impl Renderer {
    /// A renderer on the best adapter of this machine.
    ///
    /// # Errors
    /// There is no adapter, or its device cannot be opened.
    pub fn new() -> Result<Self, Error> {
        let context = Context::new(None)?;
        Ok(Self { context })
    }

    /// A renderer on the caller's device. WebGPU's default limits are enough for all but large
    /// scenes and images.
    pub fn from_device(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        let context = Context::of_device(device, queue);
        Self { context }
    }

    /// Renders `scene` until the first of [`StopSettings::spp`], `time` and `error` is reached,
    /// or no sample finds any light. What of a file has no meaning is in [`Scene::warnings`], which
    /// is the caller's to show.
    ///
    /// [`StopSettings::spp`]: crate::StopSettings::spp
    ///
    /// # Errors
    /// A number of the scene is out of its domain, the scene is too large for the device, or the
    /// driver fails, with which the image is lost.
    pub fn render(&self, scene: Scene) -> Result<Image, Error> {
        let mut progress = self.begin(scene)?;
        while progress.pass()?.is_none() {}
        progress.image_with_aovs()
    }

    /// Begins to render `scene`, pass by pass;
    /// [`StopSettings::time`](crate::StopSettings::time) begins now.
    ///
    /// # Errors
    /// A number of the scene is out of its domain, or the scene is too large for the device.
    pub fn begin(&self, mut scene: Scene) -> Result<ProgressiveRender<'_>, Error> {
        validate_and_fold(&mut scene)?;
        let (film, settings) = (scene.film, scene.render);
        let prepared = Prepared::of(scene);
        let session = Session::new(&self.context, &prepared, film, settings.seed)?;
        Ok(ProgressiveRender {
            prepared,
            session,
            passes: Passes::new(&settings),
            ended: None,
        })
    }
}

/// A render in progress.
#[derive(Debug)]
pub struct ProgressiveRender<'a> {
    prepared: Prepared,
    session: Session<'a>,
    passes: Passes,
    ended: Option<StoppedBy>,
}

impl ProgressiveRender<'_> {
    /// Takes every pixel a few samples further, as many as a fraction of a second allows; once the
    /// render has ended, nothing but what ended it.
    ///
    /// # Errors
    /// The driver fails.
    pub fn pass(&mut self) -> Result<Option<StoppedBy>, Error> {
        if self.ended.is_none() {
            self.ended = self.passes.take(&mut self.session, || false)?;
        }
        if self.ended.is_none() {
            self.ended = self.passes.judge(&self.session)?;
        }
        Ok(self.ended)
    }

    /// Samples per pixel so far.
    pub fn samples(&self) -> u64 {
        self.session.samples()
    }

    /// The image so far.
    ///
    /// # Errors
    /// The driver fails.
    pub fn image(&self) -> Result<Image, Error> {
        let (film, _) = self.session.snapshot()?;
        let adapter = &self.session.context().adapter;
        let attributes = layers::render_attributes(&self.prepared, &film, adapter);
        Ok(Image {
            film,
            channels: Vec::new(),
            attributes,
        })
    }

    /// The image so far with the AOVs of [`RenderSettings::aovs`], some of which have rays of their
    /// own.
    ///
    /// # Errors
    /// The driver fails.
    ///
    /// [`RenderSettings::aovs`]: crate::RenderSettings::aovs
    pub fn image_with_aovs(&self) -> Result<Image, Error> {
        let mut image = self.image()?;
        let of_image = (image.film.size, self.prepared.settings.seed);
        let samples = image.film.mean_samples();
        let aovs = render_aovs(self.session.context(), &self.prepared, of_image, samples)?;
        image.channels = layers::channels(&self.prepared, &image.film, &aovs);
        let of_channels = layers::attributes(&self.prepared, &aovs);
        image.attributes.extend(of_channels);
        Ok(image)
    }
}

/// Radiance per pixel, linear RGB, with its standard error.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    film: Film,
    channels: Vec<exr::Channel>,
    attributes: Vec<(&'static str, String)>,
}

impl Image {
    /// Pixels per row.
    pub fn width(&self) -> u32 {
        self.film.size.width
    }

    /// Rows.
    pub fn height(&self) -> u32 {
        self.film.size.height
    }

    /// Radiance (W·sr⁻¹·m⁻²) of every pixel, row by row from the top.
    pub fn radiance(&self) -> impl Iterator<Item = [f64; 3]> + '_ {
        self.film.pixels.iter().map(|pixel| pixel.mean)
    }

    /// Standard error of every pixel's radiance, row by row; `None` while a pixel has fewer than
    /// two samples.
    pub fn standard_errors(&self) -> Option<Vec<[f64; 3]>> {
        let variances = self.film.variances()?;
        let root = |variance: [f64; 3]| variance.map(f64::sqrt);
        Some(variances.into_iter().map(root).collect())
    }

    /// Mean radiance of the image.
    pub fn mean(&self) -> [f64; 3] {
        self.film.mean()
    }

    /// The error of the whole image with intervals of 95 % confidence; `None` while the image is
    /// black or a pixel has fewer than two samples.
    pub fn error(&self) -> Option<ImageError> {
        self.film.error()
    }

    /// The film: sums of every pixel, and all else that this type does not offer.
    pub fn film(&self) -> &Film {
        &self.film
    }

    /// Writes an `.exr` (radiance, standard errors, samples, AOVs) or a `.png` (sRGB).
    ///
    /// # Errors
    /// The name ends otherwise, or the file cannot be written.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        let path = path.as_ref();
        match extension(path).as_str() {
            "exr" => exr::write(path, &self.film, &self.channels, &self.attributes),
            "png" => png::write(path, &self.film, &Display::default()),
            _ => Err(Error::Usage(format!(
                "{}: an image is written as .exr or .png",
                path.display()
            ))),
        }
    }

    /// Writes the image into a texture of its size that may be copied to: linear radiance into
    /// `Rgba32Float` and `Rgba16Float`, sRGB into `Rgba8Unorm` and `Rgba8UnormSrgb`; alpha is 1. Of
    /// an array its first layer, of mipmaps the largest.
    ///
    /// # Errors
    /// The texture has another size or format, or may not be copied to.
    pub fn write_texture(&self, queue: &wgpu::Queue, texture: &wgpu::Texture) -> Result<(), Error> {
        let (width, height) = (self.width(), self.height());
        if (texture.width(), texture.height()) != (width, height) {
            return Err(Error::Usage(format!(
                "the texture has {} × {} texels: the image has {width} × {height} pixels",
                texture.width(),
                texture.height()
            )));
        }
        let refuse = |problem: &str| Err(Error::Usage(format!("the texture {problem}")));
        if !texture.usage().contains(wgpu::TextureUsages::COPY_DST) {
            return refuse("lacks the usage COPY_DST");
        }
        if texture.dimension() != wgpu::TextureDimension::D2 || texture.sample_count() != 1 {
            return refuse("has another dimension than D2, or several samples");
        }
        let pixels = self.radiance();
        let bytes: Vec<u8> = match texture.format() {
            wgpu::TextureFormat::Rgba32Float => {
                let texels = pixels.map(|[r, g, b]| [r, g, b, 1.0].map(exr::single));
                texels.flat_map(bytemuck::cast::<_, [u8; 16]>).collect()
            }
            wgpu::TextureFormat::Rgba16Float => {
                let texels = pixels.map(|[r, g, b]| [r, g, b, 1.0].map(half));
                texels.flat_map(bytemuck::cast::<_, [u8; 8]>).collect()
            }
            wgpu::TextureFormat::Rgba8Unorm | wgpu::TextureFormat::Rgba8UnormSrgb => {
                let display = Display::default();
                let texels = pixels.map(|rgb| display.encode(rgb));
                texels.flat_map(|[r, g, b]| [r, g, b, 255]).collect()
            }
            other => {
                return Err(Error::Usage(format!(
                    "the texture's format is {other:?}: Rgba32Float, Rgba16Float, Rgba8Unorm or Rgba8UnormSrgb is written"
                )));
            }
        };
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some((bytes.len() / height as usize) as u32),
            rows_per_image: None,
        };
        let size = wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        };
        queue.write_texture(texture.as_image_copy(), &bytes, layout, size);
        Ok(())
    }
}

/// `x` in 16 bits. What is beyond their range is their largest number: an image has no infinity.
fn half(x: f64) -> f16 {
    f16::from_f64(x.min(f16::MAX.to_f64()))
}
