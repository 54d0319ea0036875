//! `shaders/light/ellipsoid.wesl`; `light/area.rs` holds its directions to their density.

use crate::support::random::{Random, rounded};
use crate::support::rounding::U;
use crate::support::shader::{Answers, Function, call_in, words};
use crate::support::{context, edge_points, emitter, floor_pixel, prepared_for};
use direkt::low_level::prepare::Prepared;
use direkt::low_level::reference::core::frame::frame_from_normal;
use direkt::low_level::reference::core::pdf::PdfDiscrete;
use direkt::low_level::reference::light::area_light::{area_light, sample_area_light};
use direkt::low_level::reference::light::ellipsoid::{
    Ellipsoid, EllipsoidView, pdf_ellipsoid_area, view_ellipsoid,
};
use direkt::low_level::reference::light::sphere::sample_sphere_area;
use direkt::low_level::reference::scene::fetch::World;
use direkt::low_level::reference::scene::surface::OFFSET;
use direkt::scene::ellipsoid::rotation;
use direkt::scene::{Geometry, LightSampling, LightSelection, Scene, Strategy};
use glam::{DMat3, DVec2, DVec3};
use std::f64::consts::PI;

/// Half axes of lamps, flat and thin ones among them.
const RADII: [[f64; 3]; 6] = [
    [1.0, 0.7, 0.4],
    [1.0, 0.9, 0.05],
    [0.03, 1.0, 0.02],
    [0.8, 1.0, 1e-4],
    [1.0, 1e-3, 1e-3],
    [1e-6, 1.0, 0.5],
];

/// One lamp of each, apart from one another, which emits on both sides.
fn lamps(sampling: LightSampling) -> Prepared {
    let mut scene: Scene = floor_pixel();
    for (i, radii) in (0_u8..).zip(RADII) {
        let turn = rotation(DVec3::new(0.3, -0.2, 0.1 * f64::from(i)));
        let ellipsoid = Geometry::Ellipsoid {
            center: DVec3::new(3.0 * f64::from(i) - 8.0, f64::from(i), 4.0),
            axes: turn * DMat3::from_diagonal(DVec3::from_array(radii)),
        };
        scene.shapes.push(emitter(ellipsoid, 1.0, true));
    }
    scene.render.estimator.light_sampling = sampling;
    prepared_for(scene, Strategy::MisPower, LightSelection::Uniform)
}

fn ellipsoid(world: &World<'_>, light: u32) -> Ellipsoid {
    Ellipsoid::of(&area_light(world, light).geometry).expect("every lamp is an ellipsoid")
}

/// A place from which a lamp is seen.
#[derive(Debug, Clone, Copy)]
struct Place {
    light: u32,
    x: DVec3,
    u: DVec2,
}

/// From far, from about its size away, from near its surface, from it, and from within; all numbers
/// at the edges of [0, 1) and between.
fn places(world: &World<'_>) -> Vec<Place> {
    let mut random = Random::new(95);
    let mut places = Vec::new();
    for light in 0..RADII.len() as u32 {
        let e = ellipsoid(world, light);
        for (k, u) in (0..).zip(edge_points()) {
            let p = random.direction().normalize();
            let normal = (e.axes.inverse().transpose() * p).normalize();
            let away = e.longest * [3.0, 1.0, 0.2, 0.01, 30.0][k % 5];
            let x = match k % 7 {
                0 => e.center + 0.7 * e.axes * p,
                1 => e.point(p),
                _ => e.point(p) + away * normal,
            };
            let x = rounded(x);
            places.push(Place { light, x, u });
        }
    }
    places
}

const IMPORTS: &str = "import package::core::frame::frame_from_normal;
    import package::core::pdf::ExpectedSamples;
    import package::light::area_light::sample_area_light;
    import package::light::ellipsoid::{pdf_ellipsoid_area, pdf_ellipsoid_light};
    import package::scene::fetch::fetch_light;";

/// Samples from every place, and the density that is evaluated in their directions.
fn sampled(prepared: &Prepared, places: &[Place]) -> Answers {
    let function = Function {
        imports: IMPORTS,
        body: "let light = fetch_light(in_u32(0u));
               let x = in_vec3f(1u);
               let frame = frame_from_normal(vec3f(0.0, 0.6, 0.8));
               let s = sample_area_light(light, ExpectedSamples(1.0), x, frame, in_vec2f(4u));
               out_vec3f(0u, s.wi); out_f32(3u, s.pdf.value);
               out_vec3f(4u, s.target_point); out_f32(7u, s.radiance_over_pdf.x);
               let evaluated = pdf_ellipsoid_light(light, x, frame, s.wi, 1.0, 1.0, vec2f(0.0));
               out_f32(8u, evaluated.value);",
        inputs: 6,
        outputs: 9,
        features: &[],
    };
    let inputs: Vec<u32> = places
        .iter()
        .flat_map(|p| {
            let numbers = words(&[p.x.x, p.x.y, p.x.z, p.u.x, p.u.y]);
            std::iter::once(p.light).chain(numbers)
        })
        .collect();
    call_in(context(), prepared, &function, &inputs, places.len())
}

