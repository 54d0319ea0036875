//! `shaders/core/bvh.wesl`.

use crate::support::context;
use crate::support::hard_cases::{Measured, survive};
use crate::support::random::Random;
use crate::support::shader::{Function, call, words};
use direkt::low_level::accel::flatten::LEAF;
use direkt::low_level::reference::core::bvh::{Aabb, enter_box};
use direkt::low_level::reference::core::ray::Ray;
use glam::{DVec3, Vec3};

/// Cells by which the build pads boxes before it rounds them outwards to whole ones.
const PADDING: f64 = 0.0625;

const ENTER: Function<'_> = Function {
    imports: "import package::core::bvh::{enter_box, grid_ray};
              import package::core::ray::Ray;",
    body: "let r = grid_ray(Ray(in_vec3f(0u), in_vec3f(3u)), in_vec3f(6u), in_vec3f(9u));
           out_f32(0u, enter_box(r, vec3u(in_u32(12u), in_u32(13u), in_u32(14u)), in_f32(15u)));",
    inputs: 16,
    outputs: 1,
    features: &[],
};

const T_MAX: f64 = 1e30_f32 as f64;

/// A ray, a box in grid cells, and how far the ray reaches.
#[derive(Debug, Clone, Copy)]
struct Case {
    ray: Ray,
    low: DVec3,
    high: DVec3,
    t_max: f64,
}

/// A grid as the build makes it: its corner and cells per unit length.
#[derive(Debug, Clone, Copy)]
struct Grid {
    origin: DVec3,
    scale: DVec3,
}

/// Whether and where the GPU says that the rays enter the boxes as they are.
fn enter(grid: Grid, cases: &[Case]) -> Vec<Option<f64>> {
    let mut inputs = Vec::new();
    for case in cases {
        for v in [case.ray.origin, case.ray.direction, grid.origin, grid.scale] {
            inputs.extend(words(&v.to_array()));
        }
        for axis in 0..3 {
            inputs.push(case.low[axis] as u32 | (case.high[axis] as u32) << 16);
        }
        inputs.extend(words(&[case.t_max]));
    }
    let context = context();
    let answers = call(context, &ENTER, &inputs);
    let result = answers.f64(0).map(|t| {
        assert!(t.is_finite() && t >= 0.0, "{}: {t}", context.adapter.name);
        (t < T_MAX).then_some(t)
    });
    result.collect()
}

/// The same in f64 for the box grown by `by` cells.
fn enter_grown(grid: Grid, case: &Case, by: f64) -> Option<f64> {
    let world = |p: DVec3| grid.origin + p / grid.scale;
    let grown = Aabb {
        low: world(case.low - by),
        high: world(case.high + by),
    };
    // Shrunk, a flat box vanishes.
    let exists = grown.low.cmple(grown.high).all();
    let entered = enter_box(
        case.ray.origin,
        1.0 / case.ray.direction,
        &grown,
        case.t_max,
    );
    entered.filter(|_| exists)
}

