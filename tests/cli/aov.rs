//! `--aov`: channels of an EXR, read back, and what is refused.

use super::{run, text};
use exr::prelude::{AttributeValue, FlatImage, read_all_flat_layers_from_file};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

fn read(path: &Path) -> FlatImage {
    read_all_flat_layers_from_file(path).unwrap()
}

/// The channels by name.
fn channels(image: &FlatImage) -> BTreeMap<String, Vec<f32>> {
    let channels = &image.layer_data[0].channel_data.list;
    let values = |c: &exr::prelude::AnyChannel<exr::prelude::FlatSamples>| {
        (c.name.to_string(), c.sample_data.values_as_f32().collect())
    };
    channels.iter().map(values).collect()
}

fn attribute(image: &FlatImage, name: &str) -> Option<String> {
    let attributes = &image.layer_data[0].attributes.other;
    let found = attributes.iter().find(|(key, _)| **key == *name);
    found.map(|(_, value)| match value {
        AttributeValue::Text(text) => text.to_string(),
        other => panic!("{name} is {other:?}"),
    })
}

fn render(scene: &str, aovs: &[&str]) -> FlatImage {
    let folder = tempfile::tempdir().unwrap();
    let exr = folder.path().join("a.exr");
    let mut arguments = vec![
        "render",
        scene,
        "-o",
        text(&exr),
        "--spp",
        "6",
        "--size",
        "24x16",
    ];
    arguments.extend(aovs);
    let (code, _, stderr) = run(&arguments);
    assert_eq!(code, 0, "{stderr}");
    read(&exr)
}

const ALWAYS: [&str; 7] = [
    "B",
    "G",
    "R",
    "samples.X",
    "standard_error.B",
    "standard_error.G",
    "standard_error.R",
];

#[test]
fn an_image_has_the_channels_that_are_asked_for_and_no_others() {
    let scene = "scenes/spot_and_sun.toml";
    let names = |aovs: &[&str]| -> Vec<String> {
        let image = render(scene, aovs);
        let names = channels(&image).into_keys();
        names
            .filter(|name| !ALWAYS.contains(&name.as_str()))
            .collect()
    };
    assert_eq!(names(&[]), [""; 0]);
    assert_eq!(names(&["--aov", "sample-count"]), [""; 0]);
    assert_eq!(
        names(&["--aov", "depth,albedo"]),
        ["albedo.B", "albedo.G", "albedo.R", "depth.Z"]
    );
    let all = names(&["--aov", "all"]);
    let layers: Vec<String> = all
        .iter()
        .map(|n| n.rsplit_once('.').unwrap().0.to_owned())
        .collect();
    let mut layers: Vec<&str> = layers.iter().map(String::as_str).collect();
    layers.dedup();
    assert_eq!(
        layers,
        [
            "Combined_lamps",
            "Combined_sky",
            "Combined_sun",
            "N",
            "P",
            "albedo",
            "depth",
            "material_id",
            "normal",
            "object_id"
        ]
    );
}

#[test]
fn channels_hold_what_they_say() {
    let image = render("scenes/spot_and_sun.toml", &["--aov", "all"]);
    let plain = channels(&render("scenes/spot_and_sun.toml", &[]));
    let channels = channels(&image);
    for (name, values) in &plain {
        assert_eq!(values, &channels[name], "{name} does not depend on AOVs");
    }
    for (name, values) in &channels {
        assert!(values.iter().all(|v| v.is_finite()), "{name}");
    }
    let objects: Value = serde_json::from_str(&attribute(&image, "object_ids").unwrap()).unwrap();
    let materials: Value =
        serde_json::from_str(&attribute(&image, "material_ids").unwrap()).unwrap();
    assert_eq!(objects["1"], "shapes[0]: ground");
    for pixel in 0..24 * 16 {
        let object = channels["object_id.X"][pixel];
        let beyond = object == 0.0;
        assert_eq!(beyond, channels["depth.Z"][pixel] == 1e10);
        assert_eq!(beyond, channels["material_id.X"][pixel] == 0.0);
        if !beyond {
            let name = objects[format!("{object}")].as_str().unwrap();
            let material = materials[format!("{}", channels["material_id.X"][pixel])].as_str();
            let expected = match name.split(": ").nth(1).unwrap() {
                "ground" => "ground",
                "brass ball" | "reflector" => "brass",
                "plastic ball" => "plastic",
                _ => "clay",
            };
            assert_eq!(material, Some(expected), "{name}");
        }
        for c in ["R", "G", "B"] {
            let groups =
                ["lamps", "sky", "sun"].map(|g| channels[&format!("Combined_{g}.{c}")][pixel]);
            let (sum, all) = (groups.iter().sum::<f32>(), channels[c][pixel]);
            assert!((sum - all).abs() <= 4e-6 * all, "{sum} {all}");
            assert!((0.0..=1.0).contains(&channels[&format!("albedo.{c}")][pixel]));
        }
    }
    assert_eq!(attribute(&image, "aov_samples").as_deref(), Some("6"));
    assert_eq!(
        attribute(&image, "light_groups").as_deref(),
        Some("sun lamps sky")
    );
}

#[test]
fn aovs_without_an_exr_are_refused_or_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let png = folder.path().join("a.png");
    let scene = "scenes/tests/light_groups.toml";
    let common = [
        "render",
        scene,
        "-o",
        text(&png),
        "--spp",
        "2",
        "--size",
        "8x8",
    ];
    let (code, _, stderr) = run(&[&common[..], &["--aov", "depth"]].concat());
    assert_eq!(code, 2);
    assert!(
        stderr.contains("only an EXR holds AOVs; add an output such as -o out.exr"),
        "{stderr}"
    );
    assert!(!png.exists());
    let (code, _, stderr) = run(&common);
    assert_eq!(code, 0, "{stderr}");
    assert!(
        stderr.contains("render.aovs: only an EXR holds AOVs, and no output is one"),
        "{stderr}"
    );
}

#[test]
fn unknown_aovs_are_refused_with_the_known_ones() {
    let (code, _, stderr) = run(&[
        "render",
        "scenes/cornell.toml",
        "-o",
        "a.exr",
        "--aov",
        "albdo",
    ]);
    assert_eq!(code, 2);
    assert!(
        stderr.contains("albedo, shading-normal, geometric-normal, depth, position"),
        "{stderr}"
    );
}

#[test]
fn explain_tells_what_aovs_take() {
    let (code, stdout, stderr) = run(&[
        "explain",
        "scenes/spot_and_sun.toml",
        "--aov",
        "albedo,light-groups",
    ]);
    assert_eq!(code, 0, "{stderr}");
    assert!(
        stdout.contains("light-groups           AOV light-groups: sun, lamps, sky"),
        "{stdout}"
    );
    assert!(stdout.contains("AOV albedo"), "{stdout}");
    assert!(stdout.contains("direct.light_groups"), "{stdout}");
    let (_, stdout, _) = run(&["explain", "scenes/spot_and_sun.toml"]);
    assert!(
        !stdout.contains("AOV") && !stdout.contains("direct.light_groups"),
        "{stdout}"
    );
}
