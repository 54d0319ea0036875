//! `shaders/scene/fetch.wesl`: every record comes back as the host prepared it, rounded to f32.

use super::{every, prepared};
use crate::support::random::rounded;
use crate::support::shader::{Answers, Function, call_in};
use crate::support::{context, floor_pixel};
use direkt::low_level::accel::PrimitiveGeometry;
use direkt::low_level::emitters::Emitter;
use direkt::low_level::gpu::layout::{
    FRESNEL_CONDUCTOR, FRESNEL_CONSTANT, FRESNEL_DIELECTRIC, FRESNEL_SCHLICK, KIND_DISK,
    KIND_ELLIPSOID, KIND_RECTANGLE, KIND_SPHERE, KIND_TRIANGLE, LIGHT_DISK, LIGHT_ENVIRONMENT,
    LIGHT_RECTANGLE, LIGHT_SPHERE, LIGHT_TRIANGLE, NONE, THIN_BIT,
};
use direkt::low_level::prepare::Prepared;
use direkt::low_level::reference::light::sun::{sun_height, sun_radiance};
use direkt::low_level::reference::scene::fetch::World;
use direkt::scene::lights::{LIGHT_DIRECTIONAL, LIGHT_POINT, LIGHT_SPOT, LIGHT_SUN};
use direkt::scene::material::Fresnel;
use direkt::scene::{DirectionalLight, Light, PointLight, SpotLight};
use glam::DVec3;

fn item<T>(mut values: impl Iterator<Item = T>, i: usize) -> T {
    values.nth(i).unwrap()
}

fn fetched(prepared: &Prepared, body: &str, outputs: usize, count: usize) -> Answers {
    let function = Function {
        imports: "import package::scene::fetch::{fetch_light, fetch_material, fetch_primitive};",
        body,
        outputs,
        ..Function::default()
    };
    call_in(context(), prepared, &function, &[], count)
}

#[test]
fn primitives_come_back() {
    let prepared = every();
    let world = World::new(&prepared);
    let body = "let p = fetch_primitive(item);
                out_vec3f(0u, p.a); out_vec3f(3u, p.b); out_vec3f(6u, p.c);
                out_u32(9u, p.kind); out_u32(10u, p.material); out_bool(11u, p.one_sided); out_u32(12u, p.light);";
    let answers = fetched(&prepared, body, 13, world.primitives.len());
    let mut kinds = [0; 5];
    for (i, (p, source)) in world
        .primitives
        .iter()
        .zip(&prepared.data.primitives)
        .enumerate()
    {
        let (kind, a, b, c) = match p.geometry {
            PrimitiveGeometry::Triangle { a, u, v } => (KIND_TRIANGLE, a, a + u, a + v),
            PrimitiveGeometry::Rectangle { a, u, v } => (KIND_RECTANGLE, a, a + u, a + v),
            PrimitiveGeometry::Disk { a, u, v } => (KIND_DISK, a, a + u, a + v),
            PrimitiveGeometry::Sphere { center, radius } => (
                KIND_SPHERE,
                center,
                DVec3::new(radius, 0.0, 0.0),
                DVec3::ZERO,
            ),
            PrimitiveGeometry::Ellipsoid {
                center,
                radii,
                rodrigues,
            } => (KIND_ELLIPSOID, center, radii, rodrigues),
        };
        kinds[kind as usize] += 1;
        for (word, expected) in [(0, a), (3, b), (6, c)] {
            assert_eq!(
                item(answers.vec3(word), i),
                rounded(expected),
                "primitive {i}, word {word}"
            );
        }
        let found = [9, 10, 11, 12].map(|word| item(answers.u32(word), i));
        let light = p.light.unwrap_or(NONE);
        let expected = [kind, source.material.0, u32::from(p.one_sided), light];
        assert_eq!(found, expected, "primitive {i}");
    }
    assert!(kinds.iter().all(|&n| n >= 2), "{kinds:?}");
}

