//! The environment map as the GPU reads it: a texture of radiance and an alias table over its texels.

use super::buffer::GpuBuffer;
use super::context::Context;
use super::scene_buffers::{Word, alias_words};
use crate::emitters::{row_height, texel_luminance};
use crate::error::GpuError;
use crate::scene::EnvironmentMap;
use crate::scene::alias_table::AliasTable;
use crate::scene::light::Interpolation;

/// Cells of the sampling grid at most; larger maps are sampled in blocks of texels.
const MAX_CELLS: usize = 1 << 21;

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
    /// Uploads `map` and builds its alias table.
    ///
    /// # Errors
    /// The map has more texels along a side than the adapter's textures, or memory runs out.
    pub fn new(context: &Context, map: &EnvironmentMap) -> Result<Self, GpuError> {
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
        let (grid, weights) = cell_weights(map);
        let table = AliasTable::new(&weights).expect("a map without light is not an emitter");
        let words = alias_words(&table);
        context.checked(|| Self {
            alias: GpuBuffer::storage(&context.device, "scene.environment_alias", &words),
            texels: upload_texels(context, map),
            grid,
        })
    }
}

/// The sampling grid, and per cell the luminance of its texels times their height in z.
fn cell_weights(map: &EnvironmentMap) -> ([u32; 2], Vec<f64>) {
    let (width, height) = (map.width as usize, map.height as usize);
    let fits = |block: &usize| {
        let whole = width.is_multiple_of(*block) && height.is_multiple_of(*block);
        whole && (width / block) * (height / block) <= MAX_CELLS
    };
    // Sides without a common factor: one cell per row.
    let block = (1..=width.min(height)).find(fits);
    let (block_x, block_y) = block.map_or((width, 1), |b| (b, b));
    let columns = width / block_x;
    let mut weights = vec![0.0; columns * (height / block_y)];
    for (y, row) in mean_luminance(map).chunks_exact(width).enumerate() {
        let dz = row_height(y as f64, height as f64);
        for (x, luminance) in row.iter().enumerate() {
            weights[(y / block_y) * columns + x / block_x] += dz * luminance;
        }
    }
    ([columns as u32, (height / block_y) as u32], weights)
}

/// Per texel the mean luminance over it. Where radiance is interpolated, a texel's mean takes in its neighbours by
/// 1/8, 6/8, 1/8 per axis: it is above zero wherever the interpolated radiance is.
fn mean_luminance(map: &EnvironmentMap) -> Vec<f64> {
    let luminance: Vec<f64> = map.texels.iter().map(|&t| texel_luminance(t)).collect();
    if map.interpolation == Interpolation::Nearest {
        return luminance;
    }
    let (width, height) = (map.width as usize, map.height as usize);
    let mean = |before: f64, at: f64, after: f64| 0.125 * before + 0.75 * at + 0.125 * after;
    let along_rows: Vec<f64> = luminance
        .chunks_exact(width)
        .flat_map(|row| {
            (0..width).map(|x| mean(row[(x + width - 1) % width], row[x], row[(x + 1) % width]))
        })
        .collect();
    let at = |x: usize, y: usize| along_rows[y * width + x];
    let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    texels
        .map(|(x, y)| {
            mean(
                at(x, y.saturating_sub(1)),
                at(x, y),
                at(x, (y + 1).min(height - 1)),
            )
        })
        .collect()
}

fn upload_texels(context: &Context, map: &EnvironmentMap) -> wgpu::TextureView {
    let size = wgpu::Extent3d {
        width: map.width,
        height: map.height,
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
    let texels: Vec<[f32; 4]> = map.texels.iter().map(|&[r, g, b]| [r, g, b, 0.0]).collect();
    context.queue.write_texture(
        texture.as_image_copy(),
        bytemuck::cast_slice(&texels),
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(map.width * 16),
            rows_per_image: None,
        },
        size,
    );
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}
