//! `shaders/light/light.wesl`: light sampling from points around every kind of light.

use crate::support::every_kind::{constant_environment, every_kind};
use crate::support::random::rounded;
use crate::support::rounding::U;
use crate::support::shader::{Function, call_in};
use crate::support::{context, prepared_for};
use direkt::low_level::accel::PrimitiveGeometry;
use direkt::low_level::emitters::Emitter;
use direkt::low_level::gpu::Context;
use direkt::low_level::prepare::Prepared;
use direkt::low_level::reference::core::frame::{ShadingFrame, frame_from_normal};
use direkt::low_level::reference::light::environment::map_from_direction;
use direkt::low_level::reference::light::light::emitted_radiance;
use direkt::low_level::reference::light::sample::LightSample;
use direkt::low_level::reference::scene::fetch::World;
use direkt::scene::{
    Environment, EnvironmentRadiance, Light, LightSampling, LightSelection, PointLight, SpotLight,
    Strategy,
};
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

mod area;
mod choice;
mod environment;
mod samples;

const IMPORTS: &str = "import package::core::frame::frame_from_normal;
    import package::core::pdf::ExpectedSamples;
    import package::core::ray::Ray;
    import package::core::rng::{pcg4d, to_unit_2d};
    import package::light::sample::LightChoice;
    import package::light::environment::{environment_radiance, pdf_environment};
    import package::light::light::{choose_light, emitted_radiance, sample_chosen_light};
    import package::light::area_light::pdf_area_light;
    import package::scene::fetch::{LIGHT_ENVIRONMENT, fetch_light};
    import package::scene::surface::surface_at;
    import package::scene::trace::closest_hit;";

fn prepared(environment: Environment, sampling: LightSampling) -> Prepared {
    let mut scene = every_kind(environment);
    scene.render.estimator.light_sampling = sampling;
    prepared_for(scene, Strategy::MisPower, LightSelection::Uniform)
}

/// The frame of a surface that faces +z: samples by area and by solid angle do not depend on it.
fn facing_z() -> ShadingFrame {
    frame_from_normal(DVec3::Z)
}

/// Centre, a vector along the front's normal (any, for what has none), and size.
fn place(prepared: &Prepared, light: &Emitter) -> (DVec3, DVec3, f64) {
    match *light {
        Emitter::Area { primitive, .. } => {
            match prepared.data.primitives[primitive as usize].geometry {
                PrimitiveGeometry::Rectangle { a, u, v } => {
                    (a + 0.5 * (u + v), u.cross(v).normalize(), u.length())
                }
                PrimitiveGeometry::Triangle { a, u, v } => {
                    (a + (u + v) / 3.0, u.cross(v).normalize(), u.length())
                }
                PrimitiveGeometry::Disk { a, u, v } => (a, u.cross(v).normalize(), u.length()),
                PrimitiveGeometry::Sphere { center, radius } => (center, -DVec3::Z, radius),
                PrimitiveGeometry::Ellipsoid { center, radii, .. } => {
                    (center, -DVec3::Z, radii.max_element())
                }
            }
        }
        Emitter::Delta(Light::Point(PointLight { position, .. })) => (position, -DVec3::Z, 0.2),
        Emitter::Delta(Light::Spot(SpotLight {
            position,
            direction,
            ..
        })) => (position, direction, 0.2),
        Emitter::Delta(Light::Directional(_) | Light::Sun(_))
        | Emitter::Sun(_)
        | Emitter::Environment => (DVec3::ZERO, DVec3::Z, 0.2),
    }
}

/// Points to light: before the front, aslant, nearly in the light's plane, close, and behind.
fn receivers(prepared: &Prepared, light: &Emitter) -> Vec<DVec3> {
    let (centre, normal, size) = place(prepared, light);
    let tangent = frame_from_normal(normal).x;
    [(3.0, 0.0), (1.0, 2.0), (0.01, 4.0), (1.1, 0.3), (-2.0, 1.0)]
        .map(|(along, across)| rounded(centre + size * (along * normal + across * tangent)))
        .into()
}

