//! Scenes far from the origin, tiny and huge ones render like the original: HARD CASES G3, P2.

use crate::support::hard_cases::{Measured, survive};
use crate::support::{context, prepared, scene, take};
use direkt::low_level::accel;
use direkt::low_level::gpu::Context;
use direkt::low_level::prepare::{Prepared, SceneData};
use direkt::low_level::render::{Film, Session};
use direkt::scene::normalize::Normalization;
use direkt::scene::{
    FilmSize, Geometry, Light, LightSampling, LightSelection, PointLight, Projection, Sampler,
    Scene, SpotLight, Strategy,
};
use glam::DVec3;
use std::sync::Arc;

const SCENES: [&str; 3] = ["cornell", "veach", "spot_and_sun"];
/// Relative difference of images (mean |a − b| over mean |a|, same seed).
const BOUND: f64 = 1e-5;

/// A scene of `scenes/`, as this test renders it: lights are chosen by power, so that one that is
/// weighed by the unit of length would be noticed.
fn original(name: &str) -> Scene {
    let mut scene = scene(&format!("scenes/{name}.toml"));
    scene.film = FilmSize {
        width: 64,
        height: 64,
    };
    scene.render.estimator.strategy = Strategy::MisPower;
    scene.render.estimator.light_sampling = LightSampling::SolidAngle;
    scene.render.estimator.light_selection = LightSelection::Power;
    scene.render.estimator.sampler = Sampler::Independent;
    scene
}

/// `scene` with every position mapped by `point` and every length by `length`; lights without
/// extent grow with the square.
fn mapped(
    mut scene: Scene,
    point: impl Fn(DVec3) -> DVec3,
    vector: impl Fn(DVec3) -> DVec3,
    length: impl Fn(f64) -> f64,
) -> Scene {
    scene.camera.eye = point(scene.camera.eye);
    scene.camera.lens.radius = length(scene.camera.lens.radius);
    scene.camera.lens.focus_distance = length(scene.camera.lens.focus_distance);
    if let Projection::Orthographic { height } = &mut scene.camera.projection {
        *height = length(*height);
    }
    for shape in &mut scene.shapes {
        match &mut shape.geometry {
            Geometry::Rectangle { corner: p, u, v } | Geometry::Disk { center: p, u, v } => {
                (*p, *u, *v) = (point(*p), vector(*u), vector(*v));
            }
            Geometry::Sphere { center, radius } => {
                (*center, *radius) = (point(*center), length(*radius));
            }
            Geometry::Ellipsoid { center, axes } => {
                *center = point(*center);
                for axis in [&mut axes.x_axis, &mut axes.y_axis, &mut axes.z_axis] {
                    *axis = vector(*axis);
                }
            }
            Geometry::Mesh(mesh) => mesh.positions.iter_mut().for_each(|p| *p = point(*p)),
        }
    }
    let square = length(1.0) * length(1.0);
    for light in &mut scene.lights {
        if let Light::Point(PointLight {
            position,
            intensity,
        })
        | Light::Spot(SpotLight {
            position,
            intensity,
            ..
        }) = light
        {
            (*position, *intensity) = (point(*position), *intensity * square);
        }
    }
    scene
}

fn moved(scene: Scene, offset: DVec3) -> Scene {
    mapped(scene, |p| p + offset, |v| v, |l| l)
}

fn scaled(scene: Scene, s: f64) -> Scene {
    mapped(scene, |p| s * p, |v| s * v, |l| s * l)
}

/// The textbook's way: positions are rounded to f32 in world space. A corner's edges come with it.
fn rounded_in_world_space(mut scene: Scene) -> Scene {
    let round = |p: DVec3| p.as_vec3().as_dvec3();
    for shape in &mut scene.shapes {
        if let Geometry::Rectangle { corner: p, u, v } | Geometry::Disk { center: p, u, v } =
            &mut shape.geometry
        {
            (*u, *v) = (round(*p + *u) - round(*p), round(*p + *v) - round(*p));
        }
    }
    mapped(scene, round, |v| v, |l| f64::from(l as f32))
}

/// The textbook's way: the scene is not normalised at all.
fn in_world_space(scene: Scene) -> Prepared {
    let mut data = SceneData::new(scene);
    data.normalization = Normalization {
        center: DVec3::ZERO,
        scale: 1.0,
        radius: 1.0,
        reach: 1.0,
    };
    data.primitives = accel::primitives(&data.scene, &data.normalization);
    data.bvh = accel::build(&mut data.primitives);
    let settings = data.scene.render;
    Prepared::new(&Arc::new(data), settings)
}

