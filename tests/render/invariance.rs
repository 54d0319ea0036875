//! What must not change an image, bit for bit.

use super::test_scenes::test_scenes;
use crate::support::hard_cases::{Measured, survive_by_driver};
use crate::support::{
    context, floor_pixel, in_a_process_that_compiles_fast, lambert, own_scenes, point_light,
    prepared, scene, shape, take,
};
use direkt::low_level::accel::MAX_LIGHT_BOXES;
use direkt::low_level::accel::parts::{PARTS, Split};
use direkt::low_level::effects::Effect;
use direkt::low_level::gpu::doctor::loops::loop_budget;
use direkt::low_level::prepare::{Prepared, SceneData};
use direkt::low_level::render::{Film, Session, StopReason};
use direkt::scene::{Camera, Emission, FilmSize, Geometry, MaterialId, Mesh, Sampler, Scene};
use glam::DVec3;
use std::cmp::Reverse;
use std::collections::BTreeSet;
use std::sync::Arc;

fn small_cornell() -> Scene {
    let mut scene = scene("scenes/cornell.toml");
    scene.film = FilmSize {
        width: 63,
        height: 65,
    };
    scene
}

fn film_of(prepared: &Prepared, passes: &[u64]) -> Film {
    let context = context();
    let mut session = Session::new(context, prepared, prepared.film, 3).unwrap();
    for &samples in passes {
        assert_eq!(session.pass(samples, || false).unwrap(), StopReason::Done);
    }
    session.snapshot().unwrap().0
}

#[test]
fn passes_may_be_cut_anywhere() {
    let prepared = prepared(small_cornell());
    let whole = film_of(&prepared, &[24]);
    assert!(whole.pixels.iter().all(|p| p.samples == 24));
    assert_eq!(whole, film_of(&prepared, &[1, 2, 20, 1]));
    // Across the end of a block a pass stops, and the next begins a new block.
    let long = film_of(&prepared, &[255, 40, 45]);
    assert!(long.pixels.iter().all(|p| p.samples == 301));
    assert_eq!(long, film_of(&prepared, &[256, 45]));
}

/// 510 smooth triangles over the unit square, lit from above and seen from aslant.
fn waves() -> Scene {
    const COLUMNS: u32 = 17;
    const ROWS: u32 = 15;
    let vertices = (0..=ROWS).flat_map(|y| (0..=COLUMNS).map(move |x| (x, y)));
    let position = |(x, y)| {
        let (x, y) = (
            f64::from(x) / f64::from(COLUMNS),
            f64::from(y) / f64::from(ROWS),
        );
        DVec3::new(x - 0.5, y - 0.5, 0.05 * (9.0 * x).sin() * (7.0 * y).cos())
    };
    let positions: Vec<DVec3> = vertices.map(position).collect();
    let cells = (0..ROWS).flat_map(|y| (0..COLUMNS).map(move |x| y * (COLUMNS + 1) + x));
    let triangles = cells.flat_map(|a| {
        let above = a + COLUMNS + 1;
        [[a, a + 1, above + 1], [a, above + 1, above]]
    });
    let mut scene = floor_pixel();
    scene.camera = Camera::look_at(
        DVec3::new(0.0, -1.0, 0.8),
        DVec3::ZERO,
        DVec3::Z,
        50_f64.to_radians(),
    )
    .unwrap();
    scene.film = FilmSize {
        width: 48,
        height: 32,
    };
    let normals = positions.iter().map(|p| (DVec3::Z + 0.3 * *p).normalize());
    let mesh = Mesh {
        normals: normals.collect(),
        triangles: triangles.collect(),
        positions,
        ..Mesh::default()
    };
    scene.shapes = vec![shape("waves", Geometry::Mesh(mesh))];
    scene.lights = vec![point_light(DVec3::new(0.2, 0.1, 1.0), 3.0)];
    scene
}

