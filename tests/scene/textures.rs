//! Textures, vertex normals and texture coordinates from files.

use super::files::{Folder, load_gltf, triangle_gltf, with};
use direkt::scene::environment::Interpolation;
use direkt::scene::{Bsdf, Geometry, Mesh, Scene, Texels, Wrap};
use glam::{DVec2, DVec3};
use image::{DynamicImage, ImageBuffer, ImageFormat, Luma, Rgb};
use insta::assert_snapshot;
use serde_json::{Value, json};
use std::io::Cursor;

fn encoded(image: &DynamicImage) -> Vec<u8> {
    let mut bytes = Vec::new();
    image
        .write_to(&mut Cursor::new(&mut bytes), ImageFormat::Png)
        .expect("a PNG can be written");
    bytes
}

/// A PNG of one row.
pub(super) fn png(texels: &[[u8; 3]]) -> Vec<u8> {
    let row = ImageBuffer::from_fn(texels.len() as u32, 1, |x, _| Rgb(texels[x as usize]));
    encoded(&DynamicImage::ImageRgb8(row))
}

fn grey_png() -> Vec<u8> {
    let row = ImageBuffer::from_fn(2, 1, |x, _| Luma([x as u8]));
    encoded(&DynamicImage::ImageLuma8(row))
}

/// `json` with texture 0, of image 0, whose encoded bytes are `bytes`.
pub(super) fn with_texture(json: Value, bytes: &[u8]) -> Value {
    use base64::Engine;
    let data = base64::engine::general_purpose::STANDARD.encode(bytes);
    let uri = format!("data:image/png;base64,{data}");
    let json = with(json, "/images", json!([{ "uri": uri }]));
    with(json, "/textures", json!([{ "source": 0 }]))
}

/// The triangle with normals (0, 0, 2) and texture coordinates as unsigned bytes.
fn textured_triangle() -> Value {
    use base64::Engine;
    let mut bytes: Vec<u8> = (0..3)
        .flat_map(|_| [0.0f32, 0.0, 2.0])
        .flat_map(f32::to_le_bytes)
        .collect();
    bytes.extend([0, 0, 0, 0, 255, 0, 0, 0, 0, 255, 0, 0]);
    let data = base64::engine::general_purpose::STANDARD.encode(&bytes);
    let mut json = triangle_gltf();
    let uri = format!("data:application/octet-stream;base64,{data}");
    let mut add = |list: &str, value: Value| {
        json[list].as_array_mut().expect("a list").push(value);
    };
    add("buffers", json!({ "byteLength": 48, "uri": uri }));
    add("bufferViews", json!({ "buffer": 1, "byteLength": 36 }));
    add(
        "bufferViews",
        json!({ "buffer": 1, "byteOffset": 36, "byteLength": 12, "byteStride": 4 }),
    );
    add(
        "accessors",
        json!({ "bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC3" }),
    );
    add(
        "accessors",
        json!({ "bufferView": 3, "componentType": 5121, "normalized": true, "count": 3, "type": "VEC2" }),
    );
    let attributes = json!({ "POSITION": 0, "NORMAL": 2, "TEXCOORD_0": 3 });
    with(json, "/meshes/0/primitives/0/attributes", attributes)
}

fn mesh(scene: &Scene) -> &Mesh {
    match &scene.shapes[0].geometry {
        Geometry::Mesh(mesh) => mesh,
        other => panic!("{other:?} is no mesh"),
    }
}

