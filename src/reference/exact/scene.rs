//! Exact direct lighting of a whole scene, where all surfaces are polygons: every light is clipped
//! against the shadow volumes of all others, and what is left of it is integrated.

use super::cubature::{Estimate, Tolerance};
use super::direct::{AreaLight, Receiver, Shape, direct_lighting};
use super::ggx::Lobe;
use super::occlusion::visible_pieces;
use super::point::{directional_irradiance, point_irradiance};
use super::polygon::polygon_factor;
use crate::accel::PrimitiveGeometry;
use crate::effects::Effect;
use crate::emitters::Emitter;
use crate::reference::core::frame::{ShadingFrame, to_local};
use crate::reference::core::ray::Ray;
use crate::reference::light::light::emitted_radiance;
use crate::reference::light::spot::spot_falloff;
use crate::reference::scene::fetch::World;
use crate::reference::scene::opacity::Crossings;
use crate::reference::scene::surface::{Surface, surface_at};
use crate::reference::scene::trace::{any_hit, closest_hit};
use crate::scene::material::{BsdfParameters, Fresnel, SpecularLobe};
use crate::scene::{DirectionalLight, Light, PointLight, SpotLight};
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;

/// Polygons with which a scene is still treated exactly: each light is clipped against all.
pub const MAX_POLYGONS: usize = 256;

/// Relative error of the cubature over glossy lobes.
const TOLERANCE: f64 = 1e-6;

/// Why a scene has no exact answer.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NotExact {
    /// A shape that is no polygon.
    #[error("{0} is curved; exact visibility is known for triangles and rectangles only")]
    Curved(String),
    /// Light from everywhere.
    #[error(
        "[environment]: exact visibility is known for polygons only, not for the sky between them"
    )]
    Environment,
    /// Light from a sun.
    #[error(
        "there is a sun; exact irradiance is known for polygons and lights without extent only"
    )]
    Sun,
    /// A light without extent of a kind that is not treated here.
    #[error(
        "there is a light of the kind {0}; exact irradiance is known for polygons, point, spot and directional lights only"
    )]
    Light(&'static str),
    /// Emission that varies over a light.
    #[error("{0} emits a texture; exact irradiance is known for constant radiance only")]
    EmissiveTexture(String),
    /// Normals that are not the polygons'.
    #[error("{0} has shading normals; exact irradiance is known for flat polygons only")]
    ShadingNormals(String),
    /// A mirror, or glass.
    #[error(
        "materials.{0} is a mirror or transparent; exact answers are known where camera rays end on the first surface"
    )]
    Specular(String),
    /// Light that meets several facets.
    #[error("energy_compensation = true; exact answers are known for light that meets one facet")]
    Compensated,
    /// Surfaces that let rays pass.
    #[error("{0}; exact visibility is known for surfaces that stop all rays")]
    Opacity(String),
    /// A lobe that is not integrated here.
    #[error(
        "materials.{0} has a GGX lobe with Fresnel's equations; exact answers are known for Schlick's"
    )]
    Fresnel(String),
    /// Too many polygons.
    #[error("{0} polygons; at most {MAX_POLYGONS} are clipped against each other")]
    TooMany(usize),
}

/// A scene of polygons.
#[derive(Debug)]
pub struct ExactScene<'a> {
    world: &'a World<'a>,
    /// Vertices of each primitive, its normal by the right-hand rule.
    polygons: Vec<Vec<DVec3>>,
}

