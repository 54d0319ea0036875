//! What several tests share.

mod device;
#[cfg(feature = "window")]
pub mod display;
pub mod every_kind;
pub mod exr_file;
pub mod hard_cases;
pub mod histogram;
pub mod random;
pub mod rounding;
pub mod shader;
pub mod source;
pub mod statistics;
pub mod twin;

pub use device::{context, in_a_process_that_compiles_fast};
use direkt::low_level::gpu::Context;
use direkt::low_level::prepare::Prepared;
use direkt::low_level::render::{Film, Session, StopReason};
use direkt::low_level::stats::z_test::z_test;
use direkt::scene::load::{LoadOptions, load};
use direkt::scene::{
    Bsdf, Camera, Emission, EstimatorSettings, FilmSize, Geometry, Light, LightSelection, Material,
    MaterialId, PointLight, RenderSettings, Sampler, Scene, ShadowRays, Shape, StopSettings,
    Strategy,
};
use glam::DVec3;
use std::path::{Path, PathBuf};

/// All strategies.
pub const STRATEGIES: [Strategy; 8] = [
    Strategy::UniformHemisphere,
    Strategy::CosineHemisphere,
    Strategy::Bsdf,
    Strategy::LightArea,
    Strategy::LightSolidAngle,
    Strategy::LightProjectedSolidAngle,
    Strategy::MisBalance,
    Strategy::MisPower,
];

/// One of each kind, where all would take long.
pub const KINDS_OF_STRATEGIES: [Strategy; 3] =
    [Strategy::LightArea, Strategy::Bsdf, Strategy::MisPower];

/// Runs `last`, which must not unwind, when the process ends: the test harness offers nothing of
/// the kind.
pub fn at_exit(last: extern "C" fn()) {
    unsafe extern "C" {
        fn atexit(function: extern "C" fn()) -> i32;
    }
    // SAFETY: `last` is an `extern "C"` function without arguments, as the C library's atexit asks.
    unsafe { atexit(last) };
}

/// The folder of the project.
pub const PROJECT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// A folder or file of the project.
pub fn project(path: &str) -> PathBuf {
    Path::new(PROJECT).join(path)
}

/// Loads a scene of the project.
pub fn scene_as_it_is(path: &str) -> Scene {
    load(&project(path), &LoadOptions::default()).unwrap()
}

/// Loads a scene of the project, with the independent samples, as many for each pixel, that most
/// tests of chance rest on; tests of other samplers and of adaptive sampling say so.
pub fn scene(path: &str) -> Scene {
    let mut scene = scene_as_it_is(path);
    scene.render.estimator.sampler = Sampler::Independent;
    scene.render.estimator.adaptive = false;
    scene.render.estimator.shadow_rays = ShadowRays::Number(1);
    scene
}

/// A file or folder of `../shared`, beside the checkout. Where it is missing this says so, past the
/// test harness, which would swallow it, and gives `None`.
pub fn shared(name: &str) -> Option<PathBuf> {
    use std::io::Write;
    let path = project("../shared").join(name);
    if path.exists() {
        return Some(path);
    }
    let test = std::thread::current().name().unwrap_or("a test").to_owned();
    let sentence = format!(
        "SKIPPED: {test} needs {}, which is missing\n",
        path.display()
    );
    std::io::stderr()
        .write_all(sentence.as_bytes())
        .expect("stderr takes a line");
    None
}

