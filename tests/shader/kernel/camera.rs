//! `shaders/kernel/camera.wesl`.

use crate::support::random::numbers;
use crate::support::rounding::U;
use crate::support::shader::{Function, call_in, words};
use crate::support::{context, own_scenes, prepared, scene};
use direkt::low_level::gpu::Context;
use direkt::low_level::prepare::Prepared;
use direkt::low_level::reference::core::ray::Ray;
use direkt::low_level::reference::kernel::camera::camera_ray;
use direkt::low_level::reference::scene::fetch::World;
use direkt::scene::{FilmSize, Lens, Projection};
use glam::DVec2;

/// Points of the film and of the lens: corners, middle and random ones.
fn points(film: FilmSize) -> Vec<[DVec2; 2]> {
    let size = DVec2::new(f64::from(film.width), f64::from(film.height));
    let edges = || [0.0, 0.5, 1.0].into_iter();
    let corners = edges().flat_map(|y| edges().map(move |x| DVec2::new(x, y)));
    let last = DVec2::splat(1.0 - (-24_f64).exp2());
    let mut points: Vec<_> = corners.map(|p| [p * size, p.min(last)]).collect();
    points.extend((0..1000).map(|i| {
        let [x, y, u, v] = numbers(i, 3, 30);
        [
            DVec2::from((DVec2::new(x, y) * size).as_vec2()),
            DVec2::new(u, v),
        ]
    }));
    points
}

fn rays(context: &Context, prepared: &Prepared, points: &[[DVec2; 2]]) -> Vec<Ray> {
    let function = Function {
        imports: "import package::kernel::camera::camera_ray;",
        body: "let ray = camera_ray(in_vec2f(0u), in_vec2f(2u));
               out_vec3f(0u, ray.origin);
               out_vec3f(3u, ray.direction);",
        inputs: 4,
        outputs: 6,
        features: &[],
    };
    let inputs: Vec<f64> = points.iter().flatten().flat_map(DVec2::to_array).collect();
    let answers = call_in(context, prepared, &function, &words(&inputs), points.len());
    let rays = answers.vec3(0).zip(answers.vec3(3));
    rays.map(|(origin, direction)| Ray { origin, direction })
        .collect()
}

/// The largest differences of origin and direction, each over its bound.
///
/// The direction is a sum of three vectors, each rounded and scaled, divided by its length: 12
/// roundings of the longest sum, and 8 of the normalisation. A point of the lens is off by 4e-7 of
/// the radius (see `disk.rs`) and 4 roundings, which the focus distance divides, with 6 more. The
/// origin is the sum of the eye, which is rounded, of such a point, and of two vectors across an
/// orthographic image with 4 roundings each.
fn worst(rays: &[Ray], points: &[[DVec2; 2]], twin: &Prepared) -> [f64; 2] {
    let film = twin.film;
    let world = World::new(twin);
    let camera = twin.data.normalization.camera(&twin.camera);
    let half = camera.half_height() * (1.0 + film.aspect());
    let Lens {
        radius,
        focus_distance,
    } = camera.lens;
    let (across, ahead) = if camera.is_orthographic() {
        (half, 1.0)
    } else {
        (0.0, 1.0 + half)
    };
    let on_lens = radius * (4e-7 + 4.0 * U);
    let eye = camera.eye.length() + across + radius;
    let bounds = [
        2.0 * U * eye + 4.0 * U * across + on_lens,
        12.0 * U * (ahead + radius / focus_distance) + 8.0 * U + on_lens / focus_distance,
    ];
    let mut worst = [0.0_f64; 2];
    for (ray, [film_point, lens_point]) in rays.iter().zip(points) {
        let expected = camera_ray(&world, film, *film_point, *lens_point);
        let off = [
            ray.origin - expected.origin,
            ray.direction - expected.direction,
        ];
        for i in 0..2 {
            worst[i] = worst[i].max(off[i].length() / bounds[i]);
        }
    }
    worst
}

#[test]
fn camera_rays_are_the_twins() {
    let context = context();
    for (name, mut scene) in own_scenes() {
        for (width, height) in [(1, 1), (63, 65), (1000, 3)] {
            scene.film = FilmSize { width, height };
            let prepared = prepared(scene.clone());
            let points = points(scene.film);
            let worst = worst(&rays(context, &prepared, &points), &points, &prepared);
            assert!(
                worst.iter().all(|w| *w <= 1.0),
                "{}, {name}, {width} x {height}: {worst:?} of the bounds",
                context.adapter.name
            );
        }
    }
}

/// Every projection through every lens, and twins whose lens or focus is a little off, which are
/// told from the shader.
#[test]
fn lenses_and_projections_are_the_twins() {
    let context = context();
    let height = 0.37;
    for projection in [
        Projection::Perspective { fov_y: 0.7 },
        Projection::Orthographic { height },
    ] {
        for (radius, focus_distance) in [(0.0, 1.0), (0.3, 4.0), (1e-3, 0.05), (5.0, 0.5)] {
            let mut scene = scene("scenes/cornell.toml");
            scene.film = FilmSize {
                width: 63,
                height: 65,
            };
            scene.camera.projection = projection;
            scene.camera.lens = Lens {
                radius,
                focus_distance,
            };
            let what = format!(
                "{}, {projection:?}, {:?}",
                context.adapter.name, scene.camera.lens
            );
            let prepared = prepared(scene);
            let points = points(prepared.film);
            let rays = rays(context, &prepared, &points);
            let found = worst(&rays, &points, &prepared);
            assert!(found.iter().all(|w| *w <= 1.0), "{what}: {found:?}");
            let broken = |change: &dyn Fn(&mut direkt::scene::Camera)| {
                let mut twin = crate::support::prepared(prepared.data.scene.clone());
                change(&mut twin.camera);
                let found = worst(&rays, &points, &twin);
                assert!(
                    found.iter().any(|w| *w > 1.0),
                    "{what}: a broken twin passes"
                );
            };
            broken(&|camera| {
                camera.projection = match projection {
                    Projection::Perspective { fov_y } => Projection::Orthographic { height: fov_y },
                    Projection::Orthographic { height } => {
                        Projection::Perspective { fov_y: height }
                    }
                };
            });
            if radius > 0.0 {
                broken(&|camera| camera.lens.radius *= 1.01);
                broken(&|camera| camera.lens.focus_distance *= 1.01);
            }
        }
    }
}
