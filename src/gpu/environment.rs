//! The environment map as the GPU reads it: a texture of radiance and an alias table over its
//! sampling grid.

use super::buffer::GpuBuffer;
use super::context::Context;
use super::lights::alias_words;
use super::scene_buffers::Word;
use crate::emitters::EnvironmentGrid;
use crate::error::GpuError;
use crate::scene::{EnvironmentMap, EnvironmentRadiance, Scene};

/// The environment map of `scene`, where it has one.
pub(super) fn map_of(scene: &Scene) -> Option<&EnvironmentMap> {
    match &scene.environment.as_ref()?.radiance {
        EnvironmentRadiance::Map(map) => Some(map),
        EnvironmentRadiance::Constant(_) => None,
    }
}

/// Uploads the alias table over the cells of `grid`; without one, what is bound in its place.
pub(super) fn alias(device: &wgpu::Device, grid: Option<&EnvironmentGrid>) -> GpuBuffer<Word> {
    let words = grid.map_or_else(Vec::new, |grid| {
        alias_words(&grid.table, |cell| grid.table.probability[cell])
    });
    GpuBuffer::storage(device, "scene.environment_alias", &words)
}

/// Uploads the radiance of `map`; a black texel where there is none.
///
/// # Errors
/// The map has more texels along a side than the adapter's textures, or memory runs out.
pub(super) fn texels(
    context: &Context,
    map: Option<&EnvironmentMap>,
) -> Result<wgpu::TextureView, GpuError> {
    let Some(map) = map else {
        return context.checked(|| upload_texels(context, [1, 1], &[[0.0; 4]]));
    };
    let side = u64::from(map.width.max(map.height));
    let limit = u64::from(context.limits.max_texture_dimension_2d);
    if side > limit {
        return Err(GpuError::TooLarge {
            what: format!(
                "a row of the environment map {} ({} × {} texels)",
                map.source, map.width, map.height
            ),
            needed: side * 16,
            limit: limit * 16,
            adapter: context.adapter.name.clone(),
        });
    }
    let texels: Vec<[f32; 4]> = map.texels.iter().map(|&[r, g, b]| [r, g, b, 0.0]).collect();
    context.checked(|| upload_texels(context, [map.width, map.height], &texels))
}

fn upload_texels(
    context: &Context,
    [width, height]: [u32; 2],
    texels: &[[f32; 4]],
) -> wgpu::TextureView {
    let size = wgpu::Extent3d {
        width,
        height,
        depth_or_array_layers: 1,
    };
    let texture = context.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("scene.environment"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba32Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    context.queue.write_texture(
        texture.as_image_copy(),
        bytemuck::cast_slice(texels),
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(width * 16),
            rows_per_image: None,
        },
        size,
    );
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}
