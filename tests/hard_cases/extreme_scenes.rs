//! Renders of scenes that are much larger than what is in view: each part of them shows and shines
//! as it does alone.

use crate::support::every_kind::constant_environment;
use crate::support::{
    KINDS_OF_STRATEGIES, assert_pixel, context, emitter, floor_pixel, lambert, prepared, render,
    render_prepared, shape, statistics,
};
use direkt::low_level::gpu::Context;
use direkt::low_level::render::Film;
use direkt::low_level::stats::z_test::z_test;
use direkt::scene::environment::Interpolation;
use direkt::scene::{
    Camera, EnvironmentRadiance, FilmSize, Geometry, Mesh, Projection, Scene, Shape, Strategy,
    Texels, Texture, TextureId, TextureUse, Wrap,
};
use glam::{DAffine2, DVec2, DVec3};
use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// What lies far away.
const FAR: f64 = 1e8;
/// Radiance of the lights.
const RADIANCE: f64 = 5.0;

/// The pixel of a floor of reflectance ½, and `shapes`.
fn floor_and(shapes: Vec<Shape>) -> Scene {
    let mut scene = floor_pixel();
    scene.shapes.extend(shapes);
    scene.render.stop.spp = 1 << 13;
    scene
}

/// Renders `scene`, which has to be extreme, and compares its pixel.
fn assert_extreme(context: &Context, scene: Scene, expected: f64, what: &str) {
    let prepared = prepared(scene);
    assert!(prepared.data.normalization.is_extreme(), "{what}");
    assert_eq!(prepared.data.scene.warnings, [""; 0], "{what}");
    let film = render_prepared(context, &prepared);
    assert_pixel(&film, expected, what);
}

/// A sphere above the floor at `distance` whose radius is this part of it: the floor sees the
/// square of that part of the sky, weighted by cosines.
fn ball(distance: f64, part: f64) -> Geometry {
    Geometry::Sphere {
        center: DVec3::Z * distance,
        radius: part * distance,
    }
}

fn lamp() -> Shape {
    emitter(ball(FAR, 0.3), RADIANCE, false)
}

/// Part of a floor's sky, weighted by cosines, that a square fills above its middle whose side is
/// twice its height.
fn sky_of_square() -> f64 {
    4.0 / PI * FRAC_1_SQRT_2 * FRAC_1_SQRT_2.atan()
}

/// The rectangle between two opposite corners with the same z.
fn level(low: [f64; 2], high: [f64; 2], z: f64) -> Geometry {
    let [low, high] = [low, high].map(DVec2::from_array);
    Geometry::Rectangle {
        corner: low.extend(z),
        u: DVec3::X * (high.x - low.x),
        v: DVec3::Y * (high.y - low.y),
    }
}

/// What the floor reflects of a lamp at 10⁸, of radius 3·10⁷: ½ · 5 · 0.3²; of half of it behind an
/// edge 1 above the floor; none behind a plate that is as large as the lamp seems at 1 above the
/// floor, or behind a ball at 10⁷; what is left around a smaller ball.
#[test]
fn a_lamp_far_away_shines_and_is_hidden_by_what_is_near() {
    let context = context();
    let whole = 0.5 * RADIANCE;
    let edge = shape("edge", level([-10.0, -10.0], [0.0, 10.0], 1.0));
    let plate = shape("plate", level([-0.33, -0.33], [0.33, 0.33], 1.0));
    for (what, hides, seen) in [
        ("nothing", None, 0.09),
        ("an edge", Some(edge), 0.045),
        ("a plate", Some(plate), 0.0),
        ("a ball", Some(shape("ball", ball(1e7, 0.31))), 0.0),
        ("a ring", Some(shape("ball", ball(1e7, 0.2))), 0.09 - 0.04),
    ] {
        let mut shapes = vec![lamp()];
        shapes.extend(hides);
        let scene = floor_and(shapes);
        assert_extreme(
            context,
            scene,
            whole * seen,
            &format!("{what} before a lamp"),
        );
    }
}

/// The same through parallel rays, and through a wide view of which one pixel is in the middle.
#[test]
fn a_lamp_far_away_shines_before_every_camera() {
    let context = context();
    let eye = DVec3::new(1.0, -3.0, 2.0);
    let parallel = Projection::Orthographic { height: 1e-3 };
    for (what, projection, width) in [
        ("parallel", parallel, 1),
        ("wide", Projection::Perspective { fov_y: 0.9 }, 5),
    ] {
        let mut scene = floor_and(vec![lamp()]);
        scene.camera = Camera {
            projection,
            ..Camera::look_at(eye, DVec3::ZERO, DVec3::Z, 1.0).unwrap()
        };
        (scene.film.width, scene.film.height) = (width, width);
        let expected = 0.5 * RADIANCE * 0.09;
        assert!(prepared(scene.clone()).data.normalization.is_extreme());
        let mut film = render(context, scene);
        film.pixels = vec![film.pixels[film.pixels.len() / 2]];
        assert_pixel(&film, expected, &format!("{what} rays"));
    }
}

