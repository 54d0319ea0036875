//! glTF nodes: which are shown, how often, and what their transforms may be.

use super::builder::{Builder, CORNERS, TRIANGLE, bytes, mesh_of, triangles_of};
use direkt::scene::{Light, PointLight, Projection};
use glam::{DQuat, DVec3};
use serde_json::{Value, json};
use std::f32::consts::FRAC_1_SQRT_2;
use std::f64::consts::FRAC_PI_2;

/// The triangle as mesh 0.
fn triangle() -> Builder {
    let mut builder = Builder::new();
    let positions = builder.floats(&TRIANGLE);
    builder.mesh(json!({ "attributes": { "POSITION": positions } }));
    builder
}

/// A hidden node hides what is below it, lights too, and no camera.
#[test]
fn hidden_nodes_neither_show_nor_light() {
    let visible = |visible: Value| json!({ "KHR_node_visibility": { "visible": visible } });
    let light = json!({ "KHR_lights_punctual": { "light": 0 } });
    let mut builder = triangle();
    builder.json["extensionsRequired"] = json!(["KHR_node_visibility", "KHR_lights_punctual"]);
    builder.json["extensions"] =
        json!({ "KHR_lights_punctual": { "lights": [{ "type": "point", "range": 3 }] } });
    builder.json["cameras"] =
        json!([{ "type": "perspective", "perspective": { "yfov": 1, "znear": 1 } }]);
    builder.root(json!({ "children": [1, 2, 3, 4], "extensions": visible(json!(false)) }));
    builder.add("nodes", json!({ "mesh": 0 }));
    builder.add(
        "nodes",
        json!({ "mesh": 0, "extensions": visible(json!(true)) }),
    );
    builder.add("nodes", json!({ "extensions": light }));
    builder.add("nodes", json!({ "camera": 0, "translation": [0, 0, 7] }));
    builder
        .root(json!({ "mesh": 0, "name": "shown", "extensions": { "KHR_node_visibility": {} } }));
    let scene = builder.scene();
    assert_eq!(scene.shapes.len(), 1);
    assert_eq!(scene.shapes[0].name, "shown (mesh 0)");
    assert!(scene.lights.is_empty());
    assert_eq!(scene.camera.eye, DVec3::new(0.0, 0.0, 7.0));
    assert_eq!(
        scene.warnings,
        ["the scene has no light: the image will be black"]
    );

    builder.json["nodes"][0]["extensions"] = visible(json!(true));
    let scene = builder.scene();
    assert_eq!((scene.shapes.len(), scene.lights.len()), (3, 1));

    builder.json["nodes"][0]["extensions"] = visible(json!(0));
    assert_eq!(
        builder.refused(),
        "DIR/scene.glb: nodes[0].extensions.KHR_node_visibility.visible: is 0; expected true or false"
    );
}

/// A node with instances by `attributes`.
fn instanced(builder: &mut Builder, attributes: Value) {
    let extension = json!({ "EXT_mesh_gpu_instancing": { "attributes": attributes } });
    builder.json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    builder.root(json!({
        "mesh": 0, "name": "tree", "translation": [10, 0, 0], "scale": [2, 2, 2], "extensions": extension
    }));
}

#[test]
fn instances_are_scaled_turned_and_moved_within_their_node() {
    let mut builder = triangle();
    let translations = builder.floats(&[[0.0; 3], [0.0, 3.0, 0.0]]);
    let rotations = builder.floats(&[
        [0.0, 0.0, 0.0, 1.0],
        [0.0, 0.0, FRAC_1_SQRT_2, FRAC_1_SQRT_2],
    ]);
    let scales = builder.floats(&[[1.0; 3], [3.0, 1.0, 1.0]]);
    let attributes =
        json!({ "TRANSLATION": translations, "ROTATION": rotations, "SCALE": scales, "_ID": 0 });
    instanced(&mut builder, attributes);
    let scene = builder.scene();
    let names: Vec<&str> = scene.shapes.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(
        names,
        ["tree (mesh 0, instance 0)", "tree (mesh 0, instance 1)"]
    );
    let node = |p: DVec3| 2.0 * p + 10.0 * DVec3::X;
    assert_eq!(triangles_of(&scene, 0), [CORNERS.map(node)]);
    let turn = DQuat::from_rotation_z(FRAC_PI_2);
    let expected = CORNERS.map(|p| node(turn * (p * DVec3::new(3.0, 1.0, 1.0)) + 3.0 * DVec3::Y));
    for (got, expected) in triangles_of(&scene, 1)[0].iter().zip(expected) {
        assert!(got.distance(expected) < 1e-6, "{got}, not {expected}");
    }
    assert_eq!(
        scene.warnings,
        ["the scene has no light: the image will be black"]
    );
}

/// Rotations as normalised bytes and shorts; instances of scale 0 are hidden; without attributes
/// the mesh is there once.
#[test]
fn instances_by_one_attribute() {
    let bytes_of = [0u8, 0, 0x80, 0];
    let shorts = bytes(&[0i16, 0, -32_767, 0], i16::to_le_bytes);
    for (component, data) in [(5120, &bytes_of[..]), (5122, &shorts)] {
        let mut builder = triangle();
        let rotations = builder.accessor(component, "VEC4", 1, data);
        builder.amend("accessors", rotations, json!({ "normalized": true }));
        instanced(&mut builder, json!({ "ROTATION": rotations }));
        let half_turn = |p: DVec3| DVec3::new(10.0 - 2.0 * p.x, -2.0 * p.y, 0.0);
        let scene = builder.scene();
        for (got, corner) in triangles_of(&scene, 0)[0].iter().zip(CORNERS) {
            assert!(
                got.distance(half_turn(corner)) < 1e-12,
                "{component}: {got}"
            );
        }
    }
    let mut builder = triangle();
    let scales = builder.floats(&[[1.0; 3], [0.0; 3], [-1.0, 1.0, 1.0], [0.0; 3]]);
    instanced(&mut builder, json!({ "SCALE": scales }));
    let scene = builder.scene();
    assert_eq!(scene.shapes[1].name, "tree (mesh 0, instance 2)");
    let [a, b, c] = triangles_of(&scene, 1)[0];
    assert!((b - a).cross(c - a).z > 0.0, "a mirror keeps the front");
    assert_eq!(
        scene.warnings[0],
        "scene.glb: 2 instances of tree are hidden by a scale of 0"
    );
    let mut builder = triangle();
    instanced(&mut builder, json!({ "_ID": 0 }));
    assert_eq!(builder.scene().shapes[0].name, "tree (mesh 0)");
}

