//! `shaders/kernel/accumulate.wesl`: blocks of 256 samples against Welford's recurrence in f64.

use crate::support::context;
use crate::support::hard_cases::{Measured, survive};
use crate::support::random::numbers;
use crate::support::rounding::U;
use crate::support::shader::{Answers, Function, call};
use direkt::low_level::gpu::layout::BLOCK_SAMPLES;
use direkt::low_level::stats::moments::Moments;

const LENGTH: usize = BLOCK_SAMPLES as usize;

/// One block per item.
fn accumulated(blocks: &[Vec<[f32; 3]>]) -> Answers {
    let function = Function {
        imports: "import package::kernel::accumulate::{accumulate, fresh_state};",
        body: "var state = fresh_state();
               for (var i = 0u; i < 256u; i += 1u) {
                   accumulate(&state, in_vec3f(3u * i), i);
               }
               out_vec3f(0u, state.mean); out_vec3f(3u, state.m2);
               out_u32(6u, state.samples); out_u32(7u, state.dropped);
               out_u32(8u, state.first_bad & 0xffffu); out_u32(9u, state.first_bad >> 16u);
               out_u32(10u, state.shadow_rays + state.bsdf_rays);
               out_vec3f(11u, state.second_mean); out_u32(14u, state.second_samples);
               out_vec3f(15u, state.second_m2);",
        inputs: 3 * LENGTH,
        outputs: 18,
        features: &[],
    };
    let words: Vec<u32> = blocks
        .iter()
        .flat_map(|block| {
            assert_eq!(block.len(), LENGTH);
            block.as_flattened().iter().map(|x| x.to_bits())
        })
        .collect();
    call(context(), &function, &words)
}

/// The finite samples' moments of one channel.
fn moments(block: &[[f32; 3]], channel: usize) -> Moments {
    let finite = block.iter().filter(|rgb| rgb.iter().all(|x| x.is_finite()));
    finite.map(|rgb| f64::from(rgb[channel])).collect()
}

fn block(value: impl Fn(u32) -> f32) -> Vec<[f32; 3]> {
    let rgb = |i: u32| [value(3 * i), value(3 * i + 1), value(3 * i + 2)];
    (0..BLOCK_SAMPLES).map(rgb).collect()
}

/// Each step rounds the difference, its part and the new mean: n steps, 2 roundings of the largest
/// sample each, as the worst case. The squares inherit the mean's error times twice the deviations,
/// and 8 roundings of their own.
fn assert_near(found: [f64; 2], expected: &Moments, largest: f64, what: &str) {
    let [mean, m2] = found;
    let of_mean = 2.0 * expected.count as f64 * U * largest;
    assert!(
        (mean - expected.mean).abs() <= of_mean,
        "{what}: {mean}, not {expected:?}"
    );
    // Σ|x − mean| ≤ √(n m2).
    let deviations = (expected.count as f64 * expected.m2).sqrt();
    let of_m2 =
        2.0 * of_mean * (deviations + expected.count as f64 * of_mean) + 8.0 * U * expected.m2;
    assert!(
        (m2 - expected.m2).abs() <= of_m2,
        "{what}: m2 {m2}, not {expected:?}"
    );
    assert!(m2 >= 0.0, "{what}");
}

/// All samples and the second replicate.
fn assert_moments(answers: &Answers, item: usize, block: &[[f32; 3]], what: &str) {
    let odd: Vec<_> = block.iter().skip(1).step_by(2).copied().collect();
    for channel in 0..3 {
        let values = block.iter().map(|rgb| f64::from(rgb[channel].abs()));
        let largest = values.filter(|x| x.is_finite()).fold(0.0, f64::max);
        let found = |word: usize| answers.f64(word + channel).nth(item).unwrap();
        let all = moments(block, channel);
        assert_near([found(0), found(3)], &all, largest, what);
        let second = moments(&odd, channel);
        let of_second = format!("{what}, second replicate");
        assert_near([found(11), found(15)], &second, largest, &of_second);
        let count = answers.u32(14).nth(item).unwrap();
        assert_eq!(u64::from(count), second.count, "{what}");
    }
}

#[test]
fn blocks_have_the_moments_of_their_samples() {
    let random = |stream: u32| move |i: u32| numbers(i, stream, 31)[0] as f32;
    let blocks = [
        block(|_| 0.1),
        block(|_| 0.0),
        block(random(0)),
        // Heavy tails.
        block(|i| (1.0 / (random(1)(i) + 1e-6)).powi(2)),
        block(|i| if i.is_multiple_of(97) { 1e30 } else { 1e-30 }),
    ];
    let answers = accumulated(&blocks);
    for (item, block) in blocks.iter().enumerate() {
        if item < 4 {
            assert_moments(&answers, item, block, &format!("block {item}"));
        }
        assert!(answers.f64(0).nth(item).unwrap().is_finite());
    }
    let state: Vec<u32> = (6..11)
        .map(|word| answers.u32(word).next().unwrap())
        .collect();
    assert_eq!(state, [BLOCK_SAMPLES, 0, 0xffff, 0xffff, 0]);
}