/// A sphere before a disk before a square whose half side is its height, all equally bright: the
/// floor sees what it would see of the square, of which each hides a part (Lambert's formula, with
/// atan(1/√2)).
#[test]
fn far_lamps_of_every_shape_shine_under_every_kind_of_strategy() {
    let context = context();
    let disk = Geometry::Disk {
        center: DVec3::Z * (2.0 * FAR),
        u: DVec3::Y * (1.2 * FAR),
        v: DVec3::X * (1.2 * FAR),
    };
    let square = Geometry::Rectangle {
        corner: DVec3::new(-4.0, -4.0, 4.0) * FAR,
        u: DVec3::Y * (8.0 * FAR),
        v: DVec3::X * (8.0 * FAR),
    };
    let lamps = [disk, square].map(|lamp| emitter(lamp, RADIANCE, false));
    for strategy in KINDS_OF_STRATEGIES {
        let mut scene = floor_and([vec![lamp()], lamps.to_vec()].concat());
        scene.render.estimator.strategy = strategy;
        let expected = 0.5 * RADIANCE * sky_of_square();
        assert_extreme(context, scene, expected, &format!("{strategy}"));
    }
}

/// A square of two triangles, 4 away from its middle in units of up to 10¹², by its solid angle:
/// products of eight of its lengths are no numbers of f32 there.
#[test]
fn far_triangles_shine_when_sampled_by_solid_angle() {
    let context = context();
    let corners = [[-4.0, -4.0], [-4.0, 4.0], [4.0, 4.0], [4.0, -4.0]];
    for far in [1e6, 1e12] {
        let corner = |[x, y]: [f64; 2]| DVec3::new(x, y, 4.0) * far;
        let square = Geometry::Mesh(Mesh {
            positions: corners.map(corner).to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        });
        for strategy in [
            Strategy::LightSolidAngle,
            Strategy::LightProjectedSolidAngle,
        ] {
            let mut scene = floor_and(vec![emitter(square.clone(), RADIANCE, false)]);
            scene.render.estimator.strategy = strategy;
            let expected = 0.5 * RADIANCE * sky_of_square();
            assert_extreme(context, scene, expected, &format!("{far:e}, {strategy}"));
        }
    }
}

/// A disk of radius R at height h fills R²/(R² + h²) of the floor's sky, weighted by cosines: half
/// where it is as far away as its radius, all of it near. A light that shines upwards does not
/// shine on the floor below.
#[test]
fn ceilings_of_any_size_shine() {
    let context = context();
    let disk = |height: f64, radius: f64| Geometry::Disk {
        center: DVec3::Z * height,
        u: DVec3::Y * radius,
        v: DVec3::X * radius,
    };
    let whole = 0.5 * RADIANCE;
    let up = level([-FAR, -FAR], [FAR, FAR], 4.0);
    let down = Geometry::Rectangle {
        corner: DVec3::new(-FAR, -FAR, 4.0),
        u: DVec3::Y * (2.0 * FAR),
        v: DVec3::X * (2.0 * FAR),
    };
    for (what, geometry, expected) in [
        ("far disk", disk(1e7, 1e7), 0.5 * whole),
        ("near disk", disk(4.0, 1e7), whole),
        ("rectangle", down, whole),
        ("rectangle upside down", up, 0.0),
    ] {
        let mut scene = floor_and(vec![emitter(geometry, RADIANCE, false)]);
        scene.materials[0].double_sided = false;
        assert_extreme(context, scene, expected, what);
    }
}

/// A wall behind the floor's point that reaches from 10⁸ left to 10⁸ right, 10⁸ high, hides half of
/// the sky.
#[test]
fn a_wall_hides_half_of_the_sky() {
    let wall = Geometry::Rectangle {
        corner: DVec3::new(-FAR, 1.0, 0.0),
        u: DVec3::X * (2.0 * FAR),
        v: DVec3::Z * FAR,
    };
    let mut scene = floor_and(vec![shape("wall", wall)]);
    let mut sky = constant_environment();
    sky.radiance = EnvironmentRadiance::Constant(DVec3::ONE);
    scene.environment = Some(sky);
    // A wall at the distance a hides ½ of the sky.
    assert_extreme(context(), scene, 0.25, "a wall before the sky");
}

