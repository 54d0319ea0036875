//! Samples of environment cells and maps against their densities.

use crate::support::random::Random;
use crate::support::rounding::{U, assert_near};
use crate::support::shader::{Function, draw};
use crate::support::{context, histogram, statistics};
use direkt::low_level::emitters::{EnvironmentGrid, row_height as height_in_z};
use direkt::low_level::reference::BrokenTwin;
use direkt::low_level::reference::core::pdf::PdfDiscrete;
use direkt::low_level::reference::light::environment::pdf_environment_cell;
use direkt::low_level::stats::chi2::{Totals, chi2_test};
use direkt::scene::EnvironmentMap;
use direkt::scene::environment::Interpolation;
use glam::DVec2;
use std::f64::consts::{PI, TAU};

/// Cells at both poles and at the equator.
#[test]
fn environment_cell_samples_match_pdf() {
    let context = context();
    for (cell, grid) in [
        ([0, 0], [7, 3]),
        ([3, 1], [7, 3]),
        ([6, 2], [7, 3]),
        // So flat in z that f32 has 20 values of it there.
        ([0, 0], [4096, 2048]),
        ([1, 2047], [4096, 2048]),
    ] {
        let body = format!(
            "let u = to_unit_2d(pcg4d(vec4u(item, 16u, {}u, 17u)).xy);
             out_vec3f(0u, sample_environment_cell(vec2u({}u, {}u), vec2u({}u, {}u), u));",
            cell[1], cell[0], cell[1], grid[0], grid[1]
        );
        let function = Function {
            imports: "import package::light::environment::sample_environment_cell;
                      import package::core::rng::{pcg4d, to_unit_2d};",
            body: &body,
            inputs: 0,
            outputs: 3,
            features: &[],
        };
        // The cell in azimuth and z.
        let width = TAU / f64::from(grid[0]);
        let cosine = |row: u32| (PI * f64::from(row) / f64::from(grid[1])).cos();
        let low = DVec2::new(width * f64::from(cell[0]), cosine(cell[1] + 1));
        let high = DVec2::new(low.x + width, cosine(cell[1]));
        let samples: Vec<DVec2> = draw(context, &function, 1 << 20)
            .vec3(0)
            .map(|d| {
                let mut azimuth = (-d.x).atan2(d.z);
                // The half turn away from the cell's middle is where the angle jumps.
                azimuth += TAU * ((0.5 * (low.x + high.x) - azimuth) / TAU).round();
                // Near a pole x and z say more precisely than y how far it is.
                let squared = d.x * d.x + d.z * d.z;
                let z = if squared < 0.5 {
                    (1.0 - squared / (1.0 + (1.0 - squared).sqrt())).copysign(d.y)
                } else {
                    d.y
                };
                let p = DVec2::new(azimuth, z);
                let inside = p.clamp(low, high);
                // The depth in z, from r², is off by DEPTH + 2 DIRECTION relatively.
                let off = DVec2::new(60.0 * U, 60.0 * U * (1.0 - z.abs()) + 1e-15);
                assert!((p - inside).abs().cmple(off).all(), "{d} leaves {cell:?}");
                inside.min(DVec2::new(high.x.next_down(), high.y.next_down()))
            })
            .collect();
        let pdf = |_: DVec2| pdf_environment_cell(PdfDiscrete(1.0), cell[1], grid).0;
        let test = |pdf: &dyn Fn(DVec2) -> f64| histogram::p_value(&samples, low, high, pdf);
        let what = format!(
            "sample_environment_cell {cell:?}, seed 17, {}",
            context.adapter.name
        );
        statistics::accept(test(&pdf), &what);
        statistics::reject_broken(&what, |twin| match twin {
            BrokenTwin::PdfScaled => Some(test(&|p| 1.02 * pdf(p))),
            // Uniform on the image, that is in azimuth and polar angle.
            BrokenTwin::WrongMeasure => Some(test(&|p| {
                let polar = PI / f64::from(grid[1]);
                1.0 / (width * polar * (1.0 - p.y * p.y).max(1e-18).sqrt())
            })),
            // The others are about surfaces that reflect, and about choosing among lights and
            // strategies.
            BrokenTwin::SwappedSinCos
            | BrokenTwin::LightLeftOut
            | BrokenTwin::MisWeights
            | BrokenTwin::RaysForgotten
            | BrokenTwin::OpaqueShadows
            | BrokenTwin::ExtraCosine => None,
        });
    }
}

/// Maps of 8 × 6 texels: noise with black texels, also at the poles; one texel a million times as
/// bright as the others, at a pole and elsewhere.
fn maps() -> Vec<Vec<f32>> {
    let mut random = Random::new(9);
    let noise = (0..48)
        .map(|i| {
            if i % 5 == 0 {
                0.0
            } else {
                random.uniform() as f32
            }
        })
        .collect();
    let one = |bright: usize| {
        (0..48)
            .map(|i| if i == bright { 1e6 } else { 1.0 })
            .collect()
    };
    vec![noise, one(3), one(43), one(19)]
}

