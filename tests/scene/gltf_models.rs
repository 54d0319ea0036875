//! Materials of glTF beyond metallic and roughness: unlit, specular and glossiness, glass under textures; textures whose
//! image is another or none.

use super::files::{load_gltf, triangle_gltf, with};
use super::textures::png;
use base64::Engine;
use direkt::effects::Effect;
use direkt::render::Prepared;
use direkt::scene::{Bsdf, Material, Scene};
use glam::DVec3;
use image::{DynamicImage, ImageBuffer, ImageFormat, Rgb, Rgba};
use serde_json::{Value, json};
use std::io::Cursor;

fn uri(bytes: &[u8]) -> Value {
    let data = base64::engine::general_purpose::STANDARD.encode(bytes);
    json!({ "uri": format!("data:application/octet-stream;base64,{data}") })
}

/// The triangle with texture coordinates and with `material`, whose textures are `images` in their order.
fn gltf(material: Value, images: &[Vec<u8>]) -> Value {
    let mut json = with(triangle_gltf(), "/materials", json!([material]));
    let corners = [0.0f32, 0.0, 1.0, 0.0, 0.0, 1.0];
    let bytes: Vec<u8> = corners.into_iter().flat_map(f32::to_le_bytes).collect();
    let mut buffer = uri(&bytes);
    buffer["byteLength"] = json!(24);
    let mut add = |list: &str, value: Value| {
        json[list].as_array_mut().expect("a list").push(value);
    };
    add("buffers", buffer);
    add("bufferViews", json!({ "buffer": 1, "byteLength": 24 }));
    add(
        "accessors",
        json!({ "bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC2" }),
    );
    json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(2);
    json["images"] = images.iter().map(|bytes| uri(bytes)).collect();
    json["textures"] = (0..images.len()).map(|i| json!({ "source": i })).collect();
    json
}

fn load(material: Value, images: &[Vec<u8>]) -> Scene {
    load_gltf(&gltf(material, images)).expect("a valid glTF")
}

fn rgba(texels: &[[u8; 4]]) -> Vec<u8> {
    let row = ImageBuffer::from_fn(texels.len() as u32, 1, |x, _| Rgba(texels[x as usize]));
    let mut bytes = Vec::new();
    let written =
        DynamicImage::ImageRgba8(row).write_to(&mut Cursor::new(&mut bytes), ImageFormat::Png);
    written.expect("a PNG can be written");
    bytes
}

fn said(scene: &Scene, what: &str) -> usize {
    scene.warnings.iter().filter(|w| w.contains(what)).count()
}

fn effects(scene: Scene) -> Vec<Effect> {
    let settings = scene.render;
    let prepared = Prepared::new(scene, settings.strategy, settings.light_selection);
    prepared.effects.iter().map(|(effect, _)| effect).collect()
}

fn close(a: DVec3, b: DVec3) -> bool {
    (a - b).abs().max_element() < 1e-3
}

#[test]
fn textures_without_an_image_are_left_out() {
    let material = json!({
        "emissiveFactor": [1, 1, 1],
        "emissiveTexture": { "index": 0 },
        "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } }
    });
    let two = png(&[[255, 0, 0], [0, 255, 0]]);
    let with_texture = |texture: Value| {
        let json = gltf(material.clone(), &[two.clone()]);
        load_gltf(&with(json, "/textures", json!([texture]))).expect("a valid glTF")
    };
    for (texture, reason) in [
        (
            json!({}),
            "textures[0] is left out, factors are used: it has no image",
        ),
        (
            json!({ "extensions": { "KHR_texture_basisu": { "source": 0 } } }),
            "the extension KHR_texture_basisu, which is not supported",
        ),
        (
            json!({ "extensions": { "MSFT_texture_dds": { "source": 0 } } }),
            "the extension MSFT_texture_dds, which is not supported",
        ),
    ] {
        let scene = with_texture(texture);
        assert_eq!(said(&scene, reason), 1, "{:?}", scene.warnings);
        let emission = scene.shapes[0].emission.expect("it emits its factor");
        assert_eq!((emission.radiance, emission.texture), (DVec3::ONE, None));
        assert!(!scene.materials[0].textures.any());
    }
    // A fallback is read.
    let fallback = json!({ "source": 0, "extensions": { "KHR_texture_basisu": { "source": 7 } } });
    assert!(with_texture(fallback).materials[0].textures.color.is_some());
    let message = load_gltf(&with(
        gltf(material.clone(), &[two.clone()]),
        "/textures",
        json!([{ "source": 3 }]),
    ));
    let message = message.expect_err("no image 3");
    assert!(message.contains("textures[0].source: image 3"), "{message}");
}

