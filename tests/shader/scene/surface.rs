//! `shaders/scene/surface.wesl`: points of every kind of primitive, seen from both sides.

use super::every;
use crate::support::every_kind::{constant_environment, every_kind};
use crate::support::random::{Random, direction, numbers, rounded};
use crate::support::rounding::U;
use crate::support::shader::{Function, call_in, words};
use crate::support::{context, shape};
use direkt::low_level::accel::PrimitiveGeometry;
use direkt::low_level::accel::octahedral::octahedral;
use direkt::low_level::gpu::layout::NONE;
use direkt::low_level::reference::core::frame::{frame_from_normal, to_world};
use direkt::low_level::reference::core::math::max_abs;
use direkt::low_level::reference::core::ray::{Hit, Ray};
use direkt::low_level::reference::core::ray_ellipsoid::ellipsoid_normal;
use direkt::low_level::reference::light::disk::sample_disk_area;
use direkt::low_level::reference::light::ellipsoid::Ellipsoid;
use direkt::low_level::reference::light::sphere::sample_sphere_area;
use direkt::low_level::reference::light::triangle::sample_triangle_area;
use direkt::low_level::reference::scene::fetch::World;
use direkt::low_level::reference::scene::surface::{OFFSET, surface_at};
use direkt::scene::material::Fresnel;
use direkt::scene::{Geometry, MaterialId, Mesh, Shape};
use glam::{DVec2, DVec3, Vec4};
use std::f64::consts::TAU;

/// A view of a point of a primitive.
struct View {
    ray: Ray,
    hit: Hit,
    wo: DVec3,
    /// Unit normal of the exact geometry there, on the side of the viewer.
    facing: DVec3,
}

fn view(geometry: &PrimitiveGeometry, primitive: u32, k: u32) -> View {
    let [x, y, azimuth, distance] = numbers(primitive, k, 23);
    let u = DVec2::new(x, y);
    let planar = |a: DVec3, e1: DVec3, e2: DVec3, st: DVec2| {
        (a + st.x * e1 + st.y * e2, e1.cross(e2).normalize(), st)
    };
    let (position, normal, st) = match *geometry {
        PrimitiveGeometry::Triangle { a, u: e1, v: e2 } => {
            planar(a, e1, e2, sample_triangle_area(u))
        }
        PrimitiveGeometry::Rectangle { a, u: e1, v: e2 } => planar(a, e1, e2, u),
        PrimitiveGeometry::Disk { a, u: e1, v: e2 } => planar(a, e1, e2, sample_disk_area(u)),
        PrimitiveGeometry::Sphere { center, radius } => {
            let n = sample_sphere_area(u);
            (center + radius * n, n, DVec2::ZERO)
        }
        PrimitiveGeometry::Ellipsoid { .. } => {
            let e = Ellipsoid::of(geometry).unwrap();
            let p = sample_sphere_area(u);
            (e.point(p), ellipsoid_normal(e.axes, p), octahedral(p))
        }
    };
    let degrees = [0.0, 45.0, 80.0, 89.0, 89.9][k as usize / 2 % 5];
    let facing = if k.is_multiple_of(2) { normal } else { -normal };
    let wo = rounded(to_world(
        &frame_from_normal(facing),
        direction(degrees, TAU * azimuth),
    ));
    let t = f64::from((0.1 + distance) as f32);
    View {
        ray: Ray {
            origin: rounded(position + t * wo),
            direction: -wo,
        },
        hit: Hit {
            t,
            primitive,
            st: DVec2::from(st.as_vec2()),
        },
        wo,
        facing,
    }
}

