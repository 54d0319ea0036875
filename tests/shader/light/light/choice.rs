//! Which light is chosen, and how often.

use super::IMPORTS;
use crate::support::every_kind::{constant_environment, every_kind};
use crate::support::shader::{Function, call_in};
use crate::support::{context, floor_pixel, point_light, prepared_for, statistics};
use direkt::low_level::prepare::Prepared;
use direkt::low_level::reference::BrokenTwin;
use direkt::low_level::reference::broken::BROKEN_TWINS;
use direkt::low_level::reference::light::light::{choose_light, samples_of_light};
use direkt::low_level::reference::scene::fetch::World;
use direkt::low_level::stats::chi2::{Totals, chi2_test};
use direkt::scene::{LightSelection, ShadowRays, Strategy};
use glam::DVec3;

/// Lights that are chosen from: all kinds, or two of powers 1 : 10⁶.
fn choices() -> Vec<(String, Prepared)> {
    let mut two = floor_pixel();
    two.lights = vec![
        point_light(DVec3::new(0.0, 0.0, 1.0), 1e-3),
        point_light(DVec3::new(1.0, 0.0, 1.0), 1e3),
    ];
    let scenes = [
        ("all kinds", every_kind(constant_environment())),
        ("1 : 1e6", two),
    ];
    let mut out = Vec::new();
    for (name, scene) in scenes {
        for selection in [LightSelection::Uniform, LightSelection::Power] {
            let prepared = prepared_for(scene.clone(), Strategy::MisPower, selection);
            out.push((format!("{name}, {selection}"), prepared));
        }
    }
    out
}

#[test]
fn lights_are_chosen_as_by_the_twin() {
    let context = context();
    let function = Function {
        imports: IMPORTS,
        body: "let c = choose_light(in_u32(0u)); out_u32(0u, c.index); out_f32(1u, c.expected_samples.value);",
        inputs: 1,
        outputs: 2,
        features: &[],
    };
    let ends = [0, 1, u32::MAX, u32::MAX - 1, 1 << 31, (1 << 31) - 1];
    let words: Vec<u32> = ends
        .into_iter()
        .chain((0..10_000).map(|i: u32| i.wrapping_mul(2_654_435_761)))
        .collect();
    for (name, prepared) in choices() {
        let world = World::new(&prepared);
        let answers = call_in(context, &prepared, &function, &words, words.len());
        for (word, (index, p)) in words.iter().zip(answers.u32(0).zip(answers.f64(1))) {
            let expected = choose_light(&world, *word).unwrap();
            assert_eq!(index, expected.index, "{name}: word {word}");
            assert_eq!(
                p as f32, expected.probability.0 as f32,
                "{name}: word {word}"
            );
        }
    }
}

/// With several shadow rays what stands for a light's probability is how many of them it gets in
/// the mean, whether it is chosen or has its own.
#[test]
fn several_rays_multiply_the_density() {
    let context = context();
    let count = every_kind(constant_environment()).lights.len() + 6;
    for (selection, body) in [
        (
            LightSelection::Power,
            "let c = choose_light(item * 429496729u); out_u32(0u, c.index); out_f32(1u, c.expected_samples.value);",
        ),
        (
            LightSelection::All,
            "out_u32(0u, item); out_f32(1u, light_with_its_samples(item).expected_samples.value);",
        ),
    ] {
        for strategy in [Strategy::MisPower, Strategy::Bsdf] {
            let mut scene = every_kind(constant_environment());
            scene.render.estimator.shadow_rays = ShadowRays::Number(3);
            let prepared = prepared_for(scene, strategy, selection);
            assert_eq!(prepared.emitters.lights.len(), count);
            let world = World::new(&prepared);
            let function = Function {
                imports: &format!(
                    "{IMPORTS} import package::light::light::light_with_its_samples;"
                ),
                body,
                outputs: 2,
                ..Function::default()
            };
            let answers = call_in(context, &prepared, &function, &[], count);
            for (index, samples) in answers.u32(0).zip(answers.f64(1)) {
                let light = index as usize;
                let p = prepared.emitters.probability(light);
                let rays = match selection {
                    LightSelection::All => samples_of_light(&world, index, prepared.shadow_rays()),
                    _ => prepared.shadow_rays(),
                };
                let expected = rays as f32 * p as f32;
                assert_eq!(
                    samples as f32, expected,
                    "{selection}, {strategy}, light {light}"
                );
            }
        }
    }
}

/// 2²⁴ random words against the realised probabilities.
#[test]
fn lights_are_chosen_at_their_probability() {
    let context = context();
    for (seed, (name, prepared)) in (90..).zip(choices()) {
        let count = prepared.emitters.lights.len();
        let body = format!(
            "var chosen = array<u32, {count}>();
             for (var k = 0u; k < 16u; k += 1u) {{
                 let c = choose_light(pcg4d(vec4u(item, k, 44u, {seed}u)).x);
                 chosen[c.index] += 1u;
             }}
             for (var i = 0u; i < {count}u; i += 1u) {{ out_u32(i, chosen[i]); }}"
        );
        let function = Function {
            imports: IMPORTS,
            body: &body,
            inputs: 0,
            outputs: count,
            features: &[],
        };
        let answers = call_in(context, &prepared, &function, &[], 1 << 20);
        let counts: Vec<u64> = (0..count)
            .map(|i| answers.u32(i).map(u64::from).sum())
            .collect();
        let expected = |factor: f64| -> Vec<f64> {
            let p = |i| factor * prepared.emitters.probability(i) * f64::from(1 << 24);
            (0..count).map(p).collect()
        };
        let p_value = |counts: &[u64], factor: f64| {
            chi2_test(counts, &expected(factor), Totals::Free)
                .unwrap()
                .p_value
        };
        let what = format!(
            "choose_light, {name}, seed {seed}, {}",
            context.adapter.name
        );
        statistics::accept(p_value(&counts, 1.0), &what);
        for row in BROKEN_TWINS {
            let broken = match row.twin {
                BrokenTwin::PdfScaled => p_value(&counts, 1.02),
                BrokenTwin::LightLeftOut => {
                    let mut counts = counts.clone();
                    let most = (0..count).max_by(|a, b| {
                        let p = |i: &usize| prepared.emitters.probability(*i);
                        p(a).total_cmp(&p(b))
                    });
                    counts[most.unwrap()] = 0;
                    p_value(&counts, 1.0)
                }
                // A choice has no direction.
                BrokenTwin::WrongMeasure
                | BrokenTwin::SwappedSinCos
                | BrokenTwin::MisWeights
                | BrokenTwin::RaysForgotten
                | BrokenTwin::OpaqueShadows
                | BrokenTwin::ExtraCosine => continue,
            };
            statistics::reject(broken, &format!("{what}, {}", row.name));
        }
    }
}
