//! Files that the window opens, reads again and saves.

use super::app::{App, Note, Screen};
use super::lights::Lights;
use super::request::Method;
use super::save;
use direkt::error::Error;
use direkt::low_level::console::say;
use direkt::low_level::output::{Destination, Identity};
use direkt::scene::load::load_with_files;
use eframe::egui;
use std::path::{Path, PathBuf};
use std::sync::Arc;

impl App {
    /// Opens another scene, or the same one again, which keeps camera, methods and lights as far as
    /// it can.
    pub(super) fn open(&mut self, path: &Path) {
        let (scene, files) = load_with_files(path, &self.options.load);
        let another = path != self.options.path;
        let scene = match scene {
            Ok(scene) => scene,
            Err(error) => {
                if !another {
                    self.options.files.extend(files);
                    self.watch.follow(self.options.files.clone());
                }
                self.say(Note::Problem(error.to_string()));
                return;
            }
        };
        self.watch.follow(files.clone());
        self.options.files = files;
        let lights = Lights::of(&scene);
        let names = |lights: &Lights| lights.0.iter().map(|l| l.name.clone()).collect::<Vec<_>>();
        if another || names(&lights) != names(&self.scene.lights) {
            self.scene.lights = lights;
        }
        if another {
            self.options.path = path.to_path_buf();
            self.saving = saved_name(path);
            self.comparison.screen = Screen::Split;
            self.comparison.edited = 0;
        }
        if another || scene.render != self.scene.file.render {
            self.methods = vec![Method {
                settings: scene.render,
                forced: Vec::new(),
            }];
        }
        self.scene.file = Arc::new(scene);
        self.switch_lights();
        if another || self.navigation.at_home {
            self.go_home();
        }
        let done = if another { "opened" } else { "read again" };
        self.say(Note::Done(format!("{}: {done}", path.display())));
    }

    /// The file that the image is saved to.
    pub(super) fn image_name(&self) -> PathBuf {
        PathBuf::from(&self.saving)
    }

    /// The file that the scene is saved to: beside the one that was opened, whose files it names.
    pub(super) fn scene_name(&self) -> PathBuf {
        let stem = self.options.path.file_stem().unwrap_or_default();
        let name = format!("{}_view.toml", stem.to_string_lossy());
        self.options.path.with_file_name(name)
    }

    /// Says something below the controls' head.
    pub(super) fn say(&mut self, note: Note) {
        if self.options.verbose {
            let (Note::Done(text) | Note::Problem(text)) = &note;
            say(format_args!("direkt: {text}"));
        }
        self.note = Some(note);
    }

    /// Saves the image on screen, or the scene, by the extension of the name.
    pub(super) fn save(&mut self, path: &Path) {
        let saved = match direkt::low_level::image::extension(path).as_str() {
            _ if !self.may_replace(path) => Err(Error::Usage(format!(
                "{}: is a device, or a file that the scene reads; name another",
                path.display()
            ))),
            "toml" => save::scene(path, &self.options.path, &self.changes()),
            _ => self.save_image(path),
        };
        self.say(match saved {
            Ok(()) => Note::Done(format!("{}: saved", path.display())),
            Err(error) => Note::Problem(error.to_string()),
        });
    }

    /// Whether `path` is neither a device nor one of the files that the scene was read from.
    fn may_replace(&self, path: &Path) -> bool {
        match Identity::of(path) {
            // What is wrong with its name is said when it is written.
            None => Destination::of(path).is_err(),
            Some(identity) => {
                let mut files = self.options.files.iter().filter_map(|f| Identity::of(f));
                !files.any(|file| file.is_same(&identity))
            }
        }
    }

    fn shown_view(&self) -> usize {
        match self.comparison.screen {
            Screen::One(index) if index < self.methods.len() => index,
            _ => self.edited_view(),
        }
    }

    fn save_image(&self, path: &Path) -> Result<(), Error> {
        let picture = self.status.pictures[self.shown_view()].as_ref();
        let picture = picture
            .filter(|p| p.full)
            .ok_or_else(|| Error::Usage(format!("{}: there is no image yet", path.display())))?;
        save::image(path, picture, &self.options.path, &self.display.mapping)
    }

    /// What the scene on screen has that its file has not.
    fn changes(&self) -> save::Changes<'_> {
        let view = self.shown_view();
        let mut settings = self.methods[view].settings;
        if let Some(picture) = &self.status.pictures[view] {
            settings.stop.spp = picture.samples.max(1);
        }
        save::Changes {
            lights: &self.scene.lights,
            controller: (!self.navigation.at_home).then_some(self.navigation.controller),
            film: self.film,
            settings,
        }
    }

    /// Reads the scene again where it, or a shader, has changed; for a scene read anew all is
    /// compiled anew.
    pub(super) fn reload(&mut self) {
        if self.watch.has_changed() {
            let path = self.options.path.clone();
            self.open(&path);
        }
    }

    /// Opens a scene that was dropped on the window.
    pub(super) fn take_dropped(&mut self, context: &egui::Context) {
        let dropped: Vec<PathBuf> = context.input(|input| {
            let files = input.raw.dropped_files.iter();
            files.map(|file| file.path().to_path_buf()).collect()
        });
        if let Some(path) = dropped.last() {
            self.open(path);
        }
    }
}

/// Name under which an image is saved unless another is given.
pub(super) fn saved_name(scene: &Path) -> String {
    let stem = scene.file_stem().unwrap_or_default().to_string_lossy();
    format!("{stem}.exr")
}
