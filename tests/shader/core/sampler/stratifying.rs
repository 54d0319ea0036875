//! Samplers that stratify: their patterns and names.

use super::{ALL_GROUPS, RANDOM_GROUP, input};
use crate::support::context;
use crate::support::random::Random;
use crate::support::shader::{Function, call};
use crate::support::statistics::{accept, reject};
use direkt::low_level::reference::core::sampler::{
    GROUP_DIRECTION, GROUP_FILM, GROUP_LIGHT, Numbers, SampleId,
};
use direkt::low_level::stats::moments::Moments;
use direkt::low_level::stats::z_test::z_test;
use direkt::scene::Sampler;

/// Each sampler's groups are the twin's, bit for bit, with patterns of several sizes.
#[test]
fn groups_of_every_sampler_are_bit_identical() {
    let context = context();
    for (sampler, feature) in [
        (Sampler::Stratified, "SAMPLER_STRATIFIED"),
        (Sampler::Sobol, "SAMPLER_SOBOL"),
        (Sampler::BlueNoise, "SAMPLER_BLUE_NOISE"),
    ] {
        let mut random = Random::new(64);
        let features = [feature];
        let function = Function {
            body: "let name = SampleId(in_u32(0u), vec2u(in_u32(1u), in_u32(2u)), in_u32(3u), in_u32(5u), vec2u(in_u32(6u), in_u32(7u)));
                   let words = random_group(name, in_u32(4u));
                   out_u32(0u, words.x);
                   out_u32(1u, words.y);
                   out_u32(2u, words.z);
                   out_u32(3u, words.w);",
            inputs: 8,
            features: &features,
            ..RANDOM_GROUP
        };
        let mut items = Vec::new();
        for spp in [1, 5, 64, 1 << 16] {
            for width in [1, 512, 70_000] {
                for i in 0..500 {
                    let index = match i % 3 {
                        0 => i,
                        1 => u64::from(random.word()),
                        _ => u64::from(random.word()) << 32 | u64::from(random.word()),
                    };
                    let id = SampleId {
                        pixel: random.word(),
                        index,
                        seed: 65,
                    };
                    let numbers = Numbers {
                        sampler,
                        pattern: sampler.pattern(spp),
                        width,
                    };
                    items.push((numbers, id, ALL_GROUPS[i as usize % 4]));
                }
            }
        }
        let inputs: Vec<u32> = items
            .iter()
            .flat_map(|(n, id, group)| {
                let named = input(*id, *group);
                named
                    .into_iter()
                    .chain([n.width, n.pattern[0], n.pattern[1]])
            })
            .collect();
        let answers = call(context, &function, &inputs);
        for word in 0..4 {
            for ((numbers, id, group), got) in items.iter().zip(answers.u32(word)) {
                let expected = numbers.group(*id, *group)[word];
                assert_eq!(got, expected, "{numbers:?}, group {group} of {id:?}");
            }
        }
    }
}

/// Even and odd samples are replicates of samplers that stratify: the twin's, with seeds of their
/// own.
#[test]
fn samples_of_every_sampler_are_named_alike() {
    let context = context();
    let indices = [
        0,
        1,
        2,
        3,
        77,
        (1 << 32) - 1,
        1 << 32,
        (1 << 33) + 1,
        u64::MAX,
    ];
    for (sampler, features) in [
        (Sampler::Independent, &[][..]),
        (Sampler::Stratified, &["SAMPLER_STRATIFIED"]),
        (Sampler::Sobol, &["SAMPLER_SOBOL"]),
        (Sampler::BlueNoise, &["SAMPLER_BLUE_NOISE"]),
    ] {
        let function = Function {
            imports: "import package::core::sampler::sample_id;",
            body: "let named = sample_id(in_u32(0u), vec2u(in_u32(1u), in_u32(2u)), in_u32(3u), 7u, vec2u(3u, 2u));
                   out_u32(0u, named.pixel);
                   out_u32(1u, named.index.x);
                   out_u32(2u, named.index.y);
                   out_u32(3u, named.seed);
                   out_u32(4u, named.width + named.pattern.x + named.pattern.y);",
            inputs: 4,
            outputs: 5,
            features,
        };
        let inputs: Vec<u32> = indices
            .iter()
            .flat_map(|&index| [9, index as u32, (index >> 32) as u32, 67])
            .collect();
        let answers = call(context, &function, &inputs);
        let numbers = Numbers {
            sampler,
            ..Numbers::default()
        };
        for (i, &index) in indices.iter().enumerate() {
            let id = numbers.sample_id(9, index, 67);
            let found = [0, 1, 2, 3, 4].map(|word| answers.u32(word).nth(i).unwrap());
            let expected = [
                id.pixel,
                id.index as u32,
                (id.index >> 32) as u32,
                id.seed,
                12,
            ];
            assert_eq!(found, expected, "{sampler}, sample {index}");
        }
        let seeds = [0, 1, 2].map(|index| numbers.sample_id(9, index, 67).seed);
        assert_eq!(seeds[0], seeds[2]);
        assert_eq!(seeds[0] == seeds[1], sampler.is_independent());
    }
}

