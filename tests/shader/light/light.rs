//! `shaders/light/light.wesl`: light sampling from points around every kind of light.

use crate::support::every_kind::{constant_environment, environment_map, every_kind};
use crate::support::rounding::{UNIT, close, numbers, rounded};
use crate::support::shader::{Answers, Function, call_in, words};
use crate::support::{context, edge_points, floor_pixel, histogram, point_light, statistics};
use direkt::accel::PrimitiveGeometry;
use direkt::emitters::Emitter;
use direkt::gpu::Context;
use direkt::reference::BrokenTwin;
use direkt::reference::broken::BROKEN_TWINS;
use direkt::reference::core::frame::{frame_from_normal, to_local};
use direkt::reference::core::pdf::PdfDiscrete;
use direkt::reference::core::ray::Ray;
use direkt::reference::core::ray_planar::intersect_rectangle;
use direkt::reference::core::ray_sphere::intersect_sphere;
use direkt::reference::light::alias_table::Choice;
use direkt::reference::light::environment::map_from_direction;
use direkt::reference::light::light::{
    LightSample, choose_light, emitted_radiance, environment_cell_margin, environment_radiance,
    pdf_area_light, pdf_environment, sample_chosen_light,
};
use direkt::reference::light::sphere::sample_sphere_area;
use direkt::reference::scene::fetch::World;
use direkt::render::Prepared;
use direkt::scene::light::Interpolation;
use direkt::scene::{Environment, EnvironmentRadiance, Light, LightSelection, Strategy};
use direkt::stats::chi2::{Totals, chi2_test};
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

const IMPORTS: &str = "import package::core::pdf::PdfDiscrete;
    import package::core::ray::Ray;
    import package::core::rng::{pcg4d, to_unit_2d};
    import package::light::alias_table::Choice;
    import package::light::light::{
        choose_light, emitted_radiance, environment_radiance, pdf_area_light, pdf_environment, sample_chosen_light};
    import package::scene::fetch::{LIGHT_ENVIRONMENT, fetch_light};
    import package::scene::surface::surface_at;
    import package::scene::trace::closest_hit;";

fn prepared(environment: Environment) -> Prepared {
    let scene = every_kind(environment);
    Prepared::new(scene, Strategy::MisPower, LightSelection::Uniform)
}

