//! Materials of glTF beyond metallic and roughness: unlit, specular and glossiness, glass under
//! textures; textures whose image is another or none.

use super::files::{Folder, load_gltf, triangle_gltf, with};
use super::textures::png;
use crate::support::twin::{Part, accept_means, recorded_film, same_means, twin_film};
use crate::support::{context, prepared};
use base64::Engine;
use direkt::low_level::effects::Effect;
use direkt::low_level::prepare::Prepared;
use direkt::low_level::reference::core::ray::{Hit, Ray};
use direkt::low_level::reference::scene::fetch::World;
use direkt::low_level::reference::scene::surface::surface_at;
use direkt::scene::{Bsdf, FilmSize, Material, Scene};
use glam::{DVec2, DVec3};
use image::{DynamicImage, ImageBuffer, ImageFormat, Rgb, Rgba};
use serde_json::{Value, json};
use std::io::Cursor;

fn uri(bytes: &[u8]) -> Value {
    let data = base64::engine::general_purpose::STANDARD.encode(bytes);
    json!({ "uri": format!("data:application/octet-stream;base64,{data}") })
}

/// The triangle with texture coordinates and with `material`, whose textures are `images` in their
/// order.
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
    let prepared = Prepared::of(scene);
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
        let json = gltf(material.clone(), std::slice::from_ref(&two));
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
        gltf(material.clone(), std::slice::from_ref(&two)),
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

/// `json`, whose triangle gets the normal (0, 0, 1) and at each vertex `tangent`.
fn with_tangents(mut json: Value, tangent: [f32; 4]) -> Value {
    let mut add = |bytes: Vec<u8>, kind: &str| {
        let mut buffer = uri(&bytes);
        buffer["byteLength"] = json!(bytes.len());
        let mut push = |list: &str, value: Value| {
            let list = json[list].as_array_mut().expect("a list");
            list.push(value);
            list.len() - 1
        };
        let buffer = push("buffers", buffer);
        let view = push(
            "bufferViews",
            json!({ "buffer": buffer, "byteLength": bytes.len() }),
        );
        push(
            "accessors",
            json!({ "bufferView": view, "componentType": 5126, "count": 3, "type": kind }),
        )
    };
    let bytes = |numbers: &[f32]| -> Vec<u8> {
        let all = (0..3).flat_map(|_| numbers.iter().copied());
        all.flat_map(f32::to_le_bytes).collect()
    };
    let normal = add(bytes(&[0.0, 0.0, 1.0]), "VEC3");
    let tangent = add(bytes(&tangent), "VEC4");
    let attributes = &mut json["meshes"][0]["primitives"][0]["attributes"];
    attributes["NORMAL"] = json!(normal);
    attributes["TANGENT"] = json!(tangent);
    json
}

/// Texels of a normal map: (0.481, 0.356, 0.801) of unit length.
const SLANTED: [u8; 3] = [189, 173, 230];

fn mapped(tangent: [f32; 4], node: Value) -> Value {
    let material = json!({ "normalTexture": { "index": 0 }, "doubleSided": true });
    let json = with_tangents(gltf(material, &[png(&[SLANTED; 2])]), tangent);
    with(json, "/nodes", json!([node]))
}

/// The shading normal that `scene`'s triangle has in its middle, seen from above.
fn shading_normal(scene: Scene) -> DVec3 {
    let prepared = prepared(scene);
    let world = World::new(&prepared);
    let ray = Ray {
        origin: DVec3::Z,
        direction: -DVec3::Z,
    };
    let hit = Hit {
        t: 1.0,
        primitive: 0,
        st: DVec2::splat(1.0 / 3.0),
    };
    surface_at(&world, &ray, &hit, DVec3::Z).frame.z
}

