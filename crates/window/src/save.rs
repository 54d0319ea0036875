//! Images and scenes, saved as they are seen.

use super::lights::Lights;
use super::navigation::CameraController;
use super::picture::Picture;
use direkt::error::{Error, InputError};
use direkt::low_level::image::png::{self, Display};
use direkt::low_level::image::{exr, extension};
use direkt::low_level::output;
use direkt::scene::{FilmSize, Projection, RenderSettings};
use glam::DVec3;
use std::path::Path;
use toml_edit::{Array, DocumentMut, Item, Table, value};

/// Writes the image of `picture` to `path`, `.exr` or `.png`.
///
/// # Errors
/// The file has another extension or cannot be written.
pub fn image(
    path: &Path,
    picture: &Picture,
    source: &Path,
    display: &Display,
) -> Result<(), Error> {
    match extension(path).as_str() {
        "png" => png::write(path, &picture.film, display),
        "exr" => {
            let attributes = [
                ("scene", source.display().to_string()),
                ("spp", picture.samples.to_string()),
                ("seed", picture.method.settings.seed.to_string()),
                ("direkt", env!("CARGO_PKG_VERSION").to_owned()),
            ];
            let attributes = [&attributes, &*picture.estimator.entries()].concat();
            exr::write(path, &picture.film, &[], &attributes)
        }
        _ => Err(Error::Usage(format!(
            "{}: an image file ends in .exr or .png",
            path.display()
        ))),
    }
}

/// What of a scene is not as its file has it.
#[derive(Debug, Clone)]
pub struct Changes<'a> {
    /// The camera, where it was moved.
    pub controller: Option<CameraController>,
    /// Size of the image.
    pub film: FilmSize,
    /// The table `[render]`.
    pub settings: RenderSettings,
    /// How lights are switched.
    pub lights: &'a Lights,
}

/// Writes the scene of `source` with `changes` to `path`, a `.toml` file in the same folder, in
/// which file names mean the same. The text of a TOML scene stays as it is, but for what is
/// changed; a glTF file is included.
///
/// # Errors
/// The file is another one than that, or cannot be read or written, or a light is switched that the
/// TOML file does not say itself.
pub fn scene(path: &Path, source: &Path, changes: &Changes<'_>) -> Result<(), Error> {
    let folder = |p: &Path| p.parent().map(|f| f.join(".").canonicalize().ok());
    if extension(path) != "toml" || folder(path) != folder(source) {
        return Err(Error::Usage(format!(
            "{}: a scene is saved as .toml in the folder of {}, where the files that it names are found",
            path.display(),
            source.display()
        )));
    }
    let mut document = document(source)?;
    if let Some(controller) = &changes.controller {
        camera_table(table(&mut document, "camera"), controller);
    }
    let film = table(&mut document, "film");
    film["width"] = value(i64::from(changes.film.width));
    film["height"] = value(i64::from(changes.film.height));
    render_table(table(&mut document, "render"), &changes.settings);
    let lights = changes.lights.write(&mut document);
    lights.map_err(|problem| Error::Usage(format!("{}: {problem}", path.display())))?;
    // What it says holds for the camera and the size of the file.
    document.remove("expect");
    output::write(path, document.to_string().as_bytes())
}

fn document(source: &Path) -> Result<DocumentMut, Error> {
    if extension(source) != "toml" {
        let name = source.file_name().unwrap_or_default().to_string_lossy();
        let mut included = Table::new();
        included["file"] = value(name.as_ref());
        let mut document = DocumentMut::new();
        let mut files = toml_edit::ArrayOfTables::new();
        files.push(included);
        document["gltf"] = Item::ArrayOfTables(files);
        return Ok(document);
    }
    let problem = |what: String| InputError::file(source, what, "the scene that was opened");
    let text =
        std::fs::read_to_string(source).map_err(|e| problem(format!("cannot be read: {e}")))?;
    let parsed = text.parse::<DocumentMut>();
    Ok(parsed.map_err(|e| problem(format!("is no TOML: {e}")))?)
}

