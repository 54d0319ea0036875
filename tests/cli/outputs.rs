//! Outputs: what is refused before rendering, what is written however it is named, and inputs that
//! stay as they are.

use super::run;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

/// A scene of one kernel, so small that a run takes no longer than its start.
pub const TINY: &str = "[camera]\neye = [0, 0, 3]\ntarget = [0, 0, 0]\nfov = 40\n\
    [film]\nwidth = 8\nheight = 8\n[render]\nspp = 4\n[materials.m]\ntype = \"lambert\"\nreflectance = 0.5\n\
    [[shapes]]\ntype = \"rectangle\"\nmaterial = \"m\"\ncorner = [-1, -1, 0]\nu = [2, 0, 0]\nv = [0, 2, 0]\n\
    [[lights]]\ntype = \"point\"\nposition = [0, 0, 2]\nintensity = 1\n";

/// A folder with the file `s.toml`, which is [`TINY`].
pub fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("s.toml"), TINY).unwrap();
    folder
}

/// The command, run in `folder`.
pub fn direkt_in(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_direkt"));
    command.current_dir(folder).env("TMPDIR", folder);
    command
}

/// Exit code and stderr of a command in `folder`.
fn run_in(folder: &Path, arguments: &[&str]) -> (i32, String) {
    let output = direkt_in(folder).args(arguments).output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    (output.status.code().unwrap(), stderr)
}

/// Names and contents of the files in `folder`, links followed.
pub fn contents(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let entries = std::fs::read_dir(folder).unwrap();
    let files = entries.map(|e| e.unwrap().path()).filter(|p| p.is_file());
    let mut files: Vec<_> = files
        .map(|p| (p.clone(), std::fs::read(p).unwrap()))
        .collect();
    files.sort();
    files
}

/// Colours of an EXR, as bits.
pub fn colours(path: &Path) -> Vec<u32> {
    let image = exr::prelude::read_first_flat_layer_from_file(path);
    let image = image.unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let channels = image.layer_data.channel_data.list.into_iter();
    let colours = channels.filter(|c| !c.name.to_string().contains('.'));
    let bits = colours.flat_map(|c| {
        let values = c.sample_data.values_as_f32().map(f32::to_bits);
        values.collect::<Vec<_>>()
    });
    bits.collect()
}

#[test]
fn names_of_any_script_are_rendered() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    std::fs::create_dir(at("シーン")).unwrap();
    std::fs::write(at("シーン/場面.toml"), TINY).unwrap();
    let mut command = direkt_in(folder.path());
    let arguments = [
        "render",
        "シーン/場面.toml",
        "-q",
        "-o",
        "плоскость.exr",
        "-o",
    ];
    command.args(arguments).arg("❤.exr");
    #[cfg(target_os = "linux")]
    {
        use std::os::unix::ffi::OsStrExt;
        let bytes = std::ffi::OsStr::from_bytes;
        command.arg("-o").arg(bytes(b"no\xfftext.exr"));
        command.arg("--json").arg(bytes(b"no\xfftext.json"));
        command.arg("--assets").arg(bytes(b"\xff\xfe"));
        std::fs::create_dir(folder.path().join(bytes(b"\xff\xfe"))).unwrap();
    }
    let output = command.output().unwrap();
    assert!(output.status.success(), "{output:?}");
    assert!(output.stderr.is_empty(), "{output:?}");
    let files = contents(folder.path());
    let images = files
        .iter()
        .filter(|(p, _)| p.extension() == Some("exr".as_ref()));
    let images: Vec<_> = images.map(|(p, _)| colours(p)).collect();
    assert!(images.len() >= 2 && images.windows(2).all(|w| w[0] == w[1]));
    let image = exr::prelude::read_first_flat_layer_from_file(at("❤.exr")).unwrap();
    let other = image.layer_data.attributes.other;
    let scene = other.into_iter().find(|(name, _)| *name == *"scene");
    let Some((_, exr::prelude::AttributeValue::Text(scene))) = scene else {
        panic!("{scene:?}");
    };
    assert_eq!(scene.as_slice(), "シーン/場面.toml".as_bytes());
}

