//! The source files that name one kind of light or one sampler: few, and listed here. Tests,
//! examples and re-exports do not count.

use crate::support::project;
use crate::support::source::{code, source_files};
use clap::ValueEnum;
use direkt::scene::{Light, Sampler};
use std::collections::BTreeSet;
use std::path::PathBuf;

/// Where a light without a surface is at home; `KIND` is its name.
const HOME: [&str; 8] = [
    "shaders/light/KIND.wesl",
    "shaders/light/light.wesl",
    "src/effects/mod.rs",
    "src/reference/light/KIND.rs",
    "src/reference/light/light.rs",
    "src/reference/light/mod.rs",
    "src/scene/lights/KIND.rs",
    "src/scene/lights/mod.rs",
];

/// Files that know the kinds that glTF has, whose irradiance is known exactly.
const PUNCTUAL: &[&str] = &[
    "src/reference/exact/scene.rs",
    "src/scene/load/gltf_scene/lights.rs",
];

/// Files that know some kinds because they do more with them; BSDF-sampled rays and cameras reach
/// suns.
const GUESTS: [(&str, &[&str]); 4] = [
    ("point", PUNCTUAL),
    ("spot", PUNCTUAL),
    ("directional", PUNCTUAL),
    (
        "sun",
        &[
            "crates/window/src/density.rs",
            "shaders/kernel/direct.wesl",
            "shaders/kernel/light_groups.wesl",
            "shaders/kernel/lights_in_view.wesl",
            "src/effects/rules.rs",
            "src/emitters/mod.rs",
            "src/emitters/unit.rs",
            "src/gpu/lights.rs",
            "src/prepare/lights_in_view.rs",
            "src/prepare/small_lights.rs",
            "src/reference/exact/scene.rs",
            "src/reference/kernel/bsdf_rays.rs",
            "src/reference/kernel/lights_in_view.rs",
            "src/scene/lights/directional.rs",
            "src/scene/mod.rs",
        ],
    ),
];

/// The files of the core that name a sampler, beside its definition in `src/scene/sampler.rs`; a
/// point set of its own is a file of `shaders/core/` and its twin on top.
const HOME_OF_SAMPLERS: [&str; 3] = [
    "shaders/core/sampler.wesl",
    "src/effects/mod.rs",
    "src/reference/core/sampler.rs",
];

/// Source files in `folders` with their names, without comments, unit tests and re-exports.
fn sources(folders: &[&str]) -> Vec<(String, String)> {
    let files = folders.iter();
    let files = files.flat_map(|folder| source_files(&project(folder), &["rs", "wesl"]));
    let files = files.filter(|path| !path.ends_with("tests.rs"));
    let read = |path: PathBuf| {
        let text = std::fs::read_to_string(&path).unwrap();
        let name = path.strip_prefix(project("")).unwrap().to_str().unwrap();
        (name.to_owned(), without_reexports(&code(&text)))
    };
    files.map(read).collect()
}

fn without_reexports(code: &str) -> String {
    let mut parts = code.split("\npub use ");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |kept, part| {
        kept + part.split_once(';').map_or("", |(_, rest)| rest)
    })
}

/// Whether `code` holds `name` as a word.
fn names(code: &str, name: &str) -> bool {
    let part = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || c == '_');
    code.match_indices(name).any(|(at, _)| {
        !part(code[..at].chars().next_back()) && !part(code[at + name.len()..].chars().next())
    })
}

#[test]
fn a_light_is_named_in_eight_files() {
    let files = sources(&[
        "src",
        "shaders",
        "crates/cli/src",
        "crates/instruments/src",
        "crates/window/src",
    ]);
    assert!(files.len() > 300, "{} files", files.len());
    for (module, constant, _) in Light::CONSTANTS {
        let kind = module.strip_prefix("light::").unwrap();
        let data = format!("{}{}", kind[..1].to_uppercase(), &kind[1..]);
        let words = [
            format!("{data}Light"),
            format!("Light::{data}"),
            format!("Emitter::{data}"),
            format!("light::{kind}"),
            (*constant).to_owned(),
        ];
        let declares = |(name, code): &&(String, String)| {
            name == "src/reference/light/mod.rs" && names(code, &format!("mod {kind}"))
        };
        let knows = |file: &&(String, String)| words.iter().any(|word| names(&file.1, word));
        let found = files.iter().filter(|file| knows(file) || declares(file));
        let found: BTreeSet<String> = found.map(|(name, _)| name.clone()).collect();
        let guests = GUESTS
            .iter()
            .find(|(of, _)| *of == kind)
            .map_or(&[][..], |(_, files)| *files);
        let home = HOME
            .iter()
            .chain(guests)
            .map(|file| file.replace("KIND", kind));
        assert_eq!(
            found,
            home.collect::<BTreeSet<String>>(),
            "files that know the kind {kind}"
        );
    }
}

#[test]
fn a_sampler_is_named_in_three_files_beside_its_definition() {
    let files = sources(&["src", "shaders"]);
    for sampler in Sampler::value_variants() {
        let words = [
            format!("Sampler::{sampler:?}"),
            format!("{sampler:?}Sampler"),
            format!(
                "SAMPLER_{}",
                sampler.to_string().to_uppercase().replace('-', "_")
            ),
        ];
        let knows = |file: &&(String, String)| words.iter().any(|word| names(&file.1, word));
        let found: BTreeSet<&str> = files
            .iter()
            .filter(knows)
            .map(|(name, _)| name.as_str())
            .collect();
        // Independent numbers are what is left where no effect is called for.
        let expected = match sampler {
            Sampler::Independent => &HOME_OF_SAMPLERS[2..],
            _ => &HOME_OF_SAMPLERS,
        };
        assert_eq!(
            found,
            expected.iter().copied().collect(),
            "files that name the sampler {sampler}"
        );
    }
}