/// What rounding does to a sample: to its direction, and relative to its densities. A point on a
/// light is known to 16 roundings of its coordinates; seen from the distance d that is an angle of
/// twice as much over d; the normal is known to as many over the sine between the edges, of an
/// ellipsoid times the square of its aspect. All of it over the cosine at the light.
fn errors(prepared: &Prepared, light: &Emitter, x: DVec3, s: &LightSample) -> (f64, f64) {
    let d = (s.target_point - x).length();
    let (size, normal) = match *light {
        Emitter::Area { primitive, .. } => match prepared.data.primitives[primitive as usize]
            .geometry
        {
            PrimitiveGeometry::Triangle { a, u, v }
            | PrimitiveGeometry::Rectangle { a, u, v }
            | PrimitiveGeometry::Disk { a, u, v } => {
                let size = a.length() + u.length() + v.length();
                let height = u.cross(v).length() / u.length().max(v.length());
                (size, 16.0 * U * (1.0 + size / height))
            }
            PrimitiveGeometry::Sphere { center, radius } => (center.length() + radius, 16.0 * U),
            PrimitiveGeometry::Ellipsoid { center, radii, .. } => {
                let aspect = radii.max_element() / radii.min_element();
                let size = center.length() + radii.max_element();
                (size, 16.0 * U * aspect * aspect)
            }
        },
        Emitter::Delta(_) | Emitter::Sun(_) => (1.0, 0.0),
        // Near the poles r = √((1 − y)(1 + y)) amplifies the rounding of y, to q = 8 roundings of 1
        // − y².
        Emitter::Environment => {
            let to_map = prepared
                .data
                .scene
                .environment
                .as_ref()
                .unwrap()
                .rotation
                .transpose();
            let d = to_map * s.wi;
            let q = 8.0 * U;
            let across = (q / d.x.hypot(d.z).max(U)).min(q.sqrt());
            return (64.0 * U + across, 64.0 * U);
        }
    };
    let angle = 2.0 * 16.0 * U * (size + x.length()) / d + 16.0 * U;
    (
        angle,
        2.0 * angle + (angle + normal) / s.cos_light + 64.0 * U,
    )
}

/// How much an interpolated map changes over `angle` around `direction`; 0 without a map.
fn texel_error(world: &World<'_>, direction: DVec3, angle: f64) -> f64 {
    let environment = world.prepared.data.scene.environment.as_ref().unwrap();
    let EnvironmentRadiance::Map(map) = &environment.radiance else {
        return 0.0;
    };
    let texels = map.texels.as_flattened();
    let largest = environment.scale * f64::from(texels.iter().copied().fold(0.0, f32::max));
    let image = map_from_direction(environment.rotation.transpose() * direction);
    let sin_polar = (PI * image.y).sin().max(U);
    let columns = f64::from(map.width) * (angle / (TAU * sin_polar)).min(1.0);
    let rows = f64::from(map.height) * angle / PI;
    largest * (columns + rows).min(1.0)
}

/// Samples for a histogram: of a sphere's a third arrives, which has to show 2 % of 527 cells.
const DRAWN: usize = 3_000_000;

/// Directions of the samples that arrive; the selection of the light has probability 1 here.
fn directions(
    context: &Context,
    prepared: &Prepared,
    index: u32,
    x: DVec3,
    seed: u32,
) -> Vec<DVec3> {
    let body = format!(
        "let words = pcg4d(vec4u(item, 41u, 42u, {seed}u));
         let s = sample_chosen_light(
             LightChoice({index}u, ExpectedSamples(1.0)), vec3f({:?}, {:?}, {:?}), frame_from_normal(vec3f(0.0, 0.0, 1.0)),
             to_unit_2d(words.xy), words.z);
         out_vec3f(0u, s.wi);
         out_f32(3u, s.pdf.value);",
        x.x, x.y, x.z
    );
    let function = Function {
        imports: IMPORTS,
        body: &body,
        inputs: 0,
        outputs: 4,
        features: &[],
    };
    let answers = call_in(context, prepared, &function, &[], DRAWN);
    let arriving = answers
        .vec3(0)
        .zip(answers.f64(3))
        .filter(|(_, pdf)| *pdf > 0.0);
    arriving.map(|(wi, _)| wi).collect()
}

#[test]
fn surfaces_emit_on_their_front_and_where_two_sided_on_their_back() {
    let prepared = prepared(constant_environment(), LightSampling::Area);
    let world = World::new(&prepared);
    let function = Function {
        imports: IMPORTS,
        body: "out_vec3f(0u, emitted_radiance(in_u32(0u), in_u32(1u) == 1u, vec2f(0.0)));",
        inputs: 2,
        outputs: 3,
        features: &[],
    };
    let area = |i: &u32| matches!(prepared.emitters.lights[*i as usize], Emitter::Area { .. });
    let lights = 0..prepared.emitters.lights.len() as u32;
    let cases: Vec<[u32; 2]> = lights.filter(area).flat_map(|i| [[i, 0], [i, 1]]).collect();
    let answers = call_in(
        context(),
        &prepared,
        &function,
        cases.as_flattened(),
        cases.len(),
    );
    let mut dark = 0;
    for (&[light, front], radiance) in cases.iter().zip(answers.vec3(0)) {
        let expected = emitted_radiance(&world, light, front == 1, DVec2::ZERO);
        assert_eq!(radiance, rounded(expected), "light {light}, front {front}");
        dark += usize::from(expected == DVec3::ZERO);
    }
    assert_eq!(dark, 4, "four backs of five");
}
