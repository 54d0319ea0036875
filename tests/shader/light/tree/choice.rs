//! Which light is chosen, with what probability, and how often.

use super::{IMPORTS, places, prepared, scene_of, scenes, tree, words};
use crate::support::shader::{Function, call_in};
use crate::support::{context, statistics};
use direkt::low_level::emitters::{Emitter, LightTree};
use direkt::low_level::reference::core::rng::pcg4d;
use direkt::low_level::reference::light::tree::{choose_tree_light, pdf_tree_light};
use direkt::low_level::stats::chi2::{Totals, chi2_test};
use glam::DVec3;

/// The same light from the same words, with the probability that the query tells of it; and the
/// query's answer for every light is the twin's, and sums to 1 or, where nothing is lit at the end
/// of the way, less.
#[test]
fn choice_and_query_are_the_twins_and_each_others() {
    let context = context();
    for (name, prepared) in scenes() {
        let tree = tree(&prepared);
        let function = Function {
            imports: IMPORTS,
            body: "let words = pcg4d(vec4u(item, 7u, 8u, 9u));
                   let c = choose_tree_light(words.x, words, in_vec3f(0u), in_vec3f(3u));
                   out_u32(0u, c.index); out_f32(1u, c.expected_samples.value);",
            inputs: 6,
            outputs: 2,
            features: &[],
        };
        let places = places(&prepared, 20_000, 6);
        let answers = call_in(context, &prepared, &function, &words(&places), places.len());
        let mut others = 0;
        for (i, (index, p)) in answers.u32(0).zip(answers.f64(1)).enumerate() {
            let (x, normal) = places[i];
            let words = pcg4d([i as u32, 7, 8, 9]);
            let Some(expected) = choose_tree_light(tree, words[0], words, x, normal).choice else {
                others += usize::from(p > 0.0);
                continue;
            };
            if index != expected.index {
                others += 1;
                continue;
            }
            let expected = expected.probability.0;
            assert!(
                (p - expected).abs() < 1e-3 * expected,
                "{name}, light {index} from {x}: {p} for {expected}"
            );
            if !tree.infinite.contains(&index) {
                let trail = tree.trails[index as usize];
                let asked = pdf_tree_light(tree, trail, x, normal).0;
                assert!((asked - expected).abs() < 1e-12 * expected);
            }
        }
        assert!(
            others <= places.len() / 1000,
            "{name}: {others} other choices"
        );
    }
}

/// On the GPU: the query for the light that was chosen gives what it was chosen with.
#[test]
fn the_query_gives_what_the_choice_gave() {
    let context = context();
    for (name, prepared) in scenes() {
        let function = Function {
            imports: &format!("{IMPORTS} import package::scene::bindings::lights;"),
            body: "let words = pcg4d(vec4u(item, 17u, 18u, 19u));
                   let x = in_vec3f(0u); let n = in_vec3f(3u);
                   let c = choose_tree_light(words.x, words, x, n);
                   let asked = samples_of_tree_light(bitcast<u32>(lights[4u * c.index + 3u].w), x, n);
                   out_u32(0u, c.index); out_f32(1u, c.expected_samples.value); out_f32(2u, asked.value);",
            inputs: 6,
            outputs: 3,
            features: &[],
        };
        let places = places(&prepared, 20_000, 8);
        let answers = call_in(context, &prepared, &function, &words(&places), places.len());
        let area = |index: u32| {
            matches!(
                prepared.emitters.lights[index as usize],
                Emitter::Area { .. }
            )
        };
        let mut asked_for = 0;
        for ((index, p), asked) in answers.u32(0).zip(answers.f64(1)).zip(answers.f64(2)) {
            if p > 0.0 && area(index) {
                asked_for += 1;
                let what = format!("{name}, light {index}: {asked} for {p}");
                assert!((p - asked).abs() <= 1e-6 * p, "{what}");
            }
        }
        assert!(asked_for > 0 || name == "1 : 1e6", "{name}");
    }
}

#[test]
fn probabilities_sum_to_one() {
    let mut whole = 0;
    for (name, prepared) in scenes() {
        let tree = tree(&prepared);
        for (x, normal) in places(&prepared, 300, 9) {
            let lights = 0..prepared.emitters.lights.len();
            let outside = tree.infinite.len() as f64 * tree.share();
            let inside = lights.filter(|i| !tree.infinite.contains(&(*i as u32)));
            let p = |i: usize| pdf_tree_light(tree, tree.trails[i], x, normal).0;
            let sum = outside + inside.map(p).sum::<f64>();
            // A node that may be lit can hold lights none of which is.
            assert!(sum < 1.0 + 1e-9, "{name}: {sum} at {x}");
            whole += usize::from((sum - 1.0).abs() < 1e-9);
        }
    }
    assert!(whole > 300, "{whole} of 900");
}

