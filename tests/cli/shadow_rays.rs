//! What the commands say of shadow rays.

use super::{run, text};
use serde_json::Value;

/// A biased render says so in a line, in JSON and in the image; one that is not says nothing.
#[test]
fn bias_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let [exr, json] = ["a.exr", "a.json"].map(|n| folder.path().join(n));
    for (pattern, biased) in [("grid", true), ("stratified", false)] {
        let (code, _, stderr) = run(&[
            "render",
            "scenes/cornell.toml",
            "-o",
            text(&exr),
            "--spp",
            "2",
            "--size",
            "8x8",
            "--shadow-rays",
            "4",
            "--shadow-pattern",
            pattern,
            "--light-selection",
            "all",
            "--json",
            text(&json),
        ]);
        assert_eq!(code, 0, "{stderr}");
        let warnings = stderr.lines().filter(|l| l.contains("warning"));
        let warnings: Vec<_> = warnings.collect();
        assert_eq!(warnings.len(), usize::from(biased), "{stderr}");
        assert!(
            warnings
                .iter()
                .all(|w| w.contains("shadow_pattern = \"grid\""))
        );
        let report: Value = serde_json::from_slice(&std::fs::read(&json).unwrap()).unwrap();
        assert_eq!(report["shadow_rays"], 4);
        assert_eq!(report["shadow_pattern"], pattern);
        assert_eq!(report["light_selection"], "all");
        assert_eq!(report["biased"].is_string(), biased);
        let image = exr::prelude::read_all_flat_layers_from_file(&exr).unwrap();
        let other = &image.layer_data[0].attributes.other;
        let biased_attribute = other.get(&exr::prelude::Text::from("biased"));
        assert_eq!(biased_attribute.is_some(), biased);
    }
}

#[test]
fn explain_takes_flags_and_names_what_they_call_for() {
    let flags = [
        "--light-selection",
        "all",
        "--shadow-rays",
        "4",
        "--shadow-pattern",
        "grid",
    ];
    let arguments = [&["explain", "scenes/veach.toml"], flags.as_slice()].concat();
    let (code, stdout, stderr) = run(&arguments);
    assert_eq!(code, 0, "{stderr}");
    for part in [
        "all-lights             light_selection = \"all\", 5 lights",
        "shadow-rays            shadow_rays = 4",
        "grid-pattern           shadow_pattern = \"grid\"",
        "warning: shadow_pattern",
    ] {
        assert!(stdout.contains(part), "{part} is missing:\n{stdout}");
    }
}
