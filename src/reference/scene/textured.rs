//! Materials that textures and vertex colours vary over a surface; see
//! `shaders/scene/textured.wesl`.

use super::attributes::{interpolate_uv, uvs_of};
use super::fetch::{Primitive, World};
use super::texture::sample_texture;
use crate::scene::material::BsdfParameters;
use crate::scene::texture::{TexturedFactors, tangent_normal};
use crate::scene::{Material, NormalMap, TextureUse};
use glam::{DVec2, DVec3};

/// The factors `before` times those of the textures of `material`, which `p` has, at its point
/// `st`.
pub fn texture_factors(
    world: &World<'_>,
    before: TexturedFactors,
    material: &Material,
    p: &Primitive,
    st: DVec2,
) -> TexturedFactors {
    let sample = |texture: &TextureUse| {
        let uv = interpolate_uv(&uvs_of(world, p, texture), st);
        sample_texture(world, texture, uv)
    };
    let mut factors = before;
    if let Some(texture) = &material.textures.color {
        factors.color *= sample(texture).truncate();
    }
    if let Some(texture) = &material.textures.metallic_roughness {
        let texel = sample(texture);
        factors.roughness *= texel.y;
        factors.metallic *= texel.z;
    }
    if let Some(texture) = &material.textures.specular_glossiness {
        let texel = sample(texture);
        factors.specular *= texel.truncate();
        factors.glossiness *= texel.w;
    }
    factors
}

/// How `material`, without textures and vertex colours `own`, scatters under `factors`.
pub fn textured_material(
    material: &Material,
    own: &BsdfParameters,
    factors: &TexturedFactors,
) -> BsdfParameters {
    let mut parameters = material.bsdf.textured_parameters(own, factors);
    if let (Some(lobe), Some(own)) = (&mut parameters.specular, &own.specular) {
        lobe.compensated = own.compensated;
    }
    parameters
}

/// The normal map's value, not normalised, where the surface has the texture coordinates `uv`.
pub fn mapped_normal(world: &World<'_>, map: &NormalMap, uv: DVec2) -> DVec3 {
    tangent_normal(sample_texture(world, &map.texture, uv), map.scale)
}
