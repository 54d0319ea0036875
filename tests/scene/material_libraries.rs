//! Material libraries (MTL) of OBJ files.

use super::files::Folder;
use super::textures::png;
use direkt::scene::load::{LoadOptions, load_with_files};
use direkt::scene::material::DielectricLayer;
use direkt::scene::{Bsdf, Geometry, Scene};
use glam::DVec3;
use std::path::PathBuf;

const OBJ: &str = "mtllib sub\\paint.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nf 1 2 3\nusemtl red\nf 1/1 3/3 4/2\nusemtl glass # clear\nf 1 2 4\nusemtl red\nf 1/1 2/2 4/3\n";
const MTL: &str = "# paint\nnewmtl red\nKa 1 1 1\nKd 0.8 0.1 0.1\nmap_Kd -s 2 2 2 wood.png\nillum 1\nKs 1 1 1\nnewmtl glass\nillum 7\nNi 1.7\nTf 0.5 0.6 0.7\nd 0.1\nnewmtl lamp\nKe 3\nKd 0\n";

fn folder(obj: &str, mtl: &str) -> Folder {
    let folder = Folder::new();
    folder.write("models/m.obj", obj);
    folder.write("models/sub/paint.mtl", mtl);
    folder.write("models/sub/wood.png", png(&[[255, 0, 0], [0, 255, 0]]));
    folder
}

fn load(folder: &Folder, keys: &str) -> Scene {
    let shape = format!(
        "[environment]\nradiance = 1\n[camera]\neye = [0, 0, 1]\ntarget = [0, 0, 0]\nfov = 40\n[[shapes]]\ntype = \"mesh\"\nfile = \"models/m.obj\"\n{keys}\n"
    );
    folder.write("scene.toml", shape);
    let scene = folder.load("scene.toml").unwrap_or_else(|e| panic!("{e}"));
    Scene {
        warnings: scene.warnings.iter().map(|w| folder.anonymous(w)).collect(),
        ..scene
    }
}

fn triangles(scene: &Scene) -> Vec<usize> {
    let count = |geometry: &Geometry| geometry.primitives() as usize;
    scene.shapes.iter().map(|s| count(&s.geometry)).collect()
}

#[test]
fn a_shape_without_a_material_has_those_of_its_file() {
    let folder = folder(OBJ, MTL);
    let scene = load(&folder, "");
    assert_eq!(triangles(&scene), [1, 2, 1]);
    let names: Vec<&str> = scene.shapes.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(
        names,
        ["shapes[0]", "shapes[0]: red", "shapes[0]: glass # clear"]
    );
    let material = |shape: usize| &scene.materials[scene.shapes[shape].material.index()];
    assert_eq!(material(0).name, "default");
    let reflectance = DVec3::new(0.8, 0.1, 0.1);
    assert_eq!(material(1).bsdf, Bsdf::Lambert { reflectance });
    let texture = material(1).textures.color.expect("a texture");
    assert_eq!(texture.transform.matrix2.x_axis.x, 2.0);
    assert_eq!(
        material(2).bsdf,
        Bsdf::Dielectric {
            ior: 1.7,
            transmittance: DVec3::new(0.5, 0.6, 0.7),
            thin: false,
        }
    );
    assert_eq!(
        scene.warnings,
        ["DIR/models/sub/paint.mtl: not supported and ignored: Ka"]
    );
}

#[test]
fn a_material_of_the_scene_file_comes_first() {
    let folder = folder(OBJ, MTL);
    folder.write("models/sub/paint.mtl", "Kd nonsense");
    let own = load(
        &folder,
        "material = \"own\"\n[materials.own]\ntype = \"lambert\"\nreflectance = 1",
    );
    assert_eq!((triangles(&own), own.materials.len()), (vec![4], 1));
    assert_eq!(
        own.warnings,
        [
            "DIR/models/m.obj: material libraries (mtllib) are ignored: a shape has the material that the scene file names"
        ]
    );
}

fn bsdf(statements: &str) -> (Bsdf, Scene) {
    let folder = folder(
        "mtllib sub/paint.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n",
        &format!("newmtl a\n{statements}"),
    );
    let scene = load(&folder, "");
    (scene.materials[0].bsdf, scene)
}

