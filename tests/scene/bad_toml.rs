//! Bad TOML scenes are refused with the file, the field, what is wrong and what would be right.

use super::files::{Folder, refused};
use direkt::scene::load::LoadOptions;

const CAMERA: &str = "[camera]\neye = [0, 0, 5]\ntarget = [0, 0, 0]\nfov = 40\n";

/// The message for a scene of one shape.
fn shape(text: &str) -> String {
    refused(&format!("[[shapes]]\n{text}\n"))
}

#[track_caller]
fn says(message: String, expected: &str) {
    assert_eq!(message, format!("DIR/scene.toml: {expected}"));
}

#[test]
fn files_that_are_not_there() {
    let folder = Folder::new();
    let message = |name: &str| folder.load(name).expect_err("it must be refused");
    assert_eq!(message("none.toml"), "DIR/none.toml: there is no such file");
    std::fs::create_dir(folder.path("folder.toml")).expect("a folder can be made");
    assert_eq!(
        message("folder.toml"),
        "DIR/folder.toml: is a folder; expected a file"
    );
    folder.write("scene.pbrt", "");
    assert_eq!(
        message("scene.pbrt"),
        "DIR/scene.pbrt: `.pbrt` is not a scene format; expected a scene in .toml, .gltf or .glb"
    );
    folder.write("scene", "");
    assert_eq!(
        message("scene"),
        "DIR/scene: the name has no extension that would tell the format; expected a scene in .toml, .gltf or .glb"
    );
    folder.write("binary.toml", [0xff, 0xfe, 0x00]);
    assert!(message("binary.toml").starts_with("DIR/binary.toml: is not UTF-8"));
    #[cfg(unix)]
    {
        let path = folder.path("pipe.toml");
        std::os::unix::net::UnixListener::bind(path).expect("a socket can be made");
        assert_eq!(
            message("pipe.toml"),
            "DIR/pipe.toml: is a pipe or a device; expected a file"
        );
    }
    let options = LoadOptions {
        assets: vec![folder.path("nowhere")],
        ..LoadOptions::default()
    };
    assert_eq!(
        folder
            .load_with("scene", &options)
            .expect_err("it must be refused"),
        "DIR/nowhere: there is no such folder; expected `--assets` to name an existing folder"
    );
}

#[test]
fn syntax_and_keys() {
    says(
        refused("[camera\n"),
        "is not valid TOML: unclosed table, expected `]` (line 1)",
    );
    says(
        refused("[film]\nwidth = 5\nheigth = 5\n"),
        "film.heigth: unknown key `heigth` (line 3); expected `width`, `height`, `filter`, `filter_radius`, `filter_stddev`",
    );
    says(
        shape("type = \"sphere\"\nradiuss = 2"),
        "shapes[0].radiuss: unknown key `radiuss` (line 3); expected `center` or `radius`, `name`, `material`, `emission`, `transform`",
    );
    says(
        shape("type = \"sphere\"\n[shapes.emission]\nradiance = 1\ncolor = 2"),
        "shapes[0].emission.color: unknown key `color` (line 5); expected `radiance`, `texture`, `two_sided`, `group`",
    );
    says(
        shape("type = \"cone\""),
        "shapes[0].type: unknown type `cone` (line 2); expected `rectangle`, `box`, `sphere`, `disk`, `mesh`",
    );
    says(
        shape("radius = 1"),
        "shapes[0]: has no `type` (line 1); expected type = \"rectangle\", \"box\", \"sphere\", \"disk\" or \"mesh\"",
    );
    says(
        refused("[materials.red]\ntype = \"lambert\"\n"),
        "materials.red: missing key `reflectance` (line 1)",
    );
    says(
        refused("[camera]\neye = [0, 0, 1]\ntarget = [0, 0, 0]\n"),
        "camera: missing key `fov`; expected an angle above 0 and below 180 degrees",
    );
    says(
        refused("[render]\nstrategy = \"magic\"\n"),
        "render.strategy: unknown value `magic` (line 2); expected `uniform-hemisphere`, `cosine-hemisphere`, `bsdf`, `light-area`, `light-solid-angle`, `light-projected-solid-angle`, `mis-balance`, `mis-power`",
    );
}

