//! `direkt explain`, as a user runs it.

use super::run;
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
