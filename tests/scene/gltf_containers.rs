//! What holds a glTF: GLB chunks, JSON however it was written, and the names and the data of
//! buffers.

use super::files::{Folder, glb, load_gltf, triangle_glb, triangle_gltf, with};
use direkt::scene::{Geometry, Scene};
use serde_json::{Value, json};

#[track_caller]
fn has_the_triangle(scene: &Result<Scene, String>, what: &str) {
    let scene = scene.as_ref().unwrap_or_else(|e| panic!("{what}: {e}"));
    assert_eq!(scene.shapes.len(), 1, "{what}");
    let Geometry::Mesh(mesh) = &scene.shapes[0].geometry else {
        panic!("{what}: a mesh")
    };
    assert_eq!(mesh.triangles, [[0, 1, 2]], "{what}");
}

/// Loads bytes under a name.
fn loaded(name: &str, bytes: impl AsRef<[u8]>) -> Result<Scene, String> {
    let folder = Folder::new();
    folder.write(name, bytes);
    folder.load(name)
}

/// A GLB of chunks, each as long as `length` makes of its data.
fn glb_of(chunks: &[(&[u8; 4], &[u8])], padded: bool) -> Vec<u8> {
    let mut bytes = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
    for (kind, data) in chunks {
        bytes.extend((data.len() as u32).to_le_bytes());
        bytes.extend(*kind);
        bytes.extend(*data);
        while padded && !bytes.len().is_multiple_of(4) {
            bytes.push(b' ');
        }
    }
    let length = bytes.len() as u32;
    bytes[8..12].copy_from_slice(&length.to_le_bytes());
    bytes
}

/// JSON and binary data of the triangle's GLB; the JSON's length is no multiple of 4.
fn parts() -> (Vec<u8>, Vec<u8>) {
    let whole = triangle_glb();
    let bin = whole[whole.len() - 44..].to_vec();
    let json = with(triangle_gltf(), "/buffers", json!([{ "byteLength": 42 }]));
    let mut text = json.to_string().into_bytes();
    while text.len() % 4 != 1 {
        text.push(b' ');
    }
    (text, bin)
}

#[test]
fn chunks_of_other_kinds_are_passed_over_and_lengths_need_not_be_padded() {
    let (text, bin) = parts();
    let (json, data) = ((b"JSON", &text[..]), (b"BIN\0", &bin[..]));
    let other: (&[u8; 4], &[u8]) = (b"XYZW", b"another's");
    for chunks in [
        vec![json, data],
        vec![json, other, data],
        vec![json, data, other],
        vec![json, other, other, data, other],
    ] {
        for padded in [false, true] {
            // Where nothing is padded, a chunk of another kind cannot be told from padding.
            if padded || !chunks[1..].contains(&other) || chunks[1] == data {
                let what = format!("{} chunks, {padded}", chunks.len());
                has_the_triangle(&loaded("scene.glb", glb_of(&chunks, padded)), &what);
            }
        }
    }
    let mut trailing = glb_of(&[json, data], true);
    trailing.extend(b"more than the header says");
    has_the_triangle(&loaded("scene.glb", trailing), "trailing bytes");
}

#[test]
fn json_may_be_padded_marked_and_wide() {
    let (text, bin) = parts();
    for padding in [&b"\0\0\0"[..], b"   ", b"\n\0 \0", b"\0"] {
        let padded = [&text, padding].concat();
        let bytes = glb_of(&[(b"JSON", &padded), (b"BIN\0", &bin)], true);
        has_the_triangle(&loaded("scene.glb", bytes), &format!("{padding:?}"));
    }
    let text = triangle_gltf().to_string();
    let marked = format!("\u{feff}{text}\0\0");
    has_the_triangle(&loaded("scene.gltf", &marked), "a byte order mark");
    let glb = glb_of(&[(b"JSON", format!("\u{feff}{text}").as_bytes())], true);
    has_the_triangle(&loaded("scene.glb", glb), "a byte order mark in a GLB");
    for order in [u16::to_le_bytes, u16::to_be_bytes] {
        let wide: Vec<u8> = marked.encode_utf16().flat_map(order).collect();
        has_the_triangle(&loaded("scene.gltf", wide), "UTF-16");
    }
}

#[test]
fn names_do_not_decide_the_container() {
    has_the_triangle(&loaded("scene.gltf", triangle_glb()), "a GLB named .gltf");
    let text = triangle_gltf().to_string();
    has_the_triangle(&loaded("scene.glb", text), "JSON named .glb");
}

/// Writers without integers write `5126.0`, others `null` for what is not there.
#[test]
fn numbers_and_members_are_read_as_they_are_meant() {
    let text = triangle_gltf().to_string();
    let floats = text
        .replace("5126", "5126.0")
        .replace("\"count\":3", "\"count\":3.0");
    assert_ne!(floats, text);
    has_the_triangle(&loaded("scene.gltf", floats), "floats");
    let json = with(triangle_gltf(), "/nodes/0/children", Value::Null);
    let json = with(json, "/animations", Value::Null);
    has_the_triangle(&load_gltf(&json), "null");
    let json = with(triangle_gltf(), "/accessors/0/count", json!(2.5));
    assert_eq!(
        load_gltf(&json).expect_err("it must be refused"),
        "DIR/scene.gltf: accessors[0].count: is not a readable glTF: invalid type: floating point `2.5`, expected u64"
    );
}

