//! The container: JSON, its buffers, and checked access by index.

use super::container;
use super::draco::DracoMeshes;
use super::parse::{self, Parsed};
use super::uri::{self, Uri};
use crate::error::InputError;
use crate::scene::load::files::{self, Folders};
use gltf::json;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Extensions that are read; all others are named in a warning, or refused where the file requires
/// them.
pub(super) const SUPPORTED_EXTENSIONS: [&str; 14] = [
    "EXT_mesh_gpu_instancing",
    "EXT_texture_webp",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_node_visibility",
    "KHR_texture_transform",
];

/// A glTF file: its parsed JSON, and its buffers' bytes.
pub(super) struct Document {
    path: PathBuf,
    pub(super) root: json::Root,
    /// Names of the extensions that its objects carry.
    extensions: BTreeSet<String>,
    /// What its morph targets displace and nobody reads.
    pub(super) unread_morphs: BTreeSet<String>,
    /// `None` for a buffer without data of its own.
    buffers: Vec<Option<Vec<u8>>>,
    /// Meshes that stand for the data of accessors.
    pub(super) draco: DracoMeshes,
    /// Where the files that it names are looked up.
    folders: Folders,
}

impl Document {
    /// Reads the file and its buffers.
    pub(super) fn read(path: &Path, folders: &Folders) -> Result<Self, InputError> {
        let bytes = files::read(path)?;
        let (text, chunk) = container::split(path, &bytes)?;
        let Parsed {
            root,
            extensions,
            unread_morphs,
        } = parse::parse(path, text)?;
        let mut document = Self {
            path: path.to_path_buf(),
            root,
            extensions,
            unread_morphs,
            buffers: Vec::new(),
            draco: DracoMeshes::default(),
            folders: match std::fs::canonicalize(path) {
                Ok(canonical) => folders.of_included(&canonical),
                Err(_) => folders.clone(),
            },
        };
        document.check_version_and_extensions()?;
        for index in 0..document.root.buffers.len() {
            let data = document.read_buffer(index, chunk)?;
            document.buffers.push(data);
        }
        document.look_up_images();
        document.draco = DracoMeshes::new(&document)?;
        Ok(document)
    }

    /// The file.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// The file's name without its folder, for warnings.
    pub(super) fn file_name(&self) -> String {
        self.path
            .file_name()
            .unwrap_or(self.path.as_os_str())
            .to_string_lossy()
            .into_owned()
    }

    /// Names of the extensions that the file uses and direkt does not read, whether the file
    /// declares them or not.
    pub(super) fn unsupported_extensions(&self) -> Vec<&str> {
        let declared = &self.root.extensions_used;
        let undeclared = self.extensions.iter().filter(|e| !declared.contains(e));
        let all = declared.iter().chain(undeclared).map(String::as_str);
        let mut unsupported = Vec::new();
        for extension in all.filter(|e| !SUPPORTED_EXTENSIONS.contains(e)) {
            if !unsupported.contains(&extension) {
                unsupported.push(extension);
            }
        }
        unsupported
    }

    /// An error about `field`.
    pub(super) fn error(
        &self,
        field: impl Into<String>,
        problem: impl Into<String>,
        expected: impl Into<String>,
    ) -> InputError {
        InputError::new(&self.path, field, problem, expected)
    }

