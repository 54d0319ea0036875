//! `shaders/scene/trace.wesl`: random rays against the twin's traversal and against every primitive
//! in turn.

use super::prepared;
use super::specialize::room_with_a_ball;
use crate::support::every_kind::{constant_environment, every_kind};
use crate::support::random::{numbers, rounded};
use crate::support::rounding::U;
use crate::support::shader::{Function, call_in, words};
use crate::support::{context, scene};
use direkt::low_level::accel::PrimitiveGeometry;
use direkt::low_level::effects::Effect;
use direkt::low_level::gpu::layout::NONE;
use direkt::low_level::prepare::Prepared;
use direkt::low_level::reference::Twin;
use direkt::low_level::reference::core::ray::{Hit, Ray};
use direkt::low_level::reference::core::ray_ellipsoid::ellipsoid_normal;
use direkt::low_level::reference::light::ellipsoid::Ellipsoid;
use direkt::low_level::reference::light::sphere::sample_sphere_area;
use direkt::low_level::reference::scene::fetch::World;
use direkt::low_level::reference::scene::opacity::Crossings;
use direkt::low_level::reference::scene::trace::{
    any_hit, closest_hit, intersect_primitive, may_meet_light,
};
use direkt::scene::Emission;
use glam::{DVec2, DVec3};
use rayon::prelude::*;

const RAYS: u32 = 100_000;
/// Fraction of rays that pass an edge within the rounding of f32, at most.
const FLIPS: f64 = 1e-4;

/// A third camera rays, the others from anywhere to anywhere; directions of lengths from ½ to 2.
fn rays(twin: &Twin<'_>) -> Vec<(Ray, f64)> {
    let film = twin.direct().world().prepared.film;
    let ray = |i: u32| {
        let [a, b, c, length] = numbers(i, 1, 20);
        let [u, v, limit, _] = numbers(i, 2, 20);
        let mut ray = Ray {
            origin: DVec3::new(a, b, c) * 2.4 - 1.2,
            direction: sample_sphere_area(DVec2::new(u, v)) * (0.5 + 1.5 * length),
        };
        if i.is_multiple_of(3) {
            let x = (a * f64::from(film.width)) as u32;
            let y = (b * f64::from(film.height)) as u32;
            ray = twin.direct().camera_ray(x, y, u64::from(i));
        }
        let ray = Ray {
            origin: rounded(ray.origin),
            direction: rounded(ray.direction),
        };
        (ray, f64::from((3.0 * limit) as f32))
    };
    (0..RAYS).map(ray).collect()
}

/// Every primitive in turn.
fn brute_force(world: &World<'_>, ray: &Ray) -> Option<Hit> {
    let hits = (0..).zip(&world.primitives).filter_map(|(primitive, p)| {
        let (t, st) = intersect_primitive(ray, p, f64::INFINITY)?;
        Some(Hit { t, primitive, st })
    });
    hits.min_by(|a, b| a.t.total_cmp(&b.t))
}

/// Rounding of the ray parameter: positions are known to 16 roundings of the largest coordinates,
/// and along the ray that is divided by the cosine at the surface.
fn t_bound(world: &World<'_>, ray: &Ray, hit: &Hit) -> f64 {
    let at = ray.origin + hit.t * ray.direction;
    let (normal, extent) = match world.primitives[hit.primitive as usize].geometry {
        PrimitiveGeometry::Triangle { a, u, v }
        | PrimitiveGeometry::Rectangle { a, u, v }
        | PrimitiveGeometry::Disk { a, u, v } => {
            (u.cross(v).normalize(), a.length() + u.length() + v.length())
        }
        PrimitiveGeometry::Sphere { center, radius } => {
            ((at - center) / radius, center.length() + radius)
        }
        PrimitiveGeometry::Ellipsoid { .. } => {
            let e = Ellipsoid::of(&world.primitives[hit.primitive as usize].geometry).unwrap();
            let p = (e.axes.inverse() * (at - e.center)).normalize();
            (ellipsoid_normal(e.axes, p), e.center.length() + e.longest)
        }
    };
    let cos = normal.dot(ray.direction).abs();
    16.0 * U * (extent + ray.origin.length()) / cos
}

/// With a kernel that is specialized for the scene, and with one that loads it.
fn check_scene(name: &str) {
    for specialize in [true, false] {
        let mut scene = scene(&format!("scenes/{name}"));
        scene.render.estimator.specialize = specialize;
        let prepared = prepared(scene);
        assert_eq!(
            prepared.effects.contains(Effect::SpecializedScene),
            specialize
        );
        check_rays(&format!("{name}, specialize = {specialize}"), &prepared);
    }
}

