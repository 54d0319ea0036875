//! `direkt cost`, as a user runs it.

mod effects;
#[cfg(unix)]
mod interrupt;

use super::{cornell_with, run, text};
use serde_json::Value;
use std::path::Path;

const CORNELL: &str = "scenes/cornell.toml";

/// A small run: two estimators, a folder for the report and further flags.
fn cost(folder: &Path, flags: &[&str]) -> (i32, String, String) {
    let mut arguments = vec![
        "cost",
        "--size",
        "24x16",
        "--budget",
        "2s",
        "--strategies",
        "light-area",
        "-o",
        text(folder),
    ];
    arguments.extend(flags);
    run(&arguments)
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap()
}

#[test]
fn the_report_is_complete_and_needs_no_network() {
    let folder = tempfile::tempdir().unwrap();
    let report = folder.path().join("new/report");
    let [json, csv] = ["a.json", "a.csv"].map(|n| folder.path().join(n));
    let flags = [CORNELL, "--json", text(&json), "--csv", text(&csv)];
    let (code, stdout, stderr) = cost(&report, &flags);
    assert_eq!(code, 0, "{stdout}{stderr}");
    assert!(stdout.contains("light-area · sobol"), "{stdout}");

    for plot in ["error-time", "error-samples", "efficiency"] {
        let svg = read(&report.join(format!("cornell-{plot}.svg")));
        assert!(svg.starts_with("<svg ") && !svg.contains("NaN"), "{plot}");
        let png = image::open(report.join(format!("cornell-{plot}.png"))).unwrap();
        assert!(png.width() > 1500 && png.height() > 200, "{plot}");
    }
    let page = read(&report.join("report.html"));
    for foreign in ["http://", "https://", "<script", "<link", "url(", "@import"] {
        assert!(!page.contains(foreign), "{foreign}");
    }
    let sources = page.split("src=\"").skip(1);
    assert!(
        sources
            .clone()
            .all(|s| s.starts_with("data:image/png;base64,"))
    );
    // Two estimators, each an image and a heat map, and the reference.
    assert_eq!(sources.count(), 5);
    assert_eq!(page.matches("<svg ").count(), 3);
    assert!(page.contains("prefers-color-scheme:dark") && page.contains("primitives"));

    let facts: Value = serde_json::from_str(&read(&json)).unwrap();
    check_facts(&facts);
    check_table(&read(&csv), &facts["scenes"][0]);
}

fn check_facts(facts: &Value) {
    assert!(facts["machine"]["adapter"]["driver"].is_string());
    let scene = &facts["scenes"][0];
    assert_eq!(
        (&scene["width"], &scene["height"]),
        (&24.into(), &16.into())
    );
    assert_eq!(scene["reference"]["kind"], "own-run");
    assert_eq!(scene["reference"]["estimator"]["strategy"], "mis-power");
    assert!(scene["reference"]["rel_mse"]["value"].as_f64().unwrap() > 0.0);
    let estimators = scene["estimators"].as_array().unwrap();
    let samplers: Vec<_> = estimators.iter().map(|e| &e["sampler"]).collect();
    assert_eq!(samplers, ["independent", "sobol"]);
    for e in estimators {
        assert!(e["compile_seconds"].as_f64().unwrap() > 0.0);
        let per_sample = e["seconds_per_sample"]["value"].as_f64().unwrap();
        let rate = e["samples_per_second"].as_f64().unwrap();
        assert!((per_sample * rate - 1.0).abs() < 1e-9);
        let points = e["points"].as_array().unwrap();
        assert!(points.len() >= 3);
        for (i, point) in points.iter().enumerate() {
            assert_eq!(point["samples"], 1 << i);
            assert!(point["replicates"].as_u64().unwrap() >= 2);
            for key in ["mse", "rel_mse", "efficiency", "seconds"] {
                let of = |end: &str| point[key][end].as_f64();
                // Infinite values are `null`; less than nothing is left of some that the reference
                // is subtracted from.
                let value = of("value").map_or(f64::INFINITY, |v| v.max(0.0));
                assert!(of("low").unwrap() <= value, "{key} {point}");
            }
        }
        let last = points.last().unwrap();
        assert_eq!(e["efficiency"], last["efficiency"]);
        let [error, seconds] = ["rel_mse", "seconds"].map(|k| last[k]["value"].as_f64().unwrap());
        if let Some(efficiency) = last["efficiency"]["value"].as_f64() {
            assert!((efficiency * error * seconds - 1.0).abs() < 1e-9);
        }
        assert!(e["rank"].as_u64().unwrap() >= 1 && e["ties"].is_array());
        assert!(e["equal_time"]["rays"]["camera"].as_u64().unwrap() > 0);
    }
}