/// What the traversal relies on: the test's rounding is below the build's padding. What enters the
/// box shrunk by it enters, what misses the box grown by it misses, and the parameter lies between
/// theirs. Per axis the plane's distance is off by 3 U of the origin's coordinate and 6 U of
/// itself, which for origins within one scene's size of the scene are 0.06 cells.
#[test]
fn boxes_are_entered_within_the_padding() {
    let mut random = Random::new(35);
    let grid = Grid {
        origin: random.in_cube(),
        scale: DVec3::new(32_000.0, 50_000.0, 1e7),
    };
    let cases: Vec<Case> = (0..100_000)
        .map(|i| {
            let cell = |random: &mut Random| (65_535.0 * random.uniform()).floor();
            let corner =
                |random: &mut Random| DVec3::from_array(std::array::from_fn(|_| cell(random)));
            let (a, b) = (corner(&mut random), corner(&mut random));
            let small =
                DVec3::from_array(std::array::from_fn(|_| (20.0 * random.uniform()).floor()));
            let high = if i % 2 == 0 {
                a.max(b)
            } else {
                (a + small).min(DVec3::splat(65_535.0))
            };
            let low = if i % 2 == 0 { a.min(b) } else { a };
            // From within a scene's size, towards the box's surroundings: along its edges and
            // corners, too.
            let from = DVec3::from_array(std::array::from_fn(|_| {
                random.between(-65_535.0, 131_070.0)
            }));
            let at = DVec3::from_array(std::array::from_fn(|_| random.between(-0.1, 1.1)));
            let at = if i % 3 == 0 {
                at.clamp(DVec3::ZERO, DVec3::ONE)
            } else {
                at
            };
            let to = low + at * (high - low);
            let world = |p: DVec3| (grid.origin + p / grid.scale).as_vec3().as_dvec3();
            let direction = ((to - from) / grid.scale).as_vec3().as_dvec3();
            let t_max = [T_MAX, 0.5, 1.0, 2.0][i % 4];
            Case {
                ray: Ray {
                    origin: world(from),
                    direction,
                },
                low,
                high,
                t_max,
            }
        })
        .collect();
    let mut counts = [0, 0];
    for (case, got) in cases.iter().zip(enter(grid, &cases)) {
        let inner = enter_grown(grid, case, -PADDING);
        let outer = enter_grown(grid, case, PADDING);
        assert!(
            inner.is_none() || got.is_some(),
            "{case:?} missed, {inner:?}"
        );
        assert!(outer.is_some() || got.is_none(), "{case:?} met at {got:?}");
        counts[usize::from(got.is_some())] += 1;
        if let (Some(got), Some(outer)) = (got, outer) {
            let latest = inner.unwrap_or(f64::INFINITY);
            assert!(
                (outer..=latest).contains(&got),
                "{case:?}: {outer} {got} {latest}"
            );
        }
    }
    assert!(counts[0] > 10_000 && counts[1] > 10_000, "{counts:?}");
}

/// HARD CASES G6: a ray in the lower face, in the upper face, along an edge, parallel to a face and
/// inside, in a box without thickness, parallel and outside; in either direction along each axis,
/// with boxes padded as the build does.
#[test]
fn axis_parallel_rays_meet_what_they_touch() {
    let grid = Grid {
        origin: DVec3::splat(-1.0),
        scale: DVec3::splat(1024.0),
    };
    let (low, high) = (
        DVec3::new(100.0, 200.0, 300.0),
        DVec3::new(140.0, 260.0, 380.0),
    );
    let flat = DVec3::new(100.0, 260.0, 380.0);
    // x and y in cells, and the box's upper corner; the ray runs along z.
    let rows = [
        (100.0, 230.0, high, true),
        (140.0, 230.0, high, true),
        (100.0, 200.0, high, true),
        (140.0, 260.0, high, true),
        (120.0, 230.0, high, true),
        (100.0, 230.0, flat, true),
        (98.0, 230.0, high, false),
        (142.0, 230.0, high, false),
    ];
    let mut cases = Vec::new();
    let mut expected = Vec::new();
    for (x, y, high, meets) in rows {
        for turn in 0..3 {
            let turned = |p: DVec3| match turn {
                0 => p,
                1 => DVec3::new(p.z, p.x, p.y),
                _ => DVec3::new(p.y, p.z, p.x),
            };
            for (z, direction) in [(0.0, 1.0), (600.0, -1.0), (340.0, 1.0)] {
                // The other components are 0, −0 and what the smallest direction is raised from.
                for tiny in [0.0, -0.0, 1e-30, -1e-30] {
                    cases.push(Case {
                        ray: Ray {
                            origin: grid.origin + turned(DVec3::new(x, y, z)) / grid.scale,
                            direction: turned(DVec3::new(tiny, tiny, direction)),
                        },
                        low: turned(low) - 1.0,
                        high: turned(high) + 1.0,
                        t_max: T_MAX,
                    });
                    expected.push(meets);
                }
            }
        }
    }
    let (mut naive, mut ours) = (0, 0);
    for ((case, meets), got) in cases.iter().zip(expected).zip(enter(grid, &cases)) {
        ours += usize::from(got.is_some() != meets);
        let world = |cells: DVec3, by: f64| (grid.origin + (cells + by) / grid.scale).as_vec3();
        let (low, high) = (world(case.low, 1.0), world(case.high, -1.0));
        let ray = (case.ray.origin.as_vec3(), case.ray.direction.as_vec3());
        naive += usize::from(textbook_slabs(ray, low, high) != meets);
    }
    survive(
        context(),
        Measured {
            entry: "G6",
            case: "rays in faces, along edges, parallel inside and outside, 288 in all",
            figure: "boxes wrongly entered or missed",
            bound: 0.0,
            textbook: "slabs by 1/d, not padded",
            naive: naive as f64,
            ours: ours as f64,
        },
    );
}

