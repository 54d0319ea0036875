//! Morph targets and skins: meshes in the pose that their nodes and weights have at rest.

use super::builder::{Builder, CORNERS, TRIANGLE, bytes, mesh_of, triangles_of};
use glam::{DQuat, DVec3};
use serde_json::{Value, json};

/// The triangle with two targets: the first lifts its last corner and turns its normals, the second
/// moves all by x.
fn morphing(node: Value, of_mesh: Value) -> Builder {
    let mut builder = Builder::new();
    let positions = builder.floats(&TRIANGLE);
    let normals = builder.floats(&[[0.0, 0.0, 1.0]; 3]);
    let accessor = json!({ "componentType": 5126, "type": "VEC3", "count": 3 });
    let lifted = builder.add("accessors", accessor);
    let places = builder.view(&[2]);
    let values = builder.view(&bytes(&[0.0f32, 0.0, 4.0], f32::to_le_bytes));
    let sparse = json!({ "sparse": {
        "count": 1,
        "indices": { "bufferView": places, "componentType": 5121 },
        "values": { "bufferView": values }
    } });
    builder.amend("accessors", lifted, sparse);
    let turned = builder.floats(&[[0.0, -1.0, 0.0]; 3]);
    let moved = builder.accessor(5120, "VEC3", 3, &[1, 0, 0, 1, 0, 0, 1, 0, 0]);
    let mesh = json!({
        "primitives": [{
            "attributes": { "POSITION": positions, "NORMAL": normals },
            "targets": [{ "POSITION": lifted, "NORMAL": turned }, { "POSITION": moved }]
        }],
        "weights": of_mesh
    });
    builder.add("meshes", mesh);
    builder.root(json!({ "mesh": 0, "scale": [2, 2, 2], "weights": node }));
    builder
}

/// The node's weights count, then the mesh's; without any the base shape is what there is.
#[test]
fn morph_targets_displace_by_their_weights() {
    for (node, of_mesh, lift, shift) in [
        (Value::Null, Value::Null, 0.0, 0.0),
        (Value::Null, json!([0.25, -3]), 0.25, -3.0),
        (json!([0.5, 0]), json!([0.25, -3]), 0.5, 0.0),
        (json!([0, 0]), json!([0.25, -3]), 0.0, 0.0),
    ] {
        let scene = morphing(node, of_mesh).scene();
        let [a, b, c] = CORNERS.map(|corner| 2.0 * (corner + shift * DVec3::X));
        let expected = [a, b, c + 8.0 * lift * DVec3::Z];
        assert_eq!(triangles_of(&scene, 0), [expected]);
        let normal = DVec3::new(0.0, -lift, 1.0).normalize();
        for got in &mesh_of(&scene, 0).normals {
            assert!(got.normalize().distance(normal) < 1e-12, "{got}");
        }
        assert_eq!(
            scene.warnings,
            ["the scene has no light: the image will be black"]
        );
    }
}

/// Displaced colours and texture coordinates are told, where a target has a weight.
#[test]
fn displacements_that_are_not_read_are_told() {
    let warnings = |of_mesh: Value| {
        let mut builder = morphing(Value::Null, of_mesh);
        builder.json["meshes"][0]["primitives"][0]["targets"][1]["COLOR_0"] = json!(0);
        builder.scene().warnings
    };
    let dark = "the scene has no light: the image will be black";
    let told = "scene.glb: morph targets displace positions, normals and tangents alone: their COLOR_0 are ignored";
    assert_eq!(warnings(json!([0, 1])), [told, dark]);
    assert_eq!(warnings(json!([0, 0])), [dark]);
}

/// Two nodes show the same mesh in different poses.
#[test]
fn a_pose_is_its_node_s_own() {
    let mut builder = morphing(json!([1, 0]), Value::Null);
    builder.root(json!({ "mesh": 0 }));
    let scene = builder.scene();
    assert_eq!(triangles_of(&scene, 1), [CORNERS]);
    assert_eq!(triangles_of(&scene, 0)[0][2], DVec3::new(0.0, 2.0, 8.0));
}

