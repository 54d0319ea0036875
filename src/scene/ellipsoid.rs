//! Ellipsoids: principal axes of any affine image of the unit sphere, and their surface.

use glam::{DMat3, DVec3};

/// An ellipsoid around the origin, by its principal axes: the points R (radii ∘ p), |p| ≤ 1, with R
/// the rotation of the Rodrigues vector.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PrincipalAxes {
    /// Lengths of the half axes, above 0.
    pub radii: DVec3,
    /// Rodrigues vector of the rotation: its axis times the tangent of half its angle; at most 0.62
    /// long. 0 where the axes are those of the coordinates.
    pub rodrigues: DVec3,
}

/// Most sweeps of the Jacobi method; it converges quadratically, in about six.
const MAX_SWEEPS: usize = 40;

impl PrincipalAxes {
    /// Those of the image of the unit sphere under the invertible map `m`.
    ///
    /// One-sided Jacobi method (Hestenes 1958): rotations on the right of `m`, which map the unit
    /// sphere to itself, make its columns orthogonal. Small half axes keep their digits beside
    /// large ones where the columns have them (Demmel & Veselić 1992).
    pub fn of(m: DMat3) -> Self {
        let mut columns = [m.x_axis, m.y_axis, m.z_axis];
        for _ in 0..MAX_SWEEPS {
            let turned = [(0, 1), (1, 2), (2, 0)].map(|(i, j)| orthogonalize(&mut columns, i, j));
            if turned == [false; 3] {
                break;
            }
        }
        columns.sort_by(|a, b| b.length().total_cmp(&a.length()));
        let [first, second, _] = columns;
        let first = first.normalize();
        let second = second.reject_from_normalized(first).normalize();
        let directions = [first, second, first.cross(second)];
        let radii = columns.map(DVec3::length);
        let order = nearest_order(&directions);
        Self {
            radii: DVec3::from_array(order.map(|(i, _)| radii[i])),
            rodrigues: rodrigues_vector(&order.map(|(i, sign)| sign * directions[i])),
        }
    }

    /// The map whose image of the unit sphere it is: unit half axes times their lengths as columns.
    pub fn axes(&self) -> DMat3 {
        rotation(self.rodrigues) * DMat3::from_diagonal(self.radii)
    }
}

/// Turns two columns in their plane so that they become orthogonal; `false` where they are.
fn orthogonalize(columns: &mut [DVec3; 3], i: usize, j: usize) -> bool {
    let (a, b) = (columns[i], columns[j]);
    let dot = a.dot(b);
    if dot.abs() <= 4.0 * f64::EPSILON * a.length() * b.length() {
        return false;
    }
    let ratio = (b.length_squared() - a.length_squared()) / (2.0 * dot);
    let tangent = 1.0_f64.copysign(ratio) / (ratio.abs() + ratio.hypot(1.0));
    let cos = 1.0 / tangent.hypot(1.0);
    let sin = cos * tangent;
    (columns[i], columns[j]) = (cos * a - sin * b, sin * a + cos * b);
    true
}

/// Which direction, with which sign, goes to which coordinate, so that together they are a rotation
/// by as small an angle as can be.
fn nearest_order(directions: &[DVec3; 3]) -> [(usize, f64); 3] {
    const ORDERS: [[usize; 3]; 6] = [
        [0, 1, 2],
        [1, 2, 0],
        [2, 0, 1],
        [0, 2, 1],
        [2, 1, 0],
        [1, 0, 2],
    ];
    let candidates = ORDERS.map(|order| {
        let along = |axis: usize| directions[order[axis]][axis];
        let mut signs = [0, 1, 2].map(|axis| 1.0_f64.copysign(along(axis)));
        let image = [0, 1, 2].map(|axis| signs[axis] * directions[order[axis]]);
        if image[0].cross(image[1]).dot(image[2]) < 0.0 {
            let weakest = (0..3).min_by(|&a, &b| along(a).abs().total_cmp(&along(b).abs()));
            signs[weakest.expect("there are three axes")] *= -1.0;
        }
        let trace: f64 = (0..3).map(|axis| signs[axis] * along(axis)).sum();
        (trace, [0, 1, 2].map(|axis| (order[axis], signs[axis])))
    });
    let best = candidates.into_iter().max_by(|a, b| a.0.total_cmp(&b.0));
    best.expect("there are six orders").1
}

/// The Rodrigues vector of the rotation that turns the coordinates' axes to `images`, by less than
/// a half turn.
fn rodrigues_vector([x, y, z]: &[DVec3; 3]) -> DVec3 {
    let twice_sine = DVec3::new(y.z - z.y, z.x - x.z, x.y - y.x);
    twice_sine / (1.0 + x.x + y.y + z.z)
}

/// The rotation with the Rodrigues vector g: I + 2/(1 + |g|²) (G + G²), G v = g × v. Orthogonal for
/// every g.
pub fn rotation(rodrigues: DVec3) -> DMat3 {
    let turned = |v: DVec3| {
        let across = rodrigues.cross(v);
        v + 2.0 / (1.0 + rodrigues.length_squared()) * (across + rodrigues.cross(across))
    };
    DMat3::from_cols(turned(DVec3::X), turned(DVec3::Y), turned(DVec3::Z))
}

