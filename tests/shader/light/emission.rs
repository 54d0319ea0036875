//! `shaders/light/emission.wesl`: points on lights in proportion to what they emit.

use crate::support::random::Random;
use crate::support::rounding::{U, close};
use crate::support::shader::{Function, call_in};
use crate::support::{context, emitter, floor_pixel, prepared_for, statistics, unit_square};
use direkt::low_level::accel::PrimitiveGeometry;
use direkt::low_level::emitters::{EmissionMap, Emitter};
use direkt::low_level::prepare::Prepared;
use direkt::low_level::reference::BrokenTwin;
use direkt::low_level::reference::light::emission::{
    emission_cell_margin, emission_factor, emission_map, invert_light_area, pdf_emission,
    sample_emission,
};
use direkt::low_level::reference::scene::fetch::World;
use direkt::low_level::stats::chi2::{Totals, chi2_test};
use direkt::scene::environment::Interpolation;
use direkt::scene::{
    Geometry, LightSelection, Mesh, Scene, Strategy, Texels, Texture, TextureId, TextureUse, Wrap,
};
use glam::{DAffine2, DVec2, DVec3};
use half::f16;

/// 5 × 3 texels between 0 and 8, one of them black.
fn texture() -> Texture {
    let mut random = Random::new(91);
    let mut texel = |i| {
        let mut channel = || f16::from_f64(random.between(0.05, 8.0));
        let rgb = [channel(), channel(), channel()];
        let [r, g, b] = if i == 7 { [f16::ZERO; 3] } else { rgb };
        [r, g, b, f16::ONE]
    };
    Texture {
        source: "texels".to_owned(),
        width: 5,
        height: 3,
        texels: Texels::Halves((0..15).map(&mut texel).collect()),
    }
}

fn triangle() -> Geometry {
    Geometry::Mesh(Mesh {
        positions: vec![
            DVec3::new(-0.5, 1.0, 1.5),
            DVec3::new(0.5, 2.0, 1.25),
            DVec3::new(0.75, 1.0, 1.5),
        ],
        triangles: vec![[0, 1, 2]],
        normals: Vec::new(),
        uvs: vec![
            DVec2::new(0.0, 0.25),
            DVec2::new(1.5, 0.0),
            DVec2::new(0.75, 1.0),
        ],
        ..Mesh::default()
    })
}

/// A rectangle, a disk and a triangle that emit the same image.
fn scene(interpolation: Interpolation) -> Scene {
    let mut scene = floor_pixel();
    scene.textures.push(texture());
    let disk = Geometry::Disk {
        center: DVec3::new(0.0, -2.0, 1.0),
        u: DVec3::new(0.0, 0.5, 0.0),
        v: DVec3::new(0.75, 0.0, 0.0),
    };
    for geometry in [unit_square(), disk, triangle()] {
        let mut light = emitter(geometry, 2.0, false);
        light.emission.as_mut().unwrap().texture = Some(TextureUse {
            texture: TextureId(0),
            transform: DAffine2::IDENTITY,
            wrap: [Wrap::Mirror; 2],
            interpolation,
            second_uvs: false,
        });
        scene.shapes.push(light);
    }
    scene
}

fn prepared(interpolation: Interpolation) -> Prepared {
    prepared_for(
        scene(interpolation),
        Strategy::MisPower,
        LightSelection::Power,
    )
}

fn lights(prepared: &Prepared) -> std::ops::Range<u32> {
    assert_eq!(prepared.emitters.maps.len(), 3);
    0..prepared.emitters.lights.len() as u32
}

/// The emission map and the geometry of a light.
fn textured<'a>(world: &World<'a>, light: u32) -> (&'a EmissionMap, &'a PrimitiveGeometry) {
    let Emitter::Area { primitive, .. } = world.prepared.emitters.lights[light as usize] else {
        unreachable!("all lights have surfaces");
    };
    let geometry = &world.prepared.data.primitives[primitive as usize].geometry;
    (emission_map(world, light).unwrap(), geometry)
}

const FUNCTION: Function<'_> = Function {
    imports: "import package::light::area_light::sample_light_area;
              import package::light::emission::{emission_factor, emission_word, fetch_emission_map,
                  invert_light_area, pdf_emission, sample_emission};
              import package::scene::fetch::fetch_light;",
    body: "let light = fetch_light(in_u32(0u));
           let m = fetch_emission_map(emission_word(in_u32(0u)));
           let s = sample_emission(m, in_vec2f(1u), in_u32(3u));
           let st = sample_light_area(light, s.u);
           out_vec2f(0u, s.u);
           out_f32(2u, s.pdf.value);
           out_vec2f(3u, st);
           out_f32(5u, pdf_emission(m, invert_light_area(light.kind, st)).value);
           out_vec3f(6u, emission_factor(m, st));",
    inputs: 4,
    outputs: 9,
    features: &[],
};

fn inputs(light: u32, count: usize, seed: u32) -> (Vec<(DVec2, u32)>, Vec<u32>) {
    let mut random = Random::new(seed);
    let numbers: Vec<(DVec2, u32)> = (0..count)
        .map(|_| {
            (
                DVec2::new(random.uniform(), random.uniform()),
                random.word(),
            )
        })
        .collect();
    let words = numbers.iter().flat_map(|(u, word)| {
        let [x, y] = u.as_vec2().to_array().map(f32::to_bits);
        [light, x, y, *word]
    });
    let words = words.collect();
    (numbers, words)
}

