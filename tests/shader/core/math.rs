//! `shaders/core/math.wesl`.

use crate::support::context;
use crate::support::random::Random;
use crate::support::rounding::{U, assert_near};
use crate::support::shader::{Function, call, words};
use direkt::low_level::reference::core::math::{
    angle_of, half_angle_squares, luminance, max_abs, multiply_high, sin_cos_octant, sin_cos_two_pi,
};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_4, PI};

/// The sum 1 + y·p with y ≤ 0.62, |p| ≤ ½: ½ U for the sum, ⅓ U each for y·p and for the rounding
/// of y, ¼ U for p, and Taylor's remainder x¹⁰/10! ≤ 0.42 U of the cosine: below 2 U, and below 3 U
/// with what the lower terms add. The sine is a multiple of x, so its error is relative; |s| ≥ 0.9
/// and another product: 4 U.
#[test]
fn sines_and_cosines_are_the_twins() {
    let context = context();
    let function = Function {
        imports: "import package::core::math::{sin_cos_octant, sin_cos_two_pi};",
        body: "out_vec2f(0u, sin_cos_octant(in_f32(0u)));
               out_vec2f(2u, sin_cos_two_pi(in_f32(1u)));",
        inputs: 2,
        outputs: 4,
        features: &[],
    };
    let mut random = Random::new(11);
    let octant = f64::from((FRAC_PI_4 as f32).next_down());
    let mut cases = vec![[0.0, 0.0], [octant, U], [-octant, 1.0 - U], [1e-30, 1e-30]];
    for turns in [0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875] {
        cases.extend([-U, -0.125 * U, 0.0, U].map(|d| [turns * octant, turns + d]));
    }
    cases.extend((0..100_000).map(|_| [random.between(-octant, octant), random.uniform()]));
    let rounded = |x: f64| f64::from(x as f32);
    let inputs: Vec<f64> = cases.iter().flatten().copied().collect();
    let answers = call(context, &function, &words(&inputs));
    for ((case, of_octant), of_turn) in cases.iter().zip(answers.vec2(0)).zip(answers.vec2(2)) {
        let [x, u] = case.map(rounded);
        let what = format!("{}: {x}, {u}", context.adapter.name);
        let expected = sin_cos_octant(x);
        assert_near(of_octant.x, expected.x, 4.0 * U * expected.x.abs(), &what);
        assert_near(of_octant.y, expected.y, 3.0 * U, &what);
        // u less a multiple of ¼ is exact, 2π as f32 is off by ½ U and the product by U: 1.5 U of x
        // more.
        let expected = sin_cos_two_pi(u);
        assert!(
            (of_turn - expected).abs().max_element() <= 5.0 * U,
            "{what}"
        );
        if 4.0 * u == (4.0 * u).round() {
            assert_eq!(of_turn, expected.round(), "{what}: a quarter turn is exact");
        }
    }
}

/// The polynomial is off by 2e-8 = ⅓ U (Abramowitz & Stegun 4.4.49). For angles up to π/4: the
/// quotient is off by 5 U, of which tan/(1 + tan²) ≤ ½ counts; the square, the sum 1 + z·p and the
/// product with q add 2 U: 5 U. Beyond, π/2 as f32 (¾ U) and the difference (1 U, twice the
/// magnitude), then π (1½ U) and the difference (2 U).
#[test]
fn angles_are_the_twins() {
    let context = context();
    let function = Function {
        imports: "import package::core::math::angle_of;",
        body: "out_f32(0u, angle_of(in_f32(0u), in_f32(1u)));",
        inputs: 2,
        outputs: 1,
        features: &[],
    };
    let mut random = Random::new(12);
    let edges = [
        0.0,
        1e-37,
        1e-20,
        1e-4,
        1.0 - U,
        1.0,
        1.0 + 2.0 * U,
        3.0,
        1e20,
        8e37,
    ];
    let edges: Vec<f64> = edges.iter().flat_map(|&x| [x, -x]).collect();
    let mut cases: Vec<[f64; 2]> = edges
        .iter()
        .flat_map(|&y| {
            edges
                .iter()
                .map(move |&x| [y, x].map(|v| f64::from(v as f32)))
        })
        .collect();
    for _ in 0..100_000 {
        let d = random.direction();
        cases.push([d.x, d.y]);
    }
    let inputs: Vec<f64> = cases.iter().flatten().copied().collect();
    let answers = call(context, &function, &words(&inputs));
    for ([y, x], angle) in cases.iter().zip(answers.f64(0)) {
        let expected = angle_of(*y, *x);
        let bound = match expected.abs() / FRAC_PI_4 {
            octant if octant <= 1.0 => 5.0 * U,
            octant if octant <= 2.0 => 7.0 * U,
            _ => 11.0 * U,
        };
        assert_near(
            angle,
            expected,
            bound,
            format!("{}: ({x}, {y})", context.adapter.name),
        );
        assert!(angle.abs() <= f64::from(PI as f32), "({x}, {y})");
    }
}

