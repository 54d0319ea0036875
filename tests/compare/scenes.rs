//! Every scene, and every strategy on scenes that differ in how they are lit.

use super::compared;
use crate::hard_cases::extreme_scenes::room;
use crate::support::{
    KINDS_OF_STRATEGIES, STRATEGIES, emitter, own_scenes, scene, scenes_of_lights, shared,
    statistics,
};
use direkt::scene::load::{LoadOptions, load};
use direkt::scene::{Geometry, LightSelection, Sampler, ShadowPattern, ShadowRays, Strategy};
use direkt_instruments::compare::Comparison;
use glam::DVec3;

/// What rests on chance is counted in the suite's family: the worst pixel by Bonferroni, and each
/// channel's mean.
fn assert_agrees(comparison: &Comparison, what: &str) {
    let c = comparison;
    assert!(c.per_sample.agrees(), "{what}: {:?}", c.per_sample);
    assert!(c.accumulation.agrees(), "{what}: {:?}", c.accumulation);
    let worst = c.per_pixel.worst.expect("an image has pixels");
    let p = (worst.p_value * c.per_pixel.tests as f64).min(1.0);
    statistics::accept(p, &format!("{what}, worst pixel {worst:?}"));
    for channel in &c.whole_image.channels {
        statistics::accept(channel.p_value, &format!("{what}, {channel:?}"));
    }
    assert!(c.agrees(), "{what}");
}

#[test]
fn gpu_and_reference_agree_on_every_light_under_every_strategy() {
    for (name, scene) in scenes_of_lights() {
        for strategy in STRATEGIES {
            let comparison = compared(&scene, strategy, (1 << 12, 64), None);
            assert_agrees(&comparison, &format!("{name}, {strategy}"));
        }
    }
}

/// What does not differ in its lights, under one strategy of each kind.
#[test]
fn gpu_and_reference_agree_on_scenes_of_effects() {
    let of_lights: Vec<String> = scenes_of_lights()
        .into_iter()
        .map(|(name, _)| name)
        .collect();
    let others = own_scenes().into_iter();
    for (name, scene) in others.filter(|(name, _)| !of_lights.contains(name)) {
        for strategy in KINDS_OF_STRATEGIES {
            let comparison = compared(&scene, strategy, (1 << 12, 64), None);
            assert_agrees(&comparison, &format!("{name}, {strategy}"));
        }
    }
}

/// Every pattern of shadow rays, with rays to chosen lights and to every light, under every
/// sampler.
#[test]
fn gpu_and_reference_agree_with_several_shadow_rays() {
    use LightSelection::{All, Power, Uniform};
    use ShadowPattern::{Center, Grid, Random, Stratified};
    for (name, scene) in scenes_of_lights() {
        for (strategy, rays, pattern, selection, sampler) in [
            (Strategy::MisPower, 1, Random, All, Sampler::Independent),
            (Strategy::MisBalance, 3, Random, Power, Sampler::Stratified),
            (
                Strategy::LightSolidAngle,
                3,
                Random,
                All,
                Sampler::BlueNoise,
            ),
            (Strategy::MisPower, 4, Stratified, Uniform, Sampler::Sobol),
            (Strategy::MisPower, 2, Stratified, All, Sampler::BlueNoise),
            (Strategy::MisPower, 4, Grid, Power, Sampler::Independent),
            (
                Strategy::LightProjectedSolidAngle,
                3,
                Grid,
                All,
                Sampler::Sobol,
            ),
            (Strategy::MisPower, 4, Center, Uniform, Sampler::Stratified),
        ] {
            let mut scene = scene.clone();
            scene.render.estimator.light_selection = selection;
            scene.render.estimator.shadow_rays = ShadowRays::Number(rays);
            scene.render.estimator.shadow_pattern = pattern;
            scene.render.estimator.sampler = sampler;
            let comparison = compared(&scene, strategy, (1 << 11, 64), None);
            let what = format!("{name}, {strategy}, {rays} {pattern}, {selection}, {sampler}");
            assert_agrees(&comparison, &what);
        }
    }
}

