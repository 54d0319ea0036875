//! The window's own thread: what is on screen, and what is asked for.

use super::curve::Runs;
use super::files::saved_name;
use super::lights::Lights;
use super::mailbox::{Mailbox, RenderStatus};
use super::navigation::CameraController;
use super::picture::{Inspected, Picture};
use super::request::{Layer, MAX_VIEWS, Method, Pacing, RenderRequest, VIEW_NAMES};
use super::watch::Watch;
use super::{Options, canvas, panels, renderer};
use direkt::low_level::console::say;
use direkt::low_level::image::png::Display;
use direkt::scene::normalize::bounds;
use direkt::scene::{Camera, FilmSize, Scene};
use eframe::egui;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// How long the camera counts as moving after it has stopped.
const SETTLE: Duration = Duration::from_millis(150);

/// Which of two views is on screen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Screen {
    /// Both, side by side.
    Split,
    /// One, by its index.
    One(usize),
}

/// What the window says below its controls.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Note {
    /// Something was done.
    Done(String),
    /// Something could not be done.
    Problem(String),
}

/// The window.
pub struct App {
    pub(super) options: Options,
    pub(super) mailbox: Arc<Mailbox>,
    renderer: Option<JoinHandle<()>>,
    /// The scene as its file has it.
    pub(super) file: Arc<Scene>,
    /// The same with its lights switched.
    pub(super) scene: Arc<Scene>,
    pub(super) lights: Lights,
    pub(super) controller: CameraController,
    /// Whether the camera is where the file has it.
    pub(super) at_home: bool,
    pub(super) film: FilmSize,
    pub(super) methods: Vec<Method>,
    /// The view whose method the controls change.
    pub(super) edited: usize,
    pub(super) pacing: Pacing,
    pub(super) layer: Layer,
    pub(super) display: Display,
    pub(super) paused: bool,
    pub(super) inspected: Option<[f64; 2]>,
    /// Whether what is asked about becomes sharp.
    pub(super) focusing: bool,
    pub(super) status: RenderStatus,
    /// Pictures of the densities where was clicked, and whose they are.
    pub(super) densities: Option<(Arc<Inspected>, Vec<[egui::TextureHandle; 2]>)>,
    pub(super) textures: [Option<egui::TextureHandle>; MAX_VIEWS],
    pub(super) runs: Runs,
    pub(super) screen: Screen,
    /// Where the first view ends on screen, in parts of its width.
    pub(super) split: f32,
    pub(super) panel: bool,
    pub(super) note: Option<Note>,
    pub(super) saving: String,
    pub(super) watch: Watch,
    moved: Option<Instant>,
    posted: Option<RenderRequest>,
    /// When requests were posted that have no picture yet.
    waiting: Vec<Waiting>,
    /// Frames drawn, since when.
    frames: (u32, Instant),
    title: String,
}

impl App {
    /// A window on `scene`.
    pub fn new(creation: &eframe::CreationContext<'_>, scene: Scene, options: Options) -> Self {
        let mailbox = Arc::new(Mailbox::new(waker(&creation.egui_ctx)));
        let started = renderer::start(Arc::clone(&mailbox), options.adapter.clone());
        let note = started.as_ref().err();
        let note = note.map(|e| Note::Problem(format!("no thread can be started: {e}")));
        let [width, height] = options.size;
        let film = FilmSize { width, height };
        let method = Method {
            settings: scene.render,
            forced: Vec::new(),
        };
        let scene = Arc::new(scene);
        Self {
            watch: Watch::new(options.files.clone(), waker(&creation.egui_ctx)),
            saving: saved_name(&options.path),
            options,
            mailbox,
            renderer: started.ok(),
            lights: Lights::of(&scene),
            controller: CameraController::of(&scene.camera, bounds(&scene.shapes)),
            file: Arc::clone(&scene),
            scene,
            at_home: true,
            film,
            methods: vec![method],
            edited: 0,
            pacing: Pacing::default(),
            layer: Layer::default(),
            display: Display::default(),
            paused: false,
            inspected: None,
            focusing: false,
            status: RenderStatus::default(),
            densities: None,
            textures: Default::default(),
            runs: Runs::default(),
            screen: Screen::Split,
            split: 0.5,
            panel: true,
            note,
            moved: None,
            posted: None,
            waiting: Vec::new(),
            frames: (0, Instant::now()),
            title: String::new(),
        }
    }

