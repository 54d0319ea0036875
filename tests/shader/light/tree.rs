//! `shaders/light/tree.wesl`: which light the tree chooses, how likely that was, and how likely any
//! other would have been.

use crate::support::every_kind::{constant_environment, every_kind};
use crate::support::random::{Random, rounded};
use crate::support::shader::{Function, call_in};
use crate::support::{context, emitter, floor_pixel, point_light, prepared_for};
use direkt::low_level::accel::PrimitiveGeometry;
use direkt::low_level::emitters::{Emitter, LightTree, Selection};
use direkt::low_level::prepare::Prepared;
use direkt::low_level::reference::core::pdf::PdfDiscrete;
use direkt::low_level::reference::light::ellipsoid::Ellipsoid;
use direkt::low_level::reference::light::tree::{
    TreeChild, TreeWalk, cosine_bound, decode_axis, decode_child, tree_importance,
};
use direkt::scene::{
    Geometry, Light, LightSelection, MaterialId, Mesh, Scene, SpotLight, Strategy,
};
use glam::DVec3;

mod choice;

const IMPORTS: &str = "import package::light::tree::{
        TreeWalk, choose_tree_light, cosine_bound, decode_axis, decode_child, samples_of_tree_light, subtract_angle, tree_choice,
        tree_importance, tree_samples, walk_left};
    import package::core::pdf::PdfDiscrete;
    import package::core::rng::pcg4d;
    import package::scene::bindings::light_choice;";

/// Every kind of light, `count` more small lamps that look anywhere, and as many spots.
fn scene_of(count: u32, seed: u32) -> Scene {
    let mut scene = every_kind(constant_environment());
    let mut random = Random::new(seed);
    for _ in 0..count {
        let corner = 4.0 * random.in_cube();
        let size = random.magnitude(0.01, 0.3);
        let (u, v) = (size * random.direction(), size * random.direction());
        let triangle = Geometry::Mesh(Mesh {
            positions: vec![corner, corner + u, corner + v],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        });
        let two_sided = random.uniform() < 0.3;
        let mut lamp = emitter(triangle, random.magnitude(0.1, 100.0), two_sided);
        lamp.material = MaterialId(2);
        scene.shapes.push(lamp);
        let outer_angle = random.between(0.05, 1.4);
        scene.lights.push(Light::Spot(SpotLight {
            position: 4.0 * random.in_cube(),
            direction: random.direction().normalize(),
            intensity: DVec3::splat(random.magnitude(0.01, 10.0)),
            inner_angle: outer_angle * random.uniform(),
            outer_angle,
        }));
    }
    scene
}

fn prepared(scene: Scene) -> Prepared {
    prepared_for(scene, Strategy::MisPower, LightSelection::Tree)
}

fn tree(prepared: &Prepared) -> &LightTree {
    let selection = prepared.emitters.selection.as_ref();
    selection.and_then(Selection::tree).expect("a light tree")
}

/// Two lamps of powers 1 : 10⁶; all kinds of lights; and many.
fn scenes() -> Vec<(&'static str, Prepared)> {
    let mut two = floor_pixel();
    two.lights = vec![
        point_light(DVec3::new(0.0, 0.0, 1.0), 1e-3),
        point_light(DVec3::new(1.0, 0.0, 1.0), 1e3),
    ];
    vec![
        ("1 : 1e6", prepared(two)),
        ("all kinds", prepared(scene_of(0, 1))),
        ("many", prepared(scene_of(300, 2))),
    ]
}

/// Points around the lights, some of them on a light, and normals; both as f32 holds them.
fn places(prepared: &Prepared, count: usize, seed: u32) -> Vec<(DVec3, DVec3)> {
    let mut random = Random::new(seed);
    let lights = &prepared.emitters.lights;
    let place = |i: usize| {
        let x = match lights[i % lights.len()] {
            Emitter::Area { primitive, .. } if i.is_multiple_of(2) => {
                match prepared.data.primitives[primitive as usize].geometry {
                    PrimitiveGeometry::Triangle { a, u, v }
                    | PrimitiveGeometry::Rectangle { a, u, v }
                    | PrimitiveGeometry::Disk { a, u, v } => a + 0.3 * (u + v),
                    PrimitiveGeometry::Sphere { center, radius } => {
                        center + radius * random.direction()
                    }
                    PrimitiveGeometry::Ellipsoid { .. } => {
                        let geometry = prepared.data.primitives[primitive as usize].geometry;
                        let ellipsoid = Ellipsoid::of(&geometry).unwrap();
                        ellipsoid.point(random.direction().normalize())
                    }
                }
            }
            _ => random.in_cube(),
        };
        (rounded(x), rounded(random.direction().normalize()))
    };
    (0..count).map(place).collect()
}

