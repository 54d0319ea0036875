//! What shows small lights by chance: mirrors, glass and lobes, as flat or as curved as they are.

use super::SceneData;
use super::view::View;
use crate::accel::octahedral::from_octahedral;
use crate::accel::{Primitive, PrimitiveGeometry};
use glam::{DVec2, DVec3};
use std::collections::BTreeMap;
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

    /// At most the solid angle of the directions in which it sends the rays of a pixel of `view`.
    pub(super) fn spread(self, view: &View) -> f64 {
        let [width, at_one] = view.pixel_widths();
        let turned = 2.0 * self.curvature * width;
        (at_one * at_one + turned * turned).min(4.0 * PI)
    }
}

/// The materials of the scene that reflect, each as curved as anything made of it. Normal maps count as
/// flat.
pub(super) fn shiny_materials(data: &SceneData) -> Vec<Shiny> {
    let materials = data.scene.materials.iter();
    let lobe = |alpha: f64| 12.0 * PI * alpha * alpha;
    let lobes = materials.map(|m| Some(lobe(m.bsdf.parameters().specular?.alpha)));
    let lobes: Vec<_> = lobes.collect();
    let mut found: BTreeMap<usize, Shiny> = BTreeMap::new();
    for (index, primitive) in data.primitives.iter().enumerate() {
        let material = primitive.material.index();
        if let Some(lobe) = lobes[material] {
            let flat = Shiny {
                lobe,
                curvature: 0.0,
            };
            let shiny = found.entry(material).or_insert(flat);
            shiny.curvature = shiny.curvature.max(curvature(data, index, primitive));
        }
    }
    found.into_values().collect()
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
