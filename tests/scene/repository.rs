//! The scenes of the repository are what their first lines say.

use crate::support::shared;
use direkt::scene::load::{LoadOptions, load};
use direkt::scene::{EnvironmentRadiance, Geometry, Scene};
use glam::DVec3;
use std::path::Path;

fn near(a: DVec3, b: DVec3) -> bool {
    a.distance(b) < 1e-6
}

/// Centre and unit normal of a rectangle.
fn rectangle(geometry: &Geometry) -> (DVec3, DVec3) {
    let Geometry::Rectangle { corner, u, v } = geometry else {
        panic!("{geometry:?} is no rectangle")
    };
    (corner + 0.5 * (u + v), u.cross(*v).normalize())
}

fn repository_scene(name: &str, options: &LoadOptions) -> Scene {
    let path = Path::new(crate::support::PROJECT).join("scenes").join(name);
    load(&path, options).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn cornell_faces_inwards() {
    let scene = repository_scene("cornell.toml", &LoadOptions::default());
    assert_eq!(scene.warnings, [""; 0]);
    assert_eq!(scene.shapes.len(), 6 + 2 * 6);
    let expected = [
        (DVec3::new(0.0, 0.99, 0.01), DVec3::NEG_Y),
        (DVec3::NEG_Y, DVec3::Y),
        (DVec3::Y, DVec3::NEG_Y),
        (DVec3::NEG_Z, DVec3::Z),
        (DVec3::X, DVec3::NEG_X),
        (DVec3::NEG_X, DVec3::X),
    ];
    for (shape, (center, normal)) in scene.shapes.iter().zip(expected) {
        let (c, n) = rectangle(&shape.geometry);
        assert!(
            near(c, center) && near(n, normal),
            "{}: {c} {n}",
            shape.name
        );
    }
    let Geometry::Rectangle { u, v, .. } = scene.shapes[0].geometry else {
        panic!("the light is a rectangle")
    };
    assert!((u.length() - 0.46).abs() < 1e-12 && (v.length() - 0.38).abs() < 1e-12);
    let boxes = [
        DVec3::new(0.335, -0.7, 0.38),
        DVec3::new(-0.33, -0.4, -0.28),
    ];
    for (faces, center) in scene.shapes[6..].chunks(6).zip(boxes) {
        for face in faces {
            let (c, n) = rectangle(&face.geometry);
            assert!((c - center).dot(n) > 0.29, "{} faces inwards", face.name);
        }
    }
    assert_eq!(scene.shapes[6].name, "shapes[6]: small box (box face -x)");
}

#[test]
fn veach_plates_face_camera_and_lights() {
    let scene = repository_scene("veach.toml", &LoadOptions::default());
    assert_eq!(scene.warnings, [""; 0]);
    assert_eq!((scene.film.width, scene.film.height), (768, 512));
    for plate in &scene.shapes[..6] {
        let (c, n) = rectangle(&plate.geometry);
        assert!(
            (scene.camera.eye - c).dot(n) > 0.0,
            "{} and the camera",
            plate.name
        );
        assert!(
            (DVec3::ZERO - c).dot(n) > 0.0,
            "{} and the lights",
            plate.name
        );
    }
    let emitters = scene.shapes.iter().filter(|s| s.emission.is_some());
    assert_eq!(emitters.count(), 5);
}

#[test]
fn the_wall_light_stands_on_the_floor() {
    let scene = repository_scene("corner.toml", &LoadOptions::default());
    assert_eq!(scene.warnings, [""; 0]);
    let (_, up) = rectangle(&scene.shapes[0].geometry);
    assert!(near(up, DVec3::Y));
    let Geometry::Rectangle { corner, u, .. } = scene.shapes[1].geometry else {
        panic!("the light is a rectangle")
    };
    assert!(scene.shapes[1].emission.is_some());
    assert!(corner.y.abs() < 1e-12 && (corner + u).y.abs() < 1e-12);
    let (_, normal) = rectangle(&scene.shapes[1].geometry);
    assert!(near(normal, DVec3::Z), "it shines into the room");
}

#[test]
fn other_scenes_of_the_repository_load() {
    let scene = repository_scene("spot_and_sun.toml", &LoadOptions::default());
    assert_eq!(scene.warnings, [""; 0]);
    assert_eq!(scene.lights.len(), 3);

    let Some(assets) = shared("assets") else {
        return;
    };
    let options = LoadOptions {
        assets: vec![assets],
        ..LoadOptions::default()
    };
    let bunny = repository_scene("bunny.toml", &options);
    assert_eq!(bunny.warnings, [""; 0]);
    let Geometry::Mesh(mesh) = &bunny.shapes[0].geometry else {
        panic!("the bunny is a mesh")
    };
    assert_eq!(
        (mesh.positions.len(), mesh.triangles.len()),
        (34_834, 69_451)
    );
    let light = rectangle(&bunny.shapes[2].geometry);
    assert!(
        light.1.dot(DVec3::new(0.0, 0.1, 0.0) - light.0) > 0.0,
        "the light shines at it"
    );

    let helmet = repository_scene("helmet.toml", &options);
    assert_eq!(helmet.shapes.len(), 7);
    let environment = helmet.environment.expect("it has a sky");
    let EnvironmentRadiance::Map(map) = environment.radiance else {
        panic!("the sky is a map")
    };
    assert_eq!((map.width, map.height), (1024, 512));
}

#[test]
fn repository_scenes_say_what_they_prove() {
    let folder = Path::new(crate::support::PROJECT).join("scenes");
    for entry in std::fs::read_dir(folder).expect("scenes/ exists") {
        let path = entry.expect("scenes/ can be listed").path();
        if path.extension().is_some_and(|e| e == "toml") {
            let text = std::fs::read_to_string(&path).expect("a text file");
            assert!(text.starts_with("# Proves: "), "{}", path.display());
        }
    }
}
