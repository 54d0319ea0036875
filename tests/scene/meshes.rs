//! PLY and OBJ files.

use super::files::Folder;
use crate::support::shared;
use direkt::scene::load::{LoadOptions, load, load_with_files};
use direkt::scene::{Geometry, Mesh, Scene};
use glam::DVec3;

const HEADER: &str = "element vertex 4\nproperty float x\nproperty double y\nproperty float z\nproperty uchar red\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n";

fn ascii() -> String {
    format!(
        "ply\nformat ascii 1.0\ncomment a quad and a triangle\n{HEADER}0 0 0 255\n1 0 0 255\n1 1 0 255\n0 1 0 255\n4 0 1 2 3\n3 0 1 3\n"
    )
}

fn binary(big: bool) -> Vec<u8> {
    let name = if big { "big" } else { "little" };
    let mut bytes = format!("ply\nformat binary_{name}_endian 1.0\n{HEADER}").into_bytes();
    macro_rules! put {
        ($value:expr) => {
            bytes.extend(if big {
                $value.to_be_bytes()
            } else {
                $value.to_le_bytes()
            })
        };
    }
    for (x, y) in [(0.0f32, 0.0f64), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
        put!(x);
        put!(y);
        put!(0.0f32);
        bytes.push(255);
    }
    for face in [&[0i32, 1, 2, 3][..], &[0, 1, 3]] {
        bytes.push(face.len() as u8);
        for i in face {
            put!(i);
        }
    }
    bytes
}

pub(super) fn load_mesh(name: &str, bytes: impl AsRef<[u8]>) -> Result<Scene, String> {
    let folder = Folder::new();
    folder.write(name, bytes);
    folder.write(
        "scene.toml",
        format!("[environment]\nradiance = 1\n[[shapes]]\ntype = \"mesh\"\nfile = \"{name}\"\n"),
    );
    let scene = folder.load("scene.toml")?;
    Ok(Scene {
        warnings: scene.warnings.iter().map(|w| folder.anonymous(w)).collect(),
        ..scene
    })
}

pub(super) fn mesh(scene: &Scene) -> &Mesh {
    match &scene.shapes[0].geometry {
        Geometry::Mesh(mesh) => mesh,
        other => panic!("{other:?} is no mesh"),
    }
}

#[test]
fn ply_in_all_encodings() {
    for bytes in [ascii().into_bytes(), binary(false), binary(true)] {
        let scene = load_mesh("m.ply", bytes).expect("a valid PLY");
        assert_eq!(
            mesh(&scene).positions,
            [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y]
        );
        assert_eq!(mesh(&scene).triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 3]]);
    }
}

#[track_caller]
fn refused(name: &str, bytes: impl AsRef<[u8]>, expected: &str) {
    let message = load_mesh(name, bytes).expect_err("it must be refused");
    assert_eq!(message, format!("DIR/{name}: {expected}"));
}

#[test]
fn bad_ply_files() {
    refused(
        "m.ply",
        ascii().replace("3 0 1 3\n", "3 0 1 4\n"),
        "face 1: vertex index 4 is out of range; expected 0 to 3 (there are 4 vertices)",
    );
    refused(
        "m.ply",
        ascii().replace("3 0 1 3\n", "3 0 1 -1\n"),
        "face 1: vertex index -1 is out of range; expected 0 to 3 (there are 4 vertices)",
    );
    refused(
        "m.ply",
        ascii().replace("property float z\n", ""),
        "element vertex: has no property `z`; expected the properties x, y and z",
    );
    refused(
        "m.ply",
        ascii().replace("vertex_indices", "corners"),
        "element face: has no list `vertex_indices`; expected a triangle mesh (point clouds are not rendered)",
    );
    let message = load_mesh(
        "m.ply",
        ascii().replace("element face 2", "element face 4000000000000"),
    )
    .expect_err("it must be refused");
    assert!(
        message.contains("is truncated: its header promises at least 8000000000032 bytes"),
        "{message}"
    );
    refused(
        "m.ply",
        ascii().replace(
            "comment a quad and a triangle",
            "element nothing 9999999999999999",
        ),
        "is truncated: its header promises at least 10000000000000035 bytes of elements, but the file has 265; expected the whole file",
    );
    for name in ["m.ply", "m.obj", "m.gltf", "m.glb"] {
        let message = load_mesh(name, "nonsense").expect_err("it must be refused");
        assert!(message.starts_with(&format!("DIR/{name}: ")), "{message}");
    }
}

/// A file cut anywhere is an error, even where whole elements are left.
#[test]
fn truncated_ply_files_are_refused() {
    for bytes in [ascii().into_bytes(), binary(false)] {
        for length in 0..bytes.len() {
            let loaded = load_mesh("m.ply", &bytes[..length]);
            // Whole elements may be missing from an ascii file only by a missing last digit or
            // newline.
            assert!(loaded.is_err() || length + 2 >= bytes.len(), "{length}");
        }
    }
}

