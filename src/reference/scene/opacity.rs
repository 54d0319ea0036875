//! Opacity: whether a surface stops a ray; see `shaders/scene/opacity.wesl`.

use super::attributes::{fetch_colors, interpolate_color, interpolate_uv, uvs_of};
use super::fetch::{Primitive, World};
use super::texture::sample_texture;
use crate::reference::core::rng::pcg4d;
use crate::reference::core::sampler::{GROUP_OPACITY, SampleId, independent_counter};
use glam::DVec2;

/// Number of a sample's first camera ray; that which follows the first specular surface is the
/// next.
pub const RAY_CAMERA: u32 = 0;
/// Number of the first ray to lights in view.
pub const RAY_LIGHTS_IN_VIEW: u32 = 0x2545_f491;
/// Number of its BSDF-sampled ray.
pub const RAY_BSDF: u32 = 127;
/// Number of its first shadow ray, of the first light where every light has its own.
pub const RAY_SHADOW: u32 = 128;

/// A ray enters a sphere, or meets a planar primitive.
pub const CROSSING_FIRST: u32 = 0;
/// It leaves a sphere.
pub const CROSSING_SECOND: u32 = 1;

/// What decides which surfaces stop a ray.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Crossings {
    words: [u32; 4],
    ray: u32,
    opaque: bool,
}

impl Crossings {
    /// Every surface stops the ray.
    pub const OPAQUE: Self = Self {
        words: [0; 4],
        ray: RAY_CAMERA,
        opaque: true,
    };

    /// Those of the first camera ray of sample `id`.
    pub fn of_sample(id: SampleId) -> Self {
        Self {
            words: pcg4d(independent_counter(id, GROUP_OPACITY)),
            ray: RAY_CAMERA,
            opaque: false,
        }
    }

    /// Those of the ray that has the number `ray` in the same sample.
    #[must_use]
    pub fn of_ray(self, ray: u32) -> Self {
        Self { ray, ..self }
    }

    /// Whether a crossing of primitive `index` where its opacity is `alpha` stops the ray.
    pub fn is_stopped(&self, alpha: f64, index: u32, crossing: u32) -> bool {
        let [a, b, c, d] = self.words;
        let [.., word] = pcg4d([
            a.wrapping_add(index),
            b.wrapping_add(self.ray),
            c.wrapping_add(crossing),
            d,
        ]);
        self.opaque || f64::from(word) < (alpha * 32_f64.exp2()).floor()
    }
}

/// α of the primitive `p` at its point `st`.
pub fn opacity_at(world: &World<'_>, p: &Primitive, st: DVec2) -> f64 {
    let opacity = &world.prepared.data.scene.materials[p.material_id.index()].opacity;
    let mut factor = 1.0;
    if p.attributed.colors {
        factor *= interpolate_color(&fetch_colors(world, p), st).w;
    }
    if let Some(texture) = opacity.texture.filter(|_| p.attributed.uvs) {
        let uv = interpolate_uv(&uvs_of(world, p, &texture), st);
        factor *= sample_texture(world, &texture, uv).w;
    }
    opacity.at(factor)
}
