//! Rays and where they end.

use glam::{DVec2, DVec3};

/// The points `origin + t·direction`; `direction` need not have unit length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Where it starts.
    pub origin: DVec3,
    /// Where it goes.
    pub direction: DVec3,
}

/// The nearest intersection of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Ray parameter.
    pub t: f64,
    /// Index of the primitive.
    pub primitive: u32,
    /// Coordinates on a planar primitive: the point is `a + s·u + t·v`.
    pub st: DVec2,
}
