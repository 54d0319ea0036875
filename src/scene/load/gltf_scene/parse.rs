//! The JSON of a glTF: what writers do to it is undone before it is read by type.

use crate::error::InputError;
use gltf::json;
use serde_json::{Map, Number, Value, json};
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::path::Path;

/// A glTF's JSON by type.
pub(super) struct Parsed {
    pub(super) root: json::Root,
    /// Names of all extensions that objects of the file carry.
    pub(super) extensions: BTreeSet<String>,
    /// Attributes beside those of [`MORPHED`] that morph targets displace.
    pub(super) unread_morphs: BTreeSet<String>,
}

/// Attributes whose displacements by morph targets are read.
const MORPHED: [&str; 3] = ["POSITION", "NORMAL", "TANGENT"];

/// Parses the JSON `text` of the file `path`.
pub(super) fn parse(path: &Path, text: &[u8]) -> Result<Parsed, InputError> {
    let unreadable =
        |e: serde_json::Error| InputError::file(path, format!("is not a readable glTF: {e}"), "");
    let mut value: Value = serde_json::from_slice(&plain(text)).map_err(unreadable)?;
    if !value.is_object() {
        let problem = "is not a readable glTF: its JSON is no object";
        return Err(InputError::file(path, problem, "an object with `asset`"));
    }
    let mut extensions = BTreeSet::new();
    tidy(&mut value, &mut extensions);
    let unread_morphs = unread_morphs(&value);
    name_no_nodes(&mut value);
    let root = serde_path_to_error::deserialize(value).map_err(|e| {
        let field = match e.path().to_string() {
            root if root == "." => String::new(),
            field => field,
        };
        let problem = format!("is not a readable glTF: {}", e.inner());
        InputError::new(path, field, problem, "")
    })?;
    Ok(Parsed {
        root,
        extensions,
        unread_morphs,
    })
}

/// `text` in UTF-8, without a byte order mark and without what pads it.
fn plain(text: &[u8]) -> Cow<'_, [u8]> {
    let padding = |byte: &u8| *byte == 0 || byte.is_ascii_whitespace();
    let trimmed = |text: &[u8]| text.len() - text.iter().rev().take_while(|b| padding(b)).count();
    let wide = |unit: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = text[2..]
            .chunks_exact(2)
            .map(|pair| unit([pair[0], pair[1]]))
            .collect();
        let mut narrow = String::from_utf16_lossy(&units).into_bytes();
        narrow.truncate(trimmed(&narrow));
        Cow::Owned(narrow)
    };
    match text {
        [0xff, 0xfe, ..] => wide(u16::from_le_bytes),
        [0xfe, 0xff, ..] => wide(u16::from_be_bytes),
        _ => {
            let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
            Cow::Borrowed(&text[..trimmed(text)])
        }
    }
}

/// Drops what is `null`, writes `3.0` as the integer 3, and collects the extensions' names.
fn tidy(value: &mut Value, extensions: &mut BTreeSet<String>) {
    match value {
        Value::Object(object) => {
            object.retain(|_, member| !member.is_null());
            for (key, member) in object {
                if key == "extensions" {
                    let names = member.as_object().into_iter().flat_map(Map::keys);
                    extensions.extend(names.cloned());
                }
                if key != "extras" {
                    tidy(member, extensions);
                }
            }
        }
        Value::Array(list) => list.iter_mut().for_each(|item| tidy(item, extensions)),
        Value::Number(number) => {
            if let Some(integer) = whole(number) {
                *number = integer.into();
            }
        }
        _ => {}
    }
}

/// The value of a number with a fractional part that is zero: some writers know no integers.
fn whole(number: &Number) -> Option<i64> {
    const EXACT: f64 = 9_007_199_254_740_992.0;
    let value = number.as_f64().filter(|_| number.is_f64())?;
    let minus_zero = value == 0.0 && value.is_sign_negative();
    (value.fract() == 0.0 && value.abs() < EXACT && !minus_zero).then_some(value as i64)
}

/// What the morph targets of all meshes displace and nobody reads.
fn unread_morphs(value: &Value) -> BTreeSet<String> {
    fn items<'v>(value: &'v Value, key: &str) -> impl Iterator<Item = &'v Value> {
        value
            .get(key)
            .and_then(Value::as_array)
            .into_iter()
            .flatten()
    }
    let primitives = items(value, "meshes").flat_map(|mesh| items(mesh, "primitives"));
    let targets = primitives.flat_map(|primitive| items(primitive, "targets"));
    let names = targets.filter_map(Value::as_object).flat_map(Map::keys);
    let unread = names.filter(|name| !MORPHED.contains(&name.as_str()));
    unread.cloned().collect()
}

/// A scene's `nodes` are optional, and the crate's are not.
fn name_no_nodes(value: &mut Value) {
    let scenes = value.get_mut("scenes").and_then(Value::as_array_mut);
    for scene in scenes.into_iter().flatten() {
        if let Some(scene) = scene.as_object_mut() {
            scene.entry("nodes").or_insert_with(|| json!([]));
        }
    }
}
