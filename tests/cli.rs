//! The commands, as a user runs them.

mod adaptive;
mod aov;
mod check;
mod compare;
mod cost;
mod explain;
mod lab;
mod layers;
mod live;
mod outputs;
#[cfg(unix)]
mod rough;
mod shadow_rays;

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The command in the project's folder, with the vectors that its users have: `./lavapipe` makes
/// those of tests narrower.
fn direkt() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_direkt"));
    command.current_dir(crate::support::PROJECT);
    command.env_remove("GALLIUM_OVERRIDE_CPU_CAPS");
    command
}

/// Runs and returns (exit code, stdout, stderr).
fn run(arguments: &[&str]) -> (i32, String, String) {
    let output = direkt().args(arguments).output().unwrap();
    (
        output.status.code().unwrap(),
        String::from_utf8(output.stdout).unwrap(),
        String::from_utf8(output.stderr).unwrap(),
    )
}

/// A copy of the Cornell box in `folder`, with `setting` in its `[render]`.
fn cornell_with(setting: &str, folder: &Path) -> PathBuf {
    let source = std::fs::read_to_string(crate::support::project("scenes/cornell.toml")).unwrap();
    let table = "[render]\n";
    assert!(source.contains(table));
    let path = folder.join("cornell.toml");
    std::fs::write(&path, source.replace(table, &format!("{table}{setting}\n"))).unwrap();
    path
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

#[test]
fn render_writes_exr_png_and_json() {
    let folder = tempfile::tempdir().unwrap();
    let [exr, png, json] = ["a.exr", "a.png", "a.json"].map(|n| folder.path().join(n));
    let (code, stdout, stderr) = run(&[
        "render",
        "scenes/cornell.toml",
        "-o",
        text(&exr),
        "-o",
        text(&png),
        "--spp",
        "3",
        "--size",
        "24x16",
        "--seed",
        "5",
        "--json",
        text(&json),
    ]);
    assert_eq!((code, stdout.as_str()), (0, ""), "{stderr}");
    let names: Vec<_> = std::fs::read_dir(folder.path()).unwrap().collect();
    assert_eq!(names.len(), 3, "no temporary file is left");

    let png = image::open(&png).unwrap().into_rgb8();
    assert_eq!(png.dimensions(), (24, 16));
    assert!(png.pixels().any(|p| p.0 != [0, 0, 0]));

    let report: Value = serde_json::from_slice(&std::fs::read(&json).unwrap()).unwrap();
    for key in [
        "scene",
        "adapter",
        "width",
        "height",
        "spp",
        "passes",
        "seconds",
        "rays",
        "samples_per_second",
        "rays_per_second",
        "error",
        "non_finite",
        "effects",
        "strategy",
        "light_selection",
        "shadow_rays",
        "shadow_pattern",
        "sampler",
        "seed",
        "image_mean",
    ] {
        assert!(!report[key].is_null(), "{key} is missing");
    }
    for key in ["load", "accel", "compile", "render", "total"] {
        assert!(
            report["seconds"][key].as_f64().unwrap() >= 0.0,
            "seconds.{key}"
        );
    }
    assert_eq!(report["spp"], 3);
    assert_eq!(report["rays"]["camera"], 3 * 24 * 16);
    assert_eq!(report["strategy"], "mis-power");
    let error = &report["error"];
    for metric in ["nmse", "rel_mse"] {
        let end = |which: &str| error[format!("{metric}{which}")].as_f64().unwrap();
        assert!(end("_low") <= end("") && end("") <= end("_high"), "{error}");
        assert!(error.get(format!("{metric}_doubt")).is_some());
    }
    check_exr(&exr, &report);
}

fn check_exr(path: &Path, report: &Value) {
    let image = exr::prelude::read_all_flat_layers_from_file(path).unwrap();
    let layer = &image.layer_data[0];
    let channels: Vec<String> = layer
        .channel_data
        .list
        .iter()
        .map(|c| c.name.to_string())
        .collect();
    let expected = [
        "B",
        "G",
        "R",
        "samples.X",
        "standard_error.B",
        "standard_error.G",
        "standard_error.R",
    ];
    assert_eq!(channels, expected);
    for channel in &layer.channel_data.list {
        assert!(
            channel.sample_data.values_as_f32().all(f32::is_finite),
            "{}",
            channel.name
        );
    }
    assert!(
        layer.channel_data.list[3]
            .sample_data
            .values_as_f32()
            .all(|n| (n - 3.0).abs() < 0.1)
    );
    let other = &layer.attributes.other;
    for name in ["nmse", "rel_mse"] {
        assert!(
            other.contains_key(&exr::prelude::Text::from(name)),
            "{name}"
        );
    }
    for (name, value) in [
        ("seed", "5"),
        ("spp", "3"),
        ("scene", "scenes/cornell.toml"),
        ("adapter", report["adapter"]["name"].as_str().unwrap()),
        ("driver", report["adapter"]["driver"].as_str().unwrap()),
        ("direkt", env!("CARGO_PKG_VERSION")),
    ] {
        let attribute = other
            .get(&exr::prelude::Text::from(name))
            .unwrap_or_else(|| panic!("no {name}"));
        assert_eq!(
            *attribute,
            exr::prelude::AttributeValue::Text(value.into()),
            "{name}"
        );
    }
    for name in ["command", "seconds"] {
        assert!(
            other.contains_key(&exr::prelude::Text::from(name)),
            "{name}"
        );
    }
}

#[test]
fn json_on_stdout_is_alone_there() {
    let folder = tempfile::tempdir().unwrap();
    let png = folder.path().join("a.png");
    let (code, stdout, _) = run(&[
        "render",
        "scenes/cornell.toml",
        "-o",
        text(&png),
        "--spp",
        "1",
        "--size",
        "8x8",
        "--json",
        "-",
    ]);
    assert_eq!(code, 0);
    assert!(serde_json::from_str::<Value>(&stdout).is_ok(), "{stdout}");
}

/// Bad input: exit 2, a message that names the culprit, and the output as it was.
#[test]
fn bad_input_ends_with_2_and_touches_no_output() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out.png");
    std::fs::write(&out, "old").unwrap();
    let scene = |name: &str, content: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, content).unwrap();
        path
    };
    let nan = scene(
        "nan.toml",
        "[camera]\neye = [nan, 0, 1]\ntarget = [0, 0, 0]\nfov = 40\n",
    );
    let unknown = scene(
        "unknown.toml",
        "[camera]\neye = [0, 0, 1]\ntarget = [0, 0, 0]\nfov = 40\nlense = 1\n",
    );
    let truncated = scene("truncated.glb", "glTF\u{2}\0\0\0");
    let cases: [(&[&str], &str); 13] = [
        (&["scenes/missing.toml"], "scenes/missing.toml"),
        (&[text(&nan)], "camera.eye"),
        (&[text(&unknown)], "lense"),
        (&[text(&truncated)], "truncated.glb"),
        (&["README.md"], "README.md"),
        (&["scenes/cornell.toml", "--spp", "0"], "--spp 0"),
        (
            &["scenes/cornell.toml", "--shadow-rays", "0"],
            "--shadow-rays",
        ),
        (
            &["scenes/cornell.toml", "--shadow-rays", "1025"],
            "a number from 1 to 1024",
        ),
        (
            &["scenes/cornell.toml", "--shadow-pattern", "regular"],
            "stratified",
        ),
        (&["scenes/cornell.toml", "--size", "0x4"], "0x4"),
        (&["scenes/cornell.toml", "--time", "-1"], "-1"),
        (
            &["scenes/cornell.toml", "--adapter", "no such adapter"],
            "no such adapter",
        ),
        (&["scenes/cornell.toml", "--exposure", "nan"], "--exposure"),
    ];
    for (arguments, named) in cases {
        let mut all = vec!["render", "-o", text(&out)];
        all.extend(arguments);
        let (code, _, stderr) = run(&all);
        assert_eq!(code, 2, "{arguments:?}: {stderr}");
        assert!(
            stderr.contains(named),
            "{arguments:?} does not name {named}: {stderr}"
        );
        assert!(!stderr.contains("panicked"), "{stderr}");
        assert_eq!(
            std::fs::read_to_string(&out).unwrap(),
            "old",
            "{arguments:?}"
        );
    }
}

