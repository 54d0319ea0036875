//! The files that a render writes.

use super::plan::Plan;
use direkt::error::{Error, number};
use direkt::low_level::image::exr::Channel;
use direkt::low_level::image::{ToneMapper, exr, extension, png};
use direkt::low_level::render::Film;
use std::path::{Path, PathBuf};

/// Output files and how they are shown.
#[derive(Debug, clap::Args)]
pub struct OutputArguments {
    /// Image to write: .exr (radiance, samples, standard error) or .png (tone-mapped); may be
    /// repeated
    #[arg(
        short,
        long = "output",
        value_name = "FILE",
        required_unless_present = "check"
    )]
    pub output: Vec<PathBuf>,
    /// Write radiance alone to .exr files, for programs that take no further layers
    #[arg(long, requires = "output", conflicts_with = "aovs")]
    pub plain: bool,
    /// Exposure of the PNG in stops
    #[arg(
        long,
        value_name = "STOPS",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    pub exposure: f64,
    /// Tone mapper of the PNG
    #[arg(long, value_enum, default_value_t)]
    pub tone: ToneMapper,
}

impl OutputArguments {
    /// Adds the images to what the command is going to write.
    pub fn plan(&self, plan: &mut Plan) -> Result<(), Error> {
        if !self.exposure.is_finite() {
            return Err(Error::Usage(format!(
                "--exposure {}: a finite number is needed",
                number(self.exposure)
            )));
        }
        for path in &self.output {
            plan.image("-o", path)?;
        }
        if self.plain && !self.has_exr() {
            return Err(Error::Usage(
                "--plain: it is about EXR files; add an output such as -o out.exr".to_owned(),
            ));
        }
        Ok(())
    }

    /// Whether one of them has channels beside radiance.
    pub fn has_layers(&self) -> bool {
        self.has_exr() && !self.plain
    }

    fn has_exr(&self) -> bool {
        self.output.iter().any(|path| extension(path) == "exr")
    }

    /// Each file with its content, EXRs with `further` channels.
    pub fn encode<'a>(
        &'a self,
        film: &'a Film,
        further: &'a [Channel],
        attributes: &'a [(&str, String)],
    ) -> impl Iterator<Item = (&'a Path, Result<Vec<u8>, Error>)> {
        self.output.iter().map(move |path| {
            let encoded = match extension(path).as_str() {
                "exr" if self.plain => exr::encode_plain(film, attributes),
                "exr" => exr::encode(film, further, attributes),
                _ => png::encode(film, &self.display()),
            };
            (path.as_path(), encoded.map_err(|e| Error::write(path, e)))
        })
    }

    fn display(&self) -> png::Display {
        png::Display {
            exposure: self.exposure,
            tone: self.tone,
        }
    }
}
