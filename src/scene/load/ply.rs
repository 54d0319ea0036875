//! Stanford PLY: ascii, binary little and big endian. Positions, normals, texture coordinates and faces are read.

use super::files;
use crate::error::InputError;
use crate::scene::Mesh;
use glam::{DVec2, DVec3};
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType,
    ScalarType,
};
use std::io::Cursor;
use std::path::Path;

/// What a message goes on with after the line that is wrong: the same line again, or the state of the grammar's parser.
const NOISE: [&str; 3] = [
    "\n\tError: ParseError {",
    "\n\tError: Couldn't parse element line.",
    "\n\tError: error at ",
];

/// Reads a PLY file; polygons become fans of triangles.
pub(super) fn read(path: &Path) -> Result<Mesh, InputError> {
    let bytes = files::read(path)?;
    let failed = |e: ParseError| {
        let message = e.to_string();
        let end = NOISE.iter().filter_map(|noise| message.find(noise)).min();
        let message = &message[..end.unwrap_or(message.len())];
        let message = message.replace("\n\t", " ").replace('\n', " ");
        InputError::file(path, format!("is not a readable PLY file: {message}"), "")
    };
    let size = bytes.len();
    let mut reader = Reader::new(Cursor::new(bytes));
    let header = Parser::<Skipped>::new()
        .read_header(&mut reader)
        .map_err(failed)?;
    check_header(path, &header, size)?;
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for element in header.elements.values() {
        match element.name.as_str() {
            "vertex" => {
                vertices = Parser::<Vertex>::new()
                    .read_payload_for_element(&mut reader, element, &header)
                    .map_err(failed)?;
            }
            "face" => {
                faces = Parser::<Face>::new()
                    .read_payload_for_element(&mut reader, element, &header)
                    .map_err(failed)?;
            }
            _ => {
                Parser::<Skipped>::new()
                    .read_payload_for_element(&mut reader, element, &header)
                    .map_err(failed)?;
            }
        }
    }
    // What the file does not have is NaN in the first vertex as in all.
    let first = vertices.first();
    let normals = first.is_some_and(|v: &Vertex| !v.normal.is_nan());
    let uvs = first.is_some_and(|v| !v.uv.is_nan());
    let all = |has: bool| vertices.iter().filter(move |_| has);
    Ok(Mesh {
        triangles: triangulate(path, &faces, vertices.len())?,
        positions: vertices.iter().map(|v| v.position).collect(),
        normals: all(normals).map(|v| v.normal).collect(),
        // The file's v points up.
        uvs: all(uvs).map(|v| DVec2::new(v.uv.x, 1.0 - v.uv.y)).collect(),
        colors: Vec::new(),
    })
}

/// Refuses files without positions or faces, and counts that the file is too short for: the parser would believe them.
fn check_header(path: &Path, header: &Header, size: usize) -> Result<(), InputError> {
    let property = |element: &str, names: &[&str]| {
        header
            .elements
            .get(element)
            .is_some_and(|e| names.iter().any(|n| e.properties.contains_key(*n)))
    };
    for axis in ["x", "y", "z"] {
        if !property("vertex", &[axis]) {
            return Err(InputError::new(
                path,
                "element vertex",
                format!("has no property `{axis}`"),
                "the properties x, y and z",
            ));
        }
    }
    if !property("face", &["vertex_indices", "vertex_index"]) {
        return Err(InputError::new(
            path,
            "element face",
            "has no list `vertex_indices`",
            "a triangle mesh (point clouds are not rendered)",
        ));
    }
    let needed = header
        .elements
        .values()
        .map(|e| least_bytes(e, header.encoding).saturating_mul(e.count))
        .fold(0, usize::saturating_add);
    if needed > size {
        return Err(InputError::file(
            path,
            format!(
                "is truncated: its header promises at least {needed} bytes of elements, but the file has {size}"
            ),
            "the whole file",
        ));
    }
    Ok(())
}

/// The least number of bytes one element takes (an empty list is its length alone; in ascii, a digit and a separator).
fn least_bytes(element: &ElementDef, encoding: Encoding) -> usize {
    let bytes = |s: &ScalarType| match s {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    };
    let sum: usize = element
        .properties
        .values()
        .map(|p| match (&p.data_type, encoding) {
            (_, Encoding::Ascii) => 2,
            (PropertyType::Scalar(s) | PropertyType::List(s, _), _) => bytes(s),
        })
        .sum();
    // An element without properties would cost nothing in the file and memory here.
    sum.max(1)
}

fn triangulate(path: &Path, faces: &[Face], vertices: usize) -> Result<Vec<[u32; 3]>, InputError> {
    let mut triangles = Vec::with_capacity(faces.len());
    for (number, face) in faces.iter().enumerate() {
        for &index in &face.0 {
            if usize::try_from(index).map_or(true, |i| i >= vertices) {
                return Err(InputError::new(
                    path,
                    format!("face {number}"),
                    format!("vertex index {index} is out of range"),
                    format!(
                        "0 to {} (there are {vertices} vertices)",
                        vertices.saturating_sub(1)
                    ),
                ));
            }
        }
        // The check above makes every index a u32: a file of 2³² vertices would not fit its reader.
        let corner = |i: usize| face.0[i] as u32;
        for i in 2..face.0.len() {
            triangles.push([corner(0), corner(i - 1), corner(i)]);
        }
    }
    Ok(triangles)
}

/// A vertex; NaN where the file says nothing.
struct Vertex {
    position: DVec3,
    normal: DVec3,
    uv: DVec2,
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self {
            position: DVec3::NAN,
            normal: DVec3::NAN,
            uv: DVec2::NAN,
        }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let axis = match name {
            "x" => &mut self.position.x,
            "y" => &mut self.position.y,
            "z" => &mut self.position.z,
            "nx" => &mut self.normal.x,
            "ny" => &mut self.normal.y,
            "nz" => &mut self.normal.z,
            "u" | "s" | "texture_u" => &mut self.uv.x,
            "v" | "t" | "texture_v" => &mut self.uv.y,
            _ => return PropertyAccessResult::Ignored,
        };
        *axis = match property {
            Property::Char(v) => v.into(),
            Property::UChar(v) => v.into(),
            Property::Short(v) => v.into(),
            Property::UShort(v) => v.into(),
            Property::Int(v) => v.into(),
            Property::UInt(v) => v.into(),
            Property::Float(v) => v.into(),
            Property::Double(v) => v,
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

/// A polygon: its vertex indices, not yet checked.
struct Face(Vec<i64>);

fn is_index_list(name: &str) -> bool {
    name == "vertex_indices" || name == "vertex_index"
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self(Vec::new())
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !is_index_list(name) {
            return PropertyAccessResult::Ignored;
        }
        self.0 = match property {
            Property::ListChar(v) => v.into_iter().map(i64::from).collect(),
            Property::ListUChar(v) => v.into_iter().map(i64::from).collect(),
            Property::ListShort(v) => v.into_iter().map(i64::from).collect(),
            Property::ListUShort(v) => v.into_iter().map(i64::from).collect(),
            Property::ListInt(v) => v.into_iter().map(i64::from).collect(),
            Property::ListUInt(v) => v.into_iter().map(i64::from).collect(),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

/// An element that is read past; it takes no memory.
struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}