#[test]
fn gltf_textures_come_with_sampler_and_transform() {
    let material = json!([{
        "pbrMetallicRoughness": { "baseColorTexture": {
            "index": 0,
            "extensions": { "KHR_texture_transform": { "offset": [0.5, 0.25], "scale": [2, 3] } }
        } },
        "normalTexture": { "index": 0, "scale": 0.5 }
    }]);
    let json = with(textured_triangle(), "/materials", material);
    let json = with_texture(json, &png(&[[255, 0, 188], [0, 255, 64]]));
    let json = with(json, "/textures/0/sampler", json!(0));
    let sampler = json!([{ "magFilter": 9728, "wrapS": 33071, "wrapT": 33648 }]);
    let scene = load_gltf(&with(json, "/samplers", sampler)).expect("a valid glTF");
    let textures = scene.materials[0].textures;
    let color = textures.color.expect("a base colour texture");
    assert_eq!(color.wrap, [Wrap::Clamp, Wrap::Mirror]);
    assert_eq!(color.interpolation, Interpolation::Nearest);
    assert_eq!(
        color.transform.transform_point2(DVec2::ONE),
        DVec2::new(2.5, 3.25)
    );
    let normal = textures.normal.expect("a normal map");
    assert!((normal.scale - 0.5).abs() < 1e-12);
    // The same image as a colour, decoded, and as numbers, as they are.
    assert_eq!(scene.textures.len(), 2);
    assert!(matches!(
        scene.textures[color.texture.index()].texels,
        Texels::Halves(_)
    ));
    let decoded = scene.textures[color.texture.index()].texel(0, 0);
    assert!((decoded.z - 0.502_886).abs() < 5e-4, "{decoded}");
    let numbers = scene.textures[normal.texture.texture.index()].texel(0, 0);
    assert!((numbers.z - 188.0 / 255.0).abs() < 1e-12, "{numbers}");
    assert_eq!(
        mesh(&scene).normals,
        [DVec3::new(0.0, 0.0, 2.0).normalize(); 3]
    );
    assert_eq!(mesh(&scene).uvs, [DVec2::ZERO, DVec2::X, DVec2::Y]);
}

/// Where the factor is black nothing emits, whatever the texture says.
#[test]
fn gltf_materials_emit_textures() {
    let material = |factor: f64| {
        let material = json!([{
            "emissiveFactor": [factor, factor, factor],
            "emissiveTexture": { "index": 0 },
            "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 6 } }
        }]);
        let json = with(textured_triangle(), "/materials", material);
        let used = json!(["KHR_materials_emissive_strength"]);
        with(json, "/extensionsUsed", used)
    };
    let two = png(&[[255, 0, 188], [0, 255, 64]]);
    let scene = load_gltf(&with_texture(material(0.5), &two)).expect("a valid glTF");
    let emission = scene.shapes[0].emission.expect("it emits");
    let texture = emission.texture.expect("a texture");
    assert_eq!(emission.radiance, DVec3::splat(3.0));
    let decoded = scene.textures[texture.texture.index()].texel(0, 0);
    assert!((decoded.z - 0.502_886).abs() < 5e-4, "{decoded}");
    assert_eq!(mesh(&scene).uvs, [DVec2::ZERO, DVec2::X, DVec2::Y]);

    let constant = png(&[[0, 255, 188]; 3]);
    let scene = load_gltf(&with_texture(material(0.5), &constant)).expect("a valid glTF");
    let emission = scene.shapes[0].emission.expect("it emits");
    assert_eq!(emission.texture, None, "one value is a factor");
    assert!((emission.radiance - DVec3::new(0.0, 3.0, 1.508_66)).length() < 2e-3);

    let scene = load_gltf(&with_texture(material(0.0), &two)).expect("a valid glTF");
    assert_eq!(scene.shapes[0].emission, None);
}

/// A colour of one value is a factor, a flat normal map nothing; a material then reads no texture.
#[test]
fn constant_textures_call_for_nothing() {
    let material = json!([{
        "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 }, "baseColorFactor": [0.5, 0.5, 0.5, 1] },
        "normalTexture": { "index": 0 }
    }]);
    let json = with(textured_triangle(), "/materials", material);
    let scene = load_gltf(&with_texture(json, &png(&[[127, 128, 255]; 3]))).expect("a valid glTF");
    assert!(!scene.materials[0].textures.any());
    let Bsdf::MetallicRoughness { base_color, .. } = scene.materials[0].bsdf else {
        panic!("glTF's model");
    };
    assert!(
        (base_color.z - 0.5).abs() < 1e-6 && base_color.x < 0.12,
        "{base_color}"
    );
}

#[test]
fn ply_and_obj_bring_normals_and_texture_coordinates() {
    let folder = Folder::new();
    folder.write(
        "mesh.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
         property float nx\nproperty float ny\nproperty float nz\nproperty float s\nproperty float t\n\
         element face 1\nproperty list uchar int vertex_indices\nend_header\n\
         0 0 0 0 0 1 0 0\n1 0 0 0 1 0 1 0\n0 1 0 1 0 0 0 1\n3 0 1 2\n",
    );
    folder.write(
        "mesh.obj",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvn 0 1 0\nvn 1 0 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1/1 2/2/2 3/3/3\n",
    );
    for name in ["mesh.ply", "mesh.obj"] {
        let shape = format!(
            "[environment]\nradiance = 1\n[[shapes]]\ntype = \"mesh\"\nfile = \"{name}\"\n"
        );
        folder.write("scene.toml", shape);
        let scene = folder.load("scene.toml").expect("a valid scene");
        let mesh = mesh(&scene);
        assert_eq!(mesh.normals, [DVec3::Z, DVec3::Y, DVec3::X], "{name}");
        // Up in the file, down in the image.
        let uvs = [
            DVec2::new(0.0, 1.0),
            DVec2::new(1.0, 1.0),
            DVec2::new(0.0, 0.0),
        ];
        assert_eq!(mesh.uvs, uvs, "{name}");
    }
}

