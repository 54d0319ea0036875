//! `shaders/core/sampler.wesl`.

mod stratifying;

use crate::support::context;
use crate::support::random::Random;
use crate::support::shader::{Function, call, draw};
use crate::support::statistics::{accept, correlation_p_value, reject};
use direkt::low_level::reference::core::rng::to_unit;
use direkt::low_level::reference::core::sampler::{
    GROUP_DIRECTION, GROUP_FILM, GROUP_LIGHT, GROUP_LIGHT_POINTS, GROUP_LIGHT_TREE, GROUP_OPACITY,
    GROUP_SPECULAR, SampleId, part_of_sample, random_group,
};

const GROUPS: [u32; 3] = [GROUP_FILM, GROUP_LIGHT, GROUP_DIRECTION];
const ALL_GROUPS: [u32; 5] = [
    GROUP_FILM,
    GROUP_LIGHT,
    GROUP_DIRECTION,
    GROUP_LIGHT_POINTS,
    GROUP_SPECULAR,
];

const RANDOM_GROUP: Function<'_> = Function {
    imports: "import package::core::sampler::{SampleId, random_group};",
    body:
        "let name = SampleId(in_u32(0u), vec2u(in_u32(1u), in_u32(2u)), in_u32(3u), 1u, vec2u(0u));
           let words = random_group(name, in_u32(4u));
           out_u32(0u, words.x);
           out_u32(1u, words.y);
           out_u32(2u, words.z);
           out_u32(3u, words.w);",
    inputs: 5,
    outputs: 4,
    features: &[],
};

fn input(id: SampleId, group: u32) -> [u32; 5] {
    [
        id.pixel,
        id.index as u32,
        (id.index >> 32) as u32,
        id.seed,
        group,
    ]
}

/// 64-bit indices: HARD CASES A6.
#[test]
fn random_groups_are_bit_identical() {
    let context = context();
    let mut random = Random::new(30);
    let edges = [
        0,
        1,
        u64::from(u32::MAX),
        1 << 32,
        (1 << 32) + 1,
        10_000_000_000,
        u64::MAX,
    ];
    let mut ids: Vec<SampleId> = edges
        .iter()
        .flat_map(|&index| {
            [0, 1, u32::MAX].map(|pixel| SampleId {
                pixel,
                index,
                seed: 31,
            })
        })
        .collect();
    ids.extend((0..30_000).map(|_| SampleId {
        pixel: random.word(),
        index: u64::from(random.word()) << 32 | u64::from(random.word()),
        seed: random.word(),
    }));
    let asked: Vec<(SampleId, u32)> = ids
        .iter()
        .flat_map(|&id| GROUPS.map(|group| (id, group)))
        .collect();
    let inputs: Vec<u32> = asked
        .iter()
        .flat_map(|&(id, group)| input(id, group))
        .collect();
    let answers = call(context, &RANDOM_GROUP, &inputs);
    for word in 0..4 {
        for (&(id, group), got) in asked.iter().zip(answers.u32(word)) {
            let expected = random_group(id, group)[word];
            assert_eq!(
                got, expected,
                "{}: group {group} of {id:?}",
                context.adapter.name
            );
        }
    }
}

#[test]
fn indices_advance_in_64_bits() {
    let context = context();
    let function = Function {
        imports: "import package::core::sampler::advance;",
        body: "let index = advance(vec2u(in_u32(0u), in_u32(1u)), in_u32(2u));
               out_u32(0u, index.x);
               out_u32(1u, index.y);",
        inputs: 3,
        outputs: 2,
        features: &[],
    };
    let mut random = Random::new(32);
    let edges = [
        0,
        1,
        255,
        0x7fff_ffff,
        0x8000_0000,
        u32::MAX - 255,
        u32::MAX,
    ];
    let mut cases: Vec<[u32; 3]> = Vec::new();
    for low in edges {
        for high in [0, 1, u32::MAX] {
            cases.extend(edges.map(|offset| [low, high, offset]));
        }
    }
    cases.extend((0..10_000).map(|_| std::array::from_fn(|_| random.word())));
    let answers = call(context, &function, cases.as_flattened());
    for (&[low, high, offset], got) in cases.iter().zip(answers.u32(0).zip(answers.u32(1))) {
        let index = u64::from(high) << 32 | u64::from(low);
        let sum = index.wrapping_add(u64::from(offset));
        assert_eq!(got, (sum as u32, (sum >> 32) as u32), "{index} + {offset}");
    }
}

