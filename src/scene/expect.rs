//! What a scene's image must be: exact values, and where they come from.

use glam::DVec3;

/// The exact image of a scene, for `direkt render --check`.
#[derive(Debug, Clone, PartialEq)]
pub struct Expect {
    /// The exact radiance.
    pub radiance: ExpectedRadiance,
    /// Where the value comes from: a formula, a paper, a book. Not empty.
    pub source: String,
    /// Relative allowance for the rounding of a published value; 0 up to below 1.
    pub tolerance: f64,
}

/// Radiance (W·sr⁻¹·m⁻²) per channel, before any sampling error.
#[derive(Debug, Clone, PartialEq)]
pub enum ExpectedRadiance {
    /// Mean over the image.
    Mean(DVec3),
    /// Every pixel, row by row from the top; as many as the film has.
    Pixels(Vec<DVec3>),
}