/// Files that a scene reads: each by its own name, and by links to it.
#[test]
fn what_is_read_is_never_written() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let copy = |from: &str, to: &str| {
        std::fs::copy(crate::support::project(from), at(to)).unwrap();
    };
    copy("scenes/tests/texels_2x1.png", "texture.png");
    copy("scenes/tests/emissive_triangle.obj", "mesh.obj");
    copy("scenes/tests/texels_4x4.png", "of_gltf.png");
    copy("scenes/tests/texels_4x4.png", "unused.png");
    let floats = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let bytes: Vec<u8> = floats.iter().flat_map(|x| x.to_le_bytes()).collect();
    std::fs::write(at("data.bin"), bytes).unwrap();
    let model = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0}]}],
        "materials":[{"emissiveTexture":{"index":0},"emissiveFactor":[1,1,1]}],
        "textures":[{"source":0}],"images":[{"uri":"of_gltf.png"},{"uri":"unused.png"}],
        "buffers":[{"byteLength":36,"uri":"data.bin"}],"bufferViews":[{"buffer":0,"byteLength":36}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}]}"#;
    std::fs::write(at("model.gltf"), model).unwrap();
    let scene = format!(
        "{TINY}[[shapes]]\ntype = \"mesh\"\nfile = \"mesh.obj\"\n\
         emission = {{ radiance = 1, texture = {{ file = \"texture.png\" }} }}\n[[gltf]]\nfile = \"model.gltf\"\n"
    );
    std::fs::write(at("s.toml"), scene).unwrap();
    let inputs = [
        "s.toml",
        "texture.png",
        "mesh.obj",
        "model.gltf",
        "data.bin",
        "of_gltf.png",
        "unused.png",
    ];
    let mut named: Vec<(String, &str)> = Vec::new();
    for input in inputs {
        named.push((input.to_owned(), input));
        named.push((format!("./{input}"), input));
        std::fs::hard_link(at(input), at(&format!("hard_{input}"))).unwrap();
        named.push((format!("hard_{input}"), input));
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(input, at(&format!("link_{input}"))).unwrap();
            named.push((format!("link_{input}"), input));
        }
    }
    let before = contents(folder.path());
    let refused = |arguments: &[&str], name: &str| {
        let (code, stderr) = run_in(folder.path(), arguments);
        assert_eq!(code, 2, "{arguments:?}: {stderr}");
        let reason = if name.ends_with("s.toml") {
            "is the scene itself"
        } else {
            "is a file that the scene reads"
        };
        assert!(stderr.contains(name) && stderr.contains(reason), "{stderr}");
        assert_eq!(contents(folder.path()), before, "{arguments:?}");
    };
    std::fs::create_dir(at("shaders")).unwrap();
    std::fs::write(at("shaders/a.wesl"), "").unwrap();
    let mut command = direkt_in(folder.path());
    command.env("DIREKT_SHADERS", at("shaders"));
    let arguments = [
        "render",
        "s.toml",
        "-o",
        "a.exr",
        "--json",
        "shaders/a.wesl",
    ];
    let output = command.args(arguments).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(
        said.contains("shaders/a.wesl: is a shader that is read"),
        "{said}"
    );
    for (name, input) in &named {
        let base = ["render", "s.toml", "-q", "-o"];
        refused(&[&base[..], &["a.exr", "--json", name]].concat(), name);
        if input.ends_with(".png") {
            refused(&[&base[..], &[name]].concat(), name);
        }
    }
    for command in [
        &["explain", "s.toml", "--json"][..],
        &["compare", "s.toml", "--json"],
        &["compare", "s.toml", "--z-scores"],
        &["cost", "s.toml", "-o", "report", "--csv"],
        &["cost", "s.toml", "--calibrate", "--json"],
    ] {
        refused(&[command, &["texture.png"]].concat(), "texture.png");
    }
}

