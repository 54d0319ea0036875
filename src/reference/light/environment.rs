//! The environment; see `shaders/light/environment.wesl`.

use super::alias_table::alias_choice;
use super::sample::{FAR, LightSample};
use super::sphere::sample_sphere_area;
use crate::reference::core::math::{angle_of, sin_cos_two_pi};
use crate::reference::core::pdf::{PdfArea, PdfDiscrete, PdfSolidAngle, chosen};
use crate::reference::scene::fetch::World;
use crate::scene::environment::Interpolation;
use crate::scene::{Environment, EnvironmentMap, EnvironmentRadiance};
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// The unit direction at azimuth fraction `u` (0 at the image's left edge), `depth` below the
/// zenith in z or, where `south`, above the nadir.
pub fn direction_from_map(u: f64, depth: f64, south: bool) -> DVec3 {
    let r = (depth * (2.0 - depth)).max(0.0).sqrt();
    let sc = sin_cos_two_pi(u);
    let y = if south { depth - 1.0 } else { 1.0 - depth };
    DVec3::new(-sc.x * r, y, sc.y * r)
}

/// Image coordinates in [0, 1]² of a unit direction in the map's space; row 0 is the zenith.
pub fn map_from_direction(d: DVec3) -> DVec2 {
    let azimuth = angle_of(-d.x, d.z) / TAU;
    let polar = angle_of(d.x.hypot(d.z), d.y) / PI;
    DVec2::new(
        if azimuth < 0.0 {
            azimuth + 1.0
        } else {
            azimuth
        },
        polar,
    )
}

/// Depth in z of the edge above row `row`: 1 − cos(π j/H).
pub fn row_depth(row: u32, height: u32) -> f64 {
    2.0 * (0.5 * PI * f64::from(row) / f64::from(height))
        .sin()
        .powi(2)
}

/// Height of row `row` in z: cos(π j/H) − cos(π (j+1)/H).
pub fn row_height(row: u32, height: u32) -> f64 {
    crate::emitters::row_height(f64::from(row), f64::from(height))
}

/// A direction in the cell (column, row) of a `grid[0]` × `grid[1]` map.
pub fn sample_environment_cell(cell: [u32; 2], grid: [u32; 2], u: DVec2) -> DVec3 {
    let south = 2 * cell[1] >= grid[1];
    let (row, v) = if south {
        (grid[1] - 1 - cell[1], 1.0 - u.y)
    } else {
        (cell[1], u.y)
    };
    let depth = row_depth(row, grid[1]) + v * row_height(row, grid[1]);
    direction_from_map(
        (f64::from(cell[0]) + u.x) / f64::from(grid[0]),
        depth,
        south,
    )
}

/// Density of [`sample_environment_cell`] when the cell has probability `choice`.
pub fn pdf_environment_cell(choice: PdfDiscrete, row: u32, grid: [u32; 2]) -> PdfSolidAngle {
    PdfSolidAngle(choice.0 * f64::from(grid[0]) / (TAU * row_height(row, grid[1])))
}

/// The texels around a point of the image and how to blend them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BilinearTexels {
    /// Column on the left.
    pub left: u32,
    /// Column on the right.
    pub right: u32,
    /// Row above.
    pub top: u32,
    /// Row below.
    pub bottom: u32,
    /// Weight of the right column and of the bottom row.
    pub blend: DVec2,
}

/// `position` is in texels, in [0, size]; texel centres lie at ½. Columns wrap around, rows end at
/// the poles.
pub fn bilinear_texels(position: DVec2, [width, height]: [u32; 2]) -> BilinearTexels {
    let p = position - DVec2::splat(0.5);
    let low = p.floor();
    let column = |x: f64| (x as i64).rem_euclid(i64::from(width)) as u32;
    let row = |y: f64| (y as i64).clamp(0, i64::from(height) - 1) as u32;
    BilinearTexels {
        left: column(low.x),
        right: column(low.x + 1.0),
        top: row(low.y),
        bottom: row(low.y + 1.0),
        blend: p - low,
    }
}

fn environment<'a>(world: &World<'a>) -> &'a Environment {
    let environment = world.prepared.data.scene.environment.as_ref();
    environment.expect("only a scene with an environment asks for it")
}

fn texel(map: &EnvironmentMap, column: u32, row: u32) -> DVec3 {
    let rgb = map.texels[row as usize * map.width as usize + column as usize];
    DVec3::from_array(rgb.map(f64::from))
}

/// Radiance of `map` at image coordinates in [0, 1]².
fn map_radiance(map: &EnvironmentMap, image: DVec2) -> DVec3 {
    let position = image * DVec2::new(f64::from(map.width), f64::from(map.height));
    match map.interpolation {
        Interpolation::Linear => {
            let n = bilinear_texels(position, [map.width, map.height]);
            let top = texel(map, n.left, n.top).lerp(texel(map, n.right, n.top), n.blend.x);
            let left = texel(map, n.left, n.bottom);
            let bottom = left.lerp(texel(map, n.right, n.bottom), n.blend.x);
            top.lerp(bottom, n.blend.y)
        }
        Interpolation::Nearest => texel(
            map,
            (position.x as u32).min(map.width - 1),
            (position.y as u32).min(map.height - 1),
        ),
    }
}

