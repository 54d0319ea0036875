//! The preview window, by a user in front of an X server without a screen.

use crate::support::display::{Display, pause, wait};
use crate::support::project;
use image::RgbImage;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};

const PANEL: u32 = 340;
const SIZE: (u32, u32) = (240, 180);
const CONTROL_L: u32 = 0xffe3;
const SHIFT_L: u32 = 0xffe1;

/// An open window.
struct Preview {
    display: Display,
    child: Child,
    window: u32,
    said: Arc<Mutex<Vec<String>>>,
    folder: tempfile::TempDir,
}

impl Preview {
    /// Opens a copy of a scene of the project.
    fn open(scene: &str, flags: &[&str]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let name = Path::new(scene).file_name().unwrap();
        let copy = folder.path().join(name);
        std::fs::copy(project(scene), &copy).unwrap();
        let display = Display::start(SIZE.0 + PANEL, 700);
        let size = format!("{}x{}", SIZE.0, SIZE.1);
        let mut child = Command::new(env!("CARGO_BIN_EXE_direkt"))
            .args(["preview", "--verbose", "--size", &size])
            .arg(&copy)
            .args(flags)
            .current_dir(folder.path())
            .env("DISPLAY", &display.name)
            .env_remove("WAYLAND_DISPLAY")
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let said = Arc::<Mutex<Vec<String>>>::default();
        let lines = BufReader::new(child.stderr.take().unwrap()).lines();
        let to = Arc::clone(&said);
        std::thread::spawn(move || {
            for line in lines.map_while(Result::ok) {
                to.lock().unwrap().push(line);
            }
        });
        let window = display.wait_for_window("— direkt");
        display.focus(window);
        let preview = Self {
            display,
            child,
            window,
            said,
            folder,
        };
        preview.wait_for_samples(1);
        preview
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Samples of the first view, as the title tells.
    fn samples(&self) -> u64 {
        let title = self.display.title(self.window);
        let words: Vec<_> = title.split(" — ").collect();
        let samples = words.get(1).and_then(|w| w.strip_suffix(" samples"));
        samples.and_then(|s| s.parse().ok()).unwrap_or(0)
    }

    fn wait_for_samples(&self, least: u64) -> u64 {
        let enough = || Some(self.samples()).filter(|s| *s >= least);
        wait(&format!("{least} samples"), enough)
    }

    /// Waits until something is said that contains `text`, after the first `from` lines.
    fn wait_for(&self, from: usize, text: &str) -> String {
        wait(&format!("`{text}` in {:?}", self.said()), || {
            let said = self.said();
            said.into_iter().skip(from).find(|line| line.contains(text))
        })
    }

    fn said(&self) -> Vec<String> {
        self.said.lock().unwrap().clone()
    }

    /// The image, without the controls.
    fn image(&self) -> RgbImage {
        let screen = self.display.capture();
        image::imageops::crop_imm(&screen, 0, 0, SIZE.0, SIZE.1).to_image()
    }

    /// Waits until there are no more samples.
    fn wait_for_standstill(&self) {
        wait("a standstill", || {
            let before = self.samples();
            pause(1000);
            Some(()).filter(|()| before == self.samples())
        });
    }

    /// Waits until the image `is` what is looked for.
    fn wait_for_image(&self, what: &str, is: impl Fn(&RgbImage) -> bool) {
        wait(what, || Some(()).filter(|()| is(&self.image())));
    }

    /// The image ends where the panel begins.
    fn assert_panel(&self) {
        let screen = self.display.capture();
        for y in (0..SIZE.1).step_by(10) {
            let [r, g, b] = screen.get_pixel(SIZE.0 + 4, y).0;
            assert!(r < 64 && r == g && g == b, "row {y}: {r}, {g}, {b}");
        }
    }

    /// Keeps a picture of the screen in the folder that `DIREKT_SCREENSHOTS` names.
    fn keep(&self, name: &str) {
        if let Some(folder) = std::env::var_os("DIREKT_SCREENSHOTS") {
            let path = PathBuf::from(folder).join(format!("{name}.png"));
            self.display.capture().save(path).unwrap();
        }
    }

    fn save(&self, name: &str) {
        let from = self.said().len();
        let shift = if name.ends_with(".toml") {
            Some(SHIFT_L)
        } else {
            None
        };
        self.display
            .chord(&[Some(CONTROL_L), shift], u32::from('s'));
        self.wait_for(from, &format!("{name}: saved"));
    }

    /// Closes the window and looks at how it ended.
    fn close(mut self) {
        self.display.ask_to_close(self.window);
        let status = wait("the end", || self.child.try_wait().unwrap());
        assert!(status.success(), "{status}: {:?}", self.said());
        let said = self.said();
        assert!(
            !said.iter().any(|line| line.contains("panicked")),
            "{said:?}"
        );
    }
}

impl Drop for Preview {
    fn drop(&mut self) {
        // It has ended, unless a test failed.
        let _ = self.child.kill();
    }
}

/// Part of the pixels that differ by more than a little.
fn changed(a: &RgbImage, b: &RgbImage) -> f64 {
    let pixels = a.pixels().zip(b.pixels());
    let differ = pixels.filter(|(a, b)| a.0.iter().zip(b.0).any(|(x, y)| x.abs_diff(y) > 24));
    differ.count() as f64 / f64::from(a.width() * a.height())
}

#[test]
fn what_is_saved_is_what_render_gives() {
    assert_saved_as_rendered(&["--seed", "3"]);
}

#[test]
fn so_it_is_where_sampling_is_adaptive() {
    assert_saved_as_rendered(&["--seed", "4", "--adaptive"]);
}

fn assert_saved_as_rendered(flags: &[&str]) {
    let preview = Preview::open("scenes/cornell.toml", flags);
    preview.display.drag(1, (120, 90), (150, 100));
    preview.wait_for_samples(64);
    preview.display.key(u32::from(' '));
    preview.wait_for_standstill();
    preview.save("cornell.exr");
    preview.save("cornell_view.toml");
    let output = Command::new(env!("CARGO_BIN_EXE_direkt"))
        .args(["render", "cornell_view.toml", "-o", "again.exr", "-q"])
        .current_dir(preview.folder.path())
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");
    let read =
        |name: &str| exr::prelude::read_first_flat_layer_from_file(preview.path(name)).unwrap();
    let (saved, again) = (read("cornell.exr"), read("again.exr"));
    assert_eq!(saved.layer_data.size, again.layer_data.size);
    assert_eq!(saved.layer_data.channel_data, again.layer_data.channel_data);
    preview.close();
}

#[test]
fn a_window_is_driven_by_pointer_and_keys() {
    let preview = Preview::open("scenes/veach.toml", &[]);
    let display = &preview.display;
    preview.wait_for_samples(64);
    let first = preview.image();
    preview.keep("open");
    display.drag(1, (120, 90), (200, 120));
    preview.wait_for_image("an orbit", |image| changed(&first, image) > 0.1);
    display.key(u32::from('r'));
    preview.wait_for_image("the camera's return", |image| changed(&first, image) < 0.1);
    display.key(u32::from(']'));
    display.key(u32::from('c'));
    let back = preview.image();
    preview.wait_for_image("captions of a split view", |image| {
        changed(&back, image) > 0.02
    });
    let split = preview.image();
    preview.keep("compare");
    preview.assert_panel();
    display.key(u32::from('2'));
    preview.wait_for_image("standard errors", |image| changed(&split, image) > 0.3);
    preview.keep("standard-error");
    display.resize(preview.window, 1, 1);
    pause(500);
    display.resize(preview.window, SIZE.0 + PANEL, 700);
    preview.wait_for_image("standard errors again", |image| {
        changed(&split, image) > 0.3
    });
    preview.close();
}

#[test]
fn files_are_read_again_and_dropped_ones_opened() {
    let preview = Preview::open("scenes/cornell.toml", &[]);
    preview.wait_for_samples(64);
    let path = preview.path("cornell.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    let from = preview.said().len();
    let last_good = preview.image();
    std::fs::write(&path, text.replace("fov = 39.3077", "fov = -1")).unwrap();
    let problem = preview.wait_for(from, "camera.fov");
    assert!(problem.contains("is -1"), "{problem}");
    pause(300);
    preview.keep("problem");
    assert!(
        changed(&last_good, &preview.image()) < 0.1,
        "the last good image stays"
    );
    std::fs::write(&path, text.replace("fov = 39.3077", "fov = 20")).unwrap();
    preview.wait_for(from, "read again");
    preview.wait_for_image("a narrower view", |image| changed(&last_good, image) > 0.1);
    let closer = preview.image();
    let dropped = project("scenes/veach.toml");
    preview.display.drop_file(preview.window, &dropped);
    preview.wait_for(from, "opened");
    preview.wait_for_image("the other scene", |image| changed(&closer, image) > 0.3);
    let title = preview.display.title(preview.window);
    assert!(title.starts_with("veach.toml"), "{title}");
    preview.close();
}

#[test]
fn random_input_does_no_harm() {
    let seconds = std::env::var("DIREKT_MONKEY_SECONDS");
    let seconds = seconds.map_or(8, |s| s.parse().expect("a number of seconds"));
    let preview = Preview::open("scenes/cornell.toml", &[]);
    let mut random = crate::support::random::Random::new(5);
    let mut below = |n: i16| (random.uniform() * f64::from(n)) as i16;
    let end = std::time::Instant::now() + std::time::Duration::from_secs(seconds);
    let (width, height) = ((SIZE.0 + PANEL) as i16, 690);
    while std::time::Instant::now() < end {
        let at = (below(width), below(height));
        match below(8) {
            0..=2 => preview.display.click(at),
            3 => preview.display.drag(1, at, (below(width), below(height))),
            4 => preview.display.drag(3, at, (below(width), below(height))),
            5 => {
                preview.display.point(at);
                let wheel = 4 + below(2) as u8;
                preview.display.button(wheel, true);
                preview.display.button(wheel, false);
            }
            6 => {
                let keys = b"frxchwasdqe1234[] ";
                let key = keys[below(keys.len() as i16) as usize];
                preview.display.key(u32::from(key));
            }
            _ => {
                let side = |n: i16| u32::try_from(n).unwrap_or(1).max(1);
                let size = (side(below(width)), side(below(height)));
                preview.display.resize(preview.window, size.0, size.1);
                pause(50);
                preview.display.resize(preview.window, SIZE.0 + PANEL, 700);
            }
        }
    }
    preview.close();
}

#[test]
fn without_a_display_one_sentence_names_render() {
    let output = Command::new(env!("CARGO_BIN_EXE_direkt"))
        .args(["preview", "scenes/cornell.toml"])
        .current_dir(project("."))
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .output()
        .unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert_eq!(said.lines().count(), 1, "{said}");
    assert!(said.contains("direkt render scenes/cornell.toml"), "{said}");
}