impl<'a> ExactScene<'a> {
    /// The exact answers of `world`.
    ///
    /// # Errors
    /// It has none.
    pub fn new(world: &'a World<'a>) -> Result<Self, NotExact> {
        if world
            .prepared
            .emitters
            .lights
            .contains(&Emitter::Environment)
        {
            return Err(NotExact::Environment);
        }
        for light in &world.prepared.emitters.lights {
            match light {
                Emitter::Sun(_) => return Err(NotExact::Sun),
                Emitter::Delta(Light::Point(_) | Light::Spot(_) | Light::Directional(_))
                | Emitter::Area { .. }
                | Emitter::Environment => {}
                Emitter::Delta(other) => return Err(NotExact::Light(other.name())),
            }
        }
        if let Some(map) = world.prepared.emitters.maps.first() {
            let shape = &world.prepared.data.scene.shapes[map.shape.index()];
            return Err(NotExact::EmissiveTexture(shape.name.clone()));
        }
        if world.prepared.effects.contains(Effect::EnergyCompensation) {
            return Err(NotExact::Compensated);
        }
        let mut effects = world.prepared.effects.iter();
        if let Some((_, reason)) = effects.find(|(effect, _)| *effect == Effect::Alpha) {
            return Err(NotExact::Opacity(reason.to_owned()));
        }
        for material in &world.prepared.data.scene.materials {
            let parameters = material.bsdf.parameters();
            if parameters.is_specular() || parameters.unlit {
                return Err(NotExact::Specular(material.name.clone()));
            }
            let fresnel = parameters.specular.map(|lobe| lobe.fresnel);
            if !matches!(fresnel, None | Some(Fresnel::Schlick { f90: 1.0, .. })) {
                return Err(NotExact::Fresnel(material.name.clone()));
            }
        }
        if world.primitives.len() > MAX_POLYGONS {
            return Err(NotExact::TooMany(world.primitives.len()));
        }
        let vertices = |i: usize| match world.primitives[i].geometry {
            PrimitiveGeometry::Triangle { a, u, v } => Ok(vec![a, a + u, a + v]),
            PrimitiveGeometry::Rectangle { a, u, v } => Ok(vec![a, a + u, a + u + v, a + v]),
            PrimitiveGeometry::Disk { .. }
            | PrimitiveGeometry::Sphere { .. }
            | PrimitiveGeometry::Ellipsoid { .. } => Err(NotExact::Curved(world.name_of(i))),
        };
        if let Some(i) = (0..world.primitives.len()).find(|&i| world.has_shading_normals(i)) {
            return Err(NotExact::ShadingNormals(world.name_of(i)));
        }
        let polygons = (0..world.primitives.len()).map(vertices);
        Ok(Self {
            polygons: polygons.collect::<Result<_, _>>()?,
            world,
        })
    }

    /// Whether every surface is Lambertian, so that all answers are closed forms.
    pub fn is_diffuse(&self) -> bool {
        let mut primitives = self.world.primitives.iter();
        primitives.all(|p| p.material.specular.is_none())
    }

    /// Radiance that arrives along `ray`, against its direction.
    pub fn radiance(&self, ray: &Ray) -> Estimate {
        let Some(hit) = closest_hit(self.world, ray, Crossings::OPAQUE) else {
            return Estimate::ZERO;
        };
        let s = surface_at(self.world, ray, &hit, -ray.direction);
        let mut sum = Estimate::ZERO;
        if let Some(light) = s.light {
            sum.value += emitted_radiance(self.world, light, s.front, hit.st);
        }
        for emitter in &self.world.prepared.emitters.lights {
            let of_light = match *emitter {
                Emitter::Area {
                    primitive,
                    radiance,
                    two_sided,
                    map: _,
                } => self.of_polygon(&s, hit.primitive, primitive, radiance, two_sided),
                Emitter::Delta(light) => self.of_delta(&s, &light),
                Emitter::Sun(_) | Emitter::Environment => unreachable!("refused in `new`"),
            };
            sum.value += of_light.value;
            sum.error += of_light.error;
        }
        sum
    }

