//! Which module may import which: the layers of the core, from the lowest to the highest. What lies
//! above it (instruments, window, command line) are packages of their own, which the compiler keeps
//! apart.

use crate::support::project;
use crate::support::source::{code, source_files};
use std::collections::BTreeSet;

/// Modules of `src/`, each with those that it may import.
const LAYERS: [(&str, &[&str]); 17] = [
    ("console", &[]),
    ("lattice", &[]),
    ("stats", &[]),
    ("error", &[]),
    ("output", &["console", "error"]),
    ("scene", &["error", "lattice"]),
    ("accel", &["scene"]),
    ("emitters", &["accel", "scene"]),
    ("effects", &["accel", "emitters", "scene"]),
    ("prepare", &["accel", "effects", "emitters", "scene"]),
    (
        "reference",
        &["accel", "effects", "emitters", "prepare", "scene"],
    ),
    (
        "gpu",
        &["accel", "effects", "emitters", "error", "prepare", "scene"],
    ),
    (
        "render",
        &[
            "effects", "error", "lattice", "gpu", "prepare", "scene", "stats",
        ],
    ),
    (
        "image",
        &["error", "gpu", "output", "prepare", "render", "scene"],
    ),
    (
        "renderer",
        &["error", "gpu", "image", "prepare", "render", "scene"],
    ),
    ("low_level", &[]),
    ("lib", &[]),
];

/// Modules of the crate that `text` names outside comments and its own unit tests, which end a
/// file.
fn imports(text: &str) -> BTreeSet<String> {
    let code = code(text);
    let names = code.split("crate::").skip(1);
    names
        .map(|rest| {
            rest.chars()
                .take_while(|c| c.is_alphanumeric() || *c == '_')
                .collect()
        })
        .collect()
}

#[test]
fn no_module_imports_one_above_it() {
    let source = project("src");
    let files = source_files(&source, &["rs"]);
    assert!(files.len() > 200, "{} files", files.len());
    let mut seen = BTreeSet::new();
    let mut upwards = Vec::new();
    for path in files.iter().filter(|path| !path.ends_with("tests.rs")) {
        let first = path.strip_prefix(&source).unwrap().iter().next().unwrap();
        let module = first.to_str().unwrap().trim_end_matches(".rs");
        let layer = LAYERS.iter().find(|(name, _)| *name == module);
        let (_, below) = layer.unwrap_or_else(|| panic!("{module} is in no layer"));
        seen.insert(module.to_owned());
        for import in imports(&std::fs::read_to_string(path).unwrap()) {
            if import != module && !below.contains(&import.as_str()) {
                upwards.push(format!("{} imports {import}", path.display()));
            }
        }
    }
    assert_eq!(upwards, [""; 0]);
    assert_eq!(seen.len(), LAYERS.len(), "a layer without files: {seen:?}");
}

#[test]
fn an_import_is_seen_wherever_it_stands() {
    let text = "use crate::gpu::Context;\n// crate::render\n#[cfg(test)]\nmod tests;\n\
                fn f() -> crate::scene::Scene {}\n#[cfg(test)]\nmod tests { use crate::reference; }";
    let expected = ["gpu", "scene"].map(str::to_owned);
    assert_eq!(imports(text), BTreeSet::from(expected));
}
