//! Lights of 10⁻¹³ sr to nearly 2π, and what they shine on a surface: HARD CASES S3, S4, S5.

use super::worst;
use crate::support::context;
use crate::support::hard_cases::{Measured, survive};
use crate::support::random::Random;
use crate::support::shader::{Answers, Function, call, words};
use direkt::gpu::Context;
use direkt::reference::exact::polygon::polygon_factor;
use direkt::reference::exact::solid_angle::polygon_solid_angle;
use direkt::reference::exact::sphere::sphere_factor;
use glam::{DMat3, DVec3};
use std::f64::consts::PI;

/// A point a and the edges u and v from it, seen from the origin.
type Edges = [DVec3; 3];

fn numbers(edges: &Edges) -> [f64; 9] {
    std::array::from_fn(|i| edges[i / 3][i % 3])
}

fn relative(found: f64, exact: f64) -> f64 {
    (found / exact - 1.0).abs()
}

/// Solid angles by direkt, by the sum of the angles less π, and by Van Oosterom and Strackee's formula as printed.
const OF_TRIANGLE: Function<'_> = Function {
    imports: "import package::light::triangle::spherical_triangle;
        fn angle_at(a: vec3f, b: vec3f, c: vec3f) -> f32 {
            return acos(clamp(dot(normalize(cross(a, b)), normalize(cross(a, c))), -1.0, 1.0));
        }
        fn girard(a: vec3f, b: vec3f, c: vec3f) -> f32 {
            return angle_at(a, b, c) + angle_at(b, c, a) + angle_at(c, a, b) - 3.14159265;
        }
        fn van_oosterom(a: vec3f, b: vec3f, c: vec3f) -> f32 {
            return 2.0 * atan2(abs(dot(a, cross(b, c))), 1.0 + dot(a, b) + dot(a, c) + dot(b, c));
        }",
    body: "let a = in_vec3f(0u); let u = in_vec3f(3u); let v = in_vec3f(6u);
           out_f32(0u, spherical_triangle(vec3f(0.0), a, u, v).solid_angle);
           out_f32(1u, girard(normalize(a), normalize(a + u), normalize(a + v)));
           out_f32(2u, van_oosterom(normalize(a), normalize(a + u), normalize(a + v)));",
    inputs: 9,
    outputs: 3,
    features: &[],
};

fn solid_angles(context: &Context, function: &Function<'_>, cases: &[Edges]) -> Answers {
    let inputs: Vec<f64> = cases.iter().flat_map(numbers).collect();
    call(context, function, &words(&inputs))
}

/// 300 rotations of a right triangle with legs of 1 at this distance. Coordinates are multiples of 2⁻¹⁰, so that vertices
/// and edges are exact in f32.
fn turned_triangles(distance: f64) -> Vec<Edges> {
    let mut random = Random::new(300);
    let exact = |v: DVec3| (v * 1024.0).round() / 1024.0;
    let turned = |_| {
        let axis = random.direction().normalize();
        let r = DMat3::from_axis_angle(axis, random.between(0.0, 6.0));
        [DVec3::Z * distance, DVec3::X, DVec3::Y].map(|v| exact(r * v))
    };
    (0..300).map(turned).collect()
}

#[test]
fn small_triangles_keep_their_solid_angle() {
    let context = context();
    for (distance, word, textbook) in [
        (10.0, 1, "sum of three angles less π (Girard)"),
        (100.0, 1, "sum of three angles less π (Girard)"),
        (1000.0, 2, "Van Oosterom & Strackee, unit vectors"),
    ] {
        let cases = turned_triangles(distance);
        let answers = solid_angles(&context, &OF_TRIANGLE, &cases);
        let off = |word| {
            let found = answers.f64(word).zip(&cases);
            worst(found.map(|(found, &[a, u, v])| {
                relative(
                    found,
                    polygon_solid_angle(DVec3::ZERO, &[a, a + u, a + v]).abs(),
                )
            }))
        };
        survive(
            &context,
            Measured {
                entry: "S3",
                case: &format!(
                    "a triangle with legs of 1 at a distance of {distance}, turned 300 times"
                ),
                figure: "relative error of the solid angle",
                bound: 1e-5,
                textbook,
                naive: off(word),
                ours: off(0),
            },
        );
    }
}

/// A right triangle with legs of 1 whose vertex is at this height.
fn right_triangle(height: f64) -> Edges {
    [DVec3::Z * height, DVec3::X, DVec3::Y]
}

