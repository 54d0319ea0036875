//! What must hold of every scene that a reader lets through.

use direkt::low_level::accel::PrimitiveGeometry;
use direkt::low_level::emitters::Emitter;
use direkt::low_level::prepare::Prepared;
use direkt::scene::validate::validate;
use direkt::scene::{EnvironmentRadiance, Scene};
use glam::DVec3;

/// Whether `scene` is valid, and fit for the GPU for that reason.
pub fn check(scene: Scene) -> Result<(), String> {
    validate(&scene).map_err(|e| format!("was loaded, but is not valid: {e}"))?;
    prepare(scene)
}

/// Prepares `scene` for rendering. `Err` says which number would reach the GPU as an infinity or as
/// none.
pub fn prepare(scene: Scene) -> Result<(), String> {
    let prepared = Prepared::of(scene);
    let normalization = &prepared.data.normalization;
    if !normalization.center.is_finite() {
        return Err(format!(
            "normalisation: centre: is {}",
            normalization.center
        ));
    }
    require("normalisation: scale", normalization.scale, |s| {
        s.is_normal() && s > 0.0
    })?;
    small("eye", normalization.point(prepared.camera.eye))?;
    for primitive in &prepared.data.primitives {
        let (low, high) = primitive.geometry.bounds();
        let within = |v: DVec3| v.abs().max_element() < 1.001 * normalization.reach;
        if !(within(low) && within(high)) {
            return Err(format!(
                "{:?} reaches further than {}",
                primitive.geometry, normalization.reach
            ));
        }
        if let PrimitiveGeometry::Sphere { radius, .. } = primitive.geometry {
            require("radius", radius, |r| ((r * r) as f32).is_normal())?;
        }
        if let PrimitiveGeometry::Ellipsoid {
            radii, rodrigues, ..
        } = primitive.geometry
        {
            let shortest = radii.min_element();
            require("half axis", shortest, |r| ((r * r) as f32).is_normal())?;
            let aspect = radii.max_element() / shortest;
            require("aspect of an ellipsoid", aspect, |a| a <= 1.001e9)?;
            small("rotation", rodrigues)?;
        }
    }
    let bvh = &prepared.data.bvh;
    finite("grid: origin", bvh.grid.origin.as_dvec3())?;
    finite("grid: scale", bvh.grid.scale.as_dvec3())?;
    lights(&prepared)
}

fn lights(prepared: &Prepared) -> Result<(), String> {
    for (index, light) in prepared.emitters.lights.iter().enumerate() {
        let probability = prepared.emitters.probability(index);
        require("probability of a light", probability, |p| {
            (0.0..=1.0).contains(&p)
        })?;
        match *light {
            Emitter::Area { radiance, .. } => finite("radiance", radiance)?,
            Emitter::Environment => {}
            Emitter::Delta(light) => {
                if let Some(position) = light.position() {
                    small("position of a light", position)?;
                }
                finite("strength of a light", light.strength())?;
            }
            Emitter::Sun(sun) => finite("radiance of a sun", sun.radiance())?,
        }
    }
    let lit = !prepared.emitters.lights.is_empty();
    if lit && prepared.settings.estimator.strategy.samples_lights() {
        let chosen = prepared.emitters.sampled().next();
        chosen.ok_or("there are lights, and none is ever chosen")?;
    }
    let Some(environment) = &prepared.data.scene.environment else {
        return Ok(());
    };
    require("environment: scale", environment.scale, is_finite)?;
    for column in 0..3 {
        finite("environment: rotation", environment.rotation.col(column))?;
    }
    match &environment.radiance {
        EnvironmentRadiance::Constant(radiance) => {
            finite("environment", *radiance * environment.scale)
        }
        EnvironmentRadiance::Map(map) => {
            let largest = map.texels.iter().flatten().copied().fold(0.0, f32::max);
            require(
                "environment",
                f64::from(largest) * environment.scale,
                is_finite,
            )
        }
    }
}

/// Whether `x` is finite as f32.
fn is_finite(x: f64) -> bool {
    (x as f32).is_finite()
}

fn require(what: &str, x: f64, holds: impl Fn(f64) -> bool) -> Result<(), String> {
    let sound = holds(x);
    sound
        .then_some(())
        .ok_or_else(|| format!("{what}: is {x:e}"))
}

fn finite(what: &str, v: DVec3) -> Result<(), String> {
    v.to_array()
        .iter()
        .try_for_each(|&x| require(what, x, is_finite))
}

/// Distances are squared in f32.
fn small(what: &str, v: DVec3) -> Result<(), String> {
    require(what, v.length_squared(), is_finite)
}