    /// `list[index]`, or the error that names `field`, the number and what `kind` of thing there
    /// are how many of.
    pub(super) fn get<'a, T>(
        &self,
        list: &'a [T],
        index: usize,
        kind: &str,
        field: impl FnOnce() -> String,
    ) -> Result<&'a T, InputError> {
        list.get(index).ok_or_else(|| {
            self.error(
                field(),
                format!("{kind} {index} is out of range"),
                match list.len() {
                    0 => format!("no reference: the file has no {kind}"),
                    1 => "0, the only one".to_owned(),
                    n => format!("0 to {}", n - 1),
                },
            )
        })
    }

    /// The bytes of buffer view `index`, which `field` refers to.
    pub(super) fn view(
        &self,
        index: usize,
        field: impl FnOnce() -> String,
    ) -> Result<(&[u8], Option<usize>), InputError> {
        let view = self.get(&self.root.buffer_views, index, "bufferView", field)?;
        let name = || format!("bufferViews[{index}]");
        let buffer = view.buffer.value();
        let data = self
            .get(&self.buffers, buffer, "buffer", || name() + ".buffer")?
            .as_deref()
            .ok_or_else(|| {
                self.error(
                    format!("buffers[{buffer}]"),
                    "has neither a uri nor GLB data",
                    "data",
                )
            })?;
        let offset = view.byte_offset.map_or(0, |o| o.0);
        let bytes = slice(data, offset, view.byte_length.0).ok_or_else(|| {
            self.error(
                name(),
                format!(
                    "byteOffset {offset} and byteLength {} end outside buffer {buffer}",
                    view.byte_length.0
                ),
                format!("a range within its {} bytes", data.len()),
            )
        })?;
        Ok((bytes, view.byte_stride.map(|s| s.0)))
    }

    /// The encoded bytes of image `index`.
    pub(super) fn image(&self, index: usize, image: &json::Image) -> Result<Vec<u8>, InputError> {
        let field = format!("images[{index}]");
        match (&image.uri, image.buffer_view) {
            (Some(uri), _) => self.read_uri(uri, &format!("{field}.uri")),
            (None, Some(view)) => {
                let (bytes, _) = self.view(view.value(), || format!("{field}.bufferView"))?;
                Ok(bytes.to_vec())
            }
            (None, None) => {
                Err(self.error(field, "has neither a uri nor a bufferView", "an image"))
            }
        }
    }

    /// What messages call it: its file, or its number in this one.
    pub(super) fn image_name(&self, index: usize, image: &json::Image) -> PathBuf {
        match &image.uri {
            Some(name) if !matches!(uri::kind(name), Uri::Data(_)) => {
                self.path.with_file_name(uri::decoded_name(name))
            }
            _ => PathBuf::from(format!("{}: images[{index}]", self.path.display())),
        }
    }

    fn check_version_and_extensions(&self) -> Result<(), InputError> {
        if !self.root.asset.version.starts_with("2.") {
            return Err(self.error(
                "asset.version",
                format!("is `{}`", self.root.asset.version),
                "2.0",
            ));
        }
        let missing: Vec<&str> = self
            .root
            .extensions_required
            .iter()
            .map(String::as_str)
            .filter(|e| !SUPPORTED_EXTENSIONS.contains(e))
            .collect();
        if missing.is_empty() {
            Ok(())
        } else {
            Err(self.error(
                "extensionsRequired",
                format!("the file cannot be shown without {}", missing.join(", ")),
                format!("no more than {}", SUPPORTED_EXTENSIONS.join(", ")),
            ))
        }
    }

    fn read_buffer(
        &self,
        index: usize,
        chunk: Option<&[u8]>,
    ) -> Result<Option<Vec<u8>>, InputError> {
        let buffer = &self.root.buffers[index];
        let field = format!("buffers[{index}]");
        let mut data = match (&buffer.uri, chunk) {
            (Some(uri), _) => self.read_uri(uri, &format!("{field}.uri"))?,
            (None, Some(chunk)) if index == 0 => chunk.to_vec(),
            (None, _) => return Ok(None),
        };
        let length = usize::try_from(buffer.byte_length.0).unwrap_or(usize::MAX);
        if data.len() < length {
            return Err(self.error(
                format!("{field}.byteLength"),
                format!("is {length}, but there are only {} bytes", data.len()),
                "the whole buffer (is the file truncated?)",
            ));
        }
        data.truncate(length);
        Ok(Some(data))
    }

    /// Looks up the images, so that they count as the scene's files whether they are shown or not.
    fn look_up_images(&self) {
        let uris = self.root.images.iter().filter_map(|i| i.uri.as_deref());
        for uri in uris.filter(|uri| matches!(uri::kind(uri), Uri::Name)) {
            let mut names = uri::file_names(uri).into_iter();
            // What is missing is told where it is shown.
            let _ = names.find_map(|name| self.folders.resolve(&name, &self.path, "images").ok());
        }
    }

    fn read_uri(&self, uri: &str, field: &str) -> Result<Vec<u8>, InputError> {
        match uri::kind(uri) {
            Uri::Data(data) => uri::data(data).map_err(|problem| self.error(field, problem, "")),
            Uri::Address => Err(self.error(
                field,
                format!("`{uri}` is on the network"),
                "a file in the glTF's folder",
            )),
            Uri::Name => {
                let mut first_error = None;
                for name in uri::file_names(uri) {
                    match self.folders.resolve(&name, &self.path, field) {
                        Ok(file) => return files::read(&file),
                        Err(error) => first_error = first_error.or(Some(error)),
                    }
                }
                Err(first_error.expect("a URI stands for one name at least"))
            }
        }
    }
}

/// `data[offset..offset + length]`, or `None` outside of it.
pub(super) fn slice(data: &[u8], offset: u64, length: u64) -> Option<&[u8]> {
    let start = usize::try_from(offset).ok()?;
    let end = usize::try_from(offset.checked_add(length)?).ok()?;
    data.get(start..end)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slices_outside_are_none() {
        let data = [0u8; 8];
        assert_eq!(slice(&data, 4, 4).map(<[u8]>::len), Some(4));
        assert_eq!(slice(&data, 4, 5), None);
        assert_eq!(slice(&data, u64::MAX, 2), None);
    }
}
