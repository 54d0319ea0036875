//! What shows small lights by chance: mirrors, glass and lobes, as flat or as curved as they are.

use super::SceneData;
use crate::accel::octahedral::from_octahedral;
use crate::accel::{Primitive, PrimitiveGeometry};
use crate::scene::{Camera, FilmSize};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// What shows lights by chance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Shiny {
    /// Solid angle over which it spreads what a ray meets, as in `note_highlight`: 0 where mirrors,
    /// glass or the camera show a light as it is.
    pub(super) lobe: f64,
    /// One over its smallest radius of curvature, normalised space.
    curvature: f64,
}

impl Shiny {
    /// The camera, which shows lights without anything between.
    pub(super) const CAMERA: Self = Self {
        lobe: 0.0,
        curvature: 0.0,
    };

    /// At most the solid angle of the directions in which it sends the rays of a pixel that is `side`
    /// wide at distance 1, at most `distance` away.
    pub(super) fn spread(self, side: f64, distance: f64) -> f64 {
        let turned = 2.0 * self.curvature * side * distance;
        (side * side + turned * turned).min(4.0 * PI)
    }
}

/// The materials of the scene that reflect, each as curved as anything made of it. Normal maps count as
/// flat.
pub(super) fn shiny_materials(data: &SceneData) -> Vec<Shiny> {
    let lobe_of = |material: &crate::scene::Material| {
        let lobe = material.bsdf.parameters().specular?;
        Some(Shiny {
            lobe: 12.0 * PI * lobe.alpha * lobe.alpha,
            curvature: 0.0,
        })
    };
    let mut found: Vec<_> = data.scene.materials.iter().map(lobe_of).collect();
    let mut is_used = vec![false; found.len()];
    for (index, primitive) in data.primitives.iter().enumerate() {
        let material = primitive.material.index();
        if let Some(shiny) = &mut found[material] {
            is_used[material] = true;
            shiny.curvature = shiny.curvature.max(curvature(data, index, primitive));
        }
    }
    let used = found.into_iter().zip(is_used).filter(|(_, used)| *used);
    used.filter_map(|(shiny, _)| shiny).collect()
}

/// The largest curvature of primitive `index`.
fn curvature(data: &SceneData, index: usize, primitive: &Primitive) -> f64 {
    match primitive.geometry {
        PrimitiveGeometry::Sphere { radius, .. } => 1.0 / radius,
        // At the ends of the longest axis.
        PrimitiveGeometry::Ellipsoid { radii, .. } => {
            radii.max_element() / radii.min_element().powi(2)
        }
        PrimitiveGeometry::Triangle { u, v, .. } => {
            let attributed = &data.attributes.of_primitive[index];
            if !attributed.normals {
                return 0.0;
            }
            let encoded = data.attributes.normals(attributed);
            let normals = encoded.map(|n| from_octahedral(DVec2::from(n.map(f64::from))));
            let [a, b, c] = normals.map(DVec3::normalize);
            let along = |turn: DVec3, edge: DVec3| turn.length() / edge.length();
            along(b - a, u)
                .max(along(c - a, v))
                .max(along(c - b, v - u))
        }
        PrimitiveGeometry::Rectangle { .. } | PrimitiveGeometry::Disk { .. } => 0.0,
    }
}

/// How wide a pixel is at distance 1 with what the lens adds to it, and how far away at most what it
/// shows is; where rays are parallel, at any distance.
pub(super) fn pixel_of(data: &SceneData, camera: &Camera, film: FilmSize) -> (f64, f64) {
    let camera = data.normalization.camera(camera);
    let side = 2.0 * camera.half_height() / f64::from(film.height);
    if camera.is_orthographic() {
        return (side, 1.0);
    }
    let blur = 2.0 * camera.lens.radius / camera.lens.focus_distance;
    let distance = camera.eye.length() + data.normalization.reach;
    (side + blur, distance)
}
