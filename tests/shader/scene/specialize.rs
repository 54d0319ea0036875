//! Kernels that are specialized for a scene: what no test of `shaders/scene/trace.wesl` tells.

use super::prepared;
use super::trace::check_rays;
use crate::support::random::{Random, rounded};
use crate::support::shader::{Function, call_in, words};
use crate::support::{context, floor_pixel, lambert, scene, shape};
use direkt::low_level::accel::PrimitiveGeometry;
use direkt::low_level::effects::Effect;
use direkt::low_level::prepare::Prepared;
use direkt::scene::{Emission, Geometry, MaterialId, Mesh, Scene};
use glam::{DMat3, DVec3};

const RAYS: usize = 200_000;

fn of_shapes(geometries: Vec<Geometry>) -> Prepared {
    let mut scene = floor_pixel();
    scene.shapes = geometries.into_iter().map(|g| shape("side", g)).collect();
    specialized(scene)
}

fn specialized(scene: Scene) -> Prepared {
    let prepared = prepared(scene);
    let name = prepared.data.scene.source.display();
    assert!(
        prepared.effects.contains(Effect::SpecializedScene),
        "{name}"
    );
    prepared
}

/// Six rectangles around the middle of a box with the edges `edges`.
fn sides(edges: DMat3) -> Vec<Geometry> {
    let side = |axis: usize, sign: f64| {
        let [u, v] = [1, 2].map(|next| edges.col((axis + next) % 3));
        Geometry::Rectangle {
            corner: 0.5 * (sign * edges.col(axis) - u - v),
            u,
            v,
        }
    };
    [0, 1, 2]
        .into_iter()
        .flat_map(|axis| [side(axis, -1.0), side(axis, 1.0)])
        .collect()
}

/// The rectangle in two triangles.
fn halves(rectangle: &Geometry) -> Geometry {
    let Geometry::Rectangle { corner, u, v } = *rectangle else {
        unreachable!("a side is a rectangle");
    };
    Geometry::Mesh(Mesh {
        positions: vec![corner, corner + u, corner + u + v, corner + v],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    })
}

/// The ends of the edges of a planar primitive.
fn edges(geometry: &PrimitiveGeometry) -> Vec<[DVec3; 2]> {
    match *geometry {
        PrimitiveGeometry::Triangle { a, u, v } => {
            vec![[a, a + u], [a + u, a + v], [a + v, a]]
        }
        PrimitiveGeometry::Rectangle { a, u, v } => {
            let [b, c, d] = [a + u, a + u + v, a + v];
            vec![[a, b], [b, c], [c, d], [d, a]]
        }
        _ => unreachable!("the bodies have flat sides"),
    }
}

/// The rectangle in `count` × `count` squares of two triangles each.
fn tiles(rectangle: &Geometry, count: u32) -> Geometry {
    let Geometry::Rectangle { corner, u, v } = *rectangle else {
        unreachable!("a side is a rectangle");
    };
    let along = |i: u32| f64::from(i) / f64::from(count);
    let rows = (0..=count).flat_map(|y| (0..=count).map(move |x| (x, y)));
    let squares = (0..count).flat_map(|y| (0..count).map(move |x| y * (count + 1) + x));
    let triangles = squares.flat_map(|a| {
        let above = a + count + 1;
        [[a, a + 1, above + 1], [a, above + 1, above]]
    });
    Geometry::Mesh(Mesh {
        positions: rows
            .map(|(x, y)| corner + along(x) * u + along(y) * v)
            .collect(),
        triangles: triangles.collect(),
        ..Mesh::default()
    })
}

/// The Cornell box without its boxes, and in it a ball of 1,200 triangles, which emits where
/// `emission` says so.
pub(super) fn room_with_a_ball(emission: Option<Emission>) -> Scene {
    let mut room = scene("scenes/cornell.toml");
    let is_part = |name: &str| {
        ["light", "floor", "ceiling", "wall"]
            .iter()
            .any(|part| name.contains(part))
    };
    room.shapes.retain(|shape| is_part(&shape.name));
    assert_eq!(room.shapes.len(), 6);
    for side in sides(DMat3::IDENTITY) {
        let Geometry::Mesh(mut mesh) = tiles(&side, 10) else {
            unreachable!("tiles are a mesh");
        };
        let middle = DVec3::new(0.1, -0.5, 0.2);
        for position in &mut mesh.positions {
            *position = middle + 0.4 * position.normalize();
        }
        let mut part = shape("ball", Geometry::Mesh(mesh));
        part.emission = emission;
        room.shapes.push(part);
    }
    room
}