fn check_table(csv: &str, scene: &Value) {
    let mut lines = csv.lines();
    let header = lines.next().unwrap();
    let common = "scene,sampler,strategy,spp,seconds,relmse,efficiency,";
    assert!(header.starts_with(common), "{header}");
    let columns = header.split(',').count();
    let points = scene["estimators"].as_array().unwrap().iter();
    let points: usize = points.map(|e| e["points"].as_array().unwrap().len()).sum();
    let lines: Vec<_> = lines.collect();
    assert_eq!(lines.len(), points);
    assert!(lines[0].starts_with("cornell.toml,independent,light-area,1,"));
    assert!(lines.iter().all(|l| l.split(',').count() == columns));
}

/// Numbers of shadow rays, patterns and `all` are compared; names tell what differs, and what is
/// biased; what comes to the same is measured once.
#[test]
fn shadow_rays_and_their_patterns_are_compared() {
    let folder = tempfile::tempdir().unwrap();
    let [json, csv] = ["a.json", "a.csv"].map(|n| folder.path().join(n));
    let uniform = cornell_with("adaptive = false", folder.path());
    let arguments = [
        "cost",
        text(&uniform),
        "--size",
        "24x16",
        "--strategies",
        "light-area",
        "--samplers",
        "sobol",
        "--light-selections",
        "power,all",
        "--shadow-rays",
        "1,4",
        "--shadow-patterns",
        "random,grid",
        "--budget",
        "3s",
        "-o",
        text(folder.path()),
        "--json",
        text(&json),
        "--csv",
        text(&csv),
    ];
    let (code, stdout, stderr) = run(&arguments);
    assert_eq!(code, 0, "{stdout}{stderr}");
    let facts: Value = serde_json::from_str(&read(&json)).unwrap();
    let scene = &facts["scenes"][0];
    let estimators = scene["estimators"].as_array().unwrap();
    let names: Vec<_> = estimators.iter().map(|e| e["name"].as_str()).collect();
    let expected = [
        "light-area · sobol · 1 ray · random",
        "light-area · sobol · 1 ray · grid (biased)",
        "light-area · sobol · 4 rays · random",
        "light-area · sobol · 4 rays · grid (biased)",
    ];
    assert_eq!(names, expected.map(Some));
    for estimator in estimators {
        let biased = estimator["shadow_pattern"] == "grid";
        assert_eq!(estimator["biased"].is_string(), biased, "{estimator}");
        // As many shadow rays as the estimator has, but for those that find nothing.
        let rays = &estimator["equal_time"]["rays"];
        let [camera, shadow] = ["camera", "shadow"].map(|k| rays[k].as_f64().unwrap());
        let per_sample = shadow / camera / estimator["shadow_rays"].as_f64().unwrap();
        assert!((0.3..1.0).contains(&per_sample), "{estimator}");
    }
    // The box has one light.
    let same = scene["not_applicable"].as_array().unwrap();
    assert_eq!(same.len(), 4);
    for not in same {
        assert_eq!(not["light_selection"], "all");
        let reason = not["reason"].as_str().unwrap();
        assert!(
            reason.starts_with("on this scene the same as light-area"),
            "{reason}"
        );
    }
    let page = read(&folder.path().join("report.html"));
    assert!(page.contains("4 rays · grid (biased)"));
    assert!(read(&csv).contains(",power,4,grid,"));
}

