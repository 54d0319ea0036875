//! `shaders/kernel/camera.wesl`.

use crate::support::random::numbers;
use crate::support::rounding::U;
use crate::support::shader::{Function, call_in, words};
use crate::support::{context, own_scenes};
use direkt::reference::kernel::camera::camera_ray;
use direkt::reference::scene::fetch::World;
use direkt::render::Prepared;
use direkt::scene::{FilmSize, LightSelection, Strategy};
use glam::DVec2;

/// Corners, middle and random points of films of odd shapes. The direction is a sum of three vectors, each rounded
/// and scaled, divided by its length: 12 roundings of the longest sum, and 8 of the normalisation.
#[test]
fn camera_rays_are_the_twins() {
    let context = context();
    let function = Function {
        imports: "import package::kernel::camera::camera_ray;",
        body: "let ray = camera_ray(in_vec2f(0u));
               out_vec3f(0u, ray.origin);
               out_vec3f(3u, ray.direction);",
        inputs: 2,
        outputs: 6,
        features: &[],
    };
    for (name, mut scene) in own_scenes() {
        for (width, height) in [(1, 1), (63, 65), (1000, 3)] {
            let film = FilmSize { width, height };
            scene.film = film;
            let prepared = Prepared::new(scene.clone(), Strategy::MisPower, LightSelection::Power);
            let world = World::new(&prepared);
            let size = DVec2::new(f64::from(width), f64::from(height));
            let mut points: Vec<DVec2> = [0.0, 0.5, 1.0]
                .iter()
                .flat_map(|&y| [0.0, 0.5, 1.0].map(|x| DVec2::new(x, y) * size))
                .collect();
            points.extend((0..1000).map(|i| {
                let [x, y, ..] = numbers(i, 3, 30);
                DVec2::from((DVec2::new(x, y) * size).as_vec2())
            }));
            let inputs: Vec<f64> = points.iter().flat_map(DVec2::to_array).collect();
            let answers = call_in(
                &context,
                &prepared,
                &function,
                &words(&inputs),
                points.len(),
            );
            // Longest sum before normalisation, in the units of `forward`.
            let half_height = (0.5 * scene.camera.fov_y).tan();
            let longest = 1.0 + half_height * (1.0 + film.aspect());
            for (p, (origin, direction)) in points.iter().zip(answers.vec3(0).zip(answers.vec3(3)))
            {
                let expected = camera_ray(&world, film, *p);
                let off = (direction - expected.direction).length();
                assert!(
                    off <= (12.0 * longest + 8.0) * U,
                    "{}, {name}, {width} x {height}: {p} looks along {direction}, off by {off:.1e}",
                    context.adapter.name
                );
                let eye = (origin - expected.origin).length();
                assert!(
                    eye <= 2.0 * U * expected.origin.length(),
                    "{name}: {origin}"
                );
            }
        }
    }
}
