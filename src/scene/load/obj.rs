//! Wavefront OBJ: positions, normals, texture coordinates, vertex colours and faces, with the names
//! of their materials.

mod statements;

use super::files;
use super::polygon::Triangulator;
use super::room::Room;
use super::text;
use super::vertex_colors;
use crate::error::InputError;
use crate::scene::Mesh;
use glam::{DVec2, DVec3, Vec4};
use statements::Reader;
use std::collections::HashMap;
use std::path::Path;

/// Bytes of the shortest line of a face: `f 1 2 3` and its end.
const SHORTEST_FACE: usize = 8;
/// Stands for an attribute that a corner does not have.
const NONE: u32 = u32::MAX;

/// What an OBJ file holds; corners are indices into its positions, texture coordinates and normals.
#[derive(Debug, Default)]
pub(super) struct ObjFile {
    name: String,
    positions: Vec<DVec3>,
    /// One per position, or none.
    colors: Vec<Vec4>,
    uvs: Vec<DVec2>,
    normals: Vec<DVec3>,
    corners: Vec<[u32; 3]>,
    /// Where the corners of each face end.
    ends: Vec<u32>,
    /// From which face on which of `materials` is used.
    runs: Vec<(usize, Option<usize>)>,
    /// Names by `usemtl`, in the order of their first use.
    materials: Vec<String>,
    /// Material libraries, each as the line that names it.
    pub(super) libraries: Vec<String>,
}

/// The faces of one material.
pub(super) struct MaterialMesh {
    /// Its name, where `usemtl` gives one.
    pub(super) material: Option<String>,
    /// Their triangles.
    pub(super) mesh: Mesh,
}

/// Reads an OBJ file; what it holds besides goes to `warnings`.
pub(super) fn read(
    path: &Path,
    room: &Room,
    warnings: &mut Vec<String>,
) -> Result<ObjFile, InputError> {
    let bytes = files::read(path)?;
    if room.may_lack((bytes.len() / SHORTEST_FACE) as u64) {
        room.take(path, "f", faces(&bytes))?;
    }
    let mut reader = Reader::new(path);
    reader.read(&text::decode(&bytes))?;
    let file = reader.finish(warnings)?;
    if file.ends.is_empty() {
        return Err(InputError::file(path, "holds no face", "a mesh"));
    }
    Ok(file)
}

/// Lines of `bytes` that begin a face.
fn faces(bytes: &[u8]) -> u64 {
    let lines = bytes.split(|&b| b == b'\n');
    lines.filter(|line| line.starts_with(b"f ")).count() as u64
}

impl ObjFile {
    /// All faces as one mesh, in their order.
    pub(super) fn mesh(&self, warnings: &mut Vec<String>) -> Mesh {
        let mut builder = Builder::new(self);
        for face in 0..self.ends.len() {
            builder.add(face);
        }
        let mut triangulator = Triangulator::default();
        let mesh = builder.into_mesh(&mut triangulator);
        warnings.append(&mut triangulator.warnings(&self.name));
        mesh
    }

    /// A mesh per material, in the order in which faces use them first.
    pub(super) fn meshes_by_material(&self, warnings: &mut Vec<String>) -> Vec<MaterialMesh> {
        let mut builders: Vec<(Option<usize>, Builder)> = Vec::new();
        let ends = self.runs.iter().skip(1).map(|(first, _)| *first);
        let ends = ends.chain([self.ends.len()]);
        for ((first, material), end) in self.runs.iter().zip(ends) {
            if *first == end {
                continue;
            }
            let known = builders.iter().position(|(of, _)| of == material);
            let place = known.unwrap_or_else(|| {
                builders.push((*material, Builder::new(self)));
                builders.len() - 1
            });
            for face in *first..end {
                builders[place].1.add(face);
            }
        }
        let mut triangulator = Triangulator::default();
        let meshes = builders
            .into_iter()
            .map(|(material, builder)| MaterialMesh {
                material: material.map(|index| self.materials[index].clone()),
                mesh: builder.into_mesh(&mut triangulator),
            });
        let meshes = meshes.collect();
        warnings.append(&mut triangulator.warnings(&self.name));
        meshes
    }
}

/// Makes a mesh, whose vertices have one index, of faces whose corners have three.
struct Builder<'a> {
    file: &'a ObjFile,
    known: HashMap<[u32; 3], u32>,
    vertices: Vec<[u32; 3]>,
    corners: Vec<u32>,
    ends: Vec<usize>,
}

impl<'a> Builder<'a> {
    fn new(file: &'a ObjFile) -> Self {
        Self {
            file,
            known: HashMap::new(),
            vertices: Vec::new(),
            corners: Vec::new(),
            ends: Vec::new(),
        }
    }

    fn add(&mut self, face: usize) {
        let start = face
            .checked_sub(1)
            .map_or(0, |before| self.file.ends[before]);
        for corner in &self.file.corners[start as usize..self.file.ends[face] as usize] {
            let vertex = *self.known.entry(*corner).or_insert_with(|| {
                self.vertices.push(*corner);
                self.vertices.len() as u32 - 1
            });
            self.corners.push(vertex);
        }
        self.ends.push(self.corners.len());
    }

    fn into_mesh(self, triangulator: &mut Triangulator) -> Mesh {
        let Self {
            file,
            vertices,
            corners,
            ends,
            ..
        } = self;
        let positions = vertices.iter().map(|[v, ..]| file.positions[*v as usize]);
        let mut mesh = Mesh {
            positions: positions.collect(),
            uvs: attribute(&vertices, 1, &file.uvs, DVec2::NAN),
            normals: attribute(&vertices, 2, &file.normals, DVec3::ZERO),
            ..Mesh::default()
        };
        if !file.colors.is_empty() {
            let colors = vertices.iter().map(|[v, ..]| file.colors[*v as usize]);
            mesh.colors = vertex_colors::unless_white(colors.collect());
        }
        let mut start = 0;
        for end in ends {
            triangulator.add(&corners[start..end], &mesh.positions, &mut mesh.triangles);
            start = end;
        }
        mesh
    }
}

/// What `vertices` have of `all` by the index `which`, `missing` where they have none; empty where
/// none has any.
fn attribute<T: Copy>(vertices: &[[u32; 3]], which: usize, all: &[T], missing: T) -> Vec<T> {
    if vertices.iter().all(|vertex| vertex[which] == NONE) {
        return Vec::new();
    }
    let of_vertex = |vertex: &[u32; 3]| match vertex[which] {
        NONE => missing,
        index => all[index as usize],
    };
    vertices.iter().map(of_vertex).collect()
}