#[test]
fn two_outputs_are_two_files() {
    let folder = folder();
    #[cfg(unix)]
    std::os::unix::fs::symlink("a.exr", folder.path().join("link.exr")).unwrap();
    let mut cases: Vec<Vec<&str>> = vec![
        vec!["render", "s.toml", "-o", "a.exr", "-o", "a.exr"],
        vec!["render", "s.toml", "-o", "a.exr", "-o", "./a.exr"],
        vec!["render", "s.toml", "-o", "a.exr", "--json", "a.exr"],
        vec![
            "compare",
            "s.toml",
            "--difference",
            "a.exr",
            "--z-scores",
            "./a.exr",
        ],
        vec!["cost", "s.toml", "-o", "r", "--csv", "r/report.html"],
        vec!["cost", "s.toml", "-o", "r", "--json", "r/s-efficiency.svg"],
    ];
    if cfg!(unix) {
        cases.push(vec!["render", "s.toml", "-o", "a.exr", "-o", "link.exr"]);
    }
    cases.push(vec!["lab", "-o", "r", "--json", "r/pi.svg"]);
    for arguments in cases {
        let (code, stderr) = run_in(folder.path(), &arguments);
        assert_eq!(code, 2, "{arguments:?}: {stderr}");
        let reason = match arguments[0] {
            "lab" => "end in .svg are written there",
            _ => "is the same file as",
        };
        assert!(stderr.contains(reason), "{stderr}");
        let files = contents(folder.path());
        assert_eq!(files.len(), 1, "{arguments:?}");
    }
}

#[test]
fn what_cannot_be_written_is_said_before_rendering() {
    let folder = folder();
    let long = format!("{}.exr", "a".repeat(300));
    std::fs::create_dir(folder.path().join("folder.exr")).unwrap();
    let protected = folder.path().join("protected.exr");
    std::fs::write(&protected, "old").unwrap();
    let mut permissions = std::fs::metadata(&protected).unwrap().permissions();
    permissions.set_readonly(true);
    std::fs::set_permissions(&protected, permissions).unwrap();
    let mut cases: Vec<(Vec<&str>, &str)> = vec![
        (
            vec!["-o", "a.exr", "--json", "no/a.json"],
            "there is no folder no",
        ),
        (
            vec!["-o", "a.exr", "-o", "no/b.png"],
            "there is no folder no",
        ),
        (vec!["-o", "a.exr", "-o", &long], &long),
        (vec!["-o", "folder.exr"], "is a folder"),
        (vec!["-o", "new.exr/"], "is a folder"),
        (vec!["-o", "s.toml/a.exr"], "s.toml"),
        (vec!["-o", "protected.exr"], "write-protected"),
        (vec!["-o", "a.exr", "--json", "folder.exr"], "is a folder"),
    ];
    #[cfg(target_os = "linux")]
    {
        let at = |name: &str| folder.path().join(name);
        let made = Command::new("mkfifo").arg(at("pipe.exr")).status().unwrap();
        assert!(made.success());
        let link = std::os::unix::fs::symlink::<&str, PathBuf>;
        link("loop.exr", at("loop.exr")).unwrap();
        link("/dev/null", at("null.exr")).unwrap();
        link("no/a.exr", at("dangling.exr")).unwrap();
        cases.extend([
            // Folders that take no files, whoever runs this.
            (
                vec!["-o", "a.exr", "-o", "/proc/a.exr"],
                "/proc takes no new files",
            ),
            (
                vec!["-o", "a.exr", "--json", "/sys/a"],
                "/sys takes no new files",
            ),
            (vec!["-o", "pipe.exr"], "is a pipe or a device"),
            (vec!["-o", "null.exr"], "is a pipe or a device"),
            (vec!["-o", "loop.exr"], "loop of symbolic links"),
            (vec!["-o", "dangling.exr"], "there is no folder"),
        ]);
    }
    let before = contents(folder.path());
    for (flags, reason) in cases {
        let (code, stderr) = run_in(folder.path(), &[&["render", "s.toml"], &flags[..]].concat());
        assert_eq!(code, 2, "{flags:?}: {stderr}");
        let said = stderr.contains(reason) && !stderr.contains("rendering");
        assert!(said, "{flags:?}: {stderr}");
        assert_eq!(contents(folder.path()), before, "{flags:?}");
    }
}

