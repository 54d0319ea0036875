//! `shaders/core/rng.wesl`.

use crate::support::hard_cases::{Measured, survive};
use crate::support::random::Random;
use crate::support::shader::{Answers, Function, call, draw};
use crate::support::statistics::{accept, correlation_p_value, reject, reject_broken};
use crate::support::{context, histogram};
use direkt::low_level::reference::BrokenTwin;
use direkt::low_level::reference::core::rng::{pcg4d, to_unit, to_unit_2d};
use direkt::low_level::stats::z_test::z_test;
use glam::DVec2;

const PCG4D: Function<'_> = Function {
    imports: "import package::core::rng::pcg4d;",
    body: "let v = pcg4d(vec4u(in_u32(0u), in_u32(1u), in_u32(2u), in_u32(3u)));
           out_u32(0u, v.x);
           out_u32(1u, v.y);
           out_u32(2u, v.z);
           out_u32(3u, v.w);",
    inputs: 4,
    outputs: 4,
    features: &[],
};

const WORDS: u32 = 1 << 20;

#[test]
fn hashes_are_bit_identical() {
    let mut random = Random::new(27);
    let mut inputs: Vec<[u32; 4]> = (0..100_000)
        .map(|_| std::array::from_fn(|_| random.word()))
        .collect();
    for edge in [0, 1, 0xffff, 0x1_0000, 0x8000_0000, u32::MAX] {
        inputs.push([edge; 4]);
        for i in 0..4 {
            let mut input = [0; 4];
            input[i] = edge;
            inputs.push(input);
        }
    }
    let answers = call(context(), &PCG4D, inputs.as_flattened());
    for word in 0..4 {
        for (input, got) in inputs.iter().zip(answers.u32(word)) {
            assert_eq!(got, pcg4d(*input)[word], "word {word} of {input:x?}");
        }
    }
}

/// HARD CASES S1: a random number is never 1, and is the twin's bit for bit.
#[test]
fn units_are_bit_identical_and_below_one() {
    let context = context();
    let function = Function {
        imports: "import package::core::rng::{to_unit, to_unit_2d};",
        body: "out_f32(0u, to_unit(in_u32(0u)));
               out_vec2f(1u, to_unit_2d(vec2u(in_u32(0u), in_u32(1u))));",
        inputs: 2,
        outputs: 3,
        features: &[],
    };
    let mut random = Random::new(28);
    let edges = [
        0,
        0xff,
        0x100,
        0x7fff_ffff,
        0x8000_0000,
        0xffff_ff00,
        0xffff_ff80,
        0xffff_ffff,
    ];
    let mut inputs: Vec<[u32; 2]> = edges.iter().map(|&x| [x, !x]).collect();
    inputs.extend((0..100_000).map(|_| [random.word(), random.word()]));
    let answers = call(context, &function, inputs.as_flattened());
    for (&[x, y], (one, two)) in inputs.iter().zip(answers.f64(0).zip(answers.vec2(1))) {
        assert_eq!(one, to_unit(x), "{}: {x:#x}", context.adapter.name);
        assert_eq!(two, to_unit_2d(x, y));
        assert!((0.0..1.0).contains(&one) && two.max_element() < 1.0);
    }
}

/// HARD CASES S1: f32(x)·2⁻³² rounds the largest words to 1.
#[test]
fn the_largest_words_are_below_one() {
    let context = context();
    let function = Function {
        imports: "import package::core::rng::to_unit;",
        body: "out_f32(0u, to_unit(in_u32(0u)));
               out_f32(1u, f32(in_u32(0u)) * 2.3283064365386963e-10);",
        inputs: 1,
        outputs: 2,
        features: &[],
    };
    let inputs: Vec<u32> = (0xffff_ff00..=0xffff_ffff).collect();
    let answers = call(context, &function, &inputs);
    let ones = |word| answers.f64(word).filter(|&x| x >= 1.0).count() as f64;
    survive(
        context,
        Measured {
            entry: "S1",
            case: "the 256 largest words",
            figure: "numbers that are 1",
            bound: 0.0,
            textbook: "the word over 2³²",
            naive: ones(1),
            ours: ones(0),
        },
    );
}