#[test]
fn materials_come_back() {
    let prepared = every();
    let body = "let m = fetch_material(item);
                out_vec3f(0u, m.diffuse); out_vec3f(3u, m.f0); out_f32(6u, m.alpha); out_f32(7u, m.f90);
                out_vec3f(8u, m.k); out_u32(11u, m.bits); out_vec3f(12u, m.transmittance); out_f32(15u, m.ior);
                out_vec3f(16u, m.average);";
    let materials = &prepared.data.scene.materials;
    let function = Function {
        imports: "import package::scene::fetch::fetch_material;",
        body,
        outputs: 19,
        features: &[
            "GLOSSY",
            "SPECULAR",
            "REFRACTION",
            "EXACT_DIELECTRIC",
            "EXACT_CONDUCTOR",
        ],
        ..Function::default()
    };
    let answers = call_in(context(), &prepared, &function, &[], materials.len());
    for (i, material) in materials.iter().enumerate() {
        let p = material.bsdf.parameters();
        let (fresnel, alpha) = p.specular.map_or_else(
            || {
                let none = Fresnel::Schlick {
                    f0: DVec3::ZERO,
                    f90: 0.0,
                };
                (none, 0.0)
            },
            |s| (s.fresnel, s.alpha),
        );
        let (f0, f90, k, kind) = match fresnel {
            Fresnel::Constant(f) => (f, 0.0, DVec3::ZERO, FRESNEL_CONSTANT),
            Fresnel::Schlick { f0, f90 } => (f0, f90, DVec3::ZERO, FRESNEL_SCHLICK),
            Fresnel::Dielectric { .. } => (DVec3::ZERO, 0.0, DVec3::ZERO, FRESNEL_DIELECTRIC),
            Fresnel::Conductor { eta, k } => (eta, 0.0, k, FRESNEL_CONDUCTOR),
        };
        let thin = p.transmission.is_some_and(|t| t.thin);
        let found = (
            item(answers.f64(7), i),
            item(answers.vec3(8), i),
            item(answers.u32(11), i),
        );
        let bits = kind | if thin { THIN_BIT } else { 0 };
        assert_eq!(found, (f90, rounded(k), bits), "{}", material.name);
        let through = p.transmission.map_or(DVec3::ZERO, |t| t.transmittance);
        assert_eq!(
            item(answers.vec3(12), i),
            rounded(through),
            "{}",
            material.name
        );
        if let Fresnel::Dielectric { ior } = fresnel {
            assert_eq!(
                item(answers.f64(15), i) as f32,
                ior as f32,
                "{}",
                material.name
            );
        }
        let average = p.specular.map_or(DVec3::ZERO, |s| s.average);
        assert_eq!(
            item(answers.vec3(16), i),
            rounded(average),
            "{}",
            material.name
        );
        assert_eq!(
            item(answers.vec3(0), i),
            rounded(p.diffuse),
            "{}",
            material.name
        );
        assert_eq!(item(answers.vec3(3), i), rounded(f0), "{}", material.name);
        assert_eq!(
            item(answers.f64(6), i) as f32,
            alpha as f32,
            "{}",
            material.name
        );
    }
}

/// Without a microfacet lobe in the scene, its code and its words are left out.
#[test]
fn diffuse_materials_have_no_lobe() {
    let prepared = prepared(floor_pixel());
    let body = "let m = fetch_material(0u); out_vec3f(0u, m.diffuse); out_vec3f(3u, m.f0); out_f32(6u, m.alpha);";
    let answers = fetched(&prepared, body, 7, 1);
    assert_eq!(item(answers.vec3(0), 0), DVec3::splat(0.5));
    assert_eq!(item(answers.vec3(3), 0), DVec3::ZERO);
    assert_eq!(item(answers.f64(6), 0), 0.0);
}

