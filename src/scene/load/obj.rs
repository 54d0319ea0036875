//! Wavefront OBJ: positions, normals, texture coordinates and faces; materials come from the scene file.

use super::files;
use crate::error::InputError;
use crate::scene::Mesh;
use glam::{DVec2, DVec3};
use std::cell::Cell;
use std::path::Path;

/// Reads an OBJ file; its objects and groups become one mesh, polygons fans of triangles.
pub(super) fn read(path: &Path, warnings: &mut Vec<String>) -> Result<Mesh, InputError> {
    let bytes = files::read(path)?;
    let options = tobj::LoadOptions {
        triangulate: true,
        single_index: true,
        ignore_points: true,
        ignore_lines: true,
    };
    let names_materials = Cell::new(false);
    let mut rest = bytes.as_slice();
    let loaded = tobj::load_obj_buf(&mut rest, &options, |_| {
        names_materials.set(true);
        Err(tobj::LoadError::OpenFileFailed)
    });
    let read = &bytes[..bytes.len() - rest.len()];
    let (models, _) = loaded.map_err(|e| refusal(path, read, &e))?;
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

/// The error about the last line of `read`; an index that is out of range comes up only when its object ends.
fn refusal(path: &Path, read: &[u8], error: &tobj::LoadError) -> InputError {
    use tobj::LoadError;
    let lines = || read.split(|b| *b == b'\n');
    let out_of_range = |what: &str, keyword: &[u8]| {
        let count = lines()
            .filter(|line| line.trim_ascii_start().starts_with(keyword))
            .count();
        InputError::file(
            path,
            format!("a face names a {what} that is out of range"),
            match count {
                0 => "no index: there is none so far".to_owned(),
                n => format!("1 to {n}, or -{n} to -1 (there are {n} so far)"),
            },
        )
    };
    let expected = match error {
        LoadError::FaceVertexOutOfBounds => return out_of_range("vertex", b"v "),
        LoadError::FaceTexCoordOutOfBounds => return out_of_range("texture coordinate", b"vt "),
        LoadError::FaceNormalOutOfBounds => return out_of_range("normal", b"vn "),
        LoadError::FaceColorOutOfBounds => {
            let problem = "some vertices have a colour and some have none";
            return InputError::file(path, problem, "a colour for each vertex, or for none");
        }
        LoadError::PositionParseError => "`v` and three numbers",
        LoadError::ColorParseError => "`v` and three numbers, and three for a colour",
        LoadError::NormalParseError => "`vn` and three numbers",
        LoadError::TexcoordParseError => "`vt` and two numbers",
        LoadError::FaceParseError => "`f` and indices such as 1, 1/2, 1//3 or 1/2/3",
        LoadError::ReadError => "text in UTF-8",
        _ => "an OBJ file",
    };
    let read = read.strip_suffix(b"\n").unwrap_or(read);
    let line = read.rsplit(|b| *b == b'\n').next().unwrap_or_default();
    InputError::new(
        path,
        format!("line {}", 1 + read.iter().filter(|b| **b == b'\n').count()),
        format!("is `{}`", String::from_utf8_lossy(line.trim_ascii())),
        expected,
    )
}

fn append(mesh: &mut Mesh, part: &tobj::Mesh) -> Option<()> {
    let first = u32::try_from(mesh.positions.len()).ok()?;
    u32::try_from(mesh.positions.len() + part.positions.len() / 3).ok()?;
    let vectors = |numbers: &[f64]| -> Vec<DVec3> {
        let vectors = numbers.chunks_exact(3);
        vectors.map(|p| DVec3::new(p[0], p[1], p[2])).collect()
    };
    let pairs = part.texcoords.chunks_exact(2);
    // The file's v points up.
    let uvs = pairs.map(|p| DVec2::new(p[0], 1.0 - p[1])).collect();
    let before = mesh.positions.len();
    let positions = vectors(&part.positions);
    let count = positions.len();
    append_attributes(&mut mesh.normals, vectors(&part.normals), before, count);
    append_attributes(&mut mesh.uvs, uvs, before, count);
    mesh.positions.extend(positions);
    let triangles = part.indices.chunks_exact(3);
    mesh.triangles
        .extend(triangles.map(|t| [first + t[0], first + t[1], first + t[2]]));
    Some(())
}

/// Appends what `count` further vertices have; where only some of a file's objects have it, the others have zeros.
fn append_attributes<T: Default + Clone>(
    all: &mut Vec<T>,
    part: Vec<T>,
    before: usize,
    count: usize,
) {
    if all.is_empty() && part.is_empty() {
        return;
    }
    all.resize(before, T::default());
    all.extend(part);
    all.resize(before + count, T::default());
}
