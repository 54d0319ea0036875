//! Direct lighting by BSDF sampling.

use super::direct::{Direct, choose_direction};
use super::sample::{BsdfRay, Sample};
use crate::accel::PrimitiveGeometry;
use crate::reference::broken::BrokenTwin;
use crate::reference::core::frame::to_world;
use crate::reference::core::pdf::{PdfSolidAngle, of_samples};
use crate::reference::core::ray::Ray;
use crate::reference::core::rng::{to_unit, to_unit_2d};
use crate::reference::light::area_light::{pdf_area_light, pdf_light_area};
use crate::reference::light::ellipsoid::Ellipsoid;
use crate::reference::light::emission::{emission_cell_margin, emission_map, invert_light_area};
use crate::reference::light::environment::{
    environment_cell_margin, environment_radiance, pdf_environment,
};
use crate::reference::light::light::emitted_radiance;
use crate::reference::light::sun::{is_in_sun, pdf_sun, sun_margin, sun_radiance, suns};
use crate::reference::scene::opacity::Crossings;
use crate::reference::scene::surface::{Surface, is_above, surface_at};
use crate::reference::scene::trace::closest_hit;
use glam::DVec3;

impl Direct<'_> {
    /// L_i f_r cosθ / p(ω_i), where ω_i is chosen in proportion to the BSDF.
    pub(super) fn estimate_by_bsdf(
        &self,
        s: &Surface,
        [lobe, x, y]: [u32; 3],
        crossings: Crossings,
        sample: &mut Sample,
    ) -> DVec3 {
        let u = to_unit_2d(x, y);
        let chosen = choose_direction(s, self.hemisphere, to_unit(lobe), u);
        let ray = Ray {
            origin: s.origin,
            direction: to_world(&s.frame, BrokenTwin::direction(self.broken, chosen.wi)),
        };
        if chosen.weight.max_element() <= 0.0 || !is_above(s, ray.direction) {
            return DVec3::ZERO;
        }
        let wi = BrokenTwin::direction(self.broken, chosen.wi);
        sample.conditions.bsdf_cos_surface = wi.z;
        let one = BrokenTwin::density(self.broken, PdfSolidAngle(1.0));
        let weight = BrokenTwin::f_cos(self.broken, chosen.weight, wi.z) / one.0;
        let pdf_bsdf = BrokenTwin::density(self.broken, chosen.pdf);
        let (radiance, pdf_light) = self.light_in_direction(s, &ray, crossings, sample);
        let mut radiance = radiance * self.bsdf_weight(pdf_bsdf, pdf_light);
        if sample.path.bsdf == BsdfRay::Missed {
            radiance += self.estimate_suns_by_bsdf(ray.direction, pdf_bsdf, sample);
        }
        radiance * weight
    }

    /// MIS weight of a BSDF sample that light sampling would have chosen with the density
    /// `pdf_light`.
    fn bsdf_weight(&self, pdf_bsdf: PdfSolidAngle, pdf_light: PdfSolidAngle) -> f64 {
        if !self.sample_lights {
            return 1.0;
        }
        let pdf_light = BrokenTwin::density(self.broken, pdf_light);
        let rays = BrokenTwin::rays(self.broken, self.shadow_rays.rays());
        let weight = self.mis_weight(pdf_bsdf, of_samples(rays, pdf_light));
        BrokenTwin::weight(self.broken, weight)
    }

    /// The part of a BSDF sample with density `pdf` that it has in the radiance of the suns in its
    /// direction.
    fn estimate_suns_by_bsdf(
        &self,
        direction: DVec3,
        pdf: PdfSolidAngle,
        sample: &mut Sample,
    ) -> DVec3 {
        let mut sum = DVec3::ZERO;
        for (_, sun, selection) in suns(&self.world) {
            let margin = &mut sample.conditions.cell_margin;
            *margin = margin.min(sun_margin(&sun, direction));
            if is_in_sun(&sun, direction) {
                sum += sun_radiance(&sun) * self.bsdf_weight(pdf, pdf_sun(&sun, selection));
            }
        }
        sum
    }

    /// Radiance along `ray`, and the density with which light sampling from `s` would have chosen
    /// its direction.
    fn light_in_direction(
        &self,
        s: &Surface,
        ray: &Ray,
        crossings: Crossings,
        sample: &mut Sample,
    ) -> (DVec3, PdfSolidAngle) {
        let world = &self.world;
        let dark = (DVec3::ZERO, PdfSolidAngle(0.0));
        let Some(hit) = closest_hit(world, ray, crossings) else {
            sample.path.bsdf = BsdfRay::Missed;
            if world.prepared.data.scene.environment.is_none() {
                return dark;
            }
            sample.conditions.cell_margin = environment_cell_margin(world, ray.direction);
            let (choice, on_image, pdf) = pdf_environment(world, ray.direction);
            return (
                environment_radiance(world, ray.direction),
                BrokenTwin::measure(self.broken, choice, on_image, pdf),
            );
        };
        sample.path.bsdf = BsdfRay::Hit(hit.primitive);
        let y = surface_at(world, ray, &hit, -ray.direction);
        let Some(light) = y.light else {
            return dark;
        };
        sample.conditions.bsdf_cos_light = y.cos_o;
        let geometry = &world.primitives[hit.primitive as usize].geometry;
        if let PrimitiveGeometry::Sphere { radius, .. } = *geometry {
            sample.conditions.bsdf_light_curvature = hit.t / radius;
        }
        if let Some(ellipsoid) = Ellipsoid::of(geometry) {
            let radius = ellipsoid.curvature_radius(y.position);
            sample.conditions.bsdf_light_curvature = hit.t / radius;
        }
        let place = (s.position, &s.frame);
        if let Some(map) = emission_map(world, light) {
            let on_square = emission_cell_margin(map, invert_light_area(geometry, hit.st));
            // An angle moves the point by so much over the cosine, and as a part of the light's
            // size.
            let size = geometry.area().sqrt() / hit.t;
            sample.conditions.cell_margin = on_square * size * y.cos_o;
        }
        let (choice, on_light) = pdf_light_area(world, light, place, hit.st);
        let seen = (hit.t * hit.t, y.cos_o, hit.st);
        let pdf = pdf_area_light(world, light, place, ray.direction, seen);
        (
            emitted_radiance(world, light, y.front, hit.st),
            BrokenTwin::measure(self.broken, choice, Some(on_light), pdf),
        )
    }
}
