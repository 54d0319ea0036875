//! `shaders/core/sobol.wesl`.

use crate::support::random::Random;
use crate::support::shader::{Function, call};
use crate::support::{context, statistics};
use direkt::low_level::reference::core::rng::pcg4d;
use direkt::low_level::reference::core::sobol::{
    scramble_reversed, sobol_2d, sobol_second_reversed,
};
use direkt::low_level::stats::chi2::{Totals, chi2_test};

const POINT: Function<'_> = Function {
    imports: "import package::core::sobol::sobol_2d;",
    body: "let p = sobol_2d(in_u32(0u), vec3u(in_u32(1u), in_u32(2u), in_u32(3u)));
           out_u32(0u, p.x);
           out_u32(1u, p.y);",
    inputs: 4,
    outputs: 2,
    features: &[],
};

#[test]
fn integers_are_bit_identical() {
    let mut random = Random::new(60);
    let mut items: Vec<[u32; 4]> = vec![[0; 4], [u32::MAX; 4], [1 << 31, 0, u32::MAX, 1]];
    items.extend((0..20_000).map(|_| std::array::from_fn(|_| random.word())));
    let inputs: Vec<u32> = items.iter().flatten().copied().collect();
    let function = Function {
        imports: "import package::core::sobol::{scramble_reversed, sobol_2d, sobol_second_reversed};",
        body: "let p = sobol_2d(in_u32(0u), vec3u(in_u32(1u), in_u32(2u), in_u32(3u)));
               out_u32(0u, p.x);
               out_u32(1u, p.y);
               out_u32(2u, sobol_second_reversed(in_u32(0u)));
               out_u32(3u, scramble_reversed(in_u32(0u), in_u32(1u)));",
        outputs: 4,
        ..POINT
    };
    let answers = call(context(), &function, &inputs);
    for word in 0..4 {
        let twins = items.iter().map(|&[index, a, b, c]| match word {
            2 => sobol_second_reversed(index),
            3 => scramble_reversed(index, a),
            _ => sobol_2d(index, [a, b, c])[word],
        });
        assert!(answers.u32(word).eq(twins), "word {word}");
    }
}

/// The first 2^m points, and every later block of 2^m: each elementary interval of area 2^−m holds
/// exactly one, for all its shapes 2^−k × 2^(k − m) (Sobol' 1967). Scrambling and shuffling keep
/// that.
#[test]
fn every_block_is_a_net() {
    const BITS: u32 = 8;
    let context = context();
    for (seed, block) in [(0, 0), (1, 1), (2, 77)] {
        let seeds = pcg4d([seed, 61, 0, 0]);
        let inputs: Vec<u32> = (0..1 << BITS)
            .flat_map(|i| [(block << BITS) + i, seeds[0], seeds[1], seeds[2]])
            .collect();
        let answers = call(context, &POINT, &inputs);
        let points: Vec<(u32, u32)> = answers.u32(0).zip(answers.u32(1)).collect();
        for k in 0..=BITS {
            let mut hits = vec![0; 1 << BITS];
            for &(x, y) in &points {
                let column = u64::from(x) >> (32 - k);
                let row = u64::from(y) >> (32 - (BITS - k));
                hits[(row << k | column) as usize] += 1;
            }
            assert!(hits.iter().all(|&h| h == 1), "seed {seed}, shape {k}");
        }
    }
}

/// One point of many scramblings is uniform: what makes a scrambled sequence unbiased. A scrambling
/// without a seed is not.
#[test]
fn a_point_of_many_scramblings_is_uniform() {
    const CELLS: u32 = 15;
    let context = context();
    let p_value = |seeds: &dyn Fn(u32) -> [u32; 4]| {
        let draws = 1 << 18;
        let inputs: Vec<u32> = (0..draws)
            .flat_map(|i| {
                let [_, a, b, c] = seeds(i);
                [5, a, b, c]
            })
            .collect();
        let answers = call(context, &POINT, &inputs);
        let mut observed = vec![0_u64; (CELLS * CELLS) as usize];
        let cell = |x: u32| ((u64::from(x) * u64::from(CELLS)) >> 32) as usize;
        for (x, y) in answers.u32(0).zip(answers.u32(1)) {
            observed[cell(y) * CELLS as usize + cell(x)] += 1;
        }
        let expected = vec![f64::from(draws) / f64::from(CELLS * CELLS); observed.len()];
        chi2_test(&observed, &expected, Totals::Tied)
            .unwrap()
            .p_value
    };
    let what = format!("sobol_2d, point 5, seed 62, {}", context.adapter.name);
    statistics::accept(p_value(&|i| pcg4d([i, 62, 0, 0])), &what);
    statistics::reject(p_value(&|i| [0, i & 3, 0, 0]), &format!("{what}, unseeded"));
}
