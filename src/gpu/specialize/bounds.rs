//! Planes that all of a scene lies on one side of: shadow rays never cross them.

use crate::accel::{Primitive, PrimitiveGeometry};
use crate::effects::Effect;
use crate::emitters::Emitter;
use crate::prepare::Prepared;
use glam::DVec3;
use std::collections::BTreeSet;

/// The primitives, of those that are written out, in whose plane or on one side of it, up to `slack`,
/// the scene and all its lights lie, so that a ray between two of their points does not cross them.
/// None where light comes from beyond all surfaces. None where it passes through them: a point on
/// the other side of such a plane sees no light otherwise, as all are below its horizon.
pub(super) fn bounding(prepared: &Prepared, slack: f64) -> BTreeSet<usize> {
    let (all, written) = (&prepared.data.primitives, prepared.written_out());
    let primitives = &all[written.clone()];
    let loaded = prepared.loaded().map(|small| small.bounds);
    let never = [
        Effect::Refraction,
        Effect::DirectionalLights,
        Effect::Suns,
        Effect::Environment,
    ];
    if never.iter().any(|e| prepared.effects.contains(*e)) {
        return BTreeSet::new();
    }
    let lights = prepared.emitters.lights.iter();
    let points = lights.filter_map(|light| match light {
        Emitter::Delta(light) => light.position(),
        _ => None,
    });
    let points: Vec<DVec3> = points.collect();
    let is_bounding = |p: &Primitive| {
        let (PrimitiveGeometry::Triangle { a, u, v }
        | PrimitiveGeometry::Rectangle { a, u, v }
        | PrimitiveGeometry::Disk { a, u, v }) = p.geometry
        else {
            return false;
        };
        let n = u.cross(v).normalize_or_zero();
        let heights = primitives.iter().map(|p| range(&p.geometry, n));
        let of_points = points.iter().map(|x| [n.dot(*x); 2]);
        let of_loaded = loaded.map(|[low, high]| {
            let half = 0.5 * n.abs().dot(high - low);
            around(n, 0.5 * (low + high), half)
        });
        let plane = n.dot(a);
        let (mut before, mut behind) = (true, true);
        for [low, high] in heights.chain(of_points).chain(of_loaded) {
            before &= low >= plane - slack;
            behind &= high <= plane + slack;
        }
        before || behind
    };
    written.filter(|index| is_bounding(&all[*index])).collect()
}

/// What is as far as `half` from `middle` along `n`.
fn around(n: DVec3, middle: DVec3, half: f64) -> [f64; 2] {
    [n.dot(middle) - half, n.dot(middle) + half]
}

/// The least and the greatest n · x of points x of a primitive, or beyond.
fn range(geometry: &PrimitiveGeometry, n: DVec3) -> [f64; 2] {
    let around = |middle: DVec3, half: f64| around(n, middle, half);
    match *geometry {
        PrimitiveGeometry::Triangle { a, u, v } => {
            let [a, b, c] = [a, a + u, a + v].map(|corner| n.dot(corner));
            [a.min(b).min(c), a.max(b).max(c)]
        }
        PrimitiveGeometry::Rectangle { a, u, v } => {
            around(a + 0.5 * (u + v), 0.5 * (n.dot(u).abs() + n.dot(v).abs()))
        }
        PrimitiveGeometry::Disk { a, u, v } => around(a, n.dot(u).hypot(n.dot(v))),
        PrimitiveGeometry::Sphere { .. } | PrimitiveGeometry::Ellipsoid { .. } => {
            let (middle, radius) = geometry.bounding_sphere();
            around(middle, radius)
        }
    }
}
