//! Typed reading of accessors.

use super::document::Document;
use crate::error::InputError;
use glam::{DVec2, DVec3};
use gltf::json::accessor::{Accessor, ComponentType, Type};
use gltf::json::validation::Checked;

/// The elements of an accessor: `count` times `components` numbers, each `stride` bytes after the other.
struct Elements<'a> {
    bytes: &'a [u8],
    count: usize,
    stride: usize,
    component: ComponentType,
    normalized: bool,
}

/// Vertex positions or normals: `VEC3` of float, or of integers (KHR_mesh_quantization).
pub(super) fn vectors(
    document: &Document,
    index: usize,
    field: &str,
) -> Result<Vec<DVec3>, InputError> {
    let elements = elements(document, index, field, Type::Vec3)?;
    let vector = |i| DVec3::from_array([0, 1, 2].map(|c| elements.number(i, c)));
    Ok((0..elements.count).map(vector).collect())
}

/// Texture coordinates: `VEC2` of float or of integers.
pub(super) fn coordinates(
    document: &Document,
    index: usize,
    field: &str,
) -> Result<Vec<DVec2>, InputError> {
    let elements = elements(document, index, field, Type::Vec2)?;
    let pair = |i| DVec2::new(elements.number(i, 0), elements.number(i, 1));
    Ok((0..elements.count).map(pair).collect())
}

/// Vertex indices: `SCALAR` of an unsigned type, each below `vertices`.
pub(super) fn indices(
    document: &Document,
    index: usize,
    field: &str,
    vertices: usize,
) -> Result<Vec<u32>, InputError> {
    let elements = elements(document, index, field, Type::Scalar)?;
    if !matches!(
        elements.component,
        ComponentType::U8 | ComponentType::U16 | ComponentType::U32
    ) {
        return Err(document.error(
            format!("accessors[{index}].componentType"),
            format!("is {}", elements.component.as_gl_enum()),
            "5121, 5123 or 5125 (unsigned) for indices",
        ));
    }
    (0..elements.count)
        .map(|i| {
            let value = elements.unsigned(i);
            if (value as usize) < vertices {
                return Ok(value);
            }
            Err(document.error(
                field,
                format!("vertex {value} (element {i} of accessor {index}) is out of range"),
                format!("an index into the {vertices} vertices"),
            ))
        })
        .collect()
}

fn elements<'a>(
    document: &'a Document,
    index: usize,
    field: &str,
    wanted: Type,
) -> Result<Elements<'a>, InputError> {
    let accessor = document.get(&document.root.accessors, index, "accessor", || {
        field.to_owned()
    })?;
    let name = format!("accessors[{index}]");
    let component = checked_types(document, accessor, &name, wanted)?;
    let Some(view) = accessor.buffer_view else {
        return Err(document.error(name, "has no bufferView", "data for the geometry"));
    };
    let (bytes, stride) = document.view(view.value(), || format!("{name}.bufferView"))?;
    let size = component.size() * wanted.multiplicity();
    let stride = stride.unwrap_or(size);
    let count = accessor.count.0;
    let offset = accessor.byte_offset.map_or(0, |o| o.0);
    let needed = count
        .saturating_sub(1)
        .checked_mul(stride as u64)
        .and_then(|n| n.checked_add(size as u64))
        .filter(|_| count > 0)
        .unwrap_or(if count > 0 { u64::MAX } else { 0 });
    let range = super::document::slice(bytes, offset, needed).filter(|_| stride >= size);
    let bytes = range.ok_or_else(|| {
        document.error(
            &name,
            format!(
                "{count} elements of {size} bytes, {stride} apart, from byte {offset} on do not fit bufferView {}",
                view.value()
            ),
            format!("a range within its {} bytes", bytes.len()),
        )
    })?;
    Ok(Elements {
        bytes,
        // The range check bounds the count by the bytes that exist.
        count: usize::try_from(count).unwrap_or(0),
        stride,
        component,
        normalized: accessor.normalized,
    })
}

fn checked_types(
    document: &Document,
    accessor: &Accessor,
    name: &str,
    wanted: Type,
) -> Result<ComponentType, InputError> {
    if accessor.sparse.is_some() {
        return Err(document.error(
            format!("{name}.sparse"),
            "sparse accessors are not supported",
            "a file without them",
        ));
    }
    match accessor.type_ {
        Checked::Valid(found) if found == wanted => {}
        Checked::Valid(found) => {
            return Err(document.error(
                format!("{name}.type"),
                format!("is {found:?}"),
                format!("{wanted:?}"),
            ));
        }
        Checked::Invalid => {
            return Err(document.error(
                format!("{name}.type"),
                "is unknown",
                format!("{wanted:?}"),
            ));
        }
    }
    match accessor.component_type {
        Checked::Valid(component) => Ok(component.0),
        Checked::Invalid => Err(document.error(
            format!("{name}.componentType"),
            "is unknown",
            "5120, 5121, 5122, 5123, 5125 or 5126",
        )),
    }
}

impl Elements<'_> {
    fn raw<const N: usize>(&self, element: usize, component: usize) -> [u8; N] {
        let at = element * self.stride + component * N;
        self.bytes[at..at + N]
            .try_into()
            .expect("a slice of N bytes")
    }

    fn unsigned(&self, element: usize) -> u32 {
        match self.component {
            ComponentType::U8 => u8::from_le_bytes(self.raw(element, 0)).into(),
            ComponentType::U16 => u16::from_le_bytes(self.raw(element, 0)).into(),
            _ => u32::from_le_bytes(self.raw(element, 0)),
        }
    }

    fn number(&self, element: usize, component: usize) -> f64 {
        let (value, largest): (f64, f64) = match self.component {
            ComponentType::I8 => (
                i8::from_le_bytes(self.raw(element, component)).into(),
                127.0,
            ),
            ComponentType::U8 => (
                u8::from_le_bytes(self.raw(element, component)).into(),
                255.0,
            ),
            ComponentType::I16 => (
                i16::from_le_bytes(self.raw(element, component)).into(),
                32_767.0,
            ),
            ComponentType::U16 => (
                u16::from_le_bytes(self.raw(element, component)).into(),
                65_535.0,
            ),
            ComponentType::U32 => (u32::from_le_bytes(self.raw(element, component)).into(), 1.0),
            ComponentType::F32 => (f32::from_le_bytes(self.raw(element, component)).into(), 1.0),
        };
        if self.normalized {
            value / largest
        } else {
            value
        }
    }
}