/// Centre, a vector along the front's normal (any, for what has none), and size.
fn place(prepared: &Prepared, light: &Emitter) -> (DVec3, DVec3, f64) {
    match *light {
        Emitter::Area { primitive, .. } => match prepared.primitives[primitive as usize].geometry {
            PrimitiveGeometry::Rectangle { a, u, v } => {
                (a + 0.5 * (u + v), u.cross(v).normalize(), u.length())
            }
            PrimitiveGeometry::Triangle { a, u, v } => {
                (a + (u + v) / 3.0, u.cross(v).normalize(), u.length())
            }
            PrimitiveGeometry::Disk { a, u, v } => (a, u.cross(v).normalize(), u.length()),
            PrimitiveGeometry::Sphere { center, radius } => (center, -DVec3::Z, radius),
        },
        Emitter::Delta(Light::Point { position, .. }) => (position, -DVec3::Z, 0.2),
        Emitter::Delta(Light::Spot {
            position,
            direction,
            ..
        }) => (position, direction, 0.2),
        Emitter::Delta(Light::Directional { .. }) | Emitter::Environment => {
            (DVec3::ZERO, DVec3::Z, 0.2)
        }
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

/// One item: which light with which probability, from where, and the random numbers.
struct Item {
    choice: Choice,
    x: DVec3,
    u: DVec2,
    texel: u32,
}

fn sampled(context: &Context, prepared: &Prepared, items: &[Item]) -> Answers {
    let function = Function {
        imports: IMPORTS,
        body: "let choice = Choice(in_u32(0u), PdfDiscrete(in_f32(1u)));
               let s = sample_chosen_light(choice, in_vec3f(2u), in_vec2f(5u), in_u32(7u));
               out_vec3f(0u, s.wi); out_vec3f(3u, s.target_point); out_vec3f(6u, s.radiance_over_pdf);
               out_f32(9u, s.pdf.value); out_bool(10u, s.delta);",
        inputs: 8,
        outputs: 11,
        features: &[],
    };
    let inputs: Vec<u32> = items
        .iter()
        .flat_map(|i| {
            let mut input = vec![i.choice.index];
            let p = i.choice.probability.0;
            input.extend(words(&[p, i.x.x, i.x.y, i.x.z, i.u.x, i.u.y]));
            input.push(i.texel);
            input
        })
        .collect();
    call_in(context, prepared, &function, &inputs, items.len())
}

/// What rounding does to a sample: to its direction, and relative to its densities. A point on a light is known to
/// 16 roundings of its coordinates; seen from the distance d that is an angle of twice as much over d; the normal is
/// known to as many over the sine between the edges. All of it over the cosine at the light.
fn errors(prepared: &Prepared, light: &Emitter, x: DVec3, s: &LightSample) -> (f64, f64) {
    let d = (s.target_point - x).length();
    let (size, normal) = match *light {
        Emitter::Area { primitive, .. } => match prepared.primitives[primitive as usize].geometry {
            PrimitiveGeometry::Triangle { a, u, v }
            | PrimitiveGeometry::Rectangle { a, u, v }
            | PrimitiveGeometry::Disk { a, u, v } => {
                let size = a.length() + u.length() + v.length();
                let height = u.cross(v).length() / u.length().max(v.length());
                (size, 16.0 * UNIT * (1.0 + size / height))
            }
            PrimitiveGeometry::Sphere { center, radius } => (center.length() + radius, 16.0 * UNIT),
        },
        Emitter::Delta(_) => (1.0, 0.0),
        // Near the poles r = √((1 − y)(1 + y)) amplifies the rounding of y, to q = 8 roundings of 1 − y².
        Emitter::Environment => {
            let to_map = prepared
                .scene
                .environment
                .as_ref()
                .unwrap()
                .rotation
                .transpose();
            let d = to_map * s.wi;
            let q = 8.0 * UNIT;
            let across = (q / d.x.hypot(d.z).max(UNIT)).min(q.sqrt());
            return (64.0 * UNIT + across, 64.0 * UNIT);
        }
    };
    let angle = 2.0 * 16.0 * UNIT * (size + x.length()) / d + 16.0 * UNIT;
    (
        angle,
        2.0 * angle + (angle + normal) / s.cos_light + 64.0 * UNIT,
    )
}

#[test]
fn light_samples_are_the_twins() {
    let context = context();
    for environment in [
        constant_environment(),
        environment_map(Interpolation::Linear),
    ] {
        let prepared = prepared(environment);
        let world = World::new(&prepared);
        let mut items = Vec::new();
        for (index, light) in (0..).zip(&prepared.emitters.lights) {
            for (k, x) in (0..).zip(receivers(&prepared, light)) {
                for (j, u) in (0..).zip(edge_points()) {
                    // Words from the ends and from anywhere.
                    let texel = [0, u32::MAX, (j * 2_654_435_761_u64 + k) as u32][j as usize % 3];
                    items.push(Item {
                        choice: Choice {
                            index,
                            probability: PdfDiscrete(0.125),
                        },
                        x,
                        u,
                        texel,
                    });
                }
            }
        }
        let answers = sampled(&context, &prepared, &items);
        let vectors = answers.vec3(0).zip(answers.vec3(3).zip(answers.vec3(6)));
        let numbers = answers.f64(9).zip(answers.u32(10));
        let mut behind = 0;
        for (item, ((wi, (target, radiance)), (pdf, delta))) in
            items.iter().zip(vectors.zip(numbers))
        {
            let light = &prepared.emitters.lights[item.choice.index as usize];
            let s = sample_chosen_light(&world, item.choice, item.x, item.u, item.texel);
            let what = format!(
                "{}: {light:?} from {}, {}",
                context.adapter.name, item.x, item.u
            );
            assert!(
                wi.is_finite() && radiance.is_finite() && pdf.is_finite(),
                "{what}"
            );
            if s.radiance_over_pdf == DVec3::ZERO && s.pdf.0 == 0.0 && !s.delta {
                behind += 1;
                assert_eq!(radiance, DVec3::ZERO, "{what}: from behind");
                continue;
            }
            let (angle, relative) = errors(&prepared, light, item.x, &s);
            assert!((wi - s.wi).length() <= angle, "{what}: {wi}, not {}", s.wi);
            assert_eq!(delta == 1, s.delta, "{what}");
            assert!(
                (pdf - s.pdf.0).abs() <= relative * s.pdf.0,
                "{what}: {pdf}, not {:?}",
                s.pdf
            );
            let reach = (s.target_point - item.x).length() + item.x.length();
            let off = (target - s.target_point).length();
            let turned = if *light == Emitter::Environment {
                angle * reach
            } else {
                0.0
            };
            assert!(
                off <= 64.0 * UNIT * (1.0 + reach) + turned,
                "{what}: {target}, off by {off:.1e}"
            );
            let absolute = match light {
                // f² of the falloff: twice the error of the cosine over the range of cosines.
                Emitter::Delta(Light::Spot {
                    inner_angle,
                    outer_angle,
                    intensity,
                    ..
                }) => {
                    let range = inner_angle.cos() - outer_angle.cos();
                    let d2 = (s.target_point - item.x).length_squared();
                    2.0 * angle / range * intensity.max_element() / (d2 * 0.125)
                }
                Emitter::Environment => texel_error(&world, s.wi, angle) / s.pdf.0,
                _ => 0.0,
            };
            let off = (radiance - s.radiance_over_pdf).abs();
            let bound = relative * s.radiance_over_pdf + absolute;
            assert!(
                off.cmple(bound).all(),
                "{what}: {radiance}, not {}",
                s.radiance_over_pdf
            );
        }
        assert!(behind > 500, "{behind} samples of backs");
    }
}

/// How much an interpolated map changes over `angle` around `direction`; 0 without a map.
fn texel_error(world: &World<'_>, direction: DVec3, angle: f64) -> f64 {
    let environment = world.prepared.scene.environment.as_ref().unwrap();
    let EnvironmentRadiance::Map(map) = &environment.radiance else {
        return 0.0;
    };
    let texels = map.texels.as_flattened();
    let largest = environment.scale * f64::from(texels.iter().copied().fold(0.0, f32::max));
    let image = map_from_direction(environment.rotation.transpose() * direction);
    let sin_polar = (PI * image.y).sin().max(UNIT);
    let columns = f64::from(map.width) * (angle / (TAU * sin_polar)).min(1.0);
    let rows = f64::from(map.height) * angle / PI;
    largest * (columns + rows).min(1.0)
}

/// Nothing is divided by a distance of 0.
#[test]
fn a_point_at_a_light_receives_nothing() {
    let context = context();
    let prepared = prepared(constant_environment());
    let mut items = Vec::new();
    for (index, light) in (0..).zip(&prepared.emitters.lights) {
        if let Emitter::Delta(Light::Point { position, .. } | Light::Spot { position, .. }) = light
        {
            items.push(Item {
                choice: Choice {
                    index,
                    probability: PdfDiscrete(1.0),
                },
                x: rounded(*position),
                u: DVec2::splat(0.5),
                texel: 0,
            });
        }
    }
    assert_eq!(items.len(), 2);
    let answers = sampled(&context, &prepared, &items);
    assert!(answers.vec3(6).all(|radiance| radiance == DVec3::ZERO));
}

/// The density that a sample claims is that with which light sampling is evaluated where its direction ends. Both see
/// the light from the same point; the ray's point is off by 16 roundings over the cosine, as is the sample's.
#[test]
fn claimed_densities_are_the_evaluated_ones() {
    let context = context();
    let prepared = prepared(environment_map(Interpolation::Nearest));
    let world = World::new(&prepared);
    let function = Function {
        imports: IMPORTS,
        body: "let index = in_u32(0u);
               let light = fetch_light(index);
               let x = in_vec3f(1u);
               let s = sample_chosen_light(Choice(index, PdfDiscrete(light.selection)), x, in_vec2f(4u), in_u32(6u));
               let ray = Ray(x, s.wi);
               let hit = closest_hit(ray);
               var pdf = 0.0;
               if hit.primitive != 0xffffffffu {
                   let y = surface_at(ray, hit, -ray.direction);
                   if y.light == index && y.front {
                       pdf = pdf_area_light(index, hit.t * hit.t, y.wo.z).value;
                   }
               }
               if light.kind == LIGHT_ENVIRONMENT {
                   pdf = pdf_environment(s.wi).value;
               }
               out_f32(0u, s.pdf.value);
               out_f32(1u, pdf);
               out_vec3f(2u, s.wi);",
        inputs: 7,
        outputs: 5,
        features: &[],
    };
    let mut inputs = Vec::new();
    let mut items = Vec::new();
    for (index, light) in (0..).zip(&prepared.emitters.lights) {
        if matches!(light, Emitter::Delta(_)) {
            continue;
        }
        for (k, x) in (0..).zip(receivers(&prepared, light)) {
            for i in 0..500 {
                let [a, b, c, _] = numbers(i, k, 40);
                let texel = (c * 4_294_967_296.0) as u32;
                inputs.push(index);
                inputs.extend(words(&[x.x, x.y, x.z, a, b]));
                inputs.push(texel);
                items.push((index, x, DVec2::new(a, b), texel));
            }
        }
    }
    let answers = call_in(&context, &prepared, &function, &inputs, items.len());
    let mut compared = [0; 16];
    let found = answers.f64(0).zip(answers.f64(1).zip(answers.vec3(2)));
    for ((index, x, u, texel), (claimed, (evaluated, wi))) in items.iter().zip(found) {
        let light = &prepared.emitters.lights[*index as usize];
        let choice = Choice {
            index: *index,
            probability: PdfDiscrete(prepared.emitters.probability(*index as usize)),
        };
        let s = sample_chosen_light(&world, choice, *x, *u, *texel);
        let (angle, relative) = errors(&prepared, light, *x, &s);
        let hidden = evaluated == 0.0 || claimed == 0.0;
        let at_edge =
            *light == Emitter::Environment && environment_cell_margin(&world, wi) < 2.0 * angle;
        if hidden || at_edge {
            continue;
        }
        // Near its horizon a sphere is met where the ray's distance from the centre says: an angle moves the cosine by
        // d/(r cosθ) times as much.
        let at_horizon = match light {
            Emitter::Area { primitive, .. } => {
                match prepared.primitives[*primitive as usize].geometry {
                    PrimitiveGeometry::Sphere { radius, .. } => {
                        angle * (s.target_point - *x).length()
                            / (radius * s.cos_light * s.cos_light)
                    }
                    _ => 0.0,
                }
            }
            _ => 0.0,
        };
        compared[*index as usize] += usize::from(at_horizon < 1e-2);
        assert!(
            at_horizon > 0.1
                || (claimed - evaluated).abs() <= 2.0 * (relative + at_horizon) * claimed,
            "{}: {light:?} from {x}: {claimed} claimed, {evaluated} found",
            context.adapter.name
        );
    }
    for (light, compared) in prepared.emitters.lights.iter().zip(compared) {
        let expected = !matches!(light, Emitter::Delta(_));
        assert!(
            !expected || compared > 300,
            "{light:?}: {compared} compared"
        );
    }
}

/// Where a direction from `x` meets an area light, in coordinates of [0, 1]², and the density per unit of these that a
/// density `pdf` per solid angle makes there.
fn on_light(geometry: &PrimitiveGeometry, x: DVec3, wi: DVec3) -> (DVec2, f64) {
    let ray = Ray {
        origin: x,
        direction: wi,
    };
    match *geometry {
        PrimitiveGeometry::Rectangle { a, u, v }
        | PrimitiveGeometry::Triangle { a, u, v }
        | PrimitiveGeometry::Disk { a, u, v } => {
            let hit = intersect_rectangle(&ray, a, u, v);
            let (st, jacobian) = match geometry {
                // (s/(1 − t), t).
                PrimitiveGeometry::Triangle { .. } => (
                    DVec2::new(hit.st.x / (1.0 - hit.st.y), hit.st.y),
                    1.0 - hit.st.y,
                ),
                // (r², φ/2π): r dr dφ = π dr² dφ/2π.
                PrimitiveGeometry::Disk { .. } => {
                    let angle = hit.st.y.atan2(hit.st.x) / TAU;
                    (
                        DVec2::new(hit.st.length_squared(), angle.rem_euclid(1.0)),
                        PI,
                    )
                }
                _ => (hit.st, 1.0),
            };
            let normal = u.cross(v);
            let solid_angle = (normal.dot(wi)).abs() / (hit.t * hit.t);
            (st, solid_angle * jacobian)
        }
        PrimitiveGeometry::Sphere { center, radius } => {
            // A direction to the horizon may round past it.
            let closest = (center - x).dot(wi);
            let t = intersect_sphere(&ray, center, radius).map_or(closest, |(near, _)| near);
            let normal = (x + t * wi - center).normalize();
            let axis = frame_from_normal((x - center).normalize());
            let local = to_local(&axis, normal);
            // The cap that is seen: cosines above r/d.
            let horizon = radius / (x - center).length();
            let p = DVec2::new(
                (local.z - horizon) / (1.0 - horizon),
                (local.y.atan2(local.x) / TAU).rem_euclid(1.0),
            );
            let area = radius * radius * TAU * (1.0 - horizon);
            (p, area * -normal.dot(wi) / (t * t))
        }
    }
}

/// The direction from `x` to the point of the light with coordinates `p`; the inverse of [`on_light`].
fn towards(geometry: &PrimitiveGeometry, x: DVec3, p: DVec2) -> DVec3 {
    let point = match *geometry {
        PrimitiveGeometry::Rectangle { a, u, v } => a + p.x * u + p.y * v,
        PrimitiveGeometry::Triangle { a, u, v } => a + p.x * (1.0 - p.y) * u + p.y * v,
        PrimitiveGeometry::Disk { a, u, v } => {
            let (sin, cos) = (TAU * p.y).sin_cos();
            a + p.x.sqrt() * (cos * u + sin * v)
        }
        PrimitiveGeometry::Sphere { center, radius } => {
            let f = frame_from_normal((x - center).normalize());
            let horizon = radius / (x - center).length();
            let z = horizon + p.x * (1.0 - horizon);
            let r = (1.0 - z * z).max(0.0).sqrt();
            let (sin, cos) = (TAU * p.y).sin_cos();
            center + radius * (r * cos * f.x + r * sin * f.y + z * f.z)
        }
    };
    (point - x).normalize()
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
             Choice({index}u, PdfDiscrete(1.0)), vec3f({:?}, {:?}, {:?}), to_unit_2d(words.xy), words.z);
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

/// Directions towards area lights against `pdf_area_light` per solid angle, in coordinates of the light, where no cell
/// is cut by its edge.
#[test]
fn directions_towards_area_lights_match_pdf() {
    let context = context();
    let prepared = prepared(constant_environment());
    let world = World::new(&prepared);
    let mut tested = 0;
    for (index, light) in (0_u32..).zip(&prepared.emitters.lights) {
        let Emitter::Area { primitive, .. } = *light else {
            continue;
        };
        let geometry = &prepared.primitives[primitive as usize].geometry;
        for (k, x) in (0..).zip(receivers(&prepared, light).into_iter().take(2)) {
            tested += 1;
            let seed = 50 + 4 * index + k;
            let wis = directions(&context, &prepared, index, x, seed);
            // A point on the border may round beyond it, by the angle that a direction is known to.
            let samples: Vec<DVec2> = wis
                .iter()
                .map(|wi| {
                    let (p, _) = on_light(geometry, x, *wi);
                    let inner = p.clamp(DVec2::ZERO, DVec2::ONE);
                    if (p - inner).length() < 1e-5 {
                        inner
                    } else {
                        p
                    }
                })
                .collect();
            // A sphere's back is sampled as well, and nothing arrives from there: the density is that of all samples.
            let all = DRAWN as f64 / samples.len() as f64;
            let selection = prepared.emitters.probability(index as usize);
            let pdf = |p: DVec2, cosines: f64| {
                let wi = towards(geometry, x, p);
                let (_, to_solid_angle) = on_light(geometry, x, wi);
                let (d2, cos) = distance_and_cosine(geometry, x, wi);
                let pdf = pdf_area_light(&world, index, d2, cos).0 / selection;
                all * pdf * to_solid_angle * cos.powf(cosines)
            };
            let what = format!(
                "{geometry:?} from {x}, seed {seed}, {}",
                context.adapter.name
            );
            let test = |pdf: &dyn Fn(DVec2) -> f64| {
                histogram::p_value(&samples, DVec2::ZERO, DVec2::ONE, pdf)
            };
            statistics::accept(test(&|p| pdf(p, 0.0)), &what);
            for row in BROKEN_TWINS {
                let broken = match row.twin {
                    BrokenTwin::PdfScaled => test(&|p| 1.02 * pdf(p, 0.0)),
                    // The density per area, taken for that per solid angle.
                    BrokenTwin::WrongMeasure => test(&|p| {
                        let wi = towards(geometry, x, p);
                        all * on_light(geometry, x, wi).1 / geometry.area()
                    }),
                    BrokenTwin::ExtraCosine => test(&|p| 1.5 * pdf(p, 1.0)),
                    // One light alone is sampled, and no BSDF.
                    BrokenTwin::LightLeftOut
                    | BrokenTwin::SwappedSinCos
                    | BrokenTwin::MisWeights => continue,
                };
                statistics::reject(broken, &format!("{what}, {}", row.name));
            }
        }
    }
    assert_eq!(tested, 8, "four kinds from two points each");
}

/// Squared distance and cosine at the light.
fn distance_and_cosine(geometry: &PrimitiveGeometry, x: DVec3, wi: DVec3) -> (f64, f64) {
    let ray = Ray {
        origin: x,
        direction: wi,
    };
    match *geometry {
        PrimitiveGeometry::Rectangle { a, u, v }
        | PrimitiveGeometry::Triangle { a, u, v }
        | PrimitiveGeometry::Disk { a, u, v } => {
            let t = intersect_rectangle(&ray, a, u, v).t;
            (t * t, u.cross(v).normalize().dot(wi).abs())
        }
        PrimitiveGeometry::Sphere { center, radius } => {
            let (t, _) = intersect_sphere(&ray, center, radius).expect("it is aimed at");
            (t * t, -(x + t * wi - center).dot(wi) / radius)
        }
    }
}

#[test]
fn directions_towards_the_environment_match_pdf() {
    let context = context();
    for (seed, environment) in (80..).zip([
        constant_environment(),
        environment_map(Interpolation::Nearest),
        environment_map(Interpolation::Linear),
    ]) {
        let prepared = prepared(environment);
        let world = World::new(&prepared);
        let lights = &prepared.emitters.lights;
        let index = lights
            .iter()
            .position(|l| *l == Emitter::Environment)
            .unwrap();
        let wis = directions(&context, &prepared, index as u32, DVec3::ZERO, seed);
        let rotation = prepared.scene.environment.as_ref().unwrap().rotation;
        // In coordinates of the image, whose texels are the cells here: (31, 17).
        let samples: Vec<DVec2> = wis
            .iter()
            .map(|wi| map_from_direction(rotation.transpose() * *wi))
            .collect();
        let direction = |p: DVec2| {
            let (sin, cos) = (PI * p.y).sin_cos();
            let (sin_phi, cos_phi) = (TAU * p.x).sin_cos();
            rotation * DVec3::new(-sin_phi * sin, cos, cos_phi * sin)
        };
        // dω = 2π² sinθ du dv.
        let pdf = |p: DVec2, of: &dyn Fn(DVec3) -> f64| {
            of(direction(p)) * 2.0 * PI * PI * (PI * p.y).sin()
        };
        let (choice, _, _) = pdf_environment(&world, DVec3::Z);
        let right = |w: DVec3| pdf_environment(&world, w).2.0 / choice.0;
        let what = format!("environment, seed {seed}, {}", context.adapter.name);
        let test = |samples: &[DVec2], of: &dyn Fn(DVec3) -> f64| {
            histogram::p_value(samples, DVec2::ZERO, DVec2::ONE, |p| pdf(p, of))
        };
        statistics::accept(test(&samples, &right), &what);
        for row in BROKEN_TWINS {
            let broken = match row.twin {
                BrokenTwin::PdfScaled => test(&samples, &|w| 1.02 * right(w)),
                // Density on the image taken for that per solid angle; without a map there is none.
                BrokenTwin::WrongMeasure => {
                    if prepared.emitters.environment.is_none() {
                        continue;
                    }
                    test(&samples, &|w| pdf_environment(&world, w).1.unwrap().0)
                }
                BrokenTwin::ExtraCosine => test(&samples, &|w| 2.0 * right(w) * w.z.abs()),
                // One light alone is sampled, and no BSDF.
                BrokenTwin::LightLeftOut | BrokenTwin::SwappedSinCos | BrokenTwin::MisWeights => {
                    continue;
                }
            };
            statistics::reject(broken, &format!("{what}, {}", row.name));
        }
    }
}

/// Radiance of both kinds of map and density in random directions, except at the edges of texels.
#[test]
fn the_environment_is_the_twins() {
    let context = context();
    for environment in [
        constant_environment(),
        environment_map(Interpolation::Nearest),
        environment_map(Interpolation::Linear),
    ] {
        let prepared = prepared(environment);
        let world = World::new(&prepared);
        let function = Function {
            imports: IMPORTS,
            body: "let w = in_vec3f(0u);
                   out_vec3f(0u, environment_radiance(w));
                   out_f32(3u, pdf_environment(w).value);",
            inputs: 3,
            outputs: 4,
            features: &[],
        };
        let mut directions: Vec<DVec3> = (0..10_000)
            .map(|i| {
                let [a, b, ..] = numbers(i, 5, 43);
                rounded(sample_sphere_area(DVec2::new(a, b)))
            })
            .collect();
        directions.extend([
            DVec3::X,
            DVec3::Y,
            DVec3::Z,
            -DVec3::X,
            -DVec3::Y,
            -DVec3::Z,
        ]);
        let inputs: Vec<f64> = directions.iter().flat_map(DVec3::to_array).collect();
        let answers = call_in(
            &context,
            &prepared,
            &function,
            &words(&inputs),
            directions.len(),
        );
        let angle = 16.0 * UNIT;
        let linear = prepared
            .effects
            .contains(direkt::effects::Effect::EnvironmentLinear);
        for (w, (radiance, pdf)) in directions.iter().zip(answers.vec3(0).zip(answers.f64(3))) {
            assert!(radiance.is_finite() && pdf.is_finite());
            if environment_cell_margin(&world, *w) < angle {
                continue;
            }
            let expected = environment_radiance(&world, *w);
            let slope = if linear {
                texel_error(&world, *w, angle)
            } else {
                0.0
            };
            let off = (radiance - expected).abs();
            assert!(
                off.cmple(16.0 * UNIT * expected + slope).all(),
                "{}: {radiance} from {w}, not {expected}",
                context.adapter.name
            );
            let expected = pdf_environment(&world, *w).2.0;
            assert!(close(pdf, expected, 64.0), "{pdf} at {w}, not {expected}");
        }
    }
}

#[test]
fn surfaces_emit_on_their_front_and_where_two_sided_on_their_back() {
    let prepared = prepared(constant_environment());
    let world = World::new(&prepared);
    let function = Function {
        imports: IMPORTS,
        body: "out_vec3f(0u, emitted_radiance(in_u32(0u), in_u32(1u) == 1u));",
        inputs: 2,
        outputs: 3,
        features: &[],
    };
    let area = |i: &u32| matches!(prepared.emitters.lights[*i as usize], Emitter::Area { .. });
    let lights = 0..prepared.emitters.lights.len() as u32;
    let cases: Vec<[u32; 2]> = lights.filter(area).flat_map(|i| [[i, 0], [i, 1]]).collect();
    let answers = call_in(
        &context(),
        &prepared,
        &function,
        cases.as_flattened(),
        cases.len(),
    );
    let mut dark = 0;
    for (&[light, front], radiance) in cases.iter().zip(answers.vec3(0)) {
        let expected = emitted_radiance(&world, light, front == 1);
        assert_eq!(radiance, rounded(expected), "light {light}, front {front}");
        dark += usize::from(expected == DVec3::ZERO);
    }
    assert_eq!(dark, 3, "three backs of four");
}

/// Lights that are chosen from: all kinds, or two of powers 1 : 10⁶.
fn choices() -> Vec<(String, Prepared)> {
    let mut two = floor_pixel();
    two.lights = vec![
        point_light(DVec3::new(0.0, 0.0, 1.0), 1e-3),
        point_light(DVec3::new(1.0, 0.0, 1.0), 1e3),
    ];
    let scenes = [
        ("all kinds", every_kind(constant_environment())),
        ("1 : 1e6", two),
    ];
    let mut out = Vec::new();
    for (name, scene) in scenes {
        for selection in [LightSelection::Uniform, LightSelection::Power] {
            let prepared = Prepared::new(scene.clone(), Strategy::MisPower, selection);
            out.push((format!("{name}, {selection}"), prepared));
        }
    }
    out
}

#[test]
fn lights_are_chosen_as_by_the_twin() {
    let context = context();
    let function = Function {
        imports: IMPORTS,
        body: "let c = choose_light(in_u32(0u)); out_u32(0u, c.index); out_f32(1u, c.probability.value);",
        inputs: 1,
        outputs: 2,
        features: &[],
    };
    let ends = [0, 1, u32::MAX, u32::MAX - 1, 1 << 31, (1 << 31) - 1];
    let words: Vec<u32> = ends
        .into_iter()
        .chain((0..10_000).map(|i: u32| i.wrapping_mul(2_654_435_761)))
        .collect();
    for (name, prepared) in choices() {
        let world = World::new(&prepared);
        let answers = call_in(&context, &prepared, &function, &words, words.len());
        for (word, (index, p)) in words.iter().zip(answers.u32(0).zip(answers.f64(1))) {
            let expected = choose_light(&world, *word).unwrap();
            assert_eq!(index, expected.index, "{name}: word {word}");
            assert_eq!(
                p as f32, expected.probability.0 as f32,
                "{name}: word {word}"
            );
        }
    }
}

/// 2²⁴ random words against the realised probabilities.
#[test]
fn lights_are_chosen_at_their_probability() {
    let context = context();
    for (seed, (name, prepared)) in (90..).zip(choices()) {
        let count = prepared.emitters.lights.len();
        let body = format!(
            "var chosen = array<u32, {count}>();
             for (var k = 0u; k < 16u; k += 1u) {{
                 let c = choose_light(pcg4d(vec4u(item, k, 44u, {seed}u)).x);
                 chosen[c.index] += 1u;
             }}
             for (var i = 0u; i < {count}u; i += 1u) {{ out_u32(i, chosen[i]); }}"
        );
        let function = Function {
            imports: IMPORTS,
            body: &body,
            inputs: 0,
            outputs: count,
            features: &[],
        };
        let answers = call_in(&context, &prepared, &function, &[], 1 << 20);
        let counts: Vec<u64> = (0..count)
            .map(|i| answers.u32(i).map(u64::from).sum())
            .collect();
        let expected = |factor: f64| -> Vec<f64> {
            let p = |i| factor * prepared.emitters.probability(i) * f64::from(1 << 24);
            (0..count).map(p).collect()
        };
        let p_value = |counts: &[u64], factor: f64| {
            chi2_test(counts, &expected(factor), Totals::Free)
                .unwrap()
                .p_value
        };
        let what = format!(
            "choose_light, {name}, seed {seed}, {}",
            context.adapter.name
        );
        statistics::accept(p_value(&counts, 1.0), &what);
        for row in BROKEN_TWINS {
            let broken = match row.twin {
                BrokenTwin::PdfScaled => p_value(&counts, 1.02),
                BrokenTwin::LightLeftOut => {
                    let mut counts = counts.clone();
                    let most = (0..count).max_by(|a, b| {
                        let p = |i: &usize| prepared.emitters.probability(*i);
                        p(a).total_cmp(&p(b))
                    });
                    counts[most.unwrap()] = 0;
                    p_value(&counts, 1.0)
                }
                // A choice has no direction.
                BrokenTwin::WrongMeasure
                | BrokenTwin::SwappedSinCos
                | BrokenTwin::MisWeights
                | BrokenTwin::ExtraCosine => continue,
            };
            statistics::reject(broken, &format!("{what}, {}", row.name));
        }
    }
}
