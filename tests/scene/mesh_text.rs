//! OBJ and PLY files as exporters write them: encodings, spellings, strips and concave polygons.

use super::files::Folder;
use super::meshes::{load_mesh, mesh};
use direkt::scene::Mesh;
use glam::{DVec2, DVec3};

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";

fn load(name: &str, bytes: impl AsRef<[u8]>) -> Mesh {
    let scene = load_mesh(name, bytes).unwrap_or_else(|e| panic!("{e}"));
    mesh(&scene).clone()
}

#[track_caller]
fn refused(name: &str, bytes: impl AsRef<[u8]>, expected: &str) {
    let message = load_mesh(name, bytes).expect_err("it must be refused");
    assert_eq!(message, format!("DIR/{name}: {expected}"));
}

fn utf16(text: &str, unit: fn(u16) -> [u8; 2]) -> Vec<u8> {
    let units = std::iter::once(0xfeff).chain(text.encode_utf16());
    units.flat_map(unit).collect()
}

fn ply(header: &str, data: &str) -> String {
    format!(
        "ply\nformat ascii 1.0\n{header}element vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n{data}"
    )
}

const PLY_DATA: &str = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";

/// The same square, however its text is encoded and its lines end.
#[test]
fn encodings_and_line_ends_change_nothing() {
    let square = load("m.obj", SQUARE);
    assert_eq!(square.triangles, [[0, 1, 2], [0, 2, 3]]);
    let ply_text = ply("comment f\u{fc}r\nobj_info\n", PLY_DATA);
    for (name, text) in [
        ("m.obj", format!("# f\u{fc}r\n{SQUARE}")),
        ("m.ply", ply_text),
    ] {
        let latin: Vec<u8> = text.chars().map(|c| c as u8).collect();
        let mut cases = vec![
            text.clone().into_bytes(),
            format!("\u{feff}{text}").into_bytes(),
            utf16(&text, u16::to_le_bytes),
            utf16(&text, u16::to_be_bytes),
            latin,
        ];
        for end in ["\r\n", "\r", " \t\n"] {
            cases.push(text.replace('\n', end).into_bytes());
        }
        for case in cases {
            let message = format!("{name}: {:?}", String::from_utf8_lossy(&case));
            assert_eq!(load(name, case), square, "{message}");
        }
    }
}

#[test]
fn obj_statements_in_all_spellings() {
    let square = load("m.obj", SQUARE);
    for text in [
        "v 0 0 0 # corner\nv 1 0 0\t#\nv 1 1 0#c\nv 0 1 0\nf 1 2 3 4 # quad\n",
        "v 0 0 \\\n0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 \\ \r\n3 \\\n4",
        "# C:\\models\\\nv 0. .0 +0\nv 1.e0 0 0\nv 1d0 1 0\nv 0 1 0 1\nf 1 2 3 4\n",
        "o\ng\nusemtl\ns off\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nmtllib\nf -4 -3 -2 -1\n",
        "\t v\t0 0 0\n v 1 0 0\n\nv 1 1 0\nv 0 1 0\nf 1/ 2// 3 4\n",
        // Faces before what they name.
        "f 1 2 3 4\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n",
    ] {
        let scene = load_mesh("m.obj", text).unwrap_or_else(|e| panic!("{text}: {e}"));
        assert_eq!(*mesh(&scene), square, "{text}");
        assert!(
            scene.warnings[0].starts_with("the scene has no camera"),
            "{text}"
        );
    }
}

/// Texture coordinates of one to three numbers; corners that have none, beside corners that have.
#[test]
fn obj_attributes_of_some_faces() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0.25\nvt 0.5 0.75\nvt 1 0 7\nvn 0 0 1\nf 1 2 4\nf 2/1/1 3/2/1 4/3/1\n";
    let mesh = load("m.obj", text);
    let [bare, full] = [mesh.triangles[0], mesh.triangles[1]];
    for i in bare {
        assert!(mesh.uvs[i as usize].is_nan());
        assert_eq!(mesh.normals[i as usize], DVec3::ZERO);
    }
    let uvs = full.map(|i| mesh.uvs[i as usize]);
    assert_eq!(
        uvs,
        [
            DVec2::new(0.25, 1.0),
            DVec2::new(0.5, 0.25),
            DVec2::new(1.0, 1.0)
        ]
    );
    assert!(full.iter().all(|i| mesh.normals[*i as usize] == DVec3::Z));
    let positions = full.map(|i| mesh.positions[i as usize]);
    assert_eq!(positions, [DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y]);
}

