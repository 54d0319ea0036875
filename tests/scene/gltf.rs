//! glTF and GLB files: what they bring, and what they leave out with a warning.

use super::files::{Folder, glb, load_gltf, triangle_glb, triangle_gltf, with};
use super::textures::{png, with_texture};
use crate::support::shared;
use direkt::scene::load::{LoadOptions, load};
use direkt::scene::material::DielectricLayer;
use direkt::scene::{
    Bsdf, DirectionalLight, Geometry, Light, Mesh, PointLight, Projection, Scene, SpotLight,
};
use glam::DVec3;
use serde_json::json;

fn mesh(scene: &Scene, shape: usize) -> &Mesh {
    match &scene.shapes[shape].geometry {
        Geometry::Mesh(mesh) => mesh,
        other => panic!("{other:?} is no mesh"),
    }
}

fn corners(mesh: &Mesh, triangle: usize) -> [DVec3; 3] {
    mesh.triangles[triangle].map(|i| mesh.positions[i as usize])
}

#[test]
fn a_triangle_comes_through_every_container() {
    let embedded = load_gltf(&triangle_gltf()).expect("a valid glTF");
    let folder = Folder::new();
    folder.write("scene.glb", triangle_glb());
    let binary = folder.load("scene.glb").expect("a valid GLB");
    let bin = &triangle_glb()[triangle_glb().len() - 44..];
    folder.write("a b.bin", bin);
    let external = with(
        triangle_gltf(),
        "/buffers",
        json!([{ "byteLength": 42, "uri": "a%20b.bin" }]),
    );
    folder.write("scene.gltf", external.to_string());
    let external = folder.load("scene.gltf").expect("a valid glTF");
    for scene in [&embedded, &binary, &external] {
        assert_eq!(scene.shapes.len(), 1);
        assert_eq!(scene.shapes[0].name, "triangle (mesh 0)");
        assert_eq!(
            corners(mesh(scene, 0), 0),
            [DVec3::ZERO, DVec3::X, DVec3::Y]
        );
        assert_eq!(
            scene.warnings,
            ["the scene has no light: the image will be black"]
        );
    }
    assert_eq!(embedded.camera, binary.camera);
    assert_eq!(embedded.camera.forward, DVec3::NEG_Z);
}

#[test]
fn nodes_compose_and_mirrors_keep_the_front() {
    let json = with(
        triangle_gltf(),
        "/nodes",
        json!([
            { "translation": [10, 0, 0], "children": [1, 2] },
            { "mesh": 0, "scale": [-2, 1, 1] },
            { "mesh": 0, "matrix": [0,1,0,0, -1,0,0,0, 0,0,1,0, 0,0,5,1] }
        ]),
    );
    let scene = load_gltf(&json).expect("a valid glTF");
    let [a, b, c] = corners(mesh(&scene, 0), 0);
    assert_eq!(a, DVec3::new(10.0, 0.0, 0.0));
    // The mirror turns (1, 0, 0) to (-2, 0, 0); swapped winding keeps the normal at +z.
    assert_eq!((b - a).cross(c - a), DVec3::new(0.0, 0.0, 2.0));
    let [a, b, c] = corners(mesh(&scene, 1), 0);
    assert_eq!(a, DVec3::new(10.0, 0.0, 5.0));
    assert_eq!(b, DVec3::new(10.0, 1.0, 5.0));
    assert_eq!(c, DVec3::new(9.0, 0.0, 5.0));
}

