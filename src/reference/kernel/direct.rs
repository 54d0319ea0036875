//! Direct lighting, one sample at a time:
//!
//! L_o(x, ω_o) = L_e(x, ω_o) + ∫ L_i(x, ω_i) f_r(ω_i, ω_o) cosθ_i dω_i
//!
//! estimated by light sampling, by BSDF sampling, or by both with the power heuristic.

use super::camera::camera_ray;
use super::camera_path::{LitSurface, follow_camera_ray};
use super::filter::film_point;
use super::sample::Sample;
use super::shadow_rays::{LightNumbers, ShadowRays};
use crate::accel::PrimitiveGeometry;
use crate::effects::Effect;
use crate::emitters::Selection;
use crate::prepare::Prepared;
use crate::reference::broken::BrokenTwin;
use crate::reference::bsdf::bsdf::{
    BsdfSample, Hemisphere, eval_bsdf, sample_bsdf, sample_hemisphere,
};
use crate::reference::core::frame::to_local;
use crate::reference::core::math::max_abs;
use crate::reference::core::pdf::{
    PdfDiscrete, PdfSolidAngle, balance_heuristic, of_samples, power_heuristic,
};
use crate::reference::core::ray::Ray;
use crate::reference::core::rng::to_unit_2d;
use crate::reference::core::sampler::{
    GROUP_DIRECTION, GROUP_FILM, GROUP_LIGHT, Numbers, SampleId,
};
use crate::reference::light::alias_table::Choice;
use crate::reference::light::ellipsoid::Ellipsoid;
use crate::reference::light::light::{choose_light, sample_chosen_light, samples_of_light};
use crate::reference::light::opacity::light_opacity;
use crate::reference::light::sample::LightSample;
use crate::reference::light::tree::choose_tree_light;
use crate::reference::scene::fetch::World;
use crate::reference::scene::opacity::{Crossings, RAY_BSDF, RAY_SHADOW};
use crate::reference::scene::surface::{Surface, is_above, shadow_ray};
use crate::reference::scene::trace::any_hit;
use crate::scene::FilmSize;
use crate::scene::filter::FilterTable;
use glam::{DVec2, DVec3};

/// The estimator in f64, with the renderer's random numbers.
#[derive(Debug)]
pub struct Direct<'a> {
    pub(super) world: World<'a>,
    pub(super) size: FilmSize,
    seed: u32,
    pub(super) numbers: Numbers,
    pub(super) shadow_rays: ShadowRays,
    pub(super) sample_lights: bool,
    sample_bsdf: bool,
    pub(super) hemisphere: Option<Hemisphere>,
    pub(super) filter: FilterTable,
    balance: bool,
    pub(super) broken: Option<BrokenTwin>,
    left_out: u32,
}

impl<'a> Direct<'a> {
    /// The estimator for an image of `size` pixels; `broken` makes one mistake.
    pub(crate) fn new(
        prepared: &'a Prepared,
        size: FilmSize,
        seed: u32,
        broken: Option<BrokenTwin>,
    ) -> Self {
        let probability = |i: &u32| prepared.emitters.probability(*i as usize);
        let lights = 0..prepared.emitters.lights.len() as u32;
        let likeliest = lights.max_by(|a, b| probability(a).total_cmp(&probability(b)));
        let numbers = Numbers {
            sampler: prepared.settings.estimator.sampler,
            pattern: prepared.patterns().pixel,
            width: size.width,
        };
        Self {
            world: World::new(prepared),
            size,
            seed,
            numbers,
            shadow_rays: ShadowRays::new(prepared, numbers),
            sample_lights: prepared.effects.contains(Effect::SampleLights),
            sample_bsdf: prepared.effects.contains(Effect::SampleBsdf),
            hemisphere: hemisphere(prepared),
            filter: prepared.data.scene.filter.table(),
            balance: prepared.effects.contains(Effect::BalanceHeuristic),
            broken,
            left_out: likeliest.unwrap_or(u32::MAX),
        }
    }

