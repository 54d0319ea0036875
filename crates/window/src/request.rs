//! What the window asks the renderer for.

use direkt::low_level::effects::Effect;
use direkt::low_level::image::png::Display;
use direkt::scene::{Camera, FilmSize, RenderSettings, Scene};
use std::sync::Arc;

/// Views at most: an image, or two that are compared.
pub const MAX_VIEWS: usize = 2;
/// What they are called where there are two.
pub const VIEW_NAMES: [&str; MAX_VIEWS] = ["A", "B"];

/// How an image is rendered.
#[derive(Debug, Clone, PartialEq)]
pub struct Method {
    /// Strategy, sampler and all else that the table `[render]` holds.
    pub settings: RenderSettings,
    /// Effects that are compiled in though nothing calls for them.
    pub forced: Vec<Effect>,
}

/// Whose turn it is where two views render.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Pacing {
    /// That of the one which has rendered for less time.
    #[default]
    EqualTime,
    /// That of the one which has fewer samples.
    EqualSamples,
}

/// What of the image is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Layer {
    /// Radiance, through the tone mapper.
    #[default]
    Radiance,
    /// The standard error of each pixel over its value, as a colour.
    StandardError,
    /// The first view minus the second over their mean, from blue to red.
    Difference,
    /// How many samples pixels have, as a colour: what adaptive sampling does.
    Samples,
}

impl Layer {
    /// All of them, with their names.
    pub const ALL: [(Self, &'static str); 4] = [
        (Self::Radiance, "radiance"),
        (Self::StandardError, "standard error"),
        (Self::Difference, "difference"),
        (Self::Samples, "samples"),
    ];
}

/// All that decides what is rendered and shown.
#[derive(Debug, Clone)]
pub struct RenderRequest {
    /// The scene; its camera, size and settings are replaced by those below.
    pub scene: Arc<Scene>,
    /// The camera.
    pub camera: Camera,
    /// Size of the image.
    pub film: FilmSize,
    /// One or two ways to render it.
    pub methods: Vec<Method>,
    /// Who is next where there are two.
    pub pacing: Pacing,
    /// What is shown.
    pub layer: Layer,
    /// How radiance is shown.
    pub display: Display,
    /// Whether the camera moves: a small image soon is better than a large one late.
    pub moving: bool,
    /// Whether nothing is to be rendered.
    pub paused: bool,
    /// The point of the image that is asked about, in fractions of its width and height.
    pub inspected: Option<[f64; 2]>,
}

impl RenderRequest {
    /// Whether `other` asks for the same.
    pub fn is(&self, other: &Self) -> bool {
        let parts = |request: &Self| {
            (
                request.camera,
                request.film,
                request.pacing,
                request.layer,
                request.display,
            )
        };
        let states = |request: &Self| (request.moving, request.paused, request.inspected);
        Arc::ptr_eq(&self.scene, &other.scene)
            && parts(self) == parts(other)
            && states(self) == states(other)
            && self.methods == other.methods
    }

    /// The scene as the view of `method` renders it.
    pub fn scene_of(&self, method: &Method) -> Scene {
        let mut scene = Scene::clone(&self.scene);
        scene.camera = self.camera;
        scene.film = self.film;
        scene.render = method.settings;
        // What it says holds for the camera and the size of the file.
        scene.expect = None;
        scene
    }
}