/// Where a floor of 2·10⁸ is covered by tiles of 2, each point shows its own tile's texel.
#[test]
fn a_huge_floor_has_its_texture() {
    let context = context();
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let corners = corners.map(DVec2::from);
    let floor = Mesh {
        positions: corners.map(|p| (FAR * p).extend(0.0)).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        uvs: corners.map(|p| 0.5 * FAR * p).to_vec(),
        ..Mesh::default()
    };
    for (x, reflectance) in [(0.3, 0.2), (1.7, 0.6), (300.3, 0.2), (-300.3, 0.6)] {
        let mut scene = floor_and(vec![lamp()]);
        scene.shapes[0].geometry = Geometry::Mesh(floor.clone());
        let at = DVec3::new(x, 0.4, 0.0);
        let eye = at + DVec3::new(1.0, -3.0, 2.0);
        scene.camera = Camera::look_at(eye, at, DVec3::Z, 1e-5).unwrap();
        scene.textures = vec![Texture {
            source: "texels".to_owned(),
            width: 2,
            height: 1,
            texels: Texels::Bytes([51, 153].map(|c| [c, c, c, 255]).to_vec()),
        }];
        let mut material = lambert(1.0);
        material.textures.color = Some(TextureUse {
            texture: TextureId(0),
            transform: DAffine2::IDENTITY,
            wrap: [Wrap::Repeat; 2],
            interpolation: Interpolation::Nearest,
            second_uvs: false,
        });
        scene.materials = vec![material];
        let expected = reflectance * RADIANCE * 0.09;
        assert_extreme(context, scene, expected, &format!("the tile at {x}"));
    }
}

/// A square lamp of side 2 that is 2 above a floor, as large as is said.
pub(crate) fn room(half_side: f64) -> Scene {
    let mut scene = floor_pixel();
    let lamp = Geometry::Rectangle {
        corner: DVec3::new(-1.0, -1.0, 2.0),
        u: DVec3::Y * 2.0,
        v: DVec3::X * 2.0,
    };
    let floor = level([-half_side; 2], [half_side; 2], 0.0);
    scene.shapes = vec![shape("floor", floor), emitter(lamp, RADIANCE, false)];
    let (eye, target) = (DVec3::new(0.0, -4.0, 1.0), DVec3::Z * 0.5);
    scene.camera = Camera::look_at(eye, target, DVec3::Z, 40_f64.to_radians()).unwrap();
    scene.film = FilmSize {
        width: 8,
        height: 8,
    };
    scene.materials = vec![lambert(0.7)];
    scene.render.stop.spp = 1 << 10;
    scene
}

/// Asserts that the pixels of two films have the same means, and so the images.
fn assert_alike(film: &Film, other: &Film, what: &str) {
    for (index, (a, b)) in film.pixels.iter().zip(&other.pixels).enumerate() {
        let [va, vb] = [a, b].map(|p| p.variance_of_mean().expect("two samples or more")[0]);
        let test = z_test(a.mean[0], b.mean[0], va + vb, 2e-5 * b.mean[0]);
        let means = (a.mean[0], b.mean[0]);
        statistics::accept(test.p_value, &format!("{what}, pixel {index}: {means:?}"));
    }
    let [ea, eb] = [film, other].map(|f| f.standard_error_of_mean().expect("samples")[0]);
    let [a, b] = [film, other].map(|f| f.mean()[0]);
    let test = z_test(a, b, ea * ea + eb * eb, 2e-5 * b);
    statistics::accept(test.p_value, &format!("{what}: {a} for {b}"));
}

/// A box far above changes nothing. Of a floor of 2·10⁸ no more is lit than of one of 2,000: of the
/// lamp's light one part in 10⁶ goes beyond.
#[test]
fn a_room_is_as_it_is_beside_what_is_far_and_on_a_huge_floor() {
    let context = context();
    let ordinary = room(1e3);
    assert!(!prepared(ordinary.clone()).data.normalization.is_extreme());
    let expected = render(context, ordinary.clone());
    let mut beside = ordinary;
    for height in [FAR, 1.001 * FAR] {
        let plate = level([-3e4; 2], [3e4; 2], height);
        beside.shapes.push(shape("plate", plate));
    }
    for (what, mut scene) in [("beside a box", beside), ("on a huge floor", room(FAR))] {
        assert!(prepared(scene.clone()).data.normalization.is_extreme());
        scene.render.seed = 1;
        let film = render(context, scene);
        assert_alike(&film, &expected, what);
    }
}