#[test]
fn a_reference_of_the_same_size_is_used() {
    let folder = tempfile::tempdir().unwrap();
    let [exr, json] = ["reference.exr", "a.json"].map(|n| folder.path().join(n));
    let render = [
        "render",
        CORNELL,
        "--size",
        "24x16",
        "--spp",
        "512",
        "--sampler",
        "sobol",
        "--seed",
        "9",
        "-o",
        text(&exr),
    ];
    assert_eq!(run(&render).0, 0);
    let flags = [CORNELL, "--reference", text(&exr), "--json", text(&json)];
    let (code, stdout, stderr) = cost(folder.path(), &flags);
    assert_eq!(code, 0, "{stdout}{stderr}");
    let facts: Value = serde_json::from_str(&read(&json)).unwrap();
    let reference = &facts["scenes"][0]["reference"];
    assert_eq!(reference["kind"], "file");
    assert_eq!(reference["rel_mse"], Value::Null);

    let flags = [CORNELL, "--reference", text(&exr), "--size", "8x8"];
    let arguments = ["cost", "-o", text(folder.path())];
    let (code, _, stderr) = run(&[arguments.as_slice(), &flags].concat());
    assert_eq!(code, 2, "{stderr}");
    assert!(
        stderr.contains("it has 24 × 16 pixels") && stderr.contains("8 × 8"),
        "{stderr}"
    );
}

/// Only a light without a surface: no sampled direction meets it.
const POINT_LIGHT: &str = r#"
[camera]
eye = [0, 1, 3]
target = [0, 0, 0]
fov = 40
[film]
width = 16
height = 16
[materials.m]
type = "lambert"
reflectance = 0.5
[[shapes]]
type = "sphere"
name = "ball"
material = "m"
center = [0, 0, 0]
radius = 1
[[lights]]
type = "point"
position = [2, 2, 2]
intensity = 5
"#;

#[test]
fn what_a_scene_cannot_use_is_listed_and_names_are_escaped() {
    let folder = tempfile::tempdir().unwrap();
    let [scene, json] = ["<b>&point.toml", "a.json"].map(|n| folder.path().join(n));
    std::fs::write(&scene, POINT_LIGHT).unwrap();
    let report = folder.path().join("report");
    let arguments = [
        "cost",
        text(&scene),
        "--budget",
        "2s",
        "--strategies",
        "bsdf,light-area",
        "--samplers",
        "independent",
        "-o",
        text(&report),
        "--json",
        text(&json),
    ];
    let (code, stdout, stderr) = run(&arguments);
    assert_eq!(code, 0, "{stdout}{stderr}");
    let facts: Value = serde_json::from_str(&read(&json)).unwrap();
    let scene_facts = &facts["scenes"][0];
    assert_eq!(scene_facts["estimators"].as_array().unwrap().len(), 1);
    let not = &scene_facts["not_applicable"][0];
    assert_eq!(not["strategy"], "bsdf");
    assert!(
        not["reason"]
            .as_str()
            .unwrap()
            .contains("no sampled direction meets")
    );

    let page = read(&report.join("report.html"));
    assert!(page.contains("&lt;b&gt;&amp;point.toml") && !page.contains("<b>&point"));
    assert!(page.contains("Not applicable"));

    let arguments = [
        "cost",
        text(&scene),
        "--strategies",
        "bsdf",
        "-o",
        text(&report),
    ];
    let (code, _, stderr) = run(&arguments);
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("no estimator is applicable"), "{stderr}");
}

#[test]
fn wrong_use_is_exit_2_and_says_what_would_be_right() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, "x").unwrap();
    let too_short = [CORNELL, "--budget", "1ms", "--strategies", "light-area"];
    let cases: [(&[&str], &str); 8] = [
        (&too_short, "needs at least about"),
        (&[CORNELL, "--budget", "soon"], "expected such as 30s"),
        (&[CORNELL, "--target-error", "0"], "a positive number"),
        (&[CORNELL, "--strategies", "wrong"], "possible values"),
        (&[CORNELL, "--reference", "missing.exr"], "missing.exr"),
        (
            &[CORNELL, "--reference", text(&file)],
            "an EXR image with channels",
        ),
        (&[CORNELL, CORNELL, "--reference", "a.exr"], "for one scene"),
        (&["scenes/missing.toml"], "scenes/missing.toml"),
    ];
    for (flags, message) in cases {
        let mut arguments = vec!["cost", "--size", "8x8", "-o", text(folder.path())];
        arguments.extend(flags);
        let (code, stdout, stderr) = run(&arguments);
        assert_eq!((code, stdout.as_str()), (2, ""), "{flags:?}: {stderr}");
        assert!(stderr.contains(message), "{flags:?}: {stderr}");
    }
    let (code, _, stderr) = run(&["cost", CORNELL, "-o", text(&file)]);
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("is a file; name a folder"), "{stderr}");
}
