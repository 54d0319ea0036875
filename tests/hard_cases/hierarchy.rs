//! The hierarchy: HARD CASES G6, G7.

use super::meshes::{meshes, triangle, unlike_brute_force};
use crate::support::hard_cases::{Measured, survive};
use crate::support::random::{Random, rounded};
use crate::support::shader::{Function, call_in, words};
use crate::support::{context, floor_pixel, prepared_for, shape};
use direkt::low_level::accel::flatten::MAX_DEPTH;
use direkt::low_level::gpu::Context;
use direkt::low_level::prepare::Prepared;
use direkt::scene::{Geometry, LightSelection, Mesh, Strategy};
use glam::DVec3;

/// Levels of the hierarchy that halves space along x.
fn depth_of_spatial_median(centers: Vec<f64>, levels: usize) -> usize {
    let low = centers.iter().copied().fold(f64::INFINITY, f64::min);
    let high = centers.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if centers.len() <= 2 || low >= high {
        return levels;
    }
    let middle = 0.5 * (low + high);
    let (left, right) = centers.into_iter().partition(|&c| c < middle);
    depth_of_spatial_median(left, levels + 1).max(depth_of_spatial_median(right, levels + 1))
}

#[test]
fn a_hierarchy_is_never_deeper_than_the_stack() {
    let context = context();
    let at = |x: f64, size: f64| {
        triangle(
            DVec3::new(x, 0.0, 0.0),
            DVec3::new(x, size, 0.0),
            DVec3::new(x, 0.0, size),
        )
    };
    let exponents = || (0..140).map(|k| f64::from(-k).exp2());
    let mut all: Vec<Mesh> = exponents().map(|x| at(x, 1.0)).collect();
    all.extend((0..4096).map(|_| at(0.7, 0.5)));
    let prepared = meshes(all);
    assert!(prepared.data.bvh.depth as u32 <= prepared.data.stack_depth());
    let n = &prepared.data.normalization;
    let mut random = Random::new(74);
    let rays: Vec<_> = (0..500)
        .map(|_| {
            let to = DVec3::new(0.6, 0.8 * random.uniform(), 0.8 * random.uniform());
            let side = if random.uniform() < 0.5 { -1.0 } else { 1.0 };
            let from = to + DVec3::new(2.0 * side, 0.1 * random.uniform(), 0.0);
            [rounded(n.point(from)), rounded(n.vector(to - from))]
        })
        .collect();
    let (unlike, hits) = unlike_brute_force(&prepared, &rays);
    assert!(hits > 100, "{hits} hits");
    assert_eq!(unlike, 0, "{}", context.adapter.name);
    survive(
        context,
        Measured {
            entry: "G7",
            case: "triangles at 2⁻ᵏ, k below 140, and 4096 in one place",
            figure: "levels of the hierarchy",
            bound: MAX_DEPTH as f64,
            textbook: "halves of space",
            naive: depth_of_spatial_median(exponents().collect(), 0) as f64,
            ours: prepared.data.bvh.depth as f64,
        },
    );
}

/// Where the hierarchy finds that rays stop, and where all primitives in turn do, both on the GPU:
/// pairs of distances, for an origin and a direction each in `inputs`.
pub(super) fn distances_by_both_ways(
    context: &Context,
    prepared: &Prepared,
    inputs: &[f64],
) -> Vec<[f64; 2]> {
    let body = format!(
        "let ray = Ray(in_vec3f(0u), in_vec3f(3u));
         let hit = closest_hit(ray);
         var nearest = T_MAX;
         for (var i = 0u; i < {}u; i++) {{
             nearest = min(nearest, intersect_primitive(ray_frame(ray), fetch_primitive(i), T_MAX).t);
         }}
         out_f32(0u, hit.t); out_f32(1u, nearest);",
        prepared.data.primitives.len()
    );
    let function = Function {
        imports: "import package::core::constants::T_MAX;
                  import package::core::ray::{Ray, ray_frame};
                  import package::scene::fetch::fetch_primitive;
                  import package::scene::trace::{closest_hit, intersect_primitive};",
        body: &body,
        inputs: 6,
        outputs: 2,
        features: &[],
    };
    let rays = inputs.len() / function.inputs;
    let answers = call_in(context, prepared, &function, &words(inputs), rays);
    let both = answers.f64(0).zip(answers.f64(1));
    both.map(|(found, nearest)| [found, nearest]).collect()
}

/// Axis-parallel rays and boxes' faces on whole numbers: what the hierarchy finds is what all
/// primitives in turn give, bit for bit.
#[test]
fn rays_on_whole_numbers_are_hit_as_in_brute_force() {
    const RAYS: usize = 100_000;
    let context = context();
    let mut random = Random::new(75);
    let whole = |random: &mut Random, most: f64| (most * random.uniform()).floor();
    let mut scene = floor_pixel();
    scene.shapes.clear();
    for i in 0..100 {
        let corner = DVec3::from_array(std::array::from_fn(|_| whole(&mut random, 32.0)));
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        let u = axes[i % 3] * (1.0 + whole(&mut random, 8.0));
        let v = axes[(i + 1) % 3] * (1.0 + whole(&mut random, 8.0));
        let geometry = if i % 2 == 0 {
            Geometry::Rectangle { corner, u, v }
        } else {
            Geometry::Mesh(triangle(corner, corner + u, corner + v))
        };
        scene.shapes.push(shape("face", geometry));
    }
    let prepared = prepared_for(scene, Strategy::LightArea, LightSelection::Uniform);
    let n = &prepared.data.normalization;
    let inputs: Vec<f64> = (0..RAYS)
        .flat_map(|i| {
            let mut from = DVec3::from_array(std::array::from_fn(|_| whole(&mut random, 40.0)));
            let axis = i % 3;
            let side = if random.uniform() < 0.5 { 1.0 } else { -1.0 };
            from[axis] = 20.0 - 30.0 * side;
            let mut d = DVec3::ZERO;
            d[axis] = side;
            [n.point(from).to_array(), d.to_array()]
        })
        .flatten()
        .collect();
    let distances = distances_by_both_ways(context, &prepared, &inputs);
    assert_eq!(distances.len(), RAYS);
    let hits = distances.iter().filter(|[_, t]| *t < 1e29).count();
    assert!(hits > RAYS / 10, "{hits} hits");
    for (i, [found, nearest]) in distances.into_iter().enumerate() {
        assert_eq!(found, nearest, "ray {i}, {}", context.adapter.name);
    }
}
