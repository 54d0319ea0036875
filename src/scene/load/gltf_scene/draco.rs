//! KHR_draco_mesh_compression: primitives whose indices and attributes are one compressed mesh.

use super::document::Document;
use crate::error::InputError;
use draco_core::{DataType, DecodeLimits, DecoderBuffer, MeshDecoder, PointAttribute, PointIndex};
use gltf::json::accessor::ComponentType;
use gltf::json::mesh::Primitive;
use serde::Deserialize;
use std::collections::{BTreeMap, HashMap};
use std::sync::OnceLock;

/// The extension's name.
pub(super) const NAME: &str = "KHR_draco_mesh_compression";
/// Most vertices, and most triangles, of a primitive.
const MAX_SIZE: u64 = 1 << 27;

/// What the extension says of a primitive.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Compressed {
    buffer_view: usize,
    /// The attributes' numbers in the compressed mesh, by name.
    attributes: BTreeMap<String, u32>,
}

/// The compressed meshes of a file, each decoded when it is first asked for.
#[derive(Default)]
pub(super) struct DracoMeshes {
    /// By buffer view: the JSON path of what names it, and the mesh.
    meshes: HashMap<usize, (String, OnceLock<DracoMesh>)>,
    /// Per accessor whose data a mesh has, the buffer view and the attribute's number there.
    accessors: HashMap<usize, (usize, u32)>,
}

/// A decoded mesh.
pub(super) struct DracoMesh {
    /// Vertices of its triangles, three for each.
    pub(super) corners: Vec<u32>,
    attributes: HashMap<u32, Unpacked>,
}

/// The elements of an attribute, one after the other.
pub(super) struct Unpacked {
    pub(super) bytes: Vec<u8>,
    pub(super) count: usize,
    pub(super) component: ComponentType,
    /// Numbers of an element.
    pub(super) components: usize,
}

impl DracoMeshes {
    /// Those that the primitives of `document` name.
    pub(super) fn new(document: &Document) -> Result<Self, InputError> {
        let mut found = Self::default();
        for (mesh, json) in document.root.meshes.iter().enumerate() {
            for (number, primitive) in json.primitives.iter().enumerate() {
                let field = format!("meshes[{mesh}].primitives[{number}].extensions.{NAME}");
                if let Some(compressed) = of_primitive(document, primitive, &field)? {
                    found.add(document, primitive, &compressed, field)?;
                }
            }
        }
        Ok(found)
    }

    fn add(
        &mut self,
        document: &Document,
        primitive: &Primitive,
        compressed: &Compressed,
        field: String,
    ) -> Result<(), InputError> {
        let view = compressed.buffer_view;
        for (semantic, accessor) in &primitive.attributes {
            let Some(&id) = compressed.attributes.get(&semantic.to_string()) else {
                continue;
            };
            let place = (view, id);
            let before = self.accessors.insert(accessor.value(), place);
            if before.is_some_and(|before| before != place) {
                return Err(document.error(
                    format!("{field}.attributes.{}", semantic.to_string()),
                    format!(
                        "accessor {} stands for two compressed attributes",
                        accessor.value()
                    ),
                    "an accessor for each",
                ));
            }
        }
        self.meshes.entry(view).or_insert((field, OnceLock::new()));
        Ok(())
    }

    /// The elements of accessor `index` where a compressed mesh has them.
    pub(super) fn unpacked(
        &self,
        document: &Document,
        index: usize,
    ) -> Result<Option<&Unpacked>, InputError> {
        let Some(&(view, id)) = self.accessors.get(&index) else {
            return Ok(None);
        };
        let mesh = self.mesh(document, view)?;
        let unpacked = mesh.attributes.get(&id).ok_or_else(|| {
            let mut ids: Vec<u32> = mesh.attributes.keys().copied().collect();
            ids.sort_unstable();
            document.error(
                format!("{}.attributes", self.meshes[&view].0),
                format!("attribute {id} is not in the compressed mesh"),
                format!("one of {ids:?}"),
            )
        })?;
        Ok(Some(unpacked))
    }