/// Size of the coordinates, and the rounding of the normal: 8 roundings over the sine between the
/// edges for what is planar, over the radius (of an ellipsoid, of curvature) for a point on the
/// ray.
fn size_and_normal_error(geometry: &PrimitiveGeometry, ray: &Ray, t: f64) -> (f64, f64) {
    match *geometry {
        PrimitiveGeometry::Triangle { a, u, v }
        | PrimitiveGeometry::Rectangle { a, u, v }
        | PrimitiveGeometry::Disk { a, u, v } => {
            let size = a.length() + u.length() + v.length();
            let height = u.cross(v).length() / u.length().max(v.length());
            (size, 8.0 * U * (1.0 + size / height))
        }
        PrimitiveGeometry::Sphere { center, radius } => {
            let size = center.length() + radius;
            (
                size,
                8.0 * U * (1.0 + (ray.origin.length() + t + size) / radius),
            )
        }
        PrimitiveGeometry::Ellipsoid { .. } => {
            let e = Ellipsoid::of(geometry).unwrap();
            let radius = e.curvature_radius(ray.origin + t * ray.direction);
            let size = e.center.length() + e.longest;
            (
                size,
                8.0 * U * (1.0 + (ray.origin.length() + t + size) / radius),
            )
        }
    }
}

/// Signed distance of `p` from the exact surface, along `facing`.
fn height(geometry: &PrimitiveGeometry, facing: DVec3, p: DVec3) -> f64 {
    match *geometry {
        PrimitiveGeometry::Triangle { a, .. }
        | PrimitiveGeometry::Rectangle { a, .. }
        | PrimitiveGeometry::Disk { a, .. } => (p - a).dot(facing),
        PrimitiveGeometry::Sphere { center, radius } => {
            let outside = (p - center).length() - radius;
            outside * (p - center).dot(facing).signum()
        }
        PrimitiveGeometry::Ellipsoid { .. } => {
            // To the first order: the distance in the sphere's space over its gradient.
            let e = Ellipsoid::of(geometry).unwrap();
            let q = e.axes.inverse() * (p - e.center);
            let gradient = e.axes.inverse().transpose() * q.normalize();
            let outside = (q.length() - 1.0) / gradient.length();
            outside * gradient.dot(facing).signum()
        }
    }
}

#[test]
fn surfaces_are_the_twins_on_both_sides() {
    let context = context();
    let prepared = every();
    let world = World::new(&prepared);
    let function = Function {
        imports: "import package::core::ray::{Hit, Ray};
                  import package::scene::surface::surface_at;",
        body: "let s = surface_at(
                   Ray(in_vec3f(0u), in_vec3f(3u)), Hit(in_f32(6u), in_u32(7u), in_vec2f(8u)), in_vec3f(10u));
               out_vec3f(0u, s.position); out_vec3f(3u, s.origin);
               out_vec3f(6u, s.frame.x); out_vec3f(9u, s.frame.y); out_vec3f(12u, s.frame.z);
               out_vec3f(15u, s.wo); out_vec3f(18u, s.material.diffuse);
               out_u32(21u, s.light); out_bool(22u, s.front); out_u32(23u, s.own_light);",
        inputs: 13,
        outputs: 24,
        features: &[],
    };
    let views: Vec<View> = (0..)
        .zip(&world.primitives)
        .flat_map(|(i, p)| (0..200).map(move |k| view(&p.geometry, i, k)))
        .collect();
    let mut inputs = Vec::new();
    for View { ray, hit, wo, .. } in &views {
        inputs.extend(words(
            &[ray.origin.to_array(), ray.direction.to_array()].concat(),
        ));
        inputs.extend(words(&[hit.t]));
        inputs.push(hit.primitive);
        inputs.extend(words(&[hit.st.x, hit.st.y, wo.x, wo.y, wo.z]));
    }
    let answers = call_in(context, &prepared, &function, &inputs, views.len());
    for (i, view) in views.iter().enumerate() {
        let vector = |word: usize| answers.vec3(word).nth(i).unwrap();
        let View {
            ray,
            hit,
            wo,
            facing,
        } = view;
        let geometry = &world.primitives[hit.primitive as usize].geometry;
        let expected = surface_at(&world, ray, hit, *wo);
        let what = format!("{}: {geometry:?} from {wo}", context.adapter.name);
        let (size, normal_error) = size_and_normal_error(geometry, ray, hit.t);
        let [position, origin, x, y, z, local] = [0, 3, 6, 9, 12, 15].map(vector);
        let off = (position - expected.position).length();
        assert!(
            off <= 8.0 * U * size,
            "{what}: {position}, off by {off:.1e}"
        );
        assert!(
            (z - expected.frame.z).length() <= normal_error,
            "{what}: normal {z}"
        );
        for (a, b, dot) in [
            (x, x, 1.0),
            (y, y, 1.0),
            (z, z, 1.0),
            (x, y, 0.0),
            (y, z, 0.0),
            (z, x, 0.0),
        ] {
            assert!(
                (a.dot(b) - dot).abs() < 32.0 * U,
                "{what}: the frame is {x} {y} {z}"
            );
        }
        assert!((x.cross(y) - z).length() < 64.0 * U, "{what}: handedness");
        assert!(
            (local.z - expected.wo.z).abs() <= normal_error + 8.0 * U,
            "{what}: {local}"
        );
        let back = local.x * x + local.y * y + local.z * z;
        assert!((back - *wo).length() < 64.0 * U, "{what}: {back}");
        // The offset of 16 roundings of the largest coordinate outweighs the position's rounding.
        let above = height(geometry, *facing, origin);
        let most = 2.0 * OFFSET * size;
        assert!(
            above > 0.0 && above <= most,
            "{what}: {above:.1e} above the surface"
        );
        assert!(
            (origin - expected.origin).length() <= 16.0 * U * size,
            "{what}: {origin}"
        );
        assert!(max_abs(origin - position) > 0.0, "{what}");
        assert_eq!(vector(18), rounded(expected.material.diffuse), "{what}");
        let [light, front] = [21, 22].map(|word| answers.u32(word).nth(i).unwrap());
        assert_eq!(light, expected.light.unwrap_or(NONE), "{what}");
        let own_light = answers.u32(23).nth(i).unwrap();
        assert_eq!(own_light, expected.own_light.unwrap_or(NONE), "{what}");
        assert_eq!(front == 1, expected.front, "{what}");
        assert_eq!(
            expected.front,
            facing.dot(expected.frame.z) > 0.0 && is_front(i),
            "{what}"
        );
    }
}

