//! Where rays begin and end: HARD CASES G4, G5.

use crate::support::hard_cases::{Measured, survive};
use crate::support::random::Random;
use crate::support::shader::{Answers, Function, call_in, words};
use crate::support::{
    STRATEGIES, context, emitter, floor_pixel, lambert, point_light, prepared_for, render, shape,
    unit_square,
};
use direkt::low_level::gpu::Context;
use direkt::low_level::prepare::Prepared;
use direkt::low_level::reference::exact::rectangle::parallel_rectangle;
use direkt::scene::{
    Camera, DirectionalLight, FilmSize, Geometry, Light, LightSampling, LightSelection, Mesh,
    Sampler, Scene, Strategy,
};
use glam::{DQuat, DVec3};

const IMPORTS: &str = "import package::core::ray::Ray;
    import package::core::rng::{pcg4d, to_unit_2d};
    import package::light::light::{choose_light, sample_chosen_light};
    import package::light::sphere::sample_sphere_area;
    import package::scene::fetch::fetch_light;
    import package::scene::surface::{shadow_ray, surface_at};
    import package::scene::trace::{any_hit, closest_hit};";

fn prepared(scene: Scene) -> Prepared {
    prepared_for(scene, Strategy::LightArea, LightSelection::Uniform)
}

/// What `body` answers for camera rays of world space.
fn trace(
    context: &Context,
    prepared: &Prepared,
    rays: &[[DVec3; 2]],
    outputs: usize,
    body: &str,
) -> Answers {
    let body = format!(
        "let ray = Ray(in_vec3f(0u), in_vec3f(3u));
         let hit = closest_hit(ray);
         let s = surface_at(ray, hit, -normalize(ray.direction));
         {body}"
    );
    let function = Function {
        imports: IMPORTS,
        body: &body,
        inputs: 6,
        outputs,
        features: &[],
    };
    let n = &prepared.data.normalization;
    let inputs: Vec<f64> = rays
        .iter()
        .flat_map(|[o, d]| [n.point(*o).to_array(), n.vector(*d).to_array()])
        .flatten()
        .collect();
    call_in(context, prepared, &function, &words(&inputs), rays.len())
}

fn count(answers: &Answers, word: usize) -> f64 {
    answers.u32(word).filter(|&set| set == 1).count() as f64
}

/// The floor under a unit square; `occluded`, a larger square covers it 5·10⁻⁵ of the way below.
fn lamp(occluded: bool) -> Scene {
    let mut scene = floor_pixel();
    scene.shapes.push(emitter(unit_square(), 1.0, false));
    if occluded {
        let height = 1.0 - 5e-5;
        let cover = Geometry::Rectangle {
            corner: DVec3::new(-0.6, -0.6, height),
            u: 1.2 * DVec3::Y,
            v: 1.2 * DVec3::X,
        };
        scene.shapes.push(shape("cover", cover));
    }
    scene.render.estimator.sampler = Sampler::Independent;
    scene.render.estimator.light_sampling = LightSampling::SolidAngle;
    scene
}

#[test]
fn what_covers_a_lamp_by_a_hair_covers_it() {
    let context = context();
    let rays = vec![[DVec3::new(1.0, -3.0, 2.0), DVec3::new(-1.0, 3.0, -2.0)]; 100_000];
    let body = "let u = to_unit_2d(pcg4d(vec4u(item, 1u, 2u, 3u)).xy);
         let light = sample_chosen_light(choose_light(0u), s.position, s.frame, u, 0u);
         out_bool(0u, any_hit(shadow_ray(s, light.target_point), 1.0));
         out_bool(1u, any_hit(shadow_ray(s, light.target_point), 1.0 - 1e-4));
         let l = fetch_light(0u);
         out_bool(2u, any_hit(Ray(s.origin, l.a + u.x * l.u + u.y * l.v - s.origin), 1.0));";
    let of = |occluded| {
        let mut scene = lamp(occluded);
        // A specialized kernel meets the lamp at 1 exactly: the textbook's rays survive it.
        scene.render.estimator.specialize = false;
        trace(context, &prepared(scene), &rays, 3, body)
    };
    let all = rays.len() as f64;
    let [covered, free] = [true, false].map(of);
    survive(
        context,
        Measured {
            entry: "G5",
            case: "occluder at 1 − 5·10⁻⁵ of the way to a lamp, 10⁵ rays",
            figure: "rays that leak",
            bound: 0.0,
            textbook: "rays that end at 1 − 10⁻⁴",
            naive: all - count(&covered, 1),
            ours: all - count(&covered, 0),
        },
    );
    survive(
        context,
        Measured {
            entry: "G5",
            case: "nothing before the lamp, 10⁵ rays",
            figure: "rays that the lamp itself stops",
            bound: 0.0,
            textbook: "rays that end on the lamp",
            naive: count(&free, 2),
            ours: count(&free, 0),
        },
    );
    let exact = 0.5 * parallel_rectangle([-0.5, 0.5], [-0.5, 0.5], 1.0);
    for strategy in STRATEGIES {
        for specialize in [true, false] {
            let mut scene = lamp(true);
            scene.render.estimator.strategy = strategy;
            scene.render.estimator.specialize = specialize;
            let pixel = render(context, scene).pixels[0];
            let adapter = &context.adapter.name;
            assert_eq!(pixel.mean, [0.0; 3], "{strategy}, {specialize}, {adapter}");
        }
    }
    let mut scene = lamp(false);
    scene.render.estimator.strategy = Strategy::LightProjectedSolidAngle;
    let pixel = render(context, scene).pixels[0];
    assert!(
        (pixel.mean[0] / exact - 1.0).abs() < 2e-5,
        "{pixel:?}, not {exact}"
    );
}

