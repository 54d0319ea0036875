//! The textures of a scene as the GPU reads them: rectangles in the layers of two texture arrays.
//!
//! One binding holds textures of all sizes this way, and filtering is the shader's own, so that it
//! is as exact as the reference's: a sampler's weights have 8 bits.

use super::context::Context;
use crate::error::GpuError;
use crate::scene::{Material, Scene, Texels, Texture, TextureId, TextureUse};
use guillotiere::{AtlasAllocator, size2};
use half::f16;
use std::collections::BTreeMap;

/// Where a texture lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Place {
    /// Layer of its array.
    pub layer: u32,
    /// Its upper left texel.
    pub origin: [u32; 2],
}

/// Textures packed into the layers of an array.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Atlas {
    /// Texels of a layer along each side.
    pub size: [u32; 2],
    /// Number of layers.
    pub layers: u32,
    /// Where each texture lies.
    pub places: BTreeMap<TextureId, Place>,
}

impl Atlas {
    /// Packs `textures`, larger ones first, into layers as large as the largest width and height.
    pub fn new<'a>(textures: impl IntoIterator<Item = (TextureId, &'a Texture)>) -> Self {
        let mut textures: Vec<_> = textures.into_iter().collect();
        textures.sort_by_key(|(_, t)| std::cmp::Reverse(u64::from(t.width) * u64::from(t.height)));
        let longest = |side: fn(&Texture) -> u32| textures.iter().map(|(_, t)| side(t)).max();
        let size = [longest(|t| t.width), longest(|t| t.height)].map(|side| side.unwrap_or(1));
        let whole = size2(size[0] as i32, size[1] as i32);
        let mut layers: Vec<AtlasAllocator> = Vec::new();
        let mut places = BTreeMap::new();
        for (id, texture) in textures {
            let wanted = size2(texture.width as i32, texture.height as i32);
            let mut found = layers
                .iter_mut()
                .zip(0..)
                .find_map(|(layer, index)| Some((index, layer.allocate(wanted)?.rectangle.min)));
            if found.is_none() {
                let mut layer = AtlasAllocator::new(whole);
                let place = layer.allocate(wanted);
                layers.push(layer);
                found = place.map(|place| (layers.len() as u32 - 1, place.rectangle.min));
            }
            let (layer, corner) = found.expect("an empty layer holds every texture");
            let origin = [corner.x as u32, corner.y as u32];
            places.insert(id, Place { layer, origin });
        }
        Self {
            size,
            layers: layers.len() as u32,
            places,
        }
    }

    /// Bytes of a texel on the GPU: four where all of its textures of `scene` are made of bytes.
    fn texel_bytes(&self, scene: &Scene) -> u32 {
        let mut textures = self.places.keys().map(|id| &scene.textures[id.index()]);
        let bytes = textures.all(|t| matches!(t.texels, Texels::Bytes(_)));
        if bytes { 4 } else { 8 }
    }

    /// Its size on the GPU; one texel where there are no textures.
    pub fn bytes(&self, scene: &Scene) -> u64 {
        let texels = self.size.map(u64::from).iter().product::<u64>() * u64::from(self.layers);
        texels.max(1) * u64::from(self.texel_bytes(scene))
    }
}

/// The textures of a scene on the GPU.
#[derive(Debug)]
pub struct TextureArrays {
    /// Those read as colours.
    pub colors: TextureArray,
    /// Those read as other numbers.
    pub data: TextureArray,
}

/// One array of layers.
#[derive(Debug)]
pub struct TextureArray {
    /// Where textures lie.
    pub atlas: Atlas,
    /// All layers; one of one texel where there are no textures.
    pub view: wgpu::TextureView,
}

/// The textures that the materials and lights of `scene` read: as colours, and as other numbers.
pub fn atlases(scene: &Scene) -> [Atlas; 2] {
    let emitted = scene.shapes.iter().filter_map(|s| s.emission?.texture);
    let emitted: Vec<TextureId> = emitted.map(|u| u.texture).collect();
    let read = |uses: fn(&Material) -> [Option<TextureUse>; 3], further: &[TextureId]| {
        let uses = scene.materials.iter().flat_map(uses).flatten();
        let ids = uses.map(|used| used.texture);
        let mut ids: Vec<TextureId> = ids.chain(further.iter().copied()).collect();
        ids.sort_unstable();
        ids.dedup();
        Atlas::new(ids.into_iter().map(|id| (id, &scene.textures[id.index()])))
    };
    [
        read(
            |m| {
                let maps = &m.textures;
                [maps.color, maps.specular_glossiness, m.opacity.texture]
            },
            &emitted,
        ),
        read(
            |m| {
                let normal = m.textures.normal.map(|map| map.texture);
                [m.textures.metallic_roughness, normal, None]
            },
            &[],
        ),
    ]
}

