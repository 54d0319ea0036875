//! Configuration factors F = E/(πL) of ellipsoids, and the areas of their outlines.

use crate::scene::ellipsoid::{PrincipalAxes, rotation};
use glam::{DMat2, DMat3, DVec3};
use std::f64::consts::PI;

/// The ellipsoid `centre` + M·p, |p| ≤ 1, with M = `axes`; 1 within, where it then has to emit
/// inwards. `None` when the receiver's horizon cuts it.
///
/// An ellipsoid is seen in an elliptic cone, whose axes are the normals of the three quadrics
/// through the point that are confocal with it, Σ pᵢ²/(σᵢ² + λ) = 1 (Salmon, *A Treatise on the
/// Analytic Geometry of Three Dimensions*), and whose surface is Σ ξⱼ²/λⱼ = 0. The directions of a
/// cone with half angles α and β, projected along its axis, fill the ellipse with half axes sin α
/// and sin β, and across the axis they cancel:
///
/// ```text
///     F = sin α sin β cosθ,    sin²α = −λ₂/(λ₁ − λ₂),    sin²β = −λ₃/(λ₁ − λ₃)
/// ```
pub fn ellipsoid_factor(point: DVec3, normal: DVec3, centre: DVec3, axes: DMat3) -> Option<f64> {
    let to_centre = centre - point;
    if (axes.inverse() * to_centre).length() < 1.0 {
        return Some(1.0);
    }
    let rise = to_centre.dot(normal);
    let reach = (axes.transpose() * normal).length();
    if rise <= -reach {
        return Some(0.0);
    }
    if rise < reach {
        return None;
    }
    let PrincipalAxes { radii, rodrigues } = PrincipalAxes::of(axes);
    let turn = rotation(rodrigues);
    let p = turn.transpose() * to_centre;
    let squares = radii * radii;
    let mut sorted = squares.to_array();
    sorted.sort_by(f64::total_cmp);
    let [least, middle, largest] = sorted;
    let root = |low: f64, high: f64| confocal_parameter(p, squares, low, high);
    let outer = root(0.0, p.length_squared());
    let sine = |inner: f64| (-inner / (outer - inner)).sqrt();
    let sines = sine(root(-middle, -least)) * sine(root(-largest, -middle));
    let axis = turn * (p / (squares + DVec3::splat(outer))).normalize();
    Some(sines * axis.dot(normal))
}

/// The λ between `low` and `high`, two poles or beyond all, at which Σ pᵢ²/(σᵢ² + λ), which falls
/// there, is 1.
fn confocal_parameter(p: DVec3, squares: DVec3, mut low: f64, mut high: f64) -> f64 {
    loop {
        let at = 0.5 * (low + high);
        if at <= low || at >= high {
            return at;
        }
        if (p * p / (squares + DVec3::splat(at))).element_sum() > 1.0 {
            low = at;
        } else {
            high = at;
        }
    }
}

/// Area of the outline of the ellipsoid with the map `axes`, projected along `direction` onto the
/// plane with the unit normal `normal`: its outline, or its shadow.
pub fn outline_area(axes: DMat3, direction: DVec3, normal: DVec3) -> f64 {
    let (u, v) = normal.any_orthonormal_pair();
    let slide = |p: DVec3| p - direction * (p.dot(normal) / direction.dot(normal));
    let [a, b, c] = [axes.x_axis, axes.y_axis, axes.z_axis].map(slide);
    let rows = [u, v].map(|w| DVec3::new(a.dot(w), b.dot(w), c.dot(w)));
    let gram = |i: usize, j: usize| rows[i].dot(rows[j]);
    let squared = DMat2::from_cols_array(&[gram(0, 0), gram(0, 1), gram(1, 0), gram(1, 1)]);
    PI * squared.determinant().sqrt()
}

