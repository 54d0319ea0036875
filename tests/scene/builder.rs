//! Small GLB files, made accessor by accessor.

use super::files::{Folder, glb};
use direkt::scene::{Geometry, Mesh, Scene};
use glam::DVec3;
use serde_json::{Value, json};

/// A glTF in the making: JSON whose lists are still open, and the bytes of buffer 0.
pub struct Builder {
    pub json: Value,
    pub bin: Vec<u8>,
}

/// Little-endian bytes of numbers.
pub fn bytes<const N: usize, T: Copy>(numbers: &[T], of: fn(T) -> [u8; N]) -> Vec<u8> {
    numbers.iter().flat_map(|&x| of(x)).collect()
}

impl Builder {
    /// Scene 0 without nodes.
    pub fn new() -> Self {
        Self {
            json: json!({
                "asset": { "version": "2.0" },
                "scene": 0,
                "scenes": [{ "nodes": [] }],
                "nodes": [], "meshes": [], "accessors": [], "bufferViews": []
            }),
            bin: Vec::new(),
        }
    }

    /// Adds to a list and returns the place there.
    pub fn add(&mut self, list: &str, value: Value) -> usize {
        let entry = &mut self.json[list];
        if entry.is_null() {
            *entry = json!([]);
        }
        let list = entry.as_array_mut().expect("a list");
        list.push(value);
        list.len() - 1
    }

    /// Adds bytes to the buffer and a view of them.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        let offset = self.bin.len();
        self.bin.extend(bytes);
        while !self.bin.len().is_multiple_of(4) {
            self.bin.push(0xee);
        }
        let view = json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() });
        self.add("bufferViews", view)
    }

    /// An accessor of bytes that lie closely.
    pub fn accessor(&mut self, component: u32, kind: &str, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        let accessor = json!({
            "bufferView": view, "componentType": component, "type": kind, "count": count
        });
        self.add("accessors", accessor)
    }

    /// An accessor of floats.
    pub fn floats<const N: usize>(&mut self, elements: &[[f32; N]]) -> usize {
        let kind = match N {
            1 => "SCALAR",
            2 => "VEC2",
            3 => "VEC3",
            4 => "VEC4",
            16 => "MAT4",
            _ => panic!("no type has {N} components"),
        };
        let bytes = bytes(elements.as_flattened(), f32::to_le_bytes);
        self.accessor(5126, kind, elements.len(), &bytes)
    }

    /// Gives an object of a list the members of `overlay` as well.
    pub fn amend(&mut self, list: &str, index: usize, overlay: Value) {
        let members = self.json[list][index].as_object_mut().expect("an object");
        members.extend(overlay.as_object().expect("an object").clone());
    }

    /// A mesh of one primitive.
    pub fn mesh(&mut self, primitive: Value) -> usize {
        self.add("meshes", json!({ "primitives": [primitive] }))
    }

    /// A node, which is one of the scene's.
    pub fn root(&mut self, node: Value) -> usize {
        let index = self.add("nodes", node);
        let roots = self.json["scenes"][0]["nodes"].as_array_mut();
        roots.expect("a list").push(json!(index));
        index
    }

    /// The file.
    pub fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        if !self.bin.is_empty() {
            json["buffers"] = json!([{ "byteLength": self.bin.len() }]);
        }
        let lists = json.as_object_mut().expect("an object");
        lists.retain(|_, list| list.as_array().is_none_or(|l| !l.is_empty()));
        glb(&json, &self.bin)
    }

    /// The scene, or the message that refuses it.
    pub fn load(&self) -> Result<Scene, String> {
        let folder = Folder::new();
        folder.write("scene.glb", self.glb());
        folder.load("scene.glb")
    }

    /// The scene.
    #[track_caller]
    pub fn scene(&self) -> Scene {
        self.load().unwrap_or_else(|e| panic!("{e}"))
    }

    /// The message that refuses it.
    #[track_caller]
    pub fn refused(&self) -> String {
        self.load().expect_err("it must be refused")
    }
}

/// The mesh of a shape.
#[track_caller]
pub fn mesh_of(scene: &Scene, shape: usize) -> &Mesh {
    match &scene.shapes[shape].geometry {
        Geometry::Mesh(mesh) => mesh,
        other => panic!("{other:?} is no mesh"),
    }
}

/// The corners of all triangles of a shape.
#[track_caller]
pub fn triangles_of(scene: &Scene, shape: usize) -> Vec<[DVec3; 3]> {
    let mesh = mesh_of(scene, shape);
    let corner = |i: u32| mesh.positions[i as usize];
    mesh.triangles.iter().map(|t| t.map(corner)).collect()
}

/// (0, 0, 0), (1, 0, 0), (0, 1, 0).
pub const TRIANGLE: [[f32; 3]; 3] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

/// [`TRIANGLE`] as the scene has it.
pub const CORNERS: [DVec3; 3] = [DVec3::ZERO, DVec3::X, DVec3::Y];
