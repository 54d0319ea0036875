//! `shaders/light/alias_table.wesl`.

use crate::support::hard_cases::{Measured, survive};
use crate::support::random::Random;
use crate::support::shader::{Function, call, draw};
use crate::support::{context, statistics};
use direkt::low_level::reference::BrokenTwin;
use direkt::low_level::reference::light::alias_table::{alias_choice, alias_entry};
use direkt::low_level::stats::chi2::{Totals, chi2_test};
use direkt::scene::alias_table::AliasTable;

/// Flat, uneven, with indices of weight zero, and of sizes at which ⌊u·n/2³²⌋ is hard.
fn tables() -> Vec<Vec<f64>> {
    let mut random = Random::new(6);
    let mut uneven = |n: usize| -> Vec<f64> {
        let weight = |_| random.magnitude(1e-3, 1e3) - 0.01;
        (0..n).map(weight).map(|w| w.max(0.0)).collect()
    };
    let mut tables = vec![
        vec![3.0],
        vec![1.0; 7],
        // HARD CASES S2.
        vec![0.0, 1.0, 0.0, 1e30, 1e-30, 0.0],
        vec![0.0, 0.0, 0.0, 1.0],
        vec![1.0; 1 << 16],
    ];
    tables.extend([2, 3, 100, 65_535, 65_537].map(&mut uneven));
    tables
}

fn bits(p: f64) -> u32 {
    (p as f32).to_bits()
}

/// What the host uploads per entry: threshold, alias, probability of the index itself and of the
/// alias.
fn entry_words(table: &AliasTable, index: u32) -> [u32; 4] {
    let entry = table.entries[index as usize];
    let p = |i: u32| bits(table.probability[i as usize]);
    [entry.threshold, entry.alias, p(index), p(entry.alias)]
}

#[test]
fn alias_choices_are_the_hosts_bit_for_bit() {
    let context = context();
    let function = Function {
        imports: "import package::light::alias_table::{alias_choice, alias_entry};",
        body: "let entry = alias_entry(in_u32(0u), in_u32(1u));
               let words = vec4u(in_u32(2u), in_u32(3u), in_u32(4u), in_u32(5u));
               let choice = alias_choice(in_u32(0u), in_u32(1u), entry, words);
               out_u32(0u, entry);
               out_u32(1u, choice.index);
               out_f32(2u, choice.probability.value);",
        inputs: 6,
        outputs: 3,
        features: &[],
    };
    let mut random = Random::new(7);
    let edges = [0, 1, 0x7fff_ffff, 0x8000_0000, 0xffff_ff80, 0xffff_ffff];
    for weights in tables() {
        let table = AliasTable::new(&weights).unwrap();
        let count = weights.len() as u32;
        let words: Vec<u32> = edges
            .into_iter()
            .chain((0..20_000).map(|_| random.word()))
            .collect();
        let inputs: Vec<u32> = words
            .iter()
            .flat_map(|&u| {
                let [a, b, c, d] = entry_words(&table, alias_entry(u, count));
                [u, count, a, b, c, d]
            })
            .collect();
        let answers = call(context, &function, &inputs);
        let chosen = answers.u32(1).zip(answers.u32(2));
        for ((u, entry), (index, probability)) in words.iter().zip(answers.u32(0)).zip(chosen) {
            let what = format!("{}: {u:#x} among {count}", context.adapter.name);
            let expected = alias_choice(*u, &table);
            assert_eq!(entry, alias_entry(*u, count), "{what}");
            assert_eq!(index, expected.index, "{what}");
            assert_eq!(index, table.choose(*u), "{what}");
            assert_eq!(probability, bits(expected.probability.0), "{what}");
            assert!(weights[index as usize] > 0.0, "{what} chose {index}");
        }
    }
}

#[test]
fn alias_choices_match_pmf() {
    let context = context();
    let n = 1 << 20;
    // The heaviest, which the broken twin leaves out, is among other positive weights.
    for weights in [
        vec![1.0, 0.0, 5.0, 0.25, 0.0, 2.0, 1e-9],
        vec![0.0, 1.0, 1.0, 1.0, 0.0],
    ] {
        let table = AliasTable::new(&weights).unwrap();
        let count = weights.len();
        let entries: Vec<String> = (0..count as u32)
            .map(|i| {
                let [a, b, c, d] = entry_words(&table, i);
                format!("vec4u({a}u, {b}u, {c}u, {d}u)")
            })
            .collect();
        let imports = format!(
            "import package::light::alias_table::{{alias_choice, alias_entry}};
             import package::core::rng::pcg4d;
             var<private> entries: array<vec4u, {count}> = array<vec4u, {count}>({});",
            entries.join(", ")
        );
        let body = format!(
            "let u = pcg4d(vec4u(item, 13u, 14u, 15u)).x;
             let entry = alias_entry(u, {count}u);
             out_u32(0u, alias_choice(u, {count}u, entry, entries[entry]).index);"
        );
        let function = Function {
            imports: &imports,
            body: &body,
            inputs: 0,
            outputs: 1,
            features: &[],
        };
        let mut observed = vec![0; count];
        for index in draw(context, &function, n).u32(0) {
            observed[index as usize] += 1;
        }
        let sum: f64 = weights.iter().sum();
        let pmf: Vec<f64> = weights.iter().map(|w| w / sum).collect();
        for (p, realised) in pmf.iter().zip(&table.probability) {
            // Each entry's words are rounded to one: below 2⁻³² per entry.
            assert!((p - realised).abs() <= count as f64 * (-32_f64).exp2());
        }
        let test = |pmf: &dyn Fn(usize) -> f64| {
            let expected: Vec<f64> = (0..count).map(|i| n as f64 * pmf(i)).collect();
            let result = chi2_test(&observed, &expected, Totals::Free);
            result.expect("the counts are testable").p_value
        };
        let what = format!(
            "alias_choice, seed 15, {weights:?}, {}",
            context.adapter.name
        );
        statistics::accept(test(&|i| pmf[i]), &what);
        let heaviest = (0..count).max_by(|&a, &b| pmf[a].total_cmp(&pmf[b]));
        statistics::reject_broken(&what, |twin| match twin {
            BrokenTwin::PdfScaled => Some(test(&|i| 1.02 * pmf[i])),
            BrokenTwin::LightLeftOut => Some(test(&|i| {
                if Some(i) == heaviest { 0.0 } else { pmf[i] }
            })),
            // A choice has no measure, and the others are about what is done with the light.
            BrokenTwin::WrongMeasure
            | BrokenTwin::SwappedSinCos
            | BrokenTwin::MisWeights
            | BrokenTwin::RaysForgotten
            | BrokenTwin::OpaqueShadows
            | BrokenTwin::ExtraCosine => None,
        });
    }
}