/// 64 roundings of the coordinates: how well a place relative to a lamp, and a point of it, are
/// known.
fn rounding(e: &Ellipsoid, x: DVec3) -> f64 {
    64.0 * U * (e.center.length() + x.length() + e.longest)
}

/// Whether the ray from `x` in the direction `wi` meets the lamp whose half axes are longer by
/// `more`.
fn is_met(e: &Ellipsoid, x: DVec3, wi: DVec3, more: f64) -> bool {
    let lengths = DVec3::from_array([0, 1, 2].map(|i| e.axes.col(i).length()));
    let axes = e.axes * DMat3::from_diagonal((lengths + DVec3::splat(more)) / lengths);
    let to_sphere = axes.inverse();
    let (q, d) = (to_sphere * (e.center - x), (to_sphere * wi).normalize());
    q.length() <= 1.0 || (q.dot(d) > 0.0 && (q - q.dot(d) * d).length() <= 1.0)
}

/// By how much, relative to it, one over the density in the direction `wi` changes when place and
/// direction are moved by `rounding`; `None` where that changes the way of sampling.
fn density_error(view: &EllipsoidView, wi: DVec3, rounding: f64) -> Option<f64> {
    let inverse = view.inverse_direction_density(wi)?;
    let distance = (view.x - view.ellipsoid.center).length();
    let mut worst = 0.0_f64;
    for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
        for side in [-1.0, 1.0] {
            let step = side * rounding * axis;
            let turned = (wi + step / distance + 32.0 * U * side * axis).normalize();
            for (x, wi) in [(view.x + step, wi), (view.x, turned)] {
                let moved = view_ellipsoid(view.ellipsoid, x);
                let same = (moved.within, moved.narrow) == (view.within, view.narrow);
                let found = moved.inverse_direction_density(wi).filter(|_| same)?;
                worst = worst.max((found / inverse - 1.0).abs());
            }
        }
    }
    Some(2.0 * worst + 64.0 * U)
}

/// Every direction leads to the lamp, ends beside it on the side of the place, has the twin's
/// density there, which is that of the evaluation, and the radiance over it.
#[test]
fn directions_lead_to_lamps_with_the_twins_density() {
    let prepared = lamps(LightSampling::SolidAngle);
    let world = World::new(&prepared);
    let places = places(&world);
    let answers = sampled(&prepared, &places);
    let numbers = answers.f64(3).zip(answers.f64(7)).zip(answers.f64(8));
    let found = answers.vec3(0).zip(answers.vec3(4)).zip(numbers);
    let mut compared = [[0; 2]; RADII.len()];
    for (place, ((wi, target), ((pdf, radiance), evaluated))) in places.iter().zip(found) {
        let e = ellipsoid(&world, place.light);
        let view = view_ellipsoid(e, place.x);
        let what = format!("{place:?}: {wi} {pdf} {radiance} {evaluated}");
        assert!(
            wi.is_finite() && target.is_finite() && pdf.is_finite() && radiance.is_finite(),
            "{what}"
        );
        if pdf <= 0.0 {
            assert_eq!(radiance, 0.0, "{what}");
            continue;
        }
        let rounding = rounding(&e, place.x);
        assert!((wi.length() - 1.0).abs() < 16.0 * U, "{what}");
        assert!(is_met(&e, place.x, wi, rounding), "{what}: past the lamp");
        assert!(
            (radiance * pdf - 1.0).abs() < 16.0 * U || view.inverse_direction_density(wi).is_none(),
            "{what}"
        );
        let off = (e.axes.inverse() * (target - e.center)).length() - 1.0;
        let slope = (e.axes.inverse().transpose()
            * (e.axes.inverse() * (target - e.center)).normalize())
        .length();
        let height = off / slope;
        assert!(
            height.abs() < 2.0 * OFFSET * e.extent() + rounding,
            "{what}: {height}"
        );
        let on_the_side = if view.within { -height } else { height };
        assert!(
            view.on_surface || on_the_side > -rounding,
            "{what}: {height}"
        );
        let error = density_error(&view, wi, rounding).filter(|error| *error < 0.1);
        let Some(error) = error.filter(|_| !view.within) else {
            continue;
        };
        compared[place.light as usize][usize::from(view.narrow)] += 1;
        let inverse = view
            .inverse_direction_density(wi)
            .expect("its error is known");
        assert!(
            (pdf * inverse - 1.0).abs() <= error,
            "{what}, not {}: {error}",
            1.0 / inverse
        );
        assert!((evaluated / pdf - 1.0).abs() <= error, "{what}: evaluated");
    }
    for (light, [around, narrow]) in compared.iter().enumerate() {
        assert!(*around > 100 && *narrow > 20, "lamp {light}: {compared:?}");
    }
}

