//! Typed reading of accessors.

mod sparse;

use super::document::{Document, slice};
use crate::error::InputError;
use glam::{DVec2, DVec3, Vec4};
use gltf::json::accessor::{Accessor, ComponentType, Type};
use gltf::json::validation::Checked;
use std::borrow::Cow;

/// Most elements that an accessor without data of its own may have.
const MAX_ZEROS: u64 = 1 << 24;

/// The elements of an accessor: `count` times `components` numbers, each `stride` bytes after the
/// other.
struct Elements<'a> {
    bytes: Cow<'a, [u8]>,
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

/// Elements of `N` numbers each, of a type with as many.
pub(super) fn numbers<const N: usize>(
    document: &Document,
    index: usize,
    field: &str,
    wanted: Type,
) -> Result<Vec<[f64; N]>, InputError> {
    assert_eq!(N, wanted.multiplicity(), "{wanted:?} has as many numbers");
    let elements = elements(document, index, field, wanted)?;
    let element = |i| std::array::from_fn(|c| elements.number(i, c));
    Ok((0..elements.count).map(element).collect())
}

/// Joints of vertices: `VEC4` of unsigned bytes or shorts.
pub(super) fn joints(
    document: &Document,
    index: usize,
    field: &str,
) -> Result<Vec<[u32; 4]>, InputError> {
    let elements = elements(document, index, field, Type::Vec4)?;
    elements.check_unsigned(document, index, "joints")?;
    let element = |i| std::array::from_fn(|c| elements.unsigned(i, c));
    Ok((0..elements.count).map(element).collect())
}

/// Vertex colours: `VEC3` or `VEC4` of float or of normalised unsigned integers, brought into [0,
/// 1] (glTF 2.0, section 3.7.2.1). Alpha is 1 where there is none.
pub(super) fn colors(
    document: &Document,
    index: usize,
    field: &str,
) -> Result<Vec<Vec4>, InputError> {
    let accessor = document.get(&document.root.accessors, index, "accessor", || {
        field.to_owned()
    })?;
    let (wanted, channels) = match accessor.type_ {
        Checked::Valid(Type::Vec3) => (Type::Vec3, 3),
        _ => (Type::Vec4, 4),
    };
    let elements = elements(document, index, field, wanted)?;
    if elements.component != ComponentType::F32 && !elements.normalized {
        let field = format!("accessors[{index}].normalized");
        let expected = "true for colours that are not floats";
        return Err(document.error(field, "is false", expected));
    }
    let color = |i| {
        let mut color = [1.0; 4];
        for (c, channel) in color.iter_mut().enumerate().take(channels) {
            *channel = elements.number(i, c);
            if !channel.is_finite() {
                let problem = format!("element {i} of accessor {index} is not finite");
                return Err(document.error(field, problem, "finite numbers"));
            }
        }
        Ok(Vec4::from_array(color.map(|c| c.clamp(0.0, 1.0) as f32)))
    };
    (0..elements.count).map(color).collect()
}

/// In a list of corners: the strip or the fan ends here, and another begins.
pub(super) const RESTART: u32 = u32::MAX;

