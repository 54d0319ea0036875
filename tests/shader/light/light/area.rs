//! Directions towards area lights against their density per solid angle.

use super::{DRAWN, directions, facing_z, prepared, receivers};
use crate::support::every_kind::{constant_environment, every_kind, with_right_angles};
use crate::support::random::rounded;
use crate::support::{context, emitter, floor_pixel, histogram, prepared_for, statistics};
use direkt::low_level::accel::PrimitiveGeometry;
use direkt::low_level::accel::octahedral::octahedral;
use direkt::low_level::emitters::Emitter;
use direkt::low_level::prepare::Prepared;
use direkt::low_level::reference::BrokenTwin;
use direkt::low_level::reference::broken::BROKEN_TWINS;
use direkt::low_level::reference::core::frame::{frame_from_normal, to_local};
use direkt::low_level::reference::core::ray::Ray;
use direkt::low_level::reference::core::ray_ellipsoid::ellipsoid_normal;
use direkt::low_level::reference::core::ray_planar::intersect_rectangle;
use direkt::low_level::reference::core::ray_sphere::intersect_sphere;
use direkt::low_level::reference::light::area_light::pdf_area_light;
use direkt::low_level::reference::light::ellipsoid::{Ellipsoid, view_ellipsoid};
use direkt::low_level::reference::scene::fetch::World;
use direkt::scene::ellipsoid::rotation;
use direkt::scene::{Geometry, LightSampling, LightSelection, Strategy};
use glam::{DMat3, DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// Where a direction meets an area light.
struct OnLight {
    /// In coordinates of [0, 1]².
    at: DVec2,
    /// Area per unit of these.
    area: f64,
    /// Squared distance.
    d2: f64,
    /// Cosine at the light.
    cos: f64,
    /// The light's coordinates, where its density depends on them.
    st: DVec2,
}

impl OnLight {
    /// Solid angle per unit of the coordinates.
    fn solid_angle(&self) -> f64 {
        self.area * self.cos / self.d2
    }
}

fn on_light(geometry: &PrimitiveGeometry, x: DVec3, wi: DVec3) -> OnLight {
    let ray = Ray {
        origin: x,
        direction: wi,
    };
    match *geometry {
        PrimitiveGeometry::Rectangle { a, u, v }
        | PrimitiveGeometry::Triangle { a, u, v }
        | PrimitiveGeometry::Disk { a, u, v } => {
            let hit = intersect_rectangle(&ray, a, u, v);
            let (at, jacobian) = match geometry {
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
            OnLight {
                at,
                area: normal.length() * jacobian,
                d2: hit.t * hit.t,
                cos: normal.normalize().dot(wi).abs(),
                st: DVec2::ZERO,
            }
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
            let at = DVec2::new(
                (local.z - horizon) / (1.0 - horizon),
                (local.y.atan2(local.x) / TAU).rem_euclid(1.0),
            );
            OnLight {
                at,
                area: radius * radius * TAU * (1.0 - horizon),
                d2: t * t,
                cos: -normal.dot(wi),
                st: DVec2::ZERO,
            }
        }
        PrimitiveGeometry::Ellipsoid { .. } => {
            // As on a sphere, in its space; areas are stretched by |det M| |M⁻ᵀp|.
            let e = Ellipsoid::of(geometry).unwrap();
            let seen = view_ellipsoid(e, x);
            let d = (e.axes.inverse() * wi).normalize();
            let off = seen.to_center - seen.to_center.dot(d) * d;
            let chord = (1.0 - off.length_squared()).max(0.0).sqrt();
            let p = (-off - chord * d).normalize();
            let local = to_local(&frame_from_normal(-seen.to_center.normalize()), p);
            let horizon = 1.0 / seen.to_center.length();
            let at = DVec2::new(
                (local.z - horizon) / (1.0 - horizon),
                (local.y.atan2(local.x) / TAU).rem_euclid(1.0),
            );
            let stretch = e.axes.determinant().abs() * (e.axes.inverse().transpose() * p).length();
            OnLight {
                at,
                area: stretch * TAU * (1.0 - horizon),
                d2: (e.point(p) - x).length_squared(),
                cos: -ellipsoid_normal(e.axes, p).dot(wi),
                st: octahedral(p),
            }
        }
    }
}

/// The direction from `x` to the point of the light with coordinates `p`; the inverse of
/// [`on_light`].
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
        PrimitiveGeometry::Ellipsoid { .. } => {
            let e = Ellipsoid::of(geometry).unwrap();
            let towards_x = e.axes.inverse() * (x - e.center);
            let f = frame_from_normal(towards_x.normalize());
            let horizon = 1.0 / towards_x.length();
            let z = horizon + p.x * (1.0 - horizon);
            let r = (1.0 - z * z).max(0.0).sqrt();
            let (sin, cos) = (TAU * p.y).sin_cos();
            e.point(r * cos * f.x + r * sin * f.y + z * f.z)
        }
    };
    (point - x).normalize()
}

