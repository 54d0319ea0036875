//! Sums of many samples, their indices, and what becomes of the image: HARD CASES A1, A2, A5, A6.

use crate::support::context;
use crate::support::exr_file::radiance;
use crate::support::hard_cases::{Measured, survive};
use crate::support::random::numbers;
use crate::support::rounding::U;
use crate::support::shader::{Function, draw};
use direkt::low_level::gpu::Context;
use direkt::low_level::gpu::layout::{BLOCK_SAMPLES, PixelState};
use direkt::low_level::image::exr;
use direkt::low_level::reference::core::rng::to_unit;
use direkt::low_level::render::{Film, Pixel};
use direkt::scene::{FilmSize, Sampler};

/// Blocks of ten million samples.
const BLOCKS: usize = 10_000_000_usize.div_ceil(BLOCK_SAMPLES as usize);
const SEED: u32 = 91;

/// A pixel of [`BLOCKS`] blocks, whose sample `i` of block `item` the GPU makes by `value`.
fn pixel(context: &Context, value: &str) -> Pixel {
    let body = format!(
        "var state = fresh_state();
         for (var i = 0u; i < 256u; i++) {{
             accumulate(&state, vec3f({value}), i);
         }}
         out_vec3f(0u, state.mean); out_vec3f(3u, state.m2); out_u32(6u, state.samples);
         out_vec3f(7u, state.second_mean); out_u32(10u, state.second_samples);"
    );
    let function = Function {
        imports: "import package::kernel::accumulate::{accumulate, fresh_state};
                  import package::core::rng::{pcg4d, to_unit};",
        body: &body,
        inputs: 0,
        outputs: 11,
        features: &[],
    };
    let answers = draw(context, &function, BLOCKS);
    let parts = |i| answers.vec3(i).map(|v| v.as_vec3().to_array());
    let counts = answers.u32(6).zip(answers.u32(10));
    let mut pixel = Pixel::default();
    for (((mean, m2), second_mean), (samples, second_samples)) in
        parts(0).zip(parts(3)).zip(parts(7)).zip(counts)
    {
        pixel.merge(&PixelState {
            mean,
            samples,
            m2,
            second_mean,
            second_samples,
            ..PixelState::default()
        });
    }
    pixel
}

/// A running sum in f32, over the number of samples.
fn running_sum(values: impl Iterator<Item = f32>) -> f64 {
    let mut sum = (0.0_f32, 0_u32);
    for x in values {
        sum = (sum.0 + x, sum.1 + 1);
    }
    f64::from(sum.0) / f64::from(sum.1)
}

fn samples() -> impl Iterator<Item = (u32, u32)> {
    (0..BLOCKS as u32).flat_map(|block| (0..BLOCK_SAMPLES).map(move |i| (block, i)))
}