/// x of a normal map is along TANGENT, y along its sense times n × t (glTF 2.0, section 3.7.2.1).
#[test]
fn normal_maps_follow_the_given_tangents() {
    // v of the triangle's coordinates falls along −y, as y of the map does along growing v.
    let normal = |tangent: [f32; 4], node: Value| {
        let scene = load_gltf(&mapped(tangent, node)).expect("a valid glTF");
        let found = effects(scene.clone()).contains(&Effect::Tangents);
        (shading_normal(scene), found)
    };
    let plain = || json!({ "mesh": 0 });
    let (x, y, z) = (0.4809, 0.3558, 0.8013);
    // What the coordinates give changes nothing.
    let (found, called) = normal([1.0, 0.0, 0.0, -1.0], plain());
    assert!(close(found, DVec3::new(x, -y, z)) && !called, "{found}");
    for (tangent, node, expected) in [
        ([0.0, 1.0, 0.0, 1.0], plain(), DVec3::new(-y, x, z)),
        ([0.0, 1.0, 0.0, -1.0], plain(), DVec3::new(y, x, z)),
        ([1.0, 0.0, 0.0, 1.0], plain(), DVec3::new(x, y, z)),
        // Their length does not count, nor what is along the normal.
        ([0.0, 3.0, 1.0, 1.0], plain(), DVec3::new(-y, x, z)),
        // Turned by 90 degrees, and mirrored in x, with the surface.
        (
            [0.0, 1.0, 0.0, 1.0],
            json!({ "mesh": 0, "rotation": [0, 0, 0.5f64.sqrt(), 0.5f64.sqrt()] }),
            DVec3::new(-x, -y, z),
        ),
        (
            [0.0, 1.0, 0.0, 1.0],
            json!({ "mesh": 0, "scale": [-1, 1, 1] }),
            DVec3::new(y, x, z),
        ),
    ] {
        let (found, called) = normal(tangent, node.clone());
        assert!(
            called && close(found, expected),
            "{tangent:?}, {node}: {found} for {expected}"
        );
    }
}

/// Glass with metal in parts, glossiness from a texture, tangents and an unlit surface, before a
/// bright wall: the GPU's means are the twin's.
#[test]
fn models_are_the_twins() {
    let folder = Folder::new();
    let glass = glass(json!({}), json!({ "transmissionFactor": 1 }));
    let glossy = glossy(json!({
        "specularFactor": [0.9, 0.8, 0.7],
        "specularGlossinessTexture": { "index": 0 }
    }));
    let unlit = json!({
        "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } },
        "extensions": { "KHR_materials_unlit": {} }
    });
    let texels = rgba(&[[188, 160, 255, 51], [90, 120, 0, 230]]);
    for (name, json) in [
        ("glass.gltf", gltf(glass, std::slice::from_ref(&texels))),
        ("glossy.gltf", gltf(glossy, std::slice::from_ref(&texels))),
        ("unlit.gltf", gltf(unlit, &[texels])),
        (
            "mapped.gltf",
            mapped([0.6, 0.8, 0.0, 1.0], json!({ "mesh": 0 })),
        ),
    ] {
        folder.write(name, json.to_string());
    }
    let mut text = "[camera]\ntype = \"orthographic\"\neye = [0, 0, 5]\ntarget = [0, 0, 0]\nup = [0, 1, 0]\nheight = 2\n\
         [environment]\nradiance = 0.5\n[[lights]]\ntype = \"directional\"\ndirection = [0.3, 0.2, -1]\n\
         irradiance = [2, 3, 4]\n[materials.wall]\ntype = \"lambert\"\nreflectance = 0.5\n\
         [[shapes]]\ntype = \"rectangle\"\nmaterial = \"wall\"\ncorner = [-3, -3, -1]\nu = [6, 0, 0]\nv = [0, 6, 0]\n"
        .to_owned();
    for (name, place) in [
        ("glass", "[-1, 0, 0]"),
        ("glossy", "[0, 0, 0]"),
        ("unlit", "[-1, -1, 0]"),
        ("mapped", "[0, -1, 0]"),
    ] {
        text +=
            &format!("[[gltf]]\nfile = \"{name}.gltf\"\ntransform = [{{ translate = {place} }}]\n");
    }
    folder.write("scene.toml", text);
    let scene = folder.load("scene.toml").expect("a valid scene");
    let prepared = prepared(scene);
    let size = FilmSize {
        width: 24,
        height: 24,
    };
    for effect in [
        Effect::MetalMask,
        Effect::GlossinessTexture,
        Effect::Unlit,
        Effect::Tangents,
    ] {
        assert!(prepared.effects.contains(effect), "{effect:?}");
    }
    let twin = twin_film(&prepared, (size, 17, 256), Part::All, None);
    let gpu = recorded_film(context(), &prepared, (size, 18, 256), Part::All);
    accept_means(same_means(&gpu, &twin), "models of glTF");
}