#[test]
fn triangles_of_every_size_have_the_exact_solid_angle() {
    let context = context();
    let half = 0.75_f64.sqrt();
    let equilateral = [
        DVec3::new(1.0, 0.0, 1e-3),
        DVec3::new(-1.5, half, 0.0),
        DVec3::new(-1.5, -half, 0.0),
    ];
    let sliver = [DVec3::Z, DVec3::X, DVec3::new(0.5, 1e-6, 0.0)];
    let octant = [
        DVec3::X,
        DVec3::new(-1.0, 1.0, 0.0),
        DVec3::new(-1.0, 0.0, 1.0),
    ];
    let cases = [
        (octant, 1.570_796_326_794_9),
        (right_triangle(1.0), 0.339_836_909_454_122),
        (right_triangle(10.0), 0.004_975_144_902_270_54),
        (right_triangle(100.0), 4.999_750_014_582_4e-5),
        (right_triangle(1e3), 4.999_997_500_001_46e-7),
        (right_triangle(1e4), 4.999_999_975e-9),
        (right_triangle(1e6), 4.999_999_999_997_5e-13),
        // ½/z² up to 10⁻¹³ of it.
        (right_triangle(2_236_068.0), 0.5 / 2_236_068_f64.powi(2)),
        (equilateral, 6.272_793_017_922_59),
        (sliver, 3.562_911_697_465_38e-7),
    ];
    let answers = solid_angles(&context, &OF_TRIANGLE, &cases.map(|c| c.0));
    let off = |word| {
        let found = answers.f64(word).zip(&cases);
        worst(found.map(|(found, (_, exact))| relative(found, *exact)))
    };
    survive(
        &context,
        Measured {
            entry: "S3",
            case: "triangles of 10⁻¹³ sr to 6.2728 sr, one of them a sliver",
            figure: "relative error of the solid angle",
            bound: 1e-5,
            textbook: "sum of three angles less π (Girard)",
            naive: off(1),
            ours: off(0),
        },
    );
}

#[test]
fn squares_of_every_size_have_the_exact_solid_angle() {
    let context = context();
    // Ureña et al. 2013: four arc cosines of products of the sides' normals.
    let function = Function {
        imports: "import package::light::rectangle::spherical_rectangle;
            fn four_angles(a: vec3f, u: vec3f, v: vec3f) -> f32 {
                let n0 = normalize(cross(a, a + u));
                let n1 = normalize(cross(a + u, a + u + v));
                let n2 = normalize(cross(a + u + v, a + v));
                let n3 = normalize(cross(a + v, a));
                return acos(-dot(n0, n1)) + acos(-dot(n1, n2)) + acos(-dot(n2, n3)) + acos(-dot(n3, n0))
                    - 6.28318531;
            }",
        body: "let a = in_vec3f(0u); let u = in_vec3f(3u); let v = in_vec3f(6u);
               out_f32(0u, spherical_rectangle(vec3f(0.0), a, u, v).solid_angle);
               out_f32(1u, four_angles(a, u, v));",
        inputs: 9,
        outputs: 2,
        features: &[],
    };
    let cases = [
        (0.01, 6.170_067_073_507_11),
        (1.0, 0.805_431_683_161_323),
        (100.0, 9.999_750_007_291_43e-5),
        (1e4, 9.999_999_975e-9),
    ];
    let squares = cases.map(|(z, _)| [DVec3::new(-0.5, -0.5, z), DVec3::X, DVec3::Y]);
    let answers = solid_angles(&context, &function, &squares);
    let off = |word| {
        let found = answers.f64(word).zip(cases);
        worst(found.map(|(found, (_, exact))| relative(found, exact)))
    };
    survive(
        &context,
        Measured {
            entry: "S4",
            case: "a unit square at distances of 10⁻² to 10⁴",
            figure: "relative error of the solid angle",
            bound: 1e-5,
            textbook: "sum of four angles less 2π",
            naive: off(1),
            ours: off(0),
        },
    );
}

