//! `shaders/light/environment.wesl`.

mod samples;

use crate::support::random::{Random, rounded};
use crate::support::rounding::{U, assert_all_near, assert_near};
use crate::support::shader::{Function, call, words};
use crate::support::{context, edge_points};
use direkt::low_level::reference::core::pdf::PdfDiscrete;
use direkt::low_level::reference::light::environment::{
    bilinear_texels, direction_from_map, map_from_direction, pdf_environment_cell, row_depth,
    row_height, sample_environment_cell,
};
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// Off by: the root's argument 3 U and the root 9 U, that is 10.5 U; sine and cosine 5 U; a
/// product.
const DIRECTION: f64 = 17.0 * U;

/// The angle's tangent is off by 10.5 U where it is a root (½ of it for the angle), the angle
/// itself by 10 U, of which 1/π counts; the division of at most 1 by π adds 2 U, the sum with 1
/// another.
const IMAGE: f64 = 8.0 * U;

/// Difference of two azimuths, in turns, across the image's edge.
fn turn(a: f64, b: f64) -> f64 {
    ((a - b + 0.5).rem_euclid(1.0) - 0.5).abs()
}

#[test]
fn directions_and_image_points_are_the_twins() {
    let context = context();
    let function = Function {
        imports: "import package::light::environment::{direction_from_map, map_from_direction};",
        body: "let d = direction_from_map(in_f32(0u), in_f32(1u), in_u32(2u) == 1u);
               out_vec3f(0u, d);
               out_vec2f(3u, map_from_direction(d));
               out_vec2f(5u, map_from_direction(in_vec3f(3u)));",
        inputs: 6,
        outputs: 7,
        features: &[],
    };
    let mut random = Random::new(8);
    let mut cases: Vec<(DVec2, DVec3)> = edge_points()
        .into_iter()
        .map(|u| (DVec2::new(u.x, 2.0 * u.y), random.direction()))
        .collect();
    for depth in [0.0, 1e-30, 1e-12, U, 1e-3, 1.0, 2.0 - 2.0 * U, 2.0] {
        for u in [0.0, U, 0.25, 0.5, 0.75, 1.0 - U, random.uniform()] {
            let tilt = random.magnitude(1e-15, 1e-3);
            let beside = rounded(DVec3::new(tilt, 1.0 - depth, -tilt));
            cases.push((DVec2::new(u, f64::from(depth as f32)), beside));
        }
    }
    for d in [DVec3::X, DVec3::Y, DVec3::Z] {
        cases.extend([d, -d].map(|d| (DVec2::ZERO, d)));
    }
    let cases: Vec<(DVec2, bool, DVec3)> = cases
        .into_iter()
        .flat_map(|(image, d)| [false, true].map(|south| (image, south, d)))
        .collect();
    let inputs: Vec<u32> = cases
        .iter()
        .flat_map(|(image, south, d)| {
            let mut input = words(&[image.x, image.y, 0.0, d.x, d.y, d.z]);
            input[2] = u32::from(*south);
            input
        })
        .collect();
    let answers = call(context, &function, &inputs);
    let points = answers.vec2(3).zip(answers.vec2(5));
    for (((image, south, d), there), (back, point)) in cases.iter().zip(answers.vec3(0)).zip(points)
    {
        let what = format!("{}: {image} {d}", context.adapter.name);
        let expected = direction_from_map(image.x, image.y, *south);
        assert_all_near(there, expected, DIRECTION, &what);
        for (point, expected) in [
            (point, map_from_direction(*d)),
            (back, map_from_direction(there)),
        ] {
            let in_range = point.min_element() >= 0.0 && point.max_element() <= 1.0;
            assert!(in_range, "{what}: {point}");
            assert_near(point.y, expected.y, IMAGE, &what);
            assert!(turn(point.x, expected.x) <= IMAGE, "{what}: {point}");
        }
        // The azimuth survives at any distance from the pole: x and z have its relative error.
        let at_pole = there.x == 0.0 && there.z == 0.0;
        assert!(
            at_pole || turn(back.x, image.x) <= IMAGE + 6.0 * U / TAU,
            "{what}: comes back as {back}"
        );
    }
}

