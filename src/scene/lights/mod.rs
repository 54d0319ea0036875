//! Lights without a surface: a file for each kind, and the table that names them.
//!
//! A kind's file has its data, its keys in a scene file, what is valid, its power, how far its
//! light spreads, and the record that the GPU reads. The rest of direkt asks [`Light`], whatever
//! the kind.

mod directional;
mod point;
mod spot;
mod sun;

pub use directional::{DirectionalLight, LIGHT_DIRECTIONAL};
pub use point::{LIGHT_POINT, PointLight};
pub use spot::{LIGHT_SPOT, SpotLight};
pub use sun::{LIGHT_SUN, MIN_SUN, SunLight};

use super::normalize::Normalization;
use crate::error::InputError;
use glam::DVec3;
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::PI;
use std::path::Path;
use strum::VariantNames;

/// The table: every kind with its data, its shader module and its constant there; and the keys of
/// every `type` of a scene file.
macro_rules! lights {
    (
        kinds { $($(#[$doc:meta])* $kind:ident($data:ty) $module:literal $constant:ident;)* }
        types { $($(#[$type_doc:meta])* $ty:ident($table:ty);)* }
    ) => {
        /// A light without a surface: only light sampling can reach it, but for suns.
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub enum Light { $($(#[$doc])* $kind($data),)* }

        impl Light {
            /// The shader module of every kind, and the name and value of the constant by which the
            /// GPU knows it.
            pub const CONSTANTS: &[(&'static str, &'static str, u32)] =
                &[$(($module, stringify!($constant), $constant),)*];

            fn kind(&self) -> &dyn LightKind {
                match self { $(Self::$kind(light) => light,)* }
            }

            fn kind_mut(&mut self) -> &mut dyn LightKind {
                match self { $(Self::$kind(light) => light,)* }
            }
        }

        /// The keys of a light in a scene file, by its `type`.
        #[derive(Debug, Deserialize, JsonSchema, VariantNames)]
        #[serde(rename_all = "kebab-case")]
        #[strum(serialize_all = "kebab-case")]
        #[schemars(tag = "type")]
        pub(super) enum LightKeys { $($(#[$type_doc])* $ty($table),)* }

        impl LightKeys {
            /// The light that they describe.
            pub(super) fn light(&self) -> Result<Light, Fault> {
                match self { $(Self::$ty(table) => table.light(),)* }
            }
        }
    };
}

lights! {
    kinds {
        /// Radiates equally from a point.
        Point(PointLight) "light::point" LIGHT_POINT;
        /// A point light restricted to a cone.
        Spot(SpotLight) "light::spot" LIGHT_SPOT;
        /// Infinitely far away.
        Directional(DirectionalLight) "light::directional" LIGHT_DIRECTIONAL;
        /// Infinitely far away, and a disk of constant radiance in the sky.
        Sun(SunLight) "light::sun" LIGHT_SUN;
    }
    types {
        /// Radiates equally from a point.
        Point(point::PointTable);
        /// A point light restricted to a cone.
        Spot(spot::SpotTable);
        /// Infinitely far away.
        Directional(directional::DirectionalTable);
    }
}

/// What every kind of light has to say. Its strength is a radiant intensity where it has a
/// position, else an irradiance.
trait LightKind {
    /// Its name for people.
    fn name(&self) -> &'static str;

    /// Where it is, `None` where it is infinitely far away; and its radiant intensity (W·sr⁻¹) or
    /// irradiance (W·m⁻²) per channel.
    fn position_and_strength(&mut self) -> (Option<&mut DVec3>, &mut DVec3);

    /// Its radiance, where it has an extent.
    fn radiance(&self) -> Option<DVec3> {
        None
    }

    /// What position and strength do not say already.
    fn check(&self) -> Result<(), Fault>;

    /// Power of a normalised light over its strength: of one that is infinitely far away what falls
    /// on the sphere of `radius`, the scene's, so that how often each light is chosen does not
    /// depend on the unit of length.
    fn power_of_strength(&self, radius: f64) -> f64 {
        PI * radius * radius
    }

    /// The directions into which it shines, where it has a position; `None` for all.
    fn spread(&self) -> Option<Spread> {
        None
    }

    /// What the GPU reads of the normalised light.
    fn record(&self) -> LightRecord;
}

/// Directions into which a light shines: fully within a cone, less and less beyond it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Unit axis of the cone.
    pub axis: DVec3,
    /// Half angle of the cone, in radians.
    pub full_angle: f64,
    /// Angle beyond the cone at which there is no more light, in radians.
    pub falloff_angle: f64,
}

/// A light as the GPU reads it: `Light` of `shaders/scene/fetch.wesl`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightRecord {
    /// One of the constants `LIGHT_…`.
    pub kind: u32,
    /// Three triples, whose meaning depends on the kind.
    pub vectors: [DVec3; 3],
    /// Radiance; radiant intensity or irradiance where it has no extent.
    pub radiance: DVec3,
}

/// What is wrong with one key of a light.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Fault {
    /// The key; empty for the whole light.
    pub key: &'static str,
    /// What is there.
    pub problem: String,
    /// What would be right.
    pub expected: &'static str,
}

impl Fault {
    fn new(key: &'static str, problem: impl Into<String>, expected: &'static str) -> Self {
        Self {
            key,
            problem: problem.into(),
            expected,
        }
    }

    /// The same as an error about the light `field` of `file`.
    pub(crate) fn at(self, file: &Path, field: &str) -> InputError {
        let field = match self.key {
            "" => field.to_owned(),
            key => format!("{field}.{key}"),
        };
        InputError::new(file, field, self.problem, self.expected)
    }
}

impl Light {
    /// Its name for people: `point`.
    pub fn name(&self) -> &'static str {
        self.kind().name()
    }

    /// Where it is; `None` where it is infinitely far away.
    pub fn position(mut self) -> Option<DVec3> {
        self.kind_mut().position_and_strength().0.copied()
    }

    /// Its radiant intensity (W·sr⁻¹) where it has a position, else its irradiance on a surface
    /// that faces it (W·m⁻²).
    pub fn strength(mut self) -> DVec3 {
        *self.strength_mut()
    }

    /// The same, to be changed.
    pub fn strength_mut(&mut self) -> &mut DVec3 {
        self.kind_mut().position_and_strength().1
    }

    /// The key of its strength in a scene file.
    pub fn strength_key(&self) -> &'static str {
        match self.position() {
            Some(_) => "intensity",
            None => "irradiance",
        }
    }

    /// Its radiance, where it has an extent.
    pub fn radiance(&self) -> Option<DVec3> {
        self.kind().radiance()
    }

    /// The light in normalised space.
    pub fn normalized(mut self, normalization: &Normalization) -> Self {
        if let (Some(position), intensity) = self.kind_mut().position_and_strength() {
            *position = normalization.point(*position);
            *intensity = normalization.intensity(*intensity);
        }
        self
    }

    /// Power of a normalised light over its strength, in a scene of `radius`.
    pub fn power_of_strength(&self, radius: f64) -> f64 {
        self.kind().power_of_strength(radius)
    }

    /// The directions into which it shines, where it has a position; `None` for all.
    pub fn spread(&self) -> Option<Spread> {
        self.kind().spread()
    }

    /// What the GPU reads of the normalised light.
    pub fn record(&self) -> LightRecord {
        self.kind().record()
    }

    /// Whether every number is in its domain.
    pub(super) fn check(&self) -> Result<(), Fault> {
        if let Some(position) = self.position() {
            let problem = format!("is {position}");
            require(
                position.is_finite(),
                "position",
                || problem,
                "a finite point",
            )?;
        }
        let strength = self.strength();
        require(
            strength.is_finite() && strength.cmpge(DVec3::ZERO).all(),
            self.strength_key(),
            || format!("is {strength}"),
            "finite numbers, not negative",
        )?;
        self.kind().check()
    }
}

fn require(
    holds: bool,
    key: &'static str,
    problem: impl FnOnce() -> String,
    expected: &'static str,
) -> Result<(), Fault> {
    if holds {
        return Ok(());
    }
    Err(Fault::new(key, problem(), expected))
}

/// Whether the key `direction` is a unit vector.
fn check_direction(direction: DVec3) -> Result<(), Fault> {
    let unit = (direction.length() - 1.0).abs() < 1e-6;
    require(
        unit,
        "direction",
        || format!("is {direction}"),
        "a unit vector",
    )
}

/// The unit vector of the key `direction`.
fn direction(vector: [f64; 3]) -> Result<DVec3, Fault> {
    let unit = DVec3::from_array(vector).try_normalize();
    unit.ok_or_else(|| {
        let problem = format!("is {vector:?}");
        Fault::new("direction", problem, "a direction that is not zero")
    })
}
