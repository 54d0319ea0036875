//! Reads a scene file (TOML, glTF, GLB) and everything it names.
//!
//! Each file format lives in a module of its own; all of them end in the same [`Scene`], in world
//! space and f64, validated. What a file asks for and direkt does not do becomes one sentence in
//! [`Scene::warnings`].

mod chromaticities;
mod cutoff;
mod decode;
mod exr;
mod files;
mod fold;
mod frame;
mod gltf_scene;
mod image;
mod mesh;
mod mtl;
mod obj;
mod ply;
mod polygon;
mod radiance;
mod room;
mod text;
mod texture;
mod toml_scene;
mod transform;
mod vertex_colors;
mod warnings;

use super::{Scene, validate};
use crate::error::{Error, InputError, readable};
use files::Folders;
pub use room::Capacity;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// How a scene file is read.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct LoadOptions {
    /// Further folders in which the files that a scene names are looked up, after the scene's own.
    pub assets: Vec<PathBuf>,
    /// Most triangles that are worth reading; where there are more, that is said before they are
    /// read.
    pub capacity: Option<Capacity>,
}

/// Reads the scene in `path` (`.toml`, `.gltf` or `.glb`) with every file it names, and validates
/// it.
///
/// # Errors
/// [`Error::Input`] names the file, the field in it, what is wrong there and what would be right.
pub fn load(path: &Path, options: &LoadOptions) -> Result<Scene, Error> {
    load_with_files(path, options).0
}

/// The same, and every file that it was read from, as far as it came where it fails.
pub fn load_with_files(
    path: &Path,
    options: &LoadOptions,
) -> (Result<Scene, Error>, BTreeSet<PathBuf>) {
    let mut files = BTreeSet::from([path.to_path_buf()]);
    let folders = match Folders::of_scene(path, options) {
        Ok(folders) => folders,
        Err(error) => return (Err(error.into()), files),
    };
    let scene = load_from(path, &folders, options);
    files.extend(folders.found());
    (scene, files)
}

fn load_from(path: &Path, folders: &Folders, options: &LoadOptions) -> Result<Scene, Error> {
    let extension = files::extension(path);
    let mut scene = match extension.as_str() {
        "toml" => toml_scene::load(path, folders)?,
        "gltf" | "glb" => gltf_scene::load_scene(path, folders)?,
        _ => {
            return Err(InputError::file(
                path,
                if extension.is_empty() {
                    "the name has no extension that would tell the format".to_owned()
                } else {
                    format!("`.{extension}` is not a scene format")
                },
                "a scene in .toml, .gltf or .glb",
            )
            .into());
        }
    };
    room::check(&scene, options.capacity.as_ref())?;
    validate_and_fold(&mut scene)?;
    let mut warnings = warnings::general(&scene);
    scene.warnings.append(&mut warnings);
    for warning in &mut scene.warnings {
        *warning = readable(warning);
    }
    Ok(scene)
}

/// Validates `scene`, and leaves out of it what makes no difference or has no meaning, which
/// [`Scene::warnings`] tells.
///
/// # Errors
/// A number is out of its domain.
pub fn validate_and_fold(scene: &mut Scene) -> Result<(), Error> {
    validate::validate(scene)?;
    vertex_colors::drop_on_metals(scene);
    let mut folded = fold::fold_constant(&mut scene.materials, &scene.textures);
    scene.warnings.append(&mut folded);
    vertex_colors::fold_opacity(scene);
    fold::fold_constant_emission(&mut scene.shapes, &scene.textures);
    Ok(())
}

/// The JSON Schema of the TOML scene format, for editors.
pub fn schema() -> String {
    toml_scene::schema()
}
