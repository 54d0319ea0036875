//! Whether the numbers of a valid scene are still finite once it is moved, scaled and rounded to
//! f32.

use super::ellipsoid::PrincipalAxes;
use super::normalize::{Normalization, bounds};
use super::{Environment, EnvironmentRadiance, Geometry, Lens, Light, Projection, Scene, Shape};
use crate::error::InputError;
use glam::DVec3;

/// Largest coordinate: the squared length of a product of two is finite in f64.
const MAX_COORDINATE: f64 = 1e75;
/// Smallest size of a scene: that length is not 0 either.
const MIN_SIZE: f64 = 1e-75;
/// Farthest from the origin, in sizes of the scene: what is left of f64's 16 digits resolves it.
const MAX_OFFSET: f64 = 1e12;
/// Farthest that the eye or a light may lie from the scene, in sizes of it: distances are squared
/// in f32.
const MAX_DISTANCE: f64 = 1e18;
/// Smallest sphere, in sizes of the scene: the square of its radius is a normal number of f32.
const MIN_RADIUS: f64 = 1e-18;
/// Largest radiance, irradiance or normalised intensity.
const MAX_POWER: f64 = f32::MAX as f64;

/// What is said of larger ones.
const LARGEST: &str = "at most 3.4e38, the GPU's largest number";

/// Most primitives: the hierarchy's leaves have 28 bits for the first of theirs.
const MAX_PRIMITIVES: u64 = 1 << 28;

type Outcome = Result<(), InputError>;

/// Checks a scene that is valid otherwise.
pub(super) fn check(scene: &Scene) -> Outcome {
    geometry(scene)?;
    let range = Range {
        scene,
        normalization: Normalization::of(scene),
    };
    range.near(scene.camera.eye, || "camera.eye".to_owned())?;
    range.camera()?;
    scene.shapes.iter().try_for_each(|s| range.shape(s))?;
    for (index, light) in scene.lights.iter().enumerate() {
        range.light(light, &format!("lights[{index}]"))?;
    }
    scene
        .environment
        .as_ref()
        .map_or(Ok(()), |e| range.environment(e))
}

/// Coordinates in a range that f64 squares, and resolves beside the scene's size.
fn geometry(scene: &Scene) -> Outcome {
    let error = |field: &str, problem: String, expected: &str| {
        Err(InputError::new(&scene.source, field, problem, expected))
    };
    let primitives: u64 = scene.shapes.iter().map(|s| s.geometry.primitives()).sum();
    if primitives > MAX_PRIMITIVES {
        let problem = format!("are {primitives} triangles and other primitives together");
        return error("shapes", problem, "at most 268435456");
    }
    for shape in &scene.shapes {
        let farthest = shape.geometry.farthest();
        if farthest > MAX_COORDINATE {
            let problem = format!("reaches to {farthest:e}");
            return error(shape.field(), problem, "coordinates up to 1e75");
        }
    }
    let Some((low, high)) = bounds(&scene.shapes) else {
        return Ok(());
    };
    let size = (high - low).max_element();
    if size < MIN_SIZE {
        let problem = format!("are {size:e} in size together");
        return error("shapes", problem, "a scene of at least 1e-75");
    }
    let farthest = low.abs().max(high.abs()).max_element();
    if farthest > MAX_OFFSET * size {
        return error(
            "shapes",
            format!("are {size:e} in size together and lie {farthest:e} from the origin"),
            "a scene within 1e12 times its size of the origin",
        );
    }
    Ok(())
}

/// A scene and how it is scaled.
struct Range<'a> {
    scene: &'a Scene,
    normalization: Normalization,
}

