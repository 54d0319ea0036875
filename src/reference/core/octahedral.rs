//! Unit vectors in two numbers; see [`accel::attributes::octahedral`](crate::accel::attributes::octahedral).

use glam::{DVec2, DVec3};

/// The vector, not normalised, that `p` encodes.
pub fn from_octahedral(p: DVec2) -> DVec3 {
    let z = 1.0 - p.x.abs() - p.y.abs();
    let fold = DVec2::splat((-z).max(0.0)).copysign(p);
    (p - fold).extend(z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::attributes::octahedral;

    fn there_and_back(n: DVec3) -> DVec3 {
        let [x, y] = octahedral(n).map(f64::from);
        from_octahedral(DVec2::new(x, y)).normalize()
    }

    #[test]
    fn octahedral_normals_come_back() {
        for i in 0..2000 {
            let z = -1.0 + 2.0 * (f64::from(i) + 0.5) / 2000.0;
            let (sin, cos) = (f64::from(i) * 2.399_963).sin_cos();
            let r = (1.0 - z * z).sqrt();
            let n = DVec3::new(r * cos, r * sin, z);
            assert!(n.distance(there_and_back(n)) < 2e-7, "{n}");
        }
        for n in [DVec3::X, -DVec3::Y, DVec3::Z, -DVec3::Z] {
            assert_eq!(there_and_back(n), n);
        }
    }
}