#[test]
fn types_and_lengths() {
    says(
        shape("type = \"sphere\"\nradius = \"big\""),
        "shapes[0].radius: invalid type: string \"big\" (line 3); expected f64",
    );
    says(
        shape("type = \"sphere\"\ncenter = [1, 2]"),
        "shapes[0].center: invalid length 2 (line 3); expected an array of length 3",
    );
    says(
        refused("[materials.m]\ntype = \"lambert\"\nreflectance = [1, 0]\n"),
        "materials.m.reflectance: invalid length 2 (line 3); expected three numbers [r, g, b], or one for all",
    );
    says(
        refused("[materials.m]\ntype = \"lambert\"\nreflectance = [1, 0, 0, 1]\n"),
        "materials.m.reflectance: invalid length 4 (line 3); expected three numbers [r, g, b], or one for all",
    );
    says(
        shape("type = \"sphere\"\ntransform = [{ scale = 1 }, { spin = 3 }]"),
        "shapes[0].transform[1].spin: unknown key `spin` (line 3); expected `translate`, `scale`, `rotate`, `matrix`, `look_at`",
    );
}

#[test]
fn numbers_out_of_their_domain() {
    says(
        shape("type = \"sphere\"\nradius = nan"),
        "shapes[0].radius: is nan (line 3); expected a finite number",
    );
    says(
        shape("type = \"sphere\"\ncenter = [0, -inf, 0]"),
        "shapes[0].center[1]: is -inf (line 3); expected a finite number",
    );
    says(
        shape("type = \"sphere\"\nradius = -1"),
        "shapes[0].radius: is -1; expected a number above 0",
    );
    says(
        refused("[film]\nwidth = -512\n"),
        "film.width: is -512; expected 1 to 32768 pixels",
    );
    says(
        refused("[film]\nheight = 32769\n"),
        "film.height: is 32769; expected 1 to 32768 pixels",
    );
    for fov in ["0", "180", "-3"] {
        says(
            refused(&CAMERA.replace("40", fov)),
            &format!("camera.fov: is {fov}; expected an angle above 0 and below 180 degrees"),
        );
    }
    says(
        refused(&format!("{CAMERA}[render]\nspp = 0\n")),
        "render.spp: is 0; expected at least 1 sample per pixel",
    );
    says(
        refused(&format!("{CAMERA}[render]\ntime = 0\n")),
        "render.time: is 0; expected seconds, above 0",
    );
    says(
        refused(&format!("{CAMERA}[render]\nerror = -0.01\n")),
        "render.error: is -0.01; expected a relative error such as 0.01, above 0",
    );
    says(
        refused(&format!("{CAMERA}[render]\nconfidence = 95\n")),
        "render.confidence: is 95; expected a probability such as 0.95, above 0 and below 1",
    );
    says(
        refused("[materials.m]\ntype = \"lambert\"\nreflectance = [0.5, 1.5, 0.5]\n"),
        "materials.m.reflectance: is [0.5, 1.5, 0.5]; expected each channel from 0 to 1",
    );
    says(
        refused("[materials.m]\ntype = \"conductor\"\nreflectance = 1\nalpha = 1.25\n"),
        "materials.m.alpha: is 1.25; expected a number from 0 to 1",
    );
}

#[test]
fn cameras() {
    says(
        refused("[camera]\neye = [1, 2, 3]\ntarget = [1, 2, 3]\nfov = 40\n"),
        "camera.target: is the eye, [1.0, 2.0, 3.0]; expected a point in front of the eye",
    );
    says(
        refused("[camera]\neye = [1, 2, 3]\nfov = 40\n"),
        "camera: its position is given in parts or twice; expected `eye` and `target` (and `up`), or `matrix`",
    );
    says(
        refused("[camera]\nfov = 40\nmatrix = [[1,0,0,0],[0,1,0,0],[0,0,-1,5],[0,0,0,1]]\n"),
        "camera.matrix: is not a rotation and a translation (a uniform scale is allowed); expected a camera-to-world matrix, row by row, with the last row [0, 0, 0, 1]",
    );
}