/// The 64 samples of a pixel's replicate in each pair of dimensions: one in every cell of an 8 × 8
/// grid.
#[test]
fn stratified_samplers_fill_the_grid() {
    for sampler in [Sampler::Stratified, Sampler::Sobol, Sampler::BlueNoise] {
        let numbers = Numbers {
            sampler,
            pattern: sampler.pattern(128),
            width: 9,
        };
        for (pixel, group) in [(0, GROUP_FILM), (40, GROUP_LIGHT), (80, GROUP_DIRECTION)] {
            let mut hits = [[0; 64]; 2];
            for index in 0..64 {
                let id = SampleId {
                    pixel,
                    index,
                    seed: 66,
                };
                let words = numbers.group(id, group);
                for (pair, hits) in words.chunks(2).zip(&mut hits) {
                    hits[(pair[1] >> 29 << 3 | pair[0] >> 29) as usize] += 1;
                }
            }
            assert_eq!(hits, [[1; 64]; 2], "{sampler}, pixel {pixel}");
        }
    }
}

/// How samples of a grid lie to each other in one pair of dimensions tells nothing of how they do
/// in another.
#[test]
fn grids_of_different_pairs_are_shuffled_independently() {
    let numbers = Numbers {
        sampler: Sampler::Stratified,
        pattern: [3, 3],
        width: 512,
    };
    let id = |pixel, index| SampleId {
        pixel,
        index,
        seed: 68,
    };
    let words = |id| [GROUP_FILM, GROUP_LIGHT].map(|group| numbers.group(id, group));
    let halves = |index, pixel| -> [bool; 8] {
        let words = words(id(pixel, index));
        std::array::from_fn(|i| words[i / 4][i % 4] >> 31 == 1)
    };
    // Which halves two samples of a grid share: 0 or 1 for the columns and the rows of four pairs
    // of dimensions.
    let mut random = Random::new(69);
    let mut shared: [Vec<f64>; 8] = Default::default();
    for pixel in 0..1 << 18 {
        let first = random.word() % 64;
        let second = (first + 1 + random.word() % 63) % 64;
        let [a, b] = [first, second].map(|index| halves(u64::from(index), pixel));
        for (shared, (a, b)) in shared.iter_mut().zip(a.into_iter().zip(b)) {
            shared.push(f64::from(u8::from(a == b)));
        }
    }
    for i in 0..8 {
        for j in i / 2 * 2 + 2..8 {
            let what = format!("stratified, seed 68, shared halves of axes {i} and {j}");
            accept(independence_p_value(&shared[i], &shared[j]), &what);
        }
    }
    // Broken: a twentieth of the grids of two pairs have one shuffling.
    let source = |i: usize| if i.is_multiple_of(20) { 0 } else { 2 };
    let tied: Vec<f64> = (0..shared[0].len()).map(|i| shared[source(i)][i]).collect();
    let p = independence_p_value(&shared[0], &tied);
    reject(
        p,
        "stratified, a twentieth of two pairs' grids shuffled alike",
    );
}

/// p-value of the hypothesis that numbers do not correlate, whatever their means and variances.
fn independence_p_value(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len() as f64;
    let moments = |x: &[f64]| -> Moments { x.iter().copied().collect() };
    let (of_a, of_b) = (moments(a), moments(b));
    let products = a
        .iter()
        .zip(b)
        .map(|(a, b)| (a - of_a.mean) * (b - of_b.mean));
    let variance = |m: &Moments| m.variance().expect("more than one number");
    let variance = variance(&of_a) * variance(&of_b) / n;
    z_test(products.sum::<f64>() / n, 0.0, variance, 0.0).p_value
}
