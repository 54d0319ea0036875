//! The scenes of `scenes/tests/`: each states its exact value, and every strategy finds it.

use crate::support::{STRATEGIES, context, project, render, scene_as_it_is};
use direkt::low_level::render::{Check, Film, Pixel};
use direkt::scene::{Bsdf, Expect, ExpectedRadiance, Scene};

/// Every scene of `scenes/tests/`, by name.
pub fn test_scenes() -> Vec<(String, Scene)> {
    let mut names: Vec<_> = std::fs::read_dir(project("scenes/tests"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| name.ends_with(".toml"))
        .collect();
    names.sort();
    let load = |name: String| {
        (
            name.clone(),
            scene_as_it_is(&format!("scenes/tests/{name}")),
        )
    };
    names.into_iter().map(load).collect()
}

fn expected(scene: &Scene) -> &Expect {
    scene.expect.as_ref().expect("a table [expect]")
}

fn check(film: &Film, scene: &Scene) -> Check {
    Check::new(film, expected(scene)).unwrap()
}

#[test]
fn test_scenes_say_what_they_prove_and_what_they_expect() {
    let scenes = test_scenes();
    assert!(scenes.len() >= 80, "{} scenes", scenes.len());
    for (name, scene) in scenes {
        let text = std::fs::read_to_string(&scene.source).unwrap();
        assert!(text.starts_with("# Proves: "), "{name}");
        assert!(scene.expect.is_some(), "{name} has no [expect]");
        assert_eq!(scene.warnings, [""; 0], "{name}");
    }
}

/// The largest relative standard error of what is compared: the image's mean, or pixels, as far as
/// they are not 0. `None` where a channel of the mean must be 0.
fn relative_error(film: &Film, scene: &Scene) -> Option<f64> {
    if let ExpectedRadiance::Pixels(_) = expected(scene).radiance {
        let of_pixel = |p: &Pixel| -> Option<f64> {
            let variance = p.variance_of_mean()?;
            let lit = (0..3).filter(|&c| p.mean[c] > 0.0);
            Some(lit.fold(0.0, |worst: f64, c| {
                worst.max(variance[c].sqrt() / p.mean[c])
            }))
        };
        let pixels = film.pixels.iter().map(of_pixel);
        return pixels
            .into_iter()
            .try_fold(0.0, |worst: f64, e| Some(worst.max(e?)));
    }
    let (mean, error) = (film.mean(), film.standard_error_of_mean()?);
    let of_channel = |c: usize| (mean[c] > 0.0).then(|| error[c] / mean[c]);
    (0..3).try_fold(0.0, |worst: f64, c| Some(worst.max(of_channel(c)?)))
}

fn brighten(scene: &mut Scene, factor: f64) {
    for emission in scene.shapes.iter_mut().filter_map(|s| s.emission.as_mut()) {
        emission.radiance *= factor;
    }
    for light in &mut scene.lights {
        *light.strength_mut() *= factor;
    }
    for material in &mut scene.materials {
        if let Bsdf::Unlit { color } = &mut material.bsdf {
            *color *= factor;
        }
    }
    if let Some(environment) = &mut scene.environment {
        environment.scale *= factor;
    }
}

/// `expect` of lights 2 % dimmer, beside which the scene's are 2 % too bright.
fn dimmer(expect: &Expect) -> Expect {
    let radiance = match &expect.radiance {
        ExpectedRadiance::Mean(mean) => ExpectedRadiance::Mean(*mean / 1.02),
        ExpectedRadiance::Pixels(pixels) => {
            ExpectedRadiance::Pixels(pixels.iter().map(|p| *p / 1.02).collect())
        }
    };
    Expect {
        radiance,
        ..expect.clone()
    }
}

/// Every strategy finds the exact values, and not those of lights 2 % dimmer: the check must be
/// able to fail. It does wherever that, less twice what the value is uncertain by (it may be so
/// much too large, and is allowed so much), is nine of the image's standard errors, so that chance
/// may take 4.5 of them and as many remain, which is the case in two thirds of the renders (the
/// rest are mostly scenes that must be black, and BSDF sampling of small lights). Under the scene's
/// own strategy there are 2²⁰ samples and more, none of which may be dropped, and the kernel is
/// specialized for it; under the others the scenes share the kernels that load them.
#[test]
fn every_strategy_finds_the_exact_values_and_no_others() {
    let context = context();
    let mut wrong = Vec::new();
    let (mut renders, mut sharp, mut rejected) = (0, 0, 0);
    for (name, mut scene) in test_scenes() {
        let (own, spp) = (scene.render.estimator.strategy, scene.render.stop.spp);
        let dimmer = dimmer(expected(&scene));
        for strategy in STRATEGIES {
            scene.render.estimator.strategy = strategy;
            scene.render.estimator.specialize = strategy == own;
            scene.render.stop.spp = if strategy == own {
                spp.max((1 << 20) / scene.film.pixels() as u64)
            } else {
                spp
            };
            let film = render(context, scene.clone());
            let exact = check(&film, &scene);
            if !exact.passed {
                wrong.push(format!("{name}, {strategy}: {exact:?}"));
            }
            let passed = Check::new(&film, &dimmer).unwrap().passed;
            renders += 1;
            rejected += usize::from(!passed);
            let visible = 0.02 - 2.0 * dimmer.tolerance;
            if relative_error(&film, &scene).is_some_and(|error| error < visible / 9.0) {
                sharp += 1;
                if passed {
                    wrong.push(format!("{name}, {strategy}: 2 % too bright, and it passed"));
                }
            }
        }
    }
    let adapter = &context.adapter.name;
    assert!(wrong.is_empty(), "on {adapter}:\n{}", wrong.join("\n"));
    assert!(
        sharp >= 150 && rejected >= 160,
        "of {renders} renders {rejected} were rejected, {sharp} of them had to be"
    );
}

/// Lights that are 2 % brighter make an image that is 2 % brighter, whatever there is in the scene:
/// with the same random numbers but for f32's rounding, which may also let a few samples choose
/// another light.
#[test]
fn images_are_as_bright_as_their_lights() {
    let context = context();
    for (name, mut scene) in test_scenes() {
        scene.render.stop.spp = 16;
        // Of a specialized kernel the lights are part.
        scene.render.estimator.specialize = false;
        let mut brighter = scene.clone();
        brighten(&mut brighter, 1.02);
        let [mean, brighter] = [scene, brighter].map(|scene| render(context, scene).mean());
        for (x, y) in mean.into_iter().zip(brighter) {
            assert!((y - 1.02 * x).abs() <= 2e-4 * x, "{name}: {x}, then {y}");
        }
    }
}

/// Scenes that must be black prove something only if a leak would be seen.
#[test]
fn black_scenes_are_lit_but_for_what_hides_the_light() {
    for (name, scene) in test_scenes() {
        let ExpectedRadiance::Mean(mean) = expected(&scene).radiance else {
            continue;
        };
        let emits = scene.shapes.iter().any(|s| s.emission.is_some());
        assert!(
            mean.min_element() > 0.0 || emits || !scene.lights.is_empty(),
            "{name} has no light at all"
        );
    }
}