fn words(places: &[(DVec3, DVec3)]) -> Vec<u32> {
    let bits = |v: DVec3| v.as_vec3().to_array().map(f32::to_bits);
    let words = places.iter().flat_map(|(x, n)| [bits(*x), bits(*n)]);
    words.flatten().collect()
}

/// Bounds and importance of every child of every node. Importances differ by the rounding of
/// differences of coordinates, relative to the distance.
#[test]
fn children_are_decoded_and_weighed_as_by_the_twin() {
    let context = context();
    for (name, prepared) in scenes() {
        let tree = tree(&prepared);
        let nodes = tree.nodes.len();
        let function = Function {
            imports: IMPORTS,
            body: "let node = in_u32(6u); let side = in_u32(7u);
                   let c = decode_child(light_choice[3u * node + side], light_choice[3u * node + 2u][side]);
                   out_vec3f(0u, c.center); out_f32(3u, c.radius); out_vec3f(4u, c.half_size); out_vec3f(7u, c.axis);
                   out_vec2f(10u, c.spread); out_f32(12u, c.cos_emission); out_bool(13u, c.two_sided);
                   out_f32(14u, c.intensity); out_f32(15u, tree_importance(c, in_vec3f(0u), in_vec3f(3u)));",
            inputs: 8,
            outputs: 16,
            features: &[],
        };
        let places = places(&prepared, 40 * nodes, 5);
        let mut items = Vec::new();
        for (i, place) in words(&places).chunks_exact(6).enumerate() {
            items.extend_from_slice(place);
            items.extend([(i % nodes) as u32, (i / nodes % 2) as u32]);
        }
        let answers = call_in(context, &prepared, &function, &items, places.len());
        let cosines: Vec<_> = answers.vec2(10).zip(answers.f64(12)).collect();
        let centers: Vec<_> = answers.vec3(0).zip(answers.f64(3)).collect();
        let boxes: Vec<_> = answers.vec3(4).zip(answers.vec3(7)).collect();
        let importance: Vec<f64> = answers.f64(15).collect();
        let (mut lit, mut other) = (0, 0);
        for (i, (x, normal)) in places.iter().enumerate() {
            let (node, side) = (&tree.nodes[i % nodes], i / nodes % 2);
            let child = decode_child(&tree.grid, node[side], node[2][side]);
            let what = format!("{name}, {child:?} from {x}, normal {normal}");
            assert!(centers[i].0.distance(child.center) < 1e-6, "{what}");
            assert_eq!(centers[i].1, child.radius, "{what}");
            assert!(
                boxes[i].0.distance(child.half_size) < 1e-6 * child.radius,
                "{what}"
            );
            assert!(boxes[i].1.distance(child.axis) < 1e-6, "{what}");
            let (sin, cos) = child.spread.sin_cos();
            assert!(
                cosines[i].0.distance(glam::DVec2::new(cos, sin)) < 1e-6,
                "{what}"
            );
            assert!((cosines[i].1 - child.emission.cos()).abs() < 1e-6, "{what}");
            let expected = tree_importance(&child, *x, *normal);
            lit += usize::from(expected > 1e-20);
            let d = (child.center - x).length().max(child.radius);
            let full = child.intensity / (d * d);
            // Relative to an importance with cosines 1, as a cosine near 0 has the rounding of one
            // near 1.
            let error = (importance[i] - expected).abs() / full;
            let allowed = 1e-5 + 2e-6 / d;
            other += usize::from(error > allowed);
            assert!(
                error < allowed || at_threshold(&child, *x, *normal),
                "{what}: {} for {expected}",
                importance[i]
            );
        }
        assert!(lit > places.len() / 20, "{name}: {lit} are lit");
        assert!(
            other <= places.len() / 1000,
            "{name}: {other} at a threshold"
        );
    }
}

