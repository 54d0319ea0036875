//! A scene with every kind of primitive, material and light.

use super::{emitter, floor_pixel, lambert, point_light, shape};
use direkt::scene::environment::Interpolation;
use direkt::scene::material::DielectricLayer;
use direkt::scene::{
    Bsdf, DirectionalLight, Emission, Environment, EnvironmentMap, EnvironmentRadiance, Geometry,
    Light, Material, MaterialId, Mesh, Scene, Shape, SpotLight,
};
use glam::{DMat3, DVec3};

/// Every kind of primitive as a light and as a one-sided surface, every kind of light without a
/// surface, and `environment`. Nothing is parallel to an axis but the floor.
pub fn every_kind(environment: Environment) -> Scene {
    let mut scene = floor_pixel();
    scene.materials = vec![
        lambert(0.5),
        Material {
            name: "conductor".to_owned(),
            bsdf: Bsdf::Conductor {
                reflectance: DVec3::new(0.9, 0.7, 0.4),
                alpha: 0.2,
            },
            double_sided: false,
            ..lambert(0.0)
        },
        Material {
            name: "plastic".to_owned(),
            bsdf: Bsdf::MetallicRoughness {
                base_color: DVec3::new(0.1, 0.3, 0.6),
                metallic: 0.25,
                roughness: 0.4,
                layer: DielectricLayer::default(),
            },
            ..lambert(0.0)
        },
        Material {
            name: "gold".to_owned(),
            bsdf: Bsdf::Metal {
                eta: DVec3::new(0.221, 0.428, 1.334),
                k: DVec3::new(3.216, 2.462, 1.871),
                alpha: 0.3,
            },
            ..lambert(0.0)
        },
        Material {
            name: "mirror".to_owned(),
            bsdf: Bsdf::Mirror {
                reflectance: DVec3::new(0.9, 0.8, 0.7),
            },
            ..lambert(0.0)
        },
        Material {
            name: "pane".to_owned(),
            bsdf: Bsdf::Dielectric {
                ior: 1.5,
                transmittance: DVec3::new(0.9, 0.5, 0.7),
                thin: true,
            },
            ..lambert(0.0)
        },
    ];
    let geometries = |shift: DVec3| {
        [
            Geometry::Rectangle {
                corner: DVec3::new(-3.0, -2.0, 2.0) + shift,
                u: DVec3::new(0.3, 1.4, 0.1),
                v: DVec3::new(1.1, 0.2, -0.3),
            },
            Geometry::Mesh(Mesh {
                positions: vec![
                    DVec3::new(1.0, 0.5, 2.5) + shift,
                    DVec3::new(1.2, 2.0, 2.2) + shift,
                    DVec3::new(2.6, 0.7, 2.1) + shift,
                ],
                triangles: vec![[0, 1, 2]],
                ..Mesh::default()
            }),
            Geometry::Disk {
                center: DVec3::new(-1.5, 2.0, 1.8) + shift,
                u: DVec3::new(0.1, 0.8, 0.2),
                v: DVec3::new(0.5, 0.1, 0.1),
            },
            Geometry::Sphere {
                center: DVec3::new(1.5, -2.0, 1.7) + shift,
                radius: 0.6,
            },
            Geometry::Ellipsoid {
                center: DVec3::new(0.2, -2.4, 1.4) + shift,
                axes: DMat3::from_cols(
                    DVec3::new(0.45, 0.1, -0.1),
                    DVec3::new(0.0, 0.3, 0.15),
                    DVec3::new(0.1, 0.0, -0.2),
                ),
            },
        ]
    };
    for (i, geometry) in (0..).zip(geometries(DVec3::ZERO)) {
        scene.shapes.push(Shape {
            name: format!("light {i}"),
            geometry,
            material: MaterialId(2),
            emission: Some(Emission {
                texture: None,
                radiance: DVec3::new(1.0 + f64::from(i), 2.0, 0.5),
                two_sided: i == 1,
            }),
        });
    }
    for geometry in geometries(DVec3::new(0.3, 0.4, 3.0)) {
        scene.shapes.push(Shape {
            material: MaterialId(1),
            ..shape("one-sided", geometry)
        });
    }
    scene.lights = vec![
        point_light(DVec3::new(0.5, 0.3, 1.5), 3.0),
        Light::Spot(SpotLight {
            position: DVec3::new(-0.7, -0.5, 2.5),
            direction: DVec3::new(0.2, 0.1, -1.0).normalize(),
            intensity: DVec3::new(5.0, 4.0, 3.0),
            inner_angle: 0.3,
            outer_angle: 0.7,
        }),
        Light::Directional(DirectionalLight {
            direction: DVec3::new(0.3, -0.4, -1.0).normalize(),
            irradiance: DVec3::new(1.0, 1.5, 2.0),
        }),
    ];
    scene.environment = Some(environment);
    scene
}

/// `scene` with two more lights: a rectangle with right angles and a circular disk.
pub fn with_right_angles(mut scene: Scene) -> Scene {
    let along = DVec3::new(0.6, 0.1, -0.2);
    let across = DVec3::new(0.1, 0.2, 0.4);
    let geometries = [
        Geometry::Rectangle {
            corner: DVec3::new(-0.8, 0.9, 2.4),
            u: 1.5 * across,
            v: along,
        },
        Geometry::Disk {
            center: DVec3::new(0.9, 1.2, 1.1),
            u: 0.7 * along.normalize(),
            v: 0.7 * across.normalize(),
        },
    ];
    assert!(along.dot(across).abs() < 1e-15);
    for geometry in geometries {
        scene.shapes.push(Shape {
            material: MaterialId(2),
            ..emitter(geometry, 1.0, false)
        });
    }
    scene
}

/// The same radiance from everywhere.
pub fn constant_environment() -> Environment {
    Environment {
        radiance: EnvironmentRadiance::Constant(DVec3::new(0.2, 0.3, 0.5)),
        rotation: DMat3::IDENTITY,
        scale: 1.0,
    }
}

/// A turned map of 31 × 17 texels between 0.1 and 4.1.
pub fn environment_map(interpolation: Interpolation) -> Environment {
    let texel = |i: u32| {
        let value = 0.1 + (i * 7919 % 401) as f32 / 100.0;
        [value, 0.5 * value, 0.25 * value + 0.05]
    };
    Environment {
        radiance: EnvironmentRadiance::Map(EnvironmentMap {
            source: "test".to_owned(),
            width: 31,
            height: 17,
            texels: (0..31 * 17).map(texel).collect(),
            interpolation,
        }),
        rotation: DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 0.5).normalize(), 1.1),
        scale: 1.5,
    }
}
