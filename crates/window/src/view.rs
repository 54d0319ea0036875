//! One view at work: a scene, a method, and the session that renders it.

use super::density::densities;
use super::picture::{Inspected, InspectedSurface, Picture, colours};
use super::request::{Method, RenderRequest};
use direkt::error::{Error, GpuError};
use direkt::low_level::effects::Effect;
use direkt::low_level::gpu::Context;
use direkt::low_level::prepare::near_plane::is_distant;
use direkt::low_level::prepare::{Prepared, SceneData};
use direkt::low_level::reference::kernel::camera::camera_ray;
use direkt::low_level::reference::scene::fetch::World;
use direkt::low_level::reference::scene::opacity::Crossings;
use direkt::low_level::reference::scene::surface::surface_at;
use direkt::low_level::reference::scene::trace::closest_hit;
use direkt::low_level::render::{Checkpoint, Film, ImageError, RayCounts, Session, StopReason};
use direkt::scene::normalize::{Normalization, bounds};
use direkt::scene::{Camera, FilmSize, Scene, validate};
use glam::DVec2;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// How long a dispatch should take, in the first second and after it: the renderer looks for a
/// newer request between two, and short ones cost some speed.
const FIRST_DISPATCH: Duration = Duration::from_millis(20);
const DISPATCH: Duration = Duration::from_millis(30);
/// Samples of a pass at most.
const MAX_PASS_SAMPLES: u64 = 16;
/// Seconds that a pass should take while the camera moves.
const MOVING_PASS: f64 = 0.025;
/// Largest factor by which the image is smaller then, along each side.
const MAX_REDUCTION: f64 = 16.0;
/// Part of the time that pictures may take, and so looks at the error, in the first second and
/// after it: one wants to see soon what comes about, and later to get on.
const FIRST_SHARE: f64 = 0.25;
const SHARE: f64 = 0.02;
const ERROR_SHARE: f64 = 0.03;
/// Factor by which the samples have grown at least when a picture follows another.
const GROWTH: f64 = 1.03;
/// Samples without which an error is not asked for.
const FEWEST_SAMPLES: u64 = 4;

/// A view at work.
pub struct View<'a> {
    scene: Arc<Scene>,
    method: Arc<Method>,
    camera: Camera,
    asked: FilmSize,
    moving: bool,
    prepared: Prepared,
    session: Session<'a>,
    effects: Arc<Vec<(Effect, String)>>,
    run: u64,
    seconds: f64,
    pass_seconds: f64,
    /// Seconds that a sample of one pixel takes, as far as is known.
    sample_seconds: f64,
    /// Seconds spent on pictures and errors in this run.
    shown_seconds: f64,
    /// Seconds that a look at the error took, the last one.
    error_seconds: f64,
    /// Seconds spent on looks at the error in this run.
    error_spent: f64,
    shown_samples: u64,
    error: Option<ImageError>,
    curve: Vec<[f64; 2]>,
}

/// What another device needs to go on with a view.
pub struct Rescued {
    scene: Arc<Scene>,
    method: Arc<Method>,
    checkpoint: Checkpoint,
    camera: Camera,
    film: FilmSize,
    run: u64,
    seconds: f64,
    curve: Vec<[f64; 2]>,
}

impl<'a> View<'a> {
    /// Prepares the view of `method` and compiles its kernel, unless the device has it already.
    /// `data` is the scene of `request` where another view has it, scaled for the request's camera.
    pub fn new(
        context: &'a Context,
        request: &RenderRequest,
        method: &Method,
        data: Option<Arc<SceneData>>,
        run: u64,
    ) -> Result<Self, Error> {
        let mut settings = method.settings;
        let data = match data {
            Some(data) => {
                validate::settings(&request.scene, &settings)?;
                data
            }
            None => {
                let scene = request.scene_of(method);
                validate::validate(&scene)?;
                Arc::new(SceneData::new(scene))
            }
        };
        // A large scene is not compiled anew for each edit.
        settings.estimator.specialize &= data.bvh.small.is_none();
        let mut prepared = Prepared::seen_by(&data, (request.camera, request.film), settings);
        for &effect in &method.forced {
            prepared.effects.force(effect);
        }
        let effects = prepared.effects.iter();
        let effects = effects.map(|(effect, reason)| (effect, reason.to_owned()));
        let effects = Arc::new(effects.collect());
        let mut session = Session::new(context, &prepared, request.film, settings.seed)?;
        session.set_dispatch_time(FIRST_DISPATCH);
        let mut view = Self {
            scene: Arc::clone(&request.scene),
            method: Arc::new(method.clone()),
            camera: request.camera,
            asked: request.film,
            moving: false,
            prepared,
            session,
            effects,
            run,
            seconds: 0.0,
            pass_seconds: 0.0,
            sample_seconds: 0.0,
            shown_seconds: 0.0,
            error_seconds: 0.0,
            error_spent: 0.0,
            shown_samples: 0,
            error: None,
            curve: Vec::new(),
        };
        if request.moving {
            view.reframe(request)?;
        }
        Ok(view)
    }