#[test]
fn environment_samples_match_luminance_and_solid_angle() {
    let context = context();
    let (width, height, n) = (8_u32, 6_u32, 1 << 20);
    for (number, texels) in maps().into_iter().enumerate() {
        let grid = EnvironmentGrid::new(&EnvironmentMap {
            source: "test".to_owned(),
            width,
            height,
            texels: texels.iter().map(|&x| [x; 3]).collect(),
            interpolation: Interpolation::Nearest,
        })
        .unwrap();
        assert_eq!(grid.size, [width, height]);
        let entries: Vec<String> = grid
            .table
            .entries
            .iter()
            .map(|e| format!("vec4u({}u, {}u, 0u, 0u)", e.threshold, e.alias))
            .collect();
        let imports = format!(
            "import package::light::alias_table::{{alias_choice, alias_entry}};
             import package::light::environment::{{map_from_direction, sample_environment_cell}};
             import package::core::rng::{{pcg4d, to_unit_2d}};
             var<private> entries: array<vec4u, 48> = array<vec4u, 48>({});",
            entries.join(", ")
        );
        let body = format!(
            "let words = pcg4d(vec4u(item, 18u, 19u, {number}u));
             let entry = alias_entry(words.z, 48u);
             let index = alias_choice(words.z, 48u, entry, entries[entry]).index;
             let cell = vec2u(index % 8u, index / 8u);
             let d = sample_environment_cell(cell, vec2u(8u, 6u), to_unit_2d(words.xy));
             out_u32(0u, index);
             out_vec2f(1u, map_from_direction(d) * vec2f(8.0, 6.0));"
        );
        let function = Function {
            imports: &imports,
            body: &body,
            inputs: 0,
            outputs: 3,
            features: &[],
        };
        let answers = draw(context, &function, n);
        let mut observed = vec![0; texels.len()];
        for (index, point) in answers.u32(0).zip(answers.vec2(1)) {
            observed[index as usize] += 1;
            // The sampled direction looks its own cell up again: the cell's corners, sampled and
            // looked up, are off by 8 and 6 times 20 U. At the pole itself there is no azimuth.
            let cell = DVec2::new(f64::from(index % width), f64::from(index / width));
            let off = (point - cell - DVec2::splat(0.5)).abs();
            if point.y == 0.0 || point.y == 6.0 {
                continue;
            }
            let slack = DVec2::new(160.0 * U, 120.0 * U);
            assert!(
                off.cmple(DVec2::splat(0.5) + slack).all(),
                "{index} at {point}"
            );
        }
        // Luminance times solid angle, from the cosines themselves.
        let cosine = |row: usize| (PI * row as f64 / f64::from(height)).cos();
        let weight = |i: usize| {
            let row = i / width as usize;
            f64::from(texels[i]) * (cosine(row) - cosine(row + 1))
        };
        let normalised = |weight: &dyn Fn(usize) -> f64| -> Vec<f64> {
            let sum: f64 = (0..texels.len()).map(weight).sum();
            (0..texels.len()).map(|i| weight(i) / sum).collect()
        };
        let test = |pmf: Vec<f64>, factor: f64| {
            let expected: Vec<f64> = pmf.iter().map(|p| factor * p * n as f64).collect();
            let result = chi2_test(&observed, &expected, Totals::Free);
            result.expect("the counts are testable").p_value
        };
        let what = format!(
            "environment map {number}, seed {number}, {}",
            context.adapter.name
        );
        statistics::accept(test(normalised(&weight), 1.0), &what);
        let brightest = (0..texels.len()).max_by(|&a, &b| weight(a).total_cmp(&weight(b)));
        statistics::reject_broken(&what, |twin| match twin {
            BrokenTwin::PdfScaled => Some(test(normalised(&weight), 1.02)),
            // In proportion to the luminance alone; where one texel has it all there is no
            // difference.
            BrokenTwin::WrongMeasure if number == 0 => {
                Some(test(normalised(&|i| f64::from(texels[i])), 1.0))
            }
            BrokenTwin::LightLeftOut => Some(test(
                normalised(&|i| if Some(i) == brightest { 0.0 } else { weight(i) }),
                1.0,
            )),
            BrokenTwin::WrongMeasure
            | BrokenTwin::SwappedSinCos
            | BrokenTwin::MisWeights
            | BrokenTwin::RaysForgotten
            | BrokenTwin::OpaqueShadows
            | BrokenTwin::ExtraCosine => None,
        });
        let total: f64 = (0..height)
            .map(|r| height_in_z(f64::from(r), f64::from(height)))
            .sum();
        assert_near(total, 2.0, 1e-14, "the rows fill the sphere");
    }
}
