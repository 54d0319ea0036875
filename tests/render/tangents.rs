//! Normal maps under the tangents that vertices have.

use crate::support::{assert_pixel, context, floor_pixel, lambert, prepared, render, shape};
use direkt::low_level::effects::Effect;
use direkt::scene::environment::Interpolation;
use direkt::scene::{
    Camera, DirectionalLight, Geometry, Light, Mesh, NormalMap, Scene, Texels, Texture, TextureId,
    TextureUse, Wrap,
};
use glam::{DAffine2, DVec2, DVec3};
use std::f64::consts::PI;

/// The map's one value: leans along both tangents.
const TEXEL: [u8; 4] = [189, 82, 230, 255];

/// A floor of reflectance ½ whose vertices have the tangent `tangent`, of sense `sense`, while its
/// texture coordinates grow along x; light of irradiance 2π comes from `towards`.
fn floor(tangent: DVec3, sense: f64, towards: DVec3) -> Scene {
    let mut scene = floor_pixel();
    // From above, where every normal of the map is seen.
    let eye = DVec3::new(0.1, -0.3, 4.0);
    scene.camera = Camera::look_at(eye, DVec3::ZERO, DVec3::Z, 1e-5).unwrap();
    let corners = [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)];
    let corners = corners.map(|(x, y)| DVec2::new(x, y));
    let mesh = Mesh {
        positions: corners.map(|p| p.extend(0.0)).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        uvs: corners.map(|p| p * DVec2::new(1.0, -1.0)).to_vec(),
        normals: vec![DVec3::Z; 4],
        tangents: vec![tangent.extend(sense); 4],
        ..Mesh::default()
    };
    scene.shapes = vec![shape("floor", Geometry::Mesh(mesh))];
    scene.textures = vec![Texture {
        source: "normals".to_owned(),
        width: 1,
        height: 1,
        texels: Texels::Bytes(vec![TEXEL]),
    }];
    let mut material = lambert(0.5);
    material.textures.normal = Some(NormalMap {
        texture: TextureUse {
            texture: TextureId(0),
            transform: DAffine2::IDENTITY,
            wrap: [Wrap::Repeat; 2],
            interpolation: Interpolation::Nearest,
            second_uvs: false,
        },
        scale: 1.0,
    });
    scene.materials = vec![material];
    scene.lights = vec![Light::Directional(DirectionalLight {
        direction: -towards,
        irradiance: DVec3::splat(2.0 * PI),
    })];
    scene.render.stop.spp = 4;
    scene
}

/// ρE/π · n·l with n = x·t + y·w(n × t) + z·n (glTF 2.0, section 3.7.2.1), also where a tangent is
/// not orthogonal to the normal.
#[test]
fn normal_maps_turn_with_the_tangents() {
    let context = context();
    let towards = DVec3::new(0.48, 0.36, 0.8);
    let [x, y, z, _] = TEXEL.map(|byte| 2.0 * f64::from(byte) / 255.0 - 1.0);
    for (tangent, sense) in [
        (DVec3::Y, 1.0),
        (DVec3::Y, -1.0),
        (DVec3::NEG_X, 1.0),
        (DVec3::new(0.6, -0.8, 0.0), -1.0),
        (DVec3::new(0.6, -0.8, 1.5), 1.0),
    ] {
        let along = tangent.with_z(0.0).normalize();
        let normal = x * along + sense * y * DVec3::Z.cross(along) + z * DVec3::Z;
        let scene = floor(tangent, sense, towards);
        assert!(prepared(scene.clone()).effects.contains(Effect::Tangents));
        let expected = normal.normalize().dot(towards);
        assert_pixel(
            &render(context, scene),
            expected,
            &format!("{tangent}, {sense}"),
        );
    }
}

/// Tangents that the texture coordinates give anyway call for nothing, nor do those without
/// normals, which do not count.
#[test]
fn tangents_that_change_nothing_are_left_out() {
    let calls_for = |scene: Scene| prepared(scene).effects.contains(Effect::Tangents);
    assert!(!calls_for(floor(DVec3::X, 1.0, DVec3::Z)));
    let mut bare = floor(DVec3::Y, 1.0, DVec3::Z);
    let Geometry::Mesh(mesh) = &mut bare.shapes[0].geometry else {
        unreachable!("the floor is a mesh")
    };
    mesh.normals = Vec::new();
    assert!(!calls_for(bare));
}
