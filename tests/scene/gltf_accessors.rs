//! glTF accessors: sparse ones, those without data, quantized ones, and all that indices may be.

use super::builder::{Builder, CORNERS, TRIANGLE, bytes, mesh_of, triangles_of};
use glam::{DVec2, DVec3};
use serde_json::{Value, json};

/// `accessors[index]` with elements that displace its own.
fn displaced(builder: &mut Builder, index: usize, places: (u32, &[u8]), values: &[u8]) {
    let (component, places) = places;
    let size = match component {
        5121 => 1,
        5123 => 2,
        _ => 4,
    };
    let [of_places, of_values] = [places, values].map(|bytes| builder.view(bytes));
    let sparse = json!({ "sparse": {
        "count": places.len() / size,
        "indices": { "bufferView": of_places, "componentType": component },
        "values": { "bufferView": of_values }
    } });
    builder.amend("accessors", index, sparse);
}

/// A triangle whose last two corners come from `sparse`.
fn sparse_triangle(component: u32, places: &[u8]) -> Builder {
    let mut builder = Builder::new();
    let positions = builder.floats(&[[0.0; 3], [9.0; 3], [9.0; 3]]);
    let values = bytes(TRIANGLE[1..].as_flattened(), f32::to_le_bytes);
    displaced(&mut builder, positions, (component, places), &values);
    let mesh = builder.mesh(json!({ "attributes": { "POSITION": positions } }));
    builder.root(json!({ "mesh": mesh }));
    builder
}

#[test]
fn sparse_accessors_displace_elements_by_indices_of_every_type() {
    let wide = bytes(&[1u32, 2], u32::to_le_bytes);
    for (component, places) in [(5121, &[1, 2][..]), (5123, &[1, 0, 2, 0]), (5125, &wide)] {
        let scene = sparse_triangle(component, places).scene();
        assert_eq!(triangles_of(&scene, 0), [CORNERS], "{component}");
        assert!(!scene.warnings.iter().any(|w| w.contains("sparse")));
    }
}

/// Zeros where no data is, displaced elements beside them; the base may lie between other data.
#[test]
fn sparse_attributes_and_indices_have_any_base() {
    let mut builder = Builder::new();
    let positions = builder.accessor(5126, "VEC3", 3, &bytes(&[7.0f32; 18], f32::to_le_bytes));
    builder.amend("bufferViews", 0, json!({ "byteStride": 24 }));
    builder.amend("accessors", positions, json!({ "byteOffset": 12 }));
    let all = bytes(TRIANGLE.as_flattened(), f32::to_le_bytes);
    displaced(&mut builder, positions, (5121, &[0, 1, 2]), &all);
    let add = |builder: &mut Builder, component: u32, kind: &str| {
        let accessor = json!({ "componentType": component, "type": kind, "count": 3 });
        builder.add("accessors", accessor)
    };
    let normals = add(&mut builder, 5126, "VEC3");
    let two = bytes(&[1.0f32, 0.0, 0.0, 0.0, 1.0, 0.0], f32::to_le_bytes);
    displaced(&mut builder, normals, (5121, &[0, 2]), &two);
    let uvs = add(&mut builder, 5121, "VEC2");
    builder.amend("accessors", uvs, json!({ "normalized": true }));
    displaced(&mut builder, uvs, (5123, &[1, 0]), &[255, 51]);
    let indices = add(&mut builder, 5123, "SCALAR");
    displaced(&mut builder, indices, (5121, &[1, 2]), &[1, 0, 2, 0]);
    let mesh = builder.mesh(json!({
        "attributes": { "POSITION": positions, "NORMAL": normals, "TEXCOORD_0": uvs },
        "indices": indices
    }));
    builder.root(json!({ "mesh": mesh }));
    let scene = builder.scene();
    assert_eq!(triangles_of(&scene, 0), [CORNERS]);
    let mesh = mesh_of(&scene, 0);
    assert_eq!(mesh.normals, [DVec3::X, DVec3::ZERO, DVec3::Y]);
    assert_eq!(mesh.uvs, [DVec2::ZERO, DVec2::new(1.0, 0.2), DVec2::ZERO]);
}

