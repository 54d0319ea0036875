//! Textures of one material that are read with two sets of texture coordinates.

use crate::support::every_kind::constant_environment;
use crate::support::{assert_pixel, context, floor_pixel, lambert, prepared, render, shape};
use direkt::low_level::effects::Effect;
use direkt::scene::environment::Interpolation;
use direkt::scene::{
    EnvironmentRadiance, Geometry, Mesh, Opacity, Scene, Texels, Texture, TextureId, TextureUse,
    Wrap,
};
use glam::{DAffine2, DVec2, DVec3, Vec4};

/// Colour and alpha of the texel that the first texture coordinates name, and of that which the
/// second do.
const TEXELS: [[u8; 4]; 2] = [[51, 51, 51, 204], [153, 153, 153, 102]];

fn used(second_uvs: bool) -> TextureUse {
    TextureUse {
        texture: TextureId(0),
        transform: DAffine2::IDENTITY,
        wrap: [Wrap::Clamp; 2],
        interpolation: Interpolation::Nearest,
        second_uvs,
    }
}

/// A floor under a sky of radiance 1, its colour and opacity read with the sets that are said.
pub fn floor([color, opacity]: [bool; 2]) -> Scene {
    let mut scene = floor_pixel();
    let positions: Vec<DVec3> = [(-9.0, -9.0), (9.0, -9.0), (8.0, 9.0), (-9.0, 8.0)]
        .map(|(x, y)| DVec3::new(x, y, 0.0))
        .to_vec();
    scene.shapes = vec![shape(
        "floor",
        Geometry::Mesh(Mesh {
            uvs: vec![DVec2::new(0.25, 0.5); 4],
            second_uvs: vec![DVec2::new(0.75, 0.5); 4],
            colors: vec![Vec4::new(0.5, 0.5, 0.5, 1.0); 4],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            positions,
            ..Mesh::default()
        }),
    )];
    scene.textures = vec![Texture {
        source: "texels".to_owned(),
        width: 2,
        height: 1,
        texels: Texels::Bytes(TEXELS.to_vec()),
    }];
    let mut material = lambert(1.0);
    material.textures.color = Some(used(color));
    material.opacity = Opacity {
        texture: Some(used(opacity)),
        ..Opacity::default()
    };
    scene.materials = vec![material];
    let mut sky = constant_environment();
    sky.radiance = EnvironmentRadiance::Constant(DVec3::ONE);
    sky.scale = 1.0;
    scene.environment = Some(sky);
    scene.render.stop.spp = 1 << 12;
    scene
}

/// α·ρ + 1 − α, where both come from the texel that their own set names.
#[test]
fn each_texture_is_read_with_its_own_set() {
    let context = context();
    for (sets, reflectance, alpha) in [([true, false], 0.3, 0.8), ([false, true], 0.1, 0.4)] {
        let film = render(context, floor(sets));
        let expected = alpha * reflectance + 1.0 - alpha;
        assert_pixel(&film, expected, &format!("second sets {sets:?}"));
    }
}

/// What has no second set reads no texture of a material that asks for it, and one set calls for no
/// more.
#[test]
fn the_second_set_is_there_where_it_is_read() {
    let one = prepared(floor([false, false]));
    assert!(!one.effects.contains(Effect::SecondUvs));
    assert_eq!(one.data.attributes.words.len(), 2 * (3 + 3));
    let two = prepared(floor([false, true]));
    assert!(two.effects.contains(Effect::SecondUvs));
    assert_eq!(two.data.attributes.words.len(), 2 * (3 + 3 + 2));
    let mut missing = floor([false, true]);
    let Geometry::Mesh(mesh) = &mut missing.shapes[0].geometry else {
        panic!("a mesh")
    };
    mesh.second_uvs.clear();
    let missing = prepared(missing);
    assert!(!missing.effects.contains(Effect::SecondUvs));
    assert!(!missing.effects.contains(Effect::ColorTexture));
}