/// Sample by sample, part by part, in 64 bits.
#[test]
fn parts_of_samples_follow_each_other() {
    let function = Function {
        imports: "import package::core::sampler::{SampleId, part_of_sample};",
        body: "let name = SampleId(in_u32(0u), vec2u(in_u32(1u), in_u32(2u)), 7u, 8u, vec2u(9u));
               let part = part_of_sample(name, in_u32(3u), in_u32(4u), vec2u(5u, 6u));
               out_u32(0u, part.pixel); out_u32(1u, part.index.x); out_u32(2u, part.index.y);
               out_u32(3u, part.seed); out_u32(4u, part.width);
               out_u32(5u, part.pattern.x); out_u32(6u, part.pattern.y);",
        inputs: 5,
        outputs: 7,
        features: &[],
    };
    let mut random = Random::new(67);
    let mut cases: Vec<[u32; 5]> = vec![[1, 0, 0, 0, 1], [2, u32::MAX, 0, 1023, 1024]];
    cases.extend((0..10_000).map(|_| {
        let parts = 1 + random.word() % 1024;
        let [pixel, low, high] = std::array::from_fn(|_| random.word());
        [pixel, low, high >> 12, random.word() % parts, parts]
    }));
    let answers = call(context(), &function, cases.as_flattened());
    let indices = answers.u32(1).zip(answers.u32(2));
    for (&[pixel, low, high, part, parts], (found_low, found_high)) in cases.iter().zip(indices) {
        let id = SampleId {
            pixel,
            index: u64::from(high) << 32 | u64::from(low),
            seed: 7,
        };
        let expected = id.index * u64::from(parts) + u64::from(part);
        assert_eq!(part_of_sample(id, part, parts).index, expected);
        let found = u64::from(found_high) << 32 | u64::from(found_low);
        assert_eq!(found, expected, "part {part} of {parts} of {id:?}");
    }
    for (word, expected) in [(3, 7), (4, 8), (5, 5), (6, 6)] {
        assert!(answers.u32(word).all(|w| w == expected), "word {word}");
    }
    assert!(answers.u32(0).eq(cases.iter().map(|c| c[0])));
}

#[test]
fn groups_have_the_twins_numbers() {
    let function = Function {
        imports: "import package::core::sampler::{
                      GROUP_DIRECTION, GROUP_FILM, GROUP_LIGHT, GROUP_LIGHT_POINTS, GROUP_SPECULAR};",
        body: "out_u32(0u, GROUP_FILM);
               out_u32(1u, GROUP_LIGHT);
               out_u32(2u, GROUP_DIRECTION);
               out_u32(3u, GROUP_LIGHT_POINTS);
               out_u32(4u, GROUP_SPECULAR);",
        inputs: 0,
        outputs: 5,
        features: &[],
    };
    let answers = draw(context(), &function, 1);
    let found = [0, 1, 2, 3, 4].map(|i| answers.u32(i).next());
    assert_eq!(found, ALL_GROUPS.map(Some));
}

/// Sample `item` of a render in its `group`, with `change` made to its id: four words.
fn samples(id: &str, group: u32) -> Vec<Vec<f64>> {
    let body = format!(
        "let words = random_group(SampleId({id}, 1u, vec2u(0u)), {group}u);
         out_u32(0u, words.x);
         out_u32(1u, words.y);
         out_u32(2u, words.z);
         out_u32(3u, words.w);"
    );
    let function = Function {
        body: &body,
        inputs: 0,
        ..RANDOM_GROUP
    };
    let answers = draw(context(), &function, 1 << 20);
    let word = |w| answers.u32(w).map(to_unit).collect();
    (0..4).map(word).collect()
}

/// Samples that differ by one in the pixel, the row, the sample (low and high word), the seed or
/// the group have nothing to do with one another. The items are 1024 pixels times 1024 samples.
#[test]
fn neighbouring_samples_do_not_correlate() {
    let base = "item % 1024u, vec2u(item / 1024u, 0u), 33u";
    let neighbours = [
        ("pixel", "item % 1024u + 1u, vec2u(item / 1024u, 0u), 33u"),
        (
            "row of 1920",
            "item % 1024u + 1920u, vec2u(item / 1024u, 0u), 33u",
        ),
        ("sample", "item % 1024u, vec2u(item / 1024u + 1u, 0u), 33u"),
        (
            "block of 256",
            "item % 1024u, vec2u(item / 1024u + 256u, 0u), 33u",
        ),
        (
            "sample 2^32 later",
            "item % 1024u, vec2u(item / 1024u, 1u), 33u",
        ),
        ("seed", "item % 1024u, vec2u(item / 1024u, 0u), 34u"),
    ];
    let groups = GROUPS.map(|group| samples(base, group));
    let pair = |what: &str, a: &[Vec<f64>], b: &[Vec<f64>]| {
        for (i, a) in a.iter().enumerate() {
            for (j, b) in b.iter().enumerate() {
                let what = format!("random_group, seed 33, next {what}, words {i} and {j}");
                accept(correlation_p_value(a, b), &what);
            }
        }
    };
    for (what, id) in neighbours {
        for group in GROUPS {
            pair(
                &format!("{what}, group {group}"),
                &groups[group as usize],
                &samples(id, group),
            );
        }
    }
    for (a, b) in [(0, 1), (0, 2), (1, 2)] {
        pair(&format!("group {a} and {b}"), &groups[a], &groups[b]);
    }
    // The word that chooses a way at a specular surface, and all others of the sample.
    for surface in 0..3 {
        let way = &samples(base, GROUP_SPECULAR + surface)[..1];
        for (group, words) in (0..).zip(&groups) {
            pair(&format!("surface {surface} and group {group}"), way, words);
        }
        for group in [GROUP_LIGHT_TREE, GROUP_OPACITY, GROUP_LIGHT_POINTS] {
            let what = format!("surface {surface} and group {group}");
            pair(&what, way, &samples(base, group));
        }
    }
    // Broken: the group is forgotten, so that it repeats the other's numbers; a hundredth of them
    // is enough.
    let forgotten = samples(base, GROUP_FILM);
    let hundredth: Vec<f64> = groups[1][0]
        .iter()
        .zip(&forgotten[0])
        .enumerate()
        .map(|(i, (a, b))| if i % 100 == 0 { *b } else { *a })
        .collect();
    let p = correlation_p_value(&groups[0][0], &hundredth);
    reject(
        p,
        "random_group, a hundredth of two groups' numbers the same",
    );
}
