//! Opacities from files: `alphaMode` of glTF, and TOML's `opacity`, `alpha_cutoff` and
//! `textures.opacity`.

use super::files::{Folder, load_gltf, triangle_gltf, with};
use super::textures::{png, with_texture};
use direkt::low_level::effects::Effect;
use direkt::low_level::prepare::Prepared;
use direkt::scene::{Opacity, Scene};
use image::{DynamicImage, ImageBuffer, ImageFormat, Luma, Rgba};
use serde_json::{Value, json};
use std::io::Cursor;

fn encoded(image: &DynamicImage) -> Vec<u8> {
    let mut bytes = Vec::new();
    let written = image.write_to(&mut Cursor::new(&mut bytes), ImageFormat::Png);
    written.expect("a PNG can be written");
    bytes
}

/// A PNG of one row whose texels are white, of these alphas.
fn alphas(alphas: &[u8]) -> Vec<u8> {
    let texel = |x: u32, _| Rgba([255, 255, 255, alphas[x as usize]]);
    let row = ImageBuffer::from_fn(alphas.len() as u32, 1, texel);
    encoded(&DynamicImage::ImageRgba8(row))
}

/// A PNG of one row and one channel.
fn greys(greys: &[u8]) -> Vec<u8> {
    let row = ImageBuffer::from_fn(greys.len() as u32, 1, |x, _| Luma([greys[x as usize]]));
    encoded(&DynamicImage::ImageLuma8(row))
}

/// The triangle with this material and a base colour whose texels have these alphas.
fn gltf(material: Value, texels: &[u8]) -> Scene {
    let json = with(triangle_gltf(), "/materials", json!([material]));
    load_gltf(&with_texture(json, &alphas(texels))).expect("a valid glTF")
}

fn textured(mode: Value) -> Value {
    let mut material = json!({
        "pbrMetallicRoughness": {
            "baseColorFactor": [1, 1, 1, 0.5],
            "baseColorTexture": { "index": 0 }
        }
    });
    let Value::Object(mode) = mode else {
        panic!("an object");
    };
    material.as_object_mut().expect("an object").extend(mode);
    material
}

#[test]
fn alpha_modes_of_gltf() {
    let texels = [0, 128, 255];
    let opaque = gltf(textured(json!({ "alphaMode": "OPAQUE" })), &texels);
    assert_eq!(opaque.materials[0].opacity, Opacity::default());
    let blend = gltf(textured(json!({ "alphaMode": "BLEND" })), &texels);
    let opacity = blend.materials[0].opacity;
    assert_eq!((opacity.factor, opacity.cutoff), (0.5, None));
    let texture = opacity.texture.expect("the base colour's texture").texture;
    let at = |x: u32| opacity.at(blend.textures[texture.index()].texel(x, 0).w);
    assert_eq!((at(0), at(2)), (0.0, 0.5));
    assert!((at(1) - 64.0 / 255.0).abs() < 1e-3);
    assert!(blend.warnings.iter().all(|w| !w.contains("alpha")));
    let mask = gltf(textured(json!({ "alphaMode": "MASK" })), &texels);
    let opacity = mask.materials[0].opacity;
    let cutoff = opacity.cutoff.expect("a mask");
    assert!((cutoff - 0.5).abs() < 1e-6, "when left out: {cutoff}");
    assert_eq!(
        (opacity.at(0.999), opacity.at(1.0)),
        (0.0, 1.0),
        "≥ is opaque"
    );
}

