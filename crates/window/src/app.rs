//! The window's own thread: what is on screen, and what is asked for.

use super::curve::Runs;
use super::files::saved_name;
use super::latency::Latency;
use super::lights::Lights;
use super::mailbox::{Mailbox, RenderStatus};
use super::navigation::CameraController;
use super::picture::{Inspected, Picture};
use super::request::{Layer, MAX_VIEWS, Method, Pacing, RenderRequest, VIEW_NAMES};
use super::watch::Watch;
use super::{Options, canvas, panels, renderer};
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

/// The scene that is open.
pub(super) struct OpenScene {
    /// As its file has it.
    pub(super) file: Arc<Scene>,
    /// The same with its lights switched.
    pub(super) shown: Arc<Scene>,
    pub(super) lights: Lights,
}

/// Where the camera is.
pub(super) struct Navigation {
    pub(super) controller: CameraController,
    /// Whether the camera is where the file has it.
    pub(super) at_home: bool,
    /// When it, or the size of the image, changed last.
    moved: Option<Instant>,
}

/// How two views are compared.
pub(super) struct ViewComparison {
    /// The view whose method the controls change.
    pub(super) edited: usize,
    pub(super) pacing: Pacing,
    pub(super) screen: Screen,
    /// Where the first view ends on screen, in parts of its width.
    pub(super) split: f32,
}

/// What of the image is shown, and how.
pub(super) struct DisplayState {
    pub(super) layer: Layer,
    pub(super) mapping: Display,
    /// Whether the controls are on screen.
    pub(super) panel: bool,
}

/// What is asked about.
#[derive(Default)]
pub(super) struct Inspection {
    /// The point, in fractions of the image's width and height.
    pub(super) at: Option<[f64; 2]>,
    /// Whether the camera is focused on it.
    pub(super) focusing: bool,
    /// Pictures of the densities there, and whose they are.
    pub(super) densities: Option<(Arc<Inspected>, Vec<[egui::TextureHandle; 2]>)>,
}

