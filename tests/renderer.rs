//! A render in one call, as programs use it.

use crate::support::{context, floor_pixel, point_light, render, scene};
use direkt::low_level::render::StoppedBy;
use direkt::scene::{Aov, Aovs, FilmSize};
use direkt::{Bsdf, Error, Geometry, Image, Renderer, Scene};
use glam::DVec3;

fn renderer() -> Renderer {
    let context = context();
    Renderer::from_device(&context.device, &context.queue)
}

/// Cornell's box, small.
fn cornell() -> Scene {
    let mut scene = scene("scenes/cornell.toml");
    scene.film = FilmSize {
        width: 12,
        height: 8,
    };
    scene.render.stop.spp = 32;
    scene
}

fn image() -> Image {
    renderer().render(cornell()).unwrap()
}

#[test]
fn an_image_is_the_sessions() {
    let film = render(context(), cornell());
    let image = image();
    assert_eq!(*image.film(), film);
    assert_eq!([image.width(), image.height()], [12, 8]);
    let means: Vec<[f64; 3]> = film.pixels.iter().map(|p| p.mean).collect();
    assert!(image.radiance().eq(means));
    let errors = image.standard_errors().expect("32 samples");
    let variances = film.variances().expect("32 samples");
    assert_eq!(errors[50][1], variances[50][1].sqrt());
    assert_eq!(image.error(), film.error());
}

#[test]
fn a_render_ends_where_its_settings_say() {
    let mut scene = cornell();
    let ended = |scene: Scene| {
        let renderer = renderer();
        let mut render = renderer.begin(scene).unwrap();
        loop {
            if let Some(by) = render.pass().unwrap() {
                return (by, render.samples());
            }
        }
    };
    assert_eq!(ended(scene.clone()), (StoppedBy::Samples, 32));
    scene.render.stop.spp = u64::MAX;
    scene.render.stop.error = Some(0.5);
    let (by, samples) = ended(scene.clone());
    assert_eq!(by, StoppedBy::Error);
    assert!(samples < 10_000, "{samples}");
    scene.render.stop.error = None;
    scene.render.stop.time = Some(0.05);
    assert_eq!(ended(scene.clone()).0, StoppedBy::Time);
    scene.render.stop.time = None;
    scene.render.stop.error = Some(0.5);
    for shape in &mut scene.shapes {
        shape.emission = None;
    }
    assert_eq!(ended(scene.clone()).0, StoppedBy::Black);
    scene.render.stop.spp = 8;
    let renderer = renderer();
    let mut render = renderer.begin(scene).unwrap();
    while render.pass().unwrap().is_none() {}
    assert_eq!(render.pass().unwrap(), Some(StoppedBy::Samples));
    assert_eq!(render.samples(), 8);
}

#[test]
fn images_from_code_are_checked() {
    use direkt::Emission;
    use direkt::scene::environment::Interpolation;
    use direkt::scene::{TextureId, TextureUse, Wrap};
    let mut scene = cornell();
    scene.shapes[0].emission = Some(Emission {
        radiance: DVec3::ONE,
        two_sided: false,
        texture: Some(TextureUse {
            texture: TextureId(9),
            transform: glam::DAffine2::IDENTITY,
            wrap: [Wrap::Repeat; 2],
            interpolation: Interpolation::Linear,
            second_uvs: false,
        }),
    });
    let error = renderer().render(scene).unwrap_err().to_string();
    assert!(
        error.contains("emission.texture: is texture 9 of 0"),
        "{error}"
    );
}

#[test]
fn an_empty_scene_is_black() {
    let mut scene = Scene::default();
    (scene.film.width, scene.film.height) = (4, 4);
    assert_eq!(renderer().render(scene).unwrap().mean(), [0.0; 3]);
}

#[test]
fn a_scene_in_code_has_its_value() {
    let mut scene = Scene::default();
    let white = Bsdf::Lambert {
        reflectance: DVec3::ONE,
    };
    let white = scene.add_material("white", white);
    let wall = Geometry::Rectangle {
        corner: DVec3::new(-9.0, -9.0, 0.0),
        u: 18.0 * DVec3::X,
        v: 18.0 * DVec3::Y,
    };
    scene.add_shape("wall", wall, white);
    scene.lights.push(point_light(2.0 * DVec3::Z, 4.0));
    scene.film = FilmSize {
        width: 1,
        height: 1,
    };
    let direkt::scene::Projection::Perspective { fov_y } = &mut scene.camera.projection else {
        panic!("a perspective camera");
    };
    *fov_y = 1e-5;
    let mean = renderer().render(scene).unwrap().mean();
    let expected = std::f64::consts::FRAC_1_PI; // ρ/π · I/d²
    assert!(
        mean.iter().all(|x| (x / expected - 1.0).abs() < 1e-5),
        "{mean:?}"
    );
}