#[test]
fn bad_sparse_accessors_are_named() {
    let good = || sparse_triangle(5121, &[1, 2]);
    let refused = |pointer: &str, value: Value| {
        let mut builder = good();
        *builder.json.pointer_mut(pointer).expect("it is there") = value;
        builder.refused()
    };
    let sparse = "/accessors/0/sparse";
    assert_eq!(
        sparse_triangle(5121, &[1, 3]).refused(),
        "DIR/scene.glb: accessors[0].sparse.indices: element 1 is 3; expected an index of the 3 elements"
    );
    assert_eq!(
        sparse_triangle(5121, &[2, 2]).refused(),
        "DIR/scene.glb: accessors[0].sparse.indices: element 1 is 2 after 2; expected indices that increase"
    );
    assert_eq!(
        refused(&format!("{sparse}/count"), json!(3)),
        "DIR/scene.glb: accessors[0].sparse.indices: 3 elements of 1 bytes, 1 apart, from byte 0 on do not fit bufferView 1; expected a range within its 2 bytes"
    );
    assert_eq!(
        refused("/bufferViews/2/byteLength", json!(20)),
        "DIR/scene.glb: accessors[0].sparse.values: 2 elements of 12 bytes, 12 apart, from byte 0 on do not fit bufferView 2; expected a range within its 20 bytes"
    );
    assert_eq!(
        refused(&format!("{sparse}/values/bufferView"), json!(9)),
        "DIR/scene.glb: accessors[0].sparse.values.bufferView: bufferView 9 is out of range; expected 0 to 2"
    );
    assert_eq!(
        refused(&format!("{sparse}/indices/componentType"), json!(5126)),
        "DIR/scene.glb: accessors[0].sparse.indices.componentType: is unknown; expected 5121, 5123 or 5125"
    );
    let mut endless = good();
    let accessor = endless.json["accessors"][0].as_object_mut().unwrap();
    accessor.remove("bufferView");
    accessor.insert("count".to_owned(), json!(1u64 << 40));
    assert_eq!(
        endless.refused(),
        "DIR/scene.glb: accessors[0].count: is 1099511627776 without a bufferView; expected at most 16777216 elements that no data stands for"
    );
}

/// Every component type of KHR_mesh_quantization, as it is and normalised; −128 means −1 as −127
/// does.
#[test]
fn quantized_attributes() {
    let halves = |n: i16| n.to_le_bytes();
    for (component, bytes_of_triangle, scale) in [
        (5120, vec![0, 0, 0, 127, 0, 0, 0, 127, 0], 127.0),
        (5121, vec![0, 0, 0, 255, 0, 0, 0, 255, 0], 255.0),
        (
            5122,
            bytes(&[0, 0, 0, 32_767, 0, 0, 0, 32_767, 0], halves),
            32_767.0,
        ),
        (
            5123,
            bytes(&[0, 0, 0, -1, 0, 0, 0, -1, 0], halves),
            65_535.0,
        ),
    ] {
        for (normalized, scale) in [(true, 1.0), (false, scale)] {
            let mut builder = Builder::new();
            let positions = builder.accessor(component, "VEC3", 3, &bytes_of_triangle);
            builder.amend("accessors", positions, json!({ "normalized": normalized }));
            let normals = builder.accessor(5120, "VEC3", 3, &[0, 0, 127, 0x80, 0, 0, 0, 0x81, 0]);
            builder.amend("accessors", normals, json!({ "normalized": true }));
            let attributes = json!({ "POSITION": positions, "NORMAL": normals });
            let mesh = builder.mesh(json!({ "attributes": attributes }));
            builder.root(json!({ "mesh": mesh }));
            builder.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
            let scene = builder.scene();
            let expected = CORNERS.map(|corner| scale * corner);
            assert_eq!(triangles_of(&scene, 0), [expected], "{component}");
            let normals = &mesh_of(&scene, 0).normals;
            assert_eq!(*normals, [DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y]);
        }
    }
}

/// Texture coordinates that are not normalised count texels or what their transform makes of them.
#[test]
fn quantized_texture_coordinates() {
    let three = [0, 0, 1, 0, 0, 2];
    for (component, normalized, data, largest) in [
        (5120, false, three.map(|n: u8| n).to_vec(), 1.0),
        (5121, true, three.to_vec(), 255.0),
        (
            5122,
            true,
            bytes(&three.map(u16::from), u16::to_le_bytes),
            32_767.0,
        ),
        (
            5123,
            false,
            bytes(&three.map(u16::from), u16::to_le_bytes),
            1.0,
        ),
    ] {
        let mut builder = Builder::new();
        let positions = builder.floats(&TRIANGLE);
        let uvs = builder.accessor(component, "VEC2", 3, &data);
        builder.amend("accessors", uvs, json!({ "normalized": normalized }));
        let attributes = json!({ "POSITION": positions, "TEXCOORD_0": uvs });
        let mesh = builder.mesh(json!({ "attributes": attributes }));
        builder.root(json!({ "mesh": mesh }));
        let unit = 1.0 / largest;
        let expected = [
            DVec2::ZERO,
            DVec2::new(unit, 0.0),
            DVec2::new(0.0, 2.0 * unit),
        ];
        assert_eq!(mesh_of(&builder.scene(), 0).uvs, expected, "{component}");
    }
}