    /// Whether it can do `request` by `method` as it is, but for where the camera stands and how
    /// large the image is.
    pub fn fits(&self, request: &RenderRequest, method: &Method) -> bool {
        let kind = |c: &Camera| (c.is_orthographic(), c.lens.radius > 0.0);
        *self.method == *method
            && kind(&self.camera) == kind(&request.camera)
            && self.data_for(request).is_some()
            // While it moves, lights in view may be left to chance.
            && (request.moving || self.prepared.has_effects_for(&request.camera, request.film))
    }

    /// The scene of `request`, where this view has it, scaled for the request's camera.
    pub fn data_for(&self, request: &RenderRequest) -> Option<Arc<SceneData>> {
        let has_it = Arc::ptr_eq(&self.scene, &request.scene)
            && (self.camera == request.camera || self.is_scaled_for(request));
        has_it.then(|| Arc::clone(&self.prepared.data))
    }

    /// Whether the scene is scaled as the camera of `request` calls for. While that moves, an
    /// ordinary scene stays as it is.
    fn is_scaled_for(&self, request: &RenderRequest) -> bool {
        let effects = &self.prepared.effects;
        let normalization = &self.prepared.data.normalization;
        let scaled_for_camera =
            normalization.is_extreme() || effects.contains(Effect::DistantCamera);
        !scaled_for_camera
            && (request.moving
                || *normalization == Normalization::for_camera(&request.scene, &request.camera)
                    && !is_distant(normalization, &request.camera))
    }

    /// Whether nothing is different in `request`.
    pub fn is_of(&self, request: &RenderRequest) -> bool {
        self.camera == request.camera && self.asked == request.film && self.moving == request.moving
    }

    /// Begins the run `run` with the camera and the size of `request`.
    pub fn begin(&mut self, request: &RenderRequest, run: u64) -> Result<(), GpuError> {
        self.run = run;
        self.reframe(request)
    }

    fn reframe(&mut self, request: &RenderRequest) -> Result<(), GpuError> {
        (self.camera, self.asked, self.moving) = (request.camera, request.film, request.moving);
        let film = if request.moving {
            self.reduced(request.film)
        } else {
            request.film
        };
        self.prepared.look_from(request.camera, film);
        self.session.reframe(&self.prepared, film)?;
        self.session.set_dispatch_time(FIRST_DISPATCH);
        (self.seconds, self.shown_seconds, self.shown_samples) = (0.0, 0.0, 0);
        self.error_spent = 0.0;
        self.error = None;
        self.curve.clear();
        Ok(())
    }

    /// `film`, or a smaller one of which a pass is over soon.
    fn reduced(&self, film: FilmSize) -> FilmSize {
        let pass = self.sample_seconds * film.pixels() as f64;
        let factor = (pass / MOVING_PASS).sqrt().ceil().clamp(1.0, MAX_REDUCTION);
        let side = |length: u32| ((f64::from(length) / factor).ceil() as u32).max(1);
        FilmSize {
            width: side(film.width),
            height: side(film.height),
        }
    }

    /// Goes on from where another device was lost.
    pub fn resume(&mut self, rescued: &Rescued) -> Result<(), GpuError> {
        let same = Arc::ptr_eq(&self.scene, &rescued.scene)
            && *self.method == *rescued.method
            && self.camera == rescued.camera
            && self.prepared.film == rescued.film;
        if same {
            self.session.resume(rescued.checkpoint.clone())?;
            (self.run, self.seconds) = (rescued.run, rescued.seconds);
            self.curve.clone_from(&rescued.curve);
        }
        Ok(())
    }

    /// What another device needs to go on.
    pub fn rescue(self) -> Rescued {
        Rescued {
            scene: self.scene,
            method: self.method,
            camera: self.camera,
            film: self.prepared.film,
            checkpoint: self.session.into_checkpoint(),
            run: self.run,
            seconds: self.seconds,
            curve: self.curve,
        }
    }

    /// Samples that every pixel has.
    pub fn samples(&self) -> u64 {
        self.session.samples()
    }

    /// Seconds of rendering in this run.
    pub fn seconds(&self) -> f64 {
        self.seconds
    }

    /// Takes every pixel a little further, unless `stop` says otherwise.
    pub fn pass(&mut self, stop: impl FnMut() -> bool) -> Result<StopReason, GpuError> {
        let start = Instant::now();
        let before = self.samples();
        let reason = self.session.pass(self.pass_samples(), stop)?;
        let seconds = start.elapsed().as_secs_f64();
        self.seconds += seconds;
        if self.seconds > 1.0 {
            self.session.set_dispatch_time(DISPATCH);
        }
        let taken = self.samples() - before;
        if taken > 0 {
            self.pass_seconds = seconds / taken as f64;
            self.sample_seconds = self.pass_seconds / self.prepared.film.pixels() as f64;
        }
        Ok(reason)
    }

