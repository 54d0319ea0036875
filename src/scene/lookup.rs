//! The value of a texture between and beyond its texels.

use super::environment::Interpolation;
use super::texture::{Texture, TextureUse, Wrap};
use glam::{DVec2, DVec4};

/// A coordinate brought into [0, 1].
pub fn wrap_coordinate(x: f64, mode: Wrap) -> f64 {
    match mode {
        Wrap::Repeat => x - x.floor(),
        Wrap::Mirror => 1.0 - (x - 2.0 * (0.5 * x).floor() - 1.0).abs(),
        Wrap::Clamp => x.clamp(0.0, 1.0),
    }
}

/// A texel at most one beside the image brought into it.
pub fn wrap_texel(texel: i64, count: u32, mode: Wrap) -> u32 {
    let count = i64::from(count);
    let inside = match mode {
        Wrap::Repeat => texel.rem_euclid(count),
        Wrap::Mirror | Wrap::Clamp => texel.clamp(0, count - 1),
    };
    inside as u32
}

/// Four texels of an image and the weights between them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Footprint {
    /// Columns.
    pub columns: [u32; 2],
    /// Rows.
    pub rows: [u32; 2],
    /// Weights of the second column and row.
    pub blend: DVec2,
}

/// Where a surface's texture coordinates `uv` fall on an image of `size` texels.
pub fn footprint(t: &TextureUse, size: [u32; 2], uv: DVec2) -> Footprint {
    let on_image = t.transform.transform_point2(uv);
    let wrapped = DVec2::new(
        wrap_coordinate(on_image.x, t.wrap[0]),
        wrap_coordinate(on_image.y, t.wrap[1]),
    );
    let nearest = t.interpolation == Interpolation::Nearest;
    let position = wrapped * DVec2::new(size[0].into(), size[1].into())
        - DVec2::splat(if nearest { 0.0 } else { 0.5 });
    let first = position.floor();
    let pair = |first: f64, axis: usize| {
        [0, 1].map(|next| wrap_texel(first as i64 + next, size[axis], t.wrap[axis]))
    };
    Footprint {
        columns: pair(first.x, 0),
        rows: pair(first.y, 1),
        blend: if nearest {
            DVec2::ZERO
        } else {
            position - first
        },
    }
}

/// The value of `texture`, which `t` uses, where the surface has the coordinates `uv`.
pub fn value(texture: &Texture, t: &TextureUse, uv: DVec2) -> DVec4 {
    let f = footprint(t, [texture.width, texture.height], uv);
    let [left, right] = f.columns;
    let row = |y: u32| {
        texture
            .texel(left, y)
            .lerp(texture.texel(right, y), f.blend.x)
    };
    row(f.rows[0]).lerp(row(f.rows[1]), f.blend.y)
}
