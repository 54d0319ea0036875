//! From text to the types of [`mod@super::format`] and [`super::format_shapes`], with errors that
//! name the line and the field.

use super::format::SceneFile;
use super::format_materials::MaterialKind;
use super::format_shapes::{Scale, ShapeKind};
use crate::error::InputError;
use crate::scene::lights::LightKeys;
use crate::scene::rgb::OneOrThree;
use serde::de::{Deserialize, Deserializer};
use serde_path_to_error::Segment;
use std::path::Path;
use strum::VariantNames;
use toml::de::{DeTable, DeValue};
use toml::{Table, Value};

/// Parses a scene file.
pub(super) fn parse(path: &Path, text: &str) -> Result<SceneFile, InputError> {
    let mut table: Table = toml::from_str(text).map_err(|e| syntax_error(path, text, &e))?;
    refuse_non_finite(path, text, &mut Vec::new(), &Value::Table(table.clone()))?;
    for (list, common) in TAGGED {
        tag(path, text, &mut table, list, common)?;
    }
    serde_path_to_error::deserialize(Value::Table(table)).map_err(|e| {
        let steps = steps(e.path());
        field_error(path, text, &steps, e.inner().message())
    })
}

/// Tables with a `type`, and the keys that all their types share.
const TAGGED: [(&str, &[&str]); 3] = [
    (
        "materials",
        &["double_sided", "textures", "opacity", "alpha_cutoff"],
    ),
    ("shapes", &["name", "material", "emission", "transform"]),
    ("lights", &["group"]),
];

/// Moves the keys that depend on the `type` into a table `kind.TYPE`: from there serde reads them
/// as an enum, and says which key is wrong, which it does not for enums that are told apart by a
/// key among the others.
fn tag(
    path: &Path,
    text: &str,
    table: &mut Table,
    list: &str,
    common: &[&str],
) -> Result<(), InputError> {
    let entries: Vec<(Step, &mut Value)> = match table.get_mut(list) {
        Some(Value::Array(array)) => array
            .iter_mut()
            .enumerate()
            .map(|(i, v)| (Step::Index(i), v))
            .collect(),
        Some(Value::Table(named)) => named
            .iter_mut()
            .map(|(k, v)| (Step::Key(k.to_owned()), v))
            .collect(),
        _ => return Ok(()),
    };
    for (step, entry) in entries {
        let Value::Table(entry) = entry else { continue };
        let steps = [Step::Key(list.to_owned()), step];
        let Some(kind) = entry.remove("type") else {
            let problem = "has no `type`";
            return Err(located(path, text, &steps, problem, known_types(list)));
        };
        let Value::String(kind) = kind else {
            let [list_step, step] = steps;
            let steps = [list_step, step, Step::Key("type".to_owned())];
            let problem = format!("is {kind}");
            return Err(located(path, text, &steps, &problem, known_types(list)));
        };
        let own = std::mem::take(entry);
        let (shared, own): (Table, Table) = own
            .into_iter()
            .partition(|(key, _)| common.contains(&key.as_str()));
        *entry = shared;
        let tagged = Table::from_iter([(kind, Value::Table(own))]);
        entry.insert("kind".to_owned(), Value::Table(tagged));
    }
    Ok(())
}

fn known_types(list: &str) -> String {
    let names = match list {
        "materials" => MaterialKind::VARIANTS,
        "shapes" => ShapeKind::VARIANTS,
        _ => LightKeys::VARIANTS,
    };
    let quoted: Vec<String> = names.iter().map(|name| format!("\"{name}\"")).collect();
    let (last, others) = quoted.split_last().expect("there is a type");
    format!("type = {} or {last}", others.join(", "))
}

/// One step of the way to a field.
#[derive(Debug, Clone, PartialEq)]
enum Step {
    Key(String),
    Index(usize),
}

/// The way to a field, as the file has it: without what [`tag`] put in between.
fn steps(path: &serde_path_to_error::Path) -> Vec<Step> {
    let mut steps: Vec<Step> = path
        .iter()
        .filter_map(|segment| match segment {
            Segment::Seq { index } => Some(Step::Index(*index)),
            Segment::Map { key } => Some(Step::Key(key.clone())),
            Segment::Enum { variant } => Some(Step::Key(variant.clone())),
            Segment::Unknown => None,
        })
        .collect();
    if is_tagged(&steps) && steps.get(2) == Some(&Step::Key("kind".to_owned())) {
        steps.drain(2..steps.len().min(4));
    }
    steps
}

/// Whether the way leads into one of the [`TAGGED`] tables.
fn is_tagged(steps: &[Step]) -> bool {
    matches!(steps.first(), Some(Step::Key(key)) if TAGGED.iter().any(|(list, _)| list == key))
}

