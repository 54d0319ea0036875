//! TOML scenes mean what they say.

use super::files::{Folder, load_toml};
use direkt::scene::load::{LoadOptions, schema};
use direkt::scene::{
    Bsdf, DirectionalLight, EnvironmentRadiance, ExpectedRadiance, Geometry, Light, PointLight,
    Projection, Scene, SpotLight,
};
use glam::DVec3;

const CAMERA: &str = "[camera]\neye = [0, 0, 5]\ntarget = [0, 0, 0]\nfov = 40\n";

fn scene(text: &str) -> Scene {
    load_toml(&format!("{CAMERA}{text}")).expect("the scene is valid")
}

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

#[test]
fn canonical_shapes_are_mitsubas() {
    let scene = scene(
        r#"
        [[shapes]]
        type = "rectangle"
        [[shapes]]
        type = "sphere"
        [[shapes]]
        type = "disk"
        [[shapes]]
        type = "box"
        "#,
    );
    assert_eq!(
        rectangle(&scene.shapes[0].geometry),
        (DVec3::ZERO, DVec3::Z)
    );
    assert_eq!(
        scene.shapes[1].geometry,
        Geometry::Sphere {
            center: DVec3::ZERO,
            radius: 1.0
        }
    );
    let Geometry::Disk { center, u, v } = scene.shapes[2].geometry else {
        panic!("a disk")
    };
    assert!(near(center, DVec3::ZERO) && near(u.cross(v), DVec3::Z));
    for face in &scene.shapes[3..] {
        let (c, n) = rectangle(&face.geometry);
        assert!(near(c, n), "{}: {c} {n}", face.name);
    }
    assert_eq!(scene.shapes.len(), 9);
    assert_eq!(scene.materials.len(), 1);
    assert_eq!(
        scene.materials[0].bsdf,
        Bsdf::Lambert {
            reflectance: DVec3::splat(0.5)
        }
    );
}

#[test]
fn transforms_apply_in_the_order_listed() {
    let scene = scene(
        r#"
        [[shapes]]
        type = "sphere"
        transform = [
            { scale = 2 },
            { translate = [1, 0, 0] },
            { rotate = { axis = [0, 0, 3], degrees = 90 } },
            { matrix = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 7], [0, 0, 0, 1]] },
        ]
        [[shapes]]
        type = "rectangle"
        transform = [{ look_at = { origin = [0, 5, 0], target = [0, 0, 0], up = [0, 0, 1] } }]
        "#,
    );
    let Geometry::Sphere { center, radius } = scene.shapes[0].geometry else {
        panic!("a sphere")
    };
    assert!(near(center, DVec3::new(0.0, 1.0, 7.0)) && (radius - 2.0).abs() < 1e-12);
    let (c, n) = rectangle(&scene.shapes[1].geometry);
    assert!(near(c, DVec3::new(0.0, 5.0, 0.0)) && near(n, DVec3::NEG_Y));
}

#[test]
fn mirrored_lights_emit_to_the_mirrored_side() {
    let scene = scene(
        r#"
        [[shapes]]
        type = "rectangle"
        emission = { radiance = 1 }
        transform = [{ translate = [0, 0, 2] }, { scale = [1, 1, -1] }]
        [[shapes]]
        type = "rectangle"
        emission = { radiance = [1, 2, 3], two_sided = true }
        transform = [{ translate = [0, 0, 2] }, { scale = [-1, 1, 1] }]
        "#,
    );
    assert_eq!(rectangle(&scene.shapes[0].geometry).1, DVec3::NEG_Z);
    assert_eq!(rectangle(&scene.shapes[1].geometry).1, DVec3::Z);
    let emission = scene.shapes[1].emission.expect("it emits");
    assert!(emission.two_sided);
    assert_eq!(emission.radiance, DVec3::new(1.0, 2.0, 3.0));
}

#[test]
fn cameras_by_matrix_and_by_points_are_the_same() {
    let by_points = scene("").camera;
    let by_matrix =
        load_toml("[camera]\nfov = 40\nmatrix = [[1,0,0,0],[0,1,0,0],[0,0,1,5],[0,0,0,1]]\n")
            .expect("the scene is valid")
            .camera;
    assert_eq!(by_points, by_matrix);
    let down = load_toml("[camera]\neye = [0, 9, 0]\ntarget = [0, 0, 0]\nfov = 1e-3\n")
        .expect("a straight-down view is fine")
        .camera;
    assert!(near(down.forward, DVec3::NEG_Y) && (down.up.length() - 1.0).abs() < 1e-12);
}

