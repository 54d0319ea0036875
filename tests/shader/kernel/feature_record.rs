//! `shaders/kernel/feature_record.wesl`.

use crate::support::shader::{Function, call_in};
use crate::support::{context, prepared, scene};
use direkt::low_level::reference::kernel::feature_record::albedo;
use direkt::scene::MaterialId;
use glam::DVec3;

/// Of mirror, glass, pane, plastic and metals.
#[test]
fn albedo_is_the_twins() {
    let mut scene = scene("scenes/glass.toml");
    let materials: Vec<_> = scene
        .materials
        .iter()
        .map(|m| m.bsdf.parameters())
        .collect();
    // Every material is seen by the effects.
    let shapes = scene.shapes.len();
    for id in 0..materials.len() {
        let mut shape = scene.shapes[id % shapes].clone();
        shape.material = MaterialId(id as u32);
        scene.shapes.push(shape);
    }
    let prepared = prepared(scene);
    let function = Function {
        imports: "import package::kernel::feature_record::albedo;
                  import package::scene::fetch::fetch_material;",
        body: "out_vec3f(0u, albedo(fetch_material(item)));",
        outputs: 3,
        ..Function::default()
    };
    let answers = call_in(context(), &prepared, &function, &[], materials.len());
    for (found, material) in answers.vec3(0).zip(&materials) {
        let expected = albedo(material);
        let wrong = (found - expected).abs().max_element();
        assert!(wrong <= 4e-6, "{material:?}: {found} for {expected}");
        let inside = expected.clamp(DVec3::ZERO, DVec3::ONE);
        assert!(
            (expected - inside).abs().max_element() <= 1e-12,
            "{material:?}"
        );
        let base_alone = material.diffuse;
        if material.specular.is_some() {
            let broken = (found - base_alone).abs().max_element();
            assert!(broken > 1e-3, "{material:?}: the lobe is forgotten");
        }
    }
}

/// Features start with nothing and are those of the last surface, with what is before it.
#[test]
fn the_last_surface_counts() {
    let prepared = prepared(scene("scenes/cornell.toml"));
    let function = Function {
        imports: "import package::core::frame::frame_from_normal;
                  import package::kernel::feature_record::{features_seen, record_features, start_features};
                  import package::scene::surface::Surface;",
        body: "var s: Surface;
               s.frame = frame_from_normal(vec3f(0.6, 0.0, 0.8));
               s.material.diffuse = vec3f(0.5);
               start_features();
               out_vec3f(0u, features_seen.albedo);
               record_features(s, vec3f(1.0));
               s.frame = frame_from_normal(vec3f(0.0, 1.0, 0.0));
               record_features(s, vec3f(0.5, 1.0, 8.0));
               out_vec3f(3u, features_seen.albedo); out_vec3f(6u, features_seen.normal);",
        outputs: 9,
        ..Function::default()
    };
    let answers = call_in(context(), &prepared, &function, &[], 1);
    let word = |i| answers.vec3(i).next().unwrap();
    assert_eq!(word(0), DVec3::ZERO);
    assert_eq!(word(3), DVec3::new(0.25, 0.5, 1.0));
    assert!(word(6).distance(DVec3::Y) < 1e-6);
}