#[test]
fn transforms() {
    says(
        shape("type = \"rectangle\"\ntransform = [{ scale = [1, 1, 0] }]"),
        "shapes[0].transform: the transform is singular (its determinant is 0e0); expected a transform that does not flatten space; no scale may be 0",
    );
    says(
        shape("type = \"sphere\"\ntransform = [{ scale = [1, 2, 0] }]"),
        "shapes[0].transform: the transform is singular (its determinant is 0e0); expected a transform that does not flatten space; no scale may be 0",
    );
    says(
        shape("type = \"sphere\"\ntransform = [{ scale = [1, 2, 1e-9] }]"),
        "shapes[0].transform: makes an ellipsoid with half axes of 1e0, 2e0 and 1e-9; expected half axes that differ by a factor of 1e9 at most; a disk has no thickness",
    );
    says(
        shape(
            "type = \"sphere\"\ntransform = [{ scale = [1e-20, 2e-20, 1e-20] }]\n[[shapes]]\ntype = \"sphere\"",
        ),
        "shapes[0].transform: makes a half axis of 1e-20, 1e-20 of the scene's size; expected at least 1e-18 of it",
    );
    says(
        shape("type = \"disk\"\ntransform = [{ rotate = { axis = [0, 0, 0], degrees = 9 } }]"),
        "shapes[0].transform[0].rotate.axis: is [0.0, 0.0, 0.0]; expected a direction that is not zero",
    );
    says(
        shape(
            "type = \"disk\"\ntransform = [{ matrix = [[1,0,0,0],[0,1,0,0],[0,0,1,0],[1,0,0,1]] }]",
        ),
        "shapes[0].transform[0].matrix: its last row is [1.0, 0.0, 0.0, 1.0]; expected [0, 0, 0, 1] (the matrix is written row by row)",
    );
}

#[test]
fn shapes() {
    says(
        refused(
            "[materials.red]\ntype = \"lambert\"\nreflectance = 1\n[materials.blue]\ntype = \"lambert\"\nreflectance = 1\n[[shapes]]\ntype = \"sphere\"\nmaterial = \"rde\"\n",
        ),
        "shapes[0].material: there is no material `rde`; expected one of blue, red",
    );
    says(
        shape("type = \"rectangle\"\ncorner = [0, 0, 0]\nu = [1, 0, 0]"),
        "shapes[0]: gives only a part of `corner`, `u` and `v`; expected all three, or none for the square [-1, 1]² in the xy plane",
    );
    says(
        shape("type = \"rectangle\"\ncorner = [0, 0, 0]\nu = [1, 0, 0]\nv = [2, 0, 0]"),
        "shapes[0]: `u` [1, 0, 0] and `v` [2, 0, 0] span no area; expected two edges in different directions",
    );
    says(
        shape("type = \"box\"\nmin = [0, 0, 0]\nmax = [1, 0, 1]"),
        "shapes[0]: `min` [0, 0, 0] is not below `max` [1, 0, 1] along every axis; expected a box with a volume",
    );
    says(
        refused(&format!(
            "{CAMERA}[[shapes]]\ntype = \"sphere\"\nname = \"lamp\"\nemission = {{ radiance = [1, -1, 0] }}\n"
        )),
        "shapes[0].emission.radiance: is [1, -1, 0]; expected finite numbers, not negative",
    );
    says(
        shape("type = \"sphere\"\nemission = { radiance = 1, texture = { file = \"none.png\" } }"),
        "shapes[0].emission.texture.file: `none.png` does not exist; expected a file in the scene's folder, or in one named with --assets",
    );
}