#[test]
fn any_positive_number_of_seconds_is_one() {
    let folder = folder();
    let forever = TINY.replace("spp = 4", "spp = 4\ntime = 1e300");
    std::fs::write(folder.path().join("forever.toml"), &forever).unwrap();
    let never = forever.replace("1e300", "-1e300");
    std::fs::write(folder.path().join("never.toml"), never).unwrap();
    for arguments in [
        &["s.toml", "--spp", "4", "--time", "1e300", "--watch=1e300"][..],
        &["s.toml", "--time", "1e-320"],
        &["forever.toml"],
    ] {
        let base = ["render", "-q", "-o", "a.exr"];
        let (code, stderr) = run_in(folder.path(), &[&base[..], arguments].concat());
        assert_eq!((code, stderr.as_str()), (0, ""), "{arguments:?}");
    }
    for (arguments, said) in [
        (&["never.toml"][..], "render.time: is -1e300;"),
        (&["s.toml", "--watch=-1e300"], "--watch=-1e300: a positive"),
        (
            &["s.toml", "--confidence", "1e300"],
            "--confidence 1e300: a prob",
        ),
    ] {
        let base = ["render", "-q", "-o", "a.exr"];
        let (code, stderr) = run_in(folder.path(), &[&base[..], arguments].concat());
        assert_eq!(code, 2, "{stderr}");
        assert!(stderr.contains(said), "{stderr}");
    }
}

/// Shaders that are read from a folder and are wrong: by their text, by what they name, and by
/// their types.
#[test]
fn shaders_that_do_not_compile_end_with_2() {
    let folder = folder();
    let shaders = crate::support::project("shaders");
    let kernel = std::fs::read_to_string(shaders.join("kernel/direct.wesl")).unwrap();
    let mut copy = Command::new("cp");
    copy.arg("-r").arg(shaders).arg(folder.path());
    assert!(copy.status().unwrap().success());
    let right = "fn sample_radiance(id: SampleId, pixel: vec2u) -> vec3f {";
    assert!(kernel.contains(right));
    let file = folder.path().join("shaders/kernel/direct.wesl");
    for broken in [
        kernel.clone() + "let x = ;",
        kernel.replace(right, &right.replace("vec3f", "vec2f")),
        String::new(),
    ] {
        std::fs::write(&file, broken).unwrap();
        let mut command = direkt_in(folder.path());
        command.env("DIREKT_SHADERS", folder.path().join("shaders"));
        let output = command
            .args(["render", "s.toml", "-o", "a.exr"])
            .output()
            .unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{stderr}");
        let once = stderr.matches("direkt:").count() == 1;
        assert!(
            once && stderr.starts_with("direkt: shader `kernel"),
            "{stderr}"
        );
        assert!(!stderr.contains('\u{1b}'), "no colours: {stderr}");
    }
}

#[test]
fn a_check_of_an_adaptive_image_uses_all_its_samples() {
    let scene = "scenes/tests/glass_sphere_furnace.toml";
    let (code, stdout, _) = run(&["render", scene, "--check", "--adaptive", "--json", "-"]);
    assert_eq!(code, 0, "{stdout}");
    let report: Value = serde_json::from_str(&stdout).unwrap();
    let fewest = report["samples"][0].as_u64();
    assert!(fewest < Some(64), "else it shows nothing: {fewest:?}");
    assert_eq!(report["check"]["passed"], true);
}