#[test]
fn webp_is_read_by_its_extension() {
    let row = ImageBuffer::from_fn(2, 1, |x, _| Rgb([200 * x as u8, 0, 0]));
    let mut webp = Vec::new();
    let image = DynamicImage::ImageRgb8(row);
    image
        .write_to(&mut Cursor::new(&mut webp), ImageFormat::WebP)
        .expect("a WebP can be written");
    let material = json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } });
    let json = gltf(material, &[webp]);
    let texture = json!([{ "extensions": { "EXT_texture_webp": { "source": 0 } } }]);
    let json = with(json, "/textures", texture);
    let json = with(json, "/extensionsRequired", json!(["EXT_texture_webp"]));
    let scene = load_gltf(&json).expect("a valid glTF");
    assert_eq!(scene.textures[0].texel(0, 0).x, 0.0);
    assert!(scene.textures[0].texel(1, 0).x > 0.5);
}

#[test]
fn unlit_materials_show_their_base_colour() {
    let material = |unlit: bool| {
        let mut material = json!({
            "pbrMetallicRoughness": {
                "baseColorFactor": [0.5, 1, 1, 1],
                "baseColorTexture": { "index": 0 },
                "metallicRoughnessTexture": { "index": 1 }
            },
            "normalTexture": { "index": 1 },
            "emissiveFactor": [1, 1, 1]
        });
        if unlit {
            material["extensions"] = json!({ "KHR_materials_unlit": {} });
        }
        material
    };
    let images = [png(&[[188; 3]; 2]), png(&[[9, 99, 200], [1, 2, 3]])];
    let scene = load(material(true), &images);
    let Bsdf::Unlit { color } = scene.materials[0].bsdf else {
        panic!("{:?} is not unlit", scene.materials[0].bsdf);
    };
    assert!(close(color, DVec3::new(0.2514, 0.5029, 0.5029)), "{color}");
    assert!(!scene.materials[0].textures.any());
    assert_eq!(scene.shapes[0].emission, None);
    assert_eq!(said(&scene, "no light"), 0, "{:?}", scene.warnings);
    let found = effects(scene);
    assert!(found.contains(&Effect::Unlit) && !found.contains(&Effect::AreaLights));
    assert!(!effects(load(material(false), &images)).contains(&Effect::Unlit));
}

fn glossy(further: Value) -> Value {
    let mut model = json!({ "diffuseFactor": [0.1, 0.4, 0.05, 1] });
    let Value::Object(further) = further else {
        panic!("an object");
    };
    model.as_object_mut().expect("an object").extend(further);
    json!({ "extensions": { "KHR_materials_pbrSpecularGlossiness": model } })
}

#[test]
fn specular_and_glossiness_become_a_base_under_a_lobe() {
    let material = glossy(json!({ "specularFactor": [0, 0, 0], "glossinessFactor": 0 }));
    let parameters = load(material, &[]).materials[0].bsdf.parameters();
    assert!(close(parameters.diffuse, DVec3::new(0.1, 0.4, 0.05)));
    let lobe = parameters.specular.expect("a lobe");
    assert_eq!(lobe.alpha, 1.0);
    assert_eq!(lobe.fresnel, schlick(DVec3::ZERO));
    // The base keeps 1 − max(F₀); α = (1 − glossiness)².
    let material =
        glossy(json!({ "specularFactor": [0.5, 0.25, 0.125], "glossinessFactor": 0.25 }));
    let parameters = load(material, &[]).materials[0].bsdf.parameters();
    assert!(close(parameters.diffuse, DVec3::new(0.05, 0.2, 0.025)));
    let lobe = parameters.specular.expect("a lobe");
    assert!((lobe.alpha - 0.5625).abs() < 1e-9);
    assert_eq!(lobe.fresnel, schlick(DVec3::new(0.5, 0.25, 0.125)));
    // A smooth one is a mirror over the base.
    let material = glossy(json!({}));
    assert!(
        load(material, &[]).materials[0]
            .bsdf
            .parameters()
            .is_specular()
    );
    let message = load_gltf(&gltf(glossy(json!({ "glossinessFactor": 1.5 })), &[]));
    let message = message.expect_err("1.5");
    assert!(message.contains("glossinessFactor: is 1.5"), "{message}");
}

fn schlick(f0: DVec3) -> direkt::scene::material::Fresnel {
    direkt::scene::material::Fresnel::Schlick { f0, f90: 1.0 }
}

#[test]
fn specular_and_glossiness_have_textures() {
    let texture = json!({ "index": 0 });
    let material =
        glossy(json!({ "specularGlossinessTexture": texture, "diffuseTexture": texture }));
    let constant = load(material.clone(), &[rgba(&[[188, 188, 188, 51]; 2])]);
    let Bsdf::SpecularGlossiness {
        diffuse,
        specular,
        glossiness,
        textured,
    } = constant.materials[0].bsdf
    else {
        panic!("the model of the extension");
    };
    assert!(
        close(specular, DVec3::splat(0.5029))
            && close(diffuse, 0.5029 * DVec3::new(0.1, 0.4, 0.05))
    );
    assert!((glossiness - 0.2).abs() < 1e-3 && !textured);
    assert!(!constant.materials[0].textures.any());
    // Grey of one colour whose glossiness varies; nowhere a mirror, though the factor is 1.
    let varied = load(
        material,
        &[rgba(&[[188, 188, 188, 51], [188, 188, 188, 255]])],
    );
    assert!(varied.materials[0].textures.specular_glossiness.is_some());
    assert!(!varied.materials[0].bsdf.parameters().is_specular());
    let found = effects(varied);
    assert!(found.contains(&Effect::GlossinessTexture) && found.contains(&Effect::Glossy));
    assert!(!found.contains(&Effect::RoughnessTexture) && !found.contains(&Effect::Specular));
}