impl Range<'_> {
    fn error(&self, field: String, problem: String, expected: &str) -> Outcome {
        let file = &self.scene.source;
        Err(InputError::new(file, field, problem, expected))
    }

    fn near(&self, p: DVec3, field: impl FnOnce() -> String) -> Outcome {
        let distance = self.normalization.point(p).abs().max_element();
        if distance <= MAX_DISTANCE {
            return Ok(());
        }
        let problem = format!("lies {distance:e} times the scene's size away from it");
        self.error(field(), problem, "at most 1e18 times")
    }

    fn camera(&self) -> Outcome {
        let camera = self.normalization.camera(&self.scene.camera);
        let size = |length: f64, least: f64, key: &str, expected: &str| {
            if (least..=MAX_DISTANCE).contains(&length) {
                return Ok(());
            }
            let problem = format!("is {length:e} times the scene's size");
            self.error(format!("camera.{key}"), problem, expected)
        };
        let between = "1e-18 to 1e18 times";
        if let Projection::Orthographic { height } = camera.projection {
            size(height, MIN_RADIUS, "height", between)?;
        }
        let Lens {
            radius,
            focus_distance,
        } = camera.lens;
        if radius <= 0.0 {
            return Ok(());
        }
        size(focus_distance, MIN_RADIUS, "focus_distance", between)?;
        size(radius, 0.0, "lens_radius", "at most 1e18 times")?;
        if radius <= MAX_DISTANCE * focus_distance {
            return Ok(());
        }
        let problem = format!("is {:e} times the focus distance", radius / focus_distance);
        self.error(
            "camera.lens_radius".to_owned(),
            problem,
            "at most 1e18 times",
        )
    }

    fn bright(&self, power: DVec3, field: impl FnOnce() -> String, unit: &str) -> Outcome {
        let largest = power.max_element();
        if largest <= MAX_POWER {
            return Ok(());
        }
        self.error(field(), format!("is {largest:e}{unit}"), LARGEST)
    }

    fn shape(&self, shape: &Shape) -> Outcome {
        if let Geometry::Sphere { radius, .. } = shape.geometry {
            let of_scene = self.normalization.length(radius);
            if of_scene < MIN_RADIUS {
                return self.error(
                    format!("{}.radius", shape.field()),
                    format!("is {radius:e}, {of_scene:e} of the scene's size"),
                    "at least 1e-18 of it",
                );
            }
        }
        if let Geometry::Ellipsoid { axes, .. } = shape.geometry {
            let shortest = PrincipalAxes::of(axes).radii.min_element();
            let of_scene = self.normalization.length(shortest);
            if of_scene < MIN_RADIUS {
                return self.error(
                    format!("{}.transform", shape.field()),
                    format!("makes a half axis of {shortest:e}, {of_scene:e} of the scene's size"),
                    "at least 1e-18 of it",
                );
            }
        }
        let radiance = shape.emission.map_or(DVec3::ZERO, |e| {
            let texture = e.texture.map(|u| &self.scene.textures[u.texture.index()]);
            e.radiance * texture.map_or(1.0, |t| t.largest())
        });
        self.bright(
            radiance,
            || format!("{}.emission.radiance", shape.field()),
            "",
        )
    }

    fn light(&self, light: &Light, field: &str) -> Outcome {
        if let Some(position) = light.position() {
            self.near(position, || format!("{field}.position"))?;
        }
        let normalized = light.normalized(&self.normalization);
        let (power, unit) = match (normalized.radiance(), normalized.position()) {
            (Some(radiance), _) => (radiance, " in its radiance"),
            (None, Some(_)) => (normalized.strength(), " in units of the scene's size"),
            (None, None) => (normalized.strength(), ""),
        };
        self.bright(power, || format!("{field}.{}", light.strength_key()), unit)
    }

    fn environment(&self, environment: &Environment) -> Outcome {
        let radiance = match &environment.radiance {
            EnvironmentRadiance::Constant(radiance) => radiance.max_element(),
            EnvironmentRadiance::Map(map) => {
                let channels = map.texels.iter().flatten().copied();
                f64::from(channels.fold(0.0, f32::max))
            }
        };
        // The scale reaches the GPU by itself as well.
        let largest = radiance.max(1.0) * environment.scale;
        if largest <= MAX_POWER {
            return Ok(());
        }
        self.error(
            "environment.scale".to_owned(),
            format!(
                "is {:e}, for radiances up to {radiance:e}",
                environment.scale
            ),
            "a product of at most 3.4e38, the GPU's largest number",
        )
    }
}
