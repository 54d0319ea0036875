//! Whether the numbers of a valid scene are still finite once it is moved, scaled and rounded to f32.

use super::normalize::{Normalization, bounds};
use super::{EnvironmentRadiance, Light, Scene};
use crate::error::InputError;
use glam::DVec3;

/// Largest coordinate: the squared length of a product of two is finite in f64.
const MAX_COORDINATE: f64 = 1e75;
/// Smallest size of a scene: that length is not 0 either.
const MIN_SIZE: f64 = 1e-75;
/// Farthest from the origin, in sizes of the scene: what is left of f64's 16 digits resolves it.
const MAX_OFFSET: f64 = 1e12;
/// Farthest that the eye or a light may lie from the scene, in sizes of it: distances are squared in f32.
const MAX_DISTANCE: f64 = 1e18;
/// Largest radiance, irradiance or normalised intensity.
const MAX_POWER: f64 = f32::MAX as f64;

type Outcome = Result<(), InputError>;

/// Checks a scene that is valid otherwise.
pub(super) fn check(scene: &Scene) -> Outcome {
    let error = |field: String, problem: String, expected: &str| {
        Err(InputError::new(&scene.source, field, problem, expected))
    };
    geometry(scene)?;
    let normalization = Normalization::of(scene);
    let far = |p: DVec3| normalization.point(p).abs().max_element();
    let near = |p: DVec3, field: String| match far(p) {
        distance if distance <= MAX_DISTANCE => Ok(()),
        distance => error(
            field,
            format!("lies {distance:e} times the scene's size away from it"),
            "at most 1e18 times",
        ),
    };
    let bright = |power: DVec3, field: String| match power.max_element() {
        largest if largest <= MAX_POWER => Ok(()),
        largest => error(
            field,
            format!("is {largest:e} once the scene is scaled"),
            "at most 3.4e38, the largest number of the GPU",
        ),
    };
    near(scene.camera.eye, "camera.eye".to_owned())?;
    for (index, light) in scene.lights.iter().enumerate() {
        let field = |key: &str| format!("lights[{index}].{key}");
        match *light {
            Light::Point {
                position,
                intensity,
            }
            | Light::Spot {
                position,
                intensity,
                ..
            } => {
                near(position, field("position"))?;
                bright(normalization.intensity(intensity), field("intensity"))?;
            }
            Light::Directional { irradiance, .. } => bright(irradiance, field("irradiance"))?,
        }
    }
    for shape in &scene.shapes {
        if let Some(emission) = shape.emission {
            bright(
                emission.radiance,
                format!("{}.emission.radiance", shape.field()),
            )?;
        }
    }
    let Some(environment) = &scene.environment else {
        return Ok(());
    };
    let radiance = match &environment.radiance {
        EnvironmentRadiance::Constant(radiance) => radiance.max_element(),
        EnvironmentRadiance::Map(map) => {
            let channels = map.texels.iter().flatten().copied();
            f64::from(channels.fold(1.0, f32::max))
        }
    };
    // The scale reaches the GPU by itself, and multiplied.
    let largest = radiance.max(1.0) * environment.scale;
    bright(DVec3::splat(largest), "environment.scale".to_owned())
}

/// Coordinates in a range that f64 squares, and resolves beside the scene's size.
fn geometry(scene: &Scene) -> Outcome {
    for shape in &scene.shapes {
        let farthest = shape.geometry.farthest();
        if farthest > MAX_COORDINATE {
            return Err(InputError::new(
                &scene.source,
                shape.field(),
                format!("reaches to {farthest:e}"),
                "coordinates up to 1e75",
            ));
        }
    }
    let Some((low, high)) = bounds(scene) else {
        return Ok(());
    };
    let size = (high - low).max_element();
    let farthest = low.abs().max(high.abs()).max_element();
    let error =
        |problem, expected| Err(InputError::new(&scene.source, "shapes", problem, expected));
    if size < MIN_SIZE {
        return error(
            format!("are {size:e} in size together"),
            "a scene of at least 1e-75",
        );
    }
    if farthest > MAX_OFFSET * size {
        return error(
            format!("are {size:e} in size together and lie {farthest:e} from the origin"),
            "a scene within 1e12 times its size of the origin",
        );
    }
    Ok(())
}
