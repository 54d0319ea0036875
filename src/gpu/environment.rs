//! The environment map as the GPU reads it: a texture of radiance and an alias table over its sampling grid.

use super::buffer::GpuBuffer;
use super::context::Context;
use super::lights::alias_words;
use super::scene_buffers::Word;
use crate::emitters::EnvironmentGrid;
use crate::error::GpuError;
use crate::scene::EnvironmentMap;

/// An environment map and its sampling grid.
#[derive(Debug)]
pub struct EnvironmentBuffers {
    /// One word per cell.
    pub alias: GpuBuffer<Word>,
    /// Radiance.
    pub texels: wgpu::TextureView,
    /// Cells per row and column.
    pub grid: [u32; 2],
}

impl EnvironmentBuffers {
    /// Uploads `map` and its sampling grid.
    ///
    /// # Errors
    /// The map has more texels along a side than the adapter's textures, or memory runs out.
    pub fn new(
        context: &Context,
        map: &EnvironmentMap,
        grid: &EnvironmentGrid,
    ) -> Result<Self, GpuError> {
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
        let words = alias_words(&grid.table, |cell| grid.table.probability[cell]);
        let texels: Vec<[f32; 4]> = map.texels.iter().map(|&[r, g, b]| [r, g, b, 0.0]).collect();
        context.checked(|| Self {
            alias: GpuBuffer::storage(&context.device, "scene.environment_alias", &words),
            texels: upload_texels(context, [map.width, map.height], &texels),
            grid: grid.size,
        })
    }

    /// What is bound where there is no map: a black texel.
    ///
    /// # Errors
    /// Memory runs out.
    pub fn none(context: &Context) -> Result<Self, GpuError> {
        context.checked(|| Self {
            alias: GpuBuffer::storage(&context.device, "scene.environment_alias", &[]),
            texels: upload_texels(context, [1, 1], &[[0.0; 4]]),
            grid: [1, 1],
        })
    }
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