/// Radiance that arrives from the environment in the unit direction `direction`; 0 where there is
/// none.
pub fn environment_radiance(world: &World<'_>, direction: DVec3) -> DVec3 {
    let Some(environment) = &world.prepared.data.scene.environment else {
        return DVec3::ZERO;
    };
    if !world
        .prepared
        .emitters
        .index_of_environment()
        .is_none_or(|index| world.shines(index))
    {
        return DVec3::ZERO;
    }
    let to_map = environment.rotation.transpose();
    environment.scale
        * match &environment.radiance {
            EnvironmentRadiance::Constant(radiance) => *radiance,
            EnvironmentRadiance::Map(map) => {
                map_radiance(map, map_from_direction(to_map * direction))
            }
        }
}

/// Probability that light selection chooses the environment.
fn environment_selection(world: &World<'_>) -> PdfDiscrete {
    let probability = |i| world.prepared.emitters.probability(i);
    PdfDiscrete(
        world
            .prepared
            .emitters
            .index_of_environment()
            .map_or(0.0, probability),
    )
}

/// The cell of the environment's sampling grid in the unit direction `direction`, and its
/// probability; `None` where the environment has no map.
fn environment_cell(world: &World<'_>, direction: DVec3) -> Option<([u32; 2], PdfDiscrete)> {
    let grid = world.prepared.emitters.environment.as_ref()?;
    let [width, height] = grid.size;
    let image = map_from_direction(environment(world).rotation.transpose() * direction);
    let column = ((image.x * f64::from(width)) as u32).min(width - 1);
    let row = ((image.y * f64::from(height)) as u32).min(height - 1);
    let p = grid.table.probability[row as usize * width as usize + column as usize];
    Some(([column, row], PdfDiscrete(p)))
}

/// Angle between `direction` and the edge of its cell of the environment's sampling grid; π where
/// there is no map.
pub fn environment_cell_margin(world: &World<'_>, direction: DVec3) -> f64 {
    let Some(grid) = &world.prepared.emitters.environment else {
        return PI;
    };
    let image = map_from_direction(environment(world).rotation.transpose() * direction);
    let cells = DVec2::new(f64::from(grid.size[0]), f64::from(grid.size[1]));
    let margin = (image * cells - (image * cells).round()).abs() / cells;
    let sin_polar = (PI * image.y).sin();
    f64::min(margin.x * 2.0 * PI * sin_polar, margin.y * PI)
}

/// Density of a cell with probability `p` on the unit square of the environment's image.
fn pdf_on_image(p: PdfDiscrete, [width, height]: [u32; 2]) -> PdfArea {
    PdfArea(p.0 * f64::from(width) * f64::from(height))
}

/// Density of [`sample_environment`] in the unit direction `direction`: probability of the
/// environment, density on its image, and per solid angle with light selection included.
pub fn pdf_environment(
    world: &World<'_>,
    direction: DVec3,
) -> (PdfDiscrete, Option<PdfArea>, PdfSolidAngle) {
    let selection = environment_selection(world);
    let grid = world.prepared.emitters.environment.as_ref();
    let (on_image, pdf) = match (grid, environment_cell(world, direction)) {
        (Some(grid), Some((cell, p))) => (
            Some(pdf_on_image(p, grid.size)),
            pdf_environment_cell(p, cell[1], grid.size),
        ),
        _ => (Some(PdfArea(1.0)), PdfSolidAngle(1.0 / (4.0 * PI))),
    };
    (selection, on_image, chosen(selection, pdf))
}

/// A direction towards the environment, in proportion to the luminance of its map.
pub fn sample_environment(
    world: &World<'_>,
    selection: PdfDiscrete,
    x: DVec3,
    u: DVec2,
    texel: u32,
) -> LightSample {
    let (direction, on_image, pdf) = match &world.prepared.emitters.environment {
        Some(grid) => {
            let choice = alias_choice(texel, &grid.table);
            let cell = [choice.index % grid.size[0], choice.index / grid.size[0]];
            (
                environment(world).rotation * sample_environment_cell(cell, grid.size, u),
                Some(pdf_on_image(choice.probability, grid.size)),
                pdf_environment_cell(choice.probability, cell[1], grid.size),
            )
        }
        None => (
            sample_sphere_area(u),
            Some(PdfArea(1.0)),
            PdfSolidAngle(1.0 / (4.0 * PI)),
        ),
    };
    let pdf = chosen(selection, pdf);
    LightSample {
        wi: direction,
        target_point: x + direction * FAR,
        radiance_over_pdf: environment_radiance(world, direction) / pdf.0.max(1e-30),
        pdf,
        pdf_on_light: on_image,
        cos_light: 1.0,
        delta: false,
    }
}
