//! Runs at random, each handled roughly in one way or another: no image that could be written is
//! lost, no input changes, and exit codes are 0, 1 and 2.
//!
//! `DIREKT_ROUGH_RUNS` is their number, 500 otherwise; without it they end after [`LIMIT`] however
//! many there were, which is said.

use super::{Running, SmallDisk, end_without_room, endless, saved_as, say};
use crate::cli::outputs::{TINY, colours, direkt_in};
use std::collections::BTreeMap;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

const RUNS: u64 = 500;
/// Runs at a time.
const THREADS: u64 = 2;
/// After which no further run begins.
const LIMIT: Duration = Duration::from_secs(25);

/// A way of handling a run.
type Way = fn(&mut Bench<'_>);

const WAYS: [(&str, Way); 10] = [
    ("killed", killed),
    ("asked to end", asked_to_end),
    ("pipes closed", pipes_closed),
    ("stderr closed or full", stderr_lost),
    ("folder taken away", folder_taken),
    ("folder never there", folder_missing),
    ("folder that takes no files", folder_closed),
    ("input as output", input_as_output),
    ("disk full", disk_full),
    ("file too large", file_too_large),
];

/// One thread's folder, and its random numbers.
struct Bench<'a> {
    folder: &'a Path,
    /// Colours of the image of [`TINY`].
    right: &'a [u32],
    has_disk: bool,
    random: u64,
}

impl Bench<'_> {
    /// A whole number below `n` (SplitMix64; Steele et al. 2014).
    fn below(&mut self, n: u64) -> u64 {
        self.random = self.random.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.random;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) % n
    }

    fn sleep(&mut self, milliseconds: u64) {
        let time = self.below(milliseconds * 1000);
        std::thread::sleep(Duration::from_micros(time));
    }

    /// Exit code and stderr of a render with these arguments.
    fn render(&self, arguments: &[&str]) -> (Option<i32>, String) {
        let mut command = direkt_in(self.folder);
        command.args(["render", "s.toml", "-q"]).args(arguments);
        let output = command.output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        (output.status.code(), said)
    }

    /// Runs a script with a render in it: `$0 "$@"`.
    fn shell(&self, script: &str) -> Option<i32> {
        let mut command = Command::new("sh");
        command.args(["-c", script, env!("CARGO_BIN_EXE_direkt")]);
        command.args(["render", "s.toml", "-o", "a.exr"]);
        command.current_dir(self.folder).env("TMPDIR", self.folder);
        command.stdout(Stdio::null()).stderr(Stdio::null());
        command.status().unwrap().code()
    }

    fn assert_right(&self, image: &Path) {
        assert_eq!(colours(&self.folder.join(image)), self.right);
    }
}

/// At any moment: the old image, or the new one as a whole.
fn killed(bench: &mut Bench<'_>) {
    let out = bench.folder.join("a.exr");
    let mut command = direkt_in(bench.folder);
    let child = command.args(["render", "s.toml", "-q", "-o", "a.exr"]);
    let running = Running::start(child);
    bench.sleep(400);
    drop(running);
    if out.exists() {
        bench.assert_right("a.exr".as_ref());
    }
}

/// By a signal at any moment. A run that has a sample has an image in the end.
fn asked_to_end(bench: &mut Bench<'_>) {
    let signal = ["-INT", "-TERM", "-HUP"][bench.below(3) as usize];
    let out = bench.folder.join("a.exr");
    let running = Running::start(&mut endless(bench.folder, "a.exr"));
    bench.sleep(400);
    let wrote = out.exists();
    running.send(signal);
    let (status, said) = running.end();
    match status.code() {
        Some(0) => assert!(!colours(&out).is_empty()),
        Some(1) => {
            assert!(!wrote && said.contains("before the first sample"), "{said}");
        }
        // Before the program's own first instructions.
        None => assert!(status.signal().is_some() && !wrote && said.is_empty()),
        code => panic!("{signal}: {code:?}: {said}"),
    }
}