    /// The view whose method the controls change: that which was chosen, as long as it is there.
    pub(super) fn edited_view(&self) -> usize {
        self.edited.min(self.methods.len() - 1)
    }

    /// The newest pictures, with the names of their views where there are two.
    pub(super) fn pictures(&self) -> impl Iterator<Item = (&'static str, &Picture)> {
        let compared = self.methods.len() > 1;
        let pictures = self.status.pictures.iter().zip(VIEW_NAMES);
        pictures.filter_map(move |(picture, name)| {
            let name = if compared { name } else { "" };
            Some((name, &**picture.as_ref()?))
        })
    }

    /// The camera as it stands.
    pub(super) fn camera(&self) -> Camera {
        let moved = if self.at_home {
            None
        } else {
            self.controller.camera()
        };
        moved.unwrap_or(self.file.camera)
    }

    /// Moves the camera.
    pub(super) fn navigate(&mut self, change: impl FnOnce(&mut CameraController)) {
        let before = self.controller;
        change(&mut self.controller);
        if self.controller.camera().is_none() {
            self.controller = before;
        }
        if self.controller != before {
            self.at_home = false;
            self.inspected = None;
            self.moved = Some(Instant::now());
        }
    }

    /// Moves the camera to where the file has it.
    pub(super) fn go_home(&mut self) {
        self.controller = CameraController::of(&self.file.camera, bounds(&self.file.shapes));
        self.at_home = true;
        self.inspected = None;
        self.moved = Some(Instant::now());
    }

    /// Looks at what was asked about, or at everything.
    pub(super) fn frame_selection(&mut self) {
        let inspected = self.status.inspected.as_ref();
        let surface = inspected.and_then(|i| i.surface.as_ref());
        let around = surface
            .map(|s| s.bounds)
            .or_else(|| bounds(&self.file.shapes));
        let aspect = self.film.aspect();
        if let Some(around) = around {
            self.navigate(|controller| controller.frame(around, aspect));
        }
    }

    /// Makes the image as large as the place for it.
    pub(super) fn resize(&mut self, [width, height]: [f32; 2]) {
        let side = |length: f32| (length.round() as u32).clamp(1, FilmSize::MAX_SIDE);
        let film = FilmSize {
            width: side(width),
            height: side(height),
        };
        if film != self.film {
            self.film = film;
            self.moved = Some(Instant::now());
        }
    }

    /// Applies the switches of the lights.
    pub(super) fn switch_lights(&mut self) {
        self.scene = if self.lights.are_as_in_file() {
            Arc::clone(&self.file)
        } else {
            let mut scene = Scene::clone(&self.file);
            self.lights.apply(&mut scene);
            Arc::new(scene)
        };
    }

    /// Takes what the renderer has posted.
    fn take_status(&mut self, context: &egui::Context) {
        let status = self.mailbox.status();
        for (index, picture) in status.pictures.iter().enumerate() {
            let Some(picture) = picture else {
                self.textures[index] = None;
                continue;
            };
            let known = self.status.pictures[index].as_ref();
            if known.is_some_and(|known| Arc::ptr_eq(known, picture)) {
                continue;
            }
            self.answered(picture.version);
            self.runs.enter(picture);
            let image = Arc::clone(&picture.colours);
            let options = if picture.full {
                egui::TextureOptions::NEAREST
            } else {
                egui::TextureOptions::LINEAR
            };
            match &mut self.textures[index] {
                Some(texture) => texture.set(image, options),
                None => {
                    let name = format!("view {index}");
                    self.textures[index] = Some(context.load_texture(name, image, options));
                }
            }
        }
        self.status = status;
        self.focus();
    }

