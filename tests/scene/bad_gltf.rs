//! Broken glTF and GLB files are refused with the place that is broken.

use super::files::{Folder, glb, load_gltf, triangle_glb, triangle_gltf, with};
use direkt::scene::Geometry;
use serde_json::{Value, json};

#[track_caller]
fn refused(pointer: &str, value: Value, expected: &str) {
    let message =
        load_gltf(&with(triangle_gltf(), pointer, value)).expect_err("it must be refused");
    assert_eq!(message, format!("DIR/scene.gltf: {expected}"));
}

#[test]
fn indices_out_of_range() {
    refused(
        "/scene",
        json!(3),
        "scene: scene 3 is out of range; expected 0, the only one",
    );
    refused(
        "/scenes/0/nodes/0",
        json!(7),
        "scenes[0].nodes: node 7 is out of range; expected 0, the only one",
    );
    refused(
        "/nodes/0/mesh",
        json!(2),
        "nodes[0].mesh: mesh 2 is out of range; expected 0, the only one",
    );
    refused(
        "/nodes/0/children",
        json!([9]),
        "nodes[0].children: node 9 is out of range; expected 0, the only one",
    );
    refused(
        "/nodes/0/camera",
        json!(0),
        "nodes[0].camera: camera 0 is out of range; expected no reference: the file has no camera",
    );
    refused(
        "/nodes/0/extensions",
        json!({ "KHR_lights_punctual": { "light": 4 } }),
        "nodes[0].extensions.KHR_lights_punctual.light: light 4 is out of range; expected no reference: the file has no light",
    );
    refused(
        "/meshes/0/primitives/0/material",
        json!(5),
        "meshes[0].primitives[0].material: material 5 is out of range; expected 0, the only one",
    );
    refused(
        "/meshes/0/primitives/0/indices",
        json!(12),
        "meshes[0].primitives[0].indices: accessor 12 is out of range; expected 0 to 1",
    );
    refused(
        "/accessors/0/bufferView",
        json!(8),
        "accessors[0].bufferView: bufferView 8 is out of range; expected 0 to 1",
    );
    refused(
        "/bufferViews/0/buffer",
        json!(1),
        "bufferViews[0].buffer: buffer 1 is out of range; expected 0, the only one",
    );
    // Bytes of the floats, read as vertex indices.
    refused(
        "/bufferViews/1/byteOffset",
        json!(14),
        "meshes[0].primitives[0].indices: vertex 16256 (element 0 of accessor 1) is out of range; expected an index into the 3 vertices",
    );
}

#[test]
fn lengths_and_ranges() {
    refused(
        "/bufferViews/0/byteLength",
        json!(43),
        "bufferViews[0]: byteOffset 0 and byteLength 43 end outside buffer 0; expected a range within its 42 bytes",
    );
    refused(
        "/bufferViews/1/byteOffset",
        json!(u64::MAX),
        "bufferViews[1]: byteOffset 18446744073709551615 and byteLength 6 end outside buffer 0; expected a range within its 42 bytes",
    );
    for count in [4, u64::MAX] {
        refused(
            "/accessors/0/count",
            json!(count),
            &format!(
                "accessors[0]: {count} elements of 12 bytes, 12 apart, from byte 0 on do not fit bufferView 0; expected a range within its 36 bytes"
            ),
        );
    }
    refused(
        "/bufferViews/0/byteStride",
        json!(4),
        "accessors[0]: 3 elements of 12 bytes, 4 apart, from byte 0 on do not fit bufferView 0; expected a range within its 36 bytes",
    );
    refused(
        "/buffers/0/byteLength",
        json!(1000),
        "buffers[0].byteLength: is 1000, but there are only 42 bytes; expected the whole buffer (is the file truncated?)",
    );
    refused(
        "/accessors/1/count",
        json!(2),
        "meshes[0].primitives[0].indices: 2 corners do not make triangles; expected a multiple of 3",
    );
}