/// Kay and Kajiya's slabs with 1/d = ±∞ where d is 0: where an origin lies in a face, 0·∞ is no
/// number, and no comparison with it holds.
fn textbook_slabs((origin, direction): (Vec3, Vec3), low: Vec3, high: Vec3) -> bool {
    let (mut enter, mut leave) = (0.0_f32, f32::INFINITY);
    for axis in 0..3 {
        let inverse = 1.0 / direction[axis];
        let a = (low[axis] - origin[axis]) * inverse;
        let b = (high[axis] - origin[axis]) * inverse;
        let (near, far) = if inverse >= 0.0 { (a, b) } else { (b, a) };
        if !(near <= leave && far >= enter) {
            return false;
        }
        (enter, leave) = (enter.max(near), leave.min(far));
    }
    enter <= leave
}

#[test]
fn references_to_leaves_are_the_builds() {
    let context = context();
    let function = Function {
        imports: "import package::core::bvh::{DONE, LEAF, larger, leaf_count, leaf_first, smaller};",
        body: "out_u32(0u, leaf_first(in_u32(0u)));
               out_u32(1u, leaf_count(in_u32(0u)));
               out_f32(2u, larger(in_f32(1u), in_f32(2u)));
               out_f32(3u, smaller(in_f32(1u), in_f32(2u)));
               out_u32(4u, LEAF);
               out_u32(5u, DONE);",
        inputs: 3,
        outputs: 6,
        features: &[],
    };
    let numbers = [-1e30, -2.0, 0.0, 1e-20, 2.0, 1e30].map(|x| f64::from(x as f32));
    let mut cases = Vec::new();
    for count in 1..=8_u32 {
        for first in [0, 1, 77, 0x0fff_fffe, 0x0fff_ffff] {
            let (a, b) = (numbers[count as usize % 6], numbers[first as usize % 6]);
            cases.push((count, first, a, b));
        }
    }
    let inputs: Vec<u32> = cases
        .iter()
        .flat_map(|&(count, first, a, b)| {
            let [a, b] = [a, b].map(|x| (x as f32).to_bits());
            [LEAF | (count - 1) << 28 | first, a, b]
        })
        .collect();
    let answers = call(context, &function, &inputs);
    for (i, &(count, first, a, b)) in cases.iter().enumerate() {
        let word = |w: usize| answers.u32(w).nth(i);
        assert_eq!((word(0), word(1)), (Some(first), Some(count)));
        assert_eq!(answers.f64(2).nth(i), Some(a.max(b)), "{a} {b}");
        assert_eq!(answers.f64(3).nth(i), Some(a.min(b)), "{a} {b}");
        assert_eq!((word(4), word(5)), (Some(LEAF), Some(u32::MAX)));
    }
}