/// A plane of side 2000, turned so that no axis lies in it, under a directional light at 89° with E = 1.
fn plane(distance: f64) -> Scene {
    let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.7).normalize(), 1.1);
    let mut scene = floor_pixel();
    scene.shapes[0].geometry = Geometry::Rectangle {
        corner: turn * DVec3::new(-1000.0, -1000.0, 0.0),
        u: turn * (2000.0 * DVec3::X),
        v: turn * (2000.0 * DVec3::Y),
    };
    let (sin, cos) = 89.0_f64.to_radians().sin_cos();
    scene.lights.push(Light::Directional(DirectionalLight {
        direction: turn * -DVec3::new(0.6 * sin, 0.8 * sin, cos),
        irradiance: DVec3::ONE,
    }));
    let eye = turn * (distance * DVec3::new(0.48, -0.36, 0.8));
    scene.camera = Camera::look_at(eye, DVec3::ZERO, turn * DVec3::Z, 0.01).unwrap();
    scene.film = FilmSize {
        width: 16,
        height: 16,
    };
    scene
}

#[test]
fn a_plane_does_not_shadow_itself_at_any_distance() {
    let context = context();
    let exact = 0.5 / std::f64::consts::PI * 89.0_f64.to_radians().cos();
    let (mut naive, mut ours) = (0.0, 0.0);
    for distance in [1.0, 10.0, 100.0, 1e3, 1e4, 1e5] {
        let film = render(context, plane(distance));
        for pixel in &film.pixels {
            let off = (pixel.mean[0] / exact - 1.0).abs();
            assert!(off < 1e-4, "from {distance}: {pixel:?}, not {exact}");
        }
        let prepared = prepared(plane(distance));
        let camera = prepared.camera;
        let mut random = Random::new(61);
        let rays: Vec<_> = (0..10_000)
            .map(|_| {
                let aside = camera.right * random.between(-0.01, 0.01)
                    + camera.up * random.between(-0.01, 0.01);
                [camera.eye, distance * (camera.forward + aside)]
            })
            .collect();
        // In the plane's own unit, 10⁻⁴ off it.
        let epsilon = 1e-4 * prepared.data.normalization.scale;
        let body = format!(
            "let light = sample_chosen_light(choose_light(0u), s.position, s.frame, vec2f(0.5), 0u);
             out_bool(0u, any_hit(shadow_ray(s, light.target_point), 1.0));
             let on_ray = ray.origin + hit.t * ray.direction + {epsilon:e} * s.frame.z;
             out_bool(1u, any_hit(Ray(on_ray, light.wi * 4.0), 1.0));"
        );
        let answers = trace(context, &prepared, &rays, 2, &body);
        ours += count(&answers, 0);
        naive += count(&answers, 1);
    }
    survive(
        context,
        Measured {
            entry: "G4",
            case: "plane of 2000, light at 89°, eye at 1 to 10⁵, 6·10⁴ points",
            figure: "points in their own shadow",
            bound: 0.0,
            textbook: "origin + t·direction, 10⁻⁴ off the plane",
            naive,
            ours,
        },
    );
}

#[test]
fn shells_a_hair_apart_shadow_each_other() {
    let context = context();
    let mut scene = floor_pixel();
    let sphere = |radius| Geometry::Sphere {
        center: DVec3::new(0.3, -0.2, 0.1),
        radius,
    };
    scene.shapes = vec![
        shape("inner", sphere(1.0)),
        shape("outer", sphere(1.0 + 4e-5)),
    ];
    scene
        .lights
        .push(point_light(DVec3::new(5.0, 6.0, 7.0), 1.0));
    let prepared = prepared(scene);
    let mut random = Random::new(62);
    // Rays begin between the shells.
    let rays: Vec<_> = (0..100_000)
        .map(|_| {
            let out = random.direction().normalize();
            [DVec3::new(0.3, -0.2, 0.1) + (1.0 + 2e-5) * out, -out]
        })
        .collect();
    let epsilon = 1e-4 * prepared.data.normalization.scale;
    let body = format!(
        "let light = sample_chosen_light(choose_light(0u), s.position, s.frame, vec2f(0.5), 0u);
         let lit = dot(light.wi, s.frame.z) > 0.0;
         out_bool(0u, lit && !any_hit(shadow_ray(s, light.target_point), 1.0));
         let off = s.position + {epsilon:e} * s.frame.z;
         out_bool(1u, lit && !any_hit(Ray(off, light.target_point - off), 1.0));
         out_bool(2u, lit);"
    );
    let answers = trace(context, &prepared, &rays, 3, &body);
    assert!(count(&answers, 2) > 30_000.0);
    survive(
        context,
        Measured {
            entry: "G4",
            case: "spheres of radius 1 and 1 + 4·10⁻⁵, 10⁵ points between them",
            figure: "points that the outer one does not shadow",
            bound: 0.0,
            textbook: "rays that begin 10⁻⁴ off the surface",
            naive: count(&answers, 1),
            ours: count(&answers, 0),
        },
    );
}

