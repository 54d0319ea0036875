//! EXT_mesh_gpu_instancing: a node that shows its mesh several times.

use super::document::Document;
use super::nodes::Placed;
use super::{accessors, nodes, transform_error};
use crate::error::InputError;
use crate::scene::load::transform;
use glam::{DAffine3, DMat3, DQuat, DVec3};
use gltf::json::accessor::Type;
use serde_json::{Map, Value};

/// The extension's name.
const NAME: &str = "EXT_mesh_gpu_instancing";

/// Where an instance of a mesh stands.
pub(super) struct Place {
    /// `, instance 3`, for names; empty where it is the only one.
    pub(super) suffix: String,
    pub(super) to_world: DAffine3,
}

/// How many instances of its mesh node `index` shows, by what its accessors say.
pub(super) fn count(document: &Document, index: usize) -> u64 {
    let Some(attributes) = attributes_of(document, index) else {
        return 1;
    };
    let accessors = ["TRANSLATION", "ROTATION", "SCALE"].map(|name| {
        let index = usize::try_from(attributes.get(name)?.as_u64()?).ok()?;
        document.root.accessors.get(index)
    });
    let counts = accessors.iter().flatten().map(|a| a.count.0);
    counts.max().unwrap_or(1)
}

/// What the extension says of node `index`.
fn attributes_of(document: &Document, index: usize) -> Option<&Map<String, Value>> {
    let extensions = document.root.nodes[index].extensions.as_ref()?;
    extensions.others.get(NAME)?.get("attributes")?.as_object()
}

/// Where the instances of a node's mesh stand, moved by `placement`. What has scale 0 is hidden.
pub(super) fn place(
    document: &Document,
    node: &Placed,
    placement: &DAffine3,
    label: &str,
    warnings: &mut Vec<String>,
) -> Result<Vec<Place>, InputError> {
    let instanced = of_node(document, node.index)?;
    let is_instanced = instanced.is_some();
    let mut places = Vec::new();
    let mut hidden = 0;
    let all = instanced.unwrap_or_else(|| vec![DAffine3::IDENTITY]);
    for (number, instance) in all.into_iter().enumerate() {
        let to_file = node.to_world * instance;
        if to_file.matrix3 == DMat3::ZERO {
            hidden += 1;
            continue;
        }
        let to_world = *placement * to_file;
        transform::check(&to_world).map_err(|p| transform_error(document, node, &p))?;
        let suffix = match is_instanced {
            true => format!(", instance {number}"),
            false => String::new(),
        };
        places.push(Place { suffix, to_world });
    }
    if hidden > 0 {
        let file = document.file_name();
        warnings.push(match (is_instanced, hidden) {
            (false, _) => format!("{file}: {label} is hidden by a scale of 0"),
            (true, 1) => format!("{file}: 1 instance of {label} is hidden by a scale of 0"),
            (true, n) => format!("{file}: {n} instances of {label} are hidden by a scale of 0"),
        });
    }
    Ok(places)
}

/// The same for a mesh with a skin, whose joints take it to the file's world: its node has no part
/// in that, and instances of it are not defined.
pub(super) fn place_skinned(
    document: &Document,
    node: &Placed,
    placement: &DAffine3,
    label: &str,
    warnings: &mut Vec<String>,
) -> Result<Vec<Place>, InputError> {
    if of_node(document, node.index)?.is_some() {
        let file = document.file_name();
        warnings.push(format!(
            "{file}: {NAME} of {label} is ignored, as it has a skin"
        ));
    }
    Ok(vec![Place {
        suffix: String::new(),
        to_world: *placement,
    }])
}

/// From the space of the mesh to that of node `index`, for each of the node's instances; `None` for
/// a node that does not have the extension.
fn of_node(document: &Document, index: usize) -> Result<Option<Vec<DAffine3>>, InputError> {
    let Some(attributes) = attributes_of(document, index) else {
        return Ok(None);
    };
    let read = Reader {
        document,
        attributes,
        prefix: format!("nodes[{index}].extensions.{NAME}.attributes"),
    };
    let translations = read.all::<3>("TRANSLATION", Type::Vec3)?;
    let rotations = read.all::<4>("ROTATION", Type::Vec4)?;
    let scales = read.all::<3>("SCALE", Type::Vec3)?;
    let counts = [
        ("TRANSLATION", translations.as_ref().map(Vec::len)),
        ("ROTATION", rotations.as_ref().map(Vec::len)),
        ("SCALE", scales.as_ref().map(Vec::len)),
    ];
    let mut given = counts.iter().filter_map(|(name, n)| Some((name, (*n)?)));
    let Some((first, count)) = given.next() else {
        return Ok(None);
    };
    if let Some((name, other)) = given.find(|&(_, n)| n != count) {
        return Err(document.error(
            format!("{}.{name}", read.prefix),
            format!("has {other} elements"),
            format!("as many as {first}, {count}"),
        ));
    }
    let vector = |list: &Option<Vec<[f64; 3]>>, i: usize, default| {
        list.as_ref().map_or(default, |l| DVec3::from_array(l[i]))
    };
    let instance = |i| {
        nodes::compose(
            vector(&translations, i, DVec3::ZERO),
            rotations.as_ref().map(|l| DQuat::from_array(l[i])),
            vector(&scales, i, DVec3::ONE),
        )
    };
    Ok(Some((0..count).map(instance).collect()))
}

/// Reads the accessors that the extension names.
struct Reader<'a> {
    document: &'a Document,
    attributes: &'a Map<String, Value>,
    /// The JSON path of `attributes`.
    prefix: String,
}

impl Reader<'_> {
    fn all<const N: usize>(
        &self,
        name: &str,
        wanted: Type,
    ) -> Result<Option<Vec<[f64; N]>>, InputError> {
        let Some(value) = self.attributes.get(name) else {
            return Ok(None);
        };
        let field = format!("{}.{name}", self.prefix);
        let index = value.as_u64().and_then(|i| usize::try_from(i).ok());
        let index = index.ok_or_else(|| {
            let problem = format!("is {value}");
            self.document
                .error(&field, problem, "the index of an accessor")
        })?;
        accessors::numbers(self.document, index, &field, wanted).map(Some)
    }
}