/// Whether the importance jumps within rounding of `x`.
fn at_threshold(child: &TreeChild, x: DVec3, normal: DVec3) -> bool {
    let at = |offset: DVec3| tree_importance(child, x + offset, normal);
    let near = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| (at(1e-6 * axis), at(-1e-6 * axis)));
    let (low, high) = near
        .iter()
        .fold((at(DVec3::ZERO), at(DVec3::ZERO)), |(l, h), (a, b)| {
            (l.min(*a).min(*b), h.max(*a).max(*b))
        });
    high > 1.01 * low
}

/// Decisions of a walk are the twin's, word for word, also after the first word is used up.
#[test]
fn walks_are_bit_identical() {
    let function = Function {
        imports: IMPORTS,
        body: "var walk = TreeWalk(in_u32(0u), 0xffffffffu, vec4u(in_u32(0u), 1u, 2u, 3u));
               var way = 0u;
               for (var level = 0u; level < 32u; level += 1u) {
                   let p = f32((in_u32(1u) >> (level & 15u)) & 0xfffu) * (1.0 / 4096.0);
                   way = (way << 1u) | select(0u, 1u, walk_left(&walk, PdfDiscrete(p)));
               }
               out_u32(0u, way); out_u32(1u, walk.code); out_u32(2u, walk.range);",
        inputs: 2,
        outputs: 3,
        features: &["LIGHT_TREE"],
    };
    let mut random = Random::new(11);
    let mut items: Vec<u32> = (0..20_000).map(|_| random.word()).collect();
    items.extend([0, u32::MAX, u32::MAX, u32::MAX, u32::MAX, 1, 0, 0]);
    let prepared = prepared(scene_of(0, 1));
    let answers = call_in(context(), &prepared, &function, &items, items.len() / 2);
    let found = answers.u32(0).zip(answers.u32(1)).zip(answers.u32(2));
    for (item, ((way, code), range)) in items.chunks_exact(2).zip(found) {
        let mut walk = TreeWalk::new(item[0], [item[0], 1, 2, 3]);
        let mut expected = 0;
        for level in 0..32 {
            let p = f64::from(item[1] >> (level & 15) & 0xfff) / 4096.0;
            expected = expected << 1 | u32::from(walk.walk_left(PdfDiscrete(p)));
        }
        assert_eq!(
            (way, code, range),
            (expected, walk.code, walk.range),
            "{item:?}"
        );
    }
}

#[test]
fn axes_and_angles_are_the_twins() {
    let function = Function {
        imports: IMPORTS,
        body: "out_vec3f(0u, decode_axis(in_u32(0u)));
               let a = in_vec2f(1u); let b = in_vec2f(3u);
               out_vec2f(3u, subtract_angle(a, b)); out_f32(5u, cosine_bound(a.x, b.y, 1.0));",
        inputs: 5,
        outputs: 6,
        features: &[],
    };
    let mut random = Random::new(12);
    let mut items = Vec::new();
    let mut angles = Vec::new();
    for _ in 0..5000 {
        let pair = [(); 2].map(|()| std::f64::consts::PI * random.uniform());
        items.push(random.word());
        for angle in pair {
            let (sin, cos) = angle.sin_cos();
            items.extend([(cos as f32).to_bits(), (sin as f32).to_bits()]);
        }
        angles.push(pair);
    }
    let prepared = prepared(scene_of(0, 1));
    let answers = call_in(context(), &prepared, &function, &items, angles.len());
    let found = answers.vec3(0).zip(answers.vec2(3)).zip(answers.f64(5));
    for ((item, [a, b]), ((axis, difference), bound)) in
        items.chunks_exact(5).zip(&angles).zip(found)
    {
        assert!(
            axis.distance(decode_axis(item[0])) < 1e-6,
            "{:08x}",
            item[0]
        );
        let (sin, cos) = (a - b).max(0.0).sin_cos();
        assert!(
            difference.distance(glam::DVec2::new(cos, sin)) < 1e-6,
            "{a} − {b}"
        );
        let expected = cosine_bound(a.cos(), b.sin(), 1.0);
        assert!(
            (bound - expected).abs() < 1e-5,
            "{a}, {b}: {bound} for {expected}"
        );
    }
}
