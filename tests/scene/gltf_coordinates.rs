//! Several sets of texture coordinates in a glTF.

use super::builder::{Builder, TRIANGLE, mesh_of};
use super::textures::png;
use direkt::scene::Scene;
use glam::DVec2;
use serde_json::{Value, json};

/// The triangle with TEXCOORD_0 … TEXCOORD_3, whose last corner is (0, n) in TEXCOORD_n, and
/// texture 0, under `material`.
fn coordinates(material: Value) -> Builder {
    let mut builder = Builder::new();
    let positions = builder.floats(&TRIANGLE);
    let mut attributes = json!({ "POSITION": positions });
    for set in 0..4 {
        let uvs = builder.floats(&[[0.0, 0.0], [1.0, 0.0], [0.0, set as f32]]);
        attributes[format!("TEXCOORD_{set}")] = json!(uvs);
    }
    builder.mesh(json!({ "attributes": attributes, "material": 0 }));
    let view = builder.view(&png(&[[255, 0, 0], [0, 255, 0]]));
    builder.add(
        "images",
        json!({ "bufferView": view, "mimeType": "image/png" }),
    );
    builder.add("textures", json!({ "source": 0 }));
    builder.add("materials", material);
    builder.root(json!({ "mesh": 0 }));
    builder
}

/// The sets that the mesh carries, by their last corners.
fn sets(scene: &Scene) -> [Option<f64>; 2] {
    let mesh = mesh_of(scene, 0);
    [&mesh.uvs, &mesh.second_uvs].map(|uvs| uvs.last().map(|uv| uv.y))
}

/// The first two sets that the material names, in that order, whatever their numbers;
/// KHR_texture_transform has the last word.
#[test]
fn a_material_reads_two_sets() {
    let moved = json!({ "KHR_texture_transform": { "texCoord": 3, "offset": [0.5, 0] } });
    let scene = coordinates(json!({
        "pbrMetallicRoughness": {
            "baseColorTexture": { "index": 0, "texCoord": 2 },
            "metallicRoughnessTexture": { "index": 0, "texCoord": 1, "extensions": moved }
        },
        "normalTexture": { "index": 0, "texCoord": 2 },
        "emissiveFactor": [1, 1, 1],
        "emissiveTexture": { "index": 0, "texCoord": 3 }
    }))
    .scene();
    assert_eq!(sets(&scene), [Some(2.0), Some(3.0)]);
    let textures = scene.materials[0].textures;
    assert!(!textures.color.unwrap().second_uvs);
    assert!(textures.metallic_roughness.unwrap().second_uvs);
    assert!(!textures.normal.unwrap().texture.second_uvs);
    let emitted = scene.shapes[0].emission.unwrap().texture.unwrap();
    assert!(emitted.second_uvs);
    assert_eq!(scene.warnings, [""; 0]);
}

/// One set is the mesh's first, whatever its number; a material without textures keeps TEXCOORD_0.
#[test]
fn one_set_is_the_first() {
    let texture = json!({ "index": 0, "texCoord": 3 });
    let scene = coordinates(json!({ "normalTexture": texture })).scene();
    assert_eq!(sets(&scene), [Some(3.0), None]);
    let textures = scene.materials[0].textures;
    assert!(!textures.normal.unwrap().texture.second_uvs);
    assert_eq!(sets(&coordinates(json!({})).scene()), [Some(0.0), None]);
}

/// A third set is left out with one sentence, which names it.
#[test]
fn a_third_set_is_named() {
    let scene = coordinates(json!({
        "pbrMetallicRoughness": {
            "baseColorTexture": { "index": 0 },
            "metallicRoughnessTexture": { "index": 0, "texCoord": 1 }
        },
        "normalTexture": { "index": 0, "texCoord": 2 },
        "emissiveFactor": [1, 1, 1],
        "emissiveTexture": { "index": 0, "texCoord": 3 }
    }))
    .scene();
    assert_eq!(sets(&scene), [Some(0.0), Some(1.0)]);
    assert_eq!(scene.materials[0].textures.normal, None);
    assert_eq!(scene.shapes[0].emission.unwrap().texture, None);
    assert_eq!(
        scene.warnings,
        [
            "scene.glb: materials[0] reads textures with more than two sets of texture coordinates: beside TEXCOORD_0 and TEXCOORD_1, those with TEXCOORD_2, TEXCOORD_3 are ignored"
        ]
    );
}

/// Two primitives have the same material, and one of them one of its two sets: each reads what it
/// can.
#[test]
fn a_primitive_without_one_of_the_sets_reads_the_other() {
    for missing in [0, 1] {
        let mut builder = coordinates(json!({
            "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } },
            "normalTexture": { "index": 0, "texCoord": 1 }
        }));
        let primitives = &mut builder.json["meshes"][0]["primitives"];
        let mut second = primitives[0].clone();
        let attributes = second["attributes"].as_object_mut().unwrap();
        attributes.remove(&format!("TEXCOORD_{missing}"));
        primitives.as_array_mut().unwrap().push(second);
        let scene = builder.scene();
        let [whole, half] = [0, 1].map(|s| &scene.materials[scene.shapes[s].material.index()]);
        assert!(whole.textures.color.is_some() && whole.textures.normal.is_some());
        assert_eq!(half.textures.color.is_some(), missing == 1);
        assert_eq!(half.textures.normal.is_some(), missing == 0);
        assert!(half.texture_uses().all(|used| !used.second_uvs));
        let last = mesh_of(&scene, 1).uvs.last();
        assert_eq!(last, Some(&DVec2::new(0.0, f64::from(1 - missing))));
        assert_eq!(
            scene.warnings[0],
            "scene.glb: textures of 1 primitive have no texture coordinates: their factors are used"
        );
    }
}