#[test]
fn what_an_obj_file_holds_besides_is_named_once() {
    let text = format!(
        "{SQUARE}l 1 2 3\nl 1 2\np 1\ncurv 0 1 1 2\nsurf 0 1 0 1 1 2\ns 1\nlod 2\nusemap a\nf 1 2\nv 0 0 0 2 0 0\n"
    );
    let scene = load_mesh("m.obj", text).expect("a valid OBJ");
    assert_eq!(mesh(&scene).triangles.len(), 2, "a polyline is no face");
    assert_eq!(
        scene.warnings[..7],
        [
            "DIR/m.obj: 2 line elements are not rendered",
            "DIR/m.obj: 1 point element is not rendered",
            "DIR/m.obj: free-form curves and surfaces are not rendered",
            "DIR/m.obj: smoothing groups (s) are ignored: without vertex normals (vn) faces are flat",
            "DIR/m.obj: unknown statements are ignored: usemap",
            "DIR/m.obj: 1 vertex colour is not from 0 to 1 (the largest channel is 2); such channels are taken as the nearest of these",
            "DIR/m.obj: 1 face has fewer than three corners",
        ]
    );
}

#[test]
fn obj_errors_name_their_line() {
    refused(
        "m.obj",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 \\\n2 3\nf 1 2 9\n",
        "line 6: names vertex 9, which is out of range; expected 1 to 3, or -3 to -1 (there are 3)",
    );
    refused(
        "m.obj",
        "v 0 0 0\nf 1/1 1/1 1/1\n",
        "line 2: names texture coordinate 1, which is out of range; expected no index: there is none",
    );
    refused(
        "m.obj",
        "v 0 0 0 0\nf 1 1 1\n",
        "line 1: is `v 0 0 0 0`; expected a weight `w` other than 0",
    );
    refused(
        "m.obj",
        "v 0,5 0 0\nf 1 1 1\n",
        "line 1: is `v 0,5 0 0`; expected `v` and three numbers",
    );
}

/// Numbers that the parser does not know, blank lines, names with other characters, two properties
/// of one name.
#[test]
fn ply_files_in_all_spellings() {
    let square = load("m.obj", SQUARE);
    let data = "\n0. .0 -0\n+1 0e1 0\n\n1.0e+0 1d0 0\n  0 1 0\n4 0 1 2 3\n\n";
    assert_eq!(load("m.ply", ply("", data)), square);
    let text = ply("", PLY_DATA).replace(
        "property float z\n",
        "property float z\nproperty float scalar_Height(Z)\nproperty uchar flag\nproperty uchar flag\n",
    );
    let text = text.replace(
        "0 0 0\n1 0 0\n1 1 0\n0 1 0\n",
        "0 0 0 9 1 2\n1 0 0 9 1 2\n1 1 0 9 1 2\n0 1 0 9 1 2\n",
    );
    assert_eq!(load("m.ply", text), square);
    // What is not a number is a vertex that is dropped, as in OBJ.
    let text = ply("", &PLY_DATA.replace("1 1 0", "nan 1 0"));
    let scene = load_mesh("m.ply", text).expect("a valid PLY");
    assert!(mesh(&scene).triangles.is_empty());
    assert!(
        scene.warnings[0].contains("2 degenerate triangles were dropped"),
        "{:?}",
        scene.warnings
    );
}

/// Every width of list and index, in both orders of bytes, behind a header of lines that end in CR
/// LF.
#[test]
fn binary_ply_files_of_every_width() {
    let square = load("m.obj", SQUARE);
    for (count, count_bytes) in [("char", 1), ("uint16", 2), ("int", 4)] {
        for (index, index_bytes) in [("uchar", 1), ("short", 2), ("uint32", 4)] {
            for big in [false, true] {
                let order = if big { "big" } else { "little" };
                let header = format!(
                    "ply\r\nformat binary_{order}_endian 1.0\r\nelement vertex 4\r\nproperty double x\r\nproperty float y\r\nproperty char z\r\nproperty list uchar ushort more\r\nelement face 1\r\nproperty uchar flag\r\nproperty list {count} {index} vertex_index\r\nend_header\r\n"
                );
                let mut bytes = header.into_bytes();
                let mut put = |value: &[u8]| {
                    let mut value = value.to_vec();
                    if big {
                        value.reverse();
                    }
                    bytes.extend(value);
                };
                for (x, y) in [(0.0f64, 0.0f32), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
                    put(&x.to_le_bytes());
                    put(&y.to_le_bytes());
                    put(&[0]);
                    put(&[1]);
                    put(&7u16.to_le_bytes());
                }
                put(&[10]);
                put(&4u32.to_le_bytes()[..count_bytes]);
                for i in 0..4u32 {
                    put(&i.to_le_bytes()[..index_bytes]);
                }
                assert_eq!(load("m.ply", bytes), square, "{count} {index} {order}");
            }
        }
    }
}