#[test]
fn materials_emission_and_sides() {
    let json = with(
        triangle_gltf(),
        "/materials/0",
        json!({
            "name": "lamp",
            "doubleSided": true,
            "emissiveFactor": [1, 0.5, 0],
            "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 8 } },
            "pbrMetallicRoughness": {
                "baseColorFactor": [0.5, 0.25, 1, 1], "metallicFactor": 0, "roughnessFactor": 0.75
            }
        }),
    );
    let scene = load_gltf(&json).expect("a valid glTF");
    let material = &scene.materials[0];
    assert_eq!(
        material.bsdf,
        Bsdf::MetallicRoughness {
            base_color: DVec3::new(0.5, 0.25, 1.0),
            metallic: 0.0,
            roughness: 0.75,
            layer: DielectricLayer::default(),
        }
    );
    assert!(material.double_sided);
    let emission = scene.shapes[0].emission.expect("it emits");
    assert_eq!(emission.radiance, DVec3::new(8.0, 4.0, 0.0));
    assert!(emission.two_sided);

    let mut plain = triangle_gltf();
    plain["meshes"][0]["primitives"][0]
        .as_object_mut()
        .expect("a primitive")
        .remove("material");
    let scene = load_gltf(&plain).expect("a valid glTF");
    assert!(!scene.materials[0].double_sided);
    assert_eq!(
        scene.materials[0].bsdf,
        Bsdf::MetallicRoughness {
            base_color: DVec3::ONE,
            metallic: 1.0,
            roughness: 1.0,
            layer: DielectricLayer::default(),
        }
    );
}

/// `ymag` is half the height of what is seen; the node's scale is none of the camera's, that of the
/// including file is.
#[test]
fn orthographic_cameras() {
    let nodes = json!([{ "mesh": 0, "camera": 0, "scale": [3, 3, 3] }]);
    let json = with(triangle_gltf(), "/nodes", nodes);
    let camera = |ymag: f64| {
        let magnification = json!({ "xmag": 1, "ymag": ymag, "zfar": 9, "znear": 0.1 });
        let cameras = json!([{ "type": "orthographic", "orthographic": magnification }]);
        with(json.clone(), "/cameras", cameras)
    };
    let scene = load_gltf(&camera(1.5)).expect("a valid glTF");
    assert_eq!(
        scene.camera.projection,
        Projection::Orthographic { height: 3.0 }
    );
    assert_eq!(
        load_gltf(&camera(-1.5)).expect_err("it must be refused"),
        "DIR/scene.gltf: cameras[0].orthographic.ymag: is -1.5; expected half the height of what is seen, above 0"
    );
    let folder = Folder::new();
    folder.write("part.gltf", camera(1.5).to_string());
    let text = "[[gltf]]\nfile = \"part.gltf\"\ntransform = [{ scale = 2 }]\n";
    folder.write("scene.toml", text);
    let scene = folder.load("scene.toml").expect("a valid scene");
    assert_eq!(
        scene.camera.projection,
        Projection::Orthographic { height: 6.0 }
    );
}

