//! glTF and GLB files: what they bring, what they leave out with a warning, and how broken ones are refused.

mod scene_files;

use direkt::scene::load::{LoadOptions, load};
use direkt::scene::{Bsdf, Geometry, Light, Mesh, Scene};
use glam::DVec3;
use scene_files::{Folder, load_gltf, shared, triangle_gltf, with};
use serde_json::{Value, json};

fn mesh(scene: &Scene, shape: usize) -> &Mesh {
    match &scene.shapes[shape].geometry {
        Geometry::Mesh(mesh) => mesh,
        other => panic!("{other:?} is no mesh"),
    }
}

fn corners(mesh: &Mesh, triangle: usize) -> [DVec3; 3] {
    mesh.triangles[triangle].map(|i| mesh.positions[i as usize])
}

/// A GLB of a JSON chunk and a binary chunk.
fn glb(json: &Value, bin: &[u8]) -> Vec<u8> {
    let mut text = json.to_string().into_bytes();
    while text.len() % 4 != 0 {
        text.push(b' ');
    }
    let mut bytes = b"glTF".to_vec();
    bytes.extend(2u32.to_le_bytes());
    bytes.extend((12 + 8 + text.len() as u32 + 8 + bin.len() as u32).to_le_bytes());
    bytes.extend((text.len() as u32).to_le_bytes());
    bytes.extend(b"JSON");
    bytes.extend(&text);
    bytes.extend((bin.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(bin);
    bytes
}

/// The triangle as GLB.
fn triangle_glb() -> Vec<u8> {
    let mut bin: Vec<u8> = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    bin.extend([0u8, 0, 1, 0, 2, 0, 0, 0]);
    let json = with(triangle_gltf(), "/buffers", json!([{ "byteLength": 42 }]));
    glb(&json, &bin)
}

#[test]
fn a_triangle_comes_through_every_container() {
    let embedded = load_gltf(&triangle_gltf()).expect("a valid glTF");
    let folder = Folder::new();
    folder.write("scene.glb", triangle_glb());
    let binary = folder.load("scene.glb").expect("a valid GLB");
    let bin = &triangle_glb()[triangle_glb().len() - 44..];
    folder.write("a b.bin", bin);
    let external = with(
        triangle_gltf(),
        "/buffers",
        json!([{ "byteLength": 42, "uri": "a%20b.bin" }]),
    );
    folder.write("scene.gltf", external.to_string());
    let external = folder.load("scene.gltf").expect("a valid glTF");
    for scene in [&embedded, &binary, &external] {
        assert_eq!(scene.shapes.len(), 1);
        assert_eq!(scene.shapes[0].name, "triangle (mesh 0)");
        assert_eq!(
            corners(mesh(scene, 0), 0),
            [DVec3::ZERO, DVec3::X, DVec3::Y]
        );
        assert_eq!(
            scene.warnings,
            ["the scene has no light: the image will be black"]
        );
    }
    assert_eq!(embedded.camera, binary.camera);
    assert_eq!(embedded.camera.forward, DVec3::NEG_Z);
}

#[test]
fn nodes_compose_and_mirrors_keep_the_front() {
    let json = with(
        triangle_gltf(),
        "/nodes",
        json!([
            { "translation": [10, 0, 0], "children": [1, 2] },
            { "mesh": 0, "scale": [-2, 1, 1] },
            { "mesh": 0, "matrix": [0,1,0,0, -1,0,0,0, 0,0,1,0, 0,0,5,1] }
        ]),
    );
    let scene = load_gltf(&json).expect("a valid glTF");
    let [a, b, c] = corners(mesh(&scene, 0), 0);
    assert_eq!(a, DVec3::new(10.0, 0.0, 0.0));
    // The mirror turns (1, 0, 0) to (-2, 0, 0); swapped winding keeps the normal at +z.
    assert_eq!((b - a).cross(c - a), DVec3::new(0.0, 0.0, 2.0));
    let [a, b, c] = corners(mesh(&scene, 1), 0);
    assert_eq!(a, DVec3::new(10.0, 0.0, 5.0));
    assert_eq!(b, DVec3::new(10.0, 1.0, 5.0));
    assert_eq!(c, DVec3::new(9.0, 0.0, 5.0));
}

#[test]
fn materials_emission_and_sides() {
    let json = with(
        triangle_gltf(),
        "/materials/0",
        json!({
            "name": "lamp",
            "doubleSided": true,
            "emissiveFactor": [1, 0.5, 0],
            "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 8 } },
            "pbrMetallicRoughness": {
                "baseColorFactor": [0.5, 0.25, 1, 1], "metallicFactor": 0, "roughnessFactor": 0.75
            }
        }),
    );
    let scene = load_gltf(&json).expect("a valid glTF");
    let material = &scene.materials[0];
    assert_eq!(
        material.bsdf,
        Bsdf::MetallicRoughness {
            base_color: DVec3::new(0.5, 0.25, 1.0),
            metallic: 0.0,
            roughness: 0.75
        }
    );
    assert!(material.double_sided);
    let emission = scene.shapes[0].emission.expect("it emits");
    assert_eq!(emission.radiance, DVec3::new(8.0, 4.0, 0.0));
    assert!(emission.two_sided);

    let mut plain = triangle_gltf();
    plain["meshes"][0]["primitives"][0]
        .as_object_mut()
        .expect("a primitive")
        .remove("material");
    let scene = load_gltf(&plain).expect("a valid glTF");
    assert!(!scene.materials[0].double_sided);
    assert_eq!(
        scene.materials[0].bsdf,
        Bsdf::MetallicRoughness {
            base_color: DVec3::ONE,
            metallic: 1.0,
            roughness: 1.0
        }
    );
}

#[test]
fn cameras_and_lights_look_along_minus_z() {
    let json = with(
        triangle_gltf(),
        "/nodes",
        json!([
            { "mesh": 0, "children": [1, 2, 3, 4] },
            { "camera": 0, "translation": [0, 0, 9], "rotation": [0, 0.7071067811865476, 0, 0.7071067811865476] },
            { "extensions": { "KHR_lights_punctual": { "light": 0 } }, "translation": [1, 2, 3], "scale": [5, 5, 5] },
            { "extensions": { "KHR_lights_punctual": { "light": 1 } }, "rotation": [-0.7071067811865476, 0, 0, 0.7071067811865476] },
            { "extensions": { "KHR_lights_punctual": { "light": 2 } } }
        ]),
    );
    let json = with(
        json,
        "/cameras",
        json!([{ "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1 } }]),
    );
    let json = with(
        json,
        "/extensions",
        json!({ "KHR_lights_punctual": { "lights": [
            { "type": "point", "color": [1, 0.5, 0.25], "intensity": 40, "range": 7 },
            { "type": "directional", "intensity": 1000 },
            { "type": "spot", "intensity": 3, "spot": { "outerConeAngle": 1.5707964 } }
        ] } }),
    );
    let json = with(json, "/extensionsUsed", json!(["KHR_lights_punctual"]));
    let json = with(json, "/extensionsRequired", json!(["KHR_lights_punctual"]));
    let scene = load_gltf(&json).expect("a valid glTF");
    assert!(scene.camera.forward.distance(DVec3::NEG_X) < 1e-7);
    assert_eq!(scene.camera.eye, DVec3::new(0.0, 0.0, 9.0));
    assert!((scene.camera.fov_y - 0.5).abs() < 1e-12);
    assert_eq!(
        scene.lights[0],
        Light::Point {
            position: DVec3::new(1.0, 2.0, 3.0),
            intensity: DVec3::new(40.0, 20.0, 10.0)
        }
    );
    let Light::Directional {
        direction,
        irradiance,
    } = scene.lights[1]
    else {
        panic!("a directional light")
    };
    assert!(direction.distance(DVec3::NEG_Y) < 1e-7);
    assert_eq!(irradiance, DVec3::splat(1000.0));
    let Light::Spot {
        direction,
        inner_angle,
        outer_angle,
        ..
    } = scene.lights[2]
    else {
        panic!("a spot light")
    };
    assert_eq!(direction, DVec3::NEG_Z);
    assert!(inner_angle.abs() < 1e-15 && outer_angle <= std::f64::consts::FRAC_PI_2);
    assert_eq!(
        scene.warnings,
        [
            "scene.gltf: the range of 1 light is ignored: light falls off with the square of the distance alone"
        ]
    );
}

#[test]
fn what_is_left_out_is_said_once() {
    let json = with(
        triangle_gltf(),
        "/materials",
        json!([
            {
                "alphaMode": "BLEND",
                "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } },
                "normalTexture": { "index": 0 }
            },
            { "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }
        ]),
    );
    let json = with(
        json,
        "/meshes/0/primitives",
        json!([
            { "attributes": { "POSITION": 0, "NORMAL": 0, "COLOR_0": 0 }, "indices": 1, "material": 0 },
            { "attributes": { "POSITION": 0, "NORMAL": 0 }, "indices": 1, "material": 1, "targets": [{ "POSITION": 0 }] },
            { "attributes": { "POSITION": 0 }, "mode": 1 }
        ]),
    );
    let json = with(json, "/nodes/0/camera", json!(0));
    let json = with(
        json,
        "/cameras",
        json!([{ "type": "orthographic", "orthographic": { "xmag": 1, "ymag": 1, "zfar": 9, "znear": 0.1 } }]),
    );
    let json = with(
        json,
        "/extensionsUsed",
        json!(["KHR_materials_sheen", "KHR_materials_emissive_strength"]),
    );
    let json = with(
        json,
        "/animations",
        json!([{ "channels": [], "samplers": [] }]),
    );
    let json = with(json, "/scenes", json!([{ "nodes": [0] }, { "nodes": [] }]));
    let scene = load_gltf(&json).expect("a valid glTF");
    assert_eq!(scene.shapes[1].name, "triangle (mesh 0, primitive 1)");
    assert_eq!(
        scene.warnings,
        [
            "scene.gltf: textures are not supported yet: baseColorTexture of 2 materials is ignored, their factors are used",
            "scene.gltf: textures are not supported yet: normalTexture of 1 material is ignored, surfaces are shaded flat",
            "scene.gltf: alphaMode BLEND of 1 material is not supported: rendered opaque",
            "scene.gltf: vertex normals of 2 primitives are not supported yet: surfaces are shaded flat",
            "scene.gltf: vertex colours of 1 primitive are not supported and ignored",
            "scene.gltf: morph targets of 1 primitive are not supported: the base shape is rendered",
            "scene.gltf: points and lines of 1 primitive are not rendered",
            "scene.gltf: 1 orthographic camera is ignored: only perspective cameras are supported",
            "scene.gltf: 1 animation is ignored: the scene is rendered as it stands",
            "scene.gltf: only the default one of 2 scenes is rendered",
            "scene.gltf: the extension KHR_materials_sheen is not supported and ignored",
            "the scene has no light: the image will be black",
        ]
    );
}

#[test]
fn quantized_positions() {
    let bin: Vec<u8> = [0i16, 0, 0, 0, 32_767, 0, 0, 0, 0, 32_767, 0, 0]
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let json = with(triangle_gltf(), "/buffers", json!([{ "byteLength": 24 }]));
    let json = with(
        json,
        "/bufferViews",
        json!([{ "buffer": 0, "byteLength": 24, "byteStride": 8 }]),
    );
    let json = with(
        json,
        "/accessors",
        json!([{ "bufferView": 0, "componentType": 5122, "normalized": true, "count": 3, "type": "VEC3" }]),
    );
    let mut json = with(
        json,
        "/extensionsRequired",
        json!(["KHR_mesh_quantization"]),
    );
    json["meshes"][0]["primitives"] = json!([{ "attributes": { "POSITION": 0 } }]);
    let folder = Folder::new();
    folder.write("scene.glb", glb(&json, &bin));
    let scene = folder.load("scene.glb").expect("a valid GLB");
    assert_eq!(
        corners(mesh(&scene, 0), 0),
        [DVec3::ZERO, DVec3::X, DVec3::Y]
    );
}

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
        json!(["KHR_draco_mesh_compression", "KHR_lights_punctual"]),
        "extensionsRequired: the file cannot be shown without KHR_draco_mesh_compression; expected no more than KHR_lights_punctual, KHR_materials_emissive_strength, KHR_mesh_quantization",
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
    assert_eq!(mesh(&scene, 0).triangles.len(), 1);
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

/// Every byte of a GLB is overwritten in turn: whatever comes of it, it is a scene or an error, never a panic.
#[test]
fn damaged_glbs_do_not_panic() {
    let bytes = triangle_glb();
    let folder = Folder::new();
    for at in 0..bytes.len() {
        for value in [0u8, 0x20, b'9', 0xff] {
            let mut damaged = bytes.clone();
            damaged[at] = value;
            folder.write("scene.glb", &damaged);
            let _ = folder.load("scene.glb");
        }
    }
}

#[test]
fn khronos_samples_load() {
    let Some(assets) = shared("assets") else {
        return;
    };
    let options = LoadOptions::default();
    let helmet = load(&assets.join("FlightHelmet/FlightHelmet.gltf"), &options)
        .unwrap_or_else(|e| panic!("{e}"));
    let triangles: usize = (0..helmet.shapes.len())
        .map(|s| mesh(&helmet, s).triangles.len())
        .sum();
    let names: Vec<&str> = helmet.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(
        names,
        [
            "HoseMat",
            "RubberWoodMat",
            "GlassPlasticMat",
            "MetalPartsMat",
            "LeatherPartsMat",
            "LensesMat"
        ]
    );
    insta::assert_snapshot!(format!(
        "{triangles} triangles\n{}",
        helmet.warnings.join("\n")
    ));

    let cornell = load(&assets.join("CornellBox.glb"), &options).unwrap_or_else(|e| panic!("{e}"));
    let light = cornell.shapes[0].emission.expect("the light emits");
    assert_eq!(light.radiance, DVec3::splat(100.0));
    insta::assert_snapshot!(cornell.warnings.join("\n"));

    let depth = load(
        &assets.join("DepthOfFieldExample/DepthOfFieldExample.glb"),
        &options,
    )
    .unwrap_or_else(|e| panic!("{e}"));
    assert!(
        matches!(depth.lights[0], Light::Directional { irradiance, .. } if irradiance == DVec3::splat(6830.0))
    );
    insta::assert_snapshot!(depth.warnings.join("\n"));
}