/// Surface of an ellipsoid with half axes of the lengths a, b, c: 4π R_G(a²b², b²c², c²a²) (DLMF
/// 19.33.1).
pub fn surface(radii: DVec3) -> f64 {
    let unit = radii.max_element();
    let r = radii / unit;
    let [bc, ca, ab] = [r.y * r.z, r.z * r.x, r.x * r.y];
    let integral = ellip::elliprg(bc * bc, ca * ca, ab * ab);
    let integral = integral.expect("R_G is defined for positive numbers");
    4.0 * std::f64::consts::PI * unit * unit * integral
}

/// Half the size of the axis-parallel box around the image of the unit sphere under `m`: per axis
/// the length of a row.
pub fn half_extent(m: DMat3) -> DVec3 {
    DVec3::new(m.row(0).length(), m.row(1).length(), m.row(2).length())
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;
    use std::f64::consts::PI;

    fn maps() -> Vec<DMat3> {
        let turn = |x: f64, y: f64, z: f64, angle: f64| {
            DMat3::from_quat(DQuat::from_axis_angle(
                DVec3::new(x, y, z).normalize(),
                angle,
            ))
        };
        let scale = |x: f64, y: f64, z: f64| DMat3::from_diagonal(DVec3::new(x, y, z));
        let mut maps = vec![
            scale(0.5, 0.9, 0.3),
            scale(-2.0, 1e-4, 7.0),
            scale(1.0, 1.0, 1e-9),
            scale(3.0, 3.0, 3.0),
            turn(1.0, 2.0, -0.5, 2.8) * scale(1e-8, 1.0, 1e4),
            scale(1.0, 2.0, 1e-3) * turn(0.3, 1.0, 0.2, 0.7) * scale(1.0, 5.0, 1.0),
            DMat3::from_cols(
                DVec3::X,
                DVec3::new(4.0, 1.0, 0.0),
                DVec3::new(1.0, 2.0, 3.0),
            ),
        ];
        for i in 0..200 {
            let i = f64::from(i);
            let turned = turn(i.sin(), (2.1 * i).cos(), 0.3 - (0.7 * i).sin(), i);
            maps.push(turned * scale(1.0, 1.0 + (3.0 * i).sin().abs(), (0.1 * i).exp2()));
        }
        maps
    }

    /// The image of the sphere is {p : p·(M Mᵀ)⁻¹p = 1}, and M Mᵀ tells by how much it reaches in
    /// each direction.
    #[test]
    fn principal_axes_make_the_same_ellipsoid() {
        for m in maps() {
            let found = PrincipalAxes::of(m);
            let axes = found.axes();
            let [expected, same] = [m, axes].map(|m| m * m.transpose());
            let size = expected.to_cols_array().into_iter().fold(0.0, f64::max);
            let off = (expected - same).to_cols_array();
            assert!(off.iter().all(|x| x.abs() < 1e-13 * size), "{m}: {axes}");
            let determinant = m.determinant().abs();
            let volume = found.radii.element_product();
            assert!(
                (volume - determinant).abs() < 1e-7 * volume,
                "{m}: {found:?}"
            );
            assert!(found.rodrigues.length() < 0.62, "{m}: {found:?}");
            let r = rotation(found.rodrigues);
            let unit = r.transpose() * r - DMat3::IDENTITY;
            assert!(unit.to_cols_array().iter().all(|x| x.abs() < 1e-15), "{r}");
            assert!(r.determinant() > 0.0, "{r}");
        }
    }

    #[test]
    fn axes_along_the_coordinates_stay_there() {
        let found = PrincipalAxes::of(DMat3::from_diagonal(DVec3::new(-2.0, 1e-4, 7.0)));
        assert_eq!(found.radii, DVec3::new(2.0, 1e-4, 7.0));
        assert_eq!(found.rodrigues, DVec3::ZERO);
    }

    /// Spheroids have elementary surfaces: oblate 2πa² (1 + (1 − e²)/e · artanh e), prolate 2πa² (1 +
    /// c/(a e) asin e).
    #[test]
    fn surfaces_are_those_of_spheroids_and_of_flat_disks() {
        assert!((surface(DVec3::splat(2.0)) / (16.0 * PI) - 1.0).abs() < 1e-14);
        for c in [0.01, 0.3, 0.9_f64] {
            let e = (1.0 - c * c).sqrt();
            let oblate = 2.0 * PI * (1.0 + c * c / e * e.atanh());
            let found = surface(DVec3::new(1.0, c, 1.0));
            assert!(
                (found / oblate - 1.0).abs() < 1e-12,
                "{c}: {found} {oblate}"
            );
            let prolate = 2.0 * PI * c * c * (1.0 + 1.0 / (c * e) * e.asin());
            let found = surface(DVec3::new(c, c, 1.0));
            assert!(
                (found / prolate - 1.0).abs() < 1e-12,
                "{c}: {found} {prolate}"
            );
        }
        let flat = surface(DVec3::new(1e-9, 2.0, 0.5));
        assert!((flat / (2.0 * PI) - 1.0).abs() < 1e-12, "{flat}");
    }

    #[test]
    fn the_box_around_touches_the_ellipsoid() {
        for m in maps() {
            let half = half_extent(m);
            for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
                let foremost = m * (m.transpose() * axis).normalize();
                let off = foremost.dot(axis) - half.dot(axis);
                assert!(off.abs() < 1e-14 * half.max_element(), "{m}");
            }
        }
    }
}
