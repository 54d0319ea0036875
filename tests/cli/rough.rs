//! Rough handling: streams that are full or closed, signals, folders that vanish, disks without
//! room.
//!
//! Each case alone first, where it waits for what it needs; then many runs at random, in
//! [`random`].

mod random;

use super::outputs::{colours, contents, direkt_in, folder};
use serde_json::Value;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// Longer than anything here takes.
const PATIENCE: Duration = Duration::from_secs(120);

/// A child that ends with the test, also when the test fails.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        // A child that has ended already is what the test wants.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl Running {
    fn start(command: &mut Command) -> Self {
        Self(command.stderr(Stdio::piped()).spawn().unwrap())
    }

    fn send(&self, signal: &str) {
        let id = self.0.id().to_string();
        let sent = Command::new("kill").args([signal, &id]).status().unwrap();
        assert!(sent.success());
    }

    /// Waits until `is_so`, as long as the child runs.
    fn wait_for(&mut self, what: &str, mut is_so: impl FnMut() -> bool) {
        let start = Instant::now();
        while !is_so() {
            let ended = self.0.try_wait().unwrap();
            assert!(ended.is_none(), "{what}: {ended:?}: {}", self.said());
            assert!(start.elapsed() < PATIENCE, "{what}");
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    fn said(&mut self) -> String {
        let mut text = Vec::new();
        let mut stderr = self.0.stderr.take().unwrap();
        stderr.read_to_end(&mut text).unwrap();
        String::from_utf8_lossy(&text).into_owned()
    }

    fn end(mut self) -> (ExitStatus, String) {
        let start = Instant::now();
        let status = loop {
            if let Some(status) = self.0.try_wait().unwrap() {
                break status;
            }
            if start.elapsed() > PATIENCE {
                self.0.kill().unwrap();
                panic!("the render does not end; is SIGINT ignored where the tests run?");
            }
            std::thread::sleep(Duration::from_millis(5));
        };
        (status, self.said())
    }
}

/// A render without an end that writes `out` all the time.
fn endless(folder: &Path, out: &str) -> Command {
    let mut command = direkt_in(folder);
    let arguments = ["render", "s.toml", "--time", "1e300", "--watch=0.01", "-q"];
    command.args(arguments).args(["-o", out]);
    command
}

/// Runs `script` by the shell in `folder`; `$0` is direkt. The exit code of the script.
fn shell(folder: &Path, script: &str) -> i32 {
    let mut command = Command::new("sh");
    command.args(["-c", script, env!("CARGO_BIN_EXE_direkt")]);
    command.current_dir(folder).env("TMPDIR", folder);
    let output = command.output().unwrap();
    output.status.code().unwrap()
}

/// The place that a message names.
fn saved_as(said: &str) -> PathBuf {
    let at = said
        .split("saved as ")
        .nth(1)
        .unwrap_or_else(|| panic!("{said}"));
    PathBuf::from(at.lines().next().unwrap())
}

#[test]
fn text_that_nobody_reads_is_lost_alone() {
    let folder = folder();
    let render = "\"$0\" render s.toml -o";
    assert_eq!(shell(folder.path(), &format!("{render} right.exr")), 0);
    let right = colours(&folder.path().join("right.exr"));
    let mut cases = vec![
        format!("{render} a.exr 2>&-"),
        format!("{render} a.exr >&- 2>&- <&-"),
        format!("{{ {render} a.exr 2>&1; echo $? >code; }} | true; exit $(cat code)"),
        format!("{{ {render} a.exr --json -; echo $? >code; }} | true; exit $(cat code)"),
        format!("{{ {render} a.exr --check 2>&1; echo $? >code; }} | true; exit $(cat code)"),
    ];
    if Path::new("/dev/full").exists() {
        cases.push(format!("{render} a.exr 2>/dev/full"));
        cases.push(format!("{render} a.exr --json /dev/null 2>/dev/full"));
    }
    // A scene without exact values is refused, in silence.
    let is_refused = |script: &str| script.contains("--check");
    for script in cases {
        let code = shell(folder.path(), &script);
        if is_refused(&script) {
            assert_eq!(code, 2, "{script}");
            continue;
        }
        assert_eq!(code, 0, "{script}");
        let out = folder.path().join("a.exr");
        assert_eq!(colours(&out), right, "{script}");
        std::fs::remove_file(out).unwrap();
    }
}

#[test]
fn facts_that_a_full_disk_does_not_take_are_saved_elsewhere() {
    if !Path::new("/dev/full").exists() {
        return;
    }
    for json in ["- >/dev/full", "/dev/full"] {
        let folder = folder();
        let script = format!("\"$0\" render s.toml -q -o a.exr --json {json} 2>said");
        assert_eq!(shell(folder.path(), &script), 1, "{json}");
        let said = std::fs::read_to_string(folder.path().join("said")).unwrap();
        let facts = std::fs::read(folder.path().join(saved_as(&said))).unwrap();
        let facts: Value = serde_json::from_slice(&facts).unwrap();
        assert_eq!(facts["spp"], 4, "{said}");
        colours(&folder.path().join("a.exr"));
    }
    // A table is no file: its loss is an error all the same.
    let folder = folder();
    let script = "\"$0\" explain s.toml --json a.json >/dev/full 2>said";
    assert_eq!(shell(folder.path(), script), 1);
    let said = std::fs::read_to_string(folder.path().join("said")).unwrap();
    assert!(
        said.starts_with("direkt: stdout: cannot be written"),
        "{said}"
    );
    assert!(folder.path().join("a.json").exists());
}

#[test]
fn links_are_followed_and_devices_take_facts() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    for (link, target) in [("link.exr", "old.exr"), ("dangling.exr", "new.exr")] {
        std::os::unix::fs::symlink(target, at(link)).unwrap();
    }
    std::fs::write(at("old.exr"), "old").unwrap();
    let private = std::os::unix::fs::PermissionsExt::from_mode(0o640);
    std::fs::set_permissions(at("old.exr"), private).unwrap();
    let render = "\"$0\" render s.toml -q -o";
    let script = format!("{render} link.exr -o dangling.exr --json /dev/stdout >>facts");
    std::fs::write(at("facts"), "before\n").unwrap();
    assert_eq!(shell(folder.path(), &script), 0);
    for link in ["link.exr", "dangling.exr"] {
        assert!(at(link).symlink_metadata().unwrap().is_symlink());
    }
    assert_eq!(colours(&at("old.exr")), colours(&at("new.exr")));
    let mode = at("old.exr").metadata().unwrap().permissions();
    assert_eq!(
        std::os::unix::fs::PermissionsExt::mode(&mode) & 0o777,
        0o640
    );
    let facts = std::fs::read_to_string(at("facts")).unwrap();
    let facts = facts.strip_prefix("before\n").expect("it is appended");
    assert_eq!(serde_json::from_str::<Value>(facts).unwrap()["spp"], 4);
    assert_eq!(shell(folder.path(), "mkfifo pipe"), 0);
    let script = format!("cat pipe >piped & {render} a.exr --json pipe; code=$?; wait; exit $code");
    assert_eq!(shell(folder.path(), &script), 0);
    let piped = std::fs::read_to_string(at("piped")).unwrap();
    assert_eq!(serde_json::from_str::<Value>(&piped).unwrap()["spp"], 4);
}