/// Every scene of `scenes/` that needs nothing from outside the project.
pub fn own_scenes() -> Vec<(String, Scene)> {
    let mut names: Vec<_> = std::fs::read_dir(project("scenes"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| name.ends_with(".toml") && !NEEDS_ASSETS.contains(&name.as_str()))
        .collect();
    names.sort();
    assert!(!names.is_empty());
    let load = |name: String| (name.clone(), scene(&format!("scenes/{name}")));
    names.into_iter().map(load).collect()
}

/// Those of them that differ in how they are lit; the others show cameras and materials.
pub fn scenes_of_lights() -> Vec<(String, Scene)> {
    let names = [
        "corner.toml",
        "cornell.toml",
        "spot_and_sun.toml",
        "veach.toml",
    ];
    let load = |name: &str| (name.to_owned(), scene(&format!("scenes/{name}")));
    names.map(load).into()
}

/// Scenes whose models and maps the user has to bring.
pub const NEEDS_ASSETS: [&str; 2] = ["bunny.toml", "helmet.toml"];

/// `scene` made ready with its own settings.
pub fn prepared(scene: Scene) -> Prepared {
    Prepared::of(scene)
}

/// `scene` made ready for `strategy` with lights chosen by `selection`.
pub fn prepared_for(mut scene: Scene, strategy: Strategy, selection: LightSelection) -> Prepared {
    scene.render.estimator.strategy = strategy;
    scene.render.estimator.light_selection = selection;
    Prepared::of(scene)
}

/// Renders `scene` with its own settings.
pub fn render(context: &Context, scene: Scene) -> Film {
    render_prepared(context, &prepared(scene))
}

/// Renders a prepared scene by its own settings.
pub fn render_prepared(context: &Context, prepared: &Prepared) -> Film {
    let (film, settings) = (prepared.film, prepared.settings);
    let mut session = Session::new(context, prepared, film, settings.seed).unwrap();
    take(&mut session, settings.stop.spp);
    session.snapshot().unwrap().0
}

/// Takes every pixel to `spp` samples.
pub fn take(session: &mut Session<'_>, spp: u64) {
    while session.samples() < spp {
        let samples = session.pass_samples(spp - session.samples());
        assert_eq!(session.pass(samples, || false).unwrap(), StopReason::Done);
    }
}

/// A Lambert material, both of its sides.
pub fn lambert(reflectance: f64) -> Material {
    let bsdf = Bsdf::Lambert {
        reflectance: DVec3::splat(reflectance),
    };
    Material::new("lambert", bsdf)
}

/// A shape of material 0 that does not emit.
pub fn shape(name: &str, geometry: Geometry) -> Shape {
    Shape {
        name: name.to_owned(),
        geometry,
        material: MaterialId(0),
        emission: None,
    }
}

/// A shape of material 0 that emits `radiance`.
pub fn emitter(geometry: Geometry, radiance: f64, two_sided: bool) -> Shape {
    Shape {
        emission: Some(Emission {
            texture: None,
            radiance: DVec3::splat(radiance),
            two_sided,
        }),
        ..shape("light", geometry)
    }
}

/// A unit square at height 1 over the origin whose front faces down.
pub fn unit_square() -> Geometry {
    Geometry::Rectangle {
        corner: DVec3::new(-0.5, -0.5, 1.0),
        u: DVec3::new(0.0, 1.0, 0.0),
        v: DVec3::new(1.0, 0.0, 0.0),
    }
}

/// One pixel that sees the origin of the plane z = 0 (normal +z, Lambert with ρ = ½), so small that
/// what it sees does not vary; a square of side 20 around the origin stands for the plane.
pub fn floor_pixel() -> Scene {
    let floor = Geometry::Rectangle {
        corner: DVec3::new(-10.0, -10.0, 0.0),
        u: DVec3::new(20.0, 0.0, 0.0),
        v: DVec3::new(0.0, 20.0, 0.0),
    };
    Scene {
        source: PathBuf::from("floor pixel"),
        camera: Camera::look_at(DVec3::new(1.0, -3.0, 2.0), DVec3::ZERO, DVec3::Z, 1e-5).unwrap(),
        film: FilmSize {
            width: 1,
            height: 1,
        },
        materials: vec![lambert(0.5)],
        shapes: vec![shape("floor", floor)],
        render: RenderSettings {
            estimator: EstimatorSettings {
                sampler: Sampler::Independent,
                adaptive: false,
                shadow_rays: ShadowRays::Number(1),
                ..EstimatorSettings::default()
            },
            stop: StopSettings {
                spp: 16,
                ..StopSettings::default()
            },
            ..RenderSettings::default()
        },
        ..Scene::default()
    }
}

/// A point light.
pub fn point_light(position: DVec3, intensity: f64) -> Light {
    Light::Point(PointLight {
        position,
        intensity: DVec3::splat(intensity),
    })
}

/// Asserts that the one pixel of `film` is `expected` in every channel, as tests of the family with
/// the pixel's own standard error and a relative 2e-5 of f32 rounding.
pub fn assert_pixel(film: &Film, expected: f64, what: &str) {
    let pixel = &film.pixels[0];
    let error = pixel.variance_of_mean().expect("two samples or more");
    assert_eq!(film.ledger.dropped, 0, "{what}: non-finite samples");
    for (c, variance) in error.into_iter().enumerate() {
        let test = z_test(pixel.mean[c], expected, variance, 2e-5 * expected.abs());
        let found = pixel.mean[c];
        statistics::accept(
            test.p_value,
            &format!("{what}, channel {c}: {found} for {expected}"),
        );
    }
}

/// Points of the unit square that samplers are tested on: all pairs of 0, 2⁻²⁴, ½ ∓ 2⁻²⁴, ½, 1 −
/// 2⁻²⁴ and a few more, and 1,000 of a lattice.
pub fn edge_points() -> Vec<glam::DVec2> {
    let tiny = (-24_f64).exp2();
    let edges = [
        0.0,
        tiny,
        0.25,
        0.5 - tiny,
        0.5,
        0.5 + tiny,
        0.75,
        1.0 - tiny,
    ];
    let pairs = edges
        .iter()
        .flat_map(|x| edges.iter().map(|y| glam::DVec2::new(*x, *y)));
    // R2 lattice (Roberts 2018), rounded to what the shaders draw.
    let round = |x: f64| (x.fract() / tiny).floor() * tiny;
    let lattice = (1..=1000).map(|i| {
        let i = f64::from(i);
        glam::DVec2::new(
            round(0.754_877_666_246_692_8 * i),
            round(0.569_840_290_998_053_3 * i),
        )
    });
    pairs.chain(lattice).collect()
}
