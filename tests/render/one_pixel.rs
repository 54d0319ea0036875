//! One pixel, one exact value (section H of HARD CASES and closed forms).

use crate::support::{
    STRATEGIES, assert_pixel, context, emitter, floor_pixel, lambert, point_light, render, scene,
    shape, unit_square,
};
use direkt::scene::light::Interpolation;
use direkt::scene::{
    Emission, Environment, EnvironmentMap, EnvironmentRadiance, FilmSize, Geometry, Light,
    MaterialId, Scene,
};
use glam::{DMat3, DVec3};

/// Renders under every strategy and compares.
fn assert_under_every_strategy(scene: &Scene, spp: u64, expected: f64, what: &str) {
    let context = context();
    for strategy in STRATEGIES {
        let mut scene = scene.clone();
        scene.render.strategy = strategy;
        scene.render.spp = spp;
        let film = render(&context, scene);
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
    scene.render.spp = 8;
    let film = render(&context, scene);
    // The light spans rows 16 to 20 and columns 53 to 74 of the image; this pixel is well inside.
    let pixel = &film.pixels[18 * 128 + 64];
    let expected = [18.387_f32, 13.9873, 6.75357];
    for (c, expected) in expected.into_iter().enumerate() {
        assert_eq!(pixel.mean[c] as f32, expected, "channel {c}");
        assert!(pixel.m2[c] <= 0.0, "every sample is the same");
    }
}

#[test]
fn point_light_at_an_angle_and_above() {
    let mut scene = floor_pixel();
    scene
        .lights
        .push(point_light(DVec3::new(3.0, 0.0, 4.0), 100.0));
    assert_under_every_strategy(&scene, 4, 0.509_295_817_894_065, "point");
    scene.lights[0] = point_light_above();
    assert_under_every_strategy(&scene, 4, 3.978_873_577_297_38, "point above");
}

fn point_light_above() -> Light {
    point_light(DVec3::new(0.0, 0.0, 2.0), 100.0)
}

#[test]
fn point_light_below_the_floor_gives_nothing() {
    let mut scene = floor_pixel();
    scene
        .lights
        .push(point_light(DVec3::new(0.0, 0.0, -2.0), 100.0));
    assert_under_every_strategy(&scene, 4, 0.0, "point below");
}

#[test]
fn spot_light_with_equal_angles_is_a_step() {
    let spot = |degrees_off: f64| {
        let position = DVec3::new(0.0, 0.0, 2.0);
        let axis = DVec3::new(
            degrees_off.to_radians().sin(),
            0.0,
            -degrees_off.to_radians().cos(),
        );
        Light::Spot {
            position,
            direction: axis,
            intensity: DVec3::splat(100.0),
            inner_angle: 30_f64.to_radians(),
            outer_angle: 30_f64.to_radians(),
        }
    };
    let mut scene = floor_pixel();
    scene.lights.push(spot(29.9));
    assert_under_every_strategy(&scene, 4, 3.978_873_577_297_38, "inside the spot");
    scene.lights[0] = spot(30.1);
    assert_under_every_strategy(&scene, 4, 0.0, "outside the spot");
}

#[test]
fn spot_light_falls_off_with_the_square_of_the_cosines() {
    let (inner, outer, angle) = (
        20_f64.to_radians(),
        40_f64.to_radians(),
        30_f64.to_radians(),
    );
    let mut scene = floor_pixel();
    scene.lights.push(Light::Spot {
        position: DVec3::new(0.0, 0.0, 2.0),
        direction: DVec3::new(angle.sin(), 0.0, -angle.cos()),
        intensity: DVec3::splat(100.0),
        inner_angle: inner,
        outer_angle: outer,
    });
    let f = (angle.cos() - outer.cos()) / (inner.cos() - outer.cos());
    assert_under_every_strategy(&scene, 4, 3.978_873_577_297_38 * f * f, "spot penumbra");
}

#[test]
fn directional_light() {
    let mut scene = floor_pixel();
    let angle = 60_f64.to_radians();
    scene.lights.push(Light::Directional {
        direction: DVec3::new(-angle.sin(), 0.0, -angle.cos()),
        irradiance: DVec3::splat(10.0),
    });
    assert_under_every_strategy(&scene, 4, 0.795_774_715_459_477, "directional");
}

fn constant(radiance: f64) -> Environment {
    Environment {
        radiance: EnvironmentRadiance::Constant(DVec3::splat(radiance)),
        rotation: DMat3::IDENTITY,
        scale: 1.0,
    }
}

#[test]
fn constant_environment() {
    let mut scene = floor_pixel();
    scene.environment = Some(constant(2.0));
    assert_under_every_strategy(&scene, 1 << 14, 1.0, "environment");
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

/// The map's up axis is turned to +z, the floor's normal. A row from θ₀ to θ₁ then gives the irradiance
/// L·π·(cos²θ₀ − cos²θ₁) · (fraction of the row).
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

/// A unit square of radiance 10 that faces the floor from height 1: ρ·L·F with F = 0.239456470460774.
#[test]
fn parallel_unit_square() {
    let mut scene = floor_pixel();
    scene.shapes.push(emitter(unit_square(), 10.0, false));
    assert_under_every_strategy(&scene, 1 << 14, 1.197_282_352_303_87, "unit square");
    // From behind nothing arrives, unless the back emits as well.
    let Geometry::Rectangle { u, v, .. } = &mut scene.shapes[1].geometry else {
        unreachable!("the light is a rectangle");
    };
    std::mem::swap(u, v);
    assert_under_every_strategy(&scene, 1 << 10, 0.0, "back of a one-sided light");
    scene.shapes[1].emission = Some(Emission {
        radiance: DVec3::splat(10.0),
        two_sided: true,
    });
    assert_under_every_strategy(
        &scene,
        1 << 14,
        1.197_282_352_303_87,
        "back of a two-sided light",
    );
}

/// CS667 2007, homework 4: a sphere of radiance 20 and radius 1 at distance 5 over albedo 0.5 gives exactly 0.4.
#[test]
fn sphere_light() {
    let mut scene = floor_pixel();
    scene.shapes.push(emitter(
        Geometry::Sphere {
            center: DVec3::new(0.0, 0.0, 5.0),
            radius: 1.0,
        },
        20.0,
        false,
    ));
    assert_under_every_strategy(&scene, 1 << 16, 0.4, "sphere");
}

/// A disk of radius 1 at height 1: F = ½.
#[test]
fn disk_light() {
    let mut scene = floor_pixel();
    scene.shapes.push(emitter(
        Geometry::Disk {
            center: DVec3::new(0.0, 0.0, 1.0),
            u: DVec3::new(0.0, 1.0, 0.0),
            v: DVec3::new(1.0, 0.0, 0.0),
        },
        10.0,
        false,
    ));
    assert_under_every_strategy(&scene, 1 << 14, 2.5, "disk");
}

/// CS667 2007, homework 4: a triangle of radiance 20 at height 5 gives 0.1621633 (albedo 0.5).
#[test]
fn triangle_light() {
    let mut scene = floor_pixel();
    let mesh = direkt::scene::Mesh {
        positions: vec![
            DVec3::new(0.0, 1.0, 5.0),
            DVec3::new(0.866, -0.5, 5.0),
            DVec3::new(-0.866, -0.5, 5.0),
        ],
        triangles: vec![[0, 1, 2]],
    };
    scene
        .shapes
        .push(emitter(Geometry::Mesh(mesh), 20.0, false));
    assert_under_every_strategy(&scene, 1 << 16, 0.162_163_3, "triangle");
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
    let film = render(&context, scene.clone());
    assert!(
        film.pixels
            .iter()
            .all(|p| p.samples == 16 && p.mean.iter().all(|&m| m.abs() <= 0.0))
    );
    scene.environment = Some(constant(0.75));
    let film = render(&context, scene);
    assert!(
        film.pixels
            .iter()
            .all(|p| p.mean.iter().all(|&m| (m - 0.75).abs() <= 0.0))
    );
}

#[test]
fn a_scene_without_lights_is_black() {
    let film = render(&context(), floor_pixel());
    assert_pixel(&film, 0.0, "no lights");
}

/// Rays pass through the back of a one-sided surface, as in glTF's culling, and not through its front.
#[test]
fn the_back_of_a_one_sided_surface_does_not_exist() {
    let context = context();
    let mut scene = floor_pixel();
    scene.lights.push(point_light_above());
    let mut one_sided = lambert(0.5);
    one_sided.double_sided = false;
    scene.materials.push(one_sided);
    let mut blocker = shape(
        "blocker",
        Geometry::Rectangle {
            corner: DVec3::new(-0.5, -0.5, 1.0),
            u: DVec3::new(1.0, 0.0, 0.0),
            v: DVec3::new(0.0, 1.0, 0.0),
        },
    );
    blocker.material = MaterialId(1);
    scene.shapes.push(blocker);
    // Its front points up: the shadow ray comes from below and passes.
    assert_pixel(
        &render(&context, scene.clone()),
        3.978_873_577_297_38,
        "seen from behind",
    );
    scene.materials[1].double_sided = true;
    assert_pixel(&render(&context, scene), 0.0, "double-sided");
}