#[test]
fn lights_come_back() {
    let prepared = every();
    let body = "let l = fetch_light(item);
                out_vec3f(0u, l.a); out_vec3f(3u, l.u); out_vec3f(6u, l.v); out_vec3f(9u, l.radiance);
                out_u32(12u, l.kind); out_bool(13u, l.two_sided); out_f32(14u, l.expected_samples.value); out_f32(15u, l.area);
                out_bool(16u, l.skewed);";
    let lights = &prepared.emitters.lights;
    let answers = fetched(&prepared, body, 17, lights.len());
    let mut kinds = [0; 8];
    for (i, light) in lights.iter().enumerate() {
        let zero = DVec3::ZERO;
        let along_x = |x: f64| DVec3::new(x, 0.0, 0.0);
        let (kind, two_sided, area, vectors) = match *light {
            Emitter::Area {
                primitive,
                radiance,
                two_sided,
                map: _,
            } => {
                let geometry = prepared.data.primitives[primitive as usize].geometry;
                let (kind, [a, u, v]) = match geometry {
                    PrimitiveGeometry::Triangle { a, u, v } => (LIGHT_TRIANGLE, [a, u, v]),
                    PrimitiveGeometry::Rectangle { a, u, v } => (LIGHT_RECTANGLE, [a, u, v]),
                    PrimitiveGeometry::Disk { a, u, v } => (LIGHT_DISK, [a, u, v]),
                    PrimitiveGeometry::Sphere { center, radius } => {
                        (LIGHT_SPHERE, [center, along_x(radius), zero])
                    }
                    PrimitiveGeometry::Ellipsoid {
                        center,
                        radii,
                        rodrigues,
                    } => (LIGHT_SPHERE, [center, radii, rodrigues]),
                };
                (kind, two_sided, geometry.area(), [a, u, v, radiance])
            }
            Emitter::Delta(Light::Point(PointLight {
                position,
                intensity,
            })) => (LIGHT_POINT, false, 0.0, [position, zero, zero, intensity]),
            Emitter::Delta(Light::Spot(SpotLight {
                position,
                direction,
                intensity,
                inner_angle,
                outer_angle,
            })) => {
                let range = inner_angle.cos() - outer_angle.cos();
                let cone = DVec3::new(outer_angle.cos(), 1.0 / range, 0.0);
                (
                    LIGHT_SPOT,
                    false,
                    0.0,
                    [position, direction, cone, intensity],
                )
            }
            Emitter::Delta(Light::Directional(DirectionalLight {
                direction,
                irradiance,
            })) => (
                LIGHT_DIRECTIONAL,
                false,
                0.0,
                [-direction, zero, zero, irradiance],
            ),
            Emitter::Delta(Light::Sun(_)) => unreachable!("suns are emitters of their own"),
            Emitter::Sun(sun) => (
                LIGHT_SUN,
                false,
                0.0,
                [
                    -sun.direction,
                    zero,
                    along_x(sun_height(&sun)),
                    sun_radiance(&sun),
                ],
            ),
            Emitter::Environment => (LIGHT_ENVIRONMENT, false, 0.0, [zero; 4]),
        };
        kinds[kind as usize] += 1;
        for (word, expected) in [0, 3, 6, 9].into_iter().zip(vectors) {
            assert_eq!(
                item(answers.vec3(word), i),
                rounded(expected),
                "light {i}, word {word}"
            );
        }
        let ellipsoid = kind == LIGHT_SPHERE && vectors[2] != zero;
        let skewed = matches!(kind, LIGHT_RECTANGLE | LIGHT_DISK) || ellipsoid;
        let found = [12, 13, 16].map(|word| item(answers.u32(word), i));
        let expected = [kind, u32::from(two_sided), u32::from(skewed)];
        assert_eq!(found, expected, "light {i}");
        let numbers = [14, 15].map(|word| item(answers.f64(word), i) as f32);
        let expected = [prepared.emitters.probability(i) as f32, area as f32];
        assert_eq!(numbers, expected, "light {i}");
    }
    let one_of_each_and_an_ellipsoid = [1, 1, 1, 2, 1, 1, 1, 1];
    assert_eq!(kinds, one_of_each_and_an_ellipsoid);
}
