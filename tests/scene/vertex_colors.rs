//! Vertex colours of OBJ, PLY and glTF files.

use super::files::{Folder, load_gltf, triangle_gltf, with};
use super::meshes::{load_mesh, mesh};
use crate::support::prepared_for;
use base64::Engine;
use direkt::low_level::effects::Effect;
use direkt::scene::{LightSelection, Opacity, Scene, Strategy};
use glam::Vec4;
use serde_json::{Value, json};

fn obj(colors: [&str; 3]) -> String {
    let [a, b, c] = colors;
    format!("v 0 0 0 {a}\nv 1 0 0 {b}\nv 0 1 0 {c}\nf 1 2 3\n")
}

fn ply(kind: &str, names: &str, colors: [&str; 3]) -> String {
    let properties: Vec<String> = names
        .split(' ')
        .map(|name| format!("property {kind} {name}\n"))
        .collect();
    let [a, b, c] = colors;
    format!(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n{}element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 {a}\n1 0 0 {b}\n0 1 0 {c}\n3 0 1 2\n",
        properties.concat()
    )
}

fn rgb(r: f32, g: f32, b: f32) -> Vec4 {
    Vec4::new(r, g, b, 1.0)
}

#[test]
fn obj_and_ply_colours_are_linear_factors() {
    let expected = [rgb(1.0, 0.0, 0.2), rgb(0.0, 1.0, 0.4), rgb(0.6, 0.8, 0.0)];
    let floats = ["1 0 0.2", "0 1 0.4", "0.6 0.8 0"];
    let bytes = ["255 0 51", "0 255 102", "153 204 0"];
    let words = ["65535 0 13107", "0 65535 26214", "39321 52428 0"];
    for (name, text) in [
        ("m.obj", obj(floats)),
        ("m.ply", ply("float", "red green blue", floats)),
        ("m.ply", ply("double", "r g b", floats)),
        ("m.ply", ply("uchar", "red green blue", bytes)),
        (
            "m.ply",
            ply("uint8", "diffuse_red diffuse_green diffuse_blue", bytes),
        ),
        ("m.ply", ply("ushort", "red green blue", words)),
        ("m.ply", ply("int", "red green blue", bytes)),
    ] {
        let scene = load_mesh(name, &text).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(mesh(&scene).colors, expected, "{text}");
    }
}

/// Vertices without a colour beside those that have one are white; white alone is nothing.
#[test]
fn vertices_without_a_colour_are_white() {
    let scene = load_mesh("m.obj", obj(["", "0 0 1", ""])).expect("a valid OBJ");
    assert_eq!(
        mesh(&scene).colors,
        [Vec4::ONE, rgb(0.0, 0.0, 1.0), Vec4::ONE]
    );
    for (name, text) in [
        ("m.obj", obj(["1 1 1", "1 1 1", ""])),
        (
            "m.ply",
            ply("uchar", "red green blue alpha", ["255 255 255 255"; 3]),
        ),
    ] {
        let scene = load_mesh(name, text).expect("a valid mesh");
        assert_eq!(mesh(&scene).colors, []);
        assert!(!calls_for(&scene));
    }
}

fn calls_for(scene: &Scene) -> bool {
    let prepared = prepared_for(scene.clone(), Strategy::MisPower, LightSelection::Power);
    prepared.effects.contains(Effect::VertexColors)
}

#[test]
fn colours_out_of_range_are_said_to_be() {
    let scene = load_mesh(
        "m.ply",
        ply("float", "red green blue", ["255 0 -1", "0 0 0", "0 0 0"]),
    );
    let scene = scene.expect("a valid PLY");
    assert_eq!(mesh(&scene).colors[0], rgb(1.0, 0.0, 0.0));
    assert_eq!(
        scene.warnings[0],
        "DIR/m.ply: 1 vertex colour is not from 0 to 1 (the largest channel is 255); such channels are taken as the nearest of these"
    );
    let message = load_mesh("m.ply", ply("float", "red green blue", ["nan 0 0"; 3]));
    let message = message.expect_err("it must be refused");
    assert!(
        message.starts_with("DIR/m.ply: vertex 0: its colour is"),
        "{message}"
    );
}

/// The alpha of a mesh file is not the opacity of a scene's material, and that is said.
#[test]
fn alpha_of_mesh_files_is_ignored() {
    let colors = ["255 0 0 128", "255 0 0 255", "255 0 0 255"];
    let scene = load_mesh("m.ply", ply("uchar", "red green blue alpha", colors));
    let scene = scene.expect("a valid PLY");
    assert_eq!(mesh(&scene).colors, [rgb(1.0, 0.0, 0.0); 3]);
    assert_eq!(
        scene.warnings[0],
        "DIR/m.ply: the alpha of its vertex colours is ignored: a material's `opacity` counts"
    );
}

#[test]
fn a_shape_says_what_its_colours_mean() {
    let folder = Folder::new();
    folder.write("m.obj", obj(["0.5 0.5 0.5", "0 0 0", "1 1 1"]));
    let load = |key: &str| {
        let shape = format!("[[shapes]]\ntype = \"mesh\"\nfile = \"m.obj\"\n{key}\n");
        folder.write("scene.toml", shape);
        folder.load("scene.toml")
    };
    let colors = |key: &str| mesh(&load(key).expect("a valid scene")).colors.clone();
    assert_eq!(colors("vertex_colors = \"linear\""), colors(""));
    assert_eq!(colors("vertex_colors = \"ignore\""), []);
    let decoded = colors("vertex_colors = \"srgb\"");
    // IEC 61966-2-1: ((0.5 + 0.055)/1.055)^2.4.
    assert!((decoded[0].x - 0.214_041_14).abs() < 1e-7, "{decoded:?}");
    assert_eq!(decoded[2], Vec4::ONE);
    let message = load("vertex_colors = \"rgb\"").expect_err("it must be refused");
    assert!(message.contains("shapes[0].vertex_colors"), "{message}");
}