/// The table `name`; a new one where there is none.
fn table<'a>(document: &'a mut DocumentMut, name: &str) -> &'a mut Item {
    document
        .entry(name)
        .or_insert_with(|| Item::Table(Table::new()))
}

fn vector(v: DVec3) -> Item {
    value(Array::from_iter(v.to_array()))
}

fn camera_table(table: &mut Item, controller: &CameraController) {
    if let Some(table) = table.as_table_like_mut() {
        table.clear();
    }
    match controller.projection {
        Projection::Perspective { fov_y } => table["fov"] = value(degrees(fov_y)),
        Projection::Orthographic { height } => {
            table["type"] = value("orthographic");
            table["height"] = value(height);
        }
    }
    table["eye"] = vector(controller.eye);
    table["target"] = vector(controller.target);
    table["up"] = vector(controller.up);
    if controller.lens.radius > 0.0 {
        table["lens_radius"] = value(controller.lens.radius);
        table["focus_distance"] = value(controller.lens.focus_distance);
    }
}

/// The number of degrees that is read as exactly these radians, where there is one.
fn degrees(radians: f64) -> f64 {
    let near = radians.to_degrees();
    let candidates = [near, near.next_up(), near.next_down()];
    let exact = |d: &f64| d.to_radians().to_bits() == radians.to_bits();
    candidates.into_iter().find(exact).unwrap_or(near)
}

fn render_table(table: &mut Item, settings: &RenderSettings) {
    for (name, entry) in settings.estimator.entries() {
        table[name] = match (entry.parse::<bool>(), entry.parse::<i64>()) {
            (Ok(flag), _) => value(flag),
            (_, Ok(number)) => value(number),
            _ => value(entry),
        };
    }
    table["spp"] = value(i64::try_from(settings.stop.spp).unwrap_or(i64::MAX));
    table["seed"] = value(i64::from(settings.seed));
    for ends in ["time", "error"] {
        if let Some(table) = table.as_table_like_mut() {
            table.remove(ends);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example;
    use direkt::scene::load::{LoadOptions, load};
    use direkt::scene::normalize::bounds;
    use direkt::scene::{EstimatorSettings, Sampler, StopSettings, Strategy};

    #[test]
    fn a_saved_scene_is_read_as_it_was() {
        let folder = tempfile::tempdir().expect("a folder");
        let source = folder.path().join("cornell.toml");
        std::fs::copy(example("cornell"), &source).expect("copied");
        let before = load(&source, &LoadOptions::default()).expect("Cornell");
        let mut controller = CameraController::of(&before.camera, bounds(&before.shapes));
        controller.orbit(0.3, 0.2);
        controller.pan(0.01, -0.02);
        let lights = Lights::of(&before);
        let changes = Changes {
            lights: &lights,
            controller: Some(controller),
            film: FilmSize {
                width: 123,
                height: 45,
            },
            settings: RenderSettings {
                estimator: EstimatorSettings {
                    strategy: Strategy::Bsdf,
                    sampler: Sampler::Stratified,
                    ..before.render.estimator
                },
                stop: StopSettings {
                    spp: 17,
                    ..before.render.stop
                },
                ..before.render
            },
        };
        let path = folder.path().join("view.toml");
        scene(&path, &source, &changes).expect("written");
        let after = load(&path, &LoadOptions::default()).expect("a scene");
        assert_eq!(Some(after.camera), controller.camera());
        assert_eq!(after.film, changes.film);
        assert_eq!(after.render, changes.settings);
        assert_eq!(after.shapes, before.shapes);
        let text = std::fs::read_to_string(&path).expect("text");
        assert!(text.starts_with("# Proves"), "comments stay: {text}");
        let elsewhere = std::env::temp_dir().join("view.toml");
        assert!(scene(&elsewhere, &source, &changes).is_err());
    }

    #[test]
    fn degrees_are_read_as_the_same_radians() {
        for fov in [39.3077_f64, 40.0, 0.001, 179.0, 33.3333] {
            let radians = fov.to_radians();
            assert_eq!(degrees(radians).to_radians().to_bits(), radians.to_bits());
        }
    }
}
