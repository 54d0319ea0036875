//! The uniform of a render: camera, film, random numbers, and what kernels know of the scene as a
//! whole.

use super::layout::{
    BvhUniform, CameraUniform, EnvironmentUniform, FILTER_WORDS, FilmUniform, Frame,
    LightInViewUniform, LightTreeUniform, LightsUniform, POINTS_OF_FILM, POINTS_OF_LENS,
    POINTS_OF_PIXEL, PatternsUniform, SMALL_BODY, SMALL_DISTANT, SMALL_PLANAR, SMALL_POINT,
    SMALL_TWO_SIDED, ShadowUniform, SmallLightUniform, TILE,
};
use super::lights::first_emission_word;
use crate::emitters::Selection;
use crate::prepare::lights_in_view::{MAX_LIGHTS_IN_VIEW, PointsInView};
use crate::prepare::small_lights::{Extent, MAX_SMALL_LIGHTS};
use crate::prepare::{Patterns, Prepared};
use crate::scene::environment::Interpolation;
use crate::scene::filter::FilterTable;
use crate::scene::{EnvironmentRadiance, FilmSize, ShadowGrid};
use glam::DVec3;

/// The uniform that stays the same for a render.
pub fn frame_of(prepared: &Prepared, film: FilmSize, seed: u32) -> Frame {
    let camera = prepared.data.normalization.camera(&prepared.camera);
    let half_height = camera.half_height();
    let (bvh, small) = (&prepared.data.bvh, prepared.loaded());
    let filter = prepared.data.scene.filter.table();
    let near_plane = prepared.near_plane();
    let lens = camera.lens;
    let has_lens = lens.radius > 0.0;
    Frame {
        camera: CameraUniform {
            eye: f3(camera.eye + near_plane * camera.forward),
            near_plane: near_plane as f32,
            right: f3(camera.right * (half_height * film.aspect())),
            near_lens: if has_lens {
                (1.0 - near_plane / lens.focus_distance) as f32
            } else {
                1.0
            },
            up: f3(camera.up * half_height),
            inverse_focus_distance: if has_lens {
                (1.0 / lens.focus_distance) as f32
            } else {
                0.0
            },
            forward: f3(camera.forward),
            orthographic: u32::from(camera.is_orthographic()),
            lens_right: f3(camera.right * lens.radius),
            max_specular_depth: prepared.settings.estimator.max_specular_depth,
            lens_up: f3(camera.up * lens.radius),
            padding: 0,
        },
        film: FilmUniform {
            width: film.width,
            height: film.height,
            tiles_per_row: film.width.div_ceil(TILE),
            filter_cell: filter.cell_width,
            filter_knots: filter_words(&filter),
        },
        bvh: BvhUniform {
            grid_origin: bvh.grid.origin.to_array(),
            root: small.map_or(bvh.root, |small| small.root),
            grid_scale: bvh.grid.scale.to_array(),
            logarithmic_grid: u32::from(bvh.grid.logarithmic),
            small_box: small.map_or([0; 3], |small| small.grid_box),
            padding: 0,
        },
        environment: environment_of(prepared),
        light_tree: light_tree_of(prepared),
        lights: lights_of(prepared),
        patterns: prepared.patterns().into(),
        shadow: prepared.shadow_grid().into(),
        seed,
        far: (4.0 * prepared.data.normalization.reach) as f32,
        lights_in_view_count: prepared.lights_in_view.len() as u32,
        small_lights_count: prepared.small_lights.len() as u32,
        lights_in_view: lights_in_view_of(prepared),
        small_lights: small_lights_of(prepared),
    }
}

impl From<ShadowGrid> for ShadowUniform {
    fn from(grid: ShadowGrid) -> Self {
        Self {
            rays: grid.rays,
            columns: grid.columns,
            steps: grid.steps,
        }
    }
}

impl From<Patterns> for PatternsUniform {
    fn from(Patterns { pixel, light }: Patterns) -> Self {
        Self { pixel, light }
    }
}

fn lights_of(prepared: &Prepared) -> LightsUniform {
    let (first_sun, suns) = prepared.emitters.suns();
    let mut lights = LightsUniform {
        count: prepared.emitters.lights.len() as u32,
        first_sun: first_sun as u32,
        suns: suns as u32,
        first_emission: first_emission_word(prepared),
        ..LightsUniform::default()
    };
    for (words, &[x, y, z]) in lights.boxes.iter_mut().zip(&prepared.light_boxes) {
        *words = [x, y, z, 0];
    }
    lights
}

