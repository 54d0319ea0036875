//! Valid files of every format, small, with something of all that the format has.

use super::json::glb;
use exr::prelude::*;
use serde_json::{Value, json};
use std::io::Cursor;

/// A scene with something of everything; the files that it names are written beside it.
pub const TOML: &str = r#"[camera]
eye = [0, 1.5, 6]
target = [0, 1, 0]
up = [0, 1, 0]
fov = 40
[film]
width = 2
height = 1
[materials.red]
type = "lambert"
reflectance = [0.6, 0.1, 0.1]
double_sided = false
opacity = 0.75
alpha_cutoff = 0.5
[materials.metal]
type = "conductor"
reflectance = 0.9
alpha = 0.3
[materials.paint]
type = "metallic-roughness"
base_color = [0.5, 0.5, 0.5]
metallic = 0.5
roughness = 0.4
[[shapes]]
type = "rectangle"
material = "red"
corner = [-2, 0, -2]
u = [0, 0, 4]
v = [4, 0, 0]
[[shapes]]
type = "sphere"
material = "metal"
center = [0, 1, 0]
radius = 0.5
transform = [{ scale = 1.5 }, { rotate = { axis = [0, 1, 0], degrees = 30 } }, { translate = [1, 0, 0] }]
[[shapes]]
type = "disk"
name = "lamp"
center = [0, 3, 0]
normal = [0, -1, 0]
radius = 0.25
emission = { radiance = [10, 8, 6], two_sided = true }
[[shapes]]
type = "box"
material = "paint"
min = [-1, 0, -1]
max = [-0.5, 1.25, 0]
transform = [{ matrix = [[1, 0, 0, 0.5], [0, 1, 0, 0], [0, 0, 2, 0], [0, 0, 0, 1]] }]
[[lights]]
type = "spot"
position = [0, 4, 1]
target = [0, 0, 0]
intensity = [20, 20, 20]
inner = 10
outer = 30
[environment]
radiance = [0.1, 0.2, 0.3]
rotation = 45
scale = 2
[render]
strategy = "mis-power"
light_selection = "all"
shadow_rays = 4
spp = 16
seed = 7
confidence = 0.9
[expect]
pixels = [[[0.5, 0.5, 0.5], 0.25]]
source = "none"
tolerance = 0.1
"#;

/// A scene of files, of other lights and of defaults.
pub const TOML_OF_FILES: &str = r#"[camera]
fov = 60
matrix = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 5], [0, 0, 0, 1]]
[[shapes]]
type = "mesh"
file = "mesh.ply"
transform = [{ look_at = { origin = [0, 1, 0], target = [1, 1, 0], up = [0, 1, 0] } }]
[[shapes]]
type = "mesh"
file = "mesh.obj"
emission = { radiance = 3 }
[[gltf]]
file = "part.glb"
transform = [{ scale = [1, 2, 1] }]
[[lights]]
type = "point"
position = [0, 2, 0]
intensity = 5
[[lights]]
type = "directional"
direction = [0, -1, 0.5]
irradiance = [1, 1, 0.9]
[environment]
file = "map.hdr"
interpolation = "nearest"
[expect]
radiance = [0.5, 0.5, 0.5]
source = "a book"
[render]
time = 2.5
error = 0.05
"#;

/// A PLY header of four vertices and two faces.
const PLY_HEADER: &str = "element vertex 4\nproperty float x\nproperty double y\nproperty float z\nproperty uchar red\nelement face 2\nproperty list uchar int vertex_indices\nelement edge 1\nproperty list ushort short ends\nend_header\n";

/// PLY in ascii, little and big endian.
pub fn ply() -> Vec<Vec<u8>> {
    let ascii = format!(
        "ply\nformat ascii 1.0\ncomment a quad and a triangle\n{PLY_HEADER}0 0 0 255\n1 0 0 255\n1 1 0 255\n0 1 0.5 255\n4 0 1 2 3\n3 0 1 3\n2 0 1\n"
    );
    vec![ascii.into_bytes(), binary_ply(false), binary_ply(true)]
}

fn binary_ply(big: bool) -> Vec<u8> {
    let name = if big { "big" } else { "little" };
    let mut bytes = format!("ply\nformat binary_{name}_endian 1.0\n{PLY_HEADER}").into_bytes();
    let mut put = |mut little: Vec<u8>| {
        if big {
            little.reverse();
        }
        bytes.append(&mut little);
    };
    for (x, y) in [(0.0f32, 0.0f64), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
        put(x.to_le_bytes().to_vec());
        put(y.to_le_bytes().to_vec());
        put(0.0f32.to_le_bytes().to_vec());
        put(vec![255]);
    }
    for face in [&[0i32, 1, 2, 3][..], &[0, 1, 3]] {
        put(vec![face.len() as u8]);
        for i in face {
            put(i.to_le_bytes().to_vec());
        }
    }
    for word in [2u16, 0, 1] {
        put(word.to_le_bytes().to_vec());
    }
    bytes
}

/// OBJ files.
pub fn obj() -> Vec<Vec<u8>> {
    vec![
        b"mtllib paint.mtl\no quad\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\ng all\nusemtl red\ns 1\nf 1/1/1 2/1/1 3/1/1 4/1/1\no triangle\nv 0 0 2.125\nf -1 1 2\nl 1 2\np 1\n".to_vec(),
        b"# colours\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1e0 0 0 0 1\nv 0 0 -1.5e-3 1 1 1\nvt 0.5 1\nvn 0 1 0\nf 1 2 3\nf 1//1 3//1 4//-1\ns off\nf 2/1 3/1 4/1\n".to_vec(),
    ]
}