/// Ends an endless render of `a.exr` and `a.png` when its files may hold half a KiB: the PNG is
/// written, the EXR can be nowhere and is as it was. What was said; none where limits cannot be
/// set.
///
/// They are set in the middle, as lavapipe keeps its memory in files.
fn end_without_room(folder: &Path) -> Option<String> {
    let [exr, png] = ["a.exr", "a.png"].map(|name| folder.join(name));
    let mut running = Running::start(endless(folder, "a.exr").args(["-o", "a.png"]));
    running.wait_for("an image", || png.exists());
    let id = running.0.id().to_string();
    let mut limit = Command::new("prlimit");
    let limit = limit.args(["--fsize=512:512", "--pid", &id]).status();
    if !limit.is_ok_and(|status| status.success()) {
        return None;
    }
    // The EXR of one that had begun before is there when its PNG is.
    std::fs::remove_file(&png).unwrap();
    running.wait_for("a picture within the limit", || png.exists());
    let before = colours(&exr);
    running.send("-TERM");
    let (status, said) = running.end();
    assert_eq!(status.code(), Some(1), "{said}");
    assert!(
        said.contains("a.exr: cannot be written: File too large"),
        "{said}"
    );
    assert_eq!(colours(&exr), before);
    assert_eq!(image::open(png).unwrap().into_rgb8().dimensions(), (8, 8));
    Some(said)
}

