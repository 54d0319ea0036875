//! glTF 2.0 and GLB.
//!
//! The JSON is parsed by the crate `gltf`; every index, byte range and count in it is checked here
//! before use, so that a broken file is an error that names what is broken.

mod accessors;
mod cameras;
mod colors;
mod container;
mod coordinates;
mod document;
mod draco;
mod instances;
mod layers;
mod lights;
mod materials;
mod morph;
mod nodes;
mod parse;
mod primitives;
mod skins;
mod textures;
mod unsupported;
mod uri;

use super::files::Folders;
use super::frame;
use super::mesh::{self, NamedMesh};
use super::room::Room;
use super::transform;
use crate::error::InputError;
use crate::scene::{
    Camera, FilmSize, Geometry, Light, LightGroups, Material, MaterialId, PixelFilter,
    RenderSettings, Scene, Shape, Texture,
};
use document::Document;
use glam::DAffine3;
pub(super) use materials::FirstIds;
use materials::Materials;
use nodes::Placed;
use primitives::Primitives;
use std::path::Path;

/// What a glTF file brings into a scene.
pub(super) struct Imported {
    pub(super) shapes: Vec<Shape>,
    pub(super) materials: Vec<Material>,
    pub(super) textures: Vec<Texture>,
    pub(super) lights: Vec<Light>,
    pub(super) camera: Option<Camera>,
    pub(super) warnings: Vec<String>,
}

/// Reads a glTF or GLB file as a scene of its own; without a camera the scene is framed.
pub(super) fn load_scene(path: &Path, folders: &Folders) -> Result<Scene, InputError> {
    let imported = load_part(path, folders, &DAffine3::IDENTITY, FirstIds::default(), "")?;
    let film = FilmSize::default();
    Ok(Scene {
        source: path.to_path_buf(),
        camera: imported
            .camera
            .unwrap_or_else(|| frame::framed(&imported.shapes, &imported.materials, film).0),
        film,
        materials: imported.materials,
        textures: imported.textures,
        shapes: imported.shapes,
        lights: imported.lights,
        environment: None,
        render: RenderSettings::default(),
        expect: None,
        warnings: imported.warnings,
        filter: PixelFilter::default(),
        light_groups: LightGroups::default(),
    })
}

/// Reads the default scene of a file, moved by `placement`. Its materials and textures get the ids
/// from `first` on, and its shapes' names start with `prefix`.
pub(super) fn load_part(
    path: &Path,
    folders: &Folders,
    placement: &DAffine3,
    first: FirstIds,
    prefix: &str,
) -> Result<Imported, InputError> {
    let document = Document::read(path, folders)?;
    let placed = nodes::of_default_scene(&document)?;
    let mut materials = Materials::new(&document, first);
    let mut warnings = Vec::new();
    let shapes = shapes(
        &document,
        (&placed, &folders.room),
        placement,
        prefix,
        &mut materials,
        &mut warnings,
    )?;
    let lights = lights::all(&document, &placed, placement)?;
    let camera = cameras::first(&document, &placed, placement)?;
    let mut all_warnings = unsupported::warnings(&document, &placed, &materials);
    all_warnings.append(&mut warnings);
    let (materials, textures) = materials.into_used();
    let (textures, mut of_textures) = textures.into_parts();
    all_warnings.append(&mut of_textures);
    Ok(Imported {
        shapes,
        materials,
        textures,
        lights,
        camera,
        warnings: all_warnings,
    })
}

/// Reads the geometry of a file's default scene alone.
pub(super) fn load_meshes(
    path: &Path,
    folders: &Folders,
    warnings: &mut Vec<String>,
) -> Result<Vec<NamedMesh>, InputError> {
    let document = Document::read(path, folders)?;
    let placed = nodes::of_default_scene(&document)?;
    let mut primitives = Primitives::new(&document, &placed, &folders.room)?;
    let mut meshes = Vec::new();
    for node in &placed {
        for instance in primitives.of_node(node, &DAffine3::IDENTITY, warnings)? {
            meshes.push(NamedMesh {
                name: instance.name,
                mesh: instance.mesh,
            });
        }
    }
    warnings.append(&mut unsupported::geometry_warnings(&document, &placed));
    Ok(meshes)
}

fn shapes(
    document: &Document,
    (placed, room): (&[Placed], &Room),
    placement: &DAffine3,
    prefix: &str,
    materials: &mut Materials,
    warnings: &mut Vec<String>,
) -> Result<Vec<Shape>, InputError> {
    let mut primitives = Primitives::new(document, placed, room)?;
    let mut shapes = Vec::new();
    let mut dropped = 0;
    for node in placed {
        for mut instance in primitives.of_node(node, placement, warnings)? {
            dropped += mesh::clean(&mut instance.mesh);
            if instance.mesh.triangles.is_empty() {
                continue;
            }
            let (material, emission): (MaterialId, _) =
                materials.use_material(instance.material, instance.sets, &instance.field)?;
            shapes.push(Shape {
                name: format!("{prefix}{}", instance.name),
                geometry: Geometry::Mesh(instance.mesh),
                material,
                emission,
            });
        }
    }
    if dropped > 0 {
        warnings.push(mesh::dropped_warning(&document.file_name(), dropped));
    }
    Ok(shapes)
}

/// The error for a transform of a node that cannot be applied.
fn transform_error(
    document: &Document,
    node: &Placed,
    problem: &transform::TransformProblem,
) -> InputError {
    let (problem, expected) = problem.describe();
    document.error(format!("nodes[{}]", node.index), problem, expected)
}
