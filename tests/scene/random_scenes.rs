//! `examples/random_scenes`: scenes that nobody chose.

#[path = "../../examples/random_scenes/generator.rs"]
mod generator;
#[path = "../../examples/random_scenes/textures.rs"]
mod textures;

use super::fuzz::harness::random;
use direkt::low_level::effects::Effect;
use direkt::low_level::prepare::Prepared;
use direkt::scene::Scene;
use direkt::scene::load::{LoadOptions, load};
use std::collections::BTreeSet;
use std::path::Path;

/// Writes what the scenes read into `folder`.
pub(crate) fn write_textures(folder: &Path) {
    for (name, bytes) in textures::files() {
        std::fs::write(folder.join(name), bytes).unwrap();
    }
}

/// Scene number `seed`, in a `folder` with the textures.
pub(crate) fn random_scene(folder: &Path, seed: u64) -> Scene {
    let text = generator::scene(seed);
    assert_eq!(text, generator::scene(seed));
    let path = folder.join(format!("{seed}.toml"));
    std::fs::write(&path, text).unwrap();
    load(&path, &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

/// Every seed is a scene with a light; together they call for all kinds of lights, cameras and
/// materials that the generator knows.
#[test]
fn every_seed_is_a_scene_with_a_light() {
    let folder = tempfile::tempdir().unwrap();
    write_textures(folder.path());
    let mut called_for = BTreeSet::new();
    for seed in 1..=100 {
        let prepared = Prepared::of(random_scene(folder.path(), seed));
        assert!(!prepared.emitters.lights.is_empty(), "{seed}");
        let effects = Effect::ALL
            .iter()
            .filter(|e| prepared.effects.contains(**e));
        called_for.extend(effects.map(|e| e.name()));
    }
    for name in [
        "alpha",
        "alpha-texture",
        "area-lights",
        "color-texture",
        "conductor-fresnel",
        "depth-of-field",
        "dielectric-fresnel",
        "directional-lights",
        "disk-lights",
        "ellipsoid-lights",
        "environment",
        "environment-map",
        "glossy",
        "orthographic",
        "pixel-filter",
        "planar-lights",
        "point-lights",
        "refraction",
        "specular",
        "sphere-lights",
        "spot-lights",
        "suns",
    ] {
        assert!(called_for.contains(name), "{name}: {called_for:?}");
    }
}