/// A regular octahedron, each face divided into `n²` triangles and pushed onto a sphere: convex and
/// closed.
pub(super) fn ball(n: u32, scale: f64, center: DVec3) -> Mesh {
    let mut mesh = Mesh::default();
    for octant in 0..8 {
        let side = |bit: u32| if octant & bit == 0 { 1.0 } else { -1.0 };
        let point = |i: u32, j: u32| {
            let [i, j, k] = [i, j, n - i - j].map(f64::from);
            center + scale * DVec3::new(side(1) * i, side(2) * j, side(4) * k).normalize()
        };
        let mut push = |corners: [DVec3; 3]| {
            let first = mesh.positions.len() as u32;
            mesh.positions.extend(corners);
            mesh.triangles.push([first, first + 1, first + 2]);
        };
        for i in 0..n {
            for j in 0..n - i {
                push([point(i, j), point(i + 1, j), point(i, j + 1)]);
                if i + j + 1 < n {
                    push([point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)]);
                }
            }
        }
    }
    mesh
}

/// A closed convex mesh: rays that leave it outwards meet nothing, rays that leave it inwards meet
/// it, and segments from its inside to a point on it are free.
#[test]
fn rays_neither_stop_at_their_own_surface_nor_leak_at_any_scale_and_offset() {
    let context = context();
    let (mut ours, mut naive) = (0.0, 0.0);
    for (scale, offset) in [
        (1e-6, 0.0),
        (1e-6, 10.0),
        (1.0, 0.0),
        (1.0, 1e3),
        (1.0, 1e7),
        (1e6, 0.0),
        (1e6, 1e7),
        (1e6, 1e13),
    ] {
        let center = DVec3::new(offset, -offset, offset);
        let mut scene = floor_pixel();
        let ball = Geometry::Mesh(ball(6, scale, center));
        scene.shapes = vec![emitter(ball, 1.0, true)];
        scene.materials = vec![lambert(0.5)];
        let prepared = prepared(scene);
        let mut random = Random::new(63);
        let rays: Vec<_> = (0..50_000)
            .map(|i| {
                let inside = 0.5 * random.in_cube();
                let out = random.direction().normalize();
                let from = if i % 2 == 0 {
                    inside
                } else {
                    inside + 4.0 * out
                };
                [
                    center + scale * from,
                    scale * if i % 2 == 0 { out } else { -out },
                ]
            })
            .collect();
        let epsilon = 1e-4 * prepared.data.normalization.scale;
        let body = format!(
            "let words = pcg4d(vec4u(item, 5u, 6u, 7u));
             let w = sample_sphere_area(to_unit_2d(words.xy));
             let wi = select(-w, w, dot(w, s.frame.z) >= 0.0);
             let inside = item % 2u == 0u;
             out_bool(0u, any_hit(Ray(s.origin, wi), 8.0) != inside);
             let on_ray = ray.origin + hit.t * ray.direction + {epsilon:e} * s.frame.z;
             out_bool(1u, any_hit(Ray(on_ray, wi), 8.0) != inside);
             let light = sample_chosen_light(choose_light(words.z), s.position, s.frame, to_unit_2d(words.xy), 0u);
             let lit = inside && light.pdf.value > 0.0 && dot(light.wi, s.frame.z) > 1e-3;
             out_bool(2u, lit && any_hit(shadow_ray(s, light.target_point), 1.0));"
        );
        let answers = trace(context, &prepared, &rays, 3, &body);
        ours += count(&answers, 0) + count(&answers, 2);
        naive += count(&answers, 1);
    }
    survive(
        context,
        Measured {
            entry: "G4",
            case: "closed convex meshes of size 10⁻⁶ to 10⁶ at up to 10⁷ sizes from the origin, 4·10⁵ rays",
            figure: "rays that stop at their own surface or leak",
            bound: 0.0,
            textbook: "origin + t·direction, 10⁻⁴ off the surface",
            naive,
            ours,
        },
    );
}