fn glass(factors: Value, extension: Value) -> Value {
    let mut pbr = json!({ "metallicRoughnessTexture": { "index": 0 } });
    let Value::Object(factors) = factors else {
        panic!("an object");
    };
    pbr.as_object_mut().expect("an object").extend(factors);
    json!({ "pbrMetallicRoughness": pbr, "extensions": { "KHR_materials_transmission": extension } })
}

fn metallic(material: &Material) -> f64 {
    match material.bsdf {
        Bsdf::MetallicRoughness { metallic, .. } => metallic,
        other => panic!("{other:?} has no metallic"),
    }
}

/// metallicFactor 1 and a texture whose blue is 0: glass, however its green varies.
#[test]
fn textures_make_glass_of_metal() {
    let all = json!({ "transmissionFactor": 1 });
    let material = glass(json!({ "metallicFactor": 1 }), all.clone());
    let scene = load(material.clone(), &[png(&[[0, 255, 0], [9, 20, 0]])]);
    let glass = &scene.materials[0];
    assert_eq!(metallic(glass), 0.0);
    assert!(glass.bsdf.parameters().transmission.is_some() && !glass.textures.any());
    assert_eq!(
        said(&scene, "roughness is ignored"),
        1,
        "{:?}",
        scene.warnings
    );
    // Blue 255 is metal, whose roughness varies.
    let scene = load(material.clone(), &[png(&[[0, 255, 255], [9, 20, 255]])]);
    assert_eq!(metallic(&scene.materials[0]), 1.0);
    assert!(scene.materials[0].textures.metallic_roughness.is_some());
    assert!(scene.materials[0].bsdf.parameters().transmission.is_none());
    // Of both there are parts, which is said.
    let scene = load(material.clone(), &[png(&[[0, 255, 0], [9, 128, 255]])]);
    assert!(scene.materials[0].bsdf.is_masked());
    assert_eq!(
        said(&scene, "metallic varies over glass"),
        1,
        "{:?}",
        scene.warnings
    );
    let found = effects(scene);
    for effect in [
        Effect::MetalMask,
        Effect::Glossy,
        Effect::Specular,
        Effect::Refraction,
        Effect::RoughnessTexture,
    ] {
        assert!(found.contains(&effect), "{effect:?} in {found:?}");
    }
    // Less metal than glass everywhere, or the same of both.
    let scene = load(material.clone(), &[png(&[[0, 255, 0], [9, 128, 100]])]);
    assert_eq!(metallic(&scene.materials[0]), 0.0);
    assert_eq!(said(&scene, "the metal's part is left out"), 1);
    let scene = load(material, &[png(&[[0, 255, 51]; 2])]);
    assert!((metallic(&scene.materials[0]) - 0.2).abs() < 1e-9);
    assert_eq!(said(&scene, "the metal's part is left out"), 1);
}

/// A texture of one value is a factor; others are named.
#[test]
fn textures_of_the_dielectric_are_factors_or_named() {
    let extension = json!({ "transmissionFactor": 1, "transmissionTexture": { "index": 1 } });
    let mut material = glass(json!({ "metallicFactor": 0 }), extension);
    material["extensions"]["KHR_materials_specular"] = json!({
        "specularTexture": { "index": 2 },
        "specularColorTexture": { "index": 2 }
    });
    let rough = png(&[[0, 255, 0]; 2]);
    let layer = |scene: &Scene| match scene.materials[0].bsdf {
        Bsdf::MetallicRoughness { layer, .. } => layer,
        other => panic!("{other:?} has no layer"),
    };
    let images = [
        rough.clone(),
        png(&[[51, 9, 9]; 2]),
        rgba(&[[188, 188, 188, 102]; 2]),
    ];
    let scene = load(material.clone(), &images);
    assert!((layer(&scene).transmission - 0.2).abs() < 1e-9);
    assert!((layer(&scene).specular - 0.4).abs() < 1e-9);
    assert!(close(layer(&scene).specular_color, DVec3::splat(0.5029)));
    assert_eq!(
        said(&scene, "varies and is ignored"),
        0,
        "{:?}",
        scene.warnings
    );
    let images = [
        rough,
        png(&[[51, 9, 9], [0, 9, 9]]),
        rgba(&[[188, 188, 188, 102], [0, 0, 0, 9]]),
    ];
    let scene = load(material, &images);
    assert_eq!(layer(&scene).transmission, 1.0);
    for name in [
        "transmissionTexture",
        "specularTexture",
        "specularColorTexture",
    ] {
        assert_eq!(
            said(&scene, &format!("{name} varies and is ignored")),
            1,
            "{name}"
        );
    }
}
