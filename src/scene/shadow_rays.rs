//! Several shadow rays per camera ray: how many, and where on the lights they end.

use super::choice::choice;
use crate::lattice;
use schemars::JsonSchema;
use serde::de::{Deserialize, Deserializer, Visitor};
use serde::ser::{Serialize, Serializer};
use std::str::FromStr;

/// Most shadow rays per camera ray, and with light selection `all` per light.
pub const MAX_SHADOW_RAYS: u32 = 1024;

/// Most light samples that a camera ray takes in all: with light selection `all` the lights' shadow
/// rays together. So many fit half a word of a sample's record.
pub const MAX_LIGHT_SAMPLES: u64 = 0xffff;

/// How many shadow rays a camera ray has, with light selection `all` per light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum ShadowRays {
    /// One, or [`SEVERAL`](Self::SEVERAL) where a few pixels tell that they pay.
    #[default]
    Auto,
    /// So many.
    Number(u32),
}

impl ShadowRays {
    /// How many there are with `auto` where several pay.
    pub const SEVERAL: u32 = 4;

    /// How many there are before pixels have been asked.
    pub fn least(self) -> u32 {
        match self {
            Self::Auto => 1,
            Self::Number(rays) => rays,
        }
    }

    /// How many there may be.
    pub fn most(self) -> u32 {
        match self {
            Self::Auto => Self::SEVERAL,
            Self::Number(rays) => rays,
        }
    }
}

/// The word for [`ShadowRays::Auto`].
const AUTO: &str = "auto";
/// What a number of shadow rays can be.
const EXPECTED: &str = "\"auto\" or a number from 1 to 1024";

impl std::fmt::Display for ShadowRays {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Auto => f.write_str(AUTO),
            Self::Number(rays) => rays.fmt(f),
        }
    }
}

impl FromStr for ShadowRays {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = text
            .parse()
            .ok()
            .filter(|n| (1..=MAX_SHADOW_RAYS).contains(n));
        match (text, number) {
            (AUTO, _) => Ok(Self::Auto),
            (_, Some(rays)) => Ok(Self::Number(rays)),
            _ => Err(format!("expected {EXPECTED}")),
        }
    }
}

impl Serialize for ShadowRays {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Auto => serializer.serialize_str(AUTO),
            Self::Number(rays) => serializer.serialize_u32(*rays),
        }
    }
}

impl<'de> Deserialize<'de> for ShadowRays {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(WordOrNumber)
    }
}

struct WordOrNumber;

impl Visitor<'_> for WordOrNumber {
    type Value = ShadowRays;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(EXPECTED)
    }

    fn visit_i64<E: serde::de::Error>(self, number: i64) -> Result<ShadowRays, E> {
        let unexpected = serde::de::Unexpected::Signed(number);
        let rays = u32::try_from(number).map_err(|_| E::invalid_value(unexpected, &self))?;
        Ok(ShadowRays::Number(rays))
    }

    fn visit_str<E: serde::de::Error>(self, word: &str) -> Result<ShadowRays, E> {
        let unexpected = serde::de::Unexpected::Str(word);
        (word == AUTO)
            .then_some(ShadowRays::Auto)
            .ok_or_else(|| E::invalid_value(unexpected, &self))
    }
}

impl JsonSchema for ShadowRays {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "ShadowRays".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "anyOf": [
                { "const": AUTO },
                { "type": "integer", "minimum": 1, "maximum": MAX_SHADOW_RAYS }
            ]
        })
    }
}

choice! {
    /// Where on the lights the points of a camera ray's shadow rays lie.
    pub enum ShadowPattern {
        /// Where the sampler's next numbers say.
        #[default]
        Random,
        /// In the middle; biased, for study.
        Center,
        /// In the middles of a grid's cells, one ray in each; biased, for study.
        Grid,
        /// Jittered in the cells of that grid; several lights get their shares of the rays, too.
        Stratified,
    }
}

/// A grid over the unit square with a cell for each of a camera ray's shadow rays, and the lattice
/// of what they choose lights by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ShadowGrid {
    /// Shadow rays, at least 1.
    pub rays: u32,
    /// Columns of the grid.
    pub columns: u32,
    /// Rows of the grid; columns times rows are all rays.
    pub rows: u32,
    /// What a ray's words for the choices of light and of environment texel are ahead of the ray's
    /// before, in fractions of 2³². All rays together have one word in each of `rays` equal parts,
    /// and those of a light lie all over the grid: a rank-1 lattice over (ray, light, texel) with
    /// the generator (1, k, k²), k near the golden section.
    pub steps: [u32; 2],
}

impl ShadowGrid {
    /// The grid of `rays` cells that is nearest to a square, with no more rows than columns.
    pub fn new(rays: u32) -> Self {
        let divides = |rows: &u32| rays.is_multiple_of(*rows);
        let rows = (1..=rays.isqrt()).rev().find(divides).unwrap_or(1);
        let generator = lattice::coprime(rays);
        let step = |k: u64| ((k << 32) / u64::from(rays)) as u32;
        let square = u64::from(generator).pow(2) % u64::from(rays);
        Self {
            rays,
            columns: rays / rows,
            rows,
            steps: [step(u64::from(generator)), step(square)],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grids_have_a_cell_for_every_ray() {
        for (rays, expected) in [
            (1, [1, 1]),
            (2, [2, 1]),
            (4, [2, 2]),
            (7, [7, 1]),
            (12, [4, 3]),
            (1000, [40, 25]),
            (1024, [32, 32]),
        ] {
            let grid = ShadowGrid::new(rays);
            assert_eq!([grid.columns, grid.rows], expected, "{rays} rays");
        }
    }

    /// Each of n equal parts of the words holds one ray, wherever the first ray's word lies; and
    /// the rays that choose a half of the lights have texels from all over.
    #[test]
    fn every_part_of_the_choices_holds_one_ray() {
        for rays in 1..=MAX_SHADOW_RAYS {
            let grid = ShadowGrid::new(rays);
            let part = |word: u32| (u64::from(word) * u64::from(rays)) >> 32;
            let start = u32::MAX / rays / 2;
            for step in grid.steps {
                let words = (0..rays).map(|i| start.wrapping_add(i.wrapping_mul(step)));
                let mut parts: Vec<u64> = words.map(part).collect();
                parts.sort_unstable();
                assert!(parts.iter().copied().eq(0..u64::from(rays)), "{rays} rays");
            }
            let chosen = |i: &u32| i.wrapping_mul(grid.steps[0]) < 1 << 31;
            let texels = (0..rays).filter(chosen);
            let low = texels.filter(|i| i.wrapping_mul(grid.steps[1]) < 1 << 31);
            let share = low.count() as f64 / f64::from(rays);
            assert!(rays < 16 || (share - 0.25).abs() < 0.1, "{rays}: {share}");
        }
    }
}
