//! `shaders/scene/opacity.wesl`: opacities are the twin's, crossings stop as often as they say and
//! independently of each other, and a ray meets what it meets in whatever order.

use super::prepared;
use crate::support::random::{Random, rounded};
use crate::support::shader::{Function, call, call_in, words};
use crate::support::statistics::{accept, reject};
use crate::support::{context, scene, shape};
use direkt::low_level::gpu::layout::NONE;
use direkt::low_level::prepare::Prepared;
use direkt::low_level::reference::Twin;
use direkt::low_level::reference::core::ray::{Hit, Ray};
use direkt::low_level::reference::core::sampler::SampleId;
use direkt::low_level::reference::scene::fetch::World;
use direkt::low_level::reference::scene::opacity::{
    CROSSING_FIRST, CROSSING_SECOND, Crossings, RAY_BSDF, RAY_CAMERA, RAY_SHADOW, opacity_at,
};
use direkt::low_level::reference::scene::trace::{any_hit, closest_hit, stop_at_primitive};
use direkt::low_level::stats::z_test::z_test;
use direkt::scene::{Geometry, Mesh};
use glam::{DVec2, DVec3, Vec4};
use rayon::prelude::*;

/// Samples of every frequency.
const SAMPLES: u32 = 1 << 19;

fn sample(index: u32) -> SampleId {
    SampleId {
        pixel: index >> 8,
        index: u64::from(index & 255),
        seed: 7,
    }
}

fn leaves() -> Prepared {
    prepared(scene("scenes/leaves.toml"))
}

/// A veil over a 2 × 2 texture, smooth between its texels, and triangles of it with vertex colours.
fn textured() -> Prepared {
    let mut scene = scene("scenes/tests/opacity_texture.toml");
    let mut random = Random::new(69);
    let mut colors = |count: usize| -> Vec<Vec4> {
        let mut color = || [0; 4].map(|_| random.between(0.0, 1.0) as f32);
        (0..count).map(|_| Vec4::from_array(color())).collect()
    };
    for (uvs, normals) in [(true, true), (true, false), (false, true), (false, false)] {
        let mut triangle = shape(
            "triangle",
            Geometry::Mesh(Mesh {
                positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
                triangles: vec![[0, 1, 2]],
                normals: vec![DVec3::new(0.3, 0.1, 1.0); if normals { 3 } else { 0 }],
                uvs: if uvs {
                    vec![DVec2::ZERO, DVec2::X, DVec2::Y]
                } else {
                    vec![]
                },
                colors: colors(3),
                ..Mesh::default()
            }),
        );
        triangle.material = scene.shapes[0].material;
        scene.shapes.push(triangle);
    }
    let texture = scene
        .materials
        .iter_mut()
        .find_map(|m| m.opacity.texture.as_mut());
    texture.expect("a texture").interpolation = direkt::scene::environment::Interpolation::Linear;
    prepared(scene)
}

/// Opacities over a primitive are as exact as the texture coordinates, which a texel's edge
/// amplifies; a mask's edge lies within that.
#[test]
fn opacities_are_the_twins() {
    let context = context();
    let function = Function {
        imports: "import package::scene::fetch::fetch_primitive;
                  import package::scene::opacity::opacity_at;",
        body: "out_f32(0u, opacity_at(fetch_primitive(in_u32(2u)), in_vec2f(0u)));",
        inputs: 3,
        outputs: 1,
        features: &[],
    };
    for (name, prepared) in [("leaves", leaves()), ("texture", textured())] {
        let world = World::new(&prepared);
        let mut random = Random::new(70);
        let with_opacity = (0..world.primitives.len() as u32)
            .filter(|i| world.primitives[*i as usize].attributed.opacity);
        let mut cases = Vec::new();
        for i in with_opacity {
            for _ in 0..400 {
                let s = random.between(0.0, 1.0);
                cases.push((i, rounded(DVec3::new(s, random.between(0.0, 1.0 - s), 0.0))));
            }
        }
        let input = |(i, st): &(u32, DVec3)| [words(&[st.x, st.y]), vec![*i]].concat();
        let inputs: Vec<u32> = cases.iter().flat_map(input).collect();
        let answers = call_in(context, &prepared, &function, &inputs, cases.len());
        let mut values = [0; 3];
        let mut off = 0;
        for ((i, st), got) in cases.iter().zip(answers.f64(0)) {
            let p = &world.primitives[*i as usize];
            let expected = opacity_at(&world, p, st.truncate());
            values[if expected <= 0.0 {
                0
            } else {
                usize::from(expected >= 1.0) + 1
            }] += 1;
            off += usize::from((got - expected).abs() > 1e-4);
        }
        assert!(
            off * 10_000 <= cases.len(),
            "{name}: {off} of {}",
            cases.len()
        );
        assert!(
            values[1] > 0 && (name == "texture" || values[0] > 1000),
            "{name}: {values:?}"
        );
    }
}

fn stops(crossings: Crossings, alpha: f64, index: u32, crossing: u32) -> bool {
    crossings.is_stopped(alpha, index, crossing)
}