/// Sizes of maps.
const HEIGHTS: [u32; 8] = [1, 2, 3, 8, 17, 1000, 3000, 4096];

/// Relative: a division (5 U) and a sine (5 U on [0, π/4]), squared, and two products.
const ROW_DEPTH: f64 = 22.0 * U;

/// Relative: a division (5 U) and a sine (5 U on [0, π/4]; beyond, 4 U over √½) twice, and two
/// products.
const ROW_HEIGHT: f64 = 23.0 * U;

/// Every row of small maps, and the rows at the poles and the equator of large ones.
fn rows() -> Vec<(u32, u32)> {
    let of = |h: u32| {
        (0..h)
            .filter(move |&r| r < 8 || r + 8 >= h || r.abs_diff(h / 2) < 4)
            .map(move |r| (r, h))
    };
    HEIGHTS.into_iter().flat_map(of).collect()
}

/// A cell's density times its solid angle is its probability: the integral of the density over the
/// cell.
#[test]
fn rows_and_densities_are_the_twins() {
    let context = context();
    let function = Function {
        imports:
            "import package::light::environment::{pdf_environment_cell, row_depth, row_height};
                  import package::core::pdf::PdfDiscrete;",
        body: "let size = vec2u(2u * in_u32(1u), in_u32(1u));
               out_f32(0u, row_depth(in_u32(0u) / 2u, in_u32(1u)));
               out_f32(1u, row_height(in_u32(0u), in_u32(1u)));
               out_f32(2u, pdf_environment_cell(PdfDiscrete(0.375), in_u32(0u), size).value);",
        inputs: 2,
        outputs: 3,
        features: &[],
    };
    let rows = rows();
    let inputs: Vec<u32> = rows.iter().flat_map(|&(r, h)| [r, h]).collect();
    let answers = call(context, &function, &inputs);
    let values = answers.vec2(0).zip(answers.f64(2));
    for (&(row, height), (of_row, pdf)) in rows.iter().zip(values) {
        let what = format!("{}: row {row} of {height}", context.adapter.name);
        let dz = row_height(row, height);
        // Depths are called for on the northern half.
        let depth = row_depth(row / 2, height);
        assert_near(of_row.x, depth, ROW_DEPTH * depth, &what);
        assert_near(of_row.y, dz, ROW_HEIGHT * dz, &what);
        // Three products and a quotient.
        let relative = ROW_HEIGHT + 8.0 * U;
        let grid = [2 * height, height];
        let expected = pdf_environment_cell(PdfDiscrete(0.375), row, grid).0;
        assert_near(pdf, expected, relative * expected, &what);
        let solid_angle = TAU / f64::from(grid[0]) * dz;
        assert_near(pdf * solid_angle, 0.375, relative * 0.375, &what);
    }
}

/// Relative: of the depth in z, which is a sum of positive terms. The difference 1 − u is exact.
const DEPTH: f64 = ROW_HEIGHT + 2.0 * U;

/// Fails unless `d` is `u`'s direction in `cell`.
fn assert_in_cell(d: DVec3, cell: [u32; 2], grid: [u32; 2], u: DVec2, what: &str) {
    let expected = sample_environment_cell(cell, grid, u);
    let depth = 1.0 - expected.y.abs();
    // The middle row of few may reach across the equator: there the depth is up to 2.
    let reach = if grid[1] < 4 { 2.0 } else { depth + U };
    assert_near(d.y, expected.y, DEPTH * reach + U, what);
    // r² = depth (2 − depth), with the root's and the sines' error (DIRECTION) twice: at a pole
    // relative, too.
    let (r, expected_r) = (d.x.hypot(d.z), expected.x.hypot(expected.z));
    let squared = expected_r * expected_r;
    let off = (2.0 * DEPTH + 2.0 * DIRECTION) * if grid[1] < 4 { 2.0 } else { squared };
    assert_near(r * r, squared, off, what);
    // The column is a sum and a quotient (6 U of a turn), sine and cosine are off by 5 U each and a
    // product.
    let across = d.x * expected.z - d.z * expected.x;
    let off_azimuth = (6.0 * TAU + 12.0) * U;
    assert!(
        across.abs() <= off_azimuth * r * expected_r,
        "{what}: {d}, not {expected}"
    );
}

