//! Makes lights larger that are too small for f32, and dimmer by as much.
//!
//! The normal of a planar light is the product of its edges, whose square underflows below 10⁻¹⁹; a
//! density is the reciprocal of its area. From anywhere else a light so small is a point: what
//! arrives depends on its power alone.

use super::ellipsoid::PrincipalAxes;
use super::normalize::Normalization;
use super::{Geometry, Scene};

/// Smallest size of a light, normalised space: its coordinates are rounded to 2⁻²⁴ of their
/// distance from the centre.
const MIN_SIZE: f64 = 1.0 / 268_435_456.0;

/// Enlarges the lights of `scene` that are smaller than f32 can be sure of, about their middle;
/// their power stays.
pub fn enlarge(scene: &mut Scene, normalization: &Normalization) {
    let least = MIN_SIZE / normalization.scale;
    for shape in &mut scene.shapes {
        if let Some(emission) = &mut shape.emission {
            emission.radiance /= enlarged(&mut shape.geometry, least);
        }
    }
}

/// Gives `geometry` the size `least` along its axes where it has less; returns the factor of its
/// area.
fn enlarged(geometry: &mut Geometry, least: f64) -> f64 {
    // What has no length cannot be scaled to one.
    let factor = |length: f64| {
        if length > 0.0 {
            (least / length).max(1.0)
        } else {
            1.0
        }
    };
    match geometry {
        Geometry::Rectangle { corner, u, v } => {
            let [of_u, of_v] = [*u, *v].map(|edge| factor(edge.length()));
            *corner -= 0.5 * (of_u - 1.0) * *u + 0.5 * (of_v - 1.0) * *v;
            (*u, *v) = (of_u * *u, of_v * *v);
            of_u * of_v
        }
        Geometry::Disk { u, v, .. } => {
            let [of_u, of_v] = [*u, *v].map(|axis| factor(axis.length()));
            (*u, *v) = (of_u * *u, of_v * *v);
            of_u * of_v
        }
        Geometry::Mesh(mesh) => {
            let (low, high) = mesh.bounds().unwrap_or_default();
            let size = (high - low).max_element();
            let of_size = if size > 0.0 { factor(size) } else { 1.0 };
            if of_size > 1.0 {
                let middle = 0.5 * (low + high);
                let positions = mesh.positions.iter_mut();
                positions.for_each(|p| *p = middle + of_size * (*p - middle));
            }
            of_size * of_size
        }
        Geometry::Sphere { radius, .. } => {
            let of_radius = factor(*radius);
            *radius *= of_radius;
            of_radius * of_radius
        }
        Geometry::Ellipsoid { axes, .. } => {
            let of_longest = factor(PrincipalAxes::of(*axes).radii.max_element());
            *axes *= of_longest;
            of_longest * of_longest
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn the_power_of_a_tiny_light_stays() {
        let disk = |radius: f64| Geometry::Disk {
            center: DVec3::ONE,
            u: DVec3::X * radius,
            v: DVec3::Z * radius,
        };
        let mut tiny = disk(1e-30);
        let factor = enlarged(&mut tiny, 1e-8);
        assert!((factor * 1e-44 - 1.0).abs() < 1e-12, "{factor:e}");
        let Geometry::Disk { center, u, v } = tiny else {
            unreachable!("a disk stays a disk");
        };
        assert_eq!(center, DVec3::ONE);
        assert!((u.length() - 1e-8).abs() < 1e-20 && (v.length() - 1e-8).abs() < 1e-20);
        let mut large = disk(1e-7);
        assert!((enlarged(&mut large, 1e-8) - 1.0).abs() < f64::EPSILON);
        assert_eq!(large, disk(1e-7));
    }

    #[test]
    fn a_strip_grows_across_alone() {
        let mut strip = Geometry::Rectangle {
            corner: DVec3::ZERO,
            u: DVec3::X,
            v: DVec3::Y * 1e-20,
        };
        assert!((enlarged(&mut strip, 1e-8) * 1e-12 - 1.0).abs() < 1e-12);
        let Geometry::Rectangle { corner, u, v } = strip else {
            unreachable!("a rectangle stays one");
        };
        assert_eq!(u, DVec3::X);
        assert!((v.y - 1e-8).abs() < 1e-20 && (corner.y + 0.5e-8).abs() < 1e-20);
    }
}
