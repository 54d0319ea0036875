//! `shaders/light/opacity.wesl`: the part of a light's radiance that light sampling finds.

use crate::support::random::Random;
use crate::support::shader::{Function, call_in, words};
use crate::support::{context, lambert, prepared_for, scene};
use direkt::low_level::effects::Effect;
use direkt::low_level::reference::light::opacity::light_opacity;
use direkt::low_level::reference::scene::fetch::World;
use direkt::scene::environment::Interpolation;
use direkt::scene::{Emission, Geometry, LightSelection, MaterialId, Opacity, Scene, Strategy};
use glam::{DMat3, DVec3};

/// The veil of a texture as a light, a disk and a triangle of the same material, a sphere of
/// opacity 0.3 and a light without an opacity.
fn lights() -> Scene {
    let mut scene = scene("scenes/tests/opacity_texture.toml");
    let material = scene
        .materials
        .iter()
        .position(|m| m.opacity.texture.is_some());
    let material = MaterialId(material.expect("a veil") as u32);
    let opacity = &mut scene.materials[material.index()].opacity;
    if let Some(texture) = &mut opacity.texture {
        texture.interpolation = Interpolation::Linear;
    }
    scene.materials.push(direkt::scene::Material {
        opacity: Opacity::constant(0.3),
        ..lambert(0.5)
    });
    let sphere = MaterialId(scene.materials.len() as u32 - 1);
    let veil = scene.shapes[0].clone();
    let mut add = |geometry: Geometry, material: MaterialId| {
        let mut shape = veil.clone();
        (shape.geometry, shape.material) = (geometry, material);
        scene.shapes.push(shape);
    };
    add(
        Geometry::Disk {
            center: DVec3::new(5.0, 0.0, 0.0),
            u: DVec3::new(1.5, 0.2, 0.0),
            v: DVec3::new(-0.1, 1.0, 0.3),
        },
        material,
    );
    let mesh = direkt::scene::Mesh {
        positions: vec![
            DVec3::new(0.0, 4.0, 0.0),
            DVec3::new(3.0, 4.0, 0.5),
            DVec3::new(1.0, 7.0, 0.0),
        ],
        triangles: vec![[0, 1, 2]],
        uvs: vec![
            glam::DVec2::ZERO,
            glam::DVec2::new(1.0, 0.1),
            glam::DVec2::new(0.2, 0.9),
        ],
        ..direkt::scene::Mesh::default()
    };
    add(Geometry::Mesh(mesh), material);
    add(
        Geometry::Sphere {
            center: DVec3::new(-5.0, 0.0, 0.0),
            radius: 1.0,
        },
        sphere,
    );
    add(
        Geometry::Ellipsoid {
            center: DVec3::new(-8.0, 0.0, 0.0),
            axes: DMat3::from_diagonal(DVec3::new(1.0, 0.5, 0.8)),
        },
        sphere,
    );
    for shape in &mut scene.shapes {
        shape.emission = Some(Emission {
            radiance: DVec3::ONE,
            texture: None,
            two_sided: false,
        });
    }
    scene
}

#[test]
fn light_samples_find_the_twins_part() {
    let prepared = prepared_for(lights(), Strategy::MisPower, LightSelection::Power);
    assert!(prepared.effects.contains(Effect::AlphaLights));
    let world = World::new(&prepared);
    let function = Function {
        imports: "import package::light::opacity::light_opacity;",
        body: "out_f32(0u, light_opacity(in_u32(6u), in_vec3f(0u), in_vec3f(3u)));",
        inputs: 7,
        outputs: 1,
        features: &[],
    };
    let mut random = Random::new(73);
    let mut cases = Vec::new();
    for index in 0..prepared.emitters.lights.len() as u32 {
        let direkt::low_level::emitters::Emitter::Area { primitive, .. } =
            prepared.emitters.lights[index as usize]
        else {
            continue;
        };
        for _ in 0..2000 {
            let (s, t) = (random.between(0.01, 0.49), random.between(0.01, 0.49));
            use direkt::low_level::accel::PrimitiveGeometry as Shape;
            let (y, normal) = match prepared.data.primitives[primitive as usize].geometry {
                Shape::Triangle { a, u, v }
                | Shape::Rectangle { a, u, v }
                | Shape::Disk { a, u, v } => (a + s * u + t * v, u.cross(v).normalize()),
                Shape::Sphere { center, radius } => (center + radius * DVec3::Z, DVec3::Z),
                Shape::Ellipsoid { center, .. } => (center, DVec3::Z),
            };
            let x = y + 0.5 * normal + 0.2 * random.in_cube();
            let wi = (y - x).normalize();
            cases.push((index, x.as_vec3().as_dvec3(), wi.as_vec3().as_dvec3()));
        }
    }
    let inputs: Vec<u32> = cases
        .iter()
        .flat_map(|(index, x, wi)| {
            let mut item = words(&[x.x, x.y, x.z, wi.x, wi.y, wi.z]);
            item.push(*index);
            item
        })
        .collect();
    let answers = call_in(context(), &prepared, &function, &inputs, cases.len());
    let mut seen = [false; 3];
    for ((index, x, wi), got) in cases.iter().zip(answers.f64(0)) {
        let expected = light_opacity(&world, *index, *x, *wi);
        let kind = if expected >= 1.0 {
            0
        } else {
            1 + usize::from((expected - 0.3).abs() > 1e-9)
        };
        seen[kind] = true;
        // Neighbouring texels differ by at most 0.8 over half the image.
        assert!(
            (got - expected).abs() < 1e-5,
            "light {index}: {got}, {expected}"
        );
    }
    assert_eq!(seen, [true; 3], "opaque, constant and textured lights");
}