/// Strips and fans with indices of every type, and without; the largest value of a type begins a
/// new one.
#[test]
fn strips_and_fans_begin_anew_at_the_largest_index() {
    let corner = |i: usize| DVec3::new((i % 2) as f64, (i / 2) as f64, 0.0);
    for (component, data) in [
        (5121, vec![0, 1, 2, 3, 255, 2, 1, 0]),
        (
            5123,
            bytes(&[0, 1, 2, 3, 65_535, 2, 1, 0], u16::to_le_bytes),
        ),
        (
            5125,
            bytes(&[0, 1, 2, 3, u32::MAX, 2, 1, 0], u32::to_le_bytes),
        ),
    ] {
        for (mode, expected) in [
            (5, [[0, 1, 2], [1, 3, 2], [2, 1, 0]]),
            (6, [[1, 2, 0], [2, 3, 0], [1, 0, 2]]),
        ] {
            let mut builder = Builder::new();
            let square = [0, 1, 2, 3].map(|i| corner(i).as_vec3().to_array());
            let positions = builder.floats(&square);
            let indices = builder.accessor(component, "SCALAR", 8, &data);
            let attributes = json!({ "POSITION": positions });
            let primitive = json!({ "attributes": attributes, "indices": indices, "mode": mode });
            let mesh = builder.mesh(primitive);
            builder.root(json!({ "mesh": mesh }));
            let expected = expected.map(|t| t.map(corner));
            assert_eq!(triangles_of(&builder.scene(), 0), expected, "{component}");
            builder.json["meshes"][0]["primitives"][0]["mode"] = json!(4);
            let message = builder.refused();
            assert!(message.contains("is out of range"), "{message}");
        }
    }
}

#[test]
fn points_lines_and_vertices_without_positions_are_left_out_with_a_sentence() {
    let mut builder = Builder::new();
    let positions = builder.floats(&TRIANGLE);
    let attributes = json!({ "POSITION": positions });
    let primitives: Vec<Value> = [0, 1, 2, 3, 4]
        .iter()
        .map(|mode| json!({ "attributes": attributes, "mode": mode }))
        .chain([json!({ "attributes": { "NORMAL": positions } })])
        .collect();
    let mesh = builder.add("meshes", json!({ "primitives": primitives }));
    builder.root(json!({ "mesh": mesh }));
    let scene = builder.scene();
    assert_eq!(scene.shapes.len(), 1);
    assert_eq!(
        scene.warnings,
        [
            "scene.glb: vertices of 1 primitive have no POSITION and are not rendered",
            "scene.glb: points and lines of 4 primitives are not rendered",
            "the scene has no light: the image will be black",
        ]
    );
}

/// Elements between others' data, a stride of 0 for closely packed ones, and indices from the
/// middle of their view.
#[test]
fn strides_and_offsets() {
    let mut builder = Builder::new();
    let mut interleaved = Vec::new();
    for position in TRIANGLE {
        interleaved.extend(bytes(&[f32::NAN], f32::to_le_bytes));
        interleaved.extend(bytes(&position, f32::to_le_bytes));
    }
    let positions = builder.accessor(5126, "VEC3", 3, &interleaved);
    builder.amend("bufferViews", 0, json!({ "byteStride": 16 }));
    builder.amend("accessors", positions, json!({ "byteOffset": 4 }));
    let indices = builder.accessor(5121, "SCALAR", 3, &[9, 9, 0, 1, 2]);
    builder.amend("bufferViews", 1, json!({ "byteStride": 0 }));
    builder.amend("accessors", indices, json!({ "byteOffset": 2 }));
    let attributes = json!({ "POSITION": positions });
    let mesh = builder.mesh(json!({ "attributes": attributes, "indices": indices }));
    builder.root(json!({ "mesh": mesh }));
    assert_eq!(triangles_of(&builder.scene(), 0), [CORNERS]);
}