#[test]
fn bad_morph_weights_are_named() {
    assert_eq!(
        morphing(json!([1]), Value::Null).refused(),
        "DIR/scene.glb: nodes[0].weights: has 1 elements; expected one for each of the 2 targets of meshes[0].primitives[0]"
    );
    assert_eq!(
        morphing(Value::Null, json!([1, 2, 3])).refused(),
        "DIR/scene.glb: meshes[0].weights: has 3 elements; expected one for each of the 2 targets of meshes[0].primitives[0]"
    );
    assert_eq!(
        morphing(json!([1e39, 0]), Value::Null).refused(),
        "DIR/scene.glb: nodes[0].weights[0]: is inf; expected a finite number"
    );
    let mut builder = morphing(json!([1, 0]), Value::Null);
    builder.json["meshes"][0]["primitives"][0]["targets"][0]["POSITION"] = json!(9);
    assert_eq!(
        builder.refused(),
        "DIR/scene.glb: meshes[0].primitives[0].targets[0].POSITION: accessor 9 is out of range; expected 0 to 4"
    );
    let short = builder.floats(&[[1.0; 3]]);
    builder.json["meshes"][0]["primitives"][0]["targets"][0]["POSITION"] = json!(short);
    assert_eq!(
        builder.refused(),
        "DIR/scene.glb: meshes[0].primitives[0].targets[0].POSITION: has 1 elements; expected as many as POSITION, 3"
    );
}

/// A column of matrix entries, as MAT4 has them: scale by `s`, then a move to `at`.
fn matrix(s: [f32; 3], at: [f32; 3]) -> [f32; 16] {
    let mut m = [0.0; 16];
    (m[0], m[5], m[10], m[15]) = (s[0], s[1], s[2], 1.0);
    m[12..15].copy_from_slice(&at);
    m
}

/// The triangle under a skin with two joints: node 1 is the first, node 2 below it the second.
/// Corners 0 and 1 follow the first, corner 2 half of each.
fn skinned() -> Builder {
    let mut builder = Builder::new();
    let positions = builder.floats(&TRIANGLE);
    let normals = builder.floats(&[[0.0, 0.0, 1.0]; 3]);
    let joints = builder.accessor(5121, "VEC4", 3, &[0, 9, 9, 9, 0, 0, 0, 0, 1, 0, 0, 0]);
    let weights = builder.floats(&[
        [1.0, 0.0, 0.0, 0.0],
        [0.5, 0.5, 0.0, 0.0],
        [0.5, 0.5, 0.0, 0.0],
    ]);
    builder.mesh(json!({ "attributes": {
        "POSITION": positions, "NORMAL": normals, "JOINTS_0": joints, "WEIGHTS_0": weights
    } }));
    let binds = builder.floats(&[
        matrix([1.0; 3], [0.0; 3]),
        matrix([1.0; 3], [0.0, -1.0, 0.0]),
    ]);
    builder.add(
        "skins",
        json!({ "joints": [1, 2], "inverseBindMatrices": binds }),
    );
    builder.root(json!({ "mesh": 0, "skin": 0, "translation": [100, 0, 0], "scale": [7, 7, 7] }));
    builder.root(json!({ "translation": [0, 0, 5], "children": [2] }));
    let quarter = DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2).to_array();
    builder.add(
        "nodes",
        json!({ "translation": [0, 1, 0], "rotation": quarter }),
    );
    builder
}

/// Joint 0 moves by (0, 0, 5). Joint 1 stands at (0, 1, 5), where it was bound but for that move,
/// turned about x by 90°: it leaves (0, 1, 0) where it is, and takes (0, 0, 1) to (0, −1, 0). The
/// mesh's own node has no part in it.
#[test]
fn skins_take_vertices_where_their_joints_stand() {
    let scene = skinned().scene();
    let up = 5.0 * DVec3::Z;
    let [a, b, c] = triangles_of(&scene, 0)[0];
    assert!(a.distance(up) < 1e-6 && b.distance(up + DVec3::X) < 1e-6);
    assert!(c.distance(up + DVec3::Y) < 1e-6, "{c}");
    let normals = &mesh_of(&scene, 0).normals;
    assert!(normals[0].normalize().distance(DVec3::Z) < 1e-6);
    // The mean of both matrices, its inverse transposed: (0, −1, 1), which a turn by 45° has as
    // well.
    let expected = DVec3::new(0.0, -1.0, 1.0).normalize();
    assert!(
        normals[2].normalize().distance(expected) < 1e-6,
        "{}",
        normals[2]
    );
    assert_eq!(
        scene.warnings,
        ["the scene has no light: the image will be black"]
    );
}