fn pipes_closed(bench: &mut Bench<'_>) {
    let streams = ["", "2>&1", "--json -", "--json - 2>&1"][bench.below(4) as usize];
    let script = format!("{{ \"$0\" \"$@\" {streams}; echo $? >code; }} | true; exit $(cat code)");
    assert_eq!(bench.shell(&script), Some(0), "{streams}");
    bench.assert_right("a.exr".as_ref());
}

fn stderr_lost(bench: &mut Bench<'_>) {
    let full = if Path::new("/dev/full").exists() {
        "2>/dev/full"
    } else {
        "2>&-"
    };
    let streams = [full, "2>&-", ">&- 2>&-"][bench.below(3) as usize];
    assert_eq!(bench.shell(&format!("\"$0\" \"$@\" {streams}")), Some(0));
    bench.assert_right("a.exr".as_ref());
}

/// While rendering: the image is where the message says.
fn folder_taken(bench: &mut Bench<'_>) {
    let gone = bench.folder.join("gone");
    std::fs::create_dir(&gone).unwrap();
    let mut running = Running::start(&mut endless(bench.folder, "gone/a.exr"));
    running.wait_for("an image", || gone.join("a.exr").exists());
    bench.sleep(20);
    running.wait_for("no folder", || {
        std::fs::remove_dir_all(&gone).is_ok() || !gone.exists()
    });
    running.send("-TERM");
    let (status, said) = running.end();
    assert_eq!(status.code(), Some(1), "{said}");
    let last = said.lines().rfind(|l| l.contains("saved as"));
    let saved = saved_as(last.unwrap_or_else(|| panic!("{said}")));
    assert!(!colours(&bench.folder.join(saved)).is_empty());
}

fn folder_missing(bench: &mut Bench<'_>) {
    let flag = ["-o", "--json"][bench.below(2) as usize];
    let (code, said) = bench.render(&["-o", "a.exr", flag, "no/b.png"]);
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("there is no folder") && !bench.folder.join("a.exr").exists());
}

fn folder_closed(bench: &mut Bench<'_>) {
    use std::os::unix::fs::PermissionsExt;
    let closed = bench.folder.join("closed");
    std::fs::create_dir(&closed).unwrap();
    std::fs::set_permissions(&closed, PermissionsExt::from_mode(0o555)).unwrap();
    // The administrator writes there all the same.
    let is_open = std::fs::write(closed.join("probe"), "").is_ok();
    let closed = if is_open { "/proc" } else { "closed" };
    let (code, said) = bench.render(&["-o", "a.exr", "-o", &format!("{closed}/b.png")]);
    assert_eq!(code, Some(2), "{said}");
    assert!(!bench.folder.join("a.exr").exists(), "{said}");
}

fn input_as_output(bench: &mut Bench<'_>) {
    let name = ["s.toml", "./s.toml", "link", "hard"][bench.below(4) as usize];
    std::os::unix::fs::symlink("s.toml", bench.folder.join("link")).unwrap();
    std::fs::hard_link(bench.folder.join("s.toml"), bench.folder.join("hard")).unwrap();
    let (code, said) = bench.render(&["-o", "a.exr", "--json", name]);
    assert_eq!(code, Some(2), "{said}");
    assert!(!bench.folder.join("a.exr").exists(), "{said}");
}

/// 16 KiB take the probe and no image of 64 × 64 pixels.
fn disk_full(bench: &mut Bench<'_>) {
    if !bench.has_disk {
        return file_too_large(bench);
    }
    let size = ["--size", "64x64"];
    let outputs = ["-o", "disk/b.exr", "-o", "a.exr"];
    let (code, said) = bench.render(&[&size[..], &outputs].concat());
    assert_eq!(code, Some(1), "{said}");
    let saved = bench.folder.join(saved_as(&said));
    assert_eq!(colours(&saved), colours(&bench.folder.join("a.exr")));
}