/// Without the many points at the edges of lights in view: of so many a few lie so near to an edge
/// that rounding moves them across.
pub(super) fn film(context: &Context, prepared: &Prepared) -> Film {
    let prepared = prepared.clone().with_lights_in_view_by_chance();
    let mut session = Session::new(context, &prepared, prepared.film, 17).unwrap();
    take(&mut session, 16);
    session.snapshot().unwrap().0
}

/// mean |a − b| / mean |a|; infinite where a sample of `b` is missing.
pub(super) fn difference(a: &Film, b: &Film) -> f64 {
    let pairs = || a.pixels.iter().zip(&b.pixels);
    if pairs().any(|(a, b)| a.samples != b.samples) {
        return f64::INFINITY;
    }
    let over = |f: &dyn Fn(f64, f64) -> f64| -> f64 {
        let of_pixel = |(a, b): (
            &direkt::low_level::render::Pixel,
            &direkt::low_level::render::Pixel,
        )|
         -> f64 { (0..3).map(|c| f(a.mean[c], b.mean[c])).sum() };
        pairs().map(of_pixel).sum()
    };
    over(&|a, b| (a - b).abs()) / over(&|a, _| a.abs())
}

/// Largest difference over [`SCENES`], between the originals and what `way` makes of them.
fn largest(context: &Context, originals: &[Film], way: impl Fn(Scene) -> Prepared) -> f64 {
    let differences = SCENES
        .iter()
        .zip(originals)
        .map(|(name, a)| difference(a, &film(context, &way(original(name)))));
    differences.fold(0.0, f64::max)
}

#[test]
fn a_moved_scene_renders_like_the_original() {
    let context = context();
    let originals = SCENES.map(|name| film(context, &prepared(original(name))));
    let offset = DVec3::new(1e7, -1e7, 1e7);
    survive(
        context,
        Measured {
            entry: "G3",
            case: "three scenes moved by 10⁷",
            figure: "relative difference of the image",
            bound: BOUND,
            textbook: "positions in f32 in world space",
            naive: largest(context, &originals, |s| {
                prepared(rounded_in_world_space(moved(s, offset)))
            }),
            ours: largest(context, &originals, |s| prepared(moved(s, offset))),
        },
    );
}

#[test]
fn a_scaled_scene_renders_like_the_original() {
    let context = context();
    let originals = SCENES.map(|name| film(context, &prepared(original(name))));
    for (s, case) in [
        (1e-12, "three scenes scaled by 10⁻¹²"),
        (1e-6, "three scenes scaled by 10⁻⁶"),
        (1e6, "three scenes scaled by 10⁶"),
    ] {
        let ours = largest(context, &originals, |x| prepared(scaled(x, s)));
        let naive = largest(context, &originals, |x| in_world_space(scaled(x, s)));
        survive(
            context,
            Measured {
                entry: "P2",
                case,
                figure: "relative difference of the image",
                bound: BOUND,
                textbook: "lengths in f32 in world space",
                naive,
                ours,
            },
        );
    }
}

/// A lens, what it is focused on and what an orthographic camera sees move and grow with the scene.
#[test]
fn cameras_move_and_grow_with_their_scenes() {
    let context = context();
    let offset = DVec3::new(1e7, -1e7, 1e7);
    for name in ["depth_of_field", "isometric"] {
        let expected = film(context, &prepared(original(name)));
        let off = |scene: Scene| difference(&expected, &film(context, &prepared(scene)));
        let mut out_of_focus = original(name);
        out_of_focus.camera.lens.radius += 0.1;
        assert!(
            off(out_of_focus) > 1e-3,
            "{name}: the lens makes no difference"
        );
        for (what, scene) in [
            ("moved by 10⁷", moved(original(name), offset)),
            ("scaled by 10⁻⁶", scaled(original(name), 1e-6)),
            ("scaled by 10⁶", scaled(original(name), 1e6)),
            ("both", moved(scaled(original(name), 1e-6), 1e-6 * offset)),
        ] {
            let off = off(scene);
            assert!(off <= BOUND, "{name}, {what}: off by {off:e}");
        }
    }
}
