//! `shaders/kernel/shadow_rays.wesl`.

use crate::support::every_kind::{environment_map, every_kind};
use crate::support::random::Random;
use crate::support::shader::{Function, call, call_in};
use crate::support::{context, edge_points, prepared_for, statistics};
use direkt::low_level::prepare::Prepared;
use direkt::low_level::reference::core::rng::to_unit;
use direkt::low_level::reference::core::sampler::{Numbers, SampleId};
use direkt::low_level::reference::kernel::shadow_rays::{ShadowRays, grid_point};
use direkt::low_level::stats::chi2::{Totals, chi2_test};
use direkt::scene::environment::Interpolation;
use direkt::scene::{self, LightSelection, Sampler, ShadowGrid, ShadowPattern, Strategy};
use glam::DVec2;

const PATTERNS: [ShadowPattern; 4] = [
    ShadowPattern::Random,
    ShadowPattern::Center,
    ShadowPattern::Grid,
    ShadowPattern::Stratified,
];
const SAMPLERS: [Sampler; 4] = [
    Sampler::Independent,
    Sampler::Stratified,
    Sampler::Sobol,
    Sampler::BlueNoise,
];
/// Those whose pairs of dimensions have nothing to do with each other: within one of its grids
/// `stratified` takes the odd columns of one pair together with the odd or with the even ones of
/// another.
const INDEPENDENT_PAIRS: [Sampler; 3] = [Sampler::Independent, Sampler::Sobol, Sampler::BlueNoise];
/// Of f32 between ½ and 1.
const ULP: f64 = 5.960_464_477_539_063e-8;

/// Lights of every kind, with `rays` shadow rays.
fn prepared(
    rays: u32,
    pattern: ShadowPattern,
    selection: LightSelection,
    sampler: Sampler,
) -> Prepared {
    let mut scene = every_kind(environment_map(Interpolation::Nearest));
    scene.render.estimator.shadow_rays = scene::ShadowRays::Number(rays);
    scene.render.estimator.shadow_pattern = pattern;
    scene.render.estimator.sampler = sampler;
    scene.render.seed = 51;
    prepared_for(scene, Strategy::MisPower, selection)
}

fn twin(prepared: &Prepared) -> (ShadowRays, Numbers) {
    let numbers = Numbers {
        sampler: prepared.settings.estimator.sampler,
        pattern: prepared.patterns().pixel,
        width: prepared.film.width,
    };
    (ShadowRays::new(prepared, numbers), numbers)
}

/// Words are the twin's, bit for bit; points up to rounding. With every pattern, sampler and
/// selection.
#[test]
fn light_numbers_are_the_twins() {
    let context = context();
    let function = Function {
        imports: "import package::core::sampler::{GROUP_DIRECTION, GROUP_LIGHT, SampleId, random_group};
                  import package::kernel::shadow_rays::light_numbers;
                  import package::scene::bindings::frame;",
        body: "let name = SampleId(in_u32(0u), vec2u(in_u32(1u), in_u32(2u)), frame.seed, frame.film.width, frame.patterns.pixel);
               let words = vec4u(random_group(name, GROUP_LIGHT).xyz, random_group(name, GROUP_DIRECTION).z);
               let u = light_numbers(name, words, in_u32(3u), in_u32(4u));
               out_u32(0u, u.choice); out_u32(1u, u.texel); out_vec2f(2u, u.point);",
        inputs: 5,
        outputs: 4,
        ..Function::default()
    };
    let mut random = Random::new(50);
    for (i, pattern) in PATTERNS.into_iter().enumerate() {
        for (j, sampler) in SAMPLERS.into_iter().enumerate() {
            let all = (i + j) % 2 == 0;
            let selection = if all {
                LightSelection::All
            } else {
                LightSelection::Power
            };
            let rays = [1, 6, 7, 1024][(i + 2 * j) % 4];
            let prepared = prepared(rays, pattern, selection, sampler);
            let lights = prepared.emitters.lights.len() as u32;
            let items: Vec<[u32; 5]> = (0..2000)
                .map(|k| {
                    let high = if k % 2 == 0 { 0 } else { random.word() };
                    let light = if all { random.word() % lights } else { 0 };
                    [
                        random.word() % 4096,
                        random.word(),
                        high,
                        light,
                        random.word() % rays,
                    ]
                })
                .collect();
            let answers = call_in(
                context,
                &prepared,
                &function,
                items.as_flattened(),
                items.len(),
            );
            let found = answers.u32(0).zip(answers.u32(1)).zip(answers.vec2(2));
            let (twin, _) = twin(&prepared);
            for (&[pixel, low, high, light, ray], ((choice, texel), point)) in
                items.iter().zip(found)
            {
                let id = SampleId {
                    pixel,
                    index: u64::from(high) << 32 | u64::from(low),
                    seed: 51,
                };
                let expected = twin.light_numbers(id, light, ray);
                let what =
                    format!("{pattern}, {sampler}, {selection}, {rays} rays: {ray} of {id:?}");
                assert!(all || choice == expected.choice, "{what}");
                assert_eq!(texel, expected.texel, "{what}");
                let off = (point - expected.point).abs().max_element();
                assert!(
                    off <= 2.0 * ULP && point.max_element() < 1.0,
                    "{what}: {point}"
                );
            }
        }
    }
}