/// Radiance maps: run-length encoded, flat, and with the old runs.
pub fn hdr() -> Vec<Vec<u8>> {
    let header = |size: &str| {
        format!("#?RADIANCE\n# a sky\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=1.5\nGAMMA=1\n\n{size}\n")
            .into_bytes()
    };
    let mut encoded = header("-Y 2 +X 8");
    for _ in 0..2 {
        encoded.extend([2, 2, 0, 8]);
        for channel in [100u8, 120, 140, 129] {
            encoded.extend([128 + 5, channel, 3, channel, 90, channel]);
        }
    }
    let mut flat = header("-Y 2 +X 3");
    flat.extend([100, 120, 140, 129].repeat(6));
    let mut old = header("-Y 1 +X 12");
    old.extend([9, 8, 7, 128, 1, 1, 1, 11]);
    vec![encoded, flat, old]
}

/// OpenEXR maps: every compression that is read, 16 and 32 bits, lines and tiles.
pub fn exr() -> Vec<Vec<u8>> {
    let compressions = [
        Compression::Uncompressed,
        Compression::RLE,
        Compression::ZIP1,
        Compression::ZIP16,
        Compression::PIZ,
        Compression::PXR24,
        Compression::B44,
        Compression::B44A,
        Compression::DWAA(None),
        Compression::DWAB(Some(45.0)),
    ];
    let lines = compressions.map(|compression| exr_of(compression, Blocks::ScanLines));
    let tiles = exr_of(Compression::ZIP1, Blocks::Tiles(Vec2(16, 16)));
    lines.into_iter().chain([tiles]).collect()
}

fn exr_of(compression: Compression, blocks: Blocks) -> Vec<u8> {
    // A block that does not get smaller is not compressed, so those that are to be hold little in
    // many texels.
    let size = match compression {
        Compression::Uncompressed => (6, 5),
        Compression::RLE | Compression::ZIP1 | Compression::B44 => (24, 17),
        _ => (24, 33),
    };
    let texel = |p: Vec2<usize>| {
        let (x, y) = ((p.x() / 12) as f32, (p.y() / 8) as f32);
        (f16::from_f32(0.25 * x), 0.5 + y, f16::from_f32(x * y))
    };
    let encoding = Encoding {
        compression,
        blocks,
        line_order: LineOrder::Increasing,
    };
    let layer = Layer::new(
        size,
        LayerAttributes::named("sky"),
        encoding,
        SpecificChannels::rgb(texel),
    );
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer)
        .write()
        .non_parallel()
        .to_buffered(&mut bytes)
        .expect("a small image can be encoded");
    bytes.into_inner()
}

/// A triangle under a camera and a light, its geometry in a data URI.
pub fn gltf() -> Value {
    use base64::Engine;
    let data = base64::engine::general_purpose::STANDARD.encode(triangle());
    json!({
        "asset": { "version": "2.0" },
        "extensionsUsed": ["KHR_lights_punctual", "KHR_materials_emissive_strength"],
        "extensions": { "KHR_lights_punctual": { "lights": [
            { "type": "spot", "color": [1, 0.9, 0.8], "intensity": 5, "spot": { "innerConeAngle": 0.2, "outerConeAngle": 0.6 } }
        ] } },
        "scene": 0,
        "scenes": [{ "nodes": [0, 2] }],
        "nodes": [
            { "mesh": 0, "name": "triangle", "children": [1], "scale": [1, 2, 1], "rotation": [0, 0.6, 0, 0.8] },
            { "translation": [0, 1, 3], "extensions": { "KHR_lights_punctual": { "light": 0 } } },
            { "camera": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 5, 1] }
        ],
        "cameras": [{ "type": "perspective", "perspective": { "yfov": 0.7, "znear": 0.1, "aspectRatio": 1.5 } }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1, "material": 0, "mode": 4 }] }],
        "materials": [{
            "name": "paint", "doubleSided": true, "emissiveFactor": [0.5, 0.5, 0.5],
            "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 3 } },
            "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0.5, "roughnessFactor": 0.5 }
        }],
        "accessors": [
            { "bufferView": 0, "byteOffset": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] },
            { "bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR" }
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": 36, "byteStride": 12 },
            { "buffer": 0, "byteOffset": 36, "byteLength": 6 }
        ],
        "buffers": [{ "byteLength": 42, "uri": format!("data:application/octet-stream;base64,{data}") }]
    })
}

/// The same as GLB.
pub fn binary_gltf() -> Vec<u8> {
    let mut json = gltf();
    json["buffers"] = json!([{ "byteLength": 42 }]);
    let mut bin = triangle();
    bin.resize(44, 0);
    glb(&json, &bin)
}

/// Three vertices and three indices.
fn triangle() -> Vec<u8> {
    let positions = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let mut bytes: Vec<u8> = positions.iter().flat_map(|x| x.to_le_bytes()).collect();
    bytes.extend([0u16, 1, 2].iter().flat_map(|i| i.to_le_bytes()));
    bytes
}