fn join(steps: &[Step]) -> String {
    let mut joined = String::new();
    for step in steps {
        match step {
            Step::Index(i) => joined += &format!("[{i}]"),
            Step::Key(k) => {
                if !joined.is_empty() {
                    joined.push('.');
                }
                joined += k;
            }
        }
    }
    joined
}

/// The line of the deepest of `steps` that the text has.
fn line_of(text: &str, steps: &[Step]) -> Option<usize> {
    let table = DeTable::parse(text).ok()?;
    let mut position = None;
    let mut value: Option<&DeValue> = None;
    for step in steps {
        let next = match (value, step) {
            (None, Step::Key(k)) => table.get_ref().get(k.as_str()),
            (Some(DeValue::Table(t)), Step::Key(k)) => t.get(k.as_str()),
            (Some(DeValue::Array(a)), Step::Index(i)) => a.get(*i),
            _ => None,
        };
        let Some(next) = next else { break };
        position = Some(next.span().start);
        value = Some(next.get_ref());
    }
    Some(line_at(text, position?))
}

fn line_at(text: &str, offset: usize) -> usize {
    let before = &text.as_bytes()[..offset.min(text.len())];
    1 + before.iter().filter(|b| **b == b'\n').count()
}

fn located(
    path: &Path,
    text: &str,
    steps: &[Step],
    problem: &str,
    expected: impl Into<String>,
) -> InputError {
    let line = line_of(text, steps).map_or_else(String::new, |l| format!(" (line {l})"));
    InputError::new(path, join(steps), format!("{problem}{line}"), expected)
}

/// What serde says about a field, in the words of the other messages: `problem; expected …`.
fn field_error(path: &Path, text: &str, steps: &[Step], message: &str) -> InputError {
    let message = message.trim();
    let (problem, expected) = message.split_once(", expected ").unwrap_or((message, ""));
    let mut expected = expected
        .strip_prefix("one of ")
        .unwrap_or(expected)
        .to_owned();
    let unknown_key = problem.starts_with("unknown field");
    if let (true, Some(Step::Key(list)), true) = (unknown_key, steps.first(), steps.len() == 3) {
        for (_, common) in TAGGED.iter().filter(|(name, _)| name == list) {
            for key in *common {
                if !expected.contains(&format!("`{key}`")) {
                    expected += &format!(", `{key}`");
                }
            }
        }
    }
    let problem = problem
        .replace("unknown field", "unknown key")
        .replace("missing field", "missing key");
    let Some(variant) = unknown_variant(&problem) else {
        return located(path, text, steps, &problem, expected);
    };
    // An enum is a table's `type`, a table with one key (a step of a transform), or a plain value.
    let mut steps = steps.to_vec();
    let word = match steps.last() {
        _ if steps.len() == 2 && is_tagged(&steps) => {
            steps.push(Step::Key("type".to_owned()));
            "type"
        }
        Some(Step::Index(_)) => {
            steps.push(Step::Key(variant.clone()));
            "key"
        }
        _ => "value",
    };
    let problem = format!("unknown {word} `{variant}`");
    located(path, text, &steps, &problem, expected)
}

fn unknown_variant(problem: &str) -> Option<String> {
    let rest = problem.strip_prefix("unknown variant `")?;
    Some(rest.strip_suffix('`')?.to_owned())
}

fn syntax_error(path: &Path, text: &str, error: &toml::de::Error) -> InputError {
    let line = error.span().map_or_else(String::new, |span| {
        format!(" (line {})", line_at(text, span.start))
    });
    let message = error.message().trim().replace('\n', ", ");
    InputError::file(path, format!("is not valid TOML: {message}{line}"), "")
}

/// TOML knows `nan` and `inf`; no field of a scene does.
fn refuse_non_finite(
    path: &Path,
    text: &str,
    steps: &mut Vec<Step>,
    value: &Value,
) -> Result<(), InputError> {
    match value {
        Value::Float(f) if !f.is_finite() => {
            let problem = format!("is {}", f.to_string().to_lowercase());
            return Err(located(path, text, steps, &problem, "a finite number"));
        }
        Value::Array(array) => {
            for (i, entry) in array.iter().enumerate() {
                steps.push(Step::Index(i));
                refuse_non_finite(path, text, steps, entry)?;
                steps.pop();
            }
        }
        Value::Table(table) => {
            for (key, entry) in table {
                steps.push(Step::Key(key.clone()));
                refuse_non_finite(path, text, steps, entry)?;
                steps.pop();
            }
        }
        _ => {}
    }
    Ok(())
}

impl<'de> Deserialize<'de> for Scale {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let visitor = OneOrThree("three factors [x, y, z], or one for all");
        Ok(Self(deserializer.deserialize_any(visitor)?))
    }
}