/// By area, too, the samples are the twin's.
#[test]
fn points_by_area_are_the_twins() {
    let prepared = lamps(LightSampling::Area);
    let world = World::new(&prepared);
    let places = places(&world);
    let answers = sampled(&prepared, &places);
    let frame = frame_from_normal(DVec3::new(0.0, 0.6, 0.8));
    let found = answers.vec3(0).zip(answers.f64(3)).zip(answers.f64(7));
    let mut compared = 0;
    for (place, ((wi, pdf), radiance)) in places.iter().zip(found) {
        let light = area_light(&world, place.light);
        let e = ellipsoid(&world, place.light);
        let twin = sample_area_light(&light, PdfDiscrete(1.0), place.x, &frame, place.u);
        let what = format!("{place:?}: {wi} {pdf} {radiance}, not {twin:?}");
        assert!(
            wi.is_finite() && pdf.is_finite() && radiance.is_finite(),
            "{what}"
        );
        // Points of the unit sphere are known to 16 U, which turns the normal.
        let distance = (twin.target_point - place.x).length();
        let angle = rounding(&e, place.x) / distance;
        let normal = 64.0 * U * e.longest / e.curvature_radius(twin.target_point);
        if angle > 1e-3 || twin.cos_light < 10.0 * (angle + normal) || normal > 1e-2 {
            continue;
        }
        compared += 1;
        assert!(wi.distance(twin.wi) <= 2.0 * angle + 16.0 * U, "{what}");
        let relative = 64.0 * U + 4.0 * angle + 2.0 * (angle + normal) / twin.cos_light + normal;
        assert!(
            (pdf / twin.pdf.0 - 1.0).abs() <= relative,
            "{what}: {relative}"
        );
        let expected = twin.radiance_over_pdf.x;
        assert!(
            (radiance / expected - 1.0).abs() <= relative,
            "{what}: {relative}"
        );
    }
    assert!(
        compared > places.len() / 4,
        "{compared} of {}",
        places.len()
    );
}

/// The density per area is the twin's, and integrates to one: over the sphere, ∫ p(M q) |det M| |M⁻ᵀq|
/// dω.
#[test]
fn densities_per_area_are_the_twins_and_integrate_to_one() {
    let function = Function {
        imports: IMPORTS,
        body: "out_f32(0u, pdf_ellipsoid_area(in_vec3f(0u), in_vec3f(3u)).value);",
        inputs: 6,
        outputs: 1,
        features: &[],
    };
    let prepared = lamps(LightSampling::Area);
    let points: Vec<DVec3> = edge_points()
        .into_iter()
        .map(|u| rounded(sample_sphere_area(u)))
        .collect();
    for radii in RADII.map(|r| rounded(DVec3::from_array(r))) {
        let inputs: Vec<f64> = points
            .iter()
            .flat_map(|p| [radii.to_array(), p.to_array()].concat())
            .collect();
        let answers = call_in(
            context(),
            &prepared,
            &function,
            &words(&inputs),
            points.len(),
        );
        let axes = DMat3::from_diagonal(radii);
        let e = Ellipsoid {
            center: DVec3::ZERO,
            axes,
            longest: radii.max_element(),
        };
        for (p, pdf) in points.iter().zip(answers.f64(0)) {
            let expected = pdf_ellipsoid_area(&e, *p).0;
            assert!(
                (pdf / expected - 1.0).abs() < 32.0 * U,
                "{radii} {p}: {pdf}, not {expected}"
            );
        }
        // The stretch of areas, without the inverse: |∂(M q)/∂θ × ∂(M q)/∂φ| / sinθ.
        for p in points.iter().take(200) {
            let frame = frame_from_normal(p.normalize());
            let stretch = (axes * frame.x).cross(axes * frame.y).length();
            let pdf = pdf_ellipsoid_area(&e, p.normalize()).0;
            assert!((pdf * stretch * 4.0 * PI - 1.0).abs() < 1e-9, "{radii} {p}");
        }
    }
}
