//! `docs/hard-cases.md`, from what was measured.

use super::{ENTRIES, HardCase};
use crate::support::project;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::PathBuf;

const INTRODUCTION: &str = "# Hard cases

What breaks renderers that compute in f32, and what direkt does there. Every line is a test of the
suite, which fails where direkt's figure is beyond the bound, and fails as well where the textbook's
way is not: then the test would prove nothing.

This page is written by the tests, with the figures of each driver that they were run on:

    DIREKT_HARD_CASES=1 ./lavapipe cargo test --release

";

fn folder() -> PathBuf {
    project("docs/hard-cases")
}

/// The page.
pub fn page() -> PathBuf {
    project("docs/hard-cases.md")
}

/// Writes what was measured on one driver and the page of all drivers.
pub fn write(measured: &[(String, HardCase)]) -> Result<(), String> {
    let Some((driver, _)) = measured.first() else {
        return Err("nothing was measured".to_owned());
    };
    let mut cases: Vec<&HardCase> = measured.iter().map(|(_, case)| case).collect();
    cases.sort_by_key(|c| (position(&c.entry), c.case.clone(), c.figure.clone()));
    let missing = missing(cases.iter().copied());
    if !missing.is_empty() {
        return Err(format!(
            "nothing of {}: a test failed or was left out",
            missing.join(", ")
        ));
    }
    let text = serde_json::to_string_pretty(&cases).map_err(|e| e.to_string())?;
    let path = folder().join(format!("{}.json", file_name(driver)));
    let io = |e: std::io::Error| e.to_string();
    std::fs::create_dir_all(folder()).map_err(io)?;
    let named = format!("{{\n\"driver\": {driver:?},\n\"cases\": {text}\n}}\n");
    std::fs::write(path, named).map_err(io)?;
    std::fs::write(page(), text_of(&results())).map_err(io)
}

/// A name for a file: letters, digits, dots, and dashes for everything else.
fn file_name(driver: &str) -> String {
    let keep = |c: char| c.is_ascii_alphanumeric() || c == '.';
    let parts = driver.split(|c| !keep(c)).filter(|p| !p.is_empty());
    parts.collect::<Vec<_>>().join("-").to_lowercase()
}

fn position(entry: &str) -> usize {
    let found = ENTRIES.iter().position(|(id, _)| *id == entry);
    found.unwrap_or(ENTRIES.len())
}

/// Entries of which there is no case.
pub fn missing<'a>(cases: impl Iterator<Item = &'a HardCase> + Clone) -> Vec<&'static str> {
    let ids = ENTRIES.iter().map(|(id, _)| *id);
    ids.filter(|id| !cases.clone().any(|c| c.entry == *id))
        .collect()
}

/// What was measured on one driver.
#[derive(Debug, serde::Deserialize)]
pub struct Results {
    /// The driver.
    pub driver: String,
    /// The cases.
    pub cases: Vec<HardCase>,
}

/// What the project's files hold, by driver.
pub fn results() -> Vec<Results> {
    let mut all: Vec<Results> = std::fs::read_dir(folder())
        .unwrap()
        .map(|entry| std::fs::read_to_string(entry.unwrap().path()).unwrap())
        .map(|text| serde_json::from_str(&text).unwrap())
        .collect();
    all.sort_by(|a, b| a.driver.cmp(&b.driver));
    all
}

/// The page of `results`.
pub fn text_of(results: &[Results]) -> String {
    let mut out = INTRODUCTION.to_owned();
    for (i, Results { driver, .. }) in results.iter().enumerate() {
        let _ = writeln!(out, "- driver {}: {driver}", i + 1);
    }
    for (id, title) in ENTRIES {
        let mut lines: BTreeMap<(&str, &str, &str), Vec<Option<&HardCase>>> = BTreeMap::new();
        for (i, Results { cases, .. }) in results.iter().enumerate() {
            for case in cases.iter().filter(|c| c.entry == id) {
                let key = (&*case.case, &*case.figure, &*case.textbook);
                let line = lines
                    .entry(key)
                    .or_insert_with(|| vec![None; results.len()]);
                line[i] = Some(case);
            }
        }
        let _ = write!(
            out,
            "\n## {id}. {title}\n\n| case | figure | at most | textbook's way |"
        );
        for i in 1..=results.len() {
            let _ = write!(out, " its figure, driver {i} | direkt's, driver {i} |");
        }
        let _ = writeln!(out, "\n|{}", "---|".repeat(4 + 2 * results.len()));
        for ((case, figure, textbook), found) in lines {
            let bound = found.iter().flatten().next().map(|c| c.bound);
            let bound = number(bound.unwrap_or(f64::NAN));
            let _ = write!(out, "| {case} | {figure} | {bound} | {textbook} |");
            for case in found {
                let naive = case.map_or_else(
                    || "—".to_owned(),
                    |c| c.naive.map_or_else(|| "not finite".to_owned(), number),
                );
                let ours = case.map_or_else(|| "—".to_owned(), |c| number(c.ours));
                let _ = write!(out, " {naive} | {ours} |");
            }
            out.push('\n');
        }
    }
    out
}

/// Three digits.
fn number(x: f64) -> String {
    if x == 0.0 || (x.fract() == 0.0 && x.abs() < 1e6) {
        format!("{x}")
    } else if (1e-3..1e4).contains(&x.abs()) {
        let digits = (2 - x.abs().log10().floor() as i32).max(0) as usize;
        format!("{x:.digits$}")
    } else {
        format!("{x:.2e}")
    }
}