/// 100,000 rays against the twin's traversal and against every primitive in turn.
pub(super) fn check_rays(name: &str, prepared: &Prepared) {
    let context = context();
    let twin = Twin::new(prepared, prepared.film, 21, None);
    let world = twin.direct().world();
    let rays = rays(&twin);
    let function = Function {
        imports: "import package::core::ray::Ray;
                  import package::scene::trace::{any_hit, closest_hit, loop_was_cut};",
        body: "let ray = Ray(in_vec3f(0u), in_vec3f(3u));
               let hit = closest_hit(ray);
               out_f32(0u, hit.t); out_u32(1u, hit.primitive); out_vec2f(2u, hit.st);
               out_bool(4u, any_hit(ray, in_f32(6u)));
               out_bool(5u, loop_was_cut);",
        inputs: 7,
        outputs: 6,
        features: &[],
    };
    let inputs: Vec<f64> = rays
        .iter()
        .flat_map(|(ray, limit)| {
            let [o, d] = [ray.origin, ray.direction];
            [o.x, o.y, o.z, d.x, d.y, d.z, *limit]
        })
        .collect();
    let answers = call_in(context, prepared, &function, &words(&inputs), rays.len());
    assert!(answers.u32(5).all(|cut| cut == 0), "a loop was cut");
    let expected: Vec<_> = rays
        .par_iter()
        .map(|(ray, limit)| {
            let hit = closest_hit(world, ray, Crossings::OPAQUE);
            let brute = brute_force(world, ray);
            // Where two primitives meet the ray at the same parameter, either is the nearest.
            assert_eq!(hit.map(|h| h.t), brute.map(|h| h.t), "{name}: {ray:?}");
            (hit, any_hit(world, ray, Crossings::OPAQUE, *limit))
        })
        .collect();
    let (mut flips, mut any_flips, mut hits) = (0, 0, 0);
    let found = answers.f64(0).zip(answers.u32(1).zip(answers.u32(4)));
    for (((ray, limit), (hit, blocked)), (t, (primitive, any))) in
        rays.iter().zip(&expected).zip(found)
    {
        any_flips += usize::from((any == 1) != *blocked);
        let inside = hit.is_some_and(|h| h.t < *limit);
        assert_eq!(*blocked, inside, "{name}: {ray:?}");
        // Where two primitives lie on one another, either is the nearest.
        let touching = |h: &Hit| {
            let other = intersect_primitive(ray, world.primitives.get(primitive as usize)?, 1e30)?;
            ((other.0 - h.t).abs() <= t_bound(world, ray, h)).then_some(())
        };
        let same = hit.map_or(NONE, |h| h.primitive) == primitive
            || hit.as_ref().and_then(touching).is_some();
        if !same {
            flips += 1;
            continue;
        }
        let Some(hit) = hit else { continue };
        hits += 1;
        let bound = t_bound(world, ray, hit);
        assert!(
            (t - hit.t).abs() <= bound,
            "{}, {name}: {ray:?} meets {hit:?} at {t}, beyond {bound:.1e}",
            context.adapter.name
        );
    }
    let most = (FLIPS * f64::from(RAYS)) as usize;
    assert!(
        flips <= most && any_flips <= most && hits > RAYS as usize / 5,
        "{}, {name}: {flips} and {any_flips} flips, {hits} hits",
        context.adapter.name
    );
}

#[test]
fn rays_through_cornell_meet_what_the_twin_meets() {
    check_scene("cornell.toml");
}

#[test]
fn rays_through_veach_meet_what_the_twin_meets() {
    check_scene("veach.toml");
}

#[test]
fn rays_through_spot_and_sun_meet_what_the_twin_meets() {
    check_scene("spot_and_sun.toml");
}

