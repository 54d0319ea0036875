//! Material libraries of OBJ files, read by the crate `tobj`.

mod clean;
mod convert;

use super::files::{self, Folders};
use super::obj::ObjFile;
use super::text;
use super::texture::Textures;
use crate::error::InputError;
use crate::scene::{Emission, Material};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::{Path, PathBuf};

/// The materials of an OBJ file's libraries.
#[derive(Debug, Default)]
pub(super) struct Libraries {
    /// By name: the material, and the library that it is from.
    materials: HashMap<String, (tobj::Material, PathBuf)>,
    /// Per library, what its materials say that is not shown.
    ignored: BTreeMap<PathBuf, BTreeSet<String>>,
}

impl Libraries {
    /// Reads the libraries that `obj`, the file `path`, names. Those that are not there are warned
    /// of.
    pub(super) fn read(
        obj: &ObjFile,
        path: &Path,
        folders: &Folders,
        warnings: &mut Vec<String>,
    ) -> Result<Self, InputError> {
        let mut libraries = Self::default();
        for file in Self::files(obj, path, folders) {
            match file {
                Ok(file) => libraries.add(&file, folders)?,
                Err(error) => warnings.push(format!("{error}; its materials are left out")),
            }
        }
        Ok(libraries)
    }

    /// The libraries that `obj`, the file `path`, names.
    pub(super) fn files(
        obj: &ObjFile,
        path: &Path,
        folders: &Folders,
    ) -> Vec<Result<PathBuf, InputError>> {
        let folders = folders.of_included(path);
        let of_line = |line: &String| {
            // One name with spaces, or several names.
            let error = match find(&folders, line, path, "mtllib") {
                Ok(file) => return vec![Ok(file)],
                Err(error) => error,
            };
            let words: Vec<&str> = line.split_whitespace().collect();
            match words.as_slice() {
                [_] => vec![Err(error)],
                several => several
                    .iter()
                    .map(|word| find(&folders, word, path, "mtllib"))
                    .collect(),
            }
        };
        obj.libraries.iter().flat_map(of_line).collect()
    }

    /// Whether no library with a material was found.
    pub(super) fn is_empty(&self) -> bool {
        self.materials.is_empty()
    }

    fn add(&mut self, file: &Path, folders: &Folders) -> Result<(), InputError> {
        let folders = folders.of_included(file);
        let bytes = files::read(file)?;
        let clean = clean::clean(file, &text::decode(&bytes))?;
        let (materials, _) = tobj::load_mtl_buf(&mut clean.as_bytes())
            .map_err(|e| InputError::file(file, format!("is not a readable MTL file: {e}"), ""))?;
        for material in materials {
            convert::look_up_maps(&material, file, &folders);
            let (name, entry) = (material.name.clone(), (material, file.to_path_buf()));
            // Of several of one name the first counts.
            self.materials.entry(name).or_insert(entry);
        }
        Ok(())
    }

    /// The material `name` as direkt's and what it emits; `None` where no library has it.
    pub(super) fn material(
        &mut self,
        name: &str,
        folders: &Folders,
        textures: &mut Textures,
        warnings: &mut Vec<String>,
    ) -> Option<(Material, Option<Emission>)> {
        let without_comment = || name.split_once(" #").map(|(name, _)| name.trim_end());
        let known = self.materials.get(name);
        let (material, file) = known.or_else(|| self.materials.get(without_comment()?))?;
        let mut converter = convert::Converter {
            file,
            folders: folders.of_included(file),
            textures,
            ignored: self.ignored.entry(file.clone()).or_default(),
            warnings,
        };
        Some(converter.convert(material))
    }

    /// A sentence per library about what its materials say that is not shown.
    pub(super) fn warnings(&self) -> Vec<String> {
        let with_any = self
            .ignored
            .iter()
            .filter(|(_, ignored)| !ignored.is_empty());
        let sentence = |(file, ignored): (&PathBuf, &BTreeSet<String>)| {
            let ignored: Vec<&str> = ignored.iter().map(String::as_str).collect();
            format!(
                "{}: not supported and ignored: {}",
                file.display(),
                ignored.join(", ")
            )
        };
        with_any.map(sentence).collect()
    }
}

/// The file that `field` of `file` calls `name`: as it is written, with the other kind of slashes,
/// or by its last part alone, as other machines have other folders.
fn find(folders: &Folders, name: &str, file: &Path, field: &str) -> Result<PathBuf, InputError> {
    let slashed = name.replace('\\', "/");
    let last = slashed.rsplit('/').next().unwrap_or_default();
    let first = folders.resolve(name, file, field);
    first.or_else(|error| {
        let mut others = [slashed.as_str(), last].into_iter();
        let found = others.find_map(|name| folders.resolve(name, file, field).ok());
        found.ok_or(error)
    })
}
