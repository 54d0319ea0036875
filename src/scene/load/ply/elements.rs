//! The elements of a PLY file that make a mesh.

use crate::error::InputError;
use crate::scene::Mesh;
use crate::scene::load::polygon::Triangulator;
use crate::scene::load::vertex_colors::{self, Clamped};
use glam::{DVec2, DVec3, Vec4};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};
use std::path::Path;

/// Names of a colour's channels.
pub(super) const COLOR_NAMES: [&[&str]; 4] = [
    &["red", "r", "diffuse_red"],
    &["green", "g", "diffuse_green"],
    &["blue", "b", "diffuse_blue"],
    &["alpha", "a", "diffuse_alpha"],
];

/// Ends a strip: the next index begins another. What −1 is in a list of unsigned numbers as well.
const RESTARTS: [i64; 2] = [-1, u32::MAX as i64];

/// Vertices, polygons and triangle strips.
#[derive(Default)]
pub(super) struct Elements {
    pub(super) vertices: Vec<Vertex>,
    pub(super) faces: Vec<Indices>,
    pub(super) strips: Vec<Indices>,
}

impl Elements {
    /// The mesh that they make.
    pub(super) fn mesh(&self, path: &Path, warnings: &mut Vec<String>) -> Result<Mesh, InputError> {
        let name = path.display().to_string();
        let vertices = &self.vertices;
        // What the file does not have is NaN in the first vertex as in all.
        let first = vertices.first();
        let normals = first.is_some_and(|v| !v.normal.is_nan());
        let uvs = first.is_some_and(|v| !v.uv.is_nan());
        let all = |has: bool| vertices.iter().filter(move |_| has);
        let mut mesh = Mesh {
            positions: vertices.iter().map(|v| v.position).collect(),
            normals: all(normals).map(|v| v.normal).collect(),
            // The file's v points up.
            uvs: all(uvs).map(|v| DVec2::new(v.uv.x, 1.0 - v.uv.y)).collect(),
            colors: self.colors(path, warnings)?,
            triangles: Vec::with_capacity(self.faces.len()),
            second_uvs: Vec::new(),
            tangents: Vec::new(),
        };
        let mut triangulator = Triangulator::default();
        let mut corners = Vec::new();
        for (number, face) in self.faces.iter().enumerate() {
            corners.clear();
            for &index in &face.0 {
                corners.push(self.index(path, || format!("face {number}"), index)?);
            }
            triangulator.add(&corners, &mesh.positions, &mut mesh.triangles);
        }
        for (number, strip) in self.strips.iter().enumerate() {
            for part in strip.0.split(|i| RESTARTS.contains(i)) {
                corners.clear();
                for &index in part {
                    corners.push(self.index(path, || format!("triangle strip {number}"), index)?);
                }
                add_strip(&corners, &mut mesh.triangles);
            }
        }
        warnings.append(&mut triangulator.warnings(&name));
        Ok(mesh)
    }

    fn index(
        &self,
        path: &Path,
        field: impl FnOnce() -> String,
        index: i64,
    ) -> Result<u32, InputError> {
        let count = self.vertices.len();
        match u32::try_from(index) {
            Ok(index) if (index as usize) < count => Ok(index),
            _ => Err(InputError::new(
                path,
                field(),
                format!("vertex index {index} is out of range"),
                format!(
                    "0 to {} (there are {count} vertices)",
                    count.saturating_sub(1)
                ),
            )),
        }
    }

    fn colors(&self, path: &Path, warnings: &mut Vec<String>) -> Result<Vec<Vec4>, InputError> {
        let has_color = |v: &Vertex| !v.color.truncate().is_nan();
        if !self.vertices.first().is_some_and(has_color) {
            return Ok(Vec::new());
        }
        let mut clamped = Clamped::default();
        let mut colors = Vec::with_capacity(self.vertices.len());
        for (number, vertex) in self.vertices.iter().enumerate() {
            let mut color = vertex.color;
            if color.w.is_nan() {
                color.w = 1.0;
            }
            let factors = clamped.color(color.to_array().map(f64::from));
            colors.push(factors.ok_or_else(|| {
                InputError::new(
                    path,
                    format!("vertex {number}"),
                    format!("its colour is {}", vertex.color),
                    "finite numbers",
                )
            })?);
        }
        if let Some(sentence) = clamped.sentence() {
            warnings.push(format!("{}: {sentence}", path.display()));
        }
        Ok(vertex_colors::unless_white(colors))
    }
}

/// Adds the triangles of a strip, which turn alike. Those with a vertex twice join its parts and
/// show nothing.
fn add_strip(corners: &[u32], triangles: &mut Vec<[u32; 3]>) {
    for (number, corner) in corners.windows(3).enumerate() {
        let (a, b, c) = (corner[0], corner[1], corner[2]);
        if a != b && b != c && c != a {
            let turned = number % 2 == 1;
            triangles.push(if turned { [b, a, c] } else { [a, b, c] });
        }
    }
}

/// A vertex; NaN where the file says nothing.
pub(super) struct Vertex {
    position: DVec3,
    normal: DVec3,
    uv: DVec2,
    color: Vec4,
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self {
            position: DVec3::NAN,
            normal: DVec3::NAN,
            uv: DVec2::NAN,
            color: Vec4::NAN,
        }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let number = number(&property);
        let place = match name {
            "x" => &mut self.position.x,
            "y" => &mut self.position.y,
            "z" => &mut self.position.z,
            "nx" => &mut self.normal.x,
            "ny" => &mut self.normal.y,
            "nz" => &mut self.normal.z,
            "u" | "s" | "texture_u" => &mut self.uv.x,
            "v" | "t" | "texture_v" => &mut self.uv.y,
            _ => return self.set_channel(name, number),
        };
        let Some((value, _)) = number else {
            return PropertyAccessResult::UnsupportedType;
        };
        *place = value;
        PropertyAccessResult::Set
    }
}

impl Vertex {
    fn set_channel(&mut self, name: &str, number: Option<(f64, f64)>) -> PropertyAccessResult {
        let channel = COLOR_NAMES.iter().position(|names| names.contains(&name));
        match (channel, number) {
            (None, _) => PropertyAccessResult::Ignored,
            (_, None) => PropertyAccessResult::UnsupportedType,
            (Some(channel), Some((value, one))) => {
                self.color[channel] = (value / one) as f32;
                PropertyAccessResult::Set
            }
        }
    }
}

/// A number, and what stands for 1 where it is a channel of a colour.
fn number(property: &Property) -> Option<(f64, f64)> {
    Some(match *property {
        Property::Char(v) => (v.into(), 127.0),
        Property::UChar(v) => (v.into(), 255.0),
        Property::Short(v) => (v.into(), 32_767.0),
        Property::UShort(v) => (v.into(), 65_535.0),
        // Wide enough for anything, but written for the bytes of an image.
        Property::Int(v) => (v.into(), 255.0),
        Property::UInt(v) => (v.into(), 255.0),
        Property::Float(v) => (v.into(), 1.0),
        Property::Double(v) => (v, 1.0),
        _ => return None,
    })
}

/// Vertex indices of a polygon or a strip, not yet checked.
pub(super) struct Indices(Vec<i64>);

impl PropertyAccess for Indices {
    fn new() -> Self {
        Self(Vec::new())
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !matches!(name, "vertex_indices" | "vertex_index") {
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
pub(super) struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}