impl TextureArrays {
    /// Uploads the textures of `scene`.
    ///
    /// # Errors
    /// There are more than the adapter's texture arrays hold, or memory runs out.
    pub fn new(context: &Context, scene: &Scene) -> Result<Self, GpuError> {
        let [colors, data] = atlases(scene);
        Ok(Self {
            colors: TextureArray::new(context, scene, colors, "colour textures")?,
            data: TextureArray::new(context, scene, data, "normal and roughness textures")?,
        })
    }
}

impl TextureArray {
    fn new(context: &Context, scene: &Scene, atlas: Atlas, what: &str) -> Result<Self, GpuError> {
        let limits = &context.limits;
        let side = u64::from(limits.max_texture_dimension_2d);
        for (needed, limit, of) in [
            (atlas.size[0].into(), side, "texels of a row"),
            (atlas.size[1].into(), side, "texels of a column"),
            (
                atlas.layers.into(),
                limits.max_texture_array_layers.into(),
                "layers",
            ),
        ] {
            if needed > limit {
                return Err(GpuError::TooMany {
                    what: format!("{of} of the {what}"),
                    needed,
                    limit,
                    adapter: context.adapter.name.clone(),
                });
            }
        }
        let textures: Vec<(&Texture, Place)> = atlas
            .places
            .iter()
            .map(|(id, place)| (&scene.textures[id.index()], *place))
            .collect();
        let texel = atlas.texel_bytes(scene);
        let format = if texel == 4 {
            wgpu::TextureFormat::Rgba8Unorm
        } else {
            wgpu::TextureFormat::Rgba16Float
        };
        let size = wgpu::Extent3d {
            width: atlas.size[0].max(1),
            height: atlas.size[1].max(1),
            depth_or_array_layers: atlas.layers.max(1),
        };
        let view = context.checked(|| {
            let texture = context.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(what),
                size,
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
                view_formats: &[],
            });
            for (source, place) in &textures {
                upload(context, &texture, source, *place, texel);
            }
            texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2Array),
                ..Default::default()
            })
        })?;
        Ok(Self { atlas, view })
    }
}

/// Writes `source` to its place in `texture`, whose texels have `texel` bytes.
fn upload(context: &Context, texture: &wgpu::Texture, source: &Texture, place: Place, texel: u32) {
    let converted: Vec<[f16; 4]>;
    let bytes: &[u8] = match &source.texels {
        Texels::Bytes(texels) if texel == 4 => bytemuck::cast_slice(texels),
        Texels::Bytes(texels) => {
            let half = |n: u8| f16::from_f64(f64::from(n) / 255.0);
            converted = texels.iter().map(|t| t.map(half)).collect();
            bytemuck::cast_slice(&converted)
        }
        Texels::Halves(texels) => bytemuck::cast_slice(texels),
    };
    context.queue.write_texture(
        wgpu::TexelCopyTextureInfo {
            origin: wgpu::Origin3d {
                x: place.origin[0],
                y: place.origin[1],
                z: place.layer,
            },
            ..texture.as_image_copy()
        },
        bytes,
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(source.width * texel),
            rows_per_image: None,
        },
        wgpu::Extent3d {
            width: source.width,
            height: source.height,
            depth_or_array_layers: 1,
        },
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    fn blank(width: u32, height: u32) -> Texture {
        Texture {
            source: String::new(),
            width,
            height,
            texels: Texels::Bytes(Vec::new()),
        }
    }

    #[test]
    fn textures_lie_apart_in_few_layers() {
        let sizes = [
            (64, 64),
            (32, 32),
            (32, 32),
            (16, 64),
            (64, 16),
            (32, 16),
            (1, 1),
            (48, 48),
        ];
        let textures: Vec<Texture> = sizes.iter().map(|&(w, h)| blank(w, h)).collect();
        let ids = (0..).map(TextureId);
        let atlas = Atlas::new(ids.zip(&textures));
        assert_eq!(atlas.size, [64, 64]);
        assert!(atlas.layers <= 4, "{} layers", atlas.layers);
        let mut taken = vec![false; 64 * 64 * atlas.layers as usize];
        for (id, place) in &atlas.places {
            let (width, height) = sizes[id.index()];
            for y in place.origin[1]..place.origin[1] + height {
                for x in place.origin[0]..place.origin[0] + width {
                    assert!(x < 64 && y < 64, "{id:?} at {place:?}");
                    let texel = &mut taken[((place.layer * 64 + y) * 64 + x) as usize];
                    assert!(!std::mem::replace(texel, true), "{id:?} covers another");
                }
            }
        }
        assert_eq!(atlas.places.len(), sizes.len());
    }
}
