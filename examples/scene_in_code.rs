//! A scene without a file: a sphere on a floor under a lamp, and a spot light.

use direkt::{Bsdf, Camera, Error, FilmSize, Geometry, Light, Renderer, Scene, SpotLight};
use glam::DVec3;

fn main() -> Result<(), Error> {
    let mut scene = Scene {
        camera: Camera::look_at(DVec3::new(0.0, 2.0, 5.0), DVec3::Y, DVec3::Y, 0.7)
            .expect("the eye is not what it looks at"),
        film: FilmSize {
            width: 320,
            height: 240,
        },
        ..Scene::default()
    };
    let grey = Bsdf::Lambert {
        reflectance: DVec3::splat(0.6),
    };
    let grey = scene.add_material("grey", grey);
    let floor = Geometry::Rectangle {
        corner: DVec3::new(-4.0, 0.0, 4.0),
        u: 8.0 * DVec3::X,
        v: -8.0 * DVec3::Z,
    };
    let ball = Geometry::Sphere {
        center: DVec3::Y,
        radius: 1.0,
    };
    // The front of a rectangle is where u × v points: down.
    let lamp = Geometry::Rectangle {
        corner: DVec3::new(-0.5, 3.0, -0.5),
        u: DVec3::X,
        v: DVec3::Z,
    };
    scene.add_shape("floor", floor, grey);
    scene.add_shape("ball", ball, grey);
    scene.add_area_light("lamp", lamp, grey, DVec3::splat(12.0));
    scene.lights.push(Light::Spot(SpotLight {
        position: DVec3::new(3.0, 3.0, 2.0),
        direction: DVec3::new(-3.0, -2.0, -2.0).normalize(),
        intensity: DVec3::new(20.0, 12.0, 6.0),
        inner_angle: 0.2,
        outer_angle: 0.4,
    }));
    let image = Renderer::new()?.render(scene)?;
    image.write("scene_in_code.png")?;
    println!("scene_in_code.png: mean radiance {:.4?}", image.mean());
    Ok(())
}