#[test]
fn cones_of_far_spheres_keep_their_solid_angle() {
    let context = context();
    let function = Function {
        imports: "import package::light::sphere::cone_height;",
        body: "out_f32(0u, 6.28318531 * cone_height(in_f32(0u)));
               out_f32(1u, 6.28318531 * (1.0 - sqrt(1.0 - in_f32(0u))));",
        inputs: 1,
        outputs: 2,
        features: &[],
    };
    let cases = [
        (1e-1_f64, 0.031_494_861_522_999_1),
        (1e-2, 0.000_314_167_119_733_337),
        (1e-3, 3.141_593_438_988_35e-6),
        (1e-4, 3.141_592_661_443_77e-8),
        (1e-6, 3.141_592_653_590_58e-12),
    ];
    let answers = call(&context, &function, &words(&cases.map(|(s, _)| s * s)));
    let off = |word| {
        let found = answers.f64(word).zip(cases);
        worst(found.map(|(found, (_, exact))| relative(found, exact)))
    };
    survive(
        &context,
        Measured {
            entry: "S5",
            case: "spheres at distances of 10 to 10⁶ radii",
            figure: "relative error of the solid angle",
            bound: 1e-6,
            textbook: "2π(1 − √(1 − s²))",
            naive: off(1),
            ours: off(0),
        },
    );
}

/// Points of the unit square, the middles of a grid.
const GRID: u32 = 128;

/// Per case the irradiance over radiance at the origin, normal +z, by direkt's light sampling and by `textbook`: an
/// expression of `u` (the point of the unit square) for one sample of `light`.
fn irradiance(
    context: &Context,
    (kind, features): (&str, &[&'static str]),
    (imports, textbook): (&str, &str),
    cases: &[(Edges, f64)],
) -> [Vec<f64>; 2] {
    let imports = format!(
        "import package::core::constants::TWO_PI;
         import package::core::frame::frame_from_normal;
         import package::core::pdf::PdfDiscrete;
         import package::light::area_light::sample_area_light;
         import package::scene::fetch::{{LIGHT_RECTANGLE, LIGHT_SPHERE, LIGHT_TRIANGLE, Light}};
         {imports}"
    );
    let body = format!(
        "let light = Light(in_vec3f(0u), {kind}, {kind} != LIGHT_SPHERE, false, in_vec3f(3u), 1.0, in_vec3f(6u), in_f32(9u), vec3f(1.0));
         let u = in_vec2f(10u);
         let s = sample_area_light(
             light, PdfDiscrete(1.0), vec3f(0.0), frame_from_normal(vec3f(0.0, 0.0, 1.0)), u);
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
    let imports = "import package::core::rng::to_unit;
        import package::light::triangle::sample_triangle_area;
        fn angle_at(a: vec3f, b: vec3f, c: vec3f) -> f32 {
            return acos(clamp(dot(normalize(cross(a, b)), normalize(cross(a, c))), -1.0, 1.0));
        }
        fn by_angles(a: vec3f, b: vec3f, c: vec3f, z: f32) -> f32 {
            return z * (angle_at(a, b, c) + angle_at(b, c, a) + angle_at(c, a, b) - 3.14159265);
        }";
    let textbook = "by_angles(light.a, light.a + light.u, light.a + light.v, s.wi.z)";
    let found = irradiance(
        &context,
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
    survive_irradiance(&context, found, &exact, ("S3", case, textbook));
}

/// A light of 0.95·10⁻³ sr, tilted by 80°, for a receiver that it grazes by 5°: what pbrt-v4's
/// `SampleSphericalRectangle` does below 10⁻³ sr. And one on either side of 10⁻⁵ sr, where direkt changes.
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
        &context,
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
    survive_irradiance(&context, found, &exact, ("S4", case, textbook));
}

/// On either side of where direkt changes to area sampling: 10⁻⁵ sr is a distance of 560 radii.
#[test]
fn spheres_of_every_size_shine_as_brightly_as_they_should() {
    let context = context();
    let distances = [2.0, 100.0, 550.0, 570.0, 1e3, 1e5];
    let cases = distances.map(|d| ([d * DVec3::Z, DVec3::X, DVec3::ZERO], 4.0 * PI));
    let textbook = "s.wi.z * TWO_PI * (1.0 - sqrt(1.0 - 1.0 / dot(light.a, light.a)))";
    let found = irradiance(
        &context,
        ("LIGHT_SPHERE", &["LIGHT_SPHERES", "LIGHT_SOLID_ANGLE"]),
        ("", textbook),
        &cases,
    );
    let exact = distances.map(|d| sphere_factor(DVec3::ZERO, DVec3::Z, d * DVec3::Z, 1.0));
    let case = "spheres at distances of 2 to 10⁵ radii";
    let textbook = "density 1/(2π(1 − √(1 − s²)))";
    survive_irradiance(&context, found, &exact, ("S5", case, textbook));
}