    /// The compressed mesh of `primitive`; `None` where it has none.
    pub(super) fn of_primitive(
        &self,
        document: &Document,
        primitive: &Primitive,
    ) -> Result<Option<&DracoMesh>, InputError> {
        match of_primitive(document, primitive, NAME)? {
            Some(compressed) => self.mesh(document, compressed.buffer_view).map(Some),
            None => Ok(None),
        }
    }

    fn mesh(&self, document: &Document, view: usize) -> Result<&DracoMesh, InputError> {
        let (field, slot) = &self.meshes[&view];
        if let Some(known) = slot.get() {
            return Ok(known);
        }
        let (bytes, _) = document.view(view, || format!("{field}.bufferView"))?;
        let decoded = decode(bytes).map_err(|problem| {
            let problem = format!("bufferView {view} cannot be decoded: {problem}");
            document.error(field, problem, "a mesh that Draco compressed")
        })?;
        Ok(slot.get_or_init(|| decoded))
    }
}

fn of_primitive(
    document: &Document,
    primitive: &Primitive,
    field: &str,
) -> Result<Option<Compressed>, InputError> {
    let extensions = primitive.extensions.as_ref();
    let Some(value) = extensions.and_then(|e| e.others.get(NAME)) else {
        return Ok(None);
    };
    let compressed = Compressed::deserialize(value)
        .map_err(|e| document.error(field, format!("is not understood: {e}"), ""))?;
    Ok(Some(compressed))
}

/// Decodes a mesh, or says what is wrong with it.
fn decode(bytes: &[u8]) -> Result<DracoMesh, String> {
    let mut limits = DecodeLimits::default();
    limits.max_points = MAX_SIZE;
    limits.max_faces = MAX_SIZE;
    let mut buffer = DecoderBuffer::new(bytes).with_limits(limits);
    let mut mesh = draco_core::Mesh::new();
    MeshDecoder::new()
        .decode(&mut buffer, &mut mesh)
        .map_err(|e| e.to_string())?;
    let count = mesh.num_points();
    let corners: Vec<u32> = mesh.faces().iter().flatten().map(|point| point.0).collect();
    if let Some(outside) = corners.iter().find(|&&corner| corner as usize >= count) {
        return Err(format!("vertex {outside} of {count} is out of range"));
    }
    let mut attributes = HashMap::new();
    for index in 0..mesh.num_attributes() {
        let attribute = mesh.attribute(index);
        // Types that glTF does not have are no accessor's.
        if let Some(component) = component_of(attribute.data_type()) {
            let unpacked = unpack(attribute, component, count)?;
            attributes.insert(attribute.unique_id(), unpacked);
        }
    }
    Ok(DracoMesh {
        corners,
        attributes,
    })
}

fn component_of(kind: DataType) -> Option<ComponentType> {
    match kind {
        DataType::Int8 => Some(ComponentType::I8),
        DataType::Uint8 => Some(ComponentType::U8),
        DataType::Int16 => Some(ComponentType::I16),
        DataType::Uint16 => Some(ComponentType::U16),
        DataType::Uint32 => Some(ComponentType::U32),
        DataType::Float32 => Some(ComponentType::F32),
        _ => None,
    }
}

/// The attribute's value at each of `count` vertices.
fn unpack(
    attribute: &PointAttribute,
    component: ComponentType,
    count: usize,
) -> Result<Unpacked, String> {
    let components = usize::from(attribute.num_components());
    let size = components * component.size();
    let stride = usize::try_from(attribute.byte_stride()).unwrap_or(0);
    let data = attribute.buffer().data();
    let mut bytes = Vec::with_capacity(count * size);
    for vertex in 0..count {
        let value = attribute.mapped_index(PointIndex(vertex as u32)).0 as usize;
        let found = value
            .checked_mul(stride)
            .and_then(|at| data.get(at..at.checked_add(size)?));
        let found = found.ok_or_else(|| format!("vertex {vertex} has no value"))?;
        bytes.extend_from_slice(found);
    }
    Ok(Unpacked {
        bytes,
        count,
        component,
        components,
    })
}
