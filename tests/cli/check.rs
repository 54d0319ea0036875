//! `direkt render --check`.

use super::{run, text};
use crate::support::project;
use serde_json::Value;
use std::path::Path;

/// `point_above.toml`, which is deterministic, with `change` made to its text.
fn changed_point(folder: &Path, change: (&str, &str)) -> std::path::PathBuf {
    let original = project("scenes/tests/point_above.toml");
    let text = std::fs::read_to_string(original).unwrap();
    assert!(text.contains(change.0));
    let path = folder.join("changed.toml");
    std::fs::write(&path, text.replace(change.0, change.1)).unwrap();
    path
}

#[test]
fn check_passes_without_an_output_and_tells_the_facts() {
    let scene = "scenes/tests/square_parallel.toml";
    let (code, stdout, stderr) = run(&["render", scene, "--check"]);
    assert_eq!(code, 0, "{stdout}{stderr}");
    assert!(stdout.starts_with("check passed: 3 values"), "{stdout}");
    assert!(stdout.contains("polygon formula"), "{stdout}");
    let (code, stdout, _) = run(&["render", scene, "--check", "--json", "-"]);
    assert_eq!(code, 0);
    let report: Value = serde_json::from_str(&stdout).unwrap();
    let check = &report["check"];
    assert_eq!(check["passed"], true);
    assert!(check["worst_sigma"].as_f64().unwrap() < 4.5);
    assert_eq!(check["failures"], serde_json::json!([]));
}

#[test]
fn check_of_a_wrong_value_ends_with_1_and_says_what_was_found() {
    let folder = tempfile::tempdir().unwrap();
    let wrong = changed_point(folder.path(), ("radiance = 3.97", "radiance = 3.96"));
    let png = folder.path().join("a.png");
    let (code, stdout, stderr) = run(&["render", text(&wrong), "--check", "-o", text(&png)]);
    assert_eq!(code, 1, "{stdout}{stderr}");
    assert!(png.exists(), "the image is written all the same");
    for part in [
        "green: found 3.978",
        "expected 3.968",
        "bound",
        "check FAILED",
    ] {
        assert!(stdout.contains(part), "{part}: {stdout}");
    }
    let (code, stdout, _) = run(&["render", text(&wrong), "--check", "--json", "-"]);
    assert_eq!(code, 1);
    let report: Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!(report["check"]["passed"], false);
    assert_eq!(report["check"]["failures"].as_array().unwrap().len(), 3);
}

#[test]
fn checks_that_cannot_be_made_end_with_2() {
    let folder = tempfile::tempdir().unwrap();
    let few = changed_point(folder.path(), ("spp = 64", "spp = 63"));
    let cases: [(&[&str], &str); 5] = [
        (&["scenes/cornell.toml", "--check"], "[expect]"),
        (&[text(&few), "--check"], "at least 64"),
        (
            &["scenes/tests/sky.toml", "--check", "--spp", "8"],
            "at least 64",
        ),
        (
            &["scenes/tests/sky.toml", "--check", "--size", "4x4"],
            "--size",
        ),
        (&["scenes/tests/sky.toml"], "--output"),
    ];
    for (arguments, named) in cases {
        let mut all = vec!["render"];
        all.extend(arguments);
        let (code, stdout, stderr) = run(&all);
        assert_eq!((code, stdout.as_str()), (2, ""), "{arguments:?}: {stderr}");
        assert!(stderr.contains(named), "{arguments:?}: {stderr}");
    }
}