/// What is not said is a pinhole, the plane through `target`, and the pixel's own square.
#[test]
fn lenses_projections_and_filters() {
    let view = "[camera]\neye = [0, 3, 4]\ntarget = [0, 0, 0]\n";
    let load = |rest: &str| load_toml(&format!("{view}{rest}")).expect("the scene is valid");
    let plain = load("fov = 40\n");
    assert!(!plain.camera.is_orthographic() && plain.filter.is_pixel());
    assert_eq!(plain.camera.lens.radius, 0.0);
    assert_eq!(load("fov = 40\nlens_radius = 0\n").camera, plain.camera);
    let same = load("fov = 40\n[film]\nfilter = \"box\"\nfilter_radius = 0.5\n");
    assert_eq!(same.filter, plain.filter);
    let lens = load("fov = 40\nlens_radius = 0.25\n").camera.lens;
    assert_eq!((lens.radius, lens.focus_distance), (0.25, 5.0));
    let lens = load("fov = 40\nlens_radius = 0.25\nfocus_distance = 2\n")
        .camera
        .lens;
    assert_eq!((lens.radius, lens.focus_distance), (0.25, 2.0));
    let orthographic = load("type = \"orthographic\"\nheight = 3\n").camera;
    assert_eq!(
        orthographic.projection,
        Projection::Orthographic { height: 3.0 }
    );
    for (filter, radius) in [("tent", 1.0), ("gaussian", 1.5), ("blackman-harris", 2.0)] {
        let text = format!("fov = 40\n[film]\nfilter = \"{filter}\"\n");
        assert_eq!(load(&text).filter.radius, radius, "{filter}");
        let wider = format!("{text}filter_radius = 2.5\n");
        assert_eq!(load(&wider).filter.radius, 2.5, "{filter}");
    }
}

#[test]
fn expectations_are_a_mean_or_pixels_row_by_row() {
    let scene = scene(
        r#"
        [film]
        width = 2
        height = 2
        [expect]
        pixels = [[1, [1, 2, 3]], [0, 0.5]]
        source = "made up"
        "#,
    );
    let expect = scene.expect.expect("there is a table");
    let rows = [[1.0; 3], [1.0, 2.0, 3.0], [0.0; 3], [0.5; 3]];
    assert_eq!(
        expect.radiance,
        ExpectedRadiance::Pixels(rows.map(DVec3::from_array).to_vec())
    );
    assert_eq!((expect.source.as_str(), expect.tolerance), ("made up", 0.0));
    let mean = load_toml("[expect]\nradiance = 2\nsource = \"book\"\ntolerance = 1e-4\n");
    let mean = mean.expect("the scene is valid").expect;
    let mean = mean.expect("there is a table");
    assert_eq!(mean.radiance, ExpectedRadiance::Mean(DVec3::splat(2.0)));
    assert_eq!(mean.tolerance, 1e-4);
}

#[test]
fn lights_and_environment() {
    let scene = scene(
        r#"
        [[lights]]
        type = "point"
        position = [3, 0, 4]
        intensity = 100
        [[lights]]
        type = "spot"
        position = [0, 2, 0]
        target = [0, 1, 0]
        intensity = [1, 2, 3]
        inner = 30
        outer = 30
        [[lights]]
        type = "directional"
        direction = [0, -2, 0]
        irradiance = 10
        [environment]
        radiance = 2
        rotation = 90
        scale = 0.5
        "#,
    );
    assert_eq!(
        scene.lights[0],
        Light::Point(PointLight {
            position: DVec3::new(3.0, 0.0, 4.0),
            intensity: DVec3::splat(100.0)
        })
    );
    let Light::Spot(SpotLight {
        direction,
        inner_angle,
        outer_angle,
        ..
    }) = scene.lights[1]
    else {
        panic!("a spot light")
    };
    assert!(near(direction, DVec3::NEG_Y));
    assert!((inner_angle - outer_angle).abs() < 1e-15);
    let Light::Directional(DirectionalLight { direction, .. }) = scene.lights[2] else {
        panic!("a directional light")
    };
    assert!(near(direction, DVec3::NEG_Y));
    let environment = scene.environment.expect("it has one");
    assert!(near(environment.rotation * DVec3::NEG_Z, DVec3::NEG_X));
}

#[test]
fn a_map_with_bad_texels_is_cleaned() {
    let folder = Folder::new();
    let texels = [
        [1.0f32, 2.0, 3.0],
        [f32::NAN, 1.0, 1.0],
        [-1.0, 0.5, 0.0],
        [f32::INFINITY; 3],
    ];
    let texel = |x: usize, y: usize| {
        let [r, g, b] = texels[2 * y + x];
        (r, g, b)
    };
    exr::prelude::write_rgb_file(folder.path("sky.exr"), 2, 2, texel)
        .expect("an EXR can be written");
    folder.write(
        "scene.toml",
        format!("{CAMERA}[environment]\nfile = \"sky.exr\"\n"),
    );
    let scene = folder.load("scene.toml").expect("the scene is valid");
    assert_eq!(scene.warnings.len(), 1);
    assert_eq!(
        folder.anonymous(&scene.warnings[0]),
        "DIR/sky.exr: 3 texels are negative or not finite; such channels are taken as 0"
    );
    let EnvironmentRadiance::Map(map) = scene.environment.expect("it has one").radiance else {
        panic!("a map")
    };
    assert_eq!(
        map.texels,
        [[1.0, 2.0, 3.0], [0.0, 1.0, 1.0], [0.0, 0.5, 0.0], [0.0; 3]]
    );
}

