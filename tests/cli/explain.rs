//! `direkt explain`, as a user runs it.

use super::{run, text};
use serde_json::Value;

#[test]
fn explain_tells_effects_with_reasons() {
    let (code, stdout, stderr) = run(&["explain", "scenes/cornell.toml"]);
    assert_eq!(code, 0, "{stderr}");
    for part in ["rectangles", "area-lights", "left out:", "spheres"] {
        assert!(stdout.contains(part), "{part} is missing:\n{stdout}");
    }
    let (code, stdout, _) = run(&["explain", "scenes/cornell.toml", "--wgsl"]);
    assert_eq!(code, 0);
    assert!(naga::front::wgsl::parse_str(&stdout).is_ok());
}

#[test]
fn the_schema_is_json_and_knows_the_tables() {
    let (code, stdout, _) = run(&["explain", "--schema"]);
    assert_eq!(code, 0);
    let schema: Value = serde_json::from_str(&stdout).unwrap();
    for table in [
        "camera",
        "film",
        "materials",
        "shapes",
        "lights",
        "environment",
        "render",
        "expect",
    ] {
        assert!(schema["properties"][table].is_object(), "{table}");
    }
}

/// What the setting does on a scene under a strategy.
#[test]
fn what_the_environment_is_sampled_by_is_told() {
    let map = "scenes/tests/sun_and_sky.toml";
    let facts = |scene: &str, flags: &[&str]| -> Value {
        let (code, stdout, stderr) = run(&[&["explain", scene, "--json", "-"], flags].concat());
        assert_eq!(code, 0, "{stderr}");
        serde_json::from_str(&stdout).unwrap()
    };
    let default = facts(map, &[]);
    assert_eq!(default["environment"]["columns"], 32);
    assert_eq!(default["environment"]["compensated"], true);
    assert_eq!(default["mis_compensation_unused"], Value::Null);
    let without = facts(map, &["--mis-compensation=false"]);
    assert_eq!(without["environment"]["compensated"], false);
    assert_eq!(without["mis_compensation_unused"], Value::Null);
    let alone = facts(map, &["--strategy", "light-area"]);
    assert_eq!(alone["environment"]["compensated"], false);
    let constant = facts("scenes/tests/sky.toml", &["--mis-compensation"]);
    assert_eq!(constant["environment"], Value::Null);
    for (facts, reason) in [
        (alone, "does not combine light and BSDF sampling"),
        (constant, "no environment map"),
    ] {
        let told = facts["mis_compensation_unused"].as_str();
        assert!(told.is_some_and(|t| t.contains(reason)), "{told:?}");
    }
    let (_, stdout, _) = run(&["explain", map]);
    assert!(stdout.contains("32 × 16 cells, each by what of its luminance exceeds the mean"));
}

/// The size of the kernel, memory, rays and random numbers, for people and as JSON.
#[test]
fn what_a_sample_takes_is_told() {
    let (code, stdout, _) = run(&["explain", "scenes/depth_of_field.toml", "--json", "-"]);
    assert_eq!(code, 0);
    let facts: Value = serde_json::from_str(&stdout).unwrap();
    assert!(facts["wgsl_bytes"].as_u64() > Some(10_000));
    assert!(facts["spirv_instructions"].as_u64() > Some(1000));
    assert!(facts["functions"].as_u64() > Some(20));
    let rays = &facts["rays"];
    let of = |kind: &str| rays[kind].as_f64().unwrap();
    assert_eq!((of("camera"), of("shadow"), of("bsdf")), (1.0, 5.0, 1.0));
    let numbers = facts["random_numbers"].as_array().unwrap();
    let purposes: Vec<_> = numbers
        .iter()
        .map(|n| n["purpose"].as_str().unwrap())
        .collect();
    let expected = ["film", "lens", "light point", "lobe", "direction"];
    assert_eq!(purposes, expected);
    assert_eq!(facts["random_numbers_per_sample"], 17);
    let memory = facts["memory"].as_array().unwrap().iter();
    let sum: u64 = memory.map(|m| m["bytes"].as_u64().unwrap()).sum();
    assert_eq!(facts["memory_bytes"], sum);
    let (_, stdout, _) = run(&["explain", "scenes/depth_of_field.toml"]);
    for part in [
        "depth-of-field         camera.lens_radius = 0.16",
        "all-lights             light_selection = \"auto\", 5 lights",
        "random numbers per sample: 17 (film 0–1, lens 2–3, light point 64 and on × 5,",
        "rays per sample, at most: 7.00 (camera 1.00, shadow 5.00, BSDF 1.00)",
        "direct.pixels",
    ] {
        assert!(stdout.contains(part), "{part} is missing:\n{stdout}");
    }
}

#[test]
fn prices_are_measured_and_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let [svg, json] = ["a.svg", "a.json"].map(|n| folder.path().join(n));
    let base = [
        "explain",
        "scenes/tests/orthographic.toml",
        "--measure",
        "--budget",
        "1ms",
        "--effects",
        "spheres",
    ];
    let (code, stdout, stderr) =
        run(&[&base[..], &["-o", text(&svg), "--json", text(&json)]].concat());
    assert_eq!(code, 0, "{stderr}");
    assert!(stdout.contains("what is called for is"), "{stdout}");
    let svg = std::fs::read_to_string(svg).unwrap();
    assert!(svg.contains("+ spheres: compile time") && !svg.contains("NaN"));
    let facts: Value = serde_json::from_str(&std::fs::read_to_string(json).unwrap()).unwrap();
    let measured = &facts["measured"];
    assert_eq!(measured["rounds"], 3);
    let kernels = measured["kernels"].as_array().unwrap();
    assert_eq!(kernels[0]["kernel"], "called for");
    assert_eq!(kernels[1]["kernel"], "+ spheres");
    let size = |i: usize| kernels[i]["spirv_instructions"].as_u64();
    assert!(size(1) > size(0));
    for kernel in kernels {
        for ratio in ["compile_ratio", "sample_ratio"] {
            let of = |end: &str| kernel[ratio][end].as_f64().unwrap();
            assert!(0.0 < of("low") && of("low") <= of("value"), "{kernel}");
        }
    }
    assert_eq!(kernels[0]["sample_ratio"]["value"], 1.0);
    let (code, _, stderr) = run(&[
        "explain",
        "a.toml",
        "--measure",
        "--effects",
        "sobol-sampler",
    ]);
    assert_eq!(code, 2);
    assert!(stderr.contains("expected geometry, triangles"), "{stderr}");
    assert!(measured["rays_per_sample"]["shadow"].as_f64() < Some(1.01));
    for wrong in ["a.txt", "a.exr"] {
        let (code, _, stderr) = run(&[&base[..], &["-o", wrong]].concat());
        assert_eq!(code, 2, "{stderr}");
        assert!(stderr.contains(".svg or .png"), "{stderr}");
    }
}
