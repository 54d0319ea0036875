//! Compressed geometry: meshes that Google's Draco made.

use super::builder::{Builder, mesh_of, triangles_of};
use base64::Engine;
use glam::DVec3;
use serde_json::{Value, json};

/// 16 points (x, y, ¼·((x + y) mod 2)), x and y from 0 to 3, of two triangles per square, with
/// normals +z and texture coordinates (x, y)/3, by Draco 1.5's C++ encoder, quantized to 14, 10 and
/// 12 bits: by EdgeBreaker with the valence traversal, by the standard one, and in sequence.
const GRIDS: [&str; 3] = [
    "RFJBQ08CAgEBAAAAEBICEgMABt/Tp1p9Cv8BEf8Ca0H/AmtBA/8AAQAAAAEAAAEACQMAAgIBAwkCAQACAQEJAwABAwEBAQAPAwEcJwEQAQgBDAYAq8NxD4yr6qoKAKSqqSoAoKoCAKoKAAAAoKoAAAAAVBUAAICpCgAAAFUFAABgqgIAAEBVAQAAAAD/PwAAAAAAAAAAAAAAAAAAAABAQA4FAQEADQMBCBMBFAEcCwEIBgCzqoQ/hqu6qqmaqlHq58DAJyAqaiBqYCAKoAKonwNQAQOfAA4AAAASA/gwggAAAAD/DwAAAAAAAAAAAAAAAIA/DAYDAQEFuAcBGIsBEL8BBP//////////////+wEE/4MBEAsACu2LtlKHDYBggP8DAAD/AQAA/wIRQQo=",
    "RFJBQ08CAgEBAAAAEBIAEgMABt/Tp1p9Cv8BEQH/AAADAwkCAQABCQMAAQAJAwACAgMCAAEBAA0vAUABAKu6qqmaqqoKAKmaqqkKAACgqqqqqqqqqqoKAACQqgCQqqmaqqoKAKwaAKmaqgCgqgAAAAD/DwAAAAMBAAoDATwbAQQDAJ+JAP4DAAAA/wMAAP8BAAAAAQEADzcBQAEAq+qqCgCkqqkqAKCqAgCqSqqaqgIAqSoAkKoAAKqqqqKqqqoAgKqqqgIAqioAkKoAAKmqqgIApKqpSqqaqgIAqioAoKqwqgFAqpKqpqoAAACgqqoqAAAAAP8/AAAAAAAAAAAAAAAAgD8MCgAAAAAAAAAAAAAAAAAAQEAO",
    "RFJBQ08CAgEAAAASEAEAAQUABQQBAgYBBgUCAwcCBwYEBQkECQgFBgoFCgkGBwsGCwoICQ0IDQwJCg4JDg0KCw8KDw4BAwMJAgEAAQkDAAEACQMAAgIDAgABAQANAwEEJwE8AwAgi6gqAKgqAKgqAAiAqqoqAKgqAKgqAAiAqqoqAKgqAKgqAAiAqqoqAKgqAKgqAAAAAAAA/w8AAAADAQAKAwE8GwEEAwCfiQD+AwAAAP8DAAD/AQAAAAEBAA8DAQQvATwDACCLUFUBAFVFVQUAUhVVFQBQVQQAVRUAUFUBgFRFVQUAVBVVFQBIVQQAVRUAUFUBAFVFVQUAUhVVFQBQVQQAVRUAUFUBgFRFVQUAVBVVFQBIVQAAAAAA/z8AAAAAAAAAAAAAAACAPwwKAAAAAAAAAAAAAAAAAABAQA4=",
];

/// A file of a grid; its accessors have no data of their own.
fn grid(encoded: &[u8]) -> Builder {
    let mut builder = Builder::new();
    let view = builder.view(encoded);
    let mut bare = |kind: &str, component: u32, count: usize| {
        let accessor = json!({ "componentType": component, "type": kind, "count": count });
        builder.add("accessors", accessor)
    };
    let attributes = json!({
        "POSITION": bare("VEC3", 5126, 16), "NORMAL": bare("VEC3", 5126, 16),
        "TEXCOORD_0": bare("VEC2", 5126, 16)
    });
    let indices = bare("SCALAR", 5123, 54);
    let extension = json!({
        "bufferView": view, "attributes": { "POSITION": 2, "NORMAL": 1, "TEXCOORD_0": 0 }
    });
    let mesh = builder.mesh(json!({
        "attributes": attributes, "indices": indices,
        "extensions": { "KHR_draco_mesh_compression": extension }
    }));
    builder.root(json!({ "mesh": mesh }));
    builder.json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    builder
}