/// Rays that are not traced, as they enter no light's box, would have met none; and there are such
/// rays.
#[test]
fn rays_that_meet_a_light_enter_its_box() {
    let context = context();
    let scenes =
        ["cornell.toml", "veach.toml", "corner.toml"].map(|n| scene(&format!("scenes/{n}")));
    let every = every_kind(constant_environment());
    let shining = Emission {
        radiance: DVec3::ONE,
        texture: None,
        two_sided: true,
    };
    let scenes = scenes
        .into_iter()
        .chain([every, room_with_a_ball(Some(shining))]);
    for (mut scene, specialize) in scenes.flat_map(|s| [(s.clone(), true), (s, false)]) {
        scene.render.estimator.specialize = specialize;
        let prepared = prepared(scene);
        let name = prepared.data.scene.source.display().to_string();
        let twin = Twin::new(&prepared, prepared.film, 23, None);
        let world = twin.direct().world();
        let rays = rays(&twin);
        let function = Function {
            imports: "import package::core::ray::Ray;
                      import package::scene::trace::may_meet_light;",
            body: "out_bool(0u, may_meet_light(Ray(in_vec3f(0u), in_vec3f(3u))));",
            inputs: 6,
            outputs: 1,
            features: &[],
        };
        let inputs = rays.iter().flat_map(|(ray, _)| {
            let [o, d] = [ray.origin, ray.direction];
            [o.x, o.y, o.z, d.x, d.y, d.z]
        });
        let inputs = words(&inputs.collect::<Vec<_>>());
        let answers = call_in(context, &prepared, &function, &inputs, rays.len());
        let (mut met, mut spared, mut missed) = (0, 0, 0);
        for ((ray, _), may) in rays.iter().zip(answers.u32(0)) {
            let hit = closest_hit(world, ray, Crossings::OPAQUE);
            let light = hit.and_then(|h| world.primitives[h.primitive as usize].light);
            let near = may_meet_light(world, ray);
            assert!(near || light.is_none(), "{name}: the twin, {ray:?}");
            missed += u32::from(may == 0 && near);
            met += u32::from(light.is_some());
            spared += 1 - may;
        }
        assert!(
            met > 10 && spared > RAYS / 10,
            "{name}: {met} met, {spared} spared"
        );
        // A box is wider than what it is around; a primitive itself is as wide as rounding says.
        let specialized = prepared.effects.contains(Effect::SpecializedScene);
        let most = if specialized {
            (FLIPS * f64::from(RAYS)) as u32
        } else {
            0
        };
        assert!(missed <= most, "{}, {name}: {missed}", context.adapter.name);
    }
}

/// One-sided surfaces of every kind are passed through from behind.
#[test]
fn rays_through_every_kind_meet_what_the_twin_meets() {
    let context = context();
    let prepared = super::every();
    let world = World::new(&prepared);
    let function = Function {
        imports: "import package::core::ray::{Ray, ray_frame};
                  import package::core::constants::T_MAX;
                  import package::scene::fetch::fetch_primitive;
                  import package::scene::trace::intersect_primitive;",
        body: "let ray = Ray(in_vec3f(0u), in_vec3f(3u));
               let hit = intersect_primitive(ray_frame(ray), fetch_primitive(in_u32(6u)), T_MAX);
               out_bool(0u, hit.t < T_MAX);
               out_f32(1u, hit.t);",
        inputs: 7,
        outputs: 2,
        features: &[],
    };
    let mut cases = Vec::new();
    for (i, p) in (0_u32..).zip(&world.primitives) {
        let inside = match p.geometry {
            PrimitiveGeometry::Triangle { a, u, v } => a + 0.3 * u + 0.4 * v,
            PrimitiveGeometry::Rectangle { a, u, v } => a + 0.3 * u + 0.8 * v,
            PrimitiveGeometry::Disk { a, u, v } => a + 0.3 * u - 0.7 * v,
            PrimitiveGeometry::Sphere { center, radius } => center + 0.2 * radius,
            PrimitiveGeometry::Ellipsoid { center, radii, .. } => {
                center + 0.2 * radii.min_element()
            }
        };
        for k in 0..64 {
            let [u, v, ..] = numbers(i, k, 22);
            let away = sample_sphere_area(DVec2::new(u, v));
            // From outside, and from inside a sphere.
            for distance in [0.5, 1e-3] {
                let ray = Ray {
                    origin: rounded(inside + distance * away),
                    direction: rounded(-away),
                };
                cases.push((ray, i));
            }
        }
    }
    let inputs: Vec<u32> = cases
        .iter()
        .flat_map(|(ray, i)| {
            let numbers = [ray.origin.to_array(), ray.direction.to_array()].concat();
            words(&numbers).into_iter().chain([*i])
        })
        .collect();
    let answers = call_in(context, &prepared, &function, &inputs, cases.len());
    let mut passed = 0;
    for ((ray, i), (found, t)) in cases.iter().zip(answers.u32(0).zip(answers.f64(1))) {
        let p = &world.primitives[*i as usize];
        let expected = intersect_primitive(ray, p, f64::INFINITY);
        passed += usize::from(expected.is_none());
        assert_eq!(found == 1, expected.is_some(), "{p:?} {ray:?}");
        if let Some((expected, st)) = expected {
            let hit = Hit {
                t: expected,
                primitive: *i,
                st,
            };
            assert!(
                (t - expected).abs() <= t_bound(&world, ray, &hit),
                "{p:?} {ray:?}: {t}"
            );
        }
    }
    assert!(passed > 100, "{passed} rays passed through a back");
}
