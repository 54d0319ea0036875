//! Solid angles of 10⁻¹³ sr to nearly 2π: HARD CASES S3, S4, S5.

use super::worst;
use crate::support::context;
use crate::support::hard_cases::{Measured, survive};
use crate::support::random::Random;
use crate::support::shader::{Answers, Function, call, words};
use direkt::low_level::gpu::Context;
use direkt::low_level::reference::exact::solid_angle::polygon_solid_angle;
use glam::{DMat3, DVec3};

/// A point a and the edges u and v from it, seen from the origin.
pub(super) type Edges = [DVec3; 3];

pub(super) fn numbers(edges: &Edges) -> [f64; 9] {
    std::array::from_fn(|i| edges[i / 3][i % 3])
}

pub(super) fn relative(found: f64, exact: f64) -> f64 {
    (found / exact - 1.0).abs()
}

/// Solid angles by direkt, by the sum of the angles less π, and by Van Oosterom and Strackee's
/// formula as printed.
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

/// 300 rotations of a right triangle with legs of 1 at this distance. Coordinates are multiples of
/// 2⁻¹⁰, so that vertices and edges are exact in f32.
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
        let answers = solid_angles(context, &OF_TRIANGLE, &cases);
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
            context,
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
pub(super) fn right_triangle(height: f64) -> Edges {
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
        (octant, std::f64::consts::FRAC_PI_2),
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
    let answers = solid_angles(context, &OF_TRIANGLE, &cases.map(|c| c.0));
    let off = |word| {
        let found = answers.f64(word).zip(&cases);
        worst(found.map(|(found, (_, exact))| relative(found, *exact)))
    };
    survive(
        context,
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
    let answers = solid_angles(context, &function, &squares);
    let off = |word| {
        let found = answers.f64(word).zip(cases);
        worst(found.map(|(found, (_, exact))| relative(found, exact)))
    };
    survive(
        context,
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
    let answers = call(context, &function, &words(&cases.map(|(s, _)| s * s)));
    let off = |word| {
        let found = answers.f64(word).zip(cases);
        worst(found.map(|(found, (_, exact))| relative(found, exact)))
    };
    survive(
        context,
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
