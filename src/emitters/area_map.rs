//! Area-preserving maps between the unit square and primitives' coordinates (s, t), and their
//! inverses.

use glam::DVec2;
use std::f64::consts::FRAC_PI_4;

/// The triangle s, t ≥ 0, s + t ≤ 1 (Heitz 2019, "A Low-Distortion Map Between Triangle and
/// Square").
pub fn square_to_triangle(u: DVec2) -> DVec2 {
    if u.y > u.x {
        let s = 0.5 * u.x;
        DVec2::new(s, u.y - s)
    } else {
        let t = 0.5 * u.y;
        DVec2::new(u.x - t, t)
    }
}

/// The inverse of [`square_to_triangle`].
pub fn triangle_to_square(st: DVec2) -> DVec2 {
    if st.y > st.x {
        DVec2::new(2.0 * st.x, st.x + st.y)
    } else {
        DVec2::new(st.x + st.y, 2.0 * st.y)
    }
}

/// The unit disk: concentric map (Shirley & Chiu 1997, "A Low Distortion Map Between Disk and
/// Square"). The centre maps to itself.
pub fn square_to_disk(u: DVec2) -> DVec2 {
    let p = 2.0 * u - DVec2::ONE;
    let wide = p.x.abs() > p.y.abs();
    let (radius, across) = if wide { (p.x, p.y) } else { (p.y, p.x) };
    if radius == 0.0 {
        return DVec2::ZERO;
    }
    let (sin, cos) = (FRAC_PI_4 * across / radius).sin_cos();
    radius
        * if wide {
            DVec2::new(cos, sin)
        } else {
            DVec2::new(sin, cos)
        }
}

/// The inverse of [`square_to_disk`].
pub fn disk_to_square(st: DVec2) -> DVec2 {
    let wide = st.x.abs() > st.y.abs();
    let (along, across) = if wide { (st.x, st.y) } else { (st.y, st.x) };
    if along == 0.0 {
        return DVec2::splat(0.5);
    }
    let radius = st.length().copysign(along);
    let across = radius * (across / along).atan() / FRAC_PI_4;
    let p = if wide {
        DVec2::new(radius, across)
    } else {
        DVec2::new(across, radius)
    };
    0.5 * (p + DVec2::ONE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverses_lead_back() {
        for i in 0..=32 {
            for j in 0..=32 {
                let u = DVec2::new(f64::from(i) / 32.0, f64::from(j) / 32.0);
                let triangle = triangle_to_square(square_to_triangle(u));
                let disk = disk_to_square(square_to_disk(u));
                assert!(triangle.distance(u) < 1e-14, "{u}: {triangle}");
                assert!(disk.distance(u) < 1e-14, "{u}: {disk}");
            }
        }
    }
}
