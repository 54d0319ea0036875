//! One pixel, one exact value, for what no scene file says: environment maps made here, scenes
//! without lights.

use crate::support::hard_cases::{Measured, survive};
use crate::support::{STRATEGIES, assert_pixel, context, floor_pixel, render, scene};
use direkt::low_level::gpu::Context;
use direkt::low_level::render::Pixel;
use direkt::scene::environment::Interpolation;
use direkt::scene::{Environment, EnvironmentMap, EnvironmentRadiance, FilmSize, Scene};
use glam::{DMat3, DVec3};

/// Renders under every strategy and compares.
fn assert_under_every_strategy(scene: &Scene, spp: u64, expected: f64, what: &str) {
    let context = context();
    for strategy in STRATEGIES {
        let mut scene = scene.clone();
        scene.render.estimator.strategy = strategy;
        scene.render.stop.spp = spp;
        let film = render(context, scene);
        assert_pixel(
            &film,
            expected,
            &format!("{what}, {strategy}, {}", context.adapter.name),
        );
    }
}

#[test]
fn cornells_light_seen_directly_is_its_radiance() {
    let context = context();
    let mut scene = scene("scenes/cornell.toml");
    scene.film = FilmSize {
        width: 128,
        height: 128,
    };
    scene.render.stop.spp = 8;
    let film = render(context, scene);
    // The light spans rows 16 to 20 and columns 53 to 74 of the image; this pixel is well inside.
    let pixel = &film.pixels[18 * 128 + 64];
    let expected = [18.387_f32, 13.9873, 6.75357];
    for (c, expected) in expected.into_iter().enumerate() {
        assert_eq!(pixel.mean[c] as f32, expected, "channel {c}");
        assert!(pixel.m2[c] <= 0.0, "every sample is the same");
    }
}

fn constant(radiance: f64) -> Environment {
    Environment {
        radiance: EnvironmentRadiance::Constant(DVec3::splat(radiance)),
        rotation: DMat3::IDENTITY,
        scale: 1.0,
    }
}

#[test]
fn a_constant_map_is_a_constant_environment() {
    let mut scene = floor_pixel();
    scene.environment = Some(map(16, 8, |_, _| 2.0));
    assert_under_every_strategy(&scene, 1 << 14, 1.0, "constant map");
}

fn map(width: u32, height: u32, value: impl Fn(u32, u32) -> f32) -> Environment {
    let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    Environment {
        radiance: EnvironmentRadiance::Map(EnvironmentMap {
            source: "test".to_owned(),
            width,
            height,
            texels: texels.map(|(x, y)| [value(x, y); 3]).collect(),
            interpolation: Interpolation::Nearest,
        }),
        rotation: DMat3::from_rotation_x(std::f64::consts::FRAC_PI_2),
        scale: 1.0,
    }
}

/// The map's up axis is turned to +z, the floor's normal. A row from θ₀ to θ₁ then gives the
/// irradiance L·π·(cos²θ₀ − cos²θ₁) · (fraction of the row).
#[test]
fn one_bright_texel() {
    let (width, height) = (16, 8);
    for (column, row) in [(3, 0), (9, 2), (15, 3)] {
        let mut scene = floor_pixel();
        scene.environment = Some(map(width, height, |x, y| {
            if (x, y) == (column, row) { 1e6 } else { 0.0 }
        }));
        let cos = |j: u32| (std::f64::consts::PI * f64::from(j) / f64::from(height)).cos();
        let irradiance = 1e6 * std::f64::consts::PI * (cos(row).powi(2) - cos(row + 1).powi(2))
            / f64::from(width);
        let expected = 0.5 / std::f64::consts::PI * irradiance;
        assert_under_every_strategy(
            &scene,
            1 << 16,
            expected,
            &format!("texel ({column}, {row})"),
        );
    }
}

/// Where each row of a map has one radiance, interpolation blends rows alone: the irradiance is
/// ∫ L(θ) cosθ dω, here by quadrature over θ in f64.
#[test]
fn interpolated_rows() {
    let rows = [4.0, 0.0, 1.0, 3.0, 0.5, 0.0, 2.0, 7.0_f64];
    let radiance = |theta: f64| {
        let y = 8.0 * theta / std::f64::consts::PI - 0.5;
        let at = |j: f64| rows[j.clamp(0.0, 7.0) as usize];
        let low = y.floor();
        at(low) + (at(low + 1.0) - at(low)) * (y - low)
    };
    let steps = 1 << 16;
    let width = 0.5 * std::f64::consts::PI / f64::from(steps);
    let irradiance: f64 = (0..steps)
        .map(|i| (f64::from(i) + 0.5) * width)
        .map(|theta| {
            2.0 * std::f64::consts::PI * radiance(theta) * theta.cos() * theta.sin() * width
        })
        .sum();
    let mut scene = floor_pixel();
    let mut environment = map(16, 8, |_, y| rows[y as usize] as f32);
    let EnvironmentRadiance::Map(map) = &mut environment.radiance else {
        unreachable!("the environment is a map");
    };
    map.interpolation = Interpolation::Linear;
    scene.environment = Some(environment);
    assert_under_every_strategy(
        &scene,
        1 << 16,
        0.5 / std::f64::consts::PI * irradiance,
        "interpolated rows",
    );
}

#[test]
fn an_empty_scene_is_black_or_its_environment() {
    let context = context();
    let mut scene = floor_pixel();
    scene.shapes.clear();
    scene.film = FilmSize {
        width: 9,
        height: 5,
    };
    let film = render(context, scene.clone());
    assert!(
        film.pixels
            .iter()
            .all(|p| p.samples == 16 && p.mean.iter().all(|&m| m.abs() <= 0.0))
    );
    scene.environment = Some(constant(0.75));
    let film = render(context, scene);
    let off = |p: &&Pixel| p.mean.iter().any(|&m| (m - 0.75).abs() > 0.0);
    let off = film.pixels.iter().filter(off).count();
    let empty = context.checked(|| {
        drop(bind_empty(context));
    });
    survive(
        context,
        Measured {
            entry: "I4",
            case: "no shape under a constant sky, 9 × 5 pixels",
            figure: "pixels that are not exactly the sky",
            bound: 0.0,
            textbook: "buffers of as many elements as there are",
            naive: empty.map_or(f64::NAN, |()| 0.0),
            ours: off as f64,
        },
    );
}

#[test]
fn a_scene_without_lights_is_black() {
    let film = render(context(), floor_pixel());
    assert_pixel(&film, 0.0, "no lights");
}

/// Binds a buffer without elements for a kernel to read.
fn bind_empty(context: &Context) -> wgpu::BindGroup {
    let device = &context.device;
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: 0,
        usage: wgpu::BufferUsages::STORAGE,
        mapped_at_creation: false,
    });
    let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &[wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Storage { read_only: true },
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        }],
    });
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &layout,
        entries: &[wgpu::BindGroupEntry {
            binding: 0,
            resource: buffer.as_entire_binding(),
        }],
    })
}
