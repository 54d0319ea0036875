//! Textures; see `shaders/scene/texture.wesl`.

use super::fetch::World;
pub use crate::scene::lookup::{Footprint, footprint, wrap_coordinate, wrap_texel};
use crate::scene::{TextureUse, lookup};
use glam::{DVec2, DVec4};

/// The value of a texture where the surface has the coordinates `uv`.
pub fn sample_texture(world: &World<'_>, t: &TextureUse, uv: DVec2) -> DVec4 {
    lookup::value(
        &world.prepared.data.scene.textures[t.texture.index()],
        t,
        uv,
    )
}
