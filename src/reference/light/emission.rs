//! Emission that varies over a light; see `shaders/light/emission.wesl`.

use super::alias_table::alias_choice;
use super::disk::invert_disk_area;
use super::triangle::invert_triangle_area;
use crate::accel::PrimitiveGeometry;
use crate::emitters::{EmissionMap, Emitter};
use crate::reference::core::pdf::{PdfArea, PdfDiscrete};
use crate::reference::scene::attributes::interpolate_uv;
use crate::reference::scene::fetch::World;
use crate::reference::scene::texture::sample_texture;
use glam::{DVec2, DVec3};

/// The emission map of light `index`, where it has one.
pub fn emission_map<'a>(world: &World<'a>, index: u32) -> Option<&'a EmissionMap> {
    let emitters = &world.prepared.emitters;
    match emitters.lights[index as usize] {
        Emitter::Area { map, .. } => map.map(|map| &emitters.maps[map as usize]),
        _ => None,
    }
}

/// Factor on the light's radiance at its coordinates `st`.
pub fn emission_factor(world: &World<'_>, m: &EmissionMap, st: DVec2) -> DVec3 {
    let uvs = m.uvs.map(|[u, v]| DVec2::new(u.into(), v.into()));
    sample_texture(world, &m.texture, interpolate_uv(&uvs, st)).truncate()
}

/// A point of the unit square in proportion to the emission, and the density there: `texel` chooses
/// the cell, `u` the point in it.
pub fn sample_emission(m: &EmissionMap, u: DVec2, texel: u32) -> (DVec2, PdfArea) {
    let choice = alias_choice(texel, &m.table);
    let [columns, rows] = m.grid;
    let cell = DVec2::new(
        (choice.index % columns).into(),
        (choice.index / columns).into(),
    );
    let grid = DVec2::new(columns.into(), rows.into());
    ((cell + u) / grid, pdf_emission_cell(m, choice.probability))
}

/// Density on the unit square where its cell has probability `p`.
fn pdf_emission_cell(m: &EmissionMap, p: PdfDiscrete) -> PdfArea {
    PdfArea(p.0 * f64::from(m.grid[0] * m.grid[1]))
}

/// Density of [`sample_emission`] at the point `u` of the unit square.
pub fn pdf_emission(m: &EmissionMap, u: DVec2) -> PdfArea {
    let [columns, rows] = m.grid;
    let column = ((u.x * f64::from(columns)) as u32).min(columns - 1);
    let row = ((u.y * f64::from(rows)) as u32).min(rows - 1);
    let p = m.table.probability[(row * columns + column) as usize];
    pdf_emission_cell(m, PdfDiscrete(p))
}

/// Distance of the point `u` of the unit square from the edge of its cell, along an axis.
pub fn emission_cell_margin(m: &EmissionMap, u: DVec2) -> f64 {
    let grid = DVec2::new(m.grid[0].into(), m.grid[1].into());
    let margin = (u * grid - (u * grid).round()).abs() / grid;
    margin.min_element()
}

/// Where the unit square has the point `st` of a light.
pub fn invert_light_area(geometry: &PrimitiveGeometry, st: DVec2) -> DVec2 {
    match geometry {
        PrimitiveGeometry::Triangle { .. } => invert_triangle_area(st),
        PrimitiveGeometry::Disk { .. } => invert_disk_area(st),
        _ => st,
    }
}
