//! A camera ray through mirrors and glass; see `shaders/kernel/camera_path.wesl`.

use super::feature_record::record_features;
use super::sample::Sample;
use crate::accel::PrimitiveGeometry;
use crate::reference::bsdf::specular::{Way, sample_specular};
use crate::reference::core::frame::to_world;
use crate::reference::core::ray::{Hit, Ray};
use crate::reference::core::rng::to_unit;
use crate::reference::core::sampler::{GROUP_SPECULAR, Numbers, SampleId};
use crate::reference::light::ellipsoid::Ellipsoid;
use crate::reference::light::light::{distant_radiance, emitted_radiance};
use crate::reference::scene::fetch::World;
use crate::reference::scene::opacity::{Crossings, RAY_CAMERA};
use crate::reference::scene::surface::{Surface, is_above, surface_at};
use crate::reference::scene::trace::closest_hit;
use glam::DVec3;

/// A surface that is lit directly, and what stands before it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LitSurface {
    /// The surface.
    pub surface: Surface,
    /// Its primitive.
    pub primitive: u32,
    /// Factor on its direct lighting.
    pub throughput: DVec3,
}

/// The camera ray that goes on from `s` in the local direction `wi`.
pub fn ray_onwards(s: &Surface, wi: DVec3, transmitted: bool) -> Ray {
    let side = if transmitted { -1.0 } else { 1.0 };
    Ray {
        origin: s.position - s.lift + side * (s.origin - s.position),
        direction: to_world(&s.frame, wi).normalize(),
    }
}

/// Factor by which the surface of a primitive spreads the angle of a ray that met it at `surface`,
/// having come the distance `t`.
fn spread(geometry: &PrimitiveGeometry, t: f64, surface: &Surface) -> f64 {
    let radius = match geometry {
        PrimitiveGeometry::Sphere { radius, .. } => Some(*radius),
        _ => Ellipsoid::of(geometry).map(|e| e.curvature_radius(surface.position)),
    };
    let cos = surface.wo.z.max(1e-6);
    1.0 + radius.map_or(0.0, |radius| 2.0 * t / (radius * cos))
}

/// Stands for no primitive where what a path met is hashed; `shaders/core/constants.wesl`.
const NONE: u32 = u32::MAX;

/// Notes what a camera ray met.
fn record_hit(sample: &mut Sample, hit: Option<&Hit>) {
    let primitive = hit.map_or(NONE, |hit| hit.primitive);
    let met = match sample.path {
        path if path.further_rays == 0 => primitive,
        path => path
            .camera
            .unwrap_or(NONE)
            .wrapping_mul(0x9e37_79b1)
            .wrapping_add(primitive),
    };
    sample.path.camera = (met != NONE).then_some(met);
}

fn record_way(sample: &mut Sample, way: Way) {
    let way = match way {
        Way::Lit => 0,
        Way::Reflected => 1,
        Way::Transmitted => 2,
    };
    sample.path.camera = sample.path.camera.map(|met| met ^ (way << 30));
}

/// Follows the camera ray of sample `id`: adds the radiance that it meets to `sample`, and finds
/// the surface that is lit directly. What the first ray meets of the lights `in_view` does not
/// count: they are sampled.
pub fn follow_camera_ray(
    world: &World<'_>,
    first: Ray,
    numbers: Numbers,
    id: SampleId,
    in_view: &[u32],
    sample: &mut Sample,
) -> Option<LitSurface> {
    let depth = world.prepared.settings.estimator.max_specular_depth;
    let mut throughput = DVec3::ONE;
    let mut ray = first;
    loop {
        let number = RAY_CAMERA + sample.path.further_rays;
        let sampled = if number == RAY_CAMERA { in_view } else { &[] };
        let hit = closest_hit(world, &ray, Crossings::of_sample(id).of_ray(number));
        record_hit(sample, hit.as_ref());
        let Some(hit) = hit else {
            sample.radiance += throughput * distant_radiance(world, ray.direction, sampled);
            return None;
        };
        let surface = surface_at(world, &ray, &hit, -ray.direction);
        sample.features = record_features(&surface, throughput);
        if let Some(light) = surface.light.filter(|light| !sampled.contains(light)) {
            sample.radiance += throughput * emitted_radiance(world, light, surface.front, hit.st);
        }
        let bounce = sample.path.further_rays;
        let [word, ..] = numbers.group(id, GROUP_SPECULAR + bounce);
        let next = sample_specular(&surface.material, surface.wo, surface.front, to_unit(word));
        throughput *= next.weight;
        record_way(sample, next.way);
        if next.way == Way::Lit {
            return Some(LitSurface {
                surface,
                primitive: hit.primitive,
                throughput,
            });
        }
        if bounce == depth {
            return None;
        }
        let geometry = &world.primitives[hit.primitive as usize].geometry;
        sample.conditions.spread *= spread(geometry, hit.t, &surface);
        let transmitted = next.way == Way::Transmitted;
        ray = ray_onwards(&surface, next.wi, transmitted);
        if world.has_shading_normals(hit.primitive as usize)
            && is_above(&surface, ray.direction) == transmitted
        {
            return None;
        }
        sample.path.further_rays += 1;
    }
}