#[cfg(test)]
mod tests {
    use super::super::sphere::sphere_factor;
    use super::*;
    use crate::reference::core::frame::frame_from_normal;
    use crate::scene::ellipsoid::half_extent;
    use crate::scene::load::{LoadOptions, load};
    use crate::scene::{DirectionalLight, ExpectedRadiance, Geometry, Light, Scene};

    fn maps() -> [DMat3; 5] {
        let turn = rotation(DVec3::new(0.3, -0.5, 0.2));
        let scale = |x, y, z| DMat3::from_diagonal(DVec3::new(x, y, z));
        [
            scale(0.5, 0.9, 0.3),
            turn * scale(1.0, 1.0, 0.2),
            turn * scale(0.1, -1.0, 0.1),
            scale(1.0, 0.5, 0.8) * turn * scale(1.0, 1.0, 0.05),
            DMat3::from_cols(
                DVec3::X,
                DVec3::new(0.7, 0.4, 0.1),
                DVec3::new(0.0, 0.2, 0.3),
            ),
        ]
    }

    /// (1/π) ∫ cosθ dω over the outline's ellipse c + x u + y v, on which dω = |det (u v c)|/|c + x
    /// u + y v|³ dx dy: the trapezoid rule around, the midpoint rule in the squared radius.
    fn factor_by_quadrature(normal: DVec3, to_centre: DVec3, axes: DMat3) -> f64 {
        let q = axes.inverse() * to_centre;
        let part = 1.0 - 1.0 / q.length_squared();
        let frame = frame_from_normal(q.normalize());
        let (c, u, v) = (part * to_centre, axes * frame.x, axes * frame.y);
        let (u, v) = (part.sqrt() * u, part.sqrt() * v);
        let determinant = DMat3::from_cols(u, v, c).determinant().abs();
        let (rings, spokes) = (4000, 240);
        let at = |ring: u32, spoke: u32| {
            let r = ((f64::from(ring) + 0.5) / f64::from(rings)).sqrt();
            let (sin, cos) = (2.0 * PI * f64::from(spoke) / f64::from(spokes)).sin_cos();
            let d = c + r * cos * u + r * sin * v;
            d.dot(normal) / d.length_squared().powi(2)
        };
        let sum: f64 = (0..rings)
            .flat_map(|ring| (0..spokes).map(move |spoke| (ring, spoke)))
            .map(|(ring, spoke)| at(ring, spoke))
            .sum();
        sum * determinant / f64::from(rings * spokes)
    }

    #[test]
    fn an_ellipsoid_above_the_horizon_is_the_integral() {
        let normal = DVec3::new(0.2, -0.3, 0.9).normalize();
        for axes in maps() {
            for to_centre in [
                DVec3::new(0.1, 0.2, 1.3),
                DVec3::new(1.0, -0.5, 1.4),
                DVec3::new(0.3, 0.2, 9.0),
            ] {
                let factor = ellipsoid_factor(DVec3::ONE, normal, to_centre + DVec3::ONE, axes);
                let Some(factor) = factor else { continue };
                let integral = factor_by_quadrature(normal, to_centre, axes);
                assert!(
                    (factor - integral).abs() < 1e-6 * integral,
                    "{axes} {to_centre}: {factor} {integral}"
                );
            }
        }
    }

    #[test]
    fn a_round_one_is_a_sphere_and_a_flat_one_a_disk() {
        let (normal, centre) = (DVec3::Z, DVec3::new(0.5, -0.4, 2.0));
        let round = ellipsoid_factor(DVec3::ZERO, normal, centre, DMat3::IDENTITY).unwrap();
        let sphere = sphere_factor(DVec3::ZERO, normal, centre, 1.0);
        assert!((round / sphere - 1.0).abs() < 1e-14, "{round} {sphere}");
        let flat = DMat3::from_diagonal(DVec3::new(1.0, 1.0, 1e-9));
        let flat = ellipsoid_factor(DVec3::ZERO, normal, centre, flat).unwrap();
        let disk = super::super::disk::disk_parallel(2.0, 1.0, 0.5_f64.hypot(0.4));
        assert!((flat / disk - 1.0).abs() < 1e-8, "{flat} {disk}");
    }