    /// Tells how long the request `version` waited for its first picture.
    fn answered(&mut self, version: u64) {
        let answered = |posted: &Waiting| posted.version <= version;
        let last = self.waiting.iter().rfind(|p| answered(p)).copied();
        self.waiting.retain(|p| !answered(p));
        if let Some(request) = last.filter(|_| self.options.verbose) {
            let milliseconds = request.posted.elapsed().as_secs_f64() * 1e3;
            let (version, kind) = (
                request.version,
                if request.moving { "moving" } else { "at rest" },
            );
            say(format_args!(
                "direkt: request {version}, {kind}: first picture after {milliseconds:.1} ms"
            ));
        }
    }

    /// Tells about every second how many frames were drawn.
    fn count_frame(&mut self) {
        let (frames, since) = &mut self.frames;
        *frames += 1;
        let seconds = since.elapsed().as_secs_f64();
        if seconds >= 1.0 {
            if self.options.verbose {
                say(format_args!("direkt: {frames} frames in {seconds:.2} s"));
            }
            self.frames = (0, Instant::now());
        }
    }

    /// Makes sharp what was asked about for that.
    fn focus(&mut self) {
        let inspected = self.status.inspected.as_ref();
        let answer = inspected.filter(|i| self.focusing && Some(i.at) == self.inspected);
        let Some(answer) = answer.cloned() else {
            return;
        };
        self.focusing = false;
        if let Some(surface) = &answer.surface {
            self.navigate(|controller| controller.lens.focus_distance = surface.depth);
            self.inspected = Some(answer.at);
        }
    }

    /// Posts what is asked for, if that has changed.
    fn post(&mut self, context: &egui::Context) {
        let settled = self.moved.map(|at| SETTLE.saturating_sub(at.elapsed()));
        let moving = settled.is_some_and(|left| !left.is_zero());
        if let Some(left) = settled.filter(|_| moving) {
            context.request_repaint_after(left);
        } else {
            self.moved = None;
        }
        let request = RenderRequest {
            scene: Arc::clone(&self.scene),
            camera: self.camera(),
            film: self.film,
            methods: self.methods.clone(),
            pacing: self.pacing,
            layer: self.layer,
            display: self.display,
            moving,
            paused: self.paused,
            inspected: self.inspected,
        };
        if self.posted.as_ref().is_some_and(|old| old.is(&request)) {
            return;
        }
        let version = self.mailbox.post(request.clone());
        self.waiting.push(Waiting {
            version,
            posted: Instant::now(),
            moving,
        });
        self.posted = Some(request);
    }

    fn retitle(&mut self, context: &egui::Context) {
        let name = self.options.path.file_name().unwrap_or_default();
        let samples = self.status.pictures[0].as_ref().map_or(0, |p| p.samples);
        let title = format!("{} — {samples} samples — direkt", name.to_string_lossy());
        if title != self.title {
            self.title.clone_from(&title);
            context.send_viewport_cmd(egui::ViewportCommand::Title(title));
        }
    }
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        let context = ui.ctx().clone();
        self.take_status(&context);
        self.reload();
        self.take_dropped(&context);
        canvas::shortcuts(self, &context);
        if self.panel {
            egui::Panel::right("controls")
                .exact_size(panels::WIDTH)
                .show(ui, |ui| panels::show(self, ui));
        }
        egui::CentralPanel::no_frame().show(ui, |ui| canvas::show(self, ui));
        self.post(&context);
        self.retitle(&context);
        self.count_frame();
    }

    fn on_exit(&mut self) {
        self.mailbox.quit();
        if let Some(renderer) = self.renderer.take() {
            // A renderer that panicked has said so itself.
            let _ = renderer.join();
        }
    }
}

/// A request without a picture yet.
#[derive(Debug, Clone, Copy)]
struct Waiting {
    version: u64,
    posted: Instant,
    /// Whether the camera moves.
    moving: bool,
}

/// What another thread calls when there is something new to show.
pub(super) fn waker(context: &egui::Context) -> impl Fn() + Send + Sync + 'static {
    let context = context.clone();
    move || context.request_repaint()
}
