//! The uniform of a render: camera, film, random numbers, and what kernels know of the scene as a
//! whole.

use super::layout::{FILTER_WORDS, Frame, TILE};
use super::lights::first_emission_word;
use crate::emitters::{Emitter, Selection};
use crate::prepare::Prepared;
use crate::scene::environment::Interpolation;
use crate::scene::filter::FilterTable;
use crate::scene::{EnvironmentRadiance, FilmSize};
use glam::DVec3;

/// The uniform that stays the same for a render.
pub fn frame_of(prepared: &Prepared, film: FilmSize, seed: u32) -> Frame {
    let camera = prepared.data.normalization.camera(&prepared.camera);
    let half_height = camera.half_height();
    let f3 = |v: DVec3| v.as_vec3().to_array();
    let filter = prepared.data.scene.filter.table();
    let patterns = prepared.patterns();
    let shadow_grid = prepared.shadow_grid();
    let near_plane = prepared.near_plane();
    let mut frame = Frame {
        eye: f3(camera.eye + near_plane * camera.forward),
        width: film.width,
        right: f3(camera.right * (half_height * film.aspect())),
        height: film.height,
        up: f3(camera.up * half_height),
        seed,
        forward: f3(camera.forward),
        tiles_per_row: film.width.div_ceil(TILE),
        grid_origin: prepared.data.bvh.grid.origin.to_array(),
        root: prepared.data.bvh.root,
        grid_scale: prepared.data.bvh.grid.scale.to_array(),
        light_count: prepared.emitters.lights.len() as u32,
        far: (4.0 * prepared.data.normalization.reach) as f32,
        pattern: patterns.pixel,
        light_pattern: patterns.light,
        shadow_rays: shadow_grid.rays,
        shadow_columns: shadow_grid.columns,
        shadow_steps: shadow_grid.steps,
        max_specular_depth: prepared.settings.estimator.max_specular_depth,
        filter_cell: filter.cell_width,
        orthographic: u32::from(camera.is_orthographic()),
        lens_right: f3(camera.right * camera.lens.radius),
        inverse_focus_distance: if camera.lens.radius > 0.0 {
            (1.0 / camera.lens.focus_distance) as f32
        } else {
            0.0
        },
        lens_up: f3(camera.up * camera.lens.radius),
        near_plane: near_plane as f32,
        near_lens: if camera.lens.radius > 0.0 {
            (1.0 - near_plane / camera.lens.focus_distance) as f32
        } else {
            1.0
        },
        logarithmic_grid: u32::from(prepared.data.bvh.grid.logarithmic),
        filter_knots: filter_words(&filter),
        ..Frame::default()
    };
    for (words, &[x, y, z]) in frame.light_boxes.iter_mut().zip(&prepared.light_boxes) {
        *words = [x, y, z, 0];
    }
    let (first_sun, suns) = prepared.emitters.suns();
    frame.first_sun = first_sun as u32;
    frame.suns = suns as u32;
    frame.first_emission = first_emission_word(prepared);
    let tree = prepared.emitters.selection.as_ref();
    if let Some(tree) = tree.and_then(Selection::tree) {
        frame.light_grid_origin = tree.grid.origin;
        frame.light_grid_step = tree.grid.step;
        frame.tree_nodes = tree.nodes.len() as u32;
        frame.infinite_lights = tree.infinite.len() as u32;
    }
    if let Some(environment) = &prepared.data.scene.environment {
        let to_map = environment.rotation.transpose();
        let per_unit = 1.0 / prepared.emitters.unit;
        let row = |i: usize| f3(to_map.row(i));
        [
            frame.environment_x,
            frame.environment_y,
            frame.environment_z,
        ] = [row(0), row(1), row(2)];
        let index = prepared
            .emitters
            .lights
            .iter()
            .position(|l| *l == Emitter::Environment);
        frame.environment_samples = index.map_or(0.0, |i| prepared.light_samples(i)) as f32;
        match &environment.radiance {
            EnvironmentRadiance::Constant(radiance) => {
                frame.environment_radiance = f3(*radiance * environment.scale * per_unit);
            }
            EnvironmentRadiance::Map(map) => {
                frame.environment_radiance = [(environment.scale * per_unit) as f32; 3];
                [frame.environment_width, frame.environment_height] = [map.width, map.height];
                frame.environment_linear = u32::from(map.interpolation == Interpolation::Linear);
            }
        }
    }
    let grid = prepared.emitters.environment.as_ref();
    frame.environment_grid = grid.map_or([1, 1], |grid| grid.size);
    frame
}

/// Two ends of cells per word.
fn filter_words(table: &FilterTable) -> [[f32; 4]; FILTER_WORDS] {
    std::array::from_fn(|word| {
        let knot = |i: usize| table.knots.get(i).copied().unwrap_or([1.0, 0.0]);
        let ([a, b], [c, d]) = (knot(2 * word), knot(2 * word + 1));
        [a, b, c, d]
    })
}