/// Whether each sample's crossing `place` = (primitive, ray, crossing) stops it.
fn drawn(alpha: f64, (index, ray, crossing): (u32, u32, u32)) -> Vec<bool> {
    let of = |i: u32| {
        stops(
            Crossings::of_sample(sample(i)).of_ray(ray),
            alpha,
            index,
            crossing,
        )
    };
    (0..SAMPLES).map(of).collect()
}

#[test]
fn crossings_are_the_twins() {
    let function = Function {
        imports: "import package::core::sampler::SampleId;
                  import package::scene::opacity::{is_stopped, number_ray, start_crossings};",
        body: "start_crossings(SampleId(in_u32(0u), vec2u(in_u32(1u), 0u), 7u, 1u, vec2u(0u)));
               number_ray(in_u32(2u));
               out_bool(0u, is_stopped(in_f32(3u), in_u32(4u), in_u32(5u)));",
        inputs: 6,
        outputs: 1,
        features: &["ALPHA"],
    };
    let alphas = [
        0.0,
        1e-10,
        1e-7,
        0.01,
        0.3,
        0.5,
        1.0 - (-24_f64).exp2(),
        1.0,
    ];
    let alphas = alphas.map(|alpha| f64::from(alpha as f32));
    let mut random = Random::new(71);
    let mut cases = Vec::new();
    for i in 0..100_000 {
        let rays = [
            RAY_CAMERA,
            RAY_CAMERA + 3,
            RAY_BSDF,
            RAY_SHADOW,
            RAY_SHADOW + 7,
        ];
        let ray = rays[random.word() as usize % rays.len()];
        let index = random.word() % 100_000;
        cases.push((
            i,
            ray,
            alphas[i as usize % alphas.len()],
            index,
            random.word() % 2,
        ));
    }
    let inputs: Vec<u32> = cases
        .iter()
        .flat_map(|&(i, ray, alpha, index, crossing)| {
            let id = sample(i);
            [
                id.pixel,
                id.index as u32,
                ray,
                (alpha as f32).to_bits(),
                index,
                crossing,
            ]
        })
        .collect();
    let answers = call(context(), &function, &inputs);
    for (&(i, ray, alpha, index, crossing), got) in cases.iter().zip(answers.u32(0)) {
        let expected = stops(
            Crossings::of_sample(sample(i)).of_ray(ray),
            alpha,
            index,
            crossing,
        );
        assert_eq!(
            got == 1,
            expected,
            "sample {i}, ray {ray}, {alpha}, {index}, {crossing}"
        );
    }
}

#[test]
fn crossings_stop_as_often_as_the_opacity_says() {
    for alpha in [1e-3, 0.01, 0.3, 0.5, 0.9] {
        let p_value = |expected: f64| {
            let stopped = drawn(alpha, (3, RAY_CAMERA, CROSSING_FIRST));
            let frequency = stopped.iter().filter(|s| **s).count() as f64 / f64::from(SAMPLES);
            let variance = expected * (1.0 - expected) / f64::from(SAMPLES);
            z_test(frequency, expected, variance, 0.0).p_value
        };
        accept(p_value(alpha), &format!("stopped with probability {alpha}"));
        reject(
            p_value((1.5 * alpha).min(0.5 + 0.5 * alpha)),
            &format!("another than {alpha}"),
        );
    }
}

/// p-value of the hypothesis that two crossings of every sample are independent.
fn independence(alpha: f64, a: &[bool], b: &[bool]) -> f64 {
    let count = |of: &dyn Fn(usize) -> bool| (0..a.len()).filter(|i| of(*i)).count() as f64;
    let n = a.len() as f64;
    let joint = count(&|i| a[i] && b[i]) - count(&|i| a[i]) * count(&|i| b[i]) / n;
    let variance = (alpha * (1.0 - alpha)).powi(2) / n;
    z_test(joint / n, 0.0, variance, 0.0).p_value
}

/// Rays of one sample, primitives that one ray meets, and the two crossings of a sphere. Rays that
/// were numbered in their highest bits would not be: the first word of the hash shows it.
#[test]
fn crossings_are_independent() {
    let first = (3, RAY_CAMERA, CROSSING_FIRST);
    let others = [
        (3, RAY_CAMERA + 1, CROSSING_FIRST),
        (3, RAY_BSDF, CROSSING_FIRST),
        (3, RAY_SHADOW, CROSSING_FIRST),
        (3, RAY_SHADOW + 1, CROSSING_FIRST),
        (3, RAY_CAMERA, CROSSING_SECOND),
        (4, RAY_CAMERA, CROSSING_FIRST),
        (3 + (1 << 20), RAY_CAMERA, CROSSING_FIRST),
    ];
    for alpha in [0.1, 0.5] {
        let a = drawn(alpha, first);
        for other in others {
            let p = independence(alpha, &a, &drawn(alpha, other));
            accept(p, &format!("opacity {alpha}, {first:?} and {other:?}"));
        }
        reject(independence(alpha, &a, &a), "a crossing and itself");
    }
}