#[test]
fn cameras_and_lights_look_along_minus_z() {
    let json = with(
        triangle_gltf(),
        "/nodes",
        json!([
            { "mesh": 0, "children": [1, 2, 3, 4] },
            { "camera": 0, "translation": [0, 0, 9], "rotation": [0, 0.5, 0, 0.5] },
            { "extensions": { "KHR_lights_punctual": { "light": 0 } }, "translation": [1, 2, 3], "scale": [5, 5, 5] },
            { "extensions": { "KHR_lights_punctual": { "light": 1 } }, "rotation": [-0.5, 0, 0, 0.5] },
            { "extensions": { "KHR_lights_punctual": { "light": 2 } } }
        ]),
    );
    let json = with(
        json,
        "/cameras",
        json!([{ "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1 } }]),
    );
    let json = with(
        json,
        "/extensions",
        json!({ "KHR_lights_punctual": { "lights": [
            { "type": "point", "color": [1, 0.5, 0.25], "intensity": 40, "range": 7 },
            { "type": "directional", "intensity": 1000 },
            { "type": "spot", "intensity": 3, "spot": { "outerConeAngle": 1.5707964 } }
        ] } }),
    );
    let json = with(json, "/extensionsUsed", json!(["KHR_lights_punctual"]));
    let json = with(json, "/extensionsRequired", json!(["KHR_lights_punctual"]));
    let scene = load_gltf(&json).expect("a valid glTF");
    assert!(scene.camera.forward.distance(DVec3::NEG_X) < 1e-7);
    assert_eq!(scene.camera.eye, DVec3::new(0.0, 0.0, 9.0));
    assert!((scene.camera.half_height() - 0.25_f64.tan()).abs() < 1e-12);
    assert_eq!(
        scene.lights[0],
        Light::Point(PointLight {
            position: DVec3::new(1.0, 2.0, 3.0),
            intensity: DVec3::new(40.0, 20.0, 10.0)
        })
    );
    let Light::Directional(DirectionalLight {
        direction,
        irradiance,
    }) = scene.lights[1]
    else {
        panic!("a directional light")
    };
    assert!(direction.distance(DVec3::NEG_Y) < 1e-7);
    assert_eq!(irradiance, DVec3::splat(1000.0));
    let Light::Spot(SpotLight {
        direction,
        inner_angle,
        outer_angle,
        ..
    }) = scene.lights[2]
    else {
        panic!("a spot light")
    };
    assert_eq!(direction, DVec3::NEG_Z);
    assert!(inner_angle.abs() < 1e-15 && outer_angle <= std::f64::consts::FRAC_PI_2);
    assert_eq!(
        scene.warnings,
        [
            "scene.gltf: the range of 1 light is ignored: light falls off with the square of the distance alone"
        ]
    );
}

#[test]
fn what_is_left_out_is_said_once() {
    let json = with(
        triangle_gltf(),
        "/materials",
        json!([
            {
                "alphaMode": "BLEND",
                "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } },
                "occlusionTexture": { "index": 0 }
            },
            {}
        ]),
    );
    let json = with_texture(json, &png(&[[255, 0, 0], [0, 255, 0]]));
    let json = with(
        json,
        "/meshes/0/primitives",
        json!([
            { "attributes": { "POSITION": 0, "NORMAL": 0, "COLOR_0": 0 }, "indices": 1, "material": 0 },
            { "attributes": { "POSITION": 0, "NORMAL": 0 }, "indices": 1, "material": 1, "targets": [{ "POSITION": 0 }] },
            { "attributes": { "POSITION": 0 }, "mode": 1 }
        ]),
    );
    let json = with(json, "/nodes/0/camera", json!(0));
    let json = with(
        json,
        "/cameras",
        json!([{ "type": "orthographic", "orthographic": { "xmag": 1, "ymag": 1, "zfar": 9, "znear": 0.1 } }]),
    );
    let json = with(
        json,
        "/extensionsUsed",
        json!(["KHR_materials_sheen", "KHR_materials_emissive_strength"]),
    );
    let json = with(
        json,
        "/animations",
        json!([{ "channels": [], "samplers": [] }]),
    );
    let json = with(json, "/scenes", json!([{ "nodes": [0] }, { "nodes": [] }]));
    let scene = load_gltf(&json).expect("a valid glTF");
    assert_eq!(scene.shapes[1].name, "triangle (mesh 0, primitive 1)");
    assert_eq!(
        scene.warnings,
        [
            "scene.gltf: occlusionTexture of 1 material is ignored, shadow rays are traced instead",
            "scene.gltf: textures of 1 primitive have no texture coordinates: their factors are used",
            "scene.gltf: points and lines of 1 primitive are not rendered",
            "scene.gltf: 1 animation is ignored: the scene is rendered as it stands",
            "scene.gltf: only the default one of 2 scenes is rendered",
            "scene.gltf: the extension KHR_materials_sheen is not supported and ignored",
            "the scene has no light: the image will be black",
        ]
    );
}

#[test]
fn quantized_positions() {
    let bin: Vec<u8> = [0i16, 0, 0, 0, 32_767, 0, 0, 0, 0, 32_767, 0, 0]
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let json = with(triangle_gltf(), "/buffers", json!([{ "byteLength": 24 }]));
    let json = with(
        json,
        "/bufferViews",
        json!([{ "buffer": 0, "byteLength": 24, "byteStride": 8 }]),
    );
    let json = with(
        json,
        "/accessors",
        json!([{ "bufferView": 0, "componentType": 5122, "normalized": true, "count": 3, "type": "VEC3" }]),
    );
    let mut json = with(
        json,
        "/extensionsRequired",
        json!(["KHR_mesh_quantization"]),
    );
    json["meshes"][0]["primitives"] = json!([{ "attributes": { "POSITION": 0 } }]);
    let folder = Folder::new();
    folder.write("scene.glb", glb(&json, &bin));
    let scene = folder.load("scene.glb").expect("a valid GLB");
    assert_eq!(
        corners(mesh(&scene, 0), 0),
        [DVec3::ZERO, DVec3::X, DVec3::Y]
    );
}

#[test]
fn khronos_samples_load() {
    let Some(assets) = shared("assets") else {
        return;
    };
    let options = LoadOptions::default();
    let helmet = load(&assets.join("FlightHelmet/FlightHelmet.gltf"), &options)
        .unwrap_or_else(|e| panic!("{e}"));
    let triangles: usize = (0..helmet.shapes.len())
        .map(|s| mesh(&helmet, s).triangles.len())
        .sum();
    let names: Vec<&str> = helmet.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(
        names,
        [
            "HoseMat",
            "RubberWoodMat",
            "GlassPlasticMat",
            "MetalPartsMat",
            "LeatherPartsMat",
            "LensesMat"
        ]
    );
    insta::assert_snapshot!(format!(
        "{triangles} triangles\n{}",
        helmet.warnings.join("\n")
    ));

    let cornell = load(&assets.join("CornellBox.glb"), &options).unwrap_or_else(|e| panic!("{e}"));
    let light = cornell.shapes[0].emission.expect("the light emits");
    assert_eq!(light.radiance, DVec3::splat(100.0));
    insta::assert_snapshot!(cornell.warnings.join("\n"));

    let depth = load(
        &assets.join("DepthOfFieldExample/DepthOfFieldExample.glb"),
        &options,
    )
    .unwrap_or_else(|e| panic!("{e}"));
    assert!(
        matches!(depth.lights[0], Light::Directional(DirectionalLight { irradiance, .. }) if irradiance == DVec3::splat(6830.0))
    );
    insta::assert_snapshot!(depth.warnings.join("\n"));
}

/// The extensions about dielectrics, and what is left out of them in one sentence each.
#[test]
fn extensions_of_materials_are_read() {
    let mut json = triangle_gltf();
    json["extensionsUsed"] = json!([
        "KHR_materials_ior",
        "KHR_materials_specular",
        "KHR_materials_transmission",
        "KHR_materials_volume"
    ]);
    json["materials"][0] = json!({
        "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": 0.5 },
        "extensions": {
            "KHR_materials_ior": { "ior": 1.25 },
            "KHR_materials_specular": { "specularFactor": 0.5, "specularColorFactor": [1, 0.5, 2] },
            "KHR_materials_transmission": { "transmissionFactor": 0.75 },
            "KHR_materials_volume": { "thicknessFactor": 1, "attenuationDistance": 2 }
        }
    });
    let scene = load_gltf(&json).expect("a valid glTF");
    let material = &scene.materials[0];
    let Bsdf::MetallicRoughness { layer, .. } = material.bsdf else {
        panic!("{material:?}");
    };
    let expected = DielectricLayer {
        ior: 1.25,
        specular: 0.5,
        specular_color: DVec3::new(1.0, 0.5, 2.0),
        transmission: 0.75,
        thin: false,
        metal_mask: false,
    };
    assert_eq!(layer, expected);
    assert!(material.double_sided, "light leaves through the back");
    let warned = |part: &str| scene.warnings.iter().filter(|w| w.contains(part)).count();
    assert_eq!(warned("roughness is ignored"), 1, "{:?}", scene.warnings);
    assert_eq!(warned("attenuation"), 1, "{:?}", scene.warnings);
    assert_eq!(
        warned("not supported and ignored"),
        0,
        "{:?}",
        scene.warnings
    );
    for (extension, key, value, expected) in [
        (
            "ior",
            "ior",
            json!(0.5),
            "is 0.5; expected an index of refraction from 1 to 1000, or 0",
        ),
        (
            "specular",
            "specularFactor",
            json!(2),
            "is 2; expected a number from 0 to 1",
        ),
        (
            "transmission",
            "transmissionFactor",
            json!(-1),
            "is -1; expected a number from 0 to 1",
        ),
        (
            "specular",
            "specularColorFactor",
            json!([0, -1, 0]),
            "is -1; expected a finite number, not negative",
        ),
    ] {
        let mut bad = json.clone();
        let name = format!("KHR_materials_{extension}");
        bad["materials"][0]["extensions"][&name][key] = value;
        let message = load_gltf(&bad).expect_err("it is refused");
        let expected = format!("materials[0].extensions.{name}.{key}: {expected}");
        assert!(message.contains(&expected), "{message}");
    }
}
