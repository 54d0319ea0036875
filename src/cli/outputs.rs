//! The files that a render writes.

use crate::error::Error;
use crate::image::exr::Channel;
use crate::image::{ToneMapper, exr, extension, png};
use crate::render::Film;
use std::path::{Path, PathBuf};

/// Output files and how they are shown.
#[derive(Debug, clap::Args)]
pub struct OutputArguments {
    /// Image to write: .exr (radiance, samples, standard error) or .png (tone-mapped); may be repeated
    #[arg(
        short,
        long = "output",
        value_name = "FILE",
        required_unless_present = "check"
    )]
    pub output: Vec<PathBuf>,
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
    /// Refuses what could not be written in the end, before anything is rendered.
    pub fn check(&self, scene: &Path) -> Result<(), Error> {
        if !self.exposure.is_finite() {
            return Err(Error::Usage(format!(
                "--exposure {}: a finite number is needed",
                self.exposure
            )));
        }
        for path in &self.output {
            check_image_path(path, scene)?;
        }
        Ok(())
    }

    /// Whether one of them has channels beside radiance.
    pub fn has_exr(&self) -> bool {
        self.output.iter().any(|path| extension(path) == "exr")
    }

    /// Writes all files, EXRs with `further` channels.
    pub fn write(
        &self,
        film: &Film,
        further: &[Channel],
        attributes: &[(&str, String)],
    ) -> Result<(), Error> {
        for path in &self.output {
            if extension(path) == "exr" {
                exr::write(path, film, further, attributes)?;
            } else {
                let display = png::Display {
                    exposure: self.exposure,
                    tone: self.tone,
                };
                png::write(path, film, &display)?;
            }
        }
        Ok(())
    }
}

/// Refuses a file that an image cannot be written to, before anything is rendered.
pub fn check_image_path(path: &Path, scene: &Path) -> Result<(), Error> {
    let name = path.display();
    if !matches!(extension(path).as_str(), "exr" | "png") {
        return Err(Error::Usage(format!(
            "{name}: an image file ends in .exr or .png"
        )));
    }
    if path.is_dir() {
        return Err(Error::Usage(format!("{name} is a folder; name a file")));
    }
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    if !folder.is_dir() {
        return Err(Error::Usage(format!(
            "{name}: there is no folder {}",
            folder.display()
        )));
    }
    if path.exists() && same_file(path, scene) {
        return Err(Error::Usage(format!("{name} is the scene itself")));
    }
    Ok(())
}

fn same_file(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}