    /// The scene.
    pub fn world(&self) -> &World<'a> {
        &self.world
    }

    /// The same estimator where only the lights of `group` shine; everything is sampled as before.
    #[must_use]
    pub fn with_light_group(mut self, group: u32) -> Self {
        self.world.light_group = Some(group);
        self
    }

    /// The same estimator with other random numbers.
    #[must_use]
    pub fn with_seed(self, seed: u32) -> Self {
        Self { seed, ..self }
    }

    /// The ray of sample `index` of the pixel (x, y).
    pub fn camera_ray(&self, x: u32, y: u32, index: u64) -> Ray {
        let words = self.numbers.group(self.id(x, y, index), GROUP_FILM);
        let pixel = DVec2::new(f64::from(x), f64::from(y));
        let film = film_point(&self.filter, pixel, to_unit_2d(words[0], words[1]));
        let lens = to_unit_2d(words[2], words[3]);
        camera_ray(&self.world, self.size, film, lens)
    }

    /// Names sample `index` of the pixel (x, y).
    pub fn id(&self, x: u32, y: u32, index: u64) -> SampleId {
        let pixel = y * self.size.width + x;
        self.numbers.sample_id(pixel, index, self.seed)
    }

    /// One sample of the radiance that arrives at the pixel (x, y).
    pub fn sample_radiance(&self, x: u32, y: u32, index: u64) -> Sample {
        self.sample_along(&self.camera_ray(x, y, index), self.id(x, y, index))
    }

    /// The same sample with its camera ray turned by so many radians to the right and up: what
    /// rounding the ray does to it.
    pub fn turned_sample(&self, (x, y): (u32, u32), index: u64, turn: DVec2) -> Sample {
        let camera = &self.world.prepared.camera;
        let mut ray = self.camera_ray(x, y, index);
        let turned = ray.direction + turn.x * camera.right + turn.y * camera.up;
        ray.direction = turned.normalize();
        self.sample_along(&ray, self.id(x, y, index))
    }

    fn sample_along(&self, ray: &Ray, id: SampleId) -> Sample {
        let mut sample = Sample::default();
        let pixel = (id.pixel % self.size.width, id.pixel / self.size.width);
        let lights = self.lights_of_pixel(pixel.0, pixel.1);
        let in_view: Vec<u32> = lights.iter().map(|(_, seen)| seen.light).collect();
        for &light in &lights {
            sample.radiance += self.estimate_light_in_view(light, id, pixel);
        }
        let found = follow_camera_ray(&self.world, *ray, self.numbers, id, &in_view, &mut sample);
        let Some(lit) = found else {
            return sample;
        };
        let s = lit.surface;
        if s.material.unlit {
            sample.radiance += lit.throughput * s.material.diffuse;
            return sample;
        }
        let light_words = self.numbers.group(id, GROUP_LIGHT);
        let direction_words = self.numbers.group(id, GROUP_DIRECTION);
        sample.conditions.normal_rounding = self.normal_rounding(&lit);
        sample.conditions.alpha = s
            .material
            .specular
            .map(|lobe| lobe.alpha)
            .filter(|&alpha| alpha > 0.0);
        if self.sample_lights {
            sample.by_light = lit.throughput * self.estimate_by_light(&s, id, &mut sample);
        }
        if self.sample_bsdf {
            let crossings = Crossings::of_sample(id).of_ray(RAY_BSDF);
            let words = [light_words[3], direction_words[0], direction_words[1]];
            let by_bsdf = self.estimate_by_bsdf(&s, words, crossings, &mut sample);
            sample.by_bsdf = lit.throughput * by_bsdf;
        }
        sample.radiance += sample.by_light + sample.by_bsdf;
        sample
    }

    /// 2⁻²⁴ of the primitive's coordinates over its shortest height, or radius of curvature.
    fn normal_rounding(&self, lit: &LitSurface) -> f64 {
        let geometry = &self.world.primitives[lit.primitive as usize].geometry;
        match *geometry {
            PrimitiveGeometry::Triangle { a, u, v }
            | PrimitiveGeometry::Rectangle { a, u, v }
            | PrimitiveGeometry::Disk { a, u, v } => {
                let longest = u.length().max(v.length());
                let height = u.cross(v).length() / longest;
                (-24_f64).exp2() * (max_abs(a) + longest) / height
            }
            PrimitiveGeometry::Sphere { center, radius } => {
                (-24_f64).exp2() * (max_abs(center) + radius) / radius
            }
            PrimitiveGeometry::Ellipsoid { .. } => {
                let ellipsoid = Ellipsoid::of(geometry).expect("the geometry is an ellipsoid");
                let radius = ellipsoid.curvature_radius(lit.surface.position);
                (-24_f64).exp2() * ellipsoid.extent() / radius
            }
        }
    }

    /// A sample of a light, with the mistakes of a broken twin.
    fn sample_light(&self, s: &Surface, choice: Choice, u: LightNumbers) -> Option<LightSample> {
        if self.broken == Some(BrokenTwin::LightLeftOut) && choice.index == self.left_out {
            return None;
        }
        let place = (s.position, &s.frame);
        let mut light = sample_chosen_light(&self.world, choice, place, u.point, u.texel);
        if self.broken.is_some() && !light.delta && light.pdf.0 > 0.0 {
            let pdf = BrokenTwin::measure(
                self.broken,
                choice.probability,
                light.pdf_on_light,
                light.pdf,
            );
            light.radiance_over_pdf *= light.pdf.0 / pdf.0;
            light.pdf = pdf;
        }
        let one = BrokenTwin::density(self.broken, PdfSolidAngle(1.0));
        light.radiance_over_pdf /= one.0;
        light.pdf = BrokenTwin::density(self.broken, light.pdf);
        Some(light)
    }

    /// Weight of the strategy with density `a` when `b` could have made the same sample.
    pub(super) fn mis_weight(&self, a: PdfSolidAngle, b: PdfSolidAngle) -> f64 {
        if self.balance {
            balance_heuristic(a, b)
        } else {
            power_heuristic(a, b)
        }
    }

    /// ∫ L_i f_r cosθ dω by light sampling: the mean of all light samples, or where every light has
    /// its own, the sum of the lights' means.
    fn estimate_by_light(&self, s: &Surface, id: SampleId, sample: &mut Sample) -> DVec3 {
        let emitters = &self.world.prepared.emitters;
        let rays = self.shadow_rays.rays();
        let crossings = Crossings::of_sample(id);
        let mut sum = DVec3::ZERO;
        match &emitters.selection {
            None => {}
            Some(Selection::One(_) | Selection::Tree(_)) => {
                for ray in 0..rays {
                    let u = self.shadow_rays.light_numbers(id, 0, ray);
                    let crossings = crossings.of_ray(RAY_SHADOW + ray);
                    if let Some(choice) = self.choose(s, u, sample) {
                        let found = self.estimate_by_shadow_ray(s, choice, u, crossings, sample);
                        sum += found / f64::from(rays);
                    }
                }
            }
            Some(Selection::All(sampled)) => {
                for (index, _) in (0..).zip(sampled).filter(|(_, sampled)| **sampled) {
                    let own = samples_of_light(&self.world, index, rays);
                    for ray in 0..own {
                        let choice = Choice {
                            index,
                            probability: PdfDiscrete(1.0),
                        };
                        let u = self.shadow_rays.light_numbers(id, index, ray);
                        let number = index.wrapping_mul(rays).wrapping_add(ray);
                        let crossings = crossings.of_ray(RAY_SHADOW.wrapping_add(number));
                        let found = self.estimate_by_shadow_ray(s, choice, u, crossings, sample);
                        sum += found / f64::from(own);
                    }
                }
            }
        }
        sum
    }

    /// A light for the surface; `None` where none can shine on it.
    fn choose(&self, s: &Surface, u: LightNumbers, sample: &mut Sample) -> Option<Choice> {
        match &self.world.prepared.emitters.selection {
            Some(Selection::Tree(tree)) => {
                let chosen = choose_tree_light(tree, u.choice, u.tree, s.position, s.frame.z);
                let least = &mut sample.conditions.choice_margin;
                *least = least.min(chosen.margin);
                chosen.choice
            }
            _ => choose_light(&self.world, u.choice),
        }
    }

    /// L_i f_r cosθ / p(light, ω_i) of one light sample.
    fn estimate_by_shadow_ray(
        &self,
        s: &Surface,
        choice: Choice,
        u: LightNumbers,
        crossings: Crossings,
        sample: &mut Sample,
    ) -> DVec3 {
        if s.own_light == Some(choice.index) {
            return DVec3::ZERO;
        }
        let Some(light) = self.sample_light(s, choice, u) else {
            return DVec3::ZERO;
        };
        let wi = BrokenTwin::direction(self.broken, to_local(&s.frame, light.wi));
        let f = eval_bsdf(&s.material, wi, s.wo);
        let f_cos = BrokenTwin::f_cos(self.broken, f.f_cos, wi.z);
        let mut contribution = f_cos * light.radiance_over_pdf;
        contribution *= light_opacity(&self.world, choice.index, s.position, light.wi);
        if self.sample_bsdf && !light.delta {
            let pdf_bsdf = BrokenTwin::density(self.broken, f.pdf);
            let pdf_light = of_samples(self.shadow_rays.rays(), light.pdf);
            let weight = self.mis_weight(pdf_light, pdf_bsdf);
            contribution *= BrokenTwin::weight(self.broken, weight);
        }
        if contribution.max_element() <= 0.0 || !is_above(s, light.wi) {
            return DVec3::ZERO;
        }
        sample.path.shadow.traced += 1;
        let crossings = BrokenTwin::crossings(self.broken, crossings);
        let ray = shadow_ray(s, light.target_point);
        if any_hit(&self.world, &ray, crossings, 1.0) {
            return DVec3::ZERO;
        }
        sample.path.shadow.clear += 1;
        sample.conditions.add_light(wi.z, light.cos_light);
        contribution
    }
}

/// A direction from a surface, without regard to lights: by the BSDF, or as `how` says.
pub fn choose_direction(s: &Surface, how: Option<Hemisphere>, lobe: f64, u: DVec2) -> BsdfSample {
    match how {
        Some(how) => sample_hemisphere(&s.material, s.wo, how, u),
        None => sample_bsdf(&s.material, s.wo, lobe, u),
    }
}

/// How directions are chosen where that is without regard to the BSDF.
pub fn hemisphere(prepared: &Prepared) -> Option<Hemisphere> {
    if prepared.effects.contains(Effect::UniformHemisphere) {
        Some(Hemisphere::Uniform)
    } else if prepared.effects.contains(Effect::CosineHemisphere) {
        Some(Hemisphere::Cosine)
    } else {
        None
    }
}
