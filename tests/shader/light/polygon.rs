//! `shaders/light/polygon.wesl`.

use crate::support::random::numbers;
use crate::support::shader::{Answers, Function, call, words};
use crate::support::{context, edge_points, histogram, statistics};
use direkt::low_level::gpu::Context;
use direkt::low_level::reference::BrokenTwin;
use direkt::low_level::reference::broken::BROKEN_TWINS;
use direkt::low_level::reference::exact::polygon::polygon_factor;
use direkt::low_level::reference::light::polygon::{
    invert_projected_polygon, project_polygon, sample_projected_polygon,
};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// Triangles and rectangles around the origin: high above the horizon, cut by it, around the
/// zenith, edge-on, with an edge that passes under the zenith, and turned both ways.
fn polygons() -> Vec<Vec<DVec3>> {
    let v = DVec3::new;
    let square = |c: DVec3, a: DVec3, b: DVec3| vec![c - a - b, c + a - b, c + a + b, c - a + b];
    let mut polygons = vec![
        vec![v(1.0, 0.0, 1.0), v(0.0, 1.0, 1.0), v(-0.5, -0.5, 2.0)],
        vec![v(1.0, 0.0, -0.5), v(0.0, 1.0, 1.0), v(-1.0, -0.5, 2.0)],
        vec![v(1.0, 1.0, -0.5), v(2.0, 1.0, -0.5), v(1.5, 1.0, 1.0)],
        square(v(0.0, 0.0, 1.0), v(0.5, 0.0, 0.0), v(0.0, 0.5, 0.0)),
        square(v(2.0, 0.5, 1.0), v(0.0, 0.5, 0.0), v(0.0, 0.0, 1.5)),
        square(v(0.3, 2.0, 0.5), v(1.0, 0.0, 0.2), v(0.0, 0.1, 0.7)),
        square(v(0.5, 0.0, 0.5), v(0.5, 0.0, 0.0), v(0.0, 0.5, 0.0)),
    ];
    for i in 0..20 {
        let [a, b, c, d] = numbers(i, 0, 69).map(|x| 2.0 * x - 1.0);
        let [e, f, g, h] = numbers(i, 1, 69).map(|x| 2.0 * x - 1.0);
        let centre = v(2.0 * a, 2.0 * b, 1.2 * c + 0.6);
        polygons.push(square(centre, v(d, e, f), v(-0.5 * e, 0.5 * d, 0.6 * g)));
        polygons.push(vec![centre, centre + v(d, e, f), centre + v(g, h, -d)]);
    }
    let turned: Vec<Vec<DVec3>> = polygons
        .iter()
        .map(|p| p.iter().rev().copied().collect())
        .collect();
    polygons.extend(turned);
    let rounded = |p: Vec<DVec3>| p.into_iter().map(|x| x.as_vec3().as_dvec3()).collect();
    polygons.into_iter().map(rounded).collect()
}

/// The projected solid angle and a direction, for every point of every polygon.
fn sampled(context: &Context, polygons: &[Vec<DVec3>], points: &[DVec2]) -> Answers {
    let function = Function {
        imports: "import package::light::polygon::{MAX_VERTICES, project_polygon, sample_projected_polygon};",
        body: "var v: array<vec3f, MAX_VERTICES>;
               for (var i = 0u; i < 4u; i += 1u) {
                   v[i] = in_vec3f(3u * i);
               }
               let p = project_polygon(v, in_u32(14u));
               out_f32(0u, p.area);
               out_vec3f(1u, sample_projected_polygon(p, in_vec2f(12u)));",
        inputs: 15,
        outputs: 4,
        features: &[],
    };
    let inputs: Vec<u32> = polygons
        .iter()
        .flat_map(|p| {
            points.iter().flat_map(|u| {
                let vertex = |i: usize| p.get(i).copied().unwrap_or_default().to_array();
                let vertices = (0..4).flat_map(vertex).chain(u.to_array());
                let mut item = words(&vertices.collect::<Vec<_>>());
                item.push(p.len() as u32);
                item
            })
        })
        .collect();
    call(context, &function, &inputs)
}