#[test]
fn outputs_that_cannot_be_written_are_refused_before_rendering() {
    for (out, named) in [
        ("a.jpg", ".exr or .png"),
        ("no/such/folder/a.png", "no/such/folder"),
        ("src", ".exr or .png"),
    ] {
        let (code, _, stderr) = run(&["render", "scenes/cornell.toml", "-o", out]);
        assert_eq!(code, 2, "{stderr}");
        assert!(stderr.contains(named), "{stderr}");
    }
}

/// A child that ends with the test, also when the test fails.
#[cfg(unix)]
struct Child(std::process::Child);

#[cfg(unix)]
impl Drop for Child {
    fn drop(&mut self) {
        // A child that has ended already is what the test wants.
        let _ = self.0.kill();
    }
}

/// Sends Ctrl-C.
#[cfg(unix)]
fn interrupt(child: &Child) {
    let command = format!("kill -INT {}", child.0.id());
    let sent = Command::new("sh").args(["-c", &command]).status().unwrap();
    assert!(sent.success());
}

/// Ctrl-C writes what there is.
#[cfg(unix)]
#[test]
fn an_interrupt_writes_the_image_so_far() {
    use std::io::BufRead;
    let folder = tempfile::tempdir().unwrap();
    let [png, json] = ["a.png", "a.json"].map(|n| folder.path().join(n));
    let mut child = Child(
        Command::new(env!("CARGO_BIN_EXE_direkt"))
            .args([
                "render",
                "scenes/cornell.toml",
                "--size",
                "64x64",
                "--time",
                "600",
            ])
            .args(["-o", text(&png), "--json", text(&json)])
            .current_dir(crate::support::PROJECT)
            .stderr(std::process::Stdio::piped())
            .spawn()
            .unwrap(),
    );
    let mut lines = std::io::BufReader::new(child.0.stderr.take().unwrap()).lines();
    let first = lines.next().unwrap().unwrap();
    assert!(first.starts_with("rendering"), "{first}");
    // The driver compiles at the first dispatch.
    std::thread::sleep(std::time::Duration::from_secs(5));
    interrupt(&child);
    assert!(child.0.wait().unwrap().success());
    assert!(image::open(&png).is_ok());
    let report: Value = serde_json::from_slice(&std::fs::read(&json).unwrap()).unwrap();
    assert_eq!(report["stopped_by"], "interrupt");
    assert!(report["spp"].as_u64().unwrap() >= 1);
}

