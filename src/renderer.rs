//! The door: a [`Renderer`] renders a [`Scene`] to an [`Image`] that says how right it is.

use crate::error::Error;
use crate::gpu::Context;
use crate::image::png::Display;
use crate::image::{exr, extension, layers, png};
use crate::prepare::Prepared;
use crate::render::{AovImages, Film, ImageError, Passes, Session, StoppedBy, render_aovs};
use crate::scene::Scene;
use crate::scene::validate::validate;
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

    /// A renderer on the caller's device. WebGPU's default limits are enough for all but large scenes and images.
    pub fn from_device(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        let context = Context::of_device(device, queue);
        Self { context }
    }

    /// Renders `scene` until its samples, time or error are what [`Scene::render`] asks for.
    ///
    /// # Errors
    /// A number of the scene is out of its domain, the scene is too large for the device, or the driver fails.
    pub fn render(&self, scene: Scene) -> Result<Image, Error> {
        let mut progress = self.begin(scene)?;
        while progress.pass()?.is_none() {}
        progress.image()
    }

    /// Begins to render `scene`, pass by pass.
    ///
    /// # Errors
    /// A number of the scene is out of its domain, or the scene is too large for the device.
    pub fn begin(&self, scene: Scene) -> Result<ProgressiveRender<'_>, Error> {
        validate(&scene)?;
        let (film, settings) = (scene.film, scene.render);
        let prepared = Prepared::of(scene);
        let session = Session::new(&self.context, &prepared, film, settings.seed)?;
        Ok(ProgressiveRender {
            prepared,
            session,
            passes: Passes::new(&settings),
        })
    }
}

/// A render in progress.
#[derive(Debug)]
pub struct ProgressiveRender<'a> {
    prepared: Prepared,
    session: Session<'a>,
    passes: Passes,
}

impl ProgressiveRender<'_> {
    /// Takes every pixel a few samples further, as many as a fraction of a second allows; what ended the render, where that is
    /// done.
    ///
    /// # Errors
    /// The driver fails.
    pub fn pass(&mut self) -> Result<Option<StoppedBy>, Error> {
        let ended = self.passes.take(&mut self.session, || false)?;
        Ok(match ended {
            None => self.passes.judge(&self.session)?,
            ended => ended,
        })
    }

    /// Samples per pixel so far.
    pub fn samples(&self) -> u64 {
        self.session.samples()
    }

    /// The image so far, with the AOVs of [`RenderSettings::aovs`](crate::RenderSettings::aovs).
    ///
    /// # Errors
    /// The driver fails.
    pub fn image(&self) -> Result<Image, Error> {
        let (film, _) = self.session.snapshot()?;
        let settings = self.prepared.settings;
        let aovs = if settings.aovs.is_empty() || film.mean_samples() == 0 {
            AovImages::default()
        } else {
            let image = (film.size, settings.seed);
            let samples = film.mean_samples();
            render_aovs(self.session.context(), &self.prepared, image, samples)?
        };
        Ok(Image {
            channels: layers::channels(&self.prepared, &film, &aovs),
            attributes: layers::attributes(&self.prepared, &aovs),
            film,
        })
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

    /// Standard error of every pixel's radiance, row by row; `None` while a pixel has fewer than two samples.
    pub fn standard_errors(&self) -> Option<Vec<[f64; 3]>> {
        let variances = self.film.variances()?;
        let root = |variance: [f64; 3]| variance.map(f64::sqrt);
        Some(variances.into_iter().map(root).collect())
    }

    /// Mean radiance of the image.
    pub fn mean(&self) -> [f64; 3] {
        self.film.mean()
    }

    /// Error of the whole image, with its interval; `None` while it cannot be told.
    pub fn error(&self) -> Option<ImageError> {
        self.film.error()
    }

    /// What it was made of, for what this type does not offer.
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

    /// Writes the image into a texture of its size that may be copied to: linear radiance into `Rgba32Float` and `Rgba16Float`,
    /// sRGB into `Rgba8Unorm` and `Rgba8UnormSrgb`; alpha is 1.
    ///
    /// # Errors
    /// The texture has another size or format.
    pub fn write_texture(&self, queue: &wgpu::Queue, texture: &wgpu::Texture) -> Result<(), Error> {
        let (width, height) = (self.width(), self.height());
        if (texture.width(), texture.height()) != (width, height) {
            return Err(Error::Usage(format!(
                "the texture has {} × {} texels: the image has {width} × {height} pixels",
                texture.width(),
                texture.height()
            )));
        }
        let pixels = self.radiance();
        let bytes: Vec<u8> = match texture.format() {
            wgpu::TextureFormat::Rgba32Float => {
                let texels = pixels.map(|[r, g, b]| [r, g, b, 1.0].map(exr::single));
                texels.flat_map(bytemuck::cast::<_, [u8; 16]>).collect()
            }
            wgpu::TextureFormat::Rgba16Float => {
                let texels = pixels.map(|[r, g, b]| [r, g, b, 1.0].map(f16::from_f64));
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
            bytes_per_row: Some(bytes.len() as u32 / height),
            rows_per_image: None,
        };
        queue.write_texture(texture.as_image_copy(), &bytes, layout, texture.size());
        Ok(())
    }
}