#[test]
fn wrong_types_and_values() {
    refused(
        "/accessors/0/type",
        json!("VEC2"),
        "accessors[0].type: is Vec2; expected Vec3",
    );
    refused(
        "/accessors/0/type",
        json!("VEC9"),
        "accessors[0].type: is unknown; expected Vec3",
    );
    refused(
        "/accessors/1/componentType",
        json!(5122),
        "accessors[1].componentType: is 5122; expected 5121, 5123 or 5125 (unsigned) for indices",
    );
    refused(
        "/asset/version",
        json!("1.0"),
        "asset.version: is `1.0`; expected 2.0",
    );
    refused(
        "/extensionsRequired",
        json!(["KHR_gaussian_splatting", "KHR_lights_punctual"]),
        "extensionsRequired: the file cannot be shown without KHR_gaussian_splatting; expected no more than EXT_mesh_gpu_instancing, EXT_texture_webp, KHR_draco_mesh_compression, KHR_lights_punctual, KHR_materials_emissive_strength, KHR_materials_ior, KHR_materials_pbrSpecularGlossiness, KHR_materials_specular, KHR_materials_transmission, KHR_materials_unlit, KHR_materials_volume, KHR_mesh_quantization, KHR_node_visibility, KHR_texture_transform",
    );
    refused(
        "/materials/0",
        json!({ "pbrMetallicRoughness": { "roughnessFactor": 2 } }),
        "materials[0].pbrMetallicRoughness.roughnessFactor: is 2; expected a number from 0 to 1",
    );
    refused(
        "/materials/0",
        json!({ "emissiveFactor": [0, -1, 0] }),
        "materials[0].emissiveFactor: is -1; expected a finite number, not negative",
    );
    refused(
        "/nodes/0/scale",
        json!([1, 0, 1]),
        "nodes[0]: the transform is singular (its determinant is 0e0); expected a transform that does not flatten space; no scale may be 0",
    );
    refused(
        "/nodes/0/children",
        json!([0]),
        "nodes[0].children: node 0 is reached twice; expected a tree: no cycle, and one parent for each node",
    );
    refused(
        "/buffers/0/uri",
        json!("../../secret.bin"),
        "buffers[0].uri: `../../secret.bin` leaves the scene's folder; expected a file in that folder; put it there or name its folder with --assets",
    );
    refused(
        "/buffers/0/uri",
        json!("https://example.org/a.bin"),
        "buffers[0].uri: `https://example.org/a.bin` is on the network; expected a file in the glTF's folder",
    );
}

/// A short file whose nodes show the same mesh again and again is refused before its instances take
/// memory.
#[test]
fn instances_without_end() {
    let primitive = json!({ "attributes": { "POSITION": 0 }, "indices": 1 });
    let json = with(
        triangle_gltf(),
        "/meshes/0/primitives",
        json!(vec![primitive; 6000]),
    );
    let json = with(json, "/nodes", json!(vec![json!({ "mesh": 0 }); 6000]));
    let json = with(
        json,
        "/scenes/0/nodes",
        json!((0..6000).collect::<Vec<_>>()),
    );
    assert_eq!(
        load_gltf(&json).expect_err("it must be refused"),
        "DIR/scene.gltf: nodes[4473].mesh: the nodes up to here make more than 134217728 vertices and triangles of their meshes; expected fewer instances"
    );
}

#[test]
fn not_finite_vertices_are_dropped_and_counted() {
    let mut bin: Vec<u8> = [
        0.0f32,
        0.0,
        0.0,
        1.0,
        0.0,
        0.0,
        0.0,
        1.0,
        0.0,
        f32::NAN,
        0.0,
        0.0,
    ]
    .iter()
    .flat_map(|x| x.to_le_bytes())
    .collect();
    bin.extend([0u8, 1, 2, 0, 1, 3, 1, 1, 2, 0, 0, 0]);
    let json = with(triangle_gltf(), "/buffers", json!([{ "byteLength": 60 }]));
    let json = with(
        json,
        "/bufferViews",
        json!([{ "buffer": 0, "byteLength": 48 }, { "buffer": 0, "byteOffset": 48, "byteLength": 9 }]),
    );
    let json = with(json, "/accessors/0/count", json!(4));
    let json = with(
        json,
        "/accessors/1",
        json!({ "bufferView": 1, "componentType": 5121, "count": 9, "type": "SCALAR" }),
    );
    let folder = Folder::new();
    folder.write("scene.glb", glb(&json, &bin));
    let scene = folder.load("scene.glb").expect("a valid GLB");
    assert!(matches!(&scene.shapes[0].geometry, Geometry::Mesh(m) if m.triangles.len() == 1));
    assert_eq!(
        scene.warnings[0],
        "scene.glb: 2 degenerate triangles were dropped (no area, or a vertex that is not finite)"
    );
}

#[test]
fn every_truncation_of_a_glb_is_an_error() {
    let bytes = triangle_glb();
    let folder = Folder::new();
    for length in 0..bytes.len() {
        folder.write("scene.glb", &bytes[..length]);
        let message = folder.load("scene.glb").expect_err("it must be refused");
        assert!(message.starts_with("DIR/scene.glb: "), "{message}");
        if length >= 4 {
            assert!(message.contains("truncated"), "{length}: {message}");
        }
    }
}
