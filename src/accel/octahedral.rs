//! Unit vectors in two numbers: the octahedron |x| + |y| + |z| = 1, unfolded into the square [−1,
//! 1]² (Cigolle et al. 2014, "A Survey of Efficient Representations for Independent Unit Vectors").

use glam::{DVec2, DVec3};

/// The point of the square that stands for the unit vector `n`.
pub fn octahedral(n: DVec3) -> DVec2 {
    let p = n.truncate() / n.abs().element_sum();
    if n.z >= 0.0 {
        p
    } else {
        (DVec2::ONE - DVec2::new(p.y, p.x).abs()) * DVec2::ONE.copysign(p)
    }
}

/// The vector, not normalised, that `p` stands for.
pub fn from_octahedral(p: DVec2) -> DVec3 {
    let z = 1.0 - p.x.abs() - p.y.abs();
    let fold = DVec2::splat((-z).max(0.0)).copysign(p);
    (p - fold).extend(z)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn there_and_back(n: DVec3) -> DVec3 {
        from_octahedral(octahedral(n).as_vec2().as_dvec2()).normalize()
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