#[test]
fn lights() {
    let light = |text: &str| refused(&format!("{CAMERA}[[lights]]\n{text}\n"));
    says(
        light("type = \"point\"\nposition = [0, 0, 0]\nintensity = -4"),
        "lights[0].intensity: is [-4, -4, -4]; expected finite numbers, not negative",
    );
    says(
        light(
            "type = \"spot\"\nposition = [0, 0, 0]\nintensity = 1\ndirection = [0, 0, 1]\nouter = 95",
        ),
        "lights[0].outer: is 95; expected a half angle above 0 and up to 90 degrees",
    );
    says(
        light(
            "type = \"spot\"\nposition = [0, 0, 0]\nintensity = 1\ndirection = [0, 0, 1]\ninner = 40\nouter = 30",
        ),
        "lights[0].inner: is 40; expected a half angle from 0 to `outer`",
    );
    says(
        light("type = \"spot\"\nposition = [0, 0, 0]\nintensity = 1"),
        "lights[0]: the direction is given twice or not at all; expected `direction` or `target`",
    );
    says(
        light(
            "type = \"directional\"\ndirection = [0, 0, 1]\nirradiance = 1\nangular_diameter = 200",
        ),
        "lights[0].angular_diameter: is 200; expected 0, or 0.001 to 180 degrees",
    );
    says(
        light(
            "type = \"directional\"\ndirection = [0, 0, 1]\nirradiance = 1\nangular_diameter = -1",
        ),
        "lights[0].angular_diameter: is -1; expected 0, or 0.001 to 180 degrees",
    );
    says(
        light("type = \"directional\"\ndirection = [0, 0, 0]\nirradiance = 1"),
        "lights[0].direction: is [0.0, 0.0, 0.0]; expected a direction that is not zero",
    );
    says(
        refused(&format!("{CAMERA}[environment]\nscale = 2\n")),
        "environment: the radiance is given twice or not at all; expected `radiance` or `file`",
    );
}

#[test]
fn files_that_a_scene_names() {
    let mesh = |file: &str| shape(&format!("type = \"mesh\"\nfile = \"{file}\""));
    says(
        mesh("none.ply"),
        "shapes[0].file: `none.ply` does not exist; expected a file in the scene's folder, or in one named with --assets",
    );
    for outside in ["../t.ply", "a/../../t.ply", "/etc/passwd"] {
        says(
            mesh(outside),
            &format!(
                "shapes[0].file: `{outside}` leaves the scene's folder; expected a file in that folder; put it there or name its folder with --assets"
            ),
        );
    }
    says(
        mesh(""),
        "shapes[0].file: the file name is empty; expected the name of a file",
    );

    let folder = Folder::new();
    folder.write("mesh.stl", "");
    folder.write(
        "scene.toml",
        "[[shapes]]\ntype = \"mesh\"\nfile = \"mesh.stl\"\n",
    );
    assert_eq!(
        folder.load("scene.toml").expect_err("it must be refused"),
        "DIR/scene.toml: shapes[0].file: `mesh.stl`: `.stl` is not a mesh format; expected a mesh in .ply, .obj, .gltf or .glb"
    );
    folder.write("sky.png", "");
    folder.write("scene.toml", "[environment]\nfile = \"sky.png\"\n");
    assert_eq!(
        folder.load("scene.toml").expect_err("it must be refused"),
        "DIR/sky.png: is not an image of a known format; expected a latitude-longitude map in .hdr or .exr"
    );
    folder.write(
        "sky.hdr",
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 0 +X 4\n",
    );
    folder.write("scene.toml", "[environment]\nfile = \"sky.hdr\"\n");
    assert_eq!(
        folder.load("scene.toml").expect_err("it must be refused"),
        "DIR/sky.hdr: is an image of 4 x 0 texels; expected 1 to 32768 texels per side"
    );
    folder.write(
        "sky.hdr",
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 40000\n",
    );
    assert_eq!(
        folder.load("scene.toml").expect_err("it must be refused"),
        "DIR/sky.hdr: is an image of 40000 x 2 texels; expected 1 to 32768 texels per side"
    );
    folder.write(
        "sky.hdr",
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 32768 +X 32768\n",
    );
    assert_eq!(
        folder.load("scene.toml").expect_err("it must be refused"),
        "DIR/sky.hdr: is truncated: 32768 x 32768 texels in 53 bytes; expected the whole image"
    );
    folder.write(
        "sky.hdr",
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 32 +X 32\n",
    );
    assert_eq!(
        folder.load("scene.toml").expect_err("it must be refused"),
        "DIR/sky.hdr: is truncated; expected the whole image"
    );
}