/// Masks that stop every ray or none, and textures of one alpha, are folded away.
#[test]
fn what_makes_no_difference_is_folded() {
    let folded = |mode: Value, texels: &[u8]| gltf(textured(mode), texels).materials[0].opacity;
    let mask = |cutoff: f64| json!({ "alphaMode": "MASK", "alphaCutoff": cutoff });
    assert_eq!(folded(mask(0.2), &[128, 255]), Opacity::constant(1.0));
    assert_eq!(folded(mask(0.0), &[0, 255]), Opacity::constant(1.0));
    assert_eq!(folded(mask(0.6), &[128, 255]), Opacity::constant(0.0));
    assert_eq!(folded(mask(2.0), &[128, 255]), Opacity::constant(0.0));
    let blend = json!({ "alphaMode": "BLEND" });
    assert_eq!(folded(blend, &[255, 255]), Opacity::constant(0.5));
    // White everywhere, the colour's texture is folded, its alpha not.
    let scene = gltf(textured(mask(0.4)), &[0, 255]);
    assert!(!scene.materials[0].textures.any());
    assert!(scene.materials[0].opacity.texture.is_some());
}

/// Opaque where α ≥ cutoff (glTF 2.0, section 3.9.4), however a texture holds α and however the
/// file writes the cutoff.
#[test]
fn alphas_that_equal_the_cutoff_are_opaque() {
    let at = |scene: &Scene, x: u32| {
        let opacity = scene.materials[0].opacity;
        let texture = opacity.texture.expect("a texture").texture;
        opacity.at(scene.textures[texture.index()].texel(x, 0).w)
    };
    for (level, cutoff) in [
        (51, 0.2),
        (102, 0.4),
        (128, 0.501_960_784_3),
        (128, 128.0 / 255.0),
        (77, f64::from(77.0f32 / 255.0)),
        (1, 1.0 / 255.0),
        (254, 254.0 / 255.0),
    ] {
        let mode = json!({ "alphaMode": "MASK", "alphaCutoff": cutoff });
        let mut material = textured(mode);
        material["pbrMetallicRoughness"]["baseColorFactor"][3] = json!(1);
        let scene = gltf(material.clone(), &[level, level - 1]);
        assert_eq!((at(&scene, 0), at(&scene, 1)), (1.0, 0.0), "{cutoff}");
        // Where all texels equal it nothing is left of the mask.
        let scene = gltf(material, &[level; 2]);
        assert_eq!(scene.materials[0].opacity, Opacity::constant(1.0));
    }
    // 0.9 · 102/255 is 0.36.
    let mut material = textured(json!({ "alphaMode": "MASK", "alphaCutoff": 0.36 }));
    material["pbrMetallicRoughness"]["baseColorFactor"][3] = json!(0.9);
    let scene = gltf(material, &[102, 101]);
    assert_eq!((at(&scene, 0), at(&scene, 1)), (1.0, 0.0));
    // 16-bit levels that an f16 does not hold apart.
    let folder = Folder::new();
    let words = [0x7ffe, 0x7fff, 0x8000, 0xffff];
    let row = ImageBuffer::from_fn(4, 1, |x, _| Luma([words[x as usize]]));
    folder.write("fine.png", encoded(&DynamicImage::ImageLuma16(row)));
    let material = "alpha_cutoff = 0.5\ntextures.opacity = { file = \"fine.png\" }\n";
    folder.write("scene.toml", format!("{HEAD}{material}"));
    let scene = folder.load("scene.toml").expect("valid");
    assert_eq!([0, 1, 2, 3].map(|x| at(&scene, x)), [0.0, 0.0, 1.0, 1.0]);
}

#[test]
fn bad_alphas_of_gltf() {
    for (key, value, expected) in [
        (
            "alphaCutoff",
            json!(-0.5),
            "materials[0].alphaCutoff: is -0.5; expected a finite number, not negative",
        ),
        (
            "pbrMetallicRoughness",
            json!({ "baseColorFactor": [1, 1, 1, 1.5] }),
            "materials[0].pbrMetallicRoughness.baseColorFactor: is 1.5; expected a number from 0 to 1",
        ),
    ] {
        let mut material = json!({ "alphaMode": "MASK" });
        material[key] = value;
        let json = with(triangle_gltf(), "/materials", json!([material]));
        let message = load_gltf(&json).expect_err("it must be refused");
        assert!(message.contains(expected), "{message}");
    }
}

