//! In an application that has a device of its own: the image grows pass by pass in the
//! application's texture, which is read back and saved here instead of shown.

use direkt::{LoadOptions, Renderer, Scene};

const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (device, queue) = pollster::block_on(open())?;
    let mut scene = Scene::load("scenes/veach.toml", &LoadOptions::default())?;
    scene.render.stop.spp = 32;
    let texture = texture(&device, scene.film.width, scene.film.height);

    let renderer = Renderer::from_device(&device, &queue);
    let mut render = renderer.begin(scene)?;
    loop {
        let ended = render.pass()?;
        render.image()?.write_texture(&queue, &texture)?;
        println!("{} samples per pixel", render.samples());
        if ended.is_some() {
            break;
        }
    }
    save(&device, &queue, &texture, "embed_wgpu.png")
}

async fn open() -> Result<(wgpu::Device, wgpu::Queue), Box<dyn std::error::Error>> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = instance.request_adapter(&Default::default()).await?;
    Ok(adapter.request_device(&Default::default()).await?)
}

fn texture(device: &wgpu::Device, width: u32, height: u32) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some("image"),
        size: wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: FORMAT,
        usage: wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

fn save(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
    path: &str,
) -> Result<(), Box<dyn std::error::Error>> {
    let (width, height) = (texture.width(), texture.height());
    // Rows of a copy begin at multiples of 256 bytes.
    let row = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("copy"),
        size: u64::from(row * height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(row),
        rows_per_image: None,
    };
    let mut encoder = device.create_command_encoder(&Default::default());
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout,
        },
        texture.size(),
    );
    queue.submit([encoder.finish()]);
    buffer.map_async(wgpu::MapMode::Read, .., |result| {
        result.expect("the buffer can be mapped")
    });
    device.poll(wgpu::PollType::wait_indefinitely())?;
    let mapped = buffer.get_mapped_range(..)?;
    let rows = mapped.chunks(row as usize);
    let texels = rows
        .flat_map(|row| &row[..4 * width as usize])
        .copied()
        .collect();
    image::RgbaImage::from_raw(width, height, texels)
        .expect("a texel per pixel")
        .save(path)?;
    println!("{path}");
    Ok(())
}
