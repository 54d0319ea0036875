//! Samples against exact direct lighting at the points that they see.

use super::scaled;
use crate::support::{STRATEGIES, context, prepared_for, scene, statistics};
use direkt::low_level::reference::Twin;
use direkt::low_level::reference::broken::{BROKEN_TWINS, BrokenTwin};
use direkt::low_level::reference::exact::scene::ExactScene;
use direkt::low_level::stats::moments::Moments;
use direkt::low_level::stats::t_test::one_sample;
use direkt::scene::material::DielectricLayer;
use direkt::scene::{Bsdf, FilmSize, Scene, ShadowRays, Strategy};
use direkt_instruments::compare::{CompareError, Settings, compare};
use glam::DVec3;
use rayon::prelude::*;

fn exact(
    scene: Scene,
    strategy: Strategy,
) -> Result<direkt_instruments::compare::Comparison, CompareError> {
    let settings = Settings {
        film: scaled(scene.film, 1 << 13),
        samples: 64,
        seed: 1,
        broken: None,
        exact: true,
    };
    let selection = scene.render.estimator.light_selection;
    let prepared = prepared_for(scene, strategy, selection);
    compare(context(), &prepared, &settings, |_| ())
}

#[test]
fn cornell_is_exact_under_every_strategy() {
    for strategy in STRATEGIES {
        let comparison = exact(scene("scenes/cornell.toml"), strategy).unwrap();
        let exact = comparison.exact.as_ref().unwrap();
        for channel in &exact.channels {
            statistics::accept(channel.p_value, &format!("Cornell, exact, {strategy}"));
        }
        assert!(comparison.agrees());
    }
}

/// The Cornell box with surfaces of half metal: their lobes are integrated numerically over what
/// they see of the light.
fn glossy_cornell() -> Scene {
    let mut glossy = scene("scenes/cornell.toml");
    for material in &mut glossy.materials {
        if let Bsdf::Lambert { reflectance } = material.bsdf {
            material.bsdf = Bsdf::MetallicRoughness {
                base_color: reflectance,
                metallic: 0.5,
                roughness: 0.5,
                layer: DielectricLayer::default(),
            };
        }
    }
    glossy
}

#[test]
fn a_glossy_cornell_box_is_exact() {
    let comparison = exact(glossy_cornell(), Strategy::MisPower).unwrap();
    let exact = comparison.exact.as_ref().unwrap();
    for channel in &exact.channels {
        statistics::accept(channel.p_value, "glossy Cornell, exact");
        assert!(exact.error < 1e-4 * channel.exact, "{exact:?}");
    }
}

#[test]
fn what_has_no_exact_answer_is_refused_by_name() {
    for (path, name) in [
        ("scenes/veach.toml", "is curved"),
        ("scenes/tests/sky.toml", "[environment]"),
        (
            "scenes/tests/opacity_shadow.toml",
            "materials.veil: opacity 0.4",
        ),
    ] {
        let refused = exact(scene(path), Strategy::MisPower).unwrap_err();
        assert!(refused.to_string().contains(name), "{path}: {refused}");
    }
}

/// The same statistic of the twin's samples accepts the honest twin, and rejects every broken one.
#[test]
fn exact_answers_reject_every_broken_twin() {
    assert_rejected("glossy Cornell", glossy_cornell(), |twin| {
        !matches!(twin, BrokenTwin::RaysForgotten | BrokenTwin::OpaqueShadows)
    });
    // A light so near that BSDF samples find much of it.
    let mut near = scene("scenes/tests/square_near.toml");
    near.render.estimator.shadow_rays = ShadowRays::Number(4);
    assert_rejected("near square, 4 shadow rays", near, |twin| {
        twin == BrokenTwin::RaysForgotten
    });
}

fn assert_rejected(name: &str, mut scene: Scene, broken: impl Fn(BrokenTwin) -> bool) {
    // Enough that 2 % are more than nine standard errors.
    let pixels = 1 << 15;
    if scene.film.pixels() < pixels {
        scene.film = FilmSize {
            width: 1 << 8,
            height: 1 << 7,
        };
    }
    let film = scaled(scene.film, pixels as u32);
    let selection = scene.render.estimator.light_selection;
    let prepared = prepared_for(scene, Strategy::MisPower, selection);
    let honest = Twin::new(&prepared, film, 3, None);
    let answers = ExactScene::new(honest.direct().world()).unwrap();
    let exact: Vec<DVec3> = (0..film.pixels() as u32)
        .into_par_iter()
        .map(|p| {
            let ray = honest
                .direct()
                .camera_ray(p % film.width, p / film.width, 0);
            answers.radiance(&ray).value
        })
        .collect();
    let p_value = |twin: &Twin<'_>| {
        let residuals: Moments = twin
            .samples(0)
            .iter()
            .zip(&exact)
            .map(|(sample, exact)| (sample.radiance - exact).element_sum())
            .collect();
        one_sample(&residuals, 0.0).expect("samples vary").p_value
    };
    statistics::accept(
        p_value(&honest),
        &format!("honest twin, exact {name}, seed 3"),
    );
    for row in BROKEN_TWINS.iter().filter(|row| broken(row.twin)) {
        let broken = Twin::new(&prepared, film, 3, Some(row.twin));
        statistics::reject(p_value(&broken), &format!("exact {name}, {}", row.name));
    }
}
