//! Sparse accessors: elements that displace those of the base (glTF 2.0, section 3.6.2.3).

use super::{Elements, strided};
use crate::error::InputError;
use crate::scene::load::gltf_scene::document::Document;
use gltf::json::accessor::sparse::Sparse;
use gltf::json::validation::Checked;
use std::borrow::Cow;

/// Writes the elements of `sparse`, of the accessor `name`, over those of `size` bytes in `bytes`.
pub(super) fn displace(
    document: &Document,
    name: &str,
    sparse: &Sparse,
    bytes: &mut [u8],
    size: usize,
) -> Result<(), InputError> {
    let count = bytes.len() / size;
    let indices = indices(document, name, sparse)?;
    let field = format!("{name}.sparse.values");
    let view = (
        sparse.values.buffer_view.value(),
        sparse.values.byte_offset.0,
    );
    let (values, stride) = strided(document, &field, view, sparse.count.0, size)?;
    let mut before = None;
    for (place, value) in values.chunks(stride).enumerate() {
        let index = indices.unsigned(place, 0) as usize;
        let refuse = |problem: String, expected: String| {
            let field = format!("{name}.sparse.indices");
            Err(document.error(
                field,
                format!("element {place} is {index}{problem}"),
                expected,
            ))
        };
        if index >= count {
            return refuse(String::new(), format!("an index of the {count} elements"));
        }
        if let Some(before) = before.filter(|&before| before >= index) {
            let problem = format!(" after {before}");
            return refuse(problem, "indices that increase".to_owned());
        }
        before = Some(index);
        bytes[index * size..][..size].copy_from_slice(&value[..size]);
    }
    Ok(())
}

/// Which elements are displaced.
fn indices<'a>(
    document: &'a Document,
    name: &str,
    sparse: &Sparse,
) -> Result<Elements<'a>, InputError> {
    let field = format!("{name}.sparse.indices");
    let Checked::Valid(component) = sparse.indices.component_type else {
        let field = format!("{field}.componentType");
        return Err(document.error(field, "is unknown", "5121, 5123 or 5125"));
    };
    let view = (
        sparse.indices.buffer_view.value(),
        sparse.indices.byte_offset.0,
    );
    let size = component.0.size();
    let (bytes, stride) = strided(document, &field, view, sparse.count.0, size)?;
    Ok(Elements {
        bytes: Cow::Borrowed(bytes),
        // The range check bounds the count by the bytes that exist.
        count: usize::try_from(sparse.count.0).unwrap_or(0),
        stride,
        component: component.0,
        normalized: false,
    })
}