fn lights_in_view_of(prepared: &Prepared) -> [LightInViewUniform; MAX_LIGHTS_IN_VIEW] {
    let mut uniforms = [LightInViewUniform::default(); MAX_LIGHTS_IN_VIEW];
    for (uniform, seen) in uniforms.iter_mut().zip(&prepared.lights_in_view) {
        let ([x0, y0], [x1, y1]) = (seen.low.to_array(), seen.high.to_array());
        *uniform = LightInViewUniform {
            bounds: [x0, y0, x1, y1].map(|x| x as f32),
            light: seen.light,
            points: match seen.points {
                PointsInView::OfFilm => POINTS_OF_FILM,
                PointsInView::OfLens => POINTS_OF_LENS,
                PointsInView::OfPixel => POINTS_OF_PIXEL,
            },
            per_sample: seen.per_sample,
            padding: 0,
        };
    }
    uniforms
}

fn small_lights_of(prepared: &Prepared) -> [SmallLightUniform; MAX_SMALL_LIGHTS] {
    let per_unit = 1.0 / prepared.emitters.unit;
    let mut uniforms = [SmallLightUniform::default(); MAX_SMALL_LIGHTS];
    for (uniform, light) in uniforms.iter_mut().zip(&prepared.small_lights) {
        let (area, radius, kind) = match light.extent {
            Extent::Body { radius, area } => (area * DVec3::X, radius, SMALL_BODY),
            Extent::Planar {
                radius,
                area,
                two_sided,
            } => (
                area,
                radius,
                if two_sided {
                    SMALL_TWO_SIDED
                } else {
                    SMALL_PLANAR
                },
            ),
            Extent::Distant { solid_angle } => (solid_angle * DVec3::X, 0.0, SMALL_DISTANT),
            Extent::Point { axis, cos_outer } => (axis, cos_outer, SMALL_POINT),
        };
        *uniform = SmallLightUniform {
            place: f3(light.place),
            radius: radius as f32,
            area: f3(area),
            kind,
            strength: f3(light.strength * per_unit),
            is_in_view: u32::from(light.is_in_view),
        };
    }
    uniforms
}

/// Zeros where lights are not chosen by a tree.
fn light_tree_of(prepared: &Prepared) -> LightTreeUniform {
    let selection = prepared.emitters.selection.as_ref();
    let tree = selection.and_then(Selection::tree);
    tree.map_or_else(LightTreeUniform::default, |tree| LightTreeUniform {
        grid_origin: tree.grid.origin,
        nodes: tree.nodes.len() as u32,
        grid_step: tree.grid.step,
        infinite_lights: tree.infinite.len() as u32,
    })
}

/// Zeros, but for the sampling grid, where there is no environment.
fn environment_of(prepared: &Prepared) -> EnvironmentUniform {
    let grid = prepared.emitters.environment.as_ref();
    let mut uniform = EnvironmentUniform {
        grid: grid.map_or([1, 1], |grid| grid.size),
        ..EnvironmentUniform::default()
    };
    let Some(environment) = &prepared.data.scene.environment else {
        return uniform;
    };
    let to_map = environment.rotation.transpose();
    [uniform.x, uniform.y, uniform.z] = [0, 1, 2].map(|i| f3(to_map.row(i)));
    let index = prepared.emitters.index_of_environment();
    uniform.samples_per_ray = index.map_or(0.0, |i| prepared.emitters.probability(i)) as f32;
    let per_unit = 1.0 / prepared.emitters.unit;
    match &environment.radiance {
        EnvironmentRadiance::Constant(radiance) => {
            uniform.radiance = f3(*radiance * environment.scale * per_unit);
        }
        EnvironmentRadiance::Map(map) => {
            uniform.radiance = [(environment.scale * per_unit) as f32; 3];
            [uniform.width, uniform.height] = [map.width, map.height];
            uniform.linear = u32::from(map.interpolation == Interpolation::Linear);
        }
    }
    uniform
}

fn f3(v: DVec3) -> [f32; 3] {
    v.as_vec3().to_array()
}

/// Two ends of cells per word.
fn filter_words(table: &FilterTable) -> [[f32; 4]; FILTER_WORDS] {
    std::array::from_fn(|word| {
        let knot = |i: usize| table.knots.get(i).copied().unwrap_or([1.0, 0.0]);
        let ([a, b], [c, d]) = (knot(2 * word), knot(2 * word + 1));
        [a, b, c, d]
    })
}