#[test]
fn a_metal_by_its_index_has_no_colour() {
    let folder = Folder::new();
    folder.write("m.obj", obj(["1 0 0"; 3]));
    folder.write(
        "scene.toml",
        "[materials.gold]\ntype = \"conductor\"\nmetal = \"gold\"\nalpha = 0.1\n[[shapes]]\ntype = \"mesh\"\nfile = \"m.obj\"\nmaterial = \"gold\"\n",
    );
    let scene = folder.load("scene.toml").expect("a valid scene");
    assert_eq!(mesh(&scene).colors, []);
    let warning = "shapes[0]: vertex colours are ignored: material `gold` is a metal given by its index of refraction";
    assert!(
        scene.warnings.contains(&warning.to_owned()),
        "{:?}",
        scene.warnings
    );
}

/// The triangle with a COLOR_0 of `bytes`.
fn gltf(accessor: Value, bytes: &[u8], material: Value) -> Value {
    let data = base64::engine::general_purpose::STANDARD.encode(bytes);
    let mut json = triangle_gltf();
    for (list, value) in [
        (
            "buffers",
            json!({ "byteLength": bytes.len(), "uri": format!("data:;base64,{data}") }),
        ),
        (
            "bufferViews",
            json!({ "buffer": 1, "byteLength": bytes.len() }),
        ),
        ("accessors", accessor),
    ] {
        json[list].as_array_mut().expect("a list").push(value);
    }
    let json = with(json, "/materials", json!([material]));
    let attributes = json!({ "POSITION": 0, "COLOR_0": 2 });
    with(json, "/meshes/0/primitives/0/attributes", attributes)
}

fn accessor(component: u32, kind: &str) -> Value {
    let normalized = component != 5126;
    json!({ "bufferView": 2, "componentType": component, "normalized": normalized, "count": 3, "type": kind })
}

#[test]
fn color_0_in_all_its_types() {
    let expected = [rgb(1.0, 0.0, 0.2), rgb(0.0, 1.0, 0.4), rgb(0.6, 0.8, 0.0)];
    let mut floats: Vec<f32> = Vec::new();
    let (mut bytes, mut words) = (Vec::new(), Vec::new());
    for color in expected {
        floats.extend(&color.to_array()[..3]);
        bytes.extend(color.to_array().map(|c| (255.0 * c).round() as u8));
        words.extend(
            color.to_array()[..3]
                .iter()
                .map(|c| (65_535.0 * c).round() as u16),
        );
    }
    // Out of [0, 1], to be brought back.
    floats[0] = 1.5;
    floats[1] = -0.5;
    let floats: Vec<u8> = floats.iter().flat_map(|x| x.to_le_bytes()).collect();
    let words: Vec<u8> = words.iter().flat_map(|x: &u16| x.to_le_bytes()).collect();
    for (component, kind, bytes) in [
        (5126, "VEC3", &floats),
        (5121, "VEC4", &bytes),
        (5123, "VEC3", &words),
    ] {
        let scene = load_gltf(&gltf(accessor(component, kind), bytes, json!({})));
        let scene = scene.unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(mesh(&scene).colors, expected, "{component} {kind}");
        assert!(calls_for(&scene));
    }
    let mut plain = accessor(5121, "VEC4");
    plain["normalized"] = json!(false);
    let message = load_gltf(&gltf(plain, &bytes, json!({}))).expect_err("it must be refused");
    assert_eq!(
        message,
        "DIR/scene.gltf: accessors[2].normalized: is false; expected true for colours that are not floats"
    );
}

/// Alpha is a factor on the opacity under BLEND and MASK alone, and folded away where it is the
/// same everywhere.
#[test]
fn alpha_of_color_0_follows_the_alpha_mode() {
    let colors = |alphas: [u8; 3]| alphas.map(|a| [255, 255, 255, a]).concat();
    let load = |mode: Value, alphas| {
        let json = gltf(accessor(5121, "VEC4"), &colors(alphas), mode);
        load_gltf(&json).unwrap_or_else(|e| panic!("{e}"))
    };
    let varied = [51, 102, 255];
    let opaque = load(json!({}), varied);
    assert_eq!(mesh(&opaque).colors, []);
    let blend = load(json!({ "alphaMode": "BLEND" }), varied);
    let alphas: Vec<f32> = mesh(&blend).colors.iter().map(|c| c.w).collect();
    assert_eq!(alphas, [0.2, 0.4, 1.0]);
    let blend = prepared_for(blend, Strategy::MisPower, LightSelection::Power);
    assert!(blend.data.attributes.of_primitive[0].opacity);
    // 51/255 reaches a cutoff of 0.2: all of it is opaque. 102/255 does, and 51/255 does not.
    let mask = |cutoff: f64| json!({ "alphaMode": "MASK", "alphaCutoff": cutoff });
    let whole = load(mask(0.2), varied);
    assert_eq!(mesh(&whole).colors, []);
    assert_eq!(whole.materials[0].opacity, Opacity::default());
    let part = load(mask(0.4), varied);
    assert_eq!(mesh(&part).colors.len(), 3);
    assert!(part.materials[0].opacity.cutoff.is_some());
    let half = load(json!({ "alphaMode": "BLEND" }), [51; 3]);
    assert_eq!(mesh(&half).colors, []);
    assert!((half.materials[0].opacity.factor - 0.2).abs() < 1e-7);
}