#[test]
fn empty_scenes_and_scenes_without_light_are_fine() {
    let empty = load_toml("").expect("an empty scene is valid");
    assert_eq!(
        empty.warnings,
        [
            "the scene has no camera: one that looks along −z and frames the geometry is used",
            "the scene has no light: the image will be black",
        ]
    );
    assert!(empty.shapes.is_empty());
}

#[test]
fn lobes_that_are_too_narrow_are_mirrors() {
    let scene = scene(
        r#"
        [materials.mirror]
        type = "conductor"
        reflectance = 1
        alpha = 1e-5
        [materials.polished]
        type = "metallic-roughness"
        base_color = 1
        metallic = 1
        roughness = 0
        [materials.rough]
        type = "conductor"
        reflectance = 1
        alpha = 1e-4
        [environment]
        radiance = 1
        "#,
    );
    assert_eq!(scene.warnings, [""; 0]);
    let mirrors = scene
        .materials
        .iter()
        .map(|m| m.bsdf.parameters().is_specular());
    assert_eq!(mirrors.collect::<Vec<_>>(), [true, true, false]);
}

#[test]
fn files_are_found_in_assets_and_symbolic_links_are_followed() {
    let folder = Folder::new();
    let assets = Folder::new();
    assets.write("models/t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder.write(
        "scenes/scene.toml",
        format!("{CAMERA}[[shapes]]\ntype = \"mesh\"\nfile = \"models/t.obj\"\n"),
    );
    let options = LoadOptions {
        assets: vec![assets.path("")],
        ..LoadOptions::default()
    };
    assert!(folder.load("scenes/scene.toml").is_err());
    let scene = folder
        .load_with("scenes/scene.toml", &options)
        .expect("the mesh is in the assets");
    assert!(matches!(&scene.shapes[0].geometry, Geometry::Mesh(m) if m.triangles.len() == 1));

    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(assets.path("models"), folder.path("scenes/models"))
            .expect("a link can be made");
        let message = folder
            .load("scenes/scene.toml")
            .expect_err("the link leaves");
        assert!(message.contains("leaves the scene's folder"), "{message}");
        folder
            .load_with("scenes/scene.toml", &options)
            .expect("with the assets it may");
    }
}

#[test]
fn a_gltf_is_included_with_material_light_and_placement() {
    let folder = Folder::new();
    folder.write("parts/t.gltf", super::files::triangle_gltf().to_string());
    folder.write(
        "scene.toml",
        r#"
        [materials.own]
        type = "lambert"
        reflectance = 0.1
        [[shapes]]
        type = "sphere"
        material = "own"
        [[gltf]]
        file = "parts/t.gltf"
        transform = [{ scale = [1, 1, -1] }, { translate = [0, 0, 3] }]
        [environment]
        radiance = 1
        "#,
    );
    let scene = folder.load("scene.toml").expect("the scene is valid");
    let included = &scene.shapes[1];
    assert_eq!(included.name, "gltf[0]: triangle (mesh 0)");
    assert_eq!(scene.materials[included.material.index()].name, "paint");
    let Geometry::Mesh(mesh) = &included.geometry else {
        panic!("a mesh")
    };
    let [a, b, c] = mesh.triangles[0].map(|i| mesh.positions[i as usize]);
    assert!(near(a, DVec3::new(0.0, 0.0, 3.0)));
    assert!(
        near((b - a).cross(c - a), DVec3::NEG_Z),
        "mirrored, so the front is the other side"
    );
}

#[test]
fn the_schema_describes_every_table() {
    let schema: serde_json::Value = serde_json::from_str(&schema()).expect("a schema is JSON");
    for key in [
        "camera",
        "film",
        "materials",
        "shapes",
        "gltf",
        "lights",
        "environment",
        "render",
        "expect",
    ] {
        let property = &schema["properties"][key];
        assert!(property["description"].is_string(), "{key}: {property}");
    }
    assert_eq!(schema["additionalProperties"], false);
    let text = schema.to_string();
    for word in [
        "metallic-roughness",
        "look_at",
        "two_sided",
        "mis-power",
        "vertical field of view",
    ] {
        assert!(text.contains(word), "{word}");
    }
}
