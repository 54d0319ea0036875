//! Scenes of more triangles than there is room for.

use super::builder::{Builder, TRIANGLE};
use super::files::Folder;
use direkt::scene::load::{Capacity, LoadOptions};
use serde_json::json;

const SCENE: &str =
    "[environment]\nradiance = 1\n[[shapes]]\ntype = \"mesh\"\nfile = \"FILE\"\nname = \"hill\"\n";

/// Loads `file` of `folder` where there is room for `triangles`.
fn load(folder: &Folder, file: &str, triangles: u64) -> Result<usize, String> {
    let options = LoadOptions {
        capacity: Some(Capacity {
            triangles,
            reason: "which is what the GPU takes".to_owned(),
        }),
        ..LoadOptions::default()
    };
    let scene = folder.load_with(file, &options)?;
    Ok(scene.shapes.len())
}

/// A mesh file of a scene.
fn mesh(name: &str, content: impl AsRef<[u8]>) -> Folder {
    let folder = Folder::new();
    folder.write(name, content);
    folder.write("scene.toml", SCENE.replace("FILE", name));
    folder
}

/// The same file twice; what the header promises counts, not what is behind it.
#[test]
fn headers_of_ply_files_are_counted() {
    let header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 5\nproperty list uchar int vertex_indices\nend_header\n";
    let faces = "3 0 1 2\n".repeat(5);
    let folder = mesh("m.ply", format!("{header}0 0 0\n1 0 0\n0 1 0\n{faces}"));
    assert_eq!(load(&folder, "scene.toml", 5), Ok(1));
    assert_eq!(
        load(&folder, "scene.toml", 4).unwrap_err(),
        "DIR/m.ply: element face: makes 5 triangles; expected at most 4 in a scene, which is what the GPU takes"
    );
    let broken = mesh("m.ply", format!("{header}{}", "not a number ".repeat(9)));
    let message = load(&broken, "scene.toml", 4).unwrap_err();
    assert!(message.contains("makes 5 triangles"), "{message}");
    let shape = SCENE
        .replace("FILE", "m.ply")
        .replace("[environment]\nradiance = 1\n", "");
    let twice = SCENE.replace("FILE", "m.ply") + &shape.replace("hill", "valley");
    folder.write("twice.toml", twice);
    assert_eq!(load(&folder, "twice.toml", 10), Ok(2));
    let message = load(&folder, "twice.toml", 9).unwrap_err();
    assert!(
        message.contains("makes 5 triangles, with those before them 10;"),
        "{message}"
    );
}

/// Lines of faces are counted before the first is read, and what polygons make of them behind that.
#[test]
fn faces_of_obj_files_are_counted() {
    let vertices = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
    let triangles = mesh("m.obj", format!("{vertices}{}", "f 1 2 3\n".repeat(7)));
    assert_eq!(load(&triangles, "scene.toml", 7), Ok(1));
    assert_eq!(
        load(&triangles, "scene.toml", 6).unwrap_err(),
        "DIR/m.obj: f: makes 7 triangles; expected at most 6 in a scene, which is what the GPU takes"
    );
    let quads = mesh("m.obj", format!("{vertices}{}", "f 1 2 3 4\n".repeat(7)));
    assert_eq!(load(&quads, "scene.toml", 14), Ok(1));
    assert_eq!(
        load(&quads, "scene.toml", 13).unwrap_err(),
        "DIR/scene.toml: shapes[0]: hill: makes 14 triangles; expected at most 13 in a scene, which is what the GPU takes"
    );
}

/// Every instance counts, by what accessors promise.
#[test]
fn instances_in_gltf_files_are_counted() {
    let mut builder = Builder::new();
    let positions = builder.floats(&TRIANGLE);
    builder.mesh(json!({ "attributes": { "POSITION": positions } }));
    for x in 0..5 {
        builder.root(json!({ "mesh": 0, "translation": [x, 0, 0] }));
    }
    let folder = Folder::new();
    folder.write("scene.glb", builder.glb());
    assert_eq!(load(&folder, "scene.glb", 5), Ok(5));
    assert_eq!(
        load(&folder, "scene.glb", 4).unwrap_err(),
        "DIR/scene.glb: nodes[4].mesh: makes 1 triangles, with those before them 5; expected at most 4 in a scene, which is what the GPU takes"
    );
}