/// The larger square is a sum, 1 U, which the cosine's own rounding U moves by as much; the smaller
/// a product with the squared sine, known to U, and a quotient, 5 U: 8 U. Of angles that f32 cannot
/// tell from 0 and π as well.
#[test]
fn squares_of_half_angles_are_the_twins() {
    let context = context();
    let function = Function {
        imports: "import package::core::math::half_angle_squares;",
        body: "out_vec2f(0u, half_angle_squares(in_f32(0u), in_f32(1u)));",
        inputs: 2,
        outputs: 2,
        features: &[],
    };
    let mut random = Random::new(16);
    let small = (0..10_000).map(|_| random.magnitude(1e-15, 1.0));
    let angles: Vec<f64> = small
        .flat_map(|x| [x, PI * x, PI - x, PI * (1.0 - x)])
        .collect();
    let inputs: Vec<f64> = angles
        .iter()
        .flat_map(|x| [x.cos(), x.sin().powi(2)])
        .collect();
    let answers = call(context, &function, &words(&inputs));
    for ((angle, given), found) in angles
        .iter()
        .zip(inputs.chunks_exact(2))
        .zip(answers.vec2(0))
    {
        let what = format!("{}: {angle}", context.adapter.name);
        let expected = half_angle_squares(given[0], given[1]);
        assert_near(found.x, expected.x, 8.0 * U * expected.x, &what);
        assert_near(found.y, expected.y, 8.0 * U * expected.y, &what);
    }
}

#[test]
fn high_words_of_products_are_bit_identical() {
    let context = context();
    let function = Function {
        imports: "import package::core::math::multiply_high;",
        body: "out_u32(0u, multiply_high(in_u32(0u), in_u32(1u)));",
        inputs: 2,
        outputs: 1,
        features: &[],
    };
    let mut random = Random::new(13);
    let edges = [
        0,
        1,
        2,
        0xffff,
        0x1_0000,
        0x1_0001,
        0x7fff_ffff,
        0x8000_0000,
        u32::MAX - 1,
        u32::MAX,
    ];
    let pairs = edges
        .iter()
        .flat_map(|&a| edges.iter().map(move |&b| [a, b]));
    let drawn: Vec<[u32; 2]> = (0..100_000)
        .map(|_| [random.word(), random.word()])
        .collect();
    let inputs: Vec<u32> = pairs.chain(drawn).flatten().collect();
    let answers = call(context, &function, &inputs);
    for (pair, high) in inputs.chunks_exact(2).zip(answers.u32(0)) {
        assert_eq!(high, multiply_high(pair[0], pair[1]), "{pair:?}");
    }
}

/// The weights are rounded, U, and the dot product is off by 3 U of its terms.
#[test]
fn luminance_and_largest_component_are_the_twins() {
    let context = context();
    let function = Function {
        imports: "import package::core::math::{luminance, max_abs};",
        body: "out_f32(0u, luminance(in_vec3f(0u)));
               out_f32(1u, max_abs(in_vec3f(0u)));",
        inputs: 3,
        outputs: 2,
        features: &[],
    };
    let mut random = Random::new(14);
    let mut cases = vec![
        DVec3::ZERO,
        DVec3::splat(1e30_f32.into()),
        -DVec3::Z,
        DVec3::Y,
    ];
    cases.extend((0..10_000).map(|_| {
        (random.in_cube() * random.magnitude(1e-9, 1e9))
            .as_vec3()
            .as_dvec3()
    }));
    let inputs: Vec<f64> = cases.iter().flat_map(|v| v.to_array()).collect();
    let answers = call(context, &function, &words(&inputs));
    for ((v, grey), largest) in cases.iter().zip(answers.f64(0)).zip(answers.f64(1)) {
        assert_near(grey, luminance(*v), 4.0 * U * luminance(v.abs()), v);
        assert_eq!(largest, max_abs(*v), "{v}");
    }
}