    /// Samples of the next pass: an eighth of those that there are. A pass over few samples costs
    /// some speed, as every pixel's state is read and written for it, and one over many would let
    /// the first picture wait.
    fn pass_samples(&self) -> u64 {
        match self.samples() / 8 {
            0 => 1,
            eighth => (eighth.min(MAX_PASS_SAMPLES)).next_multiple_of(2),
        }
    }

    /// Whether it is time for a picture.
    pub fn is_due(&self) -> bool {
        if self.shown_samples == 0 {
            return self.samples() > 0;
        }
        let grown = self.samples() as f64 >= GROWTH * self.shown_samples as f64;
        grown
            && self.samples() > self.shown_samples
            && self.shown_seconds - self.error_spent <= self.allowance(SHARE)
    }

    /// Seconds that something may have taken by now of which later `share` is the part of the time.
    fn allowance(&self, share: f64) -> f64 {
        FIRST_SHARE * self.seconds.min(1.0) + share * (self.seconds - 1.0).max(0.0)
    }

    /// The image so far, with the rays traced for it.
    pub fn snapshot(&self) -> Result<(Film, RayCounts), GpuError> {
        self.session.snapshot()
    }

    /// A picture of `film` beside that of the `other` view, with its error if that is due and
    /// `stop` does not say otherwise.
    pub fn picture(
        &mut self,
        (film, rays): (Film, RayCounts),
        other: Option<&Film>,
        (request, version): (&RenderRequest, u64),
        stop: impl Fn() -> bool,
    ) -> Picture {
        if self.error_is_due() {
            let start = Instant::now();
            let error = film.error_unless(stop);
            let seconds = start.elapsed().as_secs_f64();
            self.error_spent += seconds;
            if let Some(error) = error {
                self.error_seconds = seconds;
                self.error = Some(error);
                self.curve.push([self.seconds, error.nmse.value.sqrt()]);
            }
        }
        Picture {
            version,
            run: self.run,
            method: Arc::clone(&self.method),
            estimator: film.settings_of(self.prepared.settings.estimator),
            colours: Arc::new(colours(&film, other, request.layer, &request.display)),
            full: !self.moving,
            samples: self.samples(),
            seconds: self.seconds,
            pass_seconds: self.pass_seconds,
            compile_seconds: self.session.compile_seconds,
            rays,
            error: self.error,
            curve: Arc::new(self.curve.clone()),
            effects: Arc::clone(&self.effects),
            bias: self.prepared.bias(),
            film: Arc::new(film),
        }
    }

    /// Notes that a picture took `seconds`.
    pub fn shown(&mut self, seconds: f64) {
        self.shown_seconds += seconds;
        self.shown_samples = self.samples();
    }

    /// Whether it is time to look at the error: both replicates have the same number of samples,
    /// the time has grown by a quarter since the last look, and another one is not too long.
    fn error_is_due(&self) -> bool {
        let samples = self.samples();
        let last = self.curve.last().map_or(0.0, |point| point[0]);
        !self.moving
            && samples >= FEWEST_SAMPLES
            && samples.is_multiple_of(2)
            && self.seconds >= 1.25 * last
            && self.error_spent + self.error_seconds <= self.allowance(ERROR_SHARE)
    }

    /// What lies under the point `at` of the image.
    pub fn inspect(&self, at: [f64; 2]) -> Inspected {
        let world = World::new(&self.prepared);
        let size = self.prepared.film;
        let film = DVec2::from_array(at) * DVec2::new(size.width.into(), size.height.into());
        // The middle of the square that is mapped to the lens is its middle.
        let ray = camera_ray(&world, size, film, DVec2::splat(0.5));
        let hit = closest_hit(&world, &ray, Crossings::OPAQUE);
        let surface = hit.map(|hit| {
            let point = ray.origin + hit.t * ray.direction;
            let position = self.prepared.data.normalization.point_in_world(point);
            let primitive = &self.prepared.data.primitives[hit.primitive as usize];
            let scene = &self.prepared.data.scene;
            let shape = &scene.shapes[primitive.shape.index()];
            let surface = surface_at(&world, &ray, &hit, -ray.direction);
            InspectedSurface {
                shape: shape.name.clone(),
                material: scene.materials[primitive.material.index()].name.clone(),
                position,
                depth: (position - self.camera.eye).dot(self.camera.forward),
                bounds: bounds([shape]).unwrap_or((position, position)),
                densities: densities(&world, &surface),
            }
        });
        Inspected { at, surface }
    }
}