#[test]
fn obj_files() {
    let text = "mtllib paint.mtl\no quad\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nusemtl red\nf 1//1 2//1 3//1 4//1\no triangle\nv 0 0 2.123456789012\nf -1 1 2\n";
    let scene = load_mesh("m.obj", text).expect("a valid OBJ");
    assert_eq!(mesh(&scene).triangles.len(), 3);
    assert_eq!(
        scene.warnings[0],
        "DIR/m.obj: mtllib: `paint.mtl` does not exist; expected a file in the scene's folder, or in one named with --assets; its materials are left out"
    );
    assert!(
        mesh(&scene)
            .positions
            .contains(&DVec3::new(0.0, 0.0, 2.123_456_789_012))
    );
    refused(
        "m.obj",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n",
        "line 4: names vertex 7, which is out of range; expected 1 to 3, or -3 to -1 (there are 3)",
    );
    refused("m.obj", "v 0 0 0\n", "holds no face; expected a mesh");
    for veach in ["plate1.obj", "plate4.obj", "floor.obj"] {
        let Some(path) = shared(&format!("peers/veach/{veach}")) else {
            return;
        };
        let text = std::fs::read(path).expect("a readable file");
        load_mesh("m.obj", text).expect("a valid OBJ");
    }
}

/// Degenerate triangles go, and nothing else changes.
#[test]
fn degenerate_triangles_are_counted() {
    let text =
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv nan 0 0\nv 2 0 0\nf 1 2 3\nf 1 2 4\nf 1 1 2\nf 1 2 5\n";
    let scene = load_mesh("m.obj", text).expect("a valid OBJ");
    let clean = load_mesh("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").expect("a valid OBJ");
    assert_eq!(scene.shapes, clean.shapes);
    assert_eq!(scene.camera, clean.camera);
    assert_eq!(
        scene.warnings[0],
        "shapes[0]: 3 degenerate triangles were dropped (no area, or a vertex that is not finite)"
    );
}

#[test]
fn gltf_meshes_bring_their_geometry_alone() {
    let Some(assets) = shared("assets") else {
        return;
    };
    let folder = Folder::new();
    folder.write(
        "scene.toml",
        "[environment]\nradiance = 1\n[[shapes]]\ntype = \"mesh\"\nfile = \"CornellBox.glb\"\nname = \"box\"\n",
    );
    let options = LoadOptions {
        assets: vec![assets],
        ..LoadOptions::default()
    };
    let scene = folder
        .load_with("scene.toml", &options)
        .expect("a valid scene");
    assert!(
        scene
            .shapes
            .iter()
            .all(|s| s.emission.is_none() && s.material.index() == 0)
    );
    assert_eq!(scene.materials.len(), 1);
    assert_eq!(scene.shapes[0].name, "shapes[0]: box: Light (mesh 0)");
}

#[test]
fn real_ply_files_load() {
    for (name, vertices, triangles) in [("bunny.ply", 35_947, 69_451), ("teapot.ply", 1177, 2256)] {
        let Some(assets) = shared("assets") else {
            return;
        };
        let folder = Folder::new();
        let options = LoadOptions {
            assets: vec![assets],
            ..LoadOptions::default()
        };
        let path = folder.write(
            "scene.toml",
            format!("[[shapes]]\ntype = \"mesh\"\nfile = \"{name}\"\n"),
        );
        let start = std::time::Instant::now();
        let scene = load(&path, &options).unwrap_or_else(|e| panic!("{e}"));
        eprintln!("{name}: {:.1} ms", 1e3 * start.elapsed().as_secs_f64());
        assert!(mesh(&scene).positions.len() <= vertices);
        assert!(mesh(&scene).triangles.len() <= triangles);
        assert!(mesh(&scene).triangles.len() > triangles * 9 / 10);
    }
}

/// So that who looks at them sees it when they are mended.
#[test]
fn the_files_of_a_scene_are_told_even_where_one_is_broken() {
    let folder = Folder::new();
    let text = "[environment]\nradiance = 1\n[[shapes]]\ntype = \"mesh\"\nfile = \"m.ply\"\n";
    let scene = folder.write("scene.toml", text);
    for (content, right) in [(ascii(), true), ("ply\n".to_owned(), false)] {
        let mesh = folder.write("m.ply", content);
        let (read, files) = load_with_files(&scene, &LoadOptions::default());
        assert_eq!(read.is_ok(), right);
        let mesh = mesh.canonicalize().unwrap();
        assert_eq!(files.into_iter().collect::<Vec<_>>(), [mesh, scene.clone()]);
    }
}
