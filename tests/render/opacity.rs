//! Opacities against exact values, for what no scene file says.

use crate::support::{
    KINDS_OF_STRATEGIES, assert_pixel, context, emitter, floor_pixel, lambert, point_light,
    prepared, render, shape, unit_square,
};
use direkt::low_level::effects::Effect;
use direkt::scene::{Geometry, Material, MaterialId, Mesh, Opacity, Scene};
use glam::DVec3;

/// A black material of opacity `alpha`.
fn veil(alpha: f64) -> Material {
    Material {
        opacity: Opacity::constant(alpha),
        ..lambert(0.0)
    }
}

/// `count` rectangles of material 1 between the floor and what is above 1; none of their diagonals
/// meets the axis.
fn layers(count: u32) -> Geometry {
    let mut mesh = Mesh::default();
    for i in 0..count {
        let z = 0.2 + 0.6 * f64::from(i) / f64::from(count);
        let first = mesh.positions.len() as u32;
        let corners = [(-1.0, -1.0), (1.4, -1.0), (1.4, 1.0), (-1.0, 1.0)];
        mesh.positions
            .extend(corners.map(|(x, y)| DVec3::new(x, y, z)));
        mesh.triangles.push([first, first + 1, first + 2]);
        mesh.triangles.push([first, first + 2, first + 3]);
    }
    Geometry::Mesh(mesh)
}

fn under_layers(count: u32, alpha: f64) -> Scene {
    let mut scene = floor_pixel();
    scene.materials.push(veil(alpha));
    let mut shape = shape("layers", layers(count));
    shape.material = MaterialId(1);
    scene.shapes.push(shape);
    scene
}

/// The mean is the product of what each layer lets pass, under a point light, which only light
/// sampling finds, and under a square, of which BSDF samples find their part. The camera looks from
/// below the layers' edges.
#[test]
fn a_thousand_layers_let_the_product_pass() {
    let context = context();
    let passing = 0.997_f64.powi(1000);
    // 0.239456… is the form factor of a centred unit square at distance 1.
    for (name, expected) in [
        ("point", 3.978_873_577),
        ("square", 40.0 * 0.239_456_470_460_774),
    ] {
        let mut scene = under_layers(1000, 0.003);
        if name == "point" {
            scene
                .lights
                .push(point_light(DVec3::new(0.0, 0.0, 2.0), 100.0));
        } else {
            scene.shapes.push(emitter(unit_square(), 80.0, false));
        }
        scene.camera = direkt::scene::Camera::look_at(
            DVec3::new(1.0, -3.0, 0.15),
            DVec3::ZERO,
            DVec3::Z,
            1e-5,
        )
        .unwrap();
        scene.render.stop.spp = 1 << 14;
        for strategy in KINDS_OF_STRATEGIES {
            scene.render.estimator.strategy = strategy;
            let film = render(context, scene.clone());
            let what = format!("1000 layers, {name}, {strategy}, {}", context.adapter.name);
            assert_pixel(&film, passing * expected, &what);
        }
    }
}

/// A sphere whose back does not exist is crossed once.
#[test]
fn a_one_sided_sphere_is_crossed_once() {
    let context = context();
    let mut scene = floor_pixel();
    scene.shapes.clear();
    scene.materials[0] = Material {
        double_sided: false,
        ..veil(0.3)
    };
    let sphere = Geometry::Sphere {
        center: DVec3::ZERO,
        radius: 0.5,
    };
    scene.shapes.push(shape("sphere", sphere));
    scene.environment = Some(crate::support::every_kind::constant_environment());
    scene.render.stop.spp = 1 << 16;
    let film = render(context, scene);
    let mean = film.pixels[0].mean;
    let variance = 0.3 * 0.7 / f64::from(1 << 16);
    for (found, sky) in mean.iter().zip([0.2, 0.3, 0.5]) {
        let test = direkt::low_level::stats::z_test::z_test(found / sky, 0.7, variance, 1e-6);
        crate::support::statistics::accept(test.p_value, "a one-sided sphere");
    }
}

/// A minute opacity is one: nothing of the light is lost that f32 would show.
#[test]
fn a_minute_opacity_lets_all_but_nothing_pass() {
    let mut scene = under_layers(1, 1e-7);
    scene
        .lights
        .push(point_light(DVec3::new(0.0, 0.0, 2.0), 100.0));
    scene.render.stop.spp = 1 << 12;
    let prepared_scene = prepared(scene.clone());
    assert!(prepared_scene.effects.contains(Effect::Alpha));
    assert_pixel(&render(context(), scene), 3.978_873_577, "opacity 1e-7");
}

/// An opacity of 1 calls for nothing, and what has an opacity of 0 is not there at all, its
/// emission included.
#[test]
fn opaque_surfaces_and_absent_ones_call_for_nothing() {
    let opaque = prepared(under_layers(3, 1.0));
    assert!(!opaque.effects.contains(Effect::Alpha));
    assert_eq!(opaque.data.primitives.len(), 7);
    let mut scene = under_layers(3, 0.0);
    let mut light = emitter(unit_square(), 5.0, true);
    light.material = MaterialId(1);
    scene.shapes.push(light);
    let absent = prepared(scene);
    assert!(!absent.effects.contains(Effect::Alpha));
    assert!(!absent.effects.contains(Effect::Triangles));
    assert_eq!(
        (absent.data.primitives.len(), absent.emitters.lights.len()),
        (1, 0)
    );
}
