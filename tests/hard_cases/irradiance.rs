//! What lights of 10⁻¹³ sr to nearly 2π shine on a surface: HARD CASES S3, S4, S5.

use super::solid_angles::{Edges, numbers, relative, right_triangle};
use super::worst;
use crate::support::context;
use crate::support::hard_cases::{Measured, survive};
use crate::support::shader::{Function, call, words};
use direkt::low_level::gpu::Context;
use direkt::low_level::reference::exact::polygon::polygon_factor;
use direkt::low_level::reference::exact::sphere::sphere_factor;
use glam::DVec3;
use std::f64::consts::PI;

/// Points of the unit square, the middles of a grid.
const GRID: u32 = 128;

/// Per case the irradiance over radiance at the origin, normal +z, by direkt's light sampling and
/// by `textbook`: an expression of `u` (the point of the unit square) for one sample of `light`.
fn irradiance(
    context: &Context,
    (kind, features): (&str, &[&'static str]),
    (imports, textbook): (&str, &str),
    cases: &[(Edges, f64)],
) -> [Vec<f64>; 2] {
    let imports = format!(
        "import package::core::constants::TWO_PI;
         import package::core::frame::frame_from_normal;
         import package::core::pdf::ExpectedSamples;
         import package::light::area_light::sample_area_light;
         import package::scene::fetch::{{LIGHT_RECTANGLE, LIGHT_SPHERE, LIGHT_TRIANGLE, Light}};
         {imports}"
    );
    let body = format!(
        "let light = Light(in_vec3f(0u), {kind}, {kind} != LIGHT_SPHERE, false, in_vec3f(3u), ExpectedSamples(1.0), in_vec3f(6u), in_f32(9u), vec3f(1.0));
         let u = in_vec2f(10u);
         let s = sample_area_light(
             light, ExpectedSamples(1.0), vec3f(0.0), frame_from_normal(vec3f(0.0, 0.0, 1.0)), u);
         out_f32(0u, s.radiance_over_pdf.x * max(s.wi.z, 0.0));
         out_f32(1u, {textbook});"
    );
    let function = Function {
        imports: &imports,
        body: &body,
        inputs: 12,
        outputs: 2,
        features,
    };
    let middle = |i: u32| (f64::from(i) + 0.5) / f64::from(GRID);
    let points = (0..GRID * GRID).map(|i| [middle(i % GRID), middle(i / GRID)]);
    let points: Vec<[f64; 2]> = points.collect();
    let inputs: Vec<f64> = cases
        .iter()
        .flat_map(|(edges, area)| points.iter().map(move |u| (edges, area, u)))
        .flat_map(|(edges, area, u)| numbers(edges).into_iter().chain([*area, u[0], u[1]]))
        .collect();
    let answers = call(context, &function, &words(&inputs));
    [0, 1].map(|word| {
        let samples: Vec<f64> = answers.f64(word).collect();
        let cases = samples.chunks_exact(points.len());
        cases
            .map(|c| c.iter().sum::<f64>() / points.len() as f64)
            .collect()
    })
}

fn planar(edges: Edges, triangle: bool) -> (Edges, f64) {
    let area = edges[1].cross(edges[2]).length();
    (edges, if triangle { 0.5 * area } else { area })
}

fn survive_irradiance(
    context: &Context,
    [ours, naive]: [Vec<f64>; 2],
    exact: &[f64],
    (entry, case, textbook): (&str, &str, &str),
) {
    let off = |found: Vec<f64>| {
        let pairs = found.into_iter().zip(exact);
        worst(pairs.map(|(found, exact)| relative(found, PI * exact)))
    };
    survive(
        context,
        Measured {
            entry,
            case,
            figure: "relative error of the irradiance",
            bound: 5e-4,
            textbook,
            naive: off(naive),
            ours: off(ours),
        },
    );
}

/// Near and far of where direkt changes to area sampling (10⁻⁵ sr: a height of 224), and a sliver.
#[test]
fn triangles_of_every_size_shine_as_brightly_as_they_should() {
    let context = context();
    let heights = [1e-3, 1.0, 100.0, 220.0, 228.0, 1e4, 1e6];
    let sliver = [
        DVec3::new(0.3, 0.2, 1.0),
        DVec3::X,
        DVec3::new(0.5, 1e-6, 0.0),
    ];
    let shapes = heights.map(right_triangle).into_iter().chain([sliver]);
    let cases: Vec<_> = shapes.map(|edges| planar(edges, true)).collect();
    let exact = |&([a, u, v], _): &(Edges, f64)| {
        polygon_factor(DVec3::ZERO, DVec3::Z, &[a, a + u, a + v]).abs()
    };
    let imports = "fn angle_at(a: vec3f, b: vec3f, c: vec3f) -> f32 {
            return acos(clamp(dot(normalize(cross(a, b)), normalize(cross(a, c))), -1.0, 1.0));
        }
        fn by_angles(a: vec3f, b: vec3f, c: vec3f, z: f32) -> f32 {
            return z * (angle_at(a, b, c) + angle_at(b, c, a) + angle_at(c, a, b) - 3.14159265);
        }";
    let textbook = "by_angles(light.a, light.a + light.u, light.a + light.v, s.wi.z)";
    let found = irradiance(
        context,
        (
            "LIGHT_TRIANGLE",
            &["LIGHT_PLANAR", "LIGHT_TRIANGLES", "LIGHT_SOLID_ANGLE"],
        ),
        (imports, textbook),
        &cases,
    );
    let exact: Vec<f64> = cases.iter().map(exact).collect();
    let case = "triangles at heights of 10⁻³ to 10⁶, and a sliver";
    let textbook = "density from the sum of three angles less π";
    survive_irradiance(context, found, &exact, ("S3", case, textbook));
}

/// A light of 0.95·10⁻³ sr, tilted by 80°, for a receiver that it grazes by 5°: what pbrt-v4's
/// `SampleSphericalRectangle` does below 10⁻³ sr. And one on either side of 10⁻⁵ sr, where direkt
/// changes.
#[test]
fn small_squares_at_grazing_angles_shine_as_brightly_as_they_should() {
    let context = context();
    let degree = |d: f64| d.to_radians().sin_cos();
    let ((sin, cos), (sin_tilt, cos_tilt)) = (degree(85.0), degree(80.0));
    let towards = DVec3::new(sin, 0.0, cos);
    let upwards = DVec3::new(-cos, 0.0, sin);
    let tilted = cos_tilt * upwards + sin_tilt * towards;
    let square = |solid_angle: f64| {
        let side = (solid_angle / cos_tilt).sqrt();
        let (u, v) = (side * DVec3::Y, side * tilted);
        let round = |v: DVec3| v.as_vec3().as_dvec3();
        planar([towards - 0.5 * (u + v), u, v].map(round), false)
    };
    let cases = [0.95e-3, 1.05e-5, 0.95e-5].map(square);
    let found = irradiance(
        context,
        ("LIGHT_RECTANGLE", &["LIGHT_PLANAR", "LIGHT_SOLID_ANGLE"]),
        (
            "import package::light::rectangle::spherical_rectangle;",
            "normalize(light.a + u.x * light.u + u.y * light.v).z
                * spherical_rectangle(vec3f(0.0), light.a, light.u, light.v).solid_angle",
        ),
        &cases,
    );
    let exact = cases.map(|([a, u, v], _)| {
        polygon_factor(DVec3::ZERO, DVec3::Z, &[a, a + u, a + u + v, a + v]).abs()
    });
    let case = "a square of 0.95·10⁻³ sr, tilted by 80°, 5° above the horizon";
    let textbook = "points of its area with density 1/Ω";
    survive_irradiance(context, found, &exact, ("S4", case, textbook));
}

/// On either side of where direkt changes to area sampling: 10⁻⁵ sr is a distance of 560 radii.
#[test]
fn spheres_of_every_size_shine_as_brightly_as_they_should() {
    let context = context();
    let distances = [2.0, 100.0, 550.0, 570.0, 1e3, 1e5];
    let cases = distances.map(|d| ([d * DVec3::Z, DVec3::X, DVec3::ZERO], 4.0 * PI));
    let textbook = "s.wi.z * TWO_PI * (1.0 - sqrt(1.0 - 1.0 / dot(light.a, light.a)))";
    let found = irradiance(
        context,
        ("LIGHT_SPHERE", &["LIGHT_SPHERES", "LIGHT_SOLID_ANGLE"]),
        ("", textbook),
        &cases,
    );
    let exact = distances.map(|d| sphere_factor(DVec3::ZERO, DVec3::Z, d * DVec3::Z, 1.0));
    let case = "spheres at distances of 2 to 10⁵ radii";
    let textbook = "density 1/(2π(1 − √(1 − s²)))";
    survive_irradiance(context, found, &exact, ("S5", case, textbook));
}