#[test]
fn expectations() {
    let of = |text: &str| {
        refused(&format!(
            "[film]\nwidth = 2\nheight = 1\n[expect]\n{text}\n"
        ))
    };
    let with_source = |text: &str| of(&format!("source = \"book\"\n{text}"));
    says(of("radiance = 1"), "expect: missing key `source` (line 4)");
    says(
        of("radiance = 1\nsource = \" \""),
        "expect.source: is empty; expected where the value comes from: a formula, a paper, a book",
    );
    says(
        with_source(""),
        "expect: the image is given twice or not at all; expected `radiance` (its mean) or `pixels`",
    );
    says(
        with_source("radiance = nan"),
        "expect.radiance: is nan (line 6); expected a finite number",
    );
    says(
        with_source("radiance = [1, -2, 3]"),
        "expect.radiance: is [1, -2, 3]; expected finite numbers, not negative",
    );
    says(
        with_source("radiance = 1\ntolerance = -0.1"),
        "expect.tolerance: is -0.1; expected a relative difference from 0 to below 1",
    );
    says(
        with_source("pixels = [[1, 2], [3, 4]]"),
        "expect.pixels: has 2 rows; expected 1, the film's height",
    );
    says(
        with_source("pixels = [[1, 2, 3]]"),
        "expect.pixels[0]: has 3 values; expected 2, the film's width",
    );
    says(
        with_source("pixels = [[1, -2]]"),
        "expect.pixels[0][1]: is [-2, -2, -2]; expected finite numbers, not negative",
    );
}

/// The message for a material.
fn material(text: &str) -> String {
    refused(&format!("[materials.m]\n{text}\n"))
}

#[test]
fn numbers_of_materials() {
    let index = "materials.m.ior: is 0.9; expected an index of refraction from 1 to 1000";
    let unit = "expected a number from 0 to 1";
    let channels = "expected each channel from 0 to 1";
    for (text, expected) in [
        ("type = \"conductor\"\nreflectance = 1\nalpha = -0.1", format!("materials.m.alpha: is -0.1; {unit}")),
        ("type = \"plastic\"\nreflectance = 1\nalpha = 1.5", format!("materials.m.alpha: is 1.5; {unit}")),
        ("type = \"plastic\"\nreflectance = 1\nalpha = 0.1\nior = 0.9", index.to_owned()),
        ("type = \"mirror\"\nreflectance = 1.5", format!("materials.m.reflectance: is [1.5, 1.5, 1.5]; {channels}")),
        ("type = \"dielectric\"\ntransmittance = -1", format!("materials.m.transmittance: is [-1, -1, -1]; {channels}")),
        (
            "type = \"dielectric\"\nior = 0",
            "materials.m.ior: is 0; expected the index inside over that outside, 0.001 to 1000, of a thin pane from 1".to_owned(),
        ),
        (
            "type = \"dielectric\"\ndouble_sided = false",
            "materials.m.double_sided: is false; expected true: light leaves a body of glass through the back of its surface".to_owned(),
        ),
        (
            "type = \"conductor\"\neta = 0\nk = 1\nalpha = 0.1",
            "materials.m.eta: is [0, 0, 0]; expected each channel above 0 and up to 1000".to_owned(),
        ),
        (
            "type = \"conductor\"\neta = 1\nk = -1\nalpha = 0.1",
            "materials.m.k: is [-1, -1, -1]; expected each channel from 0 to 1000".to_owned(),
        ),
        (
            "type = \"conductor\"\neta = 1\nalpha = 0.1",
            "materials.m: its reflectance is given in parts, twice or not at all; expected `reflectance`, or `eta` and `k`, or `metal`".to_owned(),
        ),
        (
            "type = \"metallic-roughness\"\nbase_color = 1\nmetallic = 0\nroughness = -0.5",
            format!("materials.m.roughness: is -0.5; {unit}"),
        ),
        (
            "type = \"metallic-roughness\"\nbase_color = 1\nmetallic = 0\nroughness = 0.5\nior = 0.9",
            index.to_owned(),
        ),
    ] {
        says(material(text), &expected);
    }
    says(
        refused("[render]\nmax_specular_depth = 65\n"),
        "render.max_specular_depth: is 65; expected 0 to 64",
    );
}
