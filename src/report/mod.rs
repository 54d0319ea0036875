//! The report of `direkt cost`: a page that needs no network, its plots as SVG and PNG, a table as CSV.

mod chart;
pub mod csv;
mod effects;
mod figures;
pub mod format;
mod lead;
pub mod machine;
mod page;
mod picture;
mod tables;

pub use figures::{ranked, with_effects};

use crate::cost::SceneCost;
use crate::drawing::raster;
use crate::error::Error;
use crate::image::write_atomically;
use machine::Machine;
use std::path::Path;

/// Writes the page and the plots into `folder`, which is made if need be. Scenes of `not_measured` are named as such.
///
/// # Errors
/// A file cannot be written.
pub fn write(
    folder: &Path,
    costs: &[SceneCost],
    not_measured: &[String],
    machine: &Machine,
) -> Result<(), Error> {
    std::fs::create_dir_all(folder).map_err(|source| Error::Write {
        path: folder.to_path_buf(),
        source,
    })?;
    for (stem, cost) in stems(costs).iter().zip(costs) {
        for figure in figures::of(cost).into_iter().chain(figures::effects(cost)) {
            let path = |extension: &str| folder.join(format!("{stem}-{}.{extension}", figure.name));
            write_atomically(&path("svg"), figure.svg.file().as_bytes())?;
            write_atomically(&path("png"), &raster::png(&figure.svg)?)?;
        }
    }
    let page = page::html(costs, not_measured, machine)?;
    write_atomically(&folder.join("report.html"), page.as_bytes())
}

/// What the files of each scene are called: its file's stem, numbered where that comes twice.
fn stems(costs: &[SceneCost]) -> Vec<String> {
    let mut stems: Vec<String> = Vec::new();
    for cost in costs {
        let stem = Path::new(&cost.scene).file_stem();
        let stem = stem.map_or_else(|| "scene".into(), |s| s.to_string_lossy().into_owned());
        let twice = stems.contains(&stem);
        stems.push(if twice {
            format!("{stem}-{}", stems.len() + 1)
        } else {
            stem
        });
    }
    stems
}