/// Prefix sums in f32, over their last.
fn prefix_sums(weights: &[f64]) -> Vec<f32> {
    let mut sum = 0.0_f32;
    let mut sums: Vec<f32> = weights
        .iter()
        .map(|&w| {
            sum += w as f32;
            sum
        })
        .collect();
    sums.iter_mut().for_each(|s| *s /= sum);
    sums
}

/// HARD CASES S2: indices of weight zero over 2²⁴ words, 16 per invocation. The textbook's index is
/// the first whose sum is not below the number.
#[test]
fn weights_of_zero_are_never_chosen() {
    let context = context();
    let weights = [0.0, 1.0, 0.0, 1e30, 1e-30, 0.0];
    let table = AliasTable::new(&weights).unwrap();
    let entries: Vec<String> = (0..6)
        .map(|i| {
            format!(
                "vec4u{:?}",
                <(u32, u32, u32, u32)>::from(entry_words(&table, i))
            )
        })
        .map(|e| e.replace(',', "u,").replace(')', "u)"))
        .collect();
    let sums: Vec<String> = prefix_sums(&weights)
        .iter()
        .map(|s| format!("{s:?}"))
        .collect();
    let imports = format!(
        "import package::light::alias_table::{{alias_choice, alias_entry}};
         var<private> entries: array<vec4u, 6> = array<vec4u, 6>({});
         var<private> sums: array<f32, 6> = array<f32, 6>({});
         fn is_zero(i: u32) -> u32 {{
             return select(0u, 1u, i == 0u || i == 2u || i == 5u);
         }}",
        entries.join(", "),
        sums.join(", "),
    );
    let function = Function {
        imports: &imports,
        body: "var zeros = vec2u(0u);
               for (var k = 0u; k < 16u; k++) {
                   let u = (16u * item + k) << 8u;
                   let entry = alias_entry(u, 6u);
                   var i = 0u;
                   while i < 5u && sums[i] < f32(u >> 8u) * 5.9604644775390625e-8 {
                       i += 1u;
                   }
                   zeros += vec2u(is_zero(alias_choice(u, 6u, entry, entries[entry]).index), is_zero(i));
               }
               out_u32(0u, zeros.x);
               out_u32(1u, zeros.y);",
        inputs: 0,
        outputs: 2,
        features: &[],
    };
    let answers = draw(context, &function, 1 << 20);
    let zeros = |word| answers.u32(word).map(f64::from).sum();
    survive(
        context,
        Measured {
            entry: "S2",
            case: "weights 0, 1, 0, 10³⁰, 10⁻³⁰, 0, over 2²⁴ numbers",
            figure: "choices of a weight of zero",
            bound: 0.0,
            textbook: "search of prefix sums",
            naive: zeros(1),
            ours: zeros(0),
        },
    );
}

/// HARD CASES S2: what no number draws is missing from an image.
#[test]
fn every_positive_weight_is_chosen() {
    let context = context();
    let decades: Vec<f64> = (-15..=15).map(|e| 10_f64.powi(e)).collect();
    let sun = [vec![1e8], vec![1.0; 1 << 20]].concat();
    for (weights, case) in [
        (decades, "weights of 10⁻¹⁵ to 10¹⁵"),
        (sun, "a texel of 10⁸ and 2²⁰ of 1"),
    ] {
        // A number of 24 bits falls between two sums.
        let steps = 24_f64.exp2();
        let first = |sum: f32| (f64::from(sum) * steps).ceil();
        let sums = prefix_sums(&weights);
        let none = std::iter::once(0.0).chain(sums.iter().copied()).zip(&sums);
        let none = none.filter(|&(from, &to)| first(from) >= first(to)).count();
        let table = AliasTable::new(&weights).unwrap();
        survive(
            context,
            Measured {
                entry: "S2",
                case,
                figure: "weights that no random number chooses",
                bound: 0.0,
                textbook: "prefix sums in f32",
                naive: none as f64,
                ours: table.probability.iter().filter(|&&p| p <= 0.0).count() as f64,
            },
        );
    }
}