/// Nodes, primitives and attributes in several bindings, as large scenes have them, are read as in
/// one.
#[test]
fn split_geometry_is_the_same() {
    let mut data = SceneData::new(waves());
    assert_eq!(data.split, None);
    let whole = film_of(&prepared(waves()), &[2]);
    assert!(whole.mean()[0] > 0.0);
    let (nodes, primitives) = (data.bvh.nodes.len(), data.primitives.len());
    let words = data.attributes.words.len();
    let [nodes, primitives, words] = [nodes, primitives, words].map(|count| count.div_ceil(PARTS));
    data.split = Some(Split {
        nodes,
        primitives,
        words,
    });
    let settings = data.scene.render;
    let split = Prepared::new(&Arc::new(data), settings);
    assert_eq!(whole, film_of(&split, &[2]));
}

#[test]
fn other_seeds_give_other_images() {
    let context = context();
    let prepared = prepared(small_cornell());
    let films = [3, 4].map(|seed| {
        let mut session = Session::new(context, &prepared, prepared.film, seed).unwrap();
        take(&mut session, 4);
        session.snapshot().unwrap().0
    });
    assert_ne!(films[0], films[1]);
}

/// `scene` made ready, with the same constants in its kernel as the others': their kernels with
/// every effect take long to compile, and so they are one.
fn with_constants_of_all(scene: Scene) -> Prepared {
    let settings = scene.render;
    let mut data = SceneData::new(scene);
    data.bvh.depth = data.bvh.depth.max(32);
    let mut prepared = Prepared::new(&Arc::new(data), settings);
    if let Some(&last) = prepared.light_boxes.last() {
        prepared.light_boxes.resize(MAX_LIGHT_BOXES, last);
    }
    prepared
}

/// Few scenes that together call for every effect that any scene calls for: each the one with most
/// that those before lack.
fn scenes_of_all_effects() -> Vec<(String, Prepared)> {
    let small = |(name, mut scene): (String, Scene)| {
        scene.render.estimator.sampler = Sampler::Independent;
        scene.film = FilmSize {
            width: 24,
            height: 16,
        };
        (name, with_constants_of_all(scene))
    };
    let all = own_scenes().into_iter().chain(test_scenes()).map(small);
    let mut all: Vec<_> = all.collect();
    let effects = |prepared: &Prepared| -> BTreeSet<_> {
        prepared.effects.iter().map(|(effect, _)| effect).collect()
    };
    let mut known = BTreeSet::new();
    let mut scenes = Vec::new();
    loop {
        let news =
            |(_, prepared): &(String, Prepared)| effects(prepared).difference(&known).count();
        let best = (0..all.len()).max_by_key(|&i| (news(&all[i]), Reverse(i)));
        let best = all.remove(best.expect("a scene"));
        if news(&best) == 0 {
            return scenes;
        }
        known.extend(effects(&best.1));
        scenes.push(best);
    }
}

/// A scene pays for what it uses and nothing else, and gets the same image as with everything.
#[test]
fn unneeded_effects_compiled_in_change_nothing() {
    let name = "render::invariance::unneeded_effects_compiled_in_change_nothing";
    in_a_process_that_compiles_fast(name, || {
        let scenes = scenes_of_all_effects();
        assert!(scenes.len() > 8, "{} scenes", scenes.len());
        for (name, mut prepared) in scenes {
            let lean = film_of(&prepared, &[4]);
            for &effect in Effect::ALL.iter().filter(|e| e.can_be_forced()) {
                prepared.effects.force(effect);
            }
            let full = film_of(&prepared, &[4]);
            let differ = lean.pixels.iter().zip(&full.pixels).filter(|(a, b)| a != b);
            let differ = differ.count();
            assert_eq!(differ, 0, "{name}: pixels that differ");
            assert!(lean.pixels.iter().all(|p| p.samples == 4), "{name}");
        }
    });
}