    #[test]
    fn within_below_and_across_the_horizon() {
        let axes = maps()[0];
        let factor = |centre| ellipsoid_factor(DVec3::ZERO, DVec3::Z, centre, axes);
        assert_eq!(factor(DVec3::new(0.1, 0.2, -0.1)), Some(1.0));
        assert_eq!(factor(-2.0 * DVec3::Z), Some(0.0));
        assert_eq!(factor(DVec3::new(2.0, 0.0, 0.2)), None);
    }

    #[test]
    fn outlines_along_an_axis_are_ellipses_of_the_other_two() {
        let axes = DMat3::from_diagonal(DVec3::new(0.5, 2.0, 3.0));
        let area = outline_area(axes, DVec3::Z, DVec3::Z);
        assert!((area - PI).abs() < 1e-14, "{area}");
        // A sphere's shadow is longer by 1/cos.
        let light = DVec3::new(0.0, 3.0, 4.0);
        let area = outline_area(DMat3::IDENTITY, light, DVec3::Z);
        assert!((area - PI / 0.8).abs() < 1e-14, "{area}");
    }

    fn scene(name: &str) -> (Scene, DVec3, DMat3, DVec3) {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/tests");
        let scene = load(&path.join(name), &LoadOptions::default()).unwrap();
        let of_shape = scene.shapes.iter().find_map(|s| match s.geometry {
            Geometry::Ellipsoid { center, axes } => Some((center, axes)),
            _ => None,
        });
        let (center, axes) = of_shape.unwrap();
        let ExpectedRadiance::Mean(mean) = scene.expect.as_ref().unwrap().radiance else {
            panic!("{name} states a mean");
        };
        (scene, center, axes, mean)
    }

    #[test]
    fn the_scenes_state_these_values() {
        for name in ["ellipsoid_light.toml", "ellipsoid_flat_near.toml"] {
            let (scene, center, axes, mean) = scene(name);
            let emitted = scene.shapes.iter().find_map(|s| s.emission).unwrap();
            // Seen from the origin of the plane z = 0, of reflectance ½.
            let factor = ellipsoid_factor(DVec3::ZERO, DVec3::Z, center, axes).unwrap();
            let expected = 0.5 * factor * emitted.radiance;
            assert!(
                (mean / expected - 1.0).abs().max_element() < 1e-9,
                "{name}: {expected}"
            );
        }
        let (scene, _, axes, mean) = scene("ellipsoid_outline_and_shadow.toml");
        let Light::Directional(DirectionalLight {
            direction,
            irradiance,
        }) = scene.lights[0]
        else {
            panic!("a directional light");
        };
        let hidden = [DVec3::Z, direction].map(|along| outline_area(axes, along, DVec3::Z));
        let lit = 1.0 - hidden.iter().sum::<f64>() / 64.0;
        let expected = 0.5 / PI * -direction.z * irradiance * lit;
        assert!(
            (mean / expected - 1.0).abs().max_element() < 1e-9,
            "{expected}"
        );
    }

    #[test]
    fn the_shadow_of_the_scene_lies_apart_and_in_view() {
        let (scene, center, axes, _) = scene("ellipsoid_outline_and_shadow.toml");
        let Light::Directional(DirectionalLight { direction, .. }) = scene.lights[0] else {
            panic!("a directional light");
        };
        let half = half_extent(axes);
        let slide = |p: DVec3| p - direction * (p.z / direction.z);
        let shadow = DMat3::from_cols(slide(axes.x_axis), slide(axes.y_axis), slide(axes.z_axis));
        let (foot, reach) = (slide(center), half_extent(shadow));
        assert!(foot.x - reach.x > center.x + half.x, "{foot} {reach}");
        assert!(foot.x + reach.x < 4.0 && foot.y.abs() + reach.y < 4.0);
        assert!(center.x - half.x > -4.0 && center.y.abs() + half.y < 4.0);
    }
}
