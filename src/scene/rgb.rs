//! Three numbers of a scene file, or one for all.

use glam::DVec3;
use schemars::JsonSchema;
use serde::de::{Deserialize, Deserializer, Error as _, SeqAccess, Visitor};

/// Three numbers [r, g, b], or one for all.
#[derive(Debug, Clone, Copy, JsonSchema)]
#[schemars(untagged)]
#[expect(
    dead_code,
    reason = "the variants describe the two spellings to the schema"
)]
enum RgbSpelling {
    Grey(f64),
    Rgb([f64; 3]),
}

/// A linear RGB value.
#[derive(Debug, Clone, Copy, PartialEq, JsonSchema)]
#[schemars(transparent)]
pub struct Rgb(#[schemars(with = "RgbSpelling")] pub [f64; 3]);

impl From<Rgb> for DVec3 {
    fn from(rgb: Rgb) -> Self {
        Self::from_array(rgb.0)
    }
}

/// Reads one number for all three, or three.
pub(crate) struct OneOrThree(pub &'static str);

impl<'de> Visitor<'de> for OneOrThree {
    type Value = [f64; 3];

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.0)
    }

    fn visit_f64<E>(self, v: f64) -> Result<Self::Value, E> {
        Ok([v; 3])
    }

    fn visit_i64<E>(self, v: i64) -> Result<Self::Value, E> {
        Ok([v as f64; 3])
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Self::Value, A::Error> {
        let mut values = [0.0; 3];
        for (i, value) in values.iter_mut().enumerate() {
            *value = seq
                .next_element()?
                .ok_or_else(|| A::Error::invalid_length(i, &self))?;
        }
        let mut length = 3;
        while seq.next_element::<serde::de::IgnoredAny>()?.is_some() {
            length += 1;
        }
        if length == 3 {
            Ok(values)
        } else {
            Err(A::Error::invalid_length(length, &self))
        }
    }
}

impl<'de> Deserialize<'de> for Rgb {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let visitor = OneOrThree("three numbers [r, g, b], or one for all");
        Ok(Self(deserializer.deserialize_any(visitor)?))
    }
}
