//! Stanford PLY: ascii, binary little and big endian. Positions, normals, texture coordinates,
//! vertex colours, faces and triangle strips are read.

mod clean;
mod elements;

use super::files;
use super::room::Room;
use super::text;
use crate::error::InputError;
use crate::scene::Mesh;
use elements::{Elements, Skipped};
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{ElementDef, Encoding, Header, PropertyAccess, PropertyType, ScalarType};
use std::borrow::Cow;
use std::io::{BufRead, Read};
use std::path::Path;

/// The element of triangle strips.
const STRIPS: &str = "tristrips";

/// What an element may say about what is seen, beside what is read; where there, it is named in a
/// warning.
const NOT_READ: [(&str, &[&str]); 3] = [
    (
        "face",
        &[
            "texcoord",
            "texnumber",
            "red",
            "diffuse_red",
            "material_index",
            "material_indices",
        ],
    ),
    ("vertex", &["material_index", "ambient_red", "specular_red"]),
    ("edge", &["vertex1"]),
];

/// What a message goes on with after the line that is wrong: the same line again, or the state of
/// the grammar's parser.
const NOISE: [&str; 3] = [
    "\n\tError: ParseError {",
    "\n\tError: Couldn't parse element line.",
    "\n\tError: error at ",
];

/// Reads a PLY file; what it holds besides goes to `warnings`.
pub(super) fn read(
    path: &Path,
    room: &Room,
    warnings: &mut Vec<String>,
) -> Result<Mesh, InputError> {
    let bytes = files::read(path)?;
    let bytes = text_as_utf8(&bytes);
    let clean::Header { text, end } = clean::header(&bytes);
    let failed = |e: ParseError| {
        let message = e.to_string();
        let end = NOISE.iter().filter_map(|noise| message.find(noise)).min();
        let message = &message[..end.unwrap_or(message.len())];
        let message = message.replace("\n\t", " ").replace('\n', " ");
        InputError::file(path, format!("is not a readable PLY file: {message}"), "")
    };
    let header = Parser::<Skipped>::new()
        .read_header(&mut Reader::new(text.as_bytes()))
        .map_err(failed)?;
    check_header(path, &header, bytes.len())?;
    let faces = header.elements.get("face").map_or(0, |e| e.count);
    room.take(path, "element face", faces as u64)?;
    let data = match header.encoding {
        Encoding::Ascii => Cow::Owned(clean::data(&bytes[end..]).into_bytes()),
        _ => Cow::Borrowed(&bytes[end..]),
    };
    // Behind the header, so that messages count its lines.
    let mut reader = Reader::new(text.as_bytes().chain(&*data));
    Parser::<Skipped>::new()
        .read_header(&mut reader)
        .map_err(failed)?;
    let mut elements = Elements::default();
    for element in header.elements.values() {
        let reader = &mut reader;
        match element.name.as_str() {
            "vertex" => elements.vertices = payload(reader, element, &header).map_err(failed)?,
            "face" => elements.faces = payload(reader, element, &header).map_err(failed)?,
            STRIPS => elements.strips = payload(reader, element, &header).map_err(failed)?,
            _ => {
                let _: Vec<Skipped> = payload(reader, element, &header).map_err(failed)?;
            }
        }
    }
    warn_of_header(path, &header, warnings);
    elements.mesh(path, warnings)
}

/// A UTF-16 file in UTF-8, without byte order mark; others as they are.
fn text_as_utf8(bytes: &[u8]) -> Cow<'_, [u8]> {
    match bytes {
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => {
            Cow::Owned(text::decode(bytes).into_owned().into_bytes())
        }
        [0xef, 0xbb, 0xbf, rest @ ..] => Cow::Borrowed(rest),
        _ => Cow::Borrowed(bytes),
    }
}

fn payload<E: PropertyAccess>(
    reader: &mut Reader<impl BufRead>,
    element: &ElementDef,
    header: &Header,
) -> Result<Vec<E>, ParseError> {
    Parser::new().read_payload_for_element(reader, element, header)
}

/// Refuses files without positions or faces, and counts that the file is too short for: the parser
/// would believe them.
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
    let has_list = |element| property(element, &["vertex_indices", "vertex_index"]);
    if !has_list("face") && !has_list(STRIPS) {
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

/// The least number of bytes one element takes (an empty list is its length alone; in ascii, a
/// digit and a separator).
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

/// Warns of what a file says about its looks and direkt does not show.
fn warn_of_header(path: &Path, header: &Header, warnings: &mut Vec<String>) {
    let has = |element: &str, property: &str| {
        let element = header.elements.get(element).filter(|e| e.count > 0);
        element.is_some_and(|e| e.properties.contains_key(property))
    };
    let mut found = Vec::new();
    for (element, properties) in NOT_READ {
        let properties = properties.iter().filter(|p| has(element, p));
        found.extend(properties.map(|p| format!("{element}.{p}")));
    }
    let of_color = elements::COLOR_NAMES.map(|names| names.iter().any(|n| has("vertex", n)));
    let [red, green, blue, _] = of_color;
    if (red || green || blue) && !(red && green && blue) {
        found.push("a vertex colour without all of red, green and blue".to_owned());
    }
    if !found.is_empty() {
        let found = found.join(", ");
        warnings.push(format!("{}: not read: {found}", path.display()));
    }
}