/// The first word of consecutive counters in each of the four places, as numbers in [0, 1).
fn consecutive(place: usize) -> Answers {
    let mut arguments = ["29u"; 4];
    arguments[place] = "item";
    let body = format!(
        "let v = pcg4d(vec4u({}));
         out_u32(0u, v.x);
         out_u32(1u, v.y);
         out_u32(2u, v.z);
         out_u32(3u, v.w);",
        arguments.join(", ")
    );
    let function = Function {
        body: &body,
        inputs: 0,
        ..PCG4D
    };
    draw(context(), &function, WORDS as usize)
}

/// A linear congruential generator that is seeded by the counter: HARD CASES A6 finds a correlation
/// of 0.9977.
fn seeded_by_counter(counter: u32) -> u32 {
    counter.wrapping_mul(1_664_525).wrapping_add(1_013_904_223)
}

/// Bits 8 to 31, those that `to_unit` takes. Below, pcg4d is weaker: with a counter in its third or
/// fourth place, bit 0 of a word can be 1 three times out of four.
#[test]
fn every_bit_of_a_number_is_balanced() {
    // Half the words have the bit: variance ¼ each.
    let p_value = |share: f64| z_test(share, 0.5, 0.25 / f64::from(WORDS), 0.0).p_value;
    for place in 0..4 {
        let answers = consecutive(place);
        for word in 0..4 {
            let mut counts = [0_u32; 32];
            for w in answers.u32(word) {
                for (bit, count) in counts.iter_mut().enumerate() {
                    *count += (w >> bit) & 1;
                }
            }
            for (bit, count) in counts.into_iter().enumerate().skip(8) {
                let share = f64::from(count) / f64::from(WORDS);
                let what = format!("pcg4d, counter {place}, word {word}, bit {bit}, seed 29");
                accept(p_value(share), &what);
                reject(p_value(1.02 * share), &format!("{what}, 2 % too often"));
            }
        }
    }
}

#[test]
fn consecutive_hashes_do_not_correlate() {
    for place in 0..4 {
        let answers = consecutive(place);
        let words: Vec<Vec<f64>> = (0..4)
            .map(|w| answers.u32(w).map(to_unit).collect())
            .collect();
        for word in 0..4 {
            for lag in [1, 2, 64, 1024] {
                let p = correlation_p_value(&words[word], &words[word][lag..]);
                accept(
                    p,
                    &format!("pcg4d, counter {place}, word {word}, lag {lag}, seed 29"),
                );
            }
            for other in 0..word {
                let p = correlation_p_value(&words[word], &words[other]);
                accept(
                    p,
                    &format!("pcg4d, counter {place}, words {word} and {other}, seed 29"),
                );
            }
        }
    }
    let broken: Vec<f64> = (0..WORDS)
        .map(|i| to_unit(seeded_by_counter(i << 4)))
        .collect();
    for lag in [1, 2, 64, 1024] {
        let p = correlation_p_value(&broken, &broken[lag..]);
        reject(p, &format!("a generator seeded by its counter, lag {lag}"));
    }
}

#[test]
fn pairs_of_hashes_are_uniform() {
    for place in 0..4 {
        let answers = consecutive(place);
        for (a, b) in [(0, 1), (1, 2), (2, 3), (3, 0)] {
            let units = |w: usize| answers.u32(w).map(to_unit);
            let pairs: Vec<DVec2> = units(a).zip(units(b)).map(DVec2::from).collect();
            let test =
                |density: f64| histogram::p_value(&pairs, DVec2::ZERO, DVec2::ONE, |_| density);
            let what = format!("pcg4d, counter {place}, words {a} and {b}, seed 29");
            accept(test(1.0), &what);
            reject_broken(&what, |twin| match twin {
                BrokenTwin::PdfScaled => Some(test(1.02)),
                // Uniform numbers have no measure but their own, and nothing here knows of lights
                // or surfaces.
                BrokenTwin::WrongMeasure
                | BrokenTwin::SwappedSinCos
                | BrokenTwin::LightLeftOut
                | BrokenTwin::MisWeights
                | BrokenTwin::RaysForgotten
                | BrokenTwin::OpaqueShadows
                | BrokenTwin::ExtraCosine => None,
            });
        }
    }
}
