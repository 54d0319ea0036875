//! Rays in scenes that are much larger than what is in view, and the grid of their boxes.

use super::hierarchy::distances_by_both_ways;
use super::meshes::triangle;
use crate::support::random::{Random, rounded};
use crate::support::{context, floor_pixel, prepared_for, shape};
use direkt::low_level::accel::grid::Grid;
use direkt::low_level::prepare::Prepared;
use direkt::scene::{Camera, Geometry, LightSelection, Mesh, Strategy};
use glam::{DVec2, DVec3};

/// Squares along each side of a wall.
const SQUARES: u32 = 24;

/// The parallelogram between `corner`, `corner + u` and `corner + v` in many triangles.
fn wall(corner: DVec3, u: DVec3, v: DVec3) -> Mesh {
    let side = SQUARES + 1;
    let at = |i: u32| f64::from(i) / f64::from(SQUARES);
    let positions = (0..side * side).map(|i| corner + at(i % side) * u + at(i / side) * v);
    let squares = (0..SQUARES * SQUARES).map(|i| i % SQUARES + i / SQUARES * side);
    Mesh {
        positions: positions.collect(),
        triangles: squares
            .flat_map(|a| [[a, a + 1, a + side], [a + 1, a + side + 1, a + side]])
            .collect(),
        ..Mesh::default()
    }
}

/// Unit vectors to a far wall and along it. Its coordinates along z are small beside the others,
/// and what is across a ray there is computed of all three.
const TO_WALL: DVec3 = DVec3::new(-0.6, -0.8, 0.0);
const ALONG_WALL: [DVec3; 2] = [DVec3::Z, DVec3::new(-0.8, 0.6, 0.0)];
/// Distances of the far walls, and half of their sides beside these.
const DISTANCES: [i32; 3] = [8, 14, 20];
const FAR_HALF_SIDE: f64 = 1.0 / 262_144.0;

/// A wall of side 2 around the origin, seen from (3, 0, 0), walls far behind it, and what makes the
/// scene extreme.
fn walls() -> Prepared {
    let mut scene = floor_pixel();
    scene.camera = Camera::look_at(DVec3::X * 3.0, DVec3::ZERO, DVec3::Z, 1.0).unwrap();
    let near = wall(DVec3::new(0.0, -1.0, -1.0), DVec3::Y * 2.0, DVec3::Z * 2.0);
    let mut meshes = vec![near];
    for exponent in DISTANCES {
        let distance = f64::from(exponent).exp2();
        let [u, v] = ALONG_WALL.map(|along| FAR_HALF_SIDE * distance * along);
        meshes.push(wall(distance * TO_WALL - u - v, 2.0 * u, 2.0 * v));
    }
    let far = DVec3::Z * 26_f64.exp2();
    meshes.push(triangle(far, far + DVec3::X, far + DVec3::Y));
    let shapes = meshes.into_iter().map(|m| shape("mesh", Geometry::Mesh(m)));
    scene.shapes = shapes.collect();
    prepared_for(scene, Strategy::LightArea, LightSelection::Uniform)
}

/// From where rays go to where in the scene of [`walls`], and which.
fn rays_to_walls(random: &mut Random) -> Vec<([DVec3; 2], String)> {
    let mut rays = Vec::new();
    let mut add = |random: &mut Random, what: String, ray: &dyn Fn(DVec3, DVec2) -> [DVec3; 2]| {
        for _ in 0..2000 {
            let at = random.in_cube().truncate();
            rays.push((ray(random.direction(), 0.8 * at), what.clone()));
        }
    };
    let near = |at: DVec2| DVec3::new(0.0, at.x, at.y);
    for exponent in [2, 8, 14, 17, 20] {
        let distance = f64::from(exponent).exp2();
        let what = format!("from 2^{exponent} to the near wall");
        add(random, what.clone(), &|from, at| {
            [distance * from, near(at)]
        });
        add(random, format!("straight {what}"), &|from, at| {
            [DVec3::new(distance, 1e-3 * from.x, 1e-3 * from.y), near(at)]
        });
    }
    for exponent in DISTANCES {
        let distance = f64::from(exponent).exp2();
        let [u, v] = ALONG_WALL.map(|along| FAR_HALF_SIDE * distance * along);
        let what = format!("from the eye to the wall at 2^{exponent}");
        add(random, what, &|from, at| {
            let eye = DVec3::new(3.0, 0.0, 1e-4 * from.z);
            [eye, distance * TO_WALL + at.x * u + at.y * v]
        });
    }
    rays
}