#[test]
fn an_output_that_cannot_be_written_leaves_the_others() {
    let folder = folder();
    let Some(said) = end_without_room(folder.path()) else {
        say("SKIPPED: an_output_that_cannot_be_written_leaves_the_others needs prlimit\n");
        return;
    };
    // The warning on the way and the error in the end.
    assert_eq!(
        said.matches("a.exr: cannot be written").count(),
        2,
        "{said}"
    );
    let names = contents(folder.path());
    assert_eq!(names.len(), 3, "s.toml, a.exr, a.png: {names:?}");
}

#[test]
fn a_folder_that_goes_leaves_the_image_elsewhere() {
    let folder = folder();
    let gone = folder.path().join("gone");
    std::fs::create_dir(&gone).unwrap();
    let mut command = endless(folder.path(), "gone/a.exr");
    let mut running = Running::start(command.args(["-o", "stays.exr", "--json", "a.json"]));
    let image = gone.join("a.exr");
    running.wait_for("an image", || image.exists());
    // A new picture may come in the middle of it.
    running.wait_for("no folder", || {
        std::fs::remove_dir_all(&gone).is_ok() || !gone.exists()
    });
    running.send("-INT");
    let (status, said) = running.end();
    assert_eq!(status.code(), Some(1), "{said}");
    assert!(said.contains("gone/a.exr: cannot be written"), "{said}");
    let saved = saved_as(said.lines().find(|l| !l.contains("--watch")).unwrap());
    let stays = folder.path().join("stays.exr");
    assert_eq!(colours(&folder.path().join(saved)), colours(&stays));
    assert!(folder.path().join("a.json").exists());
    let warnings = said.matches("--watch:").count();
    assert!(warnings <= 1, "one warning for all: {said}");
}

/// Terminals that are closed say so twice, and services that are stopped are told in several ways:
/// the facts, which wait for their reader, are written all the same.
#[test]
fn signals_end_a_render_with_its_image() {
    for signals in [["-HUP", "-HUP"], ["-TERM", "-HUP"], ["-INT", "-TERM"]] {
        let folder = folder();
        let [out, pipe] = ["a.exr", "pipe"].map(|name| folder.path().join(name));
        assert!(
            Command::new("mkfifo")
                .arg(&pipe)
                .status()
                .unwrap()
                .success()
        );
        let mut running = Running::start(endless(folder.path(), "a.exr").args(["--json", "pipe"]));
        running.wait_for("an image", || out.exists());
        for signal in signals {
            running.send(signal);
            // Two that come at once are one.
            std::thread::sleep(Duration::from_millis(150));
        }
        let ended = running.0.try_wait().unwrap();
        assert!(ended.is_none(), "{signals:?}: {ended:?}");
        let facts = std::fs::read_to_string(&pipe).unwrap();
        let facts: Value = serde_json::from_str(&facts).unwrap();
        assert_eq!(facts["stopped_by"], "interrupt");
        let (status, said) = running.end();
        assert_eq!((status.code(), said.as_str()), (Some(0), ""), "{signals:?}");
        assert!(!colours(&out).is_empty());
    }
}