fn decoded(base64: &str) -> Vec<u8> {
    let engine = base64::engine::general_purpose::STANDARD;
    engine.decode(base64).expect("valid base64")
}

#[test]
fn draco_s_meshes_are_decoded() {
    for (number, text) in GRIDS.iter().enumerate() {
        let scene = grid(&decoded(text)).scene();
        let mesh = mesh_of(&scene, 0);
        assert_eq!(
            (mesh.positions.len(), mesh.triangles.len()),
            (16, 18),
            "{number}"
        );
        // Half a step of 3/2¹⁴, and of 1/2¹² of the texture coordinates.
        for (p, uv) in mesh.positions.iter().zip(&mesh.uvs) {
            let (x, y) = (p.x.round(), p.y.round());
            let expected = DVec3::new(x, y, 0.25 * ((x + y) % 2.0));
            assert!(p.distance(expected) < 3.0 / 16_384.0, "{number}: {p}");
            assert!(
                uv.distance(expected.truncate() / 3.0) < 1.0 / 4096.0,
                "{number}: {uv}"
            );
        }
        for n in &mesh.normals {
            assert!(n.normalize().distance(DVec3::Z) < 0.01, "{number}: {n}");
        }
        let area: f64 = triangles_of(&scene, 0)
            .iter()
            .map(|[a, b, c]| {
                let z = 0.5 * (*b - *a).cross(*c - *a).z;
                assert!(
                    (z - 0.5).abs() < 1e-3,
                    "{number}: half a square that faces up"
                );
                z
            })
            .sum();
        assert!((area - 9.0).abs() < 1e-2, "{number}: {area}");
        assert_eq!(
            scene.warnings,
            ["the scene has no light: the image will be black"]
        );
    }
}

#[test]
fn bad_draco_meshes_are_named() {
    let field = "DIR/scene.glb: meshes[0].primitives[0].extensions.KHR_draco_mesh_compression";
    let bytes = decoded(GRIDS[1]);
    let cut = grid(&bytes[..bytes.len() / 2]).refused();
    let expected = format!("{field}: bufferView 0 cannot be decoded: ");
    assert!(cut.starts_with(&expected), "{cut}");
    let text = grid(b"no mesh at all").refused();
    assert!(text.starts_with(&expected), "{text}");

    let pointer = "/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression";
    let refused = |member: &str, value: Value| {
        let mut builder = grid(&bytes);
        builder.json.pointer_mut(pointer).unwrap()[member] = value;
        builder.refused()
    };
    assert_eq!(
        refused("bufferView", json!(4)),
        format!("{field}.bufferView: bufferView 4 is out of range; expected 0, the only one")
    );
    assert_eq!(
        refused("attributes", json!({ "POSITION": 9 })),
        format!(
            "{field}.attributes: attribute 9 is not in the compressed mesh; expected one of [0, 1, 2]"
        )
    );
    assert_eq!(
        refused("attributes", json!({ "POSITION": 0 })),
        "DIR/scene.glb: meshes[0].primitives[0].attributes.POSITION: has 2 numbers in Draco's mesh; expected 3, Vec3"
    );
    let message = refused("attributes", json!("all"));
    assert!(message.contains(": is not understood: "), "{message}");
    for length in 0..bytes.len() {
        let message = grid(&bytes[..length]).refused();
        assert!(
            message.starts_with("DIR/scene.glb: "),
            "{length}: {message}"
        );
    }
}

/// Every bit turned: a mesh that is damaged is refused in words, or read as another mesh.
#[test]
fn damaged_draco_meshes_are_survived() {
    for text in GRIDS {
        let bytes = decoded(text);
        let mut refused = 0;
        for bit in 0..8 * bytes.len() {
            let mut damaged = bytes.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            refused += usize::from(grid(&damaged).load().is_err());
        }
        assert!(refused > bytes.len() / 8, "{refused} were refused");
    }
}