/// Where limits cannot be set, a missing folder stands for it.
fn file_too_large(bench: &mut Bench<'_>) {
    if end_without_room(bench.folder).is_none() {
        folder_missing(bench);
    }
}

/// Takes everything away but the scene and the disk, and checks that the scene is as it was and
/// nothing is hidden.
fn clear(folder: &Path) {
    let scene = std::fs::read_to_string(folder.join("s.toml")).unwrap();
    assert_eq!(scene, TINY, "an input has changed");
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        match name.as_str() {
            "s.toml" => {}
            "disk" => std::fs::read_dir(path).unwrap().for_each(|e| {
                std::fs::remove_file(e.unwrap().path()).unwrap();
            }),
            // The next run sweeps it.
            _ if name.starts_with(".direkt-") => {}
            _ if path.is_dir() => std::fs::remove_dir_all(path).unwrap(),
            _ => std::fs::remove_file(path).unwrap(),
        }
    }
}

/// Runs of one thread until `next` is `runs`; how many there were of each way.
fn handle(thread: u64, right: &[u32], next: &AtomicU64, end: &dyn Fn(u64) -> bool) -> [u64; 10] {
    let folder = super::folder();
    let disk = SmallDisk::mount(&folder.path().join("disk"), "16k");
    let mut bench = Bench {
        folder: folder.path(),
        right,
        has_disk: disk.is_some(),
        random: thread << 32,
    };
    let mut counts = [0; 10];
    loop {
        let run = next.fetch_add(1, Ordering::Relaxed);
        if end(run) {
            break;
        }
        let way = bench.below(WAYS.len() as u64) as usize;
        WAYS[way].1(&mut bench);
        counts[way] += 1;
        clear(folder.path());
    }
    let (code, said) = bench.render(&["-o", "a.exr"]);
    assert_eq!(code, Some(0), "{said}");
    let left = std::fs::read_dir(folder.path()).unwrap();
    let left = left.map(|e| e.unwrap().file_name().into_string().unwrap());
    let left: Vec<_> = left.filter(|name| name.starts_with('.')).collect();
    assert!(left.is_empty(), "left by killed runs: {left:?}");
    drop(disk);
    counts
}

#[test]
fn no_image_is_lost_and_no_input_changed() {
    let asked = std::env::var("DIREKT_ROUGH_RUNS").ok();
    let asked = asked.map(|n| n.parse().expect("DIREKT_ROUGH_RUNS is a number"));
    let runs: u64 = asked.unwrap_or(RUNS);
    let folder = super::folder();
    let mut command = direkt_in(folder.path());
    let first = command
        .args(["render", "s.toml", "-q", "-o", "a.exr"])
        .status();
    assert!(first.unwrap().success());
    let right = colours(&folder.path().join("a.exr"));
    let (next, start) = (AtomicU64::new(0), Instant::now());
    let end = |run: u64| run >= runs || (asked.is_none() && start.elapsed() > LIMIT);
    let counts: Vec<[u64; 10]> = std::thread::scope(|scope| {
        let handled = (0..THREADS).map(|thread| {
            let (right, next, end) = (&right, &next, &end);
            scope.spawn(move || handle(thread, right, next, end))
        });
        let handled: Vec<_> = handled.collect();
        handled.into_iter().map(|h| h.join().unwrap()).collect()
    });
    let mut of_way = BTreeMap::new();
    for (way, (name, _)) in WAYS.iter().enumerate() {
        of_way.insert(name, counts.iter().map(|c| c[way]).sum::<u64>());
    }
    let done: u64 = of_way.values().sum();
    if done < runs || asked.is_some() {
        say(&format!(
            "{done} of {runs} runs handled roughly in {:.0} s: {of_way:?}\n",
            start.elapsed().as_secs_f64()
        ));
    }
    assert!(done > 0, "none in {LIMIT:?}");
}