/// Vertex indices: `SCALAR` of an unsigned type, each below `vertices`; the type's largest value is
/// [`RESTART`] where `restarts`.
pub(super) fn indices(
    document: &Document,
    index: usize,
    field: &str,
    vertices: usize,
    restarts: bool,
) -> Result<Vec<u32>, InputError> {
    let elements = elements(document, index, field, Type::Scalar)?;
    elements.check_unsigned(document, index, "indices")?;
    let largest = match elements.component {
        ComponentType::U8 => u8::MAX.into(),
        ComponentType::U16 => u16::MAX.into(),
        _ => u32::MAX,
    };
    (0..elements.count)
        .map(|i| {
            let value = elements.unsigned(i, 0);
            if restarts && value == largest {
                return Ok(RESTART);
            }
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
    if let Some(unpacked) = document.draco.unpacked(document, index)? {
        if unpacked.components != wanted.multiplicity() {
            let problem = format!("has {} numbers in Draco's mesh", unpacked.components);
            let expected = format!("{}, {wanted:?}", wanted.multiplicity());
            return Err(document.error(field, problem, expected));
        }
        return Ok(Elements {
            bytes: Cow::Borrowed(&unpacked.bytes),
            count: unpacked.count,
            stride: unpacked.component.size() * unpacked.components,
            component: unpacked.component,
            normalized: accessor.normalized,
        });
    }
    let size = component.size() * wanted.multiplicity();
    let count = accessor.count.0;
    let base = match accessor.buffer_view {
        Some(view) => {
            let offset = accessor.byte_offset.map_or(0, |o| o.0);
            let view = (view.value(), offset);
            Some(strided(document, &name, view, count, size)?)
        }
        None => None,
    };
    let (bytes, stride) = match (base, &accessor.sparse) {
        (Some((bytes, stride)), None) => (Cow::Borrowed(bytes), stride),
        (base, sparse) => {
            let mut bytes = packed(document, &name, base, count, size)?;
            if let Some(sparse) = sparse {
                sparse::displace(document, &name, sparse, &mut bytes, size)?;
            }
            (Cow::Owned(bytes), size)
        }
    };
    Ok(Elements {
        bytes,
        // The range check bounds the count by the bytes that exist.
        count: usize::try_from(count).unwrap_or(0),
        stride,
        component,
        normalized: accessor.normalized,
    })
}

/// The bytes of `count` elements of `size` bytes that begin at an offset into a buffer view, and
/// their distance there; the last element ends them.
fn strided<'a>(
    document: &'a Document,
    name: &str,
    (view, offset): (usize, u64),
    count: u64,
    size: usize,
) -> Result<(&'a [u8], usize), InputError> {
    let (bytes, stride) = document.view(view, || format!("{name}.bufferView"))?;
    let stride = stride.filter(|&s| s > 0).unwrap_or(size);
    let needed = match count.checked_sub(1) {
        None => Some(0),
        Some(before) => before
            .checked_mul(stride as u64)
            .and_then(|n| n.checked_add(size as u64)),
    };
    let range = needed
        .and_then(|needed| slice(bytes, offset, needed))
        .filter(|_| stride >= size);
    let bytes = range.ok_or_else(|| {
        document.error(
            name,
            format!(
                "{count} elements of {size} bytes, {stride} apart, from byte {offset} on do not fit bufferView {view}"
            ),
            format!("a range within its {} bytes", bytes.len()),
        )
    })?;
    Ok((bytes, stride))
}

/// A copy of the elements of `base`, one after the other; zeros where there is none (glTF 2.0,
/// section 3.6.2.3).
fn packed(
    document: &Document,
    name: &str,
    base: Option<(&[u8], usize)>,
    count: u64,
    size: usize,
) -> Result<Vec<u8>, InputError> {
    let Some((bytes, stride)) = base else {
        if count > MAX_ZEROS {
            return Err(document.error(
                format!("{name}.count"),
                format!("is {count} without a bufferView"),
                format!("at most {MAX_ZEROS} elements that no data stands for"),
            ));
        }
        return Ok(vec![0; count as usize * size]);
    };
    Ok(bytes
        .chunks(stride)
        .flat_map(|element| &element[..size])
        .copied()
        .collect())
}

fn checked_types(
    document: &Document,
    accessor: &Accessor,
    name: &str,
    wanted: Type,
) -> Result<ComponentType, InputError> {
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

    /// Refuses components that are no unsigned integers; accessor `index` holds `what`.
    fn check_unsigned(
        &self,
        document: &Document,
        index: usize,
        what: &str,
    ) -> Result<(), InputError> {
        use ComponentType::{U8, U16, U32};
        if matches!(self.component, U8 | U16 | U32) {
            return Ok(());
        }
        Err(document.error(
            format!("accessors[{index}].componentType"),
            format!("is {}", self.component.as_gl_enum()),
            format!("5121, 5123 or 5125 (unsigned) for {what}"),
        ))
    }

    fn unsigned(&self, element: usize, component: usize) -> u32 {
        match self.component {
            ComponentType::U8 => u8::from_le_bytes(self.raw(element, component)).into(),
            ComponentType::U16 => u16::from_le_bytes(self.raw(element, component)).into(),
            _ => u32::from_le_bytes(self.raw(element, component)),
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
        if self.normalized && largest > 1.0 {
            // -128 and -32,768 stand for -1, as their neighbours do (glTF 2.0, section 3.6.2.2).
            (value / largest).max(-1.0)
        } else {
            value
        }
    }
}
