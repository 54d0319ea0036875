//! Orthonormal frames.

use glam::DVec3;

/// An orthonormal frame; z is the normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShadingFrame {
    /// Tangent.
    pub x: DVec3,
    /// Bitangent.
    pub y: DVec3,
    /// Normal.
    pub z: DVec3,
}

/// The frame around the unit vector `z` that the shaders build (Duff et al. 2017, "Building an
/// Orthonormal Basis, Revisited"): directions sampled in it depend on which one it is.
pub fn frame_from_normal(z: DVec3) -> ShadingFrame {
    let s = if z.z >= 0.0 { 1.0 } else { -1.0 };
    let a = -1.0 / (s + z.z);
    let b = z.x * z.y * a;
    ShadingFrame {
        x: DVec3::new(1.0 + s * z.x * z.x * a, s * b, -s * z.x),
        y: DVec3::new(b, s + z.y * z.y * a, -z.y),
        z,
    }
}

/// Components of `v` along the frame's axes.
pub fn to_local(f: &ShadingFrame, v: DVec3) -> DVec3 {
    DVec3::new(f.x.dot(v), f.y.dot(v), f.z.dot(v))
}

/// The vector whose components along the frame's axes are `v`.
pub fn to_world(f: &ShadingFrame, v: DVec3) -> DVec3 {
    f.x * v.x + f.y * v.y + f.z * v.z
}