#[test]
fn a_number_out_of_its_domain_is_refused_by_name() {
    let mut scene = floor_pixel();
    scene.lights = vec![point_light(DVec3::Z, -1.0)];
    let error = renderer().render(scene).unwrap_err();
    assert!(matches!(error, Error::Input(_)));
    assert!(error.to_string().contains("lights[0].intensity"), "{error}");
}

#[test]
fn files_hold_what_their_names_say() {
    let mut scene = cornell();
    scene.render.aovs = Aovs::from_iter([Aov::Depth]);
    let image = renderer().render(scene).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let exr = folder.path().join("image.exr");
    image.write(&exr).unwrap();
    let read = exr::prelude::read_first_flat_layer_from_file(&exr).unwrap();
    let names = read.layer_data.channel_data.list.iter();
    let names: Vec<String> = names.map(|c| c.name.to_string()).collect();
    for wanted in ["R", "standard_error.G", "samples.X", "depth.Z"] {
        assert!(
            names.iter().any(|name| name == wanted),
            "{wanted}: {names:?}"
        );
    }
    let png = folder.path().join("image.png");
    image.write(&png).unwrap();
    assert_eq!(image::open(&png).unwrap().width(), 12);
    let error = image.write(folder.path().join("image.tiff")).unwrap_err();
    assert!(error.to_string().contains(".exr or .png"), "{error}");
}

fn texture(format: wgpu::TextureFormat, width: u32) -> wgpu::Texture {
    let usage = wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::COPY_SRC;
    texture_for(format, width, usage)
}

fn texture_for(
    format: wgpu::TextureFormat,
    width: u32,
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    context().device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d {
            width,
            height: 8,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}

/// The bytes of a texture, row by row.
fn texels(texture: &wgpu::Texture, bytes_per_texel: u32) -> Vec<u8> {
    let context = context();
    let row = bytes_per_texel * texture.width();
    let buffer = context.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: 256 * u64::from(texture.height()),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(256),
        rows_per_image: None,
    };
    let to = wgpu::TexelCopyBufferInfo {
        buffer: &buffer,
        layout,
    };
    let mut encoder = context.device.create_command_encoder(&Default::default());
    encoder.copy_texture_to_buffer(texture.as_image_copy(), to, texture.size());
    context.queue.submit([encoder.finish()]);
    let rows = |bytes: &[u8]| {
        bytes
            .chunks(256)
            .flat_map(|r| r[..row as usize].to_vec())
            .collect()
    };
    context.read(&buffer, rows).unwrap()
}

#[test]
fn textures_hold_the_image() {
    use wgpu::TextureFormat;
    let (image, queue) = (image(), &context().queue);
    let floats = texture(TextureFormat::Rgba32Float, 12);
    image.write_texture(queue, &floats).unwrap();
    let found: Vec<f32> = bytemuck::pod_collect_to_vec(&texels(&floats, 16));
    let expected: Vec<f32> = image
        .radiance()
        .flat_map(|[r, g, b]| [r as f32, g as f32, b as f32, 1.0])
        .collect();
    assert_eq!(found, expected);
    let halves = texture(TextureFormat::Rgba16Float, 12);
    image.write_texture(queue, &halves).unwrap();
    let found: Vec<u16> = bytemuck::pod_collect_to_vec(&texels(&halves, 8));
    let half = |x: f64| half::f16::from_f64(x).to_bits();
    let expected: Vec<u16> = image
        .radiance()
        .flat_map(|[r, g, b]| [r, g, b, 1.0].map(half))
        .collect();
    assert_eq!(found, expected);
    let bytes = texture(TextureFormat::Rgba8UnormSrgb, 12);
    image.write_texture(queue, &bytes).unwrap();
    let display = direkt::low_level::image::png::Display::default();
    let expected: Vec<u8> = image
        .radiance()
        .flat_map(|rgb| {
            let [r, g, b] = display.encode(rgb);
            [r, g, b, 255]
        })
        .collect();
    assert_eq!(texels(&bytes, 4), expected);
    let unwritable = texture_for(TextureFormat::Rgba8Unorm, 12, wgpu::TextureUsages::COPY_SRC);
    for (wrong, word) in [
        (texture(TextureFormat::Rgba32Float, 11), "11 × 8"),
        (texture(TextureFormat::R32Float, 12), "R32Float"),
        (unwritable, "COPY_DST"),
    ] {
        let error = image.write_texture(queue, &wrong).unwrap_err();
        assert!(error.to_string().contains(word), "{error}");
    }
}