#[test]
fn data_uris_are_read_however_they_are_spelt() {
    let json = triangle_gltf();
    let uri = json["buffers"][0]["uri"].as_str().unwrap();
    let data = uri.split_once(',').unwrap().1;
    let lines: String = data
        .as_bytes()
        .chunks(19)
        .map(|line| format!("{}\r\n", std::str::from_utf8(line).unwrap()))
        .collect();
    let encoded = data.replace('/', "%2F").replace('A', "%41");
    let for_urls = data.replace('+', "-").replace('/', "_");
    for uri in [
        format!(
            "data:application/octet-stream;base64,{}",
            data.trim_end_matches('=')
        ),
        format!("data:application/gltf-buffer;base64,{for_urls}"),
        format!("data:;base64,{lines}"),
        format!("DATA:model/x;charset=utf-8;BASE64,{encoded}"),
        format!("data:base64,{data}="),
    ] {
        let json = with(json.clone(), "/buffers/0/uri", json!(uri));
        has_the_triangle(&load_gltf(&json), &uri);
    }
    let json = with(
        json,
        "/buffers/0/uri",
        json!("data:application/octet-stream"),
    );
    assert_eq!(
        load_gltf(&json).expect_err("it must be refused"),
        "DIR/scene.gltf: buffers[0].uri: is a data URI without a comma before its data"
    );
}

#[test]
fn buffers_are_found_under_the_names_that_writers_give_them() {
    let (_, bin) = parts();
    for (file, uri) in [
        ("a b.bin", "a b.bin"),
        ("a b.bin", "a%20b.bin"),
        ("größe.bin", "größe.bin"),
        ("größe.bin", "gr%C3%B6%C3%9Fe.bin"),
        ("シーン/データ.bin", "シーン/データ.bin"),
        ("100%.bin", "100%.bin"),
        ("a%20b.bin", "a%20b.bin"),
        ("a#1.bin", "a#1.bin"),
        ("parts/a.bin", "parts\\a.bin"),
        ("parts/a.bin", "./parts/a.bin"),
        ("a.bin", "a.bin?version=2"),
    ] {
        let folder = Folder::new();
        // A buffer may be longer than what is read of it.
        folder.write(file, [&bin[..], b"and more"].concat());
        let buffers = json!([{ "byteLength": 42, "uri": uri }]);
        let json = with(triangle_gltf(), "/buffers", buffers);
        folder.write("scene.gltf", json.to_string());
        has_the_triangle(&folder.load("scene.gltf"), uri);
    }
}

#[test]
fn scenes_and_their_nodes_are_optional() {
    let empty =
        json!({ "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "name": "empty" }] });
    let scene = load_gltf(&empty).expect("an empty scene");
    assert!(scene.shapes.is_empty());
    assert_eq!(
        scene.warnings,
        ["the scene has no light: the image will be black"]
    );
    let folder = Folder::new();
    folder.write("empty.gltf", empty.to_string());
    folder.write(
        "scene.toml",
        "[[gltf]]\nfile = \"empty.gltf\"\n[environment]\nradiance = 1\n",
    );
    let scene = folder.load("scene.toml").expect("the sky alone");
    assert!(scene.shapes.is_empty());
    assert_eq!(
        scene.warnings,
        ["the scene has no camera: one that looks along −z and frames the geometry is used"]
    );

    let bare = json!({ "asset": { "version": "2.0" } });
    assert!(load_gltf(&bare).expect("nothing").shapes.is_empty());

    let mut default = triangle_gltf();
    default.as_object_mut().unwrap().remove("scene");
    has_the_triangle(&load_gltf(&default), "the first scene");
    // Without scenes every node that no other names is one of the scene's.
    default.as_object_mut().unwrap().remove("scenes");
    default["nodes"] = json!([{ "mesh": 0, "name": "child" }, { "children": [0] }]);
    let scene = load_gltf(&default);
    has_the_triangle(&scene, "no scenes");
    assert_eq!(
        scene.unwrap().warnings[0],
        "scene.gltf: there is no scene: all of its nodes are rendered"
    );
}

/// An extension that an object carries is one that the file uses, whether it says so or not.
#[test]
fn undeclared_extensions_are_named_once() {
    let extension = json!({ "EXT_of_nobody": { "extensions": {} } });
    let json = with(triangle_gltf(), "/nodes/0/extensions", extension.clone());
    let json = with(json, "/meshes/0/extensions", extension);
    let json = with(json, "/extras", json!({ "extensions": { "NOT_one": {} } }));
    let declared = with(
        json.clone(),
        "/extensionsUsed",
        json!(["EXT_of_nobody", "EXT_of_nobody"]),
    );
    for json in [json, declared] {
        let scene = load_gltf(&json).expect("a valid glTF");
        assert_eq!(
            scene.warnings,
            [
                "scene.gltf: the extension EXT_of_nobody is not supported and ignored",
                "the scene has no light: the image will be black",
            ]
        );
    }
}

#[test]
fn bad_json_is_refused_with_its_place() {
    let refused = |pointer: &str, value: Value| {
        load_gltf(&with(triangle_gltf(), pointer, value)).expect_err("it must be refused")
    };
    assert_eq!(
        refused("/nodes/0/mesh", json!("triangle")),
        "DIR/scene.gltf: nodes[0].mesh: is not a readable glTF: invalid type: string \"triangle\", expected index into child of root"
    );
    assert_eq!(
        refused("/bufferViews/1", json!({ "buffer": 0 })),
        "DIR/scene.gltf: bufferViews[1]: is not a readable glTF: missing field `byteLength`"
    );
    assert_eq!(
        loaded("scene.glb", glb(&json!([1]), &[])).expect_err("it must be refused"),
        "DIR/scene.glb: is not a readable glTF: its JSON is no object; expected an object with `asset`"
    );
}
