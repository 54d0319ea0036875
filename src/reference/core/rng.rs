//! Counter-based random numbers: the same integers as on the GPU.

use glam::DVec2;

/// Four well-mixed words from four (Jarzynski & Olano 2020, "Hash Functions for GPU Rendering",
/// pcg4d).
pub fn pcg4d(input: [u32; 4]) -> [u32; 4] {
    let mut v = input.map(|x| x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    mix(&mut v);
    v = v.map(|x| x ^ (x >> 16));
    mix(&mut v);
    v
}

fn mix(v: &mut [u32; 4]) {
    for (to, a, b) in [(0, 1, 3), (1, 2, 0), (2, 0, 1), (3, 1, 2)] {
        v[to] = v[to].wrapping_add(v[a].wrapping_mul(v[b]));
    }
}

/// A number in [0, 1 − 2⁻²⁴] from the upper 24 bits: exactly the f32 that the shaders draw.
pub fn to_unit(x: u32) -> f64 {
    f64::from(x >> 8) / f64::from(1 << 24)
}

/// Two of them.
pub fn to_unit_2d(x: u32, y: u32) -> DVec2 {
    DVec2::new(to_unit(x), to_unit(y))
}
