//! Moves geometry by an affine transform and keeps its front.
//!
//! Normals transform by the inverse transpose, so the outward (and emitting) side of a mirrored
//! shape stays the outward side: where the determinant is negative, the two edges of a rectangle or
//! disk and the winding of a triangle are swapped.

use crate::scene::{Geometry, Mesh};
use glam::{DAffine3, DMat3, DVec3, DVec4};

/// Why a transform cannot be applied.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum TransformProblem {
    /// An entry is NaN or infinite.
    NotFinite,
    /// It flattens space: `|det| ≤ 1e-12 · Π|columns|`.
    Singular {
        /// Its determinant.
        determinant: f64,
    },
}

impl TransformProblem {
    /// What is wrong, and what would be right.
    pub(super) fn describe(&self) -> (String, &'static str) {
        match self {
            Self::NotFinite => (
                "the transform overflows: an entry is not finite".to_owned(),
                "finite numbers",
            ),
            Self::Singular { determinant } => (
                format!("the transform is singular (its determinant is {determinant:e})"),
                "a transform that does not flatten space; no scale may be 0",
            ),
        }
    }
}

/// Refuses what cannot be inverted.
pub(super) fn check(transform: &DAffine3) -> Result<(), TransformProblem> {
    if !transform.is_finite() {
        return Err(TransformProblem::NotFinite);
    }
    let m = transform.matrix3;
    let volume = m.x_axis.length() * m.y_axis.length() * m.z_axis.length();
    let determinant = m.determinant();
    let invertible = determinant.abs() > 1e-12 * volume;
    if invertible {
        Ok(())
    } else {
        Err(TransformProblem::Singular { determinant })
    }
}

/// Whether the transform mirrors space.
pub(super) fn mirrors(transform: &DAffine3) -> bool {
    transform.matrix3.determinant() < 0.0
}

/// `geometry` moved by `transform`, which [`check`] has accepted.
pub(super) fn apply(transform: &DAffine3, geometry: Geometry) -> Geometry {
    let point = |p: DVec3| transform.transform_point3(p);
    let edges = |u: DVec3, v: DVec3| {
        let (u, v) = (
            transform.transform_vector3(u),
            transform.transform_vector3(v),
        );
        if mirrors(transform) { (v, u) } else { (u, v) }
    };
    match geometry {
        Geometry::Rectangle { corner, u, v } => {
            let (u, v) = edges(u, v);
            let corner = point(corner);
            Geometry::Rectangle { corner, u, v }
        }
        Geometry::Disk { center, u, v } => {
            let (u, v) = edges(u, v);
            let center = point(center);
            Geometry::Disk { center, u, v }
        }
        Geometry::Sphere { center, radius } => {
            let center = point(center);
            match uniform_scale(&transform.matrix3) {
                Some(scale) => Geometry::Sphere {
                    center,
                    radius: radius * scale,
                },
                None => Geometry::Ellipsoid {
                    center,
                    axes: transform.matrix3 * radius,
                },
            }
        }
        Geometry::Ellipsoid { center, axes } => Geometry::Ellipsoid {
            center: point(center),
            axes: transform.matrix3 * axes,
        },
        Geometry::Mesh(mesh) => Geometry::Mesh(apply_to_mesh(transform, mesh)),
    }
}

fn apply_to_mesh(transform: &DAffine3, mut mesh: Mesh) -> Mesh {
    for p in &mut mesh.positions {
        *p = transform.transform_point3(*p);
    }
    let of_normals = transform.matrix3.inverse().transpose();
    for n in &mut mesh.normals {
        *n = of_normals * n.normalize_or_zero();
    }
    turn_tangents(&transform.matrix3, &mut mesh.tangents);
    if mirrors(transform) {
        for t in &mut mesh.triangles {
            t.swap(1, 2);
        }
    }
    mesh
}

/// Turns tangents where `m` moves points. What mirrors turns the sense of n × t, and v falls along
/// what it fell along.
pub(super) fn turn_tangents(m: &DMat3, tangents: &mut [DVec4]) {
    for tangent in tangents {
        let sense = if m.determinant() < 0.0 { -1.0 } else { 1.0 };
        *tangent = (*m * tangent.truncate()).extend(sense * tangent.w);
    }
}

/// What turns normals where `m` moves points, up to a factor: its inverse transposed. Where it
/// flattens space that has no value, and this has that of the plane which remains.
pub(super) fn normal_matrix(m: &DMat3) -> DMat3 {
    let cofactors = DMat3::from_cols(
        m.y_axis.cross(m.z_axis),
        m.z_axis.cross(m.x_axis),
        m.x_axis.cross(m.y_axis),
    );
    if m.determinant() < 0.0 {
        -cofactors
    } else {
        cofactors
    }
}