#[test]
fn ten_million_samples_keep_their_mean() {
    let context = context();
    let uniform = |(block, i)| numbers(block, i, SEED)[0] as f32;
    let exact = |values: &mut dyn Iterator<Item = f32>| {
        values.map(f64::from).sum::<f64>() / samples().count() as f64
    };
    let lone = |(block, i)| if (block, i) == (0, 0) { 1.0 } else { 1e-8 };
    type Sample<'a> = &'a dyn Fn((u32, u32)) -> f32;
    let cases: [(&str, &str, &str, &str, Sample<'_>); 3] = [
        (
            "A1",
            "0.1, 10⁷ times",
            "running sum in f32",
            "0.1",
            &|_| 0.1,
        ),
        (
            "A1",
            "10⁷ uniform numbers",
            "running sum in f32",
            "to_unit(pcg4d(vec4u(item, i, 0u, 91u)).x)",
            &uniform,
        ),
        (
            "A2",
            "1, then 10⁷ times 1e-8",
            "compensated sum as compilers that reassociate leave it",
            "select(1e-8, 1.0, item == 0u && i == 0u)",
            &lone,
        ),
    ];
    for (entry, case, textbook, value, sample) in cases {
        let mean = exact(&mut samples().map(sample));
        let off = |x: f64| (x / mean - 1.0).abs();
        let pixel = pixel(context, value);
        assert_eq!(pixel.samples, samples().count() as u64);
        survive(
            context,
            Measured {
                entry,
                case,
                figure: "relative error of the mean",
                bound: 1e-6,
                textbook,
                naive: off(running_sum(samples().map(sample))),
                ours: off(pixel.mean[0]),
            },
        );
    }
}

#[test]
fn a_million_survives_in_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let size = FilmSize {
        width: 1,
        height: 1,
    };
    let mut film = Film::new(size, Sampler::Independent);
    film.pixels[0].merge(&PixelState {
        mean: [1e6; 3],
        samples: 2,
        ..PixelState::default()
    });
    exr::write(&path, &film, &[], &[]).unwrap();
    let (_, read) = radiance(&path);
    let off = |x: f64| (x / 1e6 - 1.0).abs();
    survive(
        context(),
        Measured {
            entry: "A5",
            case: "a radiance of 10⁶ in an EXR",
            figure: "relative error",
            bound: U,
            textbook: "half floats",
            naive: off(::exr::prelude::f16::from_f64(1e6).to_f64()),
            ours: off(f64::from(read[0][0])),
        },
    );
}

/// First numbers of `count` samples that the GPU names by `id`.
fn first_numbers(context: &Context, id: &str, count: usize) -> Vec<u32> {
    let body = format!("out_u32(0u, random_group(SampleId({id}, 33u, 1u, vec2u(0u)), 0u).x);");
    let function = Function {
        imports: "import package::core::sampler::{SampleId, random_group};",
        body: &body,
        inputs: 0,
        outputs: 1,
        features: &[],
    };
    draw(context, &function, count).u32(0).collect()
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len() as f64;
    let mean = |x: &[f64]| x.iter().sum::<f64>() / n;
    let (mean_a, mean_b) = (mean(a), mean(b));
    let product = |a: &[f64], b: &[f64]| -> f64 {
        let terms = a.iter().zip(b);
        terms.map(|(a, b)| (a - mean_a) * (b - mean_b)).sum()
    };
    let square = |x: &[f64], mean: f64| x.iter().map(|x| (x - mean).powi(2)).sum::<f64>();
    product(a, b) / (square(a, mean_a) * square(b, mean_b)).sqrt()
}

#[test]
fn pixels_and_indices_have_numbers_of_their_own() {
    const COUNT: usize = 1 << 20;
    let context = context();
    let units = |words: &[u32]| -> Vec<f64> { words.iter().map(|&w| to_unit(w)).collect() };
    let ours = units(&first_numbers(context, "item, vec2u(0u)", COUNT + 1));
    // A generator x → 1664525·x + 1013904223 begun at the pixel's number.
    let lcg = |pixel: u32| pixel.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    let naive = units(&(0..=COUNT as u32).map(lcg).collect::<Vec<_>>());
    let of_neighbours = |x: &[f64]| correlation(&x[1..], &x[..COUNT]).abs();
    survive(
        context,
        Measured {
            entry: "A6",
            case: "first numbers of 2²⁰ neighbouring pixels",
            figure: "correlation",
            bound: 4.0 / (COUNT as f64).sqrt(),
            textbook: "linear congruential generator begun at the pixel's number",
            naive: of_neighbours(&naive),
            ours: of_neighbours(&ours),
        },
    );
    let [first, later] = ["0u, vec2u(item, 0u)", "0u, vec2u(item, 1u)"]
        .map(|id| first_numbers(context, id, 1 << 16));
    let equal = first.iter().zip(&later).filter(|(a, b)| a == b).count();
    survive(
        context,
        Measured {
            entry: "A6",
            case: "samples i and i + 2³² of a pixel, i below 2¹⁶",
            figure: "equal numbers",
            bound: 0.0,
            textbook: "indices of 32 bits",
            naive: first.len() as f64,
            ours: equal as f64,
        },
    );
}
