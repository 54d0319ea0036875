//! Samples against the twin, and against what the ray that they send evaluates.

use super::{IMPORTS, errors, facing_z, prepared, receivers, texel_error};
use crate::support::every_kind::{constant_environment, environment_map};
use crate::support::random::{numbers, rounded};
use crate::support::rounding::U;
use crate::support::shader::{Answers, Function, call_in, words};
use crate::support::{context, edge_points};
use direkt::low_level::accel::PrimitiveGeometry;
use direkt::low_level::emitters::Emitter;
use direkt::low_level::gpu::Context;
use direkt::low_level::prepare::Prepared;
use direkt::low_level::reference::core::pdf::PdfDiscrete;
use direkt::low_level::reference::light::alias_table::Choice;
use direkt::low_level::reference::light::ellipsoid::Ellipsoid;
use direkt::low_level::reference::light::environment::environment_cell_margin;
use direkt::low_level::reference::light::light::sample_chosen_light;
use direkt::low_level::reference::scene::fetch::World;
use direkt::scene::environment::Interpolation;
use direkt::scene::{Light, LightSampling, PointLight, SpotLight};
use glam::{DVec2, DVec3};

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
        body: "let choice = LightChoice(in_u32(0u), ExpectedSamples(in_f32(1u)));
               let s = sample_chosen_light(
                   choice, in_vec3f(2u), frame_from_normal(vec3f(0.0, 0.0, 1.0)), in_vec2f(5u), in_u32(7u));
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

#[test]
fn light_samples_are_the_twins() {
    let context = context();
    for environment in [
        constant_environment(),
        environment_map(Interpolation::Linear),
    ] {
        let prepared = prepared(environment, LightSampling::Area);
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
        let answers = sampled(context, &prepared, &items);
        let vectors = answers.vec3(0).zip(answers.vec3(3).zip(answers.vec3(6)));
        let numbers = answers.f64(9).zip(answers.u32(10));
        let mut behind = 0;
        for (item, ((wi, (target, radiance)), (pdf, delta))) in
            items.iter().zip(vectors.zip(numbers))
        {
            let light = &prepared.emitters.lights[item.choice.index as usize];
            let s = sample_chosen_light(
                &world,
                item.choice,
                (item.x, &facing_z()),
                item.u,
                item.texel,
            );
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
                off <= 64.0 * U * (1.0 + reach) + turned,
                "{what}: {target}, off by {off:.1e}"
            );
            let absolute = match light {
                // f² of the falloff: twice the error of the cosine over the range of cosines.
                Emitter::Delta(Light::Spot(SpotLight {
                    inner_angle,
                    outer_angle,
                    intensity,
                    ..
                })) => {
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

/// Nothing is divided by a distance of 0.
#[test]
fn a_point_at_a_light_receives_nothing() {
    let context = context();
    let prepared = prepared(constant_environment(), LightSampling::Area);
    let mut items = Vec::new();
    for (index, light) in (0..).zip(&prepared.emitters.lights) {
        if let Emitter::Delta(
            Light::Point(PointLight { position, .. }) | Light::Spot(SpotLight { position, .. }),
        ) = light
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
    let answers = sampled(context, &prepared, &items);
    assert!(answers.vec3(6).all(|radiance| radiance == DVec3::ZERO));
}

/// The density that a sample claims is that with which light sampling is evaluated where its
/// direction ends. Both see the light from the same point; the ray's point is off by 16 roundings
/// over the cosine, as is the sample's.
#[test]
fn claimed_densities_are_the_evaluated_ones() {
    let context = context();
    let prepared = prepared(environment_map(Interpolation::Nearest), LightSampling::Area);
    let world = World::new(&prepared);
    let function = Function {
        imports: IMPORTS,
        body: "let index = in_u32(0u);
               let light = fetch_light(index);
               let x = in_vec3f(1u);
               let facing = frame_from_normal(vec3f(0.0, 0.0, 1.0));
               let s = sample_chosen_light(
                   LightChoice(index, light.expected_samples), x, facing, in_vec2f(4u), in_u32(6u));
               let ray = Ray(x, s.wi);
               let hit = closest_hit(ray);
               var pdf = 0.0;
               if hit.primitive != 0xffffffffu {
                   let y = surface_at(ray, hit, -ray.direction);
                   if y.light == index && y.front {
                       pdf = pdf_area_light(index, x, facing, s.wi, hit.t * hit.t, y.wo.z, hit.st).value;
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
    let answers = call_in(context, &prepared, &function, &inputs, items.len());
    let mut compared = [0; 16];
    let found = answers.f64(0).zip(answers.f64(1).zip(answers.vec3(2)));
    for ((index, x, u, texel), (claimed, (evaluated, wi))) in items.iter().zip(found) {
        let light = &prepared.emitters.lights[*index as usize];
        let choice = Choice {
            index: *index,
            probability: PdfDiscrete(prepared.emitters.probability(*index as usize)),
        };
        let s = sample_chosen_light(&world, choice, (*x, &facing_z()), *u, *texel);
        let (angle, relative) = errors(&prepared, light, *x, &s);
        let hidden = evaluated == 0.0 || claimed == 0.0;
        let at_edge =
            *light == Emitter::Environment && environment_cell_margin(&world, wi) < 2.0 * angle;
        if hidden || at_edge {
            continue;
        }
        // Near its horizon a sphere is met where the ray's distance from the centre says: an angle
        // moves the cosine by d/(r cosθ) times as much.
        let at_horizon = match light {
            Emitter::Area { primitive, .. } => {
                let geometry = &prepared.data.primitives[*primitive as usize].geometry;
                let radius = match geometry {
                    PrimitiveGeometry::Sphere { radius, .. } => Some(*radius),
                    _ => Ellipsoid::of(geometry).map(|e| e.curvature_radius(s.target_point)),
                };
                let over = |r: f64| (s.target_point - *x).length() / (r * s.cos_light.powi(2));
                radius.map_or(0.0, |r| angle * over(r))
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
