//! Files for the scene tests: small ones written into a temporary folder, and real ones beside the
//! checkout.

#![allow(dead_code, reason = "each test crate uses a part of it")]

use direkt::scene::Scene;
use direkt::scene::load::{LoadOptions, load};
use serde_json::{Value, json};
use std::path::PathBuf;

/// A temporary folder with scene files in it.
pub struct Folder(tempfile::TempDir);

impl Folder {
    /// An empty one.
    pub fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary folder can be made"))
    }

    /// Path of a file in it.
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes a file, with the folders it lies in.
    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        let parent = path.parent().expect("a file in a folder");
        std::fs::create_dir_all(parent).expect("a folder can be made");
        std::fs::write(&path, bytes).expect("a file can be written");
        path
    }

    /// Loads a file of it.
    pub fn load(&self, name: &str) -> Result<Scene, String> {
        self.load_with(name, &LoadOptions::default())
    }

    /// Loads a file of it; the folder is `DIR` in messages.
    pub fn load_with(&self, name: &str, options: &LoadOptions) -> Result<Scene, String> {
        load(&self.path(name), options).map_err(|e| {
            assert_eq!(e.exit_code(), 2, "bad input ends with exit code 2: {e}");
            self.anonymous(&e.to_string())
        })
    }

    /// `message` with the folder's path replaced by `DIR`.
    pub fn anonymous(&self, message: &str) -> String {
        let canonical = self.0.path().canonicalize().expect("the folder exists");
        message
            .replace(&canonical.display().to_string(), "DIR")
            .replace(&self.0.path().display().to_string(), "DIR")
    }
}

/// Loads a TOML scene given as text.
pub fn load_toml(text: &str) -> Result<Scene, String> {
    let folder = Folder::new();
    folder.write("scene.toml", text);
    folder.load("scene.toml")
}

/// The message for a TOML scene that must be refused.
pub fn refused(text: &str) -> String {
    load_toml(text).expect_err("the scene must be refused")
}

/// A glTF with one triangle (0,0,0), (1,0,0), (0,1,0) as mesh 0 with indices, shown by node 0 of
/// scene 0.
pub fn triangle_gltf() -> Value {
    let mut bytes: Vec<u8> = Vec::new();
    for x in [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
        bytes.extend(x.to_le_bytes());
    }
    for i in [0u16, 1, 2] {
        bytes.extend(i.to_le_bytes());
    }
    use base64::Engine;
    let data = base64::engine::general_purpose::STANDARD.encode(&bytes);
    json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0, "name": "triangle" }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1, "material": 0 }] }],
        "materials": [{ "name": "paint" }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" },
            { "bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR" }
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": 36 },
            { "buffer": 0, "byteOffset": 36, "byteLength": 6 }
        ],
        "buffers": [{ "byteLength": 42, "uri": format!("data:application/octet-stream;base64,{data}") }]
    })
}

/// `json` with what `pointer` names replaced by `value` (added to an object where it is not there
/// yet).
pub fn with(mut json: Value, pointer: &str, value: Value) -> Value {
    let (parent, key) = pointer.rsplit_once('/').expect("a JSON pointer");
    match json.pointer_mut(parent).expect("the parent exists") {
        Value::Object(object) => {
            object.insert(key.to_owned(), value);
        }
        Value::Array(array) => {
            let index: usize = key.parse().expect("an index");
            array[index] = value;
        }
        other => panic!("{other} has no {key}"),
    }
    json
}

/// Loads a glTF given as JSON.
pub fn load_gltf(json: &Value) -> Result<Scene, String> {
    let folder = Folder::new();
    folder.write("scene.gltf", json.to_string());
    folder.load("scene.gltf")
}

/// A GLB of a JSON chunk and a binary chunk.
pub fn glb(json: &Value, bin: &[u8]) -> Vec<u8> {
    let mut text = json.to_string().into_bytes();
    while !text.len().is_multiple_of(4) {
        text.push(b' ');
    }
    let mut bytes = b"glTF".to_vec();
    bytes.extend(2u32.to_le_bytes());
    bytes.extend((12 + 8 + text.len() as u32 + 8 + bin.len() as u32).to_le_bytes());
    bytes.extend((text.len() as u32).to_le_bytes());
    bytes.extend(b"JSON");
    bytes.extend(&text);
    bytes.extend((bin.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(bin);
    bytes
}

/// The triangle as GLB.
pub fn triangle_glb() -> Vec<u8> {
    let mut bin: Vec<u8> = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    bin.extend([0u8, 0, 1, 0, 2, 0, 0, 0]);
    let json = with(triangle_gltf(), "/buffers", json!([{ "byteLength": 42 }]));
    glb(&json, &bin)
}
