//! `direkt lab`, as a user runs it.

use super::{run, text};
use serde_json::Value;

#[test]
fn all_experiments_agree_and_write_tables_plots_and_json() {
    let folder = tempfile::tempdir().unwrap();
    let json = folder.path().join("lab.json");
    let plots = folder.path().join("new/plots");
    let (code, stdout, stderr) = run(&["lab", "--json", text(&json), "-o", text(&plots)]);
    assert_eq!(code, 0, "{stdout}{stderr}");
    for word in [
        "importance:",
        "pi:",
        "sampling:",
        "quadrature:",
        "estimators:",
        "576(ln 3 − 1) = 56.80067827",
        "6.4 (wrong)",
        "verdict: all measured values agree with the exact ones",
    ] {
        assert!(stdout.contains(word), "{word}: {stdout}");
    }
    let report: Value = serde_json::from_slice(&std::fs::read(&json).unwrap()).unwrap();
    assert_eq!(report["agrees"], true);
    let experiments = report["experiments"].as_array().unwrap();
    assert_eq!(experiments.len(), 5);
    let mut drawn = 0;
    for experiment in experiments {
        assert!(!experiment["checks"].as_array().unwrap().is_empty());
        for plot in experiment["plots"].as_array().unwrap() {
            let name = format!("{}.svg", plot["file"].as_str().unwrap());
            let svg = std::fs::read_to_string(plots.join(&name)).unwrap();
            assert!(svg.starts_with("<svg") && svg.ends_with("</svg>\n"));
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{name}");
            drawn += 1;
        }
    }
    assert_eq!(std::fs::read_dir(&plots).unwrap().count(), drawn);
}

#[test]
fn json_on_stdout_is_all_that_is_there() {
    let (code, stdout, _) = run(&["lab", "--experiment", "pi", "--seed", "3", "--json", "-"]);
    assert_eq!(code, 0);
    let report: Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!(report["seed"], 3);
    assert_eq!(report["experiments"][0]["name"], "pi");
}

#[test]
fn a_mistake_is_exit_1() {
    let (code, stdout, _) = run(&["lab", "--experiment", "importance", "--break"]);
    assert_eq!(code, 1);
    for word in ["broken on purpose", "DIFFERS: mean by 1/4", "values DIFFER"] {
        assert!(stdout.contains(word), "{word}: {stdout}");
    }
}

#[test]
fn wrong_use_is_exit_2_and_says_what_would_be_right() {
    let file = tempfile::NamedTempFile::new().unwrap();
    let cases: [(&[&str], &str); 5] = [
        (&["--samples", "0"], "from 65536 to"),
        (&["--samples", "many"], "--samples"),
        (
            &["--experiment", "tau"],
            "importance, pi, sampling, quadrature, estimators",
        ),
        (&["-o", text(file.path())], "is a file; name a folder"),
        (
            &["--adapter", "no such adapter"],
            "no adapter's name contains",
        ),
    ];
    for (flags, message) in cases {
        let arguments: Vec<&str> = ["lab"].iter().chain(flags).copied().collect();
        let (code, stdout, stderr) = run(&arguments);
        assert_eq!((code, stdout.as_str()), (2, ""), "{flags:?}: {stderr}");
        assert!(stderr.contains(message), "{flags:?}: {stderr}");
    }
}
