//! The TOML scene format: what a file may say is in [`mod@format`], [`format_materials`] and
//! [`format_shapes`], how its text becomes those types in [`parse`], and what they mean in
//! [`build`], [`mod@materials`] and [`shapes`].

mod build;
mod camera;
mod expect;
mod format;
mod format_materials;
mod format_shapes;
mod format_textures;
mod lights;
mod materials;
mod meshes;
mod parse;
mod shapes;
mod textures;

use super::files::{self, Folders};
use crate::error::InputError;
use crate::scene::Scene;
use std::path::Path;

/// Reads a TOML scene and every file it names.
pub(super) fn load(path: &Path, folders: &Folders) -> Result<Scene, InputError> {
    let bytes = files::read(path)?;
    let text = std::str::from_utf8(&bytes)
        .map_err(|e| InputError::file(path, format!("is not UTF-8: {e}"), "a text file"))?;
    let file = parse::parse(path, text)?;
    build::scene(path, folders, file)
}

/// The JSON Schema of the format.
pub(super) fn schema() -> String {
    let schema = schemars::schema_for!(format::SceneFile);
    let mut text = serde_json::to_string_pretty(&schema).expect("a schema is JSON");
    text.push('\n');
    text
}
