//! Mesh files, and what makes the triangles of any of them fit to be rendered.

use super::files::{self, Folders};
use super::{gltf_scene, obj, ply};
use crate::error::InputError;
use crate::scene::Mesh;
use std::path::Path;

/// One mesh of a file: PLY and OBJ hold one, glTF one for every primitive instance.
pub(super) struct NamedMesh {
    /// Which of the file's meshes; empty when there is only one.
    pub(super) name: String,
    /// Its triangles, as the file has them.
    pub(super) mesh: Mesh,
}

/// A format of meshes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Format {
    /// Stanford PLY.
    Ply,
    /// Wavefront OBJ.
    Obj,
    /// glTF and GLB.
    Gltf,
}

impl Format {
    /// The format that the extension of `path` tells.
    pub(super) fn of(path: &Path) -> Option<Self> {
        match files::extension(path).as_str() {
            "ply" => Some(Self::Ply),
            "obj" => Some(Self::Obj),
            "gltf" | "glb" => Some(Self::Gltf),
            _ => None,
        }
    }
}

/// Reads the geometry of a file; what it holds besides goes to `warnings`.
pub(super) fn read(
    format: Format,
    path: &Path,
    folders: &Folders,
    warnings: &mut Vec<String>,
) -> Result<Vec<NamedMesh>, InputError> {
    let mesh = match format {
        Format::Ply => ply::read(path, &folders.room, warnings)?,
        Format::Obj => obj::read(path, &folders.room, warnings)?.mesh(warnings),
        Format::Gltf => return gltf_scene::load_meshes(path, folders, warnings),
    };
    let name = String::new();
    Ok(vec![NamedMesh { name, mesh }])
}

/// Drops triangles without area or with a vertex that is not finite, and vertices that no triangle
/// uses (they would stretch the bounding box). Returns the number of dropped triangles.
pub(super) fn clean(mesh: &mut Mesh) -> usize {
    let before = mesh.triangles.len();
    let positions = &mesh.positions;
    mesh.triangles
        .retain(|t| has_area(t.map(|i| positions[i as usize])));
    compact(mesh);
    before - mesh.triangles.len()
}

/// The sentence for `dropped` triangles of `name`.
pub(super) fn dropped_warning(name: &str, dropped: usize) -> String {
    format!(
        "{name}: {dropped} degenerate {} dropped (no area, or a vertex that is not finite)",
        if dropped == 1 {
            "triangle was"
        } else {
            "triangles were"
        }
    )
}

/// Whether a triangle is finite and its area is above what rounding in f64 makes of a collinear
/// one.
fn has_area([a, b, c]: [glam::DVec3; 3]) -> bool {
    let (ab, ac, bc) = (b - a, c - a, c - b);
    let longest_squared = ab
        .length_squared()
        .max(ac.length_squared())
        .max(bc.length_squared());
    // Divided first, so that tiny and huge triangles neither underflow nor overflow. False for NaN.
    let longest = longest_squared.sqrt();
    longest.is_finite() && (ab / longest).cross(ac / longest).length() > 1e-14
}

fn compact(mesh: &mut Mesh) {
    const UNUSED: u32 = u32::MAX;
    let mut new_index = vec![UNUSED; mesh.positions.len()];
    for t in &mesh.triangles {
        for &i in t {
            new_index[i as usize] = 0;
        }
    }
    if !new_index.contains(&UNUSED) {
        return;
    }
    let kept = new_index.iter_mut().filter(|index| **index != UNUSED);
    for (index, next) in kept.zip(0..) {
        *index = next;
    }
    for t in &mut mesh.triangles {
        *t = t.map(|i| new_index[i as usize]);
    }
    let used = |i: &mut usize| {
        let used = new_index[*i] != UNUSED;
        *i += 1;
        used
    };
    let mut at = [0; 6];
    mesh.positions.retain(|_| used(&mut at[0]));
    mesh.normals.retain(|_| used(&mut at[1]));
    mesh.uvs.retain(|_| used(&mut at[2]));
    mesh.colors.retain(|_| used(&mut at[3]));
    mesh.second_uvs.retain(|_| used(&mut at[4]));
    mesh.tangents.retain(|_| used(&mut at[5]));
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn degenerate_triangles_and_their_vertices_go() {
        let mut mesh = Mesh {
            positions: vec![
                DVec3::new(f64::NAN, 0.0, 0.0),
                DVec3::ZERO,
                DVec3::X,
                DVec3::Y,
                DVec3::splat(0.1),
                DVec3::splat(0.3),
                DVec3::splat(f64::INFINITY),
            ],
            triangles: vec![[0, 1, 2], [1, 2, 3], [1, 4, 5], [1, 1, 2], [1, 2, 6]],
            ..Mesh::default()
        };
        assert_eq!(clean(&mut mesh), 4);
        assert_eq!(mesh.positions, [DVec3::ZERO, DVec3::X, DVec3::Y]);
        assert_eq!(mesh.triangles, [[0, 1, 2]]);
    }

    #[test]
    fn tiny_and_huge_triangles_stay() {
        for scale in [1e-200, 1e-20, 1.0, 1e20, 1e150] {
            let mut mesh = Mesh {
                positions: vec![DVec3::ZERO, DVec3::X * scale, DVec3::Y * scale],
                triangles: vec![[0, 1, 2]],
                ..Mesh::default()
            };
            let expected = usize::from(scale < 1e-160);
            assert_eq!(clean(&mut mesh), expected, "{scale}");
        }
    }
}