#[test]
fn every_size_is_covered() {
    for (width, height) in [(1, 1), (63, 65), (7, 300), (300, 1)] {
        let mut scene = floor_pixel();
        scene
            .lights
            .push(point_light(DVec3::new(0.0, 0.0, 2.0), 100.0));
        scene.film = FilmSize { width, height };
        let film = film_of(&prepared(scene), &[3]);
        assert_eq!(film.pixels.len(), (width * height) as usize);
        for pixel in &film.pixels {
            assert_eq!(pixel.samples, 3, "{width} × {height}");
            assert!(
                (pixel.mean[0] - 3.978_873_577).abs() < 1e-3,
                "{width} × {height}: {pixel:?}"
            );
        }
    }
}

/// Several regions: more tiles than one buffer holds.
#[test]
fn an_image_of_several_regions_is_covered() {
    let mut scene = floor_pixel();
    scene
        .lights
        .push(point_light(DVec3::new(0.0, 0.0, 2.0), 100.0));
    scene.film = FilmSize {
        width: 4096,
        height: 300,
    };
    let film = film_of(&prepared(scene), &[2]);
    assert!(
        film.pixels
            .iter()
            .all(|p| p.samples == 2 && (p.mean[0] - 3.978_873_577).abs() < 1e-2)
    );
}

#[test]
fn an_interrupted_pass_keeps_what_it_has() {
    let context = context();
    let prepared = prepared(small_cornell());
    let mut session = Session::new(context, &prepared, prepared.film, 3).unwrap();
    session.pass(2, || false).unwrap();
    assert_eq!(session.pass(2, || true).unwrap(), StopReason::Interrupted);
    let (film, rays) = session.snapshot().unwrap();
    assert_eq!(film, film_of(&prepared, &[2]));
    assert_eq!(rays.camera, 2 * 63 * 65);
}

/// Every ray passes through the backs of 6,000 one-sided rectangles before it meets the emitting
/// floor: 64 samples take more loop iterations than Mesa 22's lavapipe grants an invocation
/// (65,535). The kernel notices, and goes on.
#[test]
fn loops_longer_than_a_drivers_budget_lose_no_sample() {
    let mut scene = floor_pixel();
    scene.shapes[0].emission = Some(Emission {
        radiance: DVec3::ONE,
        texture: None,
        two_sided: false,
    });
    let mut one_sided = lambert(0.5);
    one_sided.double_sided = false;
    scene.materials.push(one_sided);
    for i in 0..6000 {
        let corner = DVec3::new(-10.0, -10.0, 0.1 + 1.5 * f64::from(i) / 6000.0);
        let mut culled = shape(
            "culled",
            Geometry::Rectangle {
                corner,
                u: DVec3::new(0.0, 20.0, 0.0),
                v: DVec3::new(20.0, 0.0, 0.0),
            },
        );
        culled.material = MaterialId(1);
        scene.shapes.push(culled);
    }
    let context = context();
    let prepared = prepared(scene);
    let mut session = Session::new(context, &prepared, prepared.film, 0).unwrap();
    session.pass(64, || false).unwrap();
    let (film, _) = session.snapshot().unwrap();
    assert_eq!(film.pixels[0].mean, [1.0; 3], "{:?}", context.adapter);
    let budget = loop_budget(context).unwrap();
    let limited = !budget.is_unlimited();
    let lost = budget.canaries.iter().map(|c| c.expected - c.ran);
    survive_by_driver(
        context,
        Measured {
            entry: "L1",
            case: "64 samples behind 6,000 surfaces that rays pass through",
            figure: "samples that are lost; of the textbook's, iterations of 270,000",
            bound: 0.0,
            textbook: "a loop as long as it takes",
            naive: f64::from(lost.sum::<u32>()),
            ours: 64.0 - film.pixels[0].samples as f64,
        },
    );
    assert_eq!(
        session.dispatches > 1,
        limited,
        "{} dispatches",
        session.dispatches
    );
}