#[test]
fn bad_instances_are_named() {
    let refused = |attributes: Value| {
        let mut builder = triangle();
        builder.floats(&[[0.0; 3]]);
        builder.floats(&[[0.0; 4], [0.0; 4]]);
        instanced(&mut builder, attributes);
        builder.refused()
    };
    let field = "DIR/scene.glb: nodes[0].extensions.EXT_mesh_gpu_instancing.attributes";
    assert_eq!(
        refused(json!({ "TRANSLATION": 1, "ROTATION": 2 })),
        format!("{field}.ROTATION: has 2 elements; expected as many as TRANSLATION, 1")
    );
    assert_eq!(
        refused(json!({ "SCALE": 7 })),
        format!("{field}.SCALE: accessor 7 is out of range; expected 0 to 2")
    );
    assert_eq!(
        refused(json!({ "SCALE": -1 })),
        format!("{field}.SCALE: is -1; expected the index of an accessor")
    );
    assert_eq!(
        refused(json!({ "ROTATION": 1 })),
        "DIR/scene.glb: accessors[1].type: is Vec3; expected Vec4"
    );
    let mut builder = triangle();
    let accessor = json!({ "componentType": 5126, "type": "VEC3", "count": 1 << 24 });
    let endless = builder.add("accessors", accessor);
    instanced(&mut builder, json!({ "TRANSLATION": endless }));
    instanced(&mut builder, json!({ "TRANSLATION": endless }));
    // 3 vertices and 1 triangle: 5 · 2²⁴ are below 2²⁷, twice as many are not.
    let message = builder.refused();
    assert!(
        message.contains("nodes[1].mesh: the nodes up to here make more"),
        "{message}"
    );
}

/// Scale and mirror in the matrix itself, sheared; the front stays on its side.
#[test]
fn matrices_may_shear_and_mirror() {
    let mut builder = triangle();
    let sheared = [1, 0, 0, 0, 1, 1, 0, 0, 0, 0, -1, 0, 0, 0, 5, 1];
    builder.root(json!({ "mesh": 0, "matrix": sheared }));
    let scene = builder.scene();
    let [a, b, c] = triangles_of(&scene, 0)[0];
    assert_eq!(a, DVec3::new(0.0, 0.0, 5.0));
    // Mirrored in z: the normal that was +z is −z.
    assert_eq!((b - a).cross(c - a), DVec3::NEG_Z);
    let mut corners = [a, b, c];
    corners.sort_by(|p, q| p.y.total_cmp(&q.y).then(p.x.total_cmp(&q.x)));
    assert_eq!(corners[2], DVec3::new(1.0, 1.0, 5.0));
    assert!(mesh_of(&scene, 0).normals.is_empty());
}

/// A point light needs no direction, so its node's scale may be 0; a spot does.
#[test]
fn point_lights_have_no_direction() {
    let mut builder = Builder::new();
    builder.json["extensions"] =
        json!({ "KHR_lights_punctual": { "lights": [{ "type": "point" }] } });
    let extension = json!({ "KHR_lights_punctual": { "light": 0 } });
    builder.root(json!({ "extensions": extension, "translation": [1, 2, 3], "scale": [0, 0, 0] }));
    let scene = builder.scene();
    let position = DVec3::new(1.0, 2.0, 3.0);
    let intensity = DVec3::ONE;
    assert_eq!(
        scene.lights,
        [Light::Point(PointLight {
            position,
            intensity
        })]
    );
    builder.json["extensions"]["KHR_lights_punctual"]["lights"][0]["type"] = json!("directional");
    assert_eq!(
        builder.refused(),
        "DIR/scene.glb: nodes[0]: its transform leaves its light no direction; expected an invertible transform"
    );
}

/// `aspectRatio` and `zfar` are optional: the image has an aspect of its own, and nothing ends in
/// the distance.
#[test]
fn cameras_need_neither_aspect_nor_far_plane() {
    for perspective in [
        json!({ "yfov": 0.5, "znear": 0.1 }),
        json!({ "yfov": 0.5, "znear": 0.1, "zfar": 100, "aspectRatio": 2 }),
    ] {
        let mut builder = triangle();
        builder.json["cameras"] = json!([{ "type": "perspective", "perspective": perspective }]);
        builder.root(json!({ "mesh": 0, "camera": 0 }));
        let projection = builder.scene().camera.projection;
        assert_eq!(projection, Projection::Perspective { fov_y: 0.5 });
    }
}

#[test]
fn nodes_form_a_tree() {
    let mut builder = triangle();
    builder.root(json!({ "children": [1, 2] }));
    builder.add("nodes", json!({ "children": [2] }));
    builder.add("nodes", json!({ "mesh": 0 }));
    assert_eq!(
        builder.refused(),
        "DIR/scene.glb: nodes[0].children: node 2 is reached twice; expected a tree: no cycle, and one parent for each node"
    );
}
