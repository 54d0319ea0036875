//! What files hold that cannot be rendered: HARD CASES I1, I2.

use super::moved::{difference, film};
use crate::support::hard_cases::{Measured, survive};
use crate::support::{context, prepared, scene};
use direkt::low_level::prepare::Prepared;
use direkt::scene::load::{LoadOptions, load};
use direkt::scene::{
    Emission, FilmSize, Geometry, LightSampling, LightSelection, Mesh, Sampler, Scene, ShadowRays,
    Shape,
};
use glam::{DMat3, DVec3};

const SCENE: &str = r#"
[camera]
eye = [0, 1.5, 4]
target = [0, 0.5, 0]
fov = 40
[film]
width = 32
height = 32
[render]
spp = 16
sampler = "independent"
light_selection = "uniform"
[environment]
radiance = 0.2
[[shapes]]
type = "rectangle"
transform = [{ scale = 3 }, { rotate = { axis = [1, 0, 0], degrees = -90 } }]
[[shapes]]
type = "mesh"
file = "lamp.obj"
emission = { radiance = 5, two_sided = true }
"#;
const LAMP: &str = "v -0.5 1 0\nv 0.5 1 0\nv 0 1.5 0.5\n";

fn load_files(lamp: &str, toml: &str) -> Result<Scene, String> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("lamp.obj"), lamp).unwrap();
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, toml).unwrap();
    load(&path, &LoadOptions::default()).map_err(|e| e.to_string())
}

fn small(mut scene: Scene) -> Scene {
    scene.film = FilmSize {
        width: 32,
        height: 32,
    };
    scene.render.estimator.sampler = Sampler::Independent;
    scene.render.estimator.adaptive = false;
    scene.render.estimator.shadow_rays = ShadowRays::Number(1);
    scene.render.estimator.light_sampling = LightSampling::SolidAngle;
    scene.render.estimator.light_selection = LightSelection::Uniform;
    scene
}

/// Pixels that differ, or lack a sample.
fn different(context: &direkt::low_level::gpu::Context, clean: &Prepared, other: &Prepared) -> f64 {
    let (a, b) = (film(context, clean), film(context, other));
    a.pixels
        .iter()
        .zip(&b.pixels)
        .filter(|(a, b)| a != b)
        .count() as f64
}

#[test]
fn triangles_that_are_none_change_no_pixel() {
    let context = context();
    let clean = small(load_files(&format!("{LAMP}f 1 2 3\n"), SCENE).unwrap());
    let dirty = format!("{LAMP}v nan 0 0\nv 2 1 0\nv 3 1 0\nf 1 2 3\nf 1 2 4\nf 1 1 2\nf 1 5 6\n");
    let dirty = small(load_files(&dirty, SCENE).unwrap());
    assert!(
        dirty
            .warnings
            .iter()
            .any(|w| w.contains("3 degenerate triangles were dropped")),
        "{:?}",
        dirty.warnings
    );
    // Kept, a collinear and a repeated-vertex emitter are lights of area 0.
    let mut kept = clean.clone();
    let positions = vec![
        DVec3::new(-0.5, 1.0, 0.0),
        DVec3::new(0.5, 1.0, 0.0),
        DVec3::new(1.5, 1.0, 0.0),
    ];
    kept.shapes.push(Shape {
        name: "degenerate".to_owned(),
        geometry: Geometry::Mesh(Mesh {
            positions,
            triangles: vec![[0, 0, 1], [0, 1, 2]],
            ..Mesh::default()
        }),
        material: kept.shapes[1].material,
        emission: Some(Emission {
            texture: None,
            radiance: DVec3::splat(5.0),
            two_sided: true,
        }),
    });
    let clean = prepared(clean);
    survive(
        context,
        Measured {
            entry: "I1",
            case: "an emitter with a NaN vertex, one with a repeated vertex, one collinear",
            figure: "pixels that differ from the clean scene's",
            bound: 0.0,
            textbook: "the triangles that are given",
            naive: different(context, &clean, &prepared(kept)),
            ours: different(context, &clean, &prepared(dirty)),
        },
    );
}

/// `rectangle` of side 2 at height 2 over the floor, facing up before the transform `of_lamp`.
fn transformed(of_lamp: &str) -> Result<Scene, String> {
    let toml = SCENE.replace(
        "type = \"mesh\"\nfile = \"lamp.obj\"\nemission = { radiance = 5, two_sided = true }",
        &format!("type = \"rectangle\"\nemission = {{ radiance = 5 }}\ntransform = [{of_lamp}]"),
    );
    load_files(LAMP, &toml)
}

#[test]
fn transforms_are_judged_by_shape_not_by_size() {
    let context = context();
    let flat = transformed("{ scale = [1, 1, 0] }").unwrap_err();
    assert!(flat.contains("the transform is singular"), "{flat}");
    // Everything at 10⁻¹⁰, by the transforms of its shapes.
    let original = small(scene("scenes/cornell.toml"));
    let toml = std::fs::read_to_string(&original.source).unwrap();
    let toml = toml.replace("eye = [0, 0, 3.9]", "eye = [0, 0, 3.9e-10]");
    let tiny = load_files(LAMP, &scaled_transforms(&toml));
    let determinant = DMat3::from_diagonal(DVec3::splat(1e-10)).determinant();
    let count = |refused: bool| f64::from(u8::from(refused));
    survive(
        context,
        Measured {
            entry: "I2",
            case: "Cornell's box with every shape scaled by 10⁻¹⁰",
            figure: "sound transforms that are refused",
            bound: 0.0,
            textbook: "transforms refused where |det| ≤ 10⁻¹²",
            naive: count(determinant <= 1e-12),
            ours: count(tiny.is_err()),
        },
    );
    let [original, tiny] = [original, small(tiny.unwrap())].map(|s| film(context, &prepared(s)));
    let off = difference(&original, &tiny);
    assert!(off <= 1e-5, "{off:e}, {}", context.adapter.name);
}

/// Every list of transforms with a scale by 10⁻¹⁰ at its end.
fn scaled_transforms(toml: &str) -> String {
    let scale = "{ scale = 1e-10 }";
    let one_line = toml.replace(" }]\n", &format!(" }}, {scale}]\n"));
    one_line.replace("\n]\n", &format!("\n    {scale},\n]\n"))
}

#[test]
fn a_mirrored_light_keeps_its_emitting_side() {
    let mirror = "{ translate = [0, 0, 2] }, { scale = [1, 1, -1] }";
    let scene = transformed(mirror).unwrap();
    let Geometry::Rectangle { u, v, .. } = scene.shapes[1].geometry else {
        panic!("a rectangle stays one")
    };
    let map = |p: DVec3| p * DVec3::new(1.0, 1.0, -1.0);
    // Of the rectangle [−1, 1]² with the normal +z.
    let naive = map(2.0 * DVec3::X).cross(map(2.0 * DVec3::Y));
    let turned = |normal: DVec3| f64::from(u8::from(normal.dot(DVec3::NEG_Z) <= 0.0));
    survive(
        context(),
        Measured {
            entry: "I2",
            case: "an emitting rectangle under scale (1, 1, −1)",
            figure: "emitting sides that turn",
            bound: 0.0,
            textbook: "edges mapped, normal by their cross product",
            naive: turned(naive),
            ours: turned(u.cross(v)),
        },
    );
}
