//! `shaders/light/area_light.wesl`, as far as solid angles go; `light.rs` tests sampling by area,
//! and both against their densities.

use crate::support::every_kind::{constant_environment, every_kind, with_right_angles};
use crate::support::random::{Random, numbers, rounded};
use crate::support::rounding::{U, close};
use crate::support::shader::{Function, call_in, words};
use crate::support::{context, emitter, floor_pixel, prepared_for, render};
use direkt::low_level::accel::PrimitiveGeometry;
use direkt::low_level::emitters::Emitter;
use direkt::low_level::reference::core::frame::frame_from_normal;
use direkt::low_level::reference::core::pdf::PdfDiscrete;
use direkt::low_level::reference::exact::solid_angle::{cone_solid_angle, polygon_solid_angle};
use direkt::low_level::reference::light::area_light::{
    MIN_SOLID_ANGLE, area_light, sample_area_light,
};
use direkt::low_level::reference::light::ellipsoid::{Ellipsoid, view_ellipsoid};
use direkt::low_level::reference::scene::fetch::World;
use direkt::scene::{FilmSize, Geometry, LightSampling, LightSelection, Strategy};
use glam::{DVec2, DVec3};

/// Size of the coordinates over the shortest edge, or the radius: how much rounding the scene to
/// f32 deforms a light.
fn deformation(geometry: &PrimitiveGeometry) -> f64 {
    match *geometry {
        PrimitiveGeometry::Triangle { a, u, v }
        | PrimitiveGeometry::Rectangle { a, u, v }
        | PrimitiveGeometry::Disk { a, u, v } => {
            let longest = u.length().max(v.length());
            (a.length() + longest) / (u.cross(v).length() / longest)
        }
        PrimitiveGeometry::Sphere { center, radius } => (center.length() + radius) / radius,
        PrimitiveGeometry::Ellipsoid { center, radii, .. } => {
            (center.length() + radii.max_element()) / radii.min_element()
        }
    }
}

/// Solid angle of what is sampled: the light, or the box around a disk; of an ellipsoid one over
/// the twin's density in the direction `wi`, which `ellipsoid.rs` holds to be one.
fn exact_solid_angle(geometry: &PrimitiveGeometry, x: DVec3, wi: DVec3) -> f64 {
    match *geometry {
        PrimitiveGeometry::Triangle { a, u, v } => polygon_solid_angle(x, &[a, a + u, a + v]).abs(),
        PrimitiveGeometry::Rectangle { a, u, v } => {
            polygon_solid_angle(x, &[a, a + u, a + u + v, a + v]).abs()
        }
        PrimitiveGeometry::Disk { a, u, v } => {
            polygon_solid_angle(x, &[a - u - v, a + u - v, a + u + v, a - u + v]).abs()
        }
        PrimitiveGeometry::Sphere { center, radius } => {
            cone_solid_angle(radius / center.distance(x))
        }
        PrimitiveGeometry::Ellipsoid { .. } => {
            let view = view_ellipsoid(Ellipsoid::of(geometry).unwrap(), x);
            let outside = view.inverse_direction_density(wi).unwrap_or(0.0);
            if view.within { f64::NAN } else { outside }
        }
    }
}

/// Roundings by which the density in a direction changes when that is turned to the world and back:
/// 8 each, times three for the third power of |M⁻¹ω|, which changes up to as many times as much as
/// the half axes differ; 0 where the density is uniform.
fn turning_back(geometry: &PrimitiveGeometry) -> f64 {
    match geometry {
        PrimitiveGeometry::Ellipsoid { radii, .. } => {
            48.0 * radii.max_element() / radii.min_element()
        }
        _ => 0.0,
    }
}