/// The window.
pub struct App {
    pub(super) options: Options,
    pub(super) mailbox: Arc<Mailbox>,
    render_thread: Option<JoinHandle<()>>,
    pub(super) scene: OpenScene,
    pub(super) navigation: Navigation,
    pub(super) film: FilmSize,
    pub(super) methods: Vec<Method>,
    pub(super) comparison: ViewComparison,
    pub(super) display: DisplayState,
    pub(super) paused: bool,
    pub(super) inspection: Inspection,
    pub(super) status: RenderStatus,
    pub(super) textures: [Option<egui::TextureHandle>; MAX_VIEWS],
    pub(super) runs: Runs,
    pub(super) note: Option<Note>,
    pub(super) saving: String,
    pub(super) watch: Watch,
    posted: Option<RenderRequest>,
    latency: Latency,
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
            latency: Latency::new(options.verbose),
            options,
            mailbox,
            render_thread: started.ok(),
            navigation: Navigation {
                controller: CameraController::of(&scene.camera, bounds(&scene.shapes)),
                at_home: true,
                moved: None,
            },
            scene: OpenScene {
                lights: Lights::of(&scene),
                file: Arc::clone(&scene),
                shown: scene,
            },
            film,
            methods: vec![method],
            comparison: ViewComparison {
                edited: 0,
                pacing: Pacing::default(),
                screen: Screen::Split,
                split: 0.5,
            },
            display: DisplayState {
                layer: Layer::default(),
                mapping: Display::default(),
                panel: true,
            },
            paused: false,
            inspection: Inspection::default(),
            status: RenderStatus::default(),
            textures: Default::default(),
            runs: Runs::default(),
            note,
            posted: None,
            title: String::new(),
        }
    }

    /// The view whose method the controls change: that which was chosen, as long as it is there.
    pub(super) fn edited_view(&self) -> usize {
        self.comparison.edited.min(self.methods.len() - 1)
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
        let moved = if self.navigation.at_home {
            None
        } else {
            self.navigation.controller.camera()
        };
        moved.unwrap_or(self.scene.file.camera)
    }

    /// Moves the camera.
    pub(super) fn navigate(&mut self, change: impl FnOnce(&mut CameraController)) {
        let before = self.navigation.controller;
        change(&mut self.navigation.controller);
        if self.navigation.controller.camera().is_none() {
            self.navigation.controller = before;
        }
        if self.navigation.controller != before {
            self.navigation.at_home = false;
            self.inspection.at = None;
            self.navigation.moved = Some(Instant::now());
        }
    }

    /// Moves the camera to where the file has it.
    pub(super) fn go_home(&mut self) {
        self.navigation.controller =
            CameraController::of(&self.scene.file.camera, bounds(&self.scene.file.shapes));
        self.navigation.at_home = true;
        self.inspection.at = None;
        self.navigation.moved = Some(Instant::now());
    }

    /// Looks at what was asked about, or at everything.
    pub(super) fn frame_selection(&mut self) {
        let inspected = self.status.inspected.as_ref();
        let surface = inspected.and_then(|i| i.surface.as_ref());
        let around = surface
            .map(|s| s.bounds)
            .or_else(|| bounds(&self.scene.file.shapes));
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
            self.navigation.moved = Some(Instant::now());
        }
    }

    /// Applies the switches of the lights.
    pub(super) fn switch_lights(&mut self) {
        self.scene.shown = if self.scene.lights.are_as_in_file() {
            Arc::clone(&self.scene.file)
        } else {
            let mut scene = Scene::clone(&self.scene.file);
            self.scene.lights.apply(&mut scene);
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
            self.latency.answered(picture.version);
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

    /// Makes sharp what was asked about for that.
    fn focus(&mut self) {
        let inspected = self.status.inspected.as_ref();
        let answer =
            inspected.filter(|i| self.inspection.focusing && Some(i.at) == self.inspection.at);
        let Some(answer) = answer.cloned() else {
            return;
        };
        self.inspection.focusing = false;
        if let Some(surface) = &answer.surface {
            self.navigate(|controller| controller.lens.focus_distance = surface.depth);
            self.inspection.at = Some(answer.at);
        }
    }

    /// Posts what is asked for, if that has changed.
    fn post(&mut self, context: &egui::Context) {
        let settled = self
            .navigation
            .moved
            .map(|at| SETTLE.saturating_sub(at.elapsed()));
        let moving = settled.is_some_and(|left| !left.is_zero());
        if let Some(left) = settled.filter(|_| moving) {
            context.request_repaint_after(left);
        } else {
            self.navigation.moved = None;
        }
        let request = RenderRequest {
            scene: Arc::clone(&self.scene.shown),
            camera: self.camera(),
            film: self.film,
            methods: self.methods.clone(),
            pacing: self.comparison.pacing,
            layer: self.display.layer,
            display: self.display.mapping,
            moving,
            paused: self.paused,
            inspected: self.inspection.at,
        };
        if self.posted.as_ref().is_some_and(|old| old.is(&request)) {
            return;
        }
        let version = self.mailbox.post(request.clone());
        self.latency.posted(version, moving);
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
        if self.display.panel {
            egui::Panel::right("controls")
                .exact_size(panels::WIDTH)
                .show(ui, |ui| panels::show(self, ui));
        }
        egui::CentralPanel::no_frame().show(ui, |ui| canvas::show(self, ui));
        self.post(&context);
        self.retitle(&context);
        self.latency.count_frame();
    }

    fn on_exit(&mut self) {
        self.mailbox.quit();
        if let Some(renderer) = self.render_thread.take() {
            // A renderer that panicked has said so itself.
            let _ = renderer.join();
        }
    }
}

/// What another thread calls when there is something new to show.
pub(super) fn waker(context: &egui::Context) -> impl Fn() + Send + Sync + 'static {
    let context = context.clone();
    move || context.request_repaint()
}