/// Every kind of material on triangles with vertex colours: what of it is a colour is multiplied by
/// theirs.
#[test]
fn vertex_colours_are_factors_on_materials() {
    let context = context();
    let mut scene = every_kind(constant_environment());
    let mut random = Random::new(68);
    let first = scene.shapes.len();
    for material in 0..scene.materials.len() as u32 {
        let mut color = || [0; 4].map(|_| random.between(0.0, 1.0) as f32);
        let colors = [color(), color(), color()].map(Vec4::from_array);
        let mesh = Mesh {
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
            triangles: vec![[0, 1, 2]],
            colors: colors.to_vec(),
            ..Mesh::default()
        };
        scene.shapes.push(Shape {
            material: MaterialId(material),
            ..shape("colored", Geometry::Mesh(mesh))
        });
    }
    let prepared = super::prepared(scene);
    let world = World::new(&prepared);
    let function = Function {
        imports: "import package::core::ray::{Hit, Ray};
                  import package::scene::surface::surface_at;",
        body: "let s = surface_at(
                   Ray(in_vec3f(0u), in_vec3f(3u)), Hit(in_f32(6u), in_u32(7u), in_vec2f(8u)), in_vec3f(10u));
               out_vec3f(0u, s.material.diffuse); out_vec3f(3u, s.material.f0); out_vec3f(6u, s.material.transmittance);
               out_f32(9u, s.material.alpha);",
        inputs: 13,
        outputs: 10,
        features: &[],
    };
    let colored = (0..).zip(&prepared.data.primitives);
    let colored = colored.filter(|(_, p)| p.shape.index() >= first);
    let views: Vec<View> = colored
        .flat_map(|(i, p)| (0..50).map(move |k| view(&p.geometry, i, k)))
        .collect();
    assert_eq!(views.len(), 50 * prepared.data.scene.materials.len());
    let mut inputs = Vec::new();
    for View { ray, hit, wo, .. } in &views {
        inputs.extend(words(
            &[ray.origin.to_array(), ray.direction.to_array()].concat(),
        ));
        inputs.extend(words(&[hit.t]));
        inputs.push(hit.primitive);
        inputs.extend(words(&[hit.st.x, hit.st.y, wo.x, wo.y, wo.z]));
    }
    let answers = call_in(context, &prepared, &function, &inputs, views.len());
    let mut varied = 0;
    for (i, View { ray, hit, wo, .. }) in views.iter().enumerate() {
        let vector = |word: usize| answers.vec3(word).nth(i).unwrap();
        let material = surface_at(&world, ray, hit, *wo).material;
        let own = world.primitives[hit.primitive as usize].material;
        varied += usize::from(material != own);
        let f0 = match material.specular.map(|lobe| lobe.fresnel) {
            Some(Fresnel::Constant(f0) | Fresnel::Schlick { f0, .. }) => f0,
            Some(Fresnel::Conductor { eta, .. }) => eta,
            _ => DVec3::ZERO,
        };
        let transmittance = material
            .transmission
            .map_or(DVec3::ZERO, |t| t.transmittance);
        let alpha = material.specular.map_or(0.0, |lobe| lobe.alpha);
        let what = format!("{} from {wo}", world.name_of(hit.primitive as usize));
        for (word, expected) in [(0, material.diffuse), (3, f0), (6, transmittance)] {
            let off = (vector(word) - expected).abs().max_element();
            assert!(
                off < 16.0 * U * expected.max_element().max(1.0),
                "{what}: {word}, {off:e}"
            );
        }
        let off = answers.f64(9).nth(i).unwrap() - alpha;
        assert!(off.abs() < 8.0 * U, "{what}: {off:e}");
    }
    // All but the metal that is given by its index.
    assert_eq!(varied, 50 * (prepared.data.scene.materials.len() - 1));
}