/// The density is 1 over the exact solid angle, and the direction the twin's: each up to a hundred
/// roundings of the light as f32 deforms it, seen from its own size away or further.
/// `pdf_area_light` of the direction is the same density, from wherever the light is seen.
#[test]
fn solid_angle_samples_are_the_twins() {
    let context = context();
    let mut scene = with_right_angles(every_kind(constant_environment()));
    scene.render.estimator.light_sampling = LightSampling::SolidAngle;
    let prepared = prepared_for(scene, Strategy::MisPower, LightSelection::Uniform);
    let world = World::new(&prepared);
    let function = Function {
        imports: "import package::core::frame::frame_from_normal;
                  import package::light::area_light::{pdf_area_light, sample_area_light};
                  import package::core::pdf::ExpectedSamples;
                  import package::scene::fetch::fetch_light;",
        body: "let facing = frame_from_normal(vec3f(0.0, 0.0, 1.0));
               let light = fetch_light(in_u32(0u));
               let x = in_vec3f(1u);
               let s = sample_area_light(light, light.expected_samples, x, facing, in_vec2f(4u));
               let d = s.target_point - x;
               let cos_light = abs(dot(normalize(cross(light.u, light.v)), s.wi));
               out_vec3f(0u, s.wi);
               out_f32(3u, s.pdf.value);
               out_f32(4u, pdf_area_light(in_u32(0u), x, facing, s.wi, dot(d, d), cos_light, vec2f(0.0)).value);",
        inputs: 6,
        outputs: 5,
        features: &[],
    };
    let mut items = Vec::new();
    for (index, light) in (0_u32..).zip(&prepared.emitters.lights) {
        if matches!(light, Emitter::Area { .. }) {
            items.extend((0..2000).map(|i| {
                let [x, y, z, _] = numbers(i, index, 67).map(|n| 2.0 * n - 1.0);
                let [a, b, ..] = numbers(i, index, 68);
                (
                    index,
                    DVec3::new(x, y, z).as_vec3().as_dvec3(),
                    DVec2::new(a, b),
                )
            }));
        }
    }
    let inputs: Vec<u32> = items
        .iter()
        .flat_map(|(index, x, u)| {
            let numbers = words(&[x.x, x.y, x.z, u.x, u.y]);
            std::iter::once(*index).chain(numbers)
        })
        .collect();
    let answers = call_in(context, &prepared, &function, &inputs, items.len());
    let mut compared = 0;
    let found = answers.vec3(0).zip(answers.f64(3)).zip(answers.f64(4));
    for ((index, x, u), ((wi, pdf), evaluated)) in items.iter().zip(found) {
        let light = area_light(&world, *index);
        let facing = frame_from_normal(DVec3::Z);
        let selection = PdfDiscrete(prepared.emitters.probability(*index as usize));
        let twin = sample_area_light(&light, selection, *x, &facing, *u);
        let solid_angle = exact_solid_angle(&light.geometry, *x, wi.normalize());
        let by_solid_angle = solid_angle > 1.1 * MIN_SOLID_ANGLE && solid_angle.is_finite();
        if pdf > 0.0 && by_solid_angle {
            assert!(
                close(evaluated, pdf, 4.0 + turning_back(&light.geometry)),
                "{:?} from {x}: {pdf}, evaluated {evaluated}",
                light.geometry
            );
        }
        let away = solid_angle > 1e-3 && solid_angle < 1.5;
        if !away || twin.pdf.0 == 0.0 || pdf == 0.0 {
            continue;
        }
        compared += 1;
        let bound = 128.0 * U * (1.0 + deformation(&light.geometry));
        let what = format!("{:?} from {x}, {u}", light.geometry);
        let off = (pdf * solid_angle / selection.0 - 1.0).abs();
        assert!(
            off <= bound,
            "{what}: density off by {off:.1e}, bound {bound:.1e}"
        );
        let turned = (wi - twin.wi).length();
        assert!(turned <= bound, "{what}: {turned:.1e}, bound {bound:.1e}");
    }
    assert!(compared > 1000, "{compared}");
}