/// More than four joints per vertex, weights as integers, and joints outside of the scene; no
/// inverse bind matrices.
#[test]
fn skins_with_two_sets_of_joints() {
    let mut builder = Builder::new();
    let positions = builder.floats(&TRIANGLE);
    let zeros = builder.accessor(5121, "VEC4", 3, &[0; 12]);
    let ones: Vec<u8> = [0u16, 1, 0, 0]
        .iter()
        .flat_map(|j| j.to_le_bytes())
        .collect();
    let ones = builder.accessor(5123, "VEC4", 3, &ones.repeat(3));
    let first = builder.accessor(5121, "VEC4", 3, &[51, 0, 0, 0].repeat(3));
    let second: Vec<u8> = [0u16, 52_428, 0, 0]
        .iter()
        .flat_map(|j| j.to_le_bytes())
        .collect();
    let second = builder.accessor(5123, "VEC4", 3, &second.repeat(3));
    for weights in [first, second] {
        builder.amend("accessors", weights, json!({ "normalized": true }));
    }
    builder.mesh(json!({ "attributes": {
        "POSITION": positions,
        "JOINTS_0": zeros, "WEIGHTS_0": first, "JOINTS_1": ones, "WEIGHTS_1": second
    } }));
    builder.add("skins", json!({ "joints": [1, 3] }));
    builder.root(json!({ "mesh": 0, "skin": 0 }));
    builder.root(json!({}));
    builder.add(
        "nodes",
        json!({ "translation": [10, 0, 0], "children": [3] }),
    );
    builder.add("nodes", json!({ "translation": [0, 10, 0] }));
    let scene = builder.scene();
    // A fifth of joint 0, which stands still, and four fifths of joint 1, at (10, 10, 0).
    let by = DVec3::new(8.0, 8.0, 0.0);
    for (got, corner) in triangles_of(&scene, 0)[0].iter().zip(CORNERS) {
        assert!(got.distance(corner + by) < 1e-9, "{got}");
    }
    builder.json["nodes"][3]["children"] = json!([2]);
    assert_eq!(
        builder.refused(),
        "DIR/scene.glb: nodes[3].children: node 3 is below itself; expected a tree: no cycle, and one parent for each node"
    );
}

/// A mesh is morphed before its skin moves it; what the including scene does comes last.
#[test]
fn a_skin_moves_what_is_morphed() {
    let mut builder = skinned();
    let deltas = builder.floats(&[[0.0, 0.0, 3.0]; 3]);
    builder.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": deltas }]);
    builder.json["meshes"][0]["weights"] = json!([2]);
    let folder = super::files::Folder::new();
    folder.write("part.glb", builder.glb());
    let text = "[[gltf]]\nfile = \"part.glb\"\ntransform = [{ scale = 10 }]\n";
    folder.write("scene.toml", text);
    let scene = folder.load("scene.toml").expect("a valid scene");
    let [a, ..] = triangles_of(&scene, 0)[0];
    assert!(a.distance(110.0 * DVec3::Z) < 1e-6, "{a}");
}

/// The node's mirror turns the winding, and nothing else of it counts (glTF 2.0, section 3.7.4).
#[test]
fn a_mirrored_node_turns_the_winding_of_its_skin() {
    let mut builder = skinned();
    builder.json["nodes"][2]["rotation"] = json!([0, 0, 0, 1]);
    let area = |builder: &Builder| {
        let [a, b, c] = triangles_of(&builder.scene(), 0)[0];
        (b - a).cross(c - a).z
    };
    assert!((area(&builder) - 1.0).abs() < 1e-6);
    builder.json["nodes"][0]["scale"] = json!([-7, 7, 7]);
    assert!((area(&builder) + 1.0).abs() < 1e-6);
}

#[test]
fn bad_skins_are_named() {
    let refused = |pointer: &str, value: Value| {
        let mut builder = skinned();
        *builder.json.pointer_mut(pointer).expect("it is there") = value;
        builder.refused()
    };
    assert_eq!(
        refused("/nodes/0/skin", json!(2)),
        "DIR/scene.glb: nodes[0].skin: skin 2 is out of range; expected 0, the only one"
    );
    assert_eq!(
        refused("/skins/0/joints/1", json!(8)),
        "DIR/scene.glb: skins[0].joints[1]: node 8 is out of range; expected 0 to 2"
    );
    assert_eq!(
        refused("/skins/0/joints", json!([1])),
        "DIR/scene.glb: meshes[0].primitives[0].attributes.JOINTS_0: joint 1 is out of range; expected an index of the skin's 1 joints"
    );
    assert_eq!(
        refused("/skins/0/joints", json!([1, 2, 1])),
        "DIR/scene.glb: skins[0].inverseBindMatrices: has 2 elements; expected one for each of the 3 joints"
    );
    assert_eq!(
        refused(
            "/meshes/0/primitives/0/attributes",
            json!({ "POSITION": 0, "JOINTS_0": 2 })
        ),
        "DIR/scene.glb: meshes[0].primitives[0].attributes.WEIGHTS_0: is missing; expected weights beside the joints"
    );
    assert_eq!(
        refused(
            "/meshes/0/primitives/0/attributes",
            json!({ "POSITION": 0 })
        ),
        "DIR/scene.glb: meshes[0].primitives[0].attributes: has no JOINTS_0, and a node shows it with a skin; expected the joints that each vertex follows"
    );
    assert_eq!(
        refused("/accessors/2/componentType", json!(5120)),
        "DIR/scene.glb: accessors[2].componentType: is 5120; expected 5121, 5123 or 5125 (unsigned) for joints"
    );
}