/// The area is π times Lambert's factor. The difference of outer and inner arcs leaves of it an
/// absolute error of a few dozen roundings of the unit disk.
#[test]
fn areas_are_lamberts() {
    let context = context();
    let polygons = polygons();
    let answers = sampled(context, &polygons, &[DVec2::splat(0.5)]);
    for (polygon, area) in polygons.iter().zip(answers.f64(0)) {
        let exact = PI * polygon_factor(DVec3::ZERO, DVec3::Z, polygon).abs();
        let twin = project_polygon(polygon).area;
        assert!(
            (twin - exact).abs() < 1e-12,
            "{polygon:?}: {twin}, not {exact}"
        );
        assert!(
            (area - exact).abs() < 5e-6,
            "{polygon:?}: {area}, not {exact}"
        );
    }
}

/// Back in the unit square, a direction's azimuth is where it should be up to the error of the area
/// before it, and all directions lie above the horizon.
#[test]
fn directions_are_the_twins() {
    let context = context();
    let polygons = polygons();
    let points = edge_points();
    let answers = sampled(context, &polygons, &points);
    let items = polygons
        .iter()
        .flat_map(|p| points.iter().map(move |u| (p, u)));
    let mut compared = 0;
    for ((polygon, u), wi) in items.zip(answers.vec3(1)) {
        let twin = project_polygon(polygon);
        if twin.area < 1e-3 {
            continue;
        }
        assert!(wi.is_finite() && wi.z >= 0.0, "{polygon:?}, {u}: {wi}");
        assert!((wi.length() - 1.0).abs() < 1e-5, "{polygon:?}, {u}: {wi}");
        // Towards the zenith a direction has no azimuth.
        if u.y < 0.01 {
            continue;
        }
        let back = invert_projected_polygon(&twin, sample_projected_polygon(&twin, *u));
        assert!((back.x - u.x).abs() < 1e-9, "{polygon:?}, {u}: twin {back}");
        let back = invert_projected_polygon(&twin, wi);
        let bound = 1e-5 / twin.area + 1e-5;
        let off = (back.x - u.x).abs();
        // The first and the last azimuth are the same where the polygon surrounds the zenith.
        assert!(
            off.min(1.0 - off) < bound,
            "{polygon:?}, {u}: {back}, bound {bound:.1e}"
        );
        compared += 1;
    }
    assert!(compared > 10_000, "{compared}");
}

/// Directions go back to the unit square, by the area before their azimuth and their place between
/// the arcs: uniform there, they have the density cosθ / area.
#[test]
fn directions_match_pdf() {
    const DRAWN: u32 = 1 << 20;
    let context = context();
    for (index, polygon) in (0..).zip(polygons().into_iter().take(7)) {
        let points: Vec<DVec2> = (0..DRAWN)
            .map(|i| {
                let [x, y, ..] = numbers(i, index, 70);
                DVec2::new(x, y)
            })
            .collect();
        let twin = project_polygon(&polygon);
        let samples: Vec<DVec3> = sampled(context, &[polygon], &points).vec3(1).collect();
        let test = |samples: &[DVec3], density: f64| {
            let square: Vec<DVec2> = samples
                .iter()
                .map(|w| invert_projected_polygon(&twin, *w))
                // What rounding moves across the border.
                .map(|p| p.clamp(DVec2::ZERO, DVec2::splat(1.0 - 1e-9)))
                .collect();
            histogram::p_value(&square, DVec2::ZERO, DVec2::ONE, |_| density)
        };
        let what = format!("polygon {index}, seed 70, {}", context.adapter.name);
        statistics::accept(test(&samples, 1.0), &what);
        for row in BROKEN_TWINS {
            let broken = match row.twin {
                BrokenTwin::PdfScaled => test(&samples, 1.02),
                BrokenTwin::SwappedSinCos => {
                    let swapped: Vec<DVec3> = samples
                        .iter()
                        .map(|w| BrokenTwin::direction(Some(row.twin), *w))
                        .collect();
                    test(&swapped, 1.0)
                }
                // In the square there is neither measure nor cosine.
                BrokenTwin::WrongMeasure
                | BrokenTwin::ExtraCosine
                | BrokenTwin::LightLeftOut
                | BrokenTwin::MisWeights
                | BrokenTwin::RaysForgotten
                | BrokenTwin::OpaqueShadows => continue,
            };
            statistics::reject(broken, &format!("{what}, {}", row.name));
        }
    }
}