const HEAD: &str = "[camera]\neye = [0, 0, 5]\ntarget = [0, 0, 0]\nup = [0, 1, 0]\nfov = 30\n[environment]\nradiance = 1\n\
    [[shapes]]\ntype = \"rectangle\"\nmaterial = \"leaf\"\ncorner = [0, 0, 0]\nu = [1, 0, 0]\nv = [0, 1, 0]\n\
    [materials.leaf]\ntype = \"lambert\"\nreflectance = 1\n";

fn toml(material: &str) -> Result<Scene, String> {
    let folder = Folder::new();
    folder.write("leaf.png", alphas(&[0, 255]));
    folder.write("grey.png", greys(&[51, 255]));
    folder.write("rgb.png", png(&[[1, 2, 3], [3, 2, 1]]));
    folder.write("scene.toml", format!("{HEAD}{material}\n"));
    folder.load("scene.toml")
}

#[test]
fn opacities_of_toml() {
    let scene = toml("opacity = 0.5\ntextures.opacity = { file = \"grey.png\" }").expect("valid");
    let opacity = scene.materials[0].opacity;
    let texture = &scene.textures[opacity.texture.expect("a texture").texture.index()];
    assert!((opacity.at(texture.texel(0, 0).w) - 0.1).abs() < 1e-4);
    // An image that is colour and opacity is held once.
    let both =
        "textures.color = { file = \"rgb.png\" }\ntextures.opacity = { file = \"leaf.png\" }";
    assert_eq!(toml(both).expect("valid").textures.len(), 2);
    let once = both.replace("rgb", "leaf");
    assert_eq!(toml(&once).expect("valid").textures.len(), 1);
}

#[test]
fn effects_say_why() {
    let material = "opacity = 0.9\nalpha_cutoff = 0.5\ntextures.opacity = { file = \"leaf.png\" }";
    let scene = toml(material).expect("valid");
    let prepared = Prepared::of(scene);
    let reason = |effect: Effect| {
        let mut effects = prepared.effects.iter();
        effects
            .find(|(e, _)| *e == effect)
            .map(|(_, reason)| reason.to_owned())
    };
    let alpha = reason(Effect::Alpha).expect("an opacity");
    assert!(
        alpha.starts_with("materials.leaf: opacity 0.9 × "),
        "{alpha}"
    );
    assert!(alpha.ends_with("leaf.png, cutoff 0.5"), "{alpha}");
    let texture = reason(Effect::AlphaTexture).expect("a texture");
    assert!(texture.ends_with("leaf.png (2 × 1)"), "{texture}");
}

#[test]
fn bad_opacities_of_toml() {
    let sphere = "opacity = 0.5\n[[shapes]]\ntype = \"sphere\"\nmaterial = \"leaf\"\ncenter = [0, 0, 0]\nradius = 1\n\
        emission = { radiance = 1, two_sided = true }";
    for (material, expected) in [
        (
            "opacity = 1.5",
            "materials.leaf.opacity: is 1.5; expected a number from 0 to 1",
        ),
        (
            "opacity = -0.1",
            "materials.leaf.opacity: is -0.1; expected a number from 0 to 1",
        ),
        (
            "alpha_cutoff = -0.5",
            "materials.leaf.alpha_cutoff: is -0.5; expected a finite number, not negative: the least opacity that is opaque",
        ),
        (
            "textures.opacity = { file = \"rgb.png\" }",
            "DIR/rgb.png: has 3 channels and no alpha; expected an alpha channel, or one channel alone",
        ),
        (
            sphere,
            "shapes[1].emission.two_sided: is true on a sphere of opacity 0.5; expected false: a sphere that rays pass emits \
             outwards only",
        ),
    ] {
        let message = toml(material).expect_err("it must be refused");
        assert!(message.contains(expected), "{message}");
    }
}