fn refused(textures: &str, files: &[(&str, Vec<u8>)]) -> String {
    let folder = Folder::new();
    for (name, bytes) in files {
        folder.write(name, bytes);
    }
    let text = format!(
        "[environment]\nradiance = 1\n[materials.m]\ntype = \"lambert\"\nreflectance = 1\n{textures}\n"
    );
    folder.write("scene.toml", text);
    folder
        .load("scene.toml")
        .expect_err("the scene must be refused")
}

#[test]
fn bad_textures_are_named() {
    let mut header = png(&[[1, 2, 3]]);
    // A PNG's width and height, here 40,000 each, are bytes 16 to 23, and bytes 29 to 32 their
    // checksum.
    header[16..24].copy_from_slice(&[0, 0, 0x9c, 0x40, 0, 0, 0x9c, 0x40]);
    header[29..33].copy_from_slice(&[0xde, 0x6e, 0x99, 0x52]);
    let color = |file: &str| format!("textures.color = {{ file = \"{file}\" }}");
    let grey = || [("grey.png", grey_png())];
    let messages = [
        refused(&color("none.png"), &[]),
        refused(&color("text.png"), &[("text.png", b"no image".to_vec())]),
        refused(&color("large.png"), &[("large.png", header)]),
        refused(
            "textures.metallic_roughness = { file = \"rgb.png\" }",
            &[("rgb.png", png(&[[1, 2, 3], [3, 2, 1]]))],
        ),
        refused("textures.normal_scale = 2", &[]),
        refused("textures.bump = { file = \"grey.png\" }", &[]),
        refused(
            "textures.color = { file = \"grey.png\", wrap = [\"clamp\", \"tile\"] }",
            &grey(),
        ),
        refused(
            "textures.color = { file = \"grey.png\", repeat = [1e400, 1] }",
            &grey(),
        ),
    ];
    assert_snapshot!(messages.join("\n"));
}

#[test]
fn gltf_attributes_are_as_many_as_positions() {
    let json = with(textured_triangle(), "/accessors/2/count", json!(2));
    let message = load_gltf(&json).expect_err("too few normals");
    assert_eq!(
        message,
        "DIR/scene.gltf: meshes[0].primitives[0].attributes.NORMAL: has 2 elements; expected as many as POSITION, 3"
    );
}

/// A material with textures on what no texture can be laid over is worth a warning each, and on a
/// rectangle none.
#[test]
fn textures_without_coordinates_are_told() {
    let folder = Folder::new();
    folder.write("t.png", png(&[[1, 2, 3]]));
    folder.write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let shape = |kind: &str| format!("[[shapes]]\nmaterial = \"m\"\n{kind}\n");
    let sphere = shape("type = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1");
    let text = "[environment]\nradiance = 1\n[camera]\neye = [0, 0, 9]\ntarget = [0, 0, 0]\nfov = 40\n\
                [materials.m]\ntype = \"lambert\"\nreflectance = 1\ntextures.color = { file = \"t.png\" }\n";
    let scene = [
        text.to_owned(),
        sphere.clone(),
        sphere + "transform = [{ scale = [1, 2, 1] }]\n",
        shape("type = \"mesh\"\nfile = \"m.obj\""),
        shape("type = \"rectangle\"\ncorner = [0, 0, 0]\nu = [1, 0, 0]\nv = [0, 1, 0]"),
    ];
    folder.write("scene.toml", scene.concat());
    let scene = folder.load("scene.toml").expect("a valid scene");
    let warning = |shape: u32, what: &str| {
        format!(
            "shapes[{shape}]: material `m` has textures, and {what} has no texture coordinates: its factors are used"
        )
    };
    let expected = [
        warning(0, "a sphere"),
        warning(1, "a sphere"),
        warning(2, "the mesh"),
    ];
    assert_eq!(scene.warnings, expected);
}