/// Strips begin anew at −1, and turn every other triangle; a vertex twice joins two parts of one.
#[test]
fn ply_triangle_strips() {
    let strips = |kind: &str, data: &str| {
        let text = format!(
            "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\nelement tristrips 1\nproperty list int {kind} vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n1 2 0\n{data}\n"
        );
        load_mesh("m.ply", text)
    };
    for (kind, data) in [
        ("int", "6 0 1 2 3 4 5"),
        ("int", "10 0 1 2 -1 1 3 2 -1 2 3"),
        ("uint", "9 0 1 2 3 4294967295 2 3 4 5"),
        ("int", "10 0 1 2 3 3 2 2 3 4 5"),
    ] {
        let scene = strips(kind, data).unwrap_or_else(|e| panic!("{e}"));
        let mesh = mesh(&scene);
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
            0.5 * (b - a).cross(c - a).z
        };
        let areas: Vec<f64> = mesh.triangles.iter().map(area).collect();
        let expected = if data.starts_with("10 0 1 2 -1") {
            2
        } else {
            4
        };
        assert_eq!(areas, vec![0.5; expected], "{data}");
        assert!(
            scene.warnings.iter().all(|w| !w.contains("degenerate")),
            "{data}"
        );
    }
    let message = strips("int", "3 0 1 6").expect_err("it must be refused");
    assert_eq!(
        message,
        "DIR/m.ply: triangle strip 0: vertex index 6 is out of range; expected 0 to 5 (there are 6 vertices)"
    );
}

#[test]
fn what_a_ply_file_says_of_its_looks_and_is_not_read_is_named() {
    let text = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nelement face 1\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\nproperty uchar red\nelement edge 1\nproperty int vertex1\nproperty int vertex2\nend_header\n0 0 0 9\n1 0 0 9\n0 1 0 9\n3 0 1 2 6 0 0 1 0 1 1 9\n0 1\n";
    let scene = load_mesh("m.ply", text).expect("a valid PLY");
    assert_eq!(
        scene.warnings[0],
        "DIR/m.ply: not read: face.texcoord, face.red, edge.vertex1, a vertex colour without all of red, green and blue"
    );
}

/// The L of area 3 and the notch of area 2.5, as one polygon each.
#[test]
fn concave_polygons_have_their_areas() {
    let l = "v 1 -1 0\nv 1 0 0\nv 0 0 0\nv 0 1 0\nv -1 1 0\nv -1 -1 0\n";
    let notch = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv 0 -0.5 0\nv -1 1 0\n";
    for (vertices, area) in [(l, 3.0), (notch, 2.5)] {
        let count = vertices.lines().count();
        for start in 0..count {
            let corners = (0..count).map(|i| (start + i) % count);
            let one: Vec<String> = corners.clone().map(|i| (i + 1).to_string()).collect();
            let zero: Vec<String> = corners.map(|i| i.to_string()).collect();
            let obj = format!("{vertices}f {}\n", one.join(" "));
            let ply = format!(
                "ply\nformat ascii 1.0\nelement vertex {count}\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n{}{count} {}\n",
                vertices.replace("v ", ""),
                zero.join(" ")
            );
            for (name, text) in [("m.obj", obj), ("m.ply", ply)] {
                let mesh = load(name, text);
                let areas = mesh.triangles.iter().map(|t| {
                    let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
                    0.5 * (b - a).cross(c - a).z
                });
                let areas: Vec<f64> = areas.collect();
                assert!(
                    areas.iter().all(|a| *a > 0.0),
                    "{name} from {start}: {areas:?}"
                );
                let sum: f64 = areas.iter().sum();
                assert!((sum - area).abs() < 1e-12, "{name} from {start}: {sum}");
            }
        }
    }
}

/// The scene and its field are named, as of every other file.
#[test]
fn files_that_are_no_meshes_are_refused_by_their_field() {
    let folder = Folder::new();
    folder.write("sub/a.obj", SQUARE);
    folder.write("a.stl", "solid");
    folder.write("bare", "solid");
    for (name, problem) in [
        (".", "`.` is a folder; expected a file"),
        ("sub", "`sub` is a folder; expected a file"),
        ("sub/..", "`sub/..` is a folder; expected a file"),
        ("", "the file name is empty; expected the name of a file"),
        (
            "a.stl",
            "`a.stl`: `.stl` is not a mesh format; expected a mesh in .ply, .obj, .gltf or .glb",
        ),
        (
            "bare",
            "`bare` has no extension that would tell its format; expected a mesh in .ply, .obj, .gltf or .glb",
        ),
    ] {
        let shape = format!("[[shapes]]\ntype = \"mesh\"\nfile = \"{name}\"\n");
        folder.write("scene.toml", shape);
        let message = folder.load("scene.toml").expect_err(name);
        assert_eq!(
            message,
            format!("DIR/scene.toml: shapes[0].file: {problem}")
        );
    }
    for (scene, field) in [
        ("[environment]\nfile = \".\"\n", "environment.file"),
        ("[[gltf]]\nfile = \"sub\"\n", "gltf[0].file"),
        (
            "[materials.a]\ntype = \"lambert\"\nreflectance = 1\ntextures.color = { file = \"sub\" }\n",
            "materials.a.textures.color.file",
        ),
    ] {
        folder.write("scene.toml", scene);
        let message = folder.load("scene.toml").expect_err(scene);
        let start = format!("DIR/scene.toml: {field}: `");
        assert!(message.starts_with(&start), "{message}");
        assert!(
            message.ends_with("is a folder; expected a file"),
            "{message}"
        );
    }
}
