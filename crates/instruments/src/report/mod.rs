//! The report of `direkt cost`: a page that needs no network, its plots as SVG and PNG, a table as
//! CSV.

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
use direkt::error::Error;
use direkt::low_level::output;
use machine::Machine;
use std::path::Path;

/// The page's file.
const PAGE: &str = "report.html";
/// Characters of a scene's name in those of its plots: four bytes each leave room for the rest of a
/// name of 255 bytes.
const MAX_STEM: usize = 48;

/// Writes the page and the plots into `folder`, which is made if need be. Scenes of `not_measured`
/// are named as such.
///
/// # Errors
/// A file cannot be written.
pub fn write(
    folder: &Path,
    costs: &[SceneCost],
    not_measured: &[String],
    machine: &Machine,
) -> Result<(), Error> {
    std::fs::create_dir_all(folder).map_err(|e| Error::write(folder, e))?;
    for (name, bytes) in files(costs, not_measured, machine) {
        output::write(&folder.join(name), &bytes?)?;
    }
    Ok(())
}

/// The names of the files of a report and what is in them, each made when it is asked for: the
/// page, then the plots.
pub fn files<'a>(
    costs: &'a [SceneCost],
    not_measured: &'a [String],
    machine: &'a Machine,
) -> impl Iterator<Item = (String, Result<Vec<u8>, Error>)> + 'a {
    let page = std::iter::once_with(move || {
        let page = page::html(costs, not_measured, machine);
        (PAGE.to_owned(), page.map(String::into_bytes))
    });
    let stems = stems(costs.iter().map(|cost| cost.scene.as_ref()));
    let plots = stems.into_iter().zip(costs).flat_map(|(stem, cost)| {
        let figures = figures::of(cost).into_iter().chain(figures::effects(cost));
        figures.flat_map(move |figure| {
            let [svg, png] = plot_names(&stem, figure.name);
            let drawn = raster::png(&figure.svg);
            [(svg, Ok(figure.svg.file().into_bytes())), (png, drawn)]
        })
    });
    page.chain(plots)
}

/// The names of all files that a report on the scenes in the files `scenes` may have.
pub fn file_names(scenes: &[&Path]) -> Vec<String> {
    let mut names = vec![PAGE.to_owned()];
    for stem in stems(scenes.iter().copied()) {
        names.extend(figures::NAMES.iter().flat_map(|f| plot_names(&stem, f)));
    }
    names
}

fn plot_names(stem: &str, figure: &str) -> [String; 2] {
    ["svg", "png"].map(|extension| format!("{stem}-{figure}.{extension}"))
}

/// What the files of each scene are called: the beginning of its file's stem, numbered where that
/// comes twice.
fn stems<'a>(scenes: impl Iterator<Item = &'a Path>) -> Vec<String> {
    let mut stems: Vec<String> = Vec::new();
    for scene in scenes {
        let stem = scene.file_stem().unwrap_or("scene".as_ref());
        let stem: String = stem.to_string_lossy().chars().take(MAX_STEM).collect();
        let twice = stems.contains(&stem);
        stems.push(if twice {
            format!("{stem}-{}", stems.len() + 1)
        } else {
            stem
        });
    }
    stems
}