/// Each cell's points are in it, up to rounding at its border, and below 1.
#[test]
fn grid_points_are_in_their_cells() {
    let function = Function {
        imports: "import package::kernel::shadow_rays::grid_point;",
        body: "out_vec2f(0u, grid_point(in_u32(0u), in_u32(1u), in_u32(2u), in_vec2f(3u)));",
        inputs: 5,
        outputs: 2,
        ..Function::default()
    };
    for rays in [1, 2, 3, 12, 1000, 1021] {
        let grid = ShadowGrid::new(rays);
        let items: Vec<(u32, DVec2)> = [0, rays / 3, rays - 1]
            .into_iter()
            .flat_map(|ray| edge_points().into_iter().map(move |u| (ray, u)))
            .collect();
        let inputs: Vec<u32> = items
            .iter()
            .flat_map(|(ray, u)| {
                let within = [u.x, u.y].map(|x| (x as f32).to_bits());
                [*ray, grid.columns, grid.rows, within[0], within[1]]
            })
            .collect();
        let answers = call(context(), &function, &inputs);
        for ((ray, within), point) in items.iter().zip(answers.vec2(0)) {
            let expected = grid_point(*ray, grid, *within);
            let off = (point - expected).abs().max_element();
            assert!(off <= 2.0 * ULP, "{rays} rays, {ray} at {within}: {point}");
            assert!(point.min_element() >= 0.0 && point.max_element() < 1.0);
            let columns = f64::from(grid.columns);
            let corner = DVec2::new(f64::from(ray % grid.columns), f64::from(ray / grid.columns));
            let from = point * DVec2::new(columns, f64::from(grid.rows)) - corner;
            assert!(from.min_element() > -1e-4 && from.max_element() < 1.0001);
        }
    }
}

/// p-value of triples in [0, 1)³ being uniform: 5 × 5 × 5 cells.
fn uniform_p_value(triples: impl Iterator<Item = [f64; 3]>) -> f64 {
    let mut observed = vec![0_u64; 125];
    for [x, y, z] in triples {
        let cell = |u: f64| (5.0 * u) as usize;
        observed[25 * cell(z) + 5 * cell(y) + cell(x)] += 1;
    }
    let drawn: u64 = observed.iter().sum();
    let expected = vec![drawn as f64 / 125.0; 125];
    let test = chi2_test(&observed, &expected, Totals::Tied);
    test.expect("every cell expects some").p_value
}

/// Samples of one pixel.
const SAMPLES: u64 = 1 << 14;

fn id(index: u64) -> SampleId {
    SampleId {
        pixel: 5,
        index,
        seed: 52,
    }
}

/// In one pixel each ray's place in its cell and its choices of light and texel are uniform and
/// independent, so that every pixel converges.
#[test]
fn every_ray_is_uniform_in_every_pixel() {
    for sampler in INDEPENDENT_PAIRS {
        let prepared = prepared(4, ShadowPattern::Stratified, LightSelection::Power, sampler);
        let (twin, _) = twin(&prepared);
        for ray in 0..4 {
            let what = format!("{sampler}, ray {ray} of 4, seed 52");
            let place = |u: DVec2| (2.0 * u).fract();
            let of = |index| twin.light_numbers(id(index), 0, ray);
            let with_light = (0..SAMPLES).map(|index| {
                let u = of(index);
                let at = place(u.point);
                [at.x, at.y, to_unit(u.choice)]
            });
            statistics::accept(uniform_p_value(with_light), &format!("light, {what}"));
            let with_texel = (0..SAMPLES).map(|index| {
                let u = of(index);
                [place(u.point).x, to_unit(u.texel), to_unit(u.choice)]
            });
            statistics::accept(uniform_p_value(with_texel), &format!("texel, {what}"));
            let fixed = (0..SAMPLES).map(|index| {
                let at = place(of(index).point);
                let ahead = ray.wrapping_mul(prepared.shadow_grid().steps[0]);
                [at.x, at.y, to_unit(ahead)]
            });
            statistics::reject(
                uniform_p_value(fixed),
                &format!("always the same light, {what}"),
            );
        }
    }
}

/// Where every light has its own rays, those to two lights are independent, and each light's are as
/// well distributed as the sampler can do: a replicate's 16 samples of 4 rays put one point in each
/// of 8 × 8 cells.
#[test]
fn lights_have_rays_of_their_own() {
    for pattern in [ShadowPattern::Random, ShadowPattern::Stratified] {
        for sampler in INDEPENDENT_PAIRS {
            let mut prepared = prepared(4, pattern, LightSelection::All, sampler);
            prepared.settings.stop.spp = 32;
            let (twin, _) = twin(&prepared);
            let pairs = (0..SAMPLES).flat_map(|index| {
                (0..4).map(move |ray| {
                    [0, 1, 3].map(|light| twin.light_numbers(id(index), light, ray))
                })
            });
            let p = uniform_p_value(pairs.map(|of| of.map(|u| (2.0 * u.point.x).fract())));
            statistics::accept(p, &format!("three lights, {pattern}, {sampler}, seed 52"));
            if sampler == Sampler::Independent || pattern == ShadowPattern::Stratified {
                continue;
            }
            for light in 0..3 {
                let mut hits = [0; 64];
                for index in 0..16 {
                    for ray in 0..4 {
                        let cell =
                            (8.0 * twin.light_numbers(id(index), light, ray).point).as_uvec2();
                        hits[(8 * cell.y + cell.x) as usize] += 1;
                    }
                }
                assert_eq!(hits, [1; 64], "{sampler}, light {light}");
            }
        }
    }
}