#[test]
fn time_limits_a_render() {
    let folder = tempfile::tempdir().unwrap();
    let [png, json] = ["a.png", "a.json"].map(|n| folder.path().join(n));
    let (code, _, stderr) = run(&[
        "render",
        "scenes/cornell.toml",
        "--size",
        "64x64",
        "--time",
        "1.5",
        "-o",
        text(&png),
        "--json",
        text(&json),
    ]);
    assert_eq!(code, 0, "{stderr}");
    let report: Value = serde_json::from_slice(&std::fs::read(&json).unwrap()).unwrap();
    assert!(report["seconds"]["render"].as_f64().unwrap() >= 1.5);
    assert_eq!(report["stopped_by"], "time");
}

#[test]
fn an_error_ends_a_render() {
    let folder = tempfile::tempdir().unwrap();
    let [exr, json] = ["a.exr", "a.json"].map(|n| folder.path().join(n));
    for (metric, key, flags) in [
        ("nmse", "nmse_high", &[][..]),
        ("rel-mse", "rel_mse_high", &["--error-metric", "rel-mse"]),
    ] {
        let mut arguments = vec!["render", "scenes/cornell.toml", "--size", "48x48"];
        arguments.extend(["--error", "0.08", "--json", text(&json)]);
        let (code, _, stderr) = run(&[&arguments[..], flags, &["-o", text(&exr)]].concat());
        assert_eq!(code, 0, "{stderr}");
        let report: Value = serde_json::from_slice(&std::fs::read(&json).unwrap()).unwrap();
        assert_eq!(report["stopped_by"], "error", "{metric}");
        let error = &report["error"];
        assert!(error[key].as_f64().unwrap() <= 0.08 * 0.08, "{error}");
        assert_eq!(error["confidence"], 0.95);
    }
    for wrong in [["--error", "0"], ["--error", "nan"], ["--confidence", "1"]] {
        let (code, _, stderr) = run(&[
            "render",
            "scenes/cornell.toml",
            "-o",
            text(&exr),
            wrong[0],
            wrong[1],
        ]);
        assert_eq!(code, 2);
        assert!(
            stderr.contains(&format!("{} {}", wrong[0], wrong[1].replace("nan", "NaN"))),
            "{stderr}"
        );
    }
}

#[test]
fn doctor_names_adapters_and_their_loop_budget() {
    let (code, stdout, stderr) = run(&["doctor"]);
    assert_eq!(code, 0, "{stderr}");
    for part in [
        "driver",
        "storage binding",
        "70,000",
        "at an address of its own",
        "verdict",
    ] {
        assert!(stdout.contains(part), "{part}: {stdout}");
    }
    let (code, stdout, _) = run(&["doctor", "--json", "-"]);
    assert_eq!(code, 0);
    let diagnoses: Value = serde_json::from_str(&stdout).unwrap();
    assert!(diagnoses[0]["adapter"]["name"].is_string());
    assert_eq!(run(&["doctor", "--adapter", "no such adapter"]).0, 2);
}