/// A point of the square is divided and mapped with a few roundings, the disk's inverse with those
/// of an arcus tangent; a texture's value changes by no more than 40 from there.
#[test]
fn emission_samples_are_the_twins() {
    let context = context();
    for interpolation in [Interpolation::Linear, Interpolation::Nearest] {
        let prepared = prepared(interpolation);
        let world = World::new(&prepared);
        for light in lights(&prepared) {
            let (map, geometry) = textured(&world, light);
            let (numbers, words) = inputs(light, 20_000, 92 + light);
            let answers = call_in(context, &prepared, &FUNCTION, &words, numbers.len());
            let found = answers.vec2(0).zip(answers.f64(2)).zip(answers.vec2(3));
            let found = found.zip(answers.f64(5)).zip(answers.vec3(6));
            let mut inside = 0;
            for ((u, word), ((((on_square, pdf), st), evaluated), factor)) in
                numbers.iter().zip(found)
            {
                let u = u.as_vec2().as_dvec2();
                let (twins, density) = sample_emission(map, u, *word);
                assert!(
                    on_square.distance(twins) < 4.0 * U,
                    "{u}: {on_square}, not {twins}"
                );
                assert!(close(pdf, density.0, 4.0), "{u}: {pdf}, not {}", density.0);
                let back = invert_light_area(geometry, st);
                let off_edge = emission_cell_margin(map, back) > 2e-6;
                assert!(back.distance(twins) < 1.2e-6, "{st} is {back}, not {twins}");
                if off_edge {
                    inside += 1;
                    assert_eq!(evaluated, pdf, "{st}");
                    assert!(close(pdf_emission(map, back).0, pdf, 4.0), "{st}");
                }
                let expected = emission_factor(&world, map, st);
                let error = (factor - expected).abs().max_element();
                let on_edge = interpolation == Interpolation::Nearest && !off_edge;
                assert!(
                    error < 40.0 * 16.0 * U || on_edge,
                    "{st}: {factor}, not {expected}"
                );
            }
            assert!(inside > 19_900, "{inside} samples lie within cells");
        }
    }
}

/// Every cell of the grid, divided into 3 × 3.
fn expected(map: &EmissionMap, pdf: impl Fn(DVec2) -> f64) -> Vec<f64> {
    let fine = map.grid.map(|n| 3 * n);
    let size = DVec2::new(fine[0].into(), fine[1].into());
    let cells = (0..fine[0] * fine[1]).map(|cell| {
        let middle = DVec2::new((cell % fine[0]).into(), (cell / fine[0]).into()) + 0.5;
        pdf(middle / size) / (size.x * size.y)
    });
    cells.collect()
}

#[test]
fn emission_samples_follow_their_density() {
    const DRAWN: usize = 1 << 20;
    let context = context();
    let prepared = prepared(Interpolation::Linear);
    let world = World::new(&prepared);
    for light in lights(&prepared) {
        let map = emission_map(&world, light).unwrap();
        let fine = map.grid.map(|n| 3 * n);
        let mut observed = vec![0; (fine[0] * fine[1]) as usize];
        for part in 0..4 {
            let (numbers, words) = inputs(light, DRAWN / 4, 95 + 4 * light + part);
            let answers = call_in(context, &prepared, &FUNCTION, &words, numbers.len());
            for u in answers.vec2(0) {
                let cell = |x: f64, n: u32| ((x * f64::from(n)) as u32).min(n - 1);
                observed[(cell(u.y, fine[1]) * fine[0] + cell(u.x, fine[0])) as usize] += 1;
            }
        }
        let p_value = |pdf: &dyn Fn(DVec2) -> f64| {
            let expected: Vec<f64> = expected(map, pdf)
                .iter()
                .map(|p| p * DRAWN as f64)
                .collect();
            chi2_test(&observed, &expected, Totals::Free)
                .unwrap()
                .p_value
        };
        let pdf = |u: DVec2| pdf_emission(map, u).0;
        let what = format!("emission of light {light}, {}", context.adapter.name);
        statistics::accept(p_value(&pdf), &what);
        statistics::reject_broken(&what, |twin| match twin {
            BrokenTwin::PdfScaled => Some(p_value(&|u| 1.02 * pdf(u))),
            // As if every cell were as likely as any other.
            BrokenTwin::WrongMeasure => Some(p_value(&|_| 1.0)),
            _ => None,
        });
        let total: f64 = expected(map, pdf).iter().sum();
        assert!((total - 1.0).abs() < 1e-9, "integrates to {total}");
    }
}

/// What is dark is never chosen, and what shines always can be: the estimator divides by the
/// density.
#[test]
fn points_that_shine_have_a_density() {
    for interpolation in [Interpolation::Linear, Interpolation::Nearest] {
        let prepared = prepared(interpolation);
        let world = World::new(&prepared);
        for light in lights(&prepared) {
            let (map, geometry) = textured(&world, light);
            let mut random = Random::new(99);
            for _ in 0..100_000 {
                let (a, b) = (random.uniform(), random.uniform());
                let st = DVec2::new(a, b * (1.0 - a));
                let shines = emission_factor(&world, map, st).max_element() > 0.0;
                let density = pdf_emission(map, invert_light_area(geometry, st)).0;
                assert!(density > 0.0 || !shines, "{st} of light {light}");
            }
        }
    }
}
