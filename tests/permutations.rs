//! Every variant of the kernel that a scene uses, and each effect alone, links and is valid WGSL.

use crate::support::{STRATEGIES, own_scenes, prepared_for};
use clap::ValueEnum;
use direkt::low_level::accel::parts::Split;
use direkt::low_level::effects::{Effect, Effects};
use direkt::low_level::gpu::SceneKernel;
use direkt::low_level::gpu::kernel::DIRECT;
use direkt::low_level::gpu::shader::KernelConstants;
use direkt::scene::{LightSelection, ShadowPattern, ShadowRays, Strategy};

const CONFIG: KernelConstants = KernelConstants {
    stack_depth: 16,
    stamp: 1,
    light_groups: 2,
    environment_group: 1,
    light_boxes: 1,
    split: None,
    specialized: None,
};

fn validate(effects: &Effects, what: &str) -> String {
    validate_with(effects, &CONFIG, what)
}

fn validate_with(effects: &Effects, config: &KernelConstants, what: &str) -> String {
    let wgsl =
        SceneKernel::link(&DIRECT, effects, config).unwrap_or_else(|e| panic!("{what}: {e}"));
    let module = naga::front::wgsl::parse_str(&wgsl)
        .unwrap_or_else(|e| panic!("{what}: {}", e.emit_to_string(&wgsl)));
    let mut validator = naga::valid::Validator::new(
        naga::valid::ValidationFlags::all(),
        naga::valid::Capabilities::default(),
    );
    if let Err(e) = validator.validate(&module) {
        panic!("{what}: {}", e.emit_to_string(&wgsl));
    }
    wgsl
}

#[test]
fn every_scene_links_under_every_strategy() {
    for (name, scene) in own_scenes() {
        for strategy in STRATEGIES {
            let prepared = prepared_for(scene.clone(), strategy, LightSelection::Power);
            let what = format!("{name}, {strategy}");
            validate(&prepared.effects, &what);
            validate_with(&prepared.effects, &KernelConstants::of(&prepared), &what);
        }
    }
}

/// With several rays in every pattern, to a chosen light and to every one.
#[test]
fn shadow_rays_link_in_every_pattern() {
    for (name, scene) in own_scenes() {
        for &pattern in ShadowPattern::value_variants() {
            for &selection in LightSelection::value_variants() {
                let mut scene = scene.clone();
                scene.render.estimator.shadow_rays = ShadowRays::Number(4);
                scene.render.estimator.shadow_pattern = pattern;
                let prepared = prepared_for(scene, Strategy::MisPower, selection);
                validate(
                    &prepared.effects,
                    &format!("{name}, {pattern}, {selection}"),
                );
            }
        }
    }
}

#[test]
fn every_effect_links_alone() {
    for &effect in Effect::ALL {
        let mut effects = Effects::default();
        effects.call_for(effect, || "alone".to_owned());
        validate(&effects, effect.name());
    }
}

#[test]
fn no_effect_and_all_effects_link() {
    validate(&Effects::default(), "none");
    let mut all = Effects::default();
    for &effect in Effect::ALL {
        all.call_for(effect, || "all".to_owned());
    }
    validate(&all, "all");
    let split = KernelConstants {
        split: Some(Split::of_words(1 << 23)),
        ..CONFIG
    };
    validate_with(&all, &split, "all, split");
}

#[test]
fn what_a_scene_does_not_call_for_is_not_in_its_shader() {
    let scenes = own_scenes();
    let (_, cornell) = scenes
        .iter()
        .find(|(name, _)| name == "cornell.toml")
        .unwrap();
    let prepared = prepared_for(
        cornell.clone(),
        direkt::scene::Strategy::LightArea,
        LightSelection::Power,
    );
    let wgsl = validate(&prepared.effects, "cornell.toml, light-area");
    for absent in [
        "intersect_sphere",
        "intersect_triangle",
        "ggx_distribution",
        "environment_texels",
        "sample_bsdf",
        "alias_choice",
        "spot_falloff",
        "estimate_by_shadow_rays",
        "grid_point",
        "note_near_miss",
        "light_with_its_samples",
        "opacity_at",
        "is_stopped",
        "primitives_1",
    ] {
        assert!(
            !wgsl.contains(absent),
            "{absent} is in the shader of the Cornell box"
        );
    }
    assert!(wgsl.contains("intersect_rectangle"));
}