/// Directions towards area lights against `pdf_area_light` per solid angle, in coordinates of the
/// light, where no cell is cut by its edge.
#[test]
fn directions_towards_area_lights_match_pdf() {
    let prepared = prepared(constant_environment(), LightSampling::Area);
    let tested = directions_match_pdf(&prepared, two_receivers);
    assert_eq!(tested, 10, "five kinds");
}

/// The same where lights are sampled over their solid angles, in one way if they have right angles,
/// in another if not.
#[test]
fn directions_over_solid_angles_match_pdf() {
    let mut scene = with_right_angles(every_kind(constant_environment()));
    scene.render.estimator.light_sampling = LightSampling::SolidAngle;
    let prepared = prepared_for(scene, Strategy::MisPower, LightSelection::Uniform);
    let tested = directions_match_pdf(&prepared, two_receivers);
    assert_eq!(tested, 14, "five kinds, two of them in two ways");
}

/// Close to ellipsoids, that around their outlines a rectangle is sampled: a round one, a flat one
/// and one like a disk.
#[test]
fn directions_towards_near_ellipsoids_match_pdf() {
    let mut scene = floor_pixel();
    for (i, radii) in (0_u8..).zip([[1.0, 0.7, 0.4], [1.0, 0.6, 0.05], [0.8, 1.0, 1e-4]]) {
        let geometry = Geometry::Ellipsoid {
            center: DVec3::new(3.0 * f64::from(i) - 3.0, 0.5, 3.0),
            axes: rotation(DVec3::new(0.2, 0.1, -0.3)) * DMat3::from_diagonal(radii.into()),
        };
        scene.shapes.push(emitter(geometry, 1.0, false));
    }
    scene.render.estimator.light_sampling = LightSampling::SolidAngle;
    let prepared = prepared_for(scene, Strategy::MisPower, LightSelection::Uniform);
    let near = |prepared: &Prepared, light: &Emitter| {
        let Emitter::Area { primitive, .. } = *light else {
            return Vec::new();
        };
        let e = Ellipsoid::of(&prepared.data.primitives[primitive as usize].geometry).unwrap();
        let p = DVec3::new(0.4, -0.3, -0.87).normalize();
        let x = rounded(e.point(p) + 0.3 * e.longest * ellipsoid_normal(e.axes, p));
        assert!(!view_ellipsoid(e, x).narrow);
        vec![x]
    };
    assert_eq!(directions_match_pdf(&prepared, near), 3);
}

fn two_receivers(prepared: &Prepared, light: &Emitter) -> Vec<DVec3> {
    let mut all = receivers(prepared, light);
    all.truncate(2);
    all
}

/// How many lights were tested, from so many points each.
fn directions_match_pdf(
    prepared: &Prepared,
    receivers: impl Fn(&Prepared, &Emitter) -> Vec<DVec3>,
) -> usize {
    let context = context();
    let sampling = prepared.settings.estimator.light_sampling;
    let world = World::new(prepared);
    let mut tested = 0;
    for (index, light) in (0_u32..).zip(&prepared.emitters.lights) {
        let Emitter::Area { primitive, .. } = *light else {
            continue;
        };
        let geometry = &prepared.data.primitives[primitive as usize].geometry;
        for (k, x) in (0..).zip(receivers(prepared, light)) {
            tested += 1;
            let seed = 50 + 4 * index + k;
            let wis = directions(context, prepared, index, x, seed);
            // A point on the border may round beyond it, by the angle that a direction is known to.
            let samples: Vec<DVec2> = wis
                .iter()
                .map(|wi| {
                    let p = on_light(geometry, x, *wi).at;
                    let inner = p.clamp(DVec2::ZERO, DVec2::ONE);
                    if (p - inner).length() < 1e-5 {
                        inner
                    } else {
                        p
                    }
                })
                .collect();
            // A sphere's back is sampled as well, and nothing arrives from there: the density is
            // that of all samples.
            let all = DRAWN as f64 / samples.len() as f64;
            let selection = prepared.emitters.probability(index as usize);
            let pdf = |p: DVec2, cosines: f64| {
                let wi = towards(geometry, x, p);
                let hit = on_light(geometry, x, wi);
                let from = (x, &facing_z());
                let pdf = pdf_area_light(&world, index, from, wi, (hit.d2, hit.cos, hit.st)).0
                    / selection;
                all * pdf * hit.solid_angle() * hit.cos.powf(cosines)
            };
            let what = format!(
                "{sampling:?}, {geometry:?} from {x}, seed {seed}, {}",
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
                        all * on_light(geometry, x, wi).solid_angle() / geometry.area()
                    }),
                    BrokenTwin::ExtraCosine => test(&|p| 1.5 * pdf(p, 1.0)),
                    // One light alone is sampled, and no BSDF.
                    BrokenTwin::LightLeftOut
                    | BrokenTwin::SwappedSinCos
                    | BrokenTwin::MisWeights
                    | BrokenTwin::RaysForgotten
                    | BrokenTwin::OpaqueShadows => continue,
                };
                statistics::reject(broken, &format!("{what}, {}", row.name));
            }
        }
    }
    tested
}
