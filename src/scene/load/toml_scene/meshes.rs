//! Shapes of type `mesh`.

use super::build::Context;
use super::format_shapes::{MeshTable, VertexColors};
use super::shapes::Part;
use crate::error::InputError;
use crate::scene::load::mesh::{self, Format};
use crate::scene::load::mtl::Libraries;
use crate::scene::load::obj::{self, ObjFile};
use crate::scene::load::texture::Textures;
use crate::scene::load::{files, vertex_colors};
use crate::scene::{Emission, Geometry, Material, MaterialId, Mesh};
use std::collections::BTreeSet;
use std::path::Path;

/// Where the materials of mesh files go.
pub(super) struct Surfaces<'a> {
    pub(super) materials: &'a mut Vec<Material>,
    pub(super) textures: &'a mut Textures,
    /// Whether the shape leaves its material to the file.
    pub(super) by_file: bool,
}

/// The meshes of the file that the shape `field` names.
pub(super) fn parts(
    context: &mut Context,
    table: &MeshTable,
    field: &str,
    surfaces: &mut Surfaces,
) -> Result<Vec<Part>, InputError> {
    let file_field = format!("{field}.file");
    let file = context
        .folders
        .resolve(&table.file, context.path, &file_field)?;
    let Some(format) = Format::of(&file) else {
        let problem = match files::extension(&file).as_str() {
            "" => format!(
                "`{}` has no extension that would tell its format",
                table.file
            ),
            extension => format!("`{}`: `.{extension}` is not a mesh format", table.file),
        };
        return Err(context.error(file_field, problem, "a mesh in .ply, .obj, .gltf or .glb"));
    };
    let mut parts = match format {
        Format::Obj => {
            let obj = obj::read(&file, &context.folders.room, &mut context.warnings)?;
            obj_parts(context, &obj, &file, surfaces)?
        }
        other => mesh::read(other, &file, context.folders, &mut context.warnings)?
            .into_iter()
            .map(|named| {
                let prefix = if named.name.is_empty() { "" } else { ": " };
                Part::new(
                    format!("{prefix}{}", named.name),
                    Geometry::Mesh(named.mesh),
                )
            })
            .collect(),
    };
    let meshes = parts
        .iter_mut()
        .filter_map(|part| match &mut part.geometry {
            Geometry::Mesh(mesh) => Some(mesh),
            _ => None,
        });
    if encode(meshes, table.vertex_colors) {
        context.warnings.push(format!(
            "{}: the alpha of its vertex colours is ignored: a material's `opacity` counts",
            file.display()
        ));
    }
    Ok(parts)
}

/// Gives vertex colours the meaning that the shape says. Returns whether some were not opaque.
fn encode<'m>(meshes: impl Iterator<Item = &'m mut Mesh>, meaning: VertexColors) -> bool {
    let mut translucent = false;
    for mesh in meshes {
        match meaning {
            VertexColors::Ignore => mesh.colors = Vec::new(),
            VertexColors::Srgb => vertex_colors::decode_srgb(&mut mesh.colors),
            VertexColors::Linear => {}
        }
        translucent |= vertex_colors::drop_alpha(mesh);
    }
    translucent
}

fn obj_parts(
    context: &mut Context,
    obj: &ObjFile,
    file: &Path,
    surfaces: &mut Surfaces,
) -> Result<Vec<Part>, InputError> {
    let warnings = &mut context.warnings;
    if !surfaces.by_file && !obj.libraries.is_empty() {
        // They are the scene's files all the same, which nothing may overwrite.
        let _ = Libraries::files(obj, file, context.folders);
        warnings.push(format!(
            "{}: material libraries (mtllib) are ignored: a shape has the material that the scene file names",
            file.display()
        ));
    }
    let mut libraries = Libraries::default();
    if surfaces.by_file {
        libraries = Libraries::read(obj, file, context.folders, warnings)?;
    }
    if libraries.is_empty() {
        let mesh = Geometry::Mesh(obj.mesh(warnings));
        return Ok(vec![Part::new(String::new(), mesh)]);
    }
    let meshes = obj.meshes_by_material(warnings);
    let single = meshes.len() == 1;
    let mut unknown = BTreeSet::new();
    let mut parts = Vec::with_capacity(meshes.len());
    for with_material in meshes {
        let name = with_material.material.unwrap_or_default();
        let suffix = if single || name.is_empty() {
            String::new()
        } else {
            format!(": {name}")
        };
        let mut part = Part::new(suffix, Geometry::Mesh(with_material.mesh));
        let known = libraries.material(&name, context.folders, surfaces.textures, warnings);
        if let Some((material, emission)) = known {
            part.set_material(surfaces.materials, material, emission, file, warnings);
        } else if !name.is_empty() {
            unknown.insert(name);
        }
        parts.push(part);
    }
    if !unknown.is_empty() {
        let names: Vec<&str> = unknown.iter().map(String::as_str).collect();
        warnings.push(format!(
            "{}: no library has the material {}: the grey of shapes without a material is used",
            file.display(),
            names.join(", ")
        ));
    }
    warnings.append(&mut libraries.warnings());
    Ok(parts)
}

impl Part {
    /// Gives the part a material of the file, of which textures are left out where the mesh has no
    /// coordinates for them.
    fn set_material(
        &mut self,
        materials: &mut Vec<Material>,
        mut material: Material,
        mut emission: Option<Emission>,
        file: &Path,
        warnings: &mut Vec<String>,
    ) {
        let bare = matches!(&self.geometry, Geometry::Mesh(mesh) if mesh.uvs.is_empty());
        let emitted = emission.as_ref().and_then(|e| e.texture);
        if bare && (material.texture_uses().next().is_some() || emitted.is_some()) {
            warnings.push(format!(
                "{}: material `{}` has textures, and its faces have no texture coordinates: its factors are used",
                file.display(),
                material.name
            ));
            material.textures = Default::default();
            material.opacity.texture = None;
            if let Some(emission) = &mut emission {
                emission.texture = None;
            }
        }
        let id = u32::try_from(materials.len()).expect("fewer than 2³² materials");
        materials.push(material);
        self.material = Some(MaterialId(id));
        self.emission = emission;
    }
}