/// From within a sphere, in proportion to the cosine. Numbers that lead to within 11° of the
/// horizon are left out: there the cosine, a root, loses digits; elsewhere 4·10⁻⁷ across
/// (`sample_lambert`) turn a direction by 5 times that.
#[test]
fn samples_from_within_a_sphere_are_the_twins() {
    let context = context();
    let mut scene = floor_pixel();
    let center = DVec3::new(0.3, -0.2, 1.0);
    let sphere = Geometry::Sphere {
        center,
        radius: 3.0,
    };
    scene.shapes.push(emitter(sphere, 1.0, true));
    scene.render.estimator.light_sampling = LightSampling::SolidAngle;
    let prepared = prepared_for(scene, Strategy::MisPower, LightSelection::Uniform);
    let world = World::new(&prepared);
    let light = area_light(&world, 0);
    let PrimitiveGeometry::Sphere { center, radius } = light.geometry else {
        unreachable!("the light is a sphere");
    };
    let function = Function {
        imports: "import package::core::frame::frame_from_normal;
                  import package::light::area_light::{pdf_area_light, sample_area_light};
                  import package::core::pdf::ExpectedSamples;
                  import package::scene::fetch::fetch_light;",
        body: "let frame = frame_from_normal(in_vec3f(3u));
               let s = sample_area_light(fetch_light(0u), ExpectedSamples(1.0), in_vec3f(0u), frame, in_vec2f(6u));
               out_vec3f(0u, s.wi);
               out_f32(3u, s.pdf.value);
               out_f32(4u, pdf_area_light(0u, in_vec3f(0u), frame, s.wi, 1.0, 1.0, vec2f(0.0)).value);",
        inputs: 8,
        outputs: 5,
        features: &[],
    };
    let mut random = Random::new(69);
    let cases: Vec<(DVec3, DVec3, DVec2)> = (0..10_000)
        .map(|i| {
            let way = [0.0, 0.5, 0.9, 0.999][i % 4];
            let x = rounded(center + way * radius * random.direction());
            let u = DVec2::new(random.uniform(), random.uniform());
            (x, random.direction(), 0.01 + 0.98 * u)
        })
        .map(|(x, normal, u)| (x, normal, u.as_vec2().as_dvec2()))
        .collect();
    let inputs: Vec<f64> = cases
        .iter()
        .flat_map(|(x, n, u)| {
            [x.to_array(), n.to_array()]
                .concat()
                .into_iter()
                .chain(u.to_array())
        })
        .collect();
    let answers = call_in(context, &prepared, &function, &words(&inputs), cases.len());
    let found = answers.vec3(0).zip(answers.f64(3).zip(answers.f64(4)));
    for ((x, normal, u), (wi, (pdf, evaluated))) in cases.iter().zip(found) {
        let frame = frame_from_normal(*normal);
        let twin = sample_area_light(&light, PdfDiscrete(1.0), *x, &frame, *u);
        let off = wi.distance(twin.wi);
        let off_pdf = (pdf - twin.pdf.0).abs().max((evaluated - twin.pdf.0).abs());
        assert!(
            off < 5e-6 && off_pdf < 5e-6,
            "{}: {wi} {pdf} {evaluated}, not {} {:?}",
            context.adapter.name,
            twin.wi,
            twin.pdf
        );
    }
}

/// Over the solid angle of a sphere the radiance is constant, and over a small one the cosine
/// nearly so: the variance of the irradiance of a sphere on the axis is π²(1 − c)⁴/3 with c = cosθ
/// of the cone (HARD CASES, section E).
#[test]
fn a_spheres_variance_is_the_exact_one() {
    let context = context();
    let mut scene = floor_pixel();
    scene.film = FilmSize {
        width: 64,
        height: 64,
    };
    scene.shapes.push(emitter(
        Geometry::Sphere {
            center: DVec3::new(0.0, 0.0, 4.0),
            radius: 2.0,
        },
        1.0,
        false,
    ));
    scene.render.estimator.strategy = Strategy::LightSolidAngle;
    scene.render.stop.spp = 64;
    let film = render(context, scene);
    // Radiance is 0.5/π times the irradiance.
    let factor = (0.5 / std::f64::consts::PI).powi(2);
    let exact = factor * 0.001_059_908_360_548_24 / 64.0;
    let reported: direkt::low_level::stats::moments::Moments = film
        .pixels
        .iter()
        .filter_map(|p| Some(p.variance_of_mean()?[0]))
        .collect();
    let test = direkt::low_level::stats::t_test::one_sample(&reported, exact).unwrap();
    crate::support::statistics::accept(test.p_value, "variance over a sphere's cone");
    let area = direkt::low_level::stats::t_test::one_sample(&reported, 1.02 * exact).unwrap();
    crate::support::statistics::reject(area.p_value, "variance over a sphere's cone, 2 % more");
}