/// Choices at each place.
const DRAWN: u32 = 1 << 18;

/// 2¹⁸ choices each from several places, against the probabilities that the twin tells, and those
/// of twins with a mistake.
#[test]
fn lights_are_chosen_at_their_probability() {
    let context = context();
    let function = |count: usize, (x, n): (DVec3, DVec3), seed: u32| {
        format!(
            "var chosen = array<u32, {count}>();
             for (var k = 0u; k < 16u; k += 1u) {{
                 let words = pcg4d(vec4u(item, k, 45u, {seed}u));
                 let c = choose_tree_light(words.x, words, vec3f({:?}, {:?}, {:?}), vec3f({:?}, {:?}, {:?}));
                 if c.expected_samples.value > 0.0 {{ chosen[c.index] += 1u; }}
             }}
             for (var i = 0u; i < {count}u; i += 1u) {{ out_u32(i, chosen[i]); }}",
            x.x, x.y, x.z, n.x, n.y, n.z
        )
    };
    let prepared = prepared(scene_of(20, 3));
    let honest = tree(&prepared);
    let count = prepared.emitters.lights.len();
    let mut found = Vec::new();
    for (seed, place) in (120..).zip(places(&prepared, 6, 10)) {
        let body = function(count, place, seed);
        let function = Function {
            imports: IMPORTS,
            body: &body,
            inputs: 0,
            outputs: count,
            features: &[],
        };
        let answers = call_in(context, &prepared, &function, &[], DRAWN as usize / 16);
        let of_light = |i: usize| answers.u32(i).map(u64::from).sum::<u64>();
        let mut counts: Vec<u64> = (0..count).map(of_light).collect();
        // Ways that end in the dark are a cell of their own.
        counts.push(u64::from(DRAWN) - counts.iter().sum::<u64>());
        let p_value = |probabilities: &[f64]| {
            let expected: Vec<f64> = probabilities.iter().map(|p| p * f64::from(DRAWN)).collect();
            chi2_test(&counts, &expected, Totals::Free).unwrap().p_value
        };
        let what = format!("choose_tree_light, seed {seed}, {}", context.adapter.name);
        let right = probabilities(honest, count, place);
        statistics::accept(p_value(&right), &what);
        for (mistake, broken) in broken_trees(honest) {
            let wrong = probabilities(&broken, count, place);
            let differ = right.iter().zip(&wrong).map(|(p, q)| (p - q).abs());
            if differ.sum::<f64>() > 0.05 {
                statistics::reject(p_value(&wrong), &format!("{what}, {mistake}"));
                found.push(mistake);
            }
        }
    }
    for (mistake, _) in broken_trees(honest) {
        assert!(
            found.contains(&mistake),
            "{mistake} makes no difference anywhere"
        );
    }
}

/// The probability of every light at a place, and of none.
fn probabilities(tree: &LightTree, count: usize, (x, normal): (DVec3, DVec3)) -> Vec<f64> {
    let of_light = |i: usize| {
        if tree.infinite.contains(&(i as u32)) {
            tree.share()
        } else {
            pdf_tree_light(tree, tree.trails[i], x, normal).0
        }
    };
    let mut all: Vec<f64> = (0..count).map(of_light).collect();
    all.push((1.0 - all.iter().sum::<f64>()).max(0.0));
    all
}

/// Trees with one mistake each.
fn broken_trees(honest: &LightTree) -> Vec<(&'static str, LightTree)> {
    let mut sides = honest.clone();
    for trail in &mut sides.trails {
        *trail ^= 1;
    }
    let mut cones = honest.clone();
    // The axes of all cones turned, as by an octahedral map that swaps its coordinates and forgets
    // a sign.
    for node in &mut cones.nodes {
        for child in &mut node[..2] {
            child[2] = !child[2].rotate_left(16);
        }
    }
    let mut intensities = honest.clone();
    for node in &mut intensities.nodes {
        node[2].swap(0, 1);
    }
    vec![
        ("the first child taken for the second", sides),
        ("axes turned", cones),
        ("intensities of the children swapped", intensities),
    ]
}
