//! `shaders/light/sphere.wesl`.

use crate::support::random::{Random, rounded};
use crate::support::rounding::{U, assert_all_near, assert_integrates_to_one, assert_near};
use crate::support::shader::{Function, call, draw, words};
use crate::support::{context, edge_points, histogram, statistics};
use direkt::low_level::reference::BrokenTwin;
use direkt::low_level::reference::light::sphere::{
    distance_within_sphere, pdf_sphere_area, sample_sphere_area, within_sphere,
};
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// z = 1 − 2u is exact for multiples of 2⁻²⁴. r = 2√(u(1 − u)) has one product (½ U after the root)
/// and a root (9 U); sine and cosine are off by 5 U, their product with r by U: 16 U in all.
#[test]
fn sphere_area_samples_are_the_twins() {
    let context = context();
    let points = edge_points();
    let inputs: Vec<f64> = points.iter().flat_map(|u| u.to_array()).collect();
    let function = Function {
        imports: "import package::light::sphere::sample_sphere_area;",
        body: "out_vec3f(0u, sample_sphere_area(in_vec2f(0u)));",
        inputs: 2,
        outputs: 3,
        features: &[],
    };
    let answers = call(context, &function, &words(&inputs));
    for (u, w) in points.iter().zip(answers.vec3(0)) {
        let what = format!("{}: {u}", context.adapter.name);
        assert_all_near(w, sample_sphere_area(*u), 16.0 * U, &what);
        assert_eq!(w.z, 1.0 - 2.0 * u.x, "{what}");
        // |w|² doubles the error of r and of the sines.
        assert_near(w.length_squared(), 1.0, 32.0 * U, &what);
        // The azimuth is off by the error across, over the radius.
        let r = w.truncate().length();
        let back = DVec2::new(0.5 * (1.0 - w.z), w.y.atan2(w.x).rem_euclid(TAU) / TAU);
        let turn = (back.y - u.y + 0.5).rem_euclid(1.0) - 0.5;
        assert_eq!(back.x, u.x, "{what}");
        assert!(
            u.x == 0.0 || turn.abs() <= 16.0 * U / (TAU * r),
            "{what} comes back as {back}"
        );
    }
}

#[test]
fn sphere_area_density_integrates_to_one() {
    let context = context();
    let function = Function {
        imports: "import package::light::sphere::pdf_sphere_area;",
        body: "out_f32(0u, pdf_sphere_area(in_f32(0u)).value);",
        inputs: 1,
        outputs: 1,
        features: &[],
    };
    let mut random = Random::new(4);
    let radii: Vec<f64> = (0..64).map(|_| random.magnitude(1e-9, 1e9)).collect();
    let areas: Vec<f64> = radii.iter().map(|r| 4.0 * PI * r * r).collect();
    let answers = call(context, &function, &words(&areas));
    for ((r, area), pdf) in radii.iter().zip(&areas).zip(answers.f64(0)) {
        // The area is rounded to f32 and divided by: U + 5 U.
        let expected = pdf_sphere_area(*area).0;
        assert_near(pdf, expected, 6.0 * U * expected, format!("radius {r}"));
        let element = |x: f64, _| TAU * PI * r * r * (PI * x).sin();
        assert_integrates_to_one(pdf, element, 7.0 * U, format!("radius {r}"));
    }
}

#[test]
fn sphere_area_samples_match_pdf() {
    let context = context();
    let function = Function {
        imports: "import package::light::sphere::sample_sphere_area;
                  import package::core::rng::{pcg4d, to_unit_2d};",
        body: "out_vec3f(0u, sample_sphere_area(to_unit_2d(pcg4d(vec4u(item, 10u, 11u, 12u)).xy)));",
        inputs: 0,
        outputs: 3,
        features: &[],
    };
    let samples: Vec<DVec3> = draw(context, &function, 1 << 20).vec3(0).collect();
    let pdf = |_: DVec3| pdf_sphere_area(4.0 * PI).0;
    let test = |pdf: &dyn Fn(DVec3) -> f64| histogram::directions_p_value(&samples, pdf);
    let what = format!("sample_sphere_area, seed 12, {}", context.adapter.name);
    statistics::accept(test(&pdf), &what);
    let sin = |w: DVec3| (1.0 - w.z * w.z).max(1e-18).sqrt();
    statistics::reject_broken(&what, |twin| match twin {
        BrokenTwin::PdfScaled => Some(test(&|w| 1.02 * pdf(w))),
        // Uniform in the polar angle and the azimuth.
        BrokenTwin::WrongMeasure => Some(test(&|w| 1.0 / (TAU * PI * sin(w)))),
        // z and √(1 − z²) change places.
        BrokenTwin::SwappedSinCos => Some(test(&|w| pdf(w) * w.z.abs() / sin(w))),
        BrokenTwin::ExtraCosine => Some(test(&|w| 2.0 * pdf(w) * w.z.abs())),
        // These are about choosing among lights and strategies.
        BrokenTwin::LightLeftOut
        | BrokenTwin::MisWeights
        | BrokenTwin::RaysForgotten
        | BrokenTwin::OpaqueShadows => None,
    });
}

/// Within, the root's argument is off by 24 U of the squared reach (differences, squares and sums),
/// which the root turns into min(q/2√, √q); the sum adds 8 U of the reach. On the sphere, what
/// leads out has no way through it.
#[test]
fn distances_within_spheres_are_the_twins() {
    let context = context();
    let function = Function {
        imports: "import package::light::sphere::{distance_within_sphere, within_sphere};",
        body: "out_f32(0u, distance_within_sphere(in_vec3f(0u), in_f32(3u), in_vec3f(4u), in_vec3f(7u)));
               out_bool(1u, within_sphere(in_vec3f(0u), in_f32(3u), in_vec3f(4u)));",
        inputs: 10,
        outputs: 2,
        features: &[],
    };
    let mut random = Random::new(98);
    let mut cases = Vec::new();
    for i in 0..20_000 {
        let center = random.in_cube();
        let radius = random.between(0.1, 2.0);
        let way = [0.0, 0.5, 0.999, 1.0, 1.01][i % 5];
        let outwards = random.direction();
        let x = rounded(center + way * radius * outwards);
        cases.push((center, radius, x, way, random.direction()));
    }
    let inputs: Vec<f64> = cases
        .iter()
        .flat_map(|(c, r, x, _, w)| {
            [c.to_array(), [*r, x.x, x.y], [x.z, w.x, w.y]]
                .concat()
                .into_iter()
                .chain([w.z])
        })
        .collect();
    let answers = call(context, &function, &words(&inputs));
    for ((c, r, x, way, w), (t, within)) in cases.iter().zip(answers.f64(0).zip(answers.u32(1))) {
        let what = format!("{}: {x} in {c}, {r}, towards {w}", context.adapter.name);
        assert_eq!(within == 1, within_sphere(*c, *r, *x), "{what}");
        assert_eq!(within == 1, *way <= 1.0, "{what}");
        let along = (*c - *x).dot(*w);
        // On the sphere and along it, rounding decides.
        if *way > 1.0 || (*way == 1.0 && along.abs() < 1e-5) {
            continue;
        }
        let reach = r + c.length();
        let root = (t - along).abs();
        let q = 24.0 * U * reach * reach;
        let bound = (0.5 * q / root.max(1e-9)).min(q.sqrt()) + 8.0 * U * reach;
        assert_near(
            t,
            distance_within_sphere(*c, *r, *x, *w),
            2.0 * bound,
            &what,
        );
        if *way == 1.0 && along < 0.0 {
            assert_eq!(t, 0.0, "{what}");
        }
    }
}