/// The factor of a similarity, `None` for another map; rotations written in decimals are off by
/// about 1e-7.
fn uniform_scale(m: &DMat3) -> Option<f64> {
    let scale = DVec3::new(m.x_axis.length(), m.y_axis.length(), m.z_axis.length());
    let tolerance = 1e-5;
    let same_length = scale.max_element() - scale.min_element() <= tolerance * scale.max_element();
    let orthogonal = m.x_axis.dot(m.y_axis).abs() <= tolerance * scale.x * scale.y
        && m.y_axis.dot(m.z_axis).abs() <= tolerance * scale.y * scale.z
        && m.z_axis.dot(m.x_axis).abs() <= tolerance * scale.z * scale.x;
    (same_length && orthogonal).then(|| m.determinant().abs().cbrt())
}

/// Two vectors that make a right-handed frame with the unit vector `normal`: `u × v = normal`.
pub(super) fn frame(normal: DVec3) -> (DVec3, DVec3) {
    let u = normal.any_orthonormal_vector();
    (u, normal.cross(u))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;

    fn normal_of(geometry: &Geometry) -> DVec3 {
        match geometry {
            Geometry::Rectangle { u, v, .. } | Geometry::Disk { u, v, .. } => {
                u.cross(*v).normalize()
            }
            Geometry::Mesh(mesh) => {
                let [a, b, c] = mesh.triangles[0].map(|i| mesh.positions[i as usize]);
                (b - a).cross(c - a).normalize()
            }
            Geometry::Sphere { .. } | Geometry::Ellipsoid { .. } => {
                panic!("a curved surface has no single normal")
            }
        }
    }

    fn flat_shapes() -> [Geometry; 3] {
        [
            Geometry::Rectangle {
                corner: DVec3::new(-1.0, -1.0, 0.0),
                u: 2.0 * DVec3::X,
                v: 2.0 * DVec3::Y,
            },
            Geometry::Disk {
                center: DVec3::ZERO,
                u: DVec3::X,
                v: DVec3::Y,
            },
            Geometry::Mesh(Mesh {
                positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
                triangles: vec![[0, 1, 2]],
                ..Mesh::default()
            }),
        ]
    }

    #[test]
    fn normals_go_by_the_inverse_transpose_even_when_mirrored() {
        let transforms = [
            DAffine3::from_scale(DVec3::new(-1.0, 2.0, 3.0)),
            DAffine3::from_scale(DVec3::new(1.0, 1.0, -1.0)),
            DAffine3::from_scale_rotation_translation(
                DVec3::new(1.0, -0.2, 5.0),
                DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 1.1),
                DVec3::new(3.0, -4.0, 1e3),
            ),
            DAffine3::from_rotation_x(std::f64::consts::FRAC_PI_2),
        ];
        for transform in transforms {
            let expected = (transform.matrix3.inverse().transpose() * DVec3::Z).normalize();
            for shape in flat_shapes() {
                let moved = apply(&transform, shape);
                assert!(
                    normal_of(&moved).distance(expected) < 1e-12,
                    "{moved:?} under {transform:?}"
                );
            }
        }
    }

    #[test]
    fn a_sphere_keeps_its_shape_or_becomes_an_ellipsoid() {
        let sphere = || Geometry::Sphere {
            center: DVec3::X,
            radius: 2.0,
        };
        let mirrored = DAffine3::from_scale(DVec3::new(-3.0, 3.0, 3.0));
        let Geometry::Sphere { center, radius } = apply(&mirrored, sphere()) else {
            panic!("a mirrored uniform scale keeps a sphere");
        };
        assert!((radius - 6.0).abs() < 1e-12);
        assert!(center.distance(DVec3::new(-3.0, 0.0, 0.0)) < 1e-12);

        let squashed = DAffine3::from_scale_rotation_translation(
            DVec3::new(1.0, -1.0, 1.1),
            DQuat::from_rotation_z(0.3),
            DVec3::Y,
        );
        let Geometry::Ellipsoid { center, axes } = apply(&squashed, sphere()) else {
            panic!("a non-uniform scale makes an ellipsoid");
        };
        assert_eq!(center, squashed.transform_point3(DVec3::X));
        for p in [DVec3::X, DVec3::Y, DVec3::Z] {
            let image = squashed.transform_point3(DVec3::X + 2.0 * p);
            assert!((center + axes * p).distance(image) < 1e-15);
        }
    }

    #[test]
    fn tiny_scales_are_fine_and_flat_ones_are_not() {
        assert_eq!(check(&DAffine3::from_scale(DVec3::splat(1e-10))), Ok(()));
        assert!(matches!(
            check(&DAffine3::from_scale(DVec3::new(1.0, 1.0, 0.0))),
            Err(TransformProblem::Singular { .. })
        ));
        let sheared_flat = DAffine3::from_mat3(DMat3::from_cols(
            DVec3::X,
            DVec3::Y,
            DVec3::new(1.0, 1.0, 1e-13),
        ));
        assert!(check(&sheared_flat).is_err());
        assert_eq!(
            check(&DAffine3::from_translation(DVec3::new(f64::NAN, 0.0, 0.0))),
            Err(TransformProblem::NotFinite)
        );
    }

    #[test]
    fn frames_are_right_handed() {
        for normal in [DVec3::X, -DVec3::Z, DVec3::new(1.0, -2.0, 3.0).normalize()] {
            let (u, v) = frame(normal);
            assert!(u.cross(v).distance(normal) < 1e-12);
        }
    }
}
