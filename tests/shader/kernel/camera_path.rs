//! `shaders/kernel/camera_path.wesl`.

use crate::support::rounding::U;
use crate::support::shader::{Function, call_in};
use crate::support::{context, prepared, render, scene};
use direkt::low_level::effects::Effect;
use direkt::low_level::reference::core::frame::{ShadingFrame, frame_from_normal};
use direkt::low_level::reference::kernel::camera_path::ray_onwards;
use direkt::low_level::reference::scene::surface::Surface;
use direkt::scene::{Bsdf, Strategy};
use glam::DVec3;

fn surface(normal: DVec3) -> Surface {
    let ShadingFrame { x, y, z } = frame_from_normal(normal);
    let position = DVec3::new(0.25, -0.5, 0.125);
    Surface {
        position,
        origin: position + z * 1e-6,
        frame: ShadingFrame { x, y, z },
        wo: DVec3::Z,
        material: Bsdf::Mirror {
            reflectance: DVec3::ONE,
        }
        .parameters(),
        light: None,
        own_light: None,
        front: true,
        normal: z,
        cos_o: 1.0,
        lift: DVec3::ZERO,
    }
}

/// Rays go on from above the surface, and those that pass through from as far below it, with
/// directions of unit length.
#[test]
fn rays_go_on_as_the_twins() {
    let scene = scene("scenes/tests/mirror.toml");
    let prepared = prepared(scene);
    let normal = DVec3::new(0.6, 0.0, 0.8);
    let s = surface(normal);
    let local = DVec3::new(0.48, 0.6, 0.64);
    for transmitted in [false, true] {
        let wi = if transmitted { -local } else { local };
        let body = format!(
            "var s: Surface;
             s.position = vec3f(0.25, -0.5, 0.125);
             s.frame = frame_from_normal(vec3f(0.6, 0.0, 0.8));
             s.origin = s.position + s.frame.z * 1e-6;
             let ray = ray_onwards(s, vec3f({:?}, {:?}, {:?}), {transmitted});
             out_vec3f(0u, ray.origin); out_vec3f(3u, ray.direction);",
            wi.x, wi.y, wi.z
        );
        let function = Function {
            imports: "import package::core::frame::frame_from_normal;
                      import package::kernel::camera_path::ray_onwards;
                      import package::scene::surface::Surface;",
            body: &body,
            outputs: 6,
            ..Function::default()
        };
        let answers = call_in(context(), &prepared, &function, &[], 1);
        let expected = ray_onwards(&s, wi, transmitted);
        let (origin, direction) = (
            answers.vec3(0).next().unwrap(),
            answers.vec3(3).next().unwrap(),
        );
        assert!(
            (origin - expected.origin).abs().max_element() <= U,
            "{origin}"
        );
        assert!(
            (direction - expected.direction).length() <= 16.0 * U,
            "{direction}"
        );
        let side = (origin - s.position).dot(normal) * direction.dot(normal);
        assert!(side > 0.0, "it starts on the side to which it goes: {side}");
    }
}

/// Light that no strategy but the camera's own ray finds has the weight 1 under each of them (HARD
/// CASES M2): a lamp seen in a mirror, and a floor seen in two.
#[test]
fn what_is_seen_in_mirrors_does_not_depend_on_the_strategy() {
    for name in ["mirror", "mirror_shows_direct_lighting", "glass_pane"] {
        let mut scene = scene(&format!("scenes/tests/{name}.toml"));
        let mut film = |strategy: Strategy| {
            scene.render.estimator.strategy = strategy;
            let mean = render(context(), scene.clone()).mean();
            DVec3::from(mean)
        };
        let first = film(Strategy::Bsdf);
        for strategy in [
            Strategy::LightArea,
            Strategy::MisPower,
            Strategy::MisBalance,
        ] {
            let other = film(strategy);
            assert!(
                (other - first).abs().max_element() <= 1e-6 * first.max_element(),
                "{name}, {strategy}"
            );
        }
    }
}

/// What a scene holds calls for what it needs, and for no more.
#[test]
fn glass_calls_for_its_effects() {
    let glass = prepared(scene("scenes/glass.toml"));
    for effect in [
        Effect::Specular,
        Effect::Refraction,
        Effect::ExactDielectric,
        Effect::ExactConductor,
        Effect::Glossy,
    ] {
        assert!(glass.effects.contains(effect), "{effect:?}");
    }
    let plain = prepared(scene("scenes/cornell.toml"));
    assert!(!plain.effects.contains(Effect::Specular));
}