    /// What the surface `s` on primitive `receiver` reflects of an area light.
    fn of_polygon(
        &self,
        s: &Surface,
        receiver: u32,
        light: u32,
        radiance: DVec3,
        two_sided: bool,
    ) -> Estimate {
        let mut sum = Estimate::ZERO;
        if receiver == light {
            return sum;
        }
        let occluders = self.occluders(s.position, [receiver, light]);
        for piece in visible_pieces(s.position, &self.polygons[light as usize], &occluders) {
            if s.material.specular.is_none() {
                let factor = polygon_factor(s.position, s.frame.z, &piece);
                let factor = if two_sided {
                    factor.abs()
                } else {
                    factor.max(0.0)
                };
                sum.value += s.material.diffuse * radiance * factor;
                continue;
            }
            let receiver = Receiver {
                point: s.position,
                normal: s.frame.z,
            };
            let wo = s.frame.x * s.wo.x + s.frame.y * s.wo.y + s.frame.z * s.wo.z;
            let light = AreaLight {
                shape: Shape::Polygon(piece),
                radiance,
                two_sided,
            };
            let bsdf = |wi| f_r(&s.material, &s.frame, wi, s.wo);
            let part = direct_lighting(&receiver, wo, bsdf, &light, Tolerance::relative(TOLERANCE));
            sum.value += part.value;
            sum.error += part.error;
        }
        sum
    }

    /// Polygons that may hide a light from `point`: all but `except`, and those whose back faces
    /// the point and does not exist.
    fn occluders(&self, point: DVec3, except: [u32; 2]) -> Vec<Vec<DVec3>> {
        let hides = |i: &usize| {
            let polygon = &self.polygons[*i];
            let normal = (polygon[1] - polygon[0]).cross(polygon[2] - polygon[0]);
            let faces = normal.dot(point - polygon[0]) > 0.0;
            !except.contains(&(*i as u32)) && (faces || !self.world.primitives[*i].one_sided)
        };
        let indices = (0..self.polygons.len()).filter(hides);
        indices.map(|i| self.polygons[i].clone()).collect()
    }

    /// What the surface reflects of a light without area.
    fn of_delta(&self, s: &Surface, light: &Light) -> Estimate {
        let n = s.frame.z;
        // Direction to the light, the end of the shadow ray, and irradiance per unit of the light's
        // colour.
        let (towards, end, irradiance, colour) = match *light {
            Light::Point(PointLight {
                position,
                intensity,
            }) => {
                let e = point_irradiance(s.position, n, position, 1.0);
                (position - s.position, position, e, intensity)
            }
            Light::Spot(SpotLight {
                position,
                direction,
                intensity,
                inner_angle,
                outer_angle,
            }) => {
                let towards = position - s.position;
                let cosine = -towards.normalize_or_zero().dot(direction);
                let falloff = spot_falloff(cosine, inner_angle.cos(), outer_angle.cos());
                let e = falloff * point_irradiance(s.position, n, position, 1.0);
                (towards, position, e, intensity)
            }
            Light::Directional(DirectionalLight {
                direction,
                irradiance,
            }) => {
                let e = directional_irradiance(n, -direction, 1.0);
                (-direction, s.position - 4.0 * direction, e, irradiance)
            }
            other => unreachable!("{} is refused in `new`", other.name()),
        };
        let ray = Ray {
            origin: s.origin,
            direction: end - s.origin,
        };
        if irradiance <= 0.0 || any_hit(self.world, &ray, Crossings::OPAQUE, 1.0) {
            return Estimate::ZERO;
        }
        let f = f_r(&s.material, &s.frame, towards.normalize_or_zero(), s.wo);
        Estimate {
            value: f * colour * irradiance,
            error: 0.0,
        }
    }
}

/// f_r for the unit direction `wi` in the scene's space and `wo` in the frame's.
fn f_r(material: &BsdfParameters, frame: &ShadingFrame, wi: DVec3, wo: DVec3) -> DVec3 {
    let diffuse = material.diffuse * FRAC_1_PI;
    let Some(SpecularLobe {
        fresnel: Fresnel::Schlick { f0, .. },
        alpha,
        ..
    }) = material.specular
    else {
        return diffuse;
    };
    let wi = to_local(frame, wi);
    let half = (wi + wo).normalize_or_zero();
    let schlick = (1.0 - wi.dot(half)).clamp(0.0, 1.0).powi(5);
    let fresnel = f0 + (DVec3::ONE - f0) * schlick;
    (DVec3::ONE - fresnel) * diffuse + Lobe { alpha, f0 }.eval(wo, wi)
}
