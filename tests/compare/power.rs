//! Every broken twin is found out, and every part of the comparison finds some.

use super::compared;
use crate::support::{KINDS_OF_STRATEGIES, prepared_for, scene, scenes_of_lights};
use direkt::low_level::effects::Effect;
use direkt::low_level::reference::broken::{BROKEN_TWINS, BrokenTwin};
use direkt::scene::{LightSampling, Scene, ShadowRays, Strategy};
use direkt_instruments::compare::Comparison;

/// By which parts of the comparison a broken twin was rejected, on how many scenes.
#[derive(Debug, Clone, Copy, Default)]
struct Found {
    tried: usize,
    by_samples: usize,
    by_pixels: usize,
    by_image: usize,
}

impl Found {
    fn add(&mut self, comparison: &Comparison) {
        self.tried += 1;
        self.by_samples += usize::from(!comparison.per_sample.agrees());
        self.by_pixels += usize::from(!comparison.per_pixel.agrees());
        self.by_image += usize::from(!comparison.whole_image.agrees());
    }
}

/// Scenes, strategies and numbers of pixels: small images of all, and two on which 2 % are more
/// than the noise of a mean: many pixels with narrow lobes, and a light that every sample meets.
fn cases() -> Vec<(String, Scene, Strategy, u32)> {
    let own = scenes_of_lights();
    let all = own.into_iter().flat_map(|(name, mut scene)| {
        // Wrong weights are about what light sampling does badly.
        scene.render.estimator.light_sampling = LightSampling::Area;
        KINDS_OF_STRATEGIES.map(|strategy| (name.clone(), scene.clone(), strategy, 1 << 12))
    });
    let quiet = ["scenes/veach.toml", "scenes/tests/square_parallel.toml"];
    let quiet = quiet.map(|path| (path.to_owned(), scene(path), Strategy::MisPower, 1 << 14));
    all.chain(quiet).collect()
}

/// Scenes with several shadow rays, for what is about them: among them a sky, of which BSDF samples
/// find as much.
fn cases_of_several_rays() -> Vec<(String, Scene, Strategy, u32)> {
    let mut scenes = scenes_of_lights();
    let sky = "scenes/tests/sky.toml";
    scenes.push((sky.to_owned(), scene(sky)));
    let several = |(name, mut scene): (String, Scene)| {
        scene.render.estimator.shadow_rays = ShadowRays::Number(4);
        let name = format!("{name} with 4 shadow rays");
        (name, scene, Strategy::MisPower, 1 << 12)
    };
    scenes.into_iter().map(several).collect()
}

/// Scenes whose surfaces let light pass, for what is about them.
fn cases_of_opacities() -> Vec<(String, Scene, Strategy, u32)> {
    let paths = ["scenes/leaves.toml", "scenes/tests/opacity_shadow.toml"];
    let strategies = [Strategy::LightArea, Strategy::MisPower];
    let of_path = |path: &str| strategies.map(|s| (path.to_owned(), scene(path), s, 1 << 12));
    paths.into_iter().flat_map(of_path).collect()
}

/// Samples with the same random numbers show every mistake everywhere. Means show those that are
/// larger than their noise: each of them on some scene.
#[test]
fn every_broken_twin_is_rejected_on_every_scene() {
    let mut found = vec![Found::default(); BROKEN_TWINS.len()];
    let special = [cases_of_several_rays(), cases_of_opacities()].concat();
    for (name, scene, strategy, pixels) in cases().into_iter().chain(special) {
        let prepared = prepared_for(
            scene.clone(),
            strategy,
            scene.render.estimator.light_selection,
        );
        let several = prepared.shadow_rays() > 1;
        let opacities = prepared.effects.contains(Effect::Alpha);
        for (row, found) in BROKEN_TWINS.iter().zip(&mut found) {
            let concerned = match row.twin {
                BrokenTwin::RaysForgotten => several,
                BrokenTwin::OpaqueShadows => opacities,
                _ => !several && !opacities,
            };
            if (row.applies)(&prepared) && concerned {
                let broken = compared(&scene, strategy, (pixels, 64), Some(row.twin));
                assert!(!broken.agrees(), "{name}, {strategy}: {} passes", row.name);
                found.add(&broken);
            }
        }
    }
    for (row, found) in BROKEN_TWINS.iter().zip(&found) {
        assert!(found.tried >= 4, "{}: {found:?}", row.name);
        assert_eq!(found.by_samples, found.tried, "{}", row.name);
        assert!(found.by_pixels > 0, "{}: {found:?}", row.name);
        assert!(found.by_image > 0, "{}: {found:?}", row.name);
    }
}
