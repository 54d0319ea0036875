//! Ctrl-C in `direkt cost`.

use super::{CORNELL, read, text};
use serde_json::Value;
use std::path::Path;

/// Runs `direkt cost` on `scenes`, with a `budget` for each, and sends Ctrl-C once `begun` has read
/// what it waits for. Exit code and stderr.
fn interrupted(
    folder: &Path,
    budget: &str,
    scenes: &[&str],
    begun: impl FnOnce(&mut dyn std::io::BufRead, &mut dyn std::io::BufRead),
) -> (i32, String) {
    use std::io::{BufReader, Read};
    use std::process::{Command, Stdio};
    let mut child = super::super::Child(
        Command::new(env!("CARGO_BIN_EXE_direkt"))
            .args(["cost", "--size", "24x16", "--budget", budget])
            .args(["--strategies", "light-area", "-o", text(folder)])
            .args(["--json", text(&folder.join("a.json"))])
            .args(scenes)
            .current_dir(crate::support::PROJECT)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap(),
    );
    let mut stdout = BufReader::new(child.0.stdout.take().unwrap());
    let mut stderr = BufReader::new(child.0.stderr.take().unwrap());
    begun(&mut stdout, &mut stderr);
    super::super::interrupt(&child);
    let mut told = String::new();
    stderr.read_to_string(&mut told).unwrap();
    (child.0.wait().unwrap().code().unwrap(), told)
}

/// Ctrl-C before there is enough for a result.
#[test]
fn an_interrupt_at_the_beginning_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    // Its reference alone takes minutes.
    let (code, stderr) = interrupted(folder.path(), "1h", &[CORNELL], |_, stderr| {
        let mut line = String::new();
        stderr.read_line(&mut line).unwrap();
        assert!(
            line.starts_with("measuring scenes/cornell.toml on "),
            "{line}"
        );
    });
    assert_eq!(code, 1, "{stderr}");
    assert!(stderr.contains("nothing was written"), "{stderr}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

/// Ctrl-C between two scenes: the first is in the report.
#[test]
fn an_interrupt_writes_the_report_so_far() {
    let folder = tempfile::tempdir().unwrap();
    let veach = "scenes/veach.toml";
    let (code, stderr) = interrupted(folder.path(), "3s", &[CORNELL, veach], |stdout, _| {
        let mut line = String::new();
        stdout.read_line(&mut line).unwrap();
        assert!(line.starts_with("scenes/cornell.toml: 24 × 16"), "{line}");
    });
    assert_eq!(code, 0, "{stderr}");
    assert!(stderr.contains("interrupted, the report shows"), "{stderr}");
    let facts: Value = serde_json::from_str(&read(&folder.path().join("a.json"))).unwrap();
    assert_eq!(facts["interrupted"], true);
    assert_eq!(facts["not_measured"], serde_json::json!([veach]));
    assert_eq!(facts["scenes"].as_array().unwrap().len(), 1);
    let cornell = &facts["scenes"][0];
    assert_eq!(cornell["interrupted"], false);
    let estimators = cornell["estimators"].as_array().unwrap();
    assert!(estimators.iter().all(|e| e["equal_time"].is_object()));
    let page = read(&folder.path().join("report.html"));
    assert!(page.contains("Interrupted before there was a result for scenes/veach.toml"));
}
