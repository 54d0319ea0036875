//! `shaders/core/frame.wesl`.

use crate::support::context;
use crate::support::random::Random;
use crate::support::rounding::{U, assert_all_near, assert_near};
use crate::support::shader::{Function, call, words};
use direkt::low_level::reference::core::frame::{
    ShadingFrame, frame_from_normal, to_local, to_world,
};
use glam::DVec3;

/// All kinds of unit vectors: random ones, the axes, and beside the poles, where z changes sign.
fn normals() -> Vec<DVec3> {
    let mut random = Random::new(15);
    let mut normals = vec![
        DVec3::X,
        DVec3::Y,
        DVec3::Z,
        -DVec3::X,
        -DVec3::Y,
        -DVec3::Z,
    ];
    for tiny in [1e-30, 1e-20, 1e-8, 1e-4] {
        for (a, b) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
            normals.push(DVec3::new(a * tiny, b * tiny, -1.0));
            normals.push(DVec3::new(a * tiny, b * tiny, 1.0));
            normals.push(DVec3::new(a, 0.0, b * tiny));
        }
    }
    normals.extend((0..100_000).map(|_| random.direction()));
    normals
        .iter()
        .map(|n| n.normalize().as_vec3().as_dvec3())
        .collect()
}

/// ±1 + z has magnitude 1 to 2, so 1/(±1 + z) is off by 6 U; 1 + x²/(±1 + z) by 9 U, all terms
/// being at most 1, and xy/(…) by 8 U. The normal itself, rounded to f32, has its length off by 2
/// U; scalar products of two axes are off by 3 × 10 U for each and by what the length does.
#[test]
fn frames_are_the_twins_and_orthonormal() {
    let context = context();
    let function = Function {
        imports: "import package::core::frame::frame_from_normal;",
        body: "let f = frame_from_normal(in_vec3f(0u));
               out_vec3f(0u, f.x);
               out_vec3f(3u, f.y);
               out_vec3f(6u, f.z);",
        inputs: 3,
        outputs: 9,
        features: &[],
    };
    let normals = normals();
    let inputs: Vec<f64> = normals.iter().flat_map(|n| n.to_array()).collect();
    let answers = call(context, &function, &words(&inputs));
    let axes = answers.vec3(0).zip(answers.vec3(3)).zip(answers.vec3(6));
    for (n, ((x, y), z)) in normals.iter().zip(axes) {
        let what = format!("{}: {n}", context.adapter.name);
        let expected = frame_from_normal(*n);
        assert_all_near(x, expected.x, 10.0 * U, &what);
        assert_all_near(y, expected.y, 10.0 * U, &what);
        assert_eq!(z, *n, "{what}");
        for (a, b) in [(x, y), (y, z), (z, x)] {
            assert_near(a.dot(b), 0.0, 64.0 * U, &what);
        }
        for a in [x, y] {
            assert_near(a.length_squared(), 1.0, 64.0 * U, &what);
        }
        assert!(x.cross(y).dot(z) > 0.0, "{what}: left-handed");
    }
}

/// Each component is a sum of three products: 3 U of their magnitudes. Any frame will do, not only
/// orthonormal ones.
#[test]
fn changes_of_frame_are_the_twins() {
    let context = context();
    let function = Function {
        imports: "import package::core::frame::{ShadingFrame, to_local, to_world};",
        body: "let f = ShadingFrame(in_vec3f(0u), in_vec3f(3u), in_vec3f(6u));
               out_vec3f(0u, to_local(f, in_vec3f(9u)));
               out_vec3f(3u, to_world(f, in_vec3f(9u)));",
        inputs: 12,
        outputs: 6,
        features: &[],
    };
    let mut random = Random::new(16);
    let cases: Vec<[DVec3; 4]> = (0..20_000)
        .map(|_| std::array::from_fn(|_| random.in_cube()))
        .collect();
    let inputs: Vec<f64> = cases.iter().flatten().flat_map(|v| v.to_array()).collect();
    let answers = call(context, &function, &words(&inputs));
    for (&[x, y, z, v], (local, world)) in cases.iter().zip(answers.vec3(0).zip(answers.vec3(3))) {
        let frame = ShadingFrame { x, y, z };
        let magnitudes = ShadingFrame {
            x: x.abs(),
            y: y.abs(),
            z: z.abs(),
        };
        let bound = 3.0 * U * to_local(&magnitudes, v.abs());
        let off = (local - to_local(&frame, v)).abs();
        assert!(off.cmple(bound).all(), "{v} is {local} there");
        let bound = 3.0 * U * to_world(&magnitudes, v.abs());
        let off = (world - to_world(&frame, v)).abs();
        assert!(off.cmple(bound).all(), "{v} is {world} here");
    }
}