/// The hierarchy may lose nothing that the primitives by themselves do not: what rays meet is what
/// all primitives in turn give, bit for bit, from wherever they come. Closed walls let none
/// through: ray and vertices are off by some 2⁻²⁴ of a distance of at most 2²⁰, and the rays stay
/// 0.2 away from the near wall's border. (Of the far walls, vertices are as far off.)
#[test]
fn rays_from_far_and_to_far_hit_as_in_brute_force() {
    let context = context();
    let prepared = walls();
    let n = prepared.data.normalization;
    assert!(
        n.is_extreme() && prepared.data.bvh.grid.logarithmic,
        "{n:?}"
    );
    let rays = rays_to_walls(&mut Random::new(90));
    let inputs: Vec<f64> = rays
        .iter()
        .flat_map(|([from, to], _)| {
            let [from, to] = [from, to].map(|p| rounded(n.point(*p)));
            [from, rounded((to - from).normalize())]
        })
        .flat_map(|v| v.to_array())
        .collect();
    let distances = distances_by_both_ways(context, &prepared, &inputs);
    assert_eq!(distances.len(), rays.len());
    let found: Vec<_> = distances.into_iter().zip(&rays).collect();
    let unlike = found.iter().filter(|([t, nearest], _)| t != nearest);
    let mut unlike: Vec<_> = unlike.map(|(_, (_, what))| what).collect();
    let count = unlike.len();
    unlike.dedup();
    assert!(unlike.is_empty(), "{count} rays are unlike: {unlike:?}");
    for ([t, _], (_, what)) in found {
        assert!(t < 1e29 || what.contains("the wall at"), "{what}: a leak");
    }
}

/// The planes that a word of a logarithmic grid stands for, as the shader has them.
fn planes(word: u32) -> [f64; 2] {
    [word & 0xffff, word >> 16].map(|plane| {
        let magnitude = f64::from(f32::from_bits(((plane & 0x7fff) << 14) + 0x2000_0000));
        if plane & 0x8000 == 0 {
            magnitude
        } else {
            -magnitude
        }
    })
}

/// Every box lies within its rounded one, which is larger by no more than nine bits of its planes,
/// 2⁻²⁰ of its distance and 2⁻¹⁴ of the radius call for.
#[test]
fn boxes_of_the_logarithmic_grid_hold_what_they_are_around() {
    let mut random = Random::new(91);
    for (reach, radius) in [(1.0, 0.7), (3e7, 1.0), (1e9, 1e-15)] {
        let grid = Grid::logarithmic(reach, radius);
        let scale = f64::from(grid.scale.x);
        let mut length = || match random.word() % 4 {
            0 => 0.0,
            1 => 0.5 * reach * random.uniform(),
            _ => random.magnitude(1e-17, 0.5 * reach),
        };
        for i in 0..100_000 {
            let middle = [(); 3].map(|()| length() * [1.0, -1.0][i % 2]);
            let half = [(); 3].map(|()| length());
            let [middle, half] = [middle, half].map(DVec3::from_array);
            let [low, high] = [middle - half, middle + half].map(|p| p.as_vec3());
            let words = grid.box_words(low, high);
            let box_reach = f64::from(low.abs().max(high.abs()).max_element());
            for axis in 0..3 {
                let [below, above] = planes(words[axis]).map(|plane| plane / scale);
                let (low, high) = (f64::from(low[axis]), f64::from(high[axis]));
                assert!(
                    below <= low && high <= above,
                    "{below:e} {low:e} {high:e} {above:e}"
                );
                let most =
                    |x: f64| x.abs() / 256.0 + box_reach * 2e-6 + radius / 8192.0 + 1e-18 / scale;
                let wide = low - below > most(low) || above - high > most(high);
                assert!(!wide, "{below:e} {low:e} {high:e} {above:e}");
            }
        }
    }
}