/// What is large is written out, the ball is loaded.
fn partly_specialized(scene: Scene) -> Prepared {
    let prepared = specialized(scene);
    let loaded = prepared.loaded().expect("most is loaded").count;
    assert_eq!((loaded, prepared.written_out()), (1200, 1200..1206));
    prepared
}

#[test]
fn rays_meet_a_mesh_among_large_primitives() {
    check_rays(
        "a room with a ball",
        &partly_specialized(room_with_a_ball(None)),
    );
}

/// Triangles, parallelograms and ellipses from both sides and from one, spheres and ellipsoids.
#[test]
fn rays_meet_every_shape_where_the_twin_does() {
    let mut scene = floor_pixel();
    scene.materials = vec![lambert(0.5), lambert(0.5)];
    scene.materials[1].double_sided = false;
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    let (corner, radius) = (DVec3::new(-0.4, 0.1, 0.2), 0.35);
    let triangle = Mesh {
        positions: vec![corner, corner + x, corner + 0.3 * x + y],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    let shapes = [
        Geometry::Mesh(triangle),
        Geometry::Rectangle {
            corner,
            u: x - 0.2 * z,
            v: y,
        },
        Geometry::Rectangle {
            corner,
            u: x,
            v: y + 0.5 * x,
        },
        Geometry::Disk {
            center: corner,
            u: 0.5 * x,
            v: 0.4 * z,
        },
        Geometry::Disk {
            center: corner,
            u: 0.5 * x,
            v: 0.4 * z + 0.3 * x,
        },
        Geometry::Sphere {
            center: corner,
            radius,
        },
        Geometry::Ellipsoid {
            center: corner,
            axes: DMat3::from_cols(0.3 * x + 0.1 * y, 0.2 * y, 0.5 * z),
        },
    ];
    scene.shapes.clear();
    for (i, geometry) in (0..).zip(shapes.iter().chain(&shapes)) {
        let mut random = Random::new(90 + i);
        let mut shape = shape("shape", moved(geometry, 0.8 * random.in_cube()));
        shape.material = MaterialId(i / shapes.len() as u32);
        scene.shapes.push(shape);
    }
    let prepared = specialized(scene);
    for effect in [
        Effect::Triangles,
        Effect::Rectangles,
        Effect::Disks,
        Effect::Spheres,
        Effect::Ellipsoids,
        Effect::OneSided,
    ] {
        assert!(prepared.effects.contains(effect), "{effect:?}");
    }
    check_rays("every shape", &prepared);
}

fn moved(geometry: &Geometry, by: DVec3) -> Geometry {
    let mut moved = geometry.clone();
    match &mut moved {
        Geometry::Mesh(mesh) => mesh.positions.iter_mut().for_each(|p| *p += by),
        Geometry::Rectangle { corner: p, .. }
        | Geometry::Disk { center: p, .. }
        | Geometry::Sphere { center: p, .. }
        | Geometry::Ellipsoid { center: p, .. } => *p += by,
    }
    moved
}

/// From anywhere within, half of them at corners, half at points of edges: between two sides that
/// meet no ray passes.
#[test]
fn no_ray_leaves_a_closed_body() {
    let turned = DMat3::from_axis_angle(DVec3::new(0.3, -0.5, 0.8).normalize(), 1.1);
    let skewed = turned
        * DMat3::from_cols(
            DVec3::X,
            DVec3::new(0.3, 0.8, 0.0),
            DVec3::new(-0.2, 0.4, 1.3),
        );
    let mixed = |edges: DMat3| {
        let mut sides = sides(edges);
        sides[3] = halves(&sides[3]);
        sides
    };
    let partly = |edges: DMat3| {
        let mut sides = mixed(edges);
        sides[4] = tiles(&sides[4], 16);
        sides
    };
    let bodies = [
        (
            "a box",
            sides(DMat3::from_diagonal(DVec3::new(1.0, 0.7, 1.9))),
        ),
        ("a turned box", sides(turned)),
        ("a skewed box", sides(skewed)),
        ("a turned box of rectangles and triangles", mixed(turned)),
        (
            "a skewed box of parallelograms and triangles",
            mixed(skewed),
        ),
        ("a turned box with a side of many triangles", partly(turned)),
        ("a skewed box with a side of many triangles", partly(skewed)),
        (
            "a box of triangles",
            sides(turned).iter().map(halves).collect(),
        ),
    ];
    let context = context();
    for (name, body) in bodies {
        let prepared = of_shapes(body);
        let primitives = prepared.data.primitives.iter();
        let edges: Vec<_> = primitives.flat_map(|p| edges(&p.geometry)).collect();
        let ends = || edges.iter().flatten().copied();
        let [low, high] = [ends().reduce(DVec3::min), ends().reduce(DVec3::max)];
        let center = 0.5 * (low.unwrap() + high.unwrap());
        let mut random = Random::new(81);
        let rays = (0..RAYS).map(|i| {
            let [a, b] = edges[random.word() as usize % edges.len()];
            let origin = rounded(center + 0.2 * random.in_cube());
            let share = if i % 2 == 0 { 0.0 } else { random.uniform() };
            [origin.to_array(), (a.lerp(b, share) - origin).to_array()]
        });
        let inputs: Vec<f64> = rays.flatten().flatten().collect();
        let function = Function {
            imports: "import package::core::constants::NONE;
                      import package::core::ray::Ray;
                      import package::scene::trace::{any_hit, closest_hit};",
            body: "let ray = Ray(in_vec3f(0u), in_vec3f(3u));
                   out_bool(0u, closest_hit(ray).primitive == NONE);
                   out_bool(1u, !any_hit(ray, 1.01));",
            inputs: 6,
            outputs: 2,
            features: &[],
        };
        let answers = call_in(context, &prepared, &function, &words(&inputs), RAYS);
        let leaks = [0, 1].map(|word| answers.u32(word).filter(|leaks| *leaks == 1).count());
        assert_eq!(leaks, [0, 0], "{}, {name}", context.adapter.name);
    }
}

/// What a shadow ray leaves out, as all lights lie before it, hides none of them.
#[test]
fn what_shadow_rays_leave_out_hides_no_light() {
    let context = context();
    let mut hidden_at_all = 0;
    let names = ["cornell", "veach", "corner", "spot_and_sun"];
    let scenes = names.map(|name| specialized(scene(&format!("scenes/{name}.toml"))));
    let with_mesh = partly_specialized(room_with_a_ball(None));
    for prepared in scenes.into_iter().chain([with_mesh]) {
        let name = prepared.data.scene.source.display().to_string();
        let function = Function {
            imports: "import package::core::constants::NONE;
                      import package::core::pdf::ExpectedSamples;
                      import package::core::ray::Ray;
                      import package::light::light::sample_chosen_light;
                      import package::light::sample::LightChoice;
                      import package::scene::surface::{shadow_ray, surface_at};
                      import package::scene::trace::{any_hit, closest_hit, hides_light};",
            body: "let ray = Ray(in_vec3f(0u), in_vec3f(3u));
                   let hit = closest_hit(ray);
                   if hit.primitive == NONE {
                       out_bool(0u, false);
                       out_bool(1u, false);
                       out_bool(2u, false);
                       return;
                   }
                   let s = surface_at(ray, hit, -normalize(ray.direction));
                   let choice = LightChoice(in_u32(6u), ExpectedSamples(1.0));
                   let light = sample_chosen_light(choice, s.position, s.frame, in_vec2f(7u), 0u);
                   let reaches = light.radiance_over_pdf.y > 0.0 && dot(s.normal, light.wi) > 0.0;
                   let to_light = shadow_ray(s, light.target_point);
                   out_bool(0u, reaches && choice.index != s.own_light);
                   out_bool(1u, any_hit(to_light, 1.0));
                   out_bool(2u, hides_light(to_light));",
            inputs: 9,
            outputs: 3,
            features: &[],
        };
        let lights = prepared.emitters.lights.len() as u32;
        let mut random = Random::new(82);
        let inputs: Vec<u32> = (0..RAYS)
            .flat_map(|_| {
                let ray = [1.2 * random.in_cube(), random.direction()];
                let ray = words(ray.map(|v| v.to_array()).as_flattened());
                let light = random.word() % lights;
                let u = words(&[random.uniform(), random.uniform()]);
                [ray, vec![light], u].concat()
            })
            .collect();
        let answers = call_in(context, &prepared, &function, &inputs, RAYS);
        let found = answers.u32(0).zip(answers.u32(1).zip(answers.u32(2)));
        let found: Vec<_> = found
            .filter(|(reaches, _)| *reaches == 1)
            .map(|(_, hidden)| hidden)
            .collect();
        let hidden = found.iter().filter(|(all, _)| *all == 1).count();
        let differ = found.iter().filter(|(all, some)| all != some).count();
        assert!(
            hidden + 1000 < found.len(),
            "{name}: {hidden} of {}",
            found.len()
        );
        // Shadow rays know no overlap.
        let adapter = &context.adapter.name;
        assert!(
            differ <= found.len() / 10_000,
            "{adapter}, {name}: {differ} differ"
        );
        hidden_at_all += hidden;
    }
    assert!(hidden_at_all > 1000, "{hidden_at_all} hidden");
}