/// As with `nohup`.
#[test]
fn what_is_ignored_from_the_start_stays_ignored() {
    let folder = folder();
    let out = folder.path().join("a.exr");
    let direkt = endless(folder.path(), "a.exr");
    let mut shell = Command::new("sh");
    shell.args(["-c", "trap '' HUP; exec \"$0\" \"$@\""]);
    shell.arg(direkt.get_program()).args(direkt.get_args());
    let mut running = Running::start(shell.current_dir(folder.path()));
    running.wait_for("an image", || out.exists());
    running.send("-HUP");
    for _ in 0..2 {
        std::fs::remove_file(&out).unwrap();
        running.wait_for("another image", || out.exists());
    }
    running.send("-TERM");
    assert_eq!(running.end().0.code(), Some(0));
}

#[test]
fn what_a_killed_run_left_is_removed_and_what_another_writes_is_not() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at(".direkt-left00.tmp"), "half an image").unwrap();
    let mut busy = Running::start(&mut endless(folder.path(), "busy.exr"));
    busy.wait_for("an image", || at("busy.exr").exists());
    for _ in 0..8 {
        let status = direkt_in(folder.path())
            .args(["render", "s.toml", "-q", "-o", "a.exr"])
            .status();
        assert!(status.unwrap().success());
        assert!(!at(".direkt-left00.tmp").exists());
    }
    busy.send("-TERM");
    let (status, said) = busy.end();
    assert_eq!((status.code(), said.as_str()), (Some(0), ""));
}

/// A tmpfs of `KiB` in a folder, where this user may mount one.
struct SmallDisk(PathBuf);

impl SmallDisk {
    fn mount(at: &Path, size: &str) -> Option<Self> {
        std::fs::create_dir(at).unwrap();
        let options = format!("size={size}");
        let mut command = Command::new("mount");
        command
            .args(["-t", "tmpfs", "-o", &options, "tmpfs"])
            .arg(at);
        let mounted = command.output().is_ok_and(|o| o.status.success());
        mounted.then(|| Self(at.to_path_buf()))
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        // It goes with the machine otherwise.
        let _ = Command::new("umount").arg("-l").arg(&self.0).status();
    }
}

#[test]
fn a_full_disk_leaves_the_image_elsewhere() {
    let folder = folder();
    let disk = folder.path().join("disk");
    let Some(small) = SmallDisk::mount(&disk, "16k") else {
        say("SKIPPED: a_full_disk_leaves_the_image_elsewhere cannot mount a tmpfs\n");
        return;
    };
    std::fs::write(disk.join("old.exr"), "old").unwrap();
    // 64 × 64 pixels take far more than 16 KiB; the probe takes less.
    let arguments = [
        "render",
        "s.toml",
        "-q",
        "--size",
        "64x64",
        "-o",
        "disk/old.exr",
    ];
    let mut command = direkt_in(folder.path());
    let output = command
        .args(arguments)
        .args(["-o", "a.exr"])
        .output()
        .unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(
        said.contains("disk/old.exr: cannot be written: No space"),
        "{said}"
    );
    let saved = folder.path().join(saved_as(&said));
    assert_eq!(colours(&saved), colours(&folder.path().join("a.exr")));
    assert_eq!(
        std::fs::read_to_string(disk.join("old.exr")).unwrap(),
        "old"
    );
    assert_eq!(contents(&disk).len(), 1, "no temporary file is left");
    std::fs::write(disk.join("fill"), [0; 12 * 1024]).unwrap();
    let mut command = direkt_in(folder.path());
    let output = command
        .args(["render", "s.toml", "-o", "disk/b.png"])
        .output()
        .unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("takes no new files: No space"), "{said}");
    drop(small);
}

/// Says it past the test harness, which would swallow it.
fn say(sentence: &str) {
    use std::io::Write;
    std::io::stderr().write_all(sentence.as_bytes()).unwrap();
}