/// HARD CASES A3: mean 100, standard deviation 0.01; E\[x²\] − E\[x\]² would be −7.5.
#[test]
fn variance_survives_a_large_mean() {
    let normal_like = |i: u32| numbers(i, 2, 31).iter().sum::<f64>() - 2.0;
    // The sum of four uniform numbers has the standard deviation √(1/3).
    let block = block(|i| (100.0 + 0.01 * 3_f64.sqrt() * normal_like(i)) as f32);
    let answers = accumulated(std::slice::from_ref(&block));
    for channel in 0..3 {
        let expected = moments(&block, channel).variance().unwrap();
        let found = answers.f64(3 + channel).next().unwrap() / 255.0;
        // E[x²] − E[x]², all of it in f32.
        let sums = block.iter().map(|rgb| rgb[channel]);
        let (sum, squares) = sums.fold((0.0_f32, 0.0_f32), |(s, q), x| (s + x, q + x * x));
        let mean = sum / 256.0;
        let textbook = f64::from(squares / 256.0 - mean * mean);
        survive(
            context(),
            Measured {
                entry: "A3",
                case: &format!(
                    "256 values around 100 with the standard deviation 0.01, channel {channel}"
                ),
                figure: "relative error of the variance",
                bound: 1e-2,
                textbook: "E[x²] − E[x]²",
                naive: (textbook / expected - 1.0).abs(),
                ours: (found / expected - 1.0).abs(),
            },
        );
    }
}

/// HARD CASES A4: a sample that is no number is dropped and entered, its neighbours stay.
#[test]
fn samples_that_are_no_numbers_are_dropped_and_entered() {
    let good = |stream: u32| block(move |i| numbers(i, stream, 32)[1] as f32);
    let with = |bad: &[(usize, usize, f32)]| {
        let mut block = good(bad.len() as u32);
        for &(position, channel, value) in bad {
            block[position][channel] = value;
        }
        block
    };
    let (nan, inf) = (f32::NAN, f32::INFINITY);
    // A negative NaN and a signalling one.
    let (negative, signalling) = (f32::from_bits(0xffc0_0001), f32::from_bits(0x7f80_0001));
    let none = 0xffff;
    let cases = [
        (with(&[(0, 0, nan)]), [255, 1, 0, none]),
        (with(&[(255, 2, inf)]), [255, 1, none, 255]),
        (with(&[(7, 1, -inf), (3, 0, inf)]), [254, 2, none, 3]),
        (
            with(&[(9, 0, negative), (5, 2, signalling), (200, 1, inf)]),
            [253, 3, 5, 200],
        ),
        // Both in one sample: it is entered as NaN.
        (with(&[(40, 0, inf), (40, 1, nan)]), [255, 1, 40, none]),
        (block(|_| nan), [0, 256, 0, none]),
        // However large, a finite sample is one.
        (with(&[(12, 0, f32::MAX * 1e-8)]), [256, 0, none, none]),
    ];
    let (blocks, expected): (Vec<_>, Vec<_>) = cases.into_iter().unzip();
    let answers = accumulated(&blocks);
    for (item, (block, expected)) in blocks.iter().zip(expected).enumerate() {
        let found = [6, 7, 8, 9].map(|word| answers.u32(word).nth(item).unwrap());
        assert_eq!(
            found, expected,
            "block {item}: samples, dropped, first NaN, first infinite"
        );
        if item < 6 {
            assert_moments(&answers, item, block, &format!("block {item}"));
        }
    }
    let finite = |mean: f64| mean.is_finite();
    let running_mean = |block: &Vec<[f32; 3]>| {
        let terms = (1_u16..).zip(block);
        terms.fold(0.0_f32, |m, (n, rgb)| m + (rgb[0] - m) / f32::from(n))
    };
    let poisoned = blocks.iter().map(running_mean);
    let poisoned = poisoned.filter(|m| !finite(f64::from(*m))).count();
    survive(
        context(),
        Measured {
            entry: "A4",
            case: "seven pixels, in six of them samples that are NaN or infinite",
            figure: "pixels that are not finite",
            bound: 0.0,
            textbook: "running mean",
            naive: poisoned as f64,
            ours: answers.f64(0).filter(|m| !finite(*m)).count() as f64,
        },
    );
}
