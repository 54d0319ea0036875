//! Wavefront OBJ: positions and faces; materials come from the scene file.

use super::files;
use crate::error::InputError;
use crate::scene::Mesh;
use glam::DVec3;
use std::cell::Cell;
use std::path::Path;

/// Reads an OBJ file; its objects and groups become one mesh, polygons fans of triangles.
pub(super) fn read(path: &Path, warnings: &mut Vec<String>) -> Result<Mesh, InputError> {
    let bytes = files::read(path)?;
    let options = tobj::LoadOptions {
        triangulate: true,
        ignore_points: true,
        ignore_lines: true,
        ..tobj::LoadOptions::default()
    };
    let names_materials = Cell::new(false);
    let (models, _) = tobj::load_obj_buf(&mut bytes.as_slice(), &options, |_| {
        names_materials.set(true);
        Err(tobj::LoadError::OpenFileFailed)
    })
    .map_err(|e| {
        let problem = match e {
            tobj::LoadError::FaceVertexOutOfBounds => {
                "a face names a vertex that is out of range".to_owned()
            }
            e => format!("is not a readable OBJ file: {e}"),
        };
        InputError::file(path, problem, "")
    })?;
    if names_materials.get() {
        warnings.push(format!(
            "{}: material libraries (mtllib) are ignored: a shape has the material that the scene file names",
            path.display()
        ));
    }
    let mut mesh = Mesh::default();
    for model in models {
        append(&mut mesh, &model.mesh)
            .ok_or_else(|| InputError::file(path, "has more than 2³² vertices", "fewer"))?;
    }
    if mesh.triangles.is_empty() {
        return Err(InputError::file(path, "holds no face", "a mesh"));
    }
    Ok(mesh)
}

fn append(mesh: &mut Mesh, part: &tobj::Mesh) -> Option<()> {
    let first = u32::try_from(mesh.positions.len()).ok()?;
    u32::try_from(mesh.positions.len() + part.positions.len() / 3).ok()?;
    let positions = part.positions.chunks_exact(3);
    mesh.positions
        .extend(positions.map(|p| DVec3::new(p[0], p[1], p[2])));
    let triangles = part.indices.chunks_exact(3);
    mesh.triangles
        .extend(triangles.map(|t| [first + t[0], first + t[1], first + t[2]]));
    Some(())
}