/// Lights chosen by a tree, with one ray and with several.
#[test]
fn gpu_and_reference_agree_with_a_light_tree() {
    use ShadowPattern::{Random, Stratified};
    for (name, scene) in scenes_of_lights() {
        for (strategy, rays, pattern, sampler) in [
            (Strategy::MisPower, 1, Random, Sampler::Sobol),
            (Strategy::MisBalance, 4, Stratified, Sampler::BlueNoise),
            (Strategy::LightArea, 3, Random, Sampler::Independent),
        ] {
            let mut scene = scene.clone();
            scene.render.estimator.light_selection = LightSelection::Tree;
            scene.render.estimator.shadow_rays = ShadowRays::Number(rays);
            scene.render.estimator.shadow_pattern = pattern;
            scene.render.estimator.sampler = sampler;
            let comparison = compared(&scene, strategy, (1 << 11, 64), None);
            let what = format!("{name}, light tree, {strategy}, {rays} {pattern}, {sampler}");
            assert_agrees(&comparison, &what);
        }
    }
}

/// A floor of 2·10⁸ under a lamp of side 2, and a ball 10⁸ away that shines: the reference has no
/// f32 to lose.
#[test]
fn gpu_and_reference_agree_on_an_extreme_scene() {
    let mut scene = room(1e8);
    let ball = Geometry::Sphere {
        center: DVec3::new(5e7, 5e7, 1e8),
        radius: 2e7,
    };
    scene.shapes.push(emitter(ball, 3.0, false));
    let comparison = compared(&scene, Strategy::MisPower, (1 << 10, 64), None);
    assert_agrees(&comparison, "an extreme scene");
}

#[test]
fn gpu_and_reference_agree_on_a_hundred_thousand_lights() {
    let scene = scene("scenes/many_lights/many_lights.toml");
    for strategy in [Strategy::MisPower, Strategy::LightSolidAngle] {
        let comparison = compared(&scene, strategy, (1 << 11, 64), None);
        assert_agrees(&comparison, &format!("many lights, {strategy}"));
        if let Some(worst) = &comparison.per_sample.worst {
            assert!(!worst.cause.contains("neither"), "{strategy}: {worst:?}");
        }
    }
}

#[test]
fn gpu_and_reference_agree_on_gltf_and_on_scenes_with_models() {
    let Some(assets) = shared("assets") else {
        return;
    };
    let options = LoadOptions {
        assets: vec![assets.clone()],
        ..LoadOptions::default()
    };
    let project = std::path::Path::new(crate::support::PROJECT);
    for path in [
        assets.join("CornellBox.glb"),
        project.join("scenes/helmet.toml"),
        project.join("scenes/bunny.toml"),
    ] {
        let scene = load(&path, &options).unwrap();
        let comparison = compared(&scene, Strategy::MisPower, (1 << 13, 64), None);
        assert_agrees(&comparison, &path.display().to_string());
    }
}

/// The bounds of the project: on Cornell 99.99 % of the samples whose rays meet the same within
/// 10⁻⁴, on the plates, whose narrow lobes amplify rounding, 99.9 % within 10⁻³; fewer than 10⁻⁴
/// whose rays meet something else.
#[test]
fn samples_agree_as_far_as_f32_goes() {
    let cornell = scene("scenes/cornell.toml");
    let veach = scene("scenes/veach.toml");
    for strategy in STRATEGIES {
        let of_cornell = compared(&cornell, strategy, (1 << 14, 64), None).per_sample;
        assert!(of_cornell.samples > 1_000_000);
        assert!(
            of_cornell.within_1e_4 >= 0.9999,
            "{strategy}: {of_cornell:?}"
        );
        assert!(of_cornell.flip_rate < 1e-4, "{strategy}: {of_cornell:?}");
        let of_veach = compared(&veach, strategy, (1 << 14, 64), None).per_sample;
        assert!(of_veach.within_1e_3 >= 0.999, "{strategy}: {of_veach:?}");
        assert!(of_veach.flip_rate < 1e-4, "{strategy}: {of_veach:?}");
        if let Some(worst) = of_veach.worst {
            assert!(!worst.cause.contains("neither"), "{strategy}: {worst:?}");
        }
    }
}
