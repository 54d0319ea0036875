//! How many shadow rays a scene may ask for.

use super::files::{Folder, refused};
use direkt::low_level::effects::Effect;
use direkt::low_level::prepare::Prepared;

const CAMERA: &str = "[camera]\neye = [0, 0, 5]\ntarget = [0, 0, 0]\nfov = 40\n";

#[track_caller]
fn says(message: String, expected: &str) {
    assert_eq!(message, format!("DIR/scene.toml: {expected}"));
}

#[test]
fn the_number_has_bounds() {
    for rays in ["0", "1025"] {
        says(
            refused(&format!("{CAMERA}[render]\nshadow_rays = {rays}\n")),
            &format!("render.shadow_rays: is {rays}; expected \"auto\" or 1 to 1024"),
        );
    }
}

/// As many lights as one ray for each may be, but not four: then there is one.
#[test]
fn many_lights_with_a_ray_each_leave_no_room_for_more() {
    let sphere = "[[shapes]]\ntype = \"sphere\"\nemission = { radiance = 1 }\n";
    for (lights, several) in [(16_383, true), (16_384, false)] {
        let text = format!(
            "{CAMERA}[render]\nlight_selection = \"all\"\n{}",
            sphere.repeat(lights)
        );
        let folder = Folder::new();
        folder.write("scene.toml", text);
        let prepared = Prepared::of(folder.load("scene.toml").expect("it can be rendered"));
        let effects = &prepared.effects;
        assert_eq!(effects.contains(Effect::ShadowRays), several, "{lights}");
    }
}

/// So many shadow rays that a camera ray cannot have them; without light sampling, and to points,
/// there are fewer.
#[test]
fn too_many_shadow_rays() {
    let scene = |settings: &str, light: &str| {
        format!(
            "{CAMERA}[render]\nlight_selection = \"all\"\nshadow_rays = 1024\n{settings}{}",
            light.repeat(64)
        )
    };
    let sphere = "[[shapes]]\ntype = \"sphere\"\nemission = { radiance = 1 }\n";
    says(
        refused(&scene("", sphere)),
        "render.light_selection: is \"all\", which takes 65536 shadow rays per camera ray here; expected at most 65535 of them: fewer shadow_rays, or \"tree\", \"power\" or \"uniform\"",
    );
    let point = "[[lights]]\ntype = \"point\"\nposition = [0, 0, 1]\nintensity = 1\n";
    let folder = Folder::new();
    for accepted in [scene("strategy = \"bsdf\"\n", sphere), scene("", point)] {
        folder.write("scene.toml", accepted);
        folder.load("scene.toml").expect("it can be rendered");
    }
}