/// Views alternate between front and back.
fn is_front(i: usize) -> bool {
    (i % 200).is_multiple_of(2)
}

/// To points above the plane the segment ends there; to points below the origin it runs level with
/// the plane, up to the rounding of a dot product (3 U) and of a sum.
#[test]
fn shadow_rays_do_not_descend() {
    let context = context();
    let prepared = every();
    let function = Function {
        imports: "import package::core::frame::frame_from_normal;
                  import package::scene::fetch::Material;
                  import package::scene::surface::{Surface, shadow_ray};",
        body: "let f = frame_from_normal(in_vec3f(3u));
               var material: Material;
               let s = Surface(in_vec3f(0u), in_vec3f(0u), f, vec3f(0.0), material, 0u, 0u, true, f.z, 1.0, vec3f(0.0));
               let ray = shadow_ray(s, in_vec3f(6u));
               out_vec3f(0u, ray.origin); out_vec3f(3u, ray.direction);",
        inputs: 9,
        outputs: 6,
        features: &[],
    };
    let cases: Vec<[DVec3; 3]> = (0..10_000)
        .map(|i| {
            let [a, b, c, d] = numbers(i, 1, 24);
            let [x, y, z, _] = numbers(i, 2, 24);
            let normal = rounded(sample_sphere_area(DVec2::new(a, b)));
            let origin = rounded(DVec3::new(c, d, x));
            let across = normal.any_orthonormal_vector() * y;
            [
                origin,
                normal,
                rounded(origin + across + normal * (z - 0.5)),
            ]
        })
        .collect();
    let inputs: Vec<f64> = cases.iter().flatten().flat_map(|v| v.to_array()).collect();
    let answers = call_in(context, &prepared, &function, &words(&inputs), cases.len());
    let found = answers.vec3(0).zip(answers.vec3(3));
    for (&[origin, normal, target], (from, d)) in cases.iter().zip(found) {
        let what = format!("{}: {origin} {normal} {target}", context.adapter.name);
        let up = normal.dot(target - origin);
        let expected = target - origin + normal * (-up).max(0.0);
        assert_eq!(from, origin, "{what}");
        assert!((d - expected).length() < 16.0 * U, "{what}: {d}");
        assert!(normal.dot(d) > -16.0 * U, "{what}: {d}");
    }
}
