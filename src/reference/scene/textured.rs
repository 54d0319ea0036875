//! Materials whose textures vary them over a surface; see `shaders/scene/textured.wesl`.

use super::fetch::World;
use super::texture::sample_texture;
use crate::scene::material::BsdfParameters;
use crate::scene::texture::{TexturedFactors, tangent_normal};
use crate::scene::{Material, NormalMap};
use glam::{DVec2, DVec3};

/// How `material`, without textures `own`, scatters where the surface has the texture coordinates `uv`.
pub fn textured_material(
    world: &World<'_>,
    material: &Material,
    own: &BsdfParameters,
    uv: DVec2,
) -> BsdfParameters {
    let mut factors = TexturedFactors::default();
    if let Some(texture) = &material.textures.color {
        factors.color = sample_texture(world, texture, uv).truncate();
    }
    if let Some(texture) = &material.textures.metallic_roughness {
        let texel = sample_texture(world, texture, uv);
        (factors.roughness, factors.metallic) = (texel.y, texel.z);
    }
    let mut parameters = material.bsdf.textured_parameters(own, &factors);
    if let (Some(lobe), Some(own)) = (&mut parameters.specular, &own.specular) {
        lobe.compensated = own.compensated;
    }
    parameters
}

/// The normal map's value, not normalised, where the surface has the texture coordinates `uv`.
pub fn mapped_normal(world: &World<'_>, map: &NormalMap, uv: DVec2) -> DVec3 {
    tangent_normal(sample_texture(world, &map.texture, uv), map.scale)
}