/// Every primitive in turn.
fn brute_force(world: &World<'_>, ray: &Ray, crossings: Crossings) -> Option<Hit> {
    let hits = (0..world.primitives.len() as u32).filter_map(|primitive| {
        let (t, st) = stop_at_primitive(world, ray, crossings, primitive, f64::INFINITY)?;
        Some(Hit { t, primitive, st })
    });
    hits.min_by(|a, b| a.t.total_cmp(&b.t))
}

/// Camera rays, and rays from anywhere inside.
fn rays(twin: &Twin<'_>, count: u32) -> Vec<Ray> {
    let film = twin.direct().world().prepared.film;
    let mut random = Random::new(72);
    let mut ray = |i: u32| {
        if i.is_multiple_of(2) {
            let (x, y) = (random.word() % film.width, random.word() % film.height);
            return twin.direct().camera_ray(x, y, u64::from(i));
        }
        Ray {
            origin: 0.8 * random.in_cube(),
            direction: random.direction(),
        }
    };
    let rays = (0..count).map(|i| {
        let Ray { origin, direction } = ray(i);
        Ray {
            origin: rounded(origin),
            direction: rounded(direction),
        }
    });
    rays.collect()
}

/// The nearest hit and any hit, on the GPU, by the twin's hierarchy and by every primitive in turn.
/// A twin whose rays are stopped by every surface is found out.
#[test]
fn rays_are_stopped_alike_in_any_order() {
    let context = context();
    let prepared = leaves();
    let twin = Twin::new(&prepared, prepared.film, 21, None);
    let world = twin.direct().world();
    let rays = rays(&twin, 40_000);
    let function = Function {
        imports: "import package::core::ray::Ray;
                  import package::core::sampler::SampleId;
                  import package::scene::opacity::{RAY_SHADOW, number_ray, start_crossings};
                  import package::scene::trace::{any_hit, closest_hit};",
        body: "start_crossings(SampleId(item >> 8u, vec2u(item & 255u, 0u), 7u, 1u, vec2u(0u)));
               number_ray(RAY_SHADOW);
               let ray = Ray(in_vec3f(0u), in_vec3f(3u));
               out_u32(0u, closest_hit(ray).primitive);
               out_bool(1u, any_hit(ray, 1.0));",
        inputs: 6,
        outputs: 2,
        features: &[],
    };
    let components = |ray: &Ray| [ray.origin.to_array(), ray.direction.to_array()].concat();
    let inputs: Vec<f64> = rays.iter().flat_map(components).collect();
    let answers = call_in(context, &prepared, &function, &words(&inputs), rays.len());
    let expected: Vec<_> = rays
        .par_iter()
        .zip(0..rays.len() as u32)
        .map(|(ray, i)| {
            let crossings = Crossings::of_sample(sample(i)).of_ray(RAY_SHADOW);
            let hit = closest_hit(world, ray, crossings);
            let brute = brute_force(world, ray, crossings);
            assert_eq!(hit.map(|h| h.t), brute.map(|h| h.t), "{ray:?}");
            let blocked = any_hit(world, ray, crossings, 1.0);
            assert_eq!(blocked, hit.is_some_and(|h| h.t < 1.0), "{ray:?}");
            let opaque = closest_hit(world, ray, Crossings::OPAQUE);
            let primitive = |hit: Option<Hit>| hit.map_or(NONE, |h| h.primitive);
            (primitive(hit), blocked, primitive(opaque))
        })
        .collect();
    let found = answers.u32(0).zip(answers.u32(1));
    let (mut flips, mut opaque_flips) = (0, 0);
    for ((primitive, blocked), (hit, any, opaque)) in found.zip(expected) {
        flips += usize::from(primitive != hit || (blocked == 1) != any);
        opaque_flips += usize::from(primitive != opaque);
    }
    let name = &context.adapter.name;
    assert!(
        flips <= rays.len() / 2_000,
        "{name}: {flips} of {}",
        rays.len()
    );
    assert!(opaque_flips > rays.len() / 100, "{name}: {opaque_flips}");
}

/// Without texture coordinates a texture does not count.
#[test]
fn untextured_surfaces_have_the_factor_alone() {
    let mut scene = scene("scenes/tests/opacity_texture.toml");
    scene.materials.iter_mut().for_each(|m| {
        if m.opacity.texture.is_some() {
            m.opacity.factor = 0.25;
        }
    });
    let prepared = prepared(scene);
    let mut world = World::new(&prepared);
    let veil = world.primitives.iter().position(|p| p.attributed.opacity);
    let veil = veil.expect("the veil has an opacity");
    let textured = opacity_at(&world, &world.primitives[veil], DVec2::new(0.25, 0.75));
    assert_eq!(textured, 0.0, "the upper left texel");
    world.primitives[veil].attributed.uvs = false;
    let untextured = opacity_at(&world, &world.primitives[veil], DVec2::new(0.25, 0.75));
    assert_eq!(untextured, 0.25);
}