#[test]
fn environment_cell_samples_are_the_twins() {
    let context = context();
    let function = Function {
        imports: "import package::light::environment::sample_environment_cell;",
        body: "let cell = vec2u(in_u32(0u), in_u32(1u));
               let grid = vec2u(in_u32(2u), in_u32(3u));
               out_vec3f(0u, sample_environment_cell(cell, grid, in_vec2f(4u)));",
        inputs: 6,
        outputs: 3,
        features: &[],
    };
    let points: Vec<DVec2> = edge_points().into_iter().take(128).collect();
    let mut cases = Vec::new();
    for (row, height) in rows() {
        let width = 2 * height;
        for (i, u) in points.iter().enumerate() {
            let column = [0, width / 3, width - 1][i % 3];
            cases.push(([column, row], [width, height], *u));
        }
    }
    let inputs: Vec<u32> = cases
        .iter()
        .flat_map(|(cell, grid, u)| {
            [cell[0], cell[1], grid[0], grid[1]]
                .into_iter()
                .chain(words(&u.to_array()))
        })
        .collect();
    let answers = call(context, &function, &inputs);
    for ((cell, grid, u), d) in cases.iter().zip(answers.vec3(0)) {
        let what = format!("{}: {u} in {cell:?} of {grid:?}", context.adapter.name);
        assert_in_cell(d, *cell, *grid, *u, &what);
    }
}

/// A position less ½ is exact from ½ on, and below rounded by 2⁻²⁶ at most: the texels are the
/// twin's, the blend is off by one more rounding.
#[test]
fn bilinear_texels_are_the_twins() {
    let context = context();
    let function = Function {
        imports: "import package::light::environment::bilinear_texels;",
        body: "let n = bilinear_texels(in_vec2f(0u), vec2u(in_u32(2u), in_u32(3u)));
               out_u32(0u, n.left);
               out_u32(1u, n.right);
               out_u32(2u, n.top);
               out_u32(3u, n.bottom);
               out_vec2f(4u, n.blend);",
        inputs: 4,
        outputs: 6,
        features: &[],
    };
    let mut random = Random::new(10);
    let mut cases = Vec::new();
    for size in [[1, 1], [2, 1], [5, 3], [8192, 4096]] {
        let limit = size.map(f64::from);
        for _ in 0..1000 {
            cases.push((size, limit.map(|x| random.between(0.0, x))));
        }
        for x in [0.0, 1e-20, 0.25, 0.5 - 0.5 * U, 0.5, 0.5 + U] {
            cases.push((size, [x, limit[1] - x].map(|x| f64::from(x as f32))));
            cases.push((size, [limit[0] - x, x].map(|x| f64::from(x as f32))));
        }
    }
    let inputs: Vec<u32> = cases
        .iter()
        .flat_map(|(size, at)| words(at).into_iter().chain(*size))
        .collect();
    let answers = call(context, &function, &inputs);
    for (i, (size, at)) in cases.iter().enumerate() {
        let what = format!("{}: {at:?} of {size:?}", context.adapter.name);
        let expected = bilinear_texels(DVec2::from(*at), *size);
        let texels = [0, 1, 2, 3].map(|word| answers.u32(word).nth(i));
        let expected_texels = [expected.left, expected.right, expected.top, expected.bottom];
        assert_eq!(texels, expected_texels.map(Some), "{what}");
        let blend = answers.vec2(4).nth(i).unwrap();
        assert!(
            (blend - expected.blend).abs().max_element() <= U,
            "{what}: {blend}"
        );
        assert!(blend.min_element() >= 0.0 && blend.max_element() <= 1.0);
    }
}
