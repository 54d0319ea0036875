//! `direkt compare`, as a user runs it.

use super::{run, text};
use crate::support::exr_file::radiance;
use serde_json::Value;

const CORNELL: &str = "scenes/cornell.toml";

#[test]
fn agreement_is_exit_0_with_a_verdict_images_and_json() {
    let folder = tempfile::tempdir().unwrap();
    let [json, difference, z_scores] =
        ["a.json", "difference.exr", "z.png"].map(|n| folder.path().join(n));
    let (code, stdout, stderr) = run(&[
        "compare",
        CORNELL,
        "--size",
        "40x24",
        "--exact",
        "--json",
        text(&json),
        "--difference",
        text(&difference),
        "--z-scores",
        text(&z_scores),
    ]);
    assert_eq!(code, 0, "{stdout}{stderr}");
    let last = stdout.lines().last().unwrap();
    assert_eq!(last, "verdict      GPU and reference agree");

    let report: Value = serde_json::from_slice(&std::fs::read(&json).unwrap()).unwrap();
    assert_eq!(report["agrees"], true);
    assert_eq!(report["broken"], Value::Null);
    assert_eq!(report["per_sample"]["samples"], 40 * 24 * 64);
    assert_eq!(report["per_sample"]["not_finite"], 0);
    assert_eq!(report["per_pixel"]["tests"], 40 * 24 * 3);
    assert_eq!(report["per_pixel"]["rejected"], 0);
    assert_eq!(
        report["whole_image"]["channels"].as_array().unwrap().len(),
        3
    );
    assert!(report["exact"]["samples"].as_u64().unwrap() > 0);
    assert!(report["adapter"]["name"].is_string());

    assert_eq!(
        image::open(&z_scores).unwrap().into_rgb8().dimensions(),
        (40, 24)
    );
    let (size, difference) = radiance(&difference);
    assert_eq!(size, [40, 24]);
    let values = || difference.iter().copied().flatten();
    assert!(
        values().any(|x| x > 0.0) && values().any(|x| x < 0.0),
        "signed"
    );
}

#[test]
fn every_mistake_is_exit_1() {
    for name in [
        "pdf-scaled",
        "wrong-measure",
        "swapped-sin-cos",
        "light-left-out",
        "mis-weights",
        "extra-cosine",
    ] {
        let (code, stdout, stderr) = run(&["compare", CORNELL, "--size", "32x32", "--break", name]);
        assert_eq!(code, 1, "{name}: {stdout}{stderr}");
        assert!(
            stdout.contains("broken on purpose") && stdout.contains("DIFFER"),
            "{stdout}"
        );
    }
}

#[test]
fn a_mistake_about_several_rays_is_exit_1() {
    let flags = ["--shadow-rays", "4", "--break", "rays-forgotten"];
    let arguments = [&["compare", CORNELL, "--size", "32x32"], flags.as_slice()].concat();
    let (code, stdout, stderr) = run(&arguments);
    assert_eq!(code, 1, "{stdout}{stderr}");
    assert!(
        stdout.contains("4 random shadow rays") && stdout.contains("DIFFER"),
        "{stdout}"
    );
}

#[test]
fn json_on_stdout_is_all_that_is_there() {
    let (code, stdout, _) = run(&["compare", CORNELL, "--size", "16x16", "--json", "-"]);
    assert_eq!(code, 0);
    let report: Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!(report["strategy"], "mis-power");
}

#[test]
fn wrong_use_is_exit_2_and_says_what_would_be_right() {
    let cases: [(&[&str], &str); 8] = [
        (
            &["--exact", "--shadow-pattern", "center"],
            "--exact: shadow_pattern = \"center\"",
        ),
        (&["--break", "rays-forgotten"], "never gets there"),
        (&["--spp", "8"], "--spp 8: with fewer than"),
        (
            &["--strategy", "bsdf", "--break", "mis-weights"],
            "never gets there",
        ),
        (&["--break", "nothing"], "possible values"),
        (&["--difference", "out.jpg"], "ends in .exr or .png"),
        (&["--z-scores", "missing/z.png"], "there is no folder"),
        (&["--size", "0x4"], "expected WIDTHxHEIGHT"),
    ];
    for (flags, message) in cases {
        let arguments: Vec<&str> = ["compare", CORNELL].iter().chain(flags).copied().collect();
        let (code, stdout, stderr) = run(&arguments);
        assert_eq!((code, stdout.as_str()), (2, ""), "{flags:?}: {stderr}");
        assert!(stderr.contains(message), "{flags:?}: {stderr}");
    }
    let (code, _, stderr) = run(&["compare", "scenes/veach.toml", "--exact"]);
    assert_eq!(code, 2);
    assert!(
        stderr.contains("scenes/veach.toml") && stderr.contains("is curved"),
        "{stderr}"
    );
    let (code, _, stderr) = run(&["compare", "scenes/missing.toml"]);
    assert_eq!(code, 2, "{stderr}");
}