#[test]
fn statements_become_materials() {
    let model = |color: f64, metallic, roughness, layer| Bsdf::MetallicRoughness {
        base_color: DVec3::splat(color),
        metallic,
        roughness,
        layer,
    };
    // α = √(2/(Ns + 2)), and α is the square of the roughness.
    let glossy = (2.0_f64 / 100.0).powf(0.25);
    let reflecting = DielectricLayer {
        specular_color: DVec3::splat(0.25) / DielectricLayer::default().f0(),
        ..DielectricLayer::default()
    };
    let dense = DielectricLayer {
        ior: 2.0,
        ..DielectricLayer::default()
    };
    for (statements, expected) in [
        (
            "Kd 0.25",
            Bsdf::Lambert {
                reflectance: DVec3::splat(0.25),
            },
        ),
        (
            "Ns 10",
            Bsdf::Lambert {
                reflectance: DVec3::splat(0.5),
            },
        ),
        (
            "Kd 0\nKs .25\nNs 98\nillum 2",
            model(0.0, 0.0, glossy, reflecting),
        ),
        ("kd 0\nks .25\nillum 3", model(0.0, 0.0, 0.0, reflecting)),
        (
            "Kd 1\nPr 0.25\nPm 1\nKs 1\nNi 2",
            model(1.0, 1.0, 0.25, dense),
        ),
    ] {
        assert_eq!(bsdf(statements).0, expected, "{statements}");
    }
    let opacity = |statements: &str| bsdf(statements).1.materials[0].opacity.factor;
    assert_eq!(opacity("d 0.25"), 0.25);
    assert_eq!(opacity("Tr 0.75"), 0.25);
    assert_eq!(opacity("d -halo 0.25\nTr 0.25"), 0.25);
    let (_, lamp) = bsdf("Ke 1 2 3");
    let emission = lamp.shapes[0].emission.expect("it emits");
    assert_eq!(
        (emission.radiance, emission.two_sided),
        (DVec3::new(1.0, 2.0, 3.0), true)
    );
}

#[test]
fn the_emission_of_the_scene_file_comes_first() {
    let folder = folder(
        "mtllib sub/paint.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl lamp\nf 1 2 3\n",
        MTL,
    );
    let radiance = |keys: &str| load(&folder, keys).shapes[0].emission.map(|e| e.radiance.x);
    assert_eq!(radiance(""), Some(3.0));
    assert_eq!(radiance("emission = { radiance = 7 }"), Some(7.0));
}

/// What is missing, unknown or out of range is a warning that names it, and the rest is rendered.
#[test]
fn what_a_library_lacks_is_named() {
    let obj = "mtllib no.mtl sub/paint.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1\nusemtl b\nf 1 3 2\nusemtl c\nf 1 2 3\n";
    let mtl = "newmtl a\nKd 2 0.5 0.5\nmap_Kd C:\\art\\none.png\nmap_Bump bump.png\nPc 0.5\nsharpness 60\nnewmtl b\nd 0\nmap_Kd ..\\else\\wood.png\nKd xyz 1 1 1\n";
    let scene = load(&folder(obj, mtl), "");
    assert_eq!(
        scene.warnings,
        [
            "DIR/models/m.obj: mtllib: `no.mtl` does not exist; expected a file in the scene's folder, or in one named with --assets; its materials are left out",
            "DIR/models/sub/paint.mtl: map_Kd of `a`: `C:\\art\\none.png` does not exist; expected a file in the scene's folder, or in one named with --assets; the texture is left out",
            "DIR/models/sub/paint.mtl: material `a` has Kd [2, 0.5, 0.5], taken as [1, 0.5, 0.5]",
            "DIR/models/sub/paint.mtl: material `b` is invisible: d is 0, or Tr is 1",
            "DIR/models/m.obj: material `b` has textures, and its faces have no texture coordinates: its factors are used",
            "DIR/models/m.obj: no library has the material c: the grey of shapes without a material is used",
            "DIR/models/sub/paint.mtl: not supported and ignored: Pc, map_bump (a height; a normal map is `norm`), sharpness, spectral",
        ]
    );
    let folder = folder(OBJ, "newmtl red\nKd 1 2\n");
    folder.write(
        "scene.toml",
        "[[shapes]]\ntype = \"mesh\"\nfile = \"models/m.obj\"\n",
    );
    assert_eq!(
        folder.load("scene.toml").expect_err("it must be refused"),
        "DIR/models/sub/paint.mtl: line 2: is `Kd 1 2`; expected `Kd` and three numbers, or one"
    );
}

/// Files that are named and not shown count as the scene's all the same, so that nothing overwrites
/// them.
#[test]
fn maps_that_are_not_shown_are_files_of_the_scene() {
    let mtl = "newmtl red\nKd 1 1 1\nmap_Ks shiny.png\nmap_bump -bm 0.5 rough.png\ndisp high.png\nnewmtl unused\nmap_Kd wood.png\n";
    let folder = folder(OBJ, mtl);
    for name in ["shiny.png", "rough.png", "high.png"] {
        folder.write(&format!("models/sub/{name}"), png(&[[1, 2, 3]]));
    }
    let files = |keys: &str| {
        load(&folder, keys);
        let (scene, files) = load_with_files(&folder.path("scene.toml"), &LoadOptions::default());
        assert!(scene.is_ok());
        let name = |path: &PathBuf| path.file_name().unwrap().to_str().unwrap().to_owned();
        files.iter().map(name).collect::<Vec<String>>()
    };
    let all = files("");
    for name in [
        "paint.mtl",
        "shiny.png",
        "rough.png",
        "high.png",
        "wood.png",
    ] {
        assert!(all.iter().any(|file| file == name), "{name}: {all:?}");
    }
    let library = "material = \"m\"\n[materials.m]\ntype = \"lambert\"\nreflectance = 1";
    assert!(files(library).contains(&"paint.mtl".to_owned()));
}
