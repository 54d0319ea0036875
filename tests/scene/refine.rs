//! Large shapes of extreme scenes are cut: into the same points with the same attributes.

use super::files::Folder;
use crate::support::{floor_pixel, shape};
use direkt::scene::normalize::Normalization;
use direkt::scene::refine::refine;
use direkt::scene::texture::{disk_uv, rectangle_uv};
use direkt::scene::{Emission, Geometry, Mesh, Shape};
use glam::{DVec2, DVec3, Vec4};
use std::collections::HashMap;

/// Half the side or the radius of what is cut.
const LARGE: f64 = 1e8;

/// `geometry`, before the camera that sees the origin, as it is cut; everything else about its
/// shape stays.
fn refined(geometry: Geometry) -> Mesh {
    let mut scene = floor_pixel();
    let before = Shape {
        emission: Some(Emission {
            radiance: DVec3::new(1.0, 2.0, 3.0),
            texture: None,
            two_sided: false,
        }),
        ..shape("floor", geometry)
    };
    scene.shapes = vec![before.clone()];
    let normalization = Normalization::of(&scene);
    assert!(normalization.is_extreme());
    refine(&mut scene, &normalization);
    let after = scene.shapes.remove(0);
    let Geometry::Mesh(mesh) = after.geometry.clone() else {
        panic!("not cut: {:?}", after.geometry);
    };
    let geometry = after.geometry.clone();
    assert_eq!(Shape { geometry, ..before }, after);
    assert!(mesh.triangles.len() > 100, "{}", mesh.triangles.len());
    mesh
}

/// The mesh lies in the plane z = 0 and faces up, and its triangles cover a region of `area`, up to
/// the part `inexact`, once: none is turned, and every edge is either one of two triangles or on
/// the border.
fn assert_covers(mesh: &Mesh, (area, inexact): (f64, f64), on_border: impl Fn(DVec2) -> bool) {
    let corners = |t: &[u32; 3]| t.map(|i| mesh.positions[i as usize].truncate());
    let areas = mesh.triangles.iter().map(|t| {
        let [a, b, c] = corners(t);
        0.5 * (b - a).perp_dot(c - a)
    });
    let areas: Vec<f64> = areas.collect();
    assert!(areas.iter().all(|&area| area > 0.0));
    let found: f64 = areas.iter().sum();
    assert!(
        (found / area - 1.0).abs() <= inexact,
        "{found:e} of {area:e}"
    );
    let bits = |p: DVec2| p.to_array().map(f64::to_bits);
    let mut edges = HashMap::new();
    for t in &mesh.triangles {
        let [a, b, c] = corners(t);
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *edges.entry((bits(from), bits(to))).or_insert(0) += 1;
        }
    }
    for (&(from, to), &count) in &edges {
        assert_eq!(count, 1, "an edge of two triangles on the same side");
        let ends = [from, to].map(|p| DVec2::from_array(p.map(f64::from_bits)));
        let inside = edges.contains_key(&(to, from));
        assert!(
            inside || ends.into_iter().all(&on_border),
            "{ends:?}: a gap"
        );
    }
    assert!(mesh.positions.iter().all(|p| p.z == 0.0));
}

fn on_square(p: DVec2) -> bool {
    p.abs().max_element() == LARGE
}

#[test]
fn a_cut_rectangle_is_the_same_rectangle() {
    let mesh = refined(Geometry::Rectangle {
        corner: DVec3::new(-LARGE, -LARGE, 0.0),
        u: DVec3::X * (2.0 * LARGE),
        v: DVec3::Y * (2.0 * LARGE),
    });
    assert_covers(&mesh, (4.0 * LARGE * LARGE, 1e-12), on_square);
    for (p, uv) in mesh.positions.iter().zip(&mesh.uvs) {
        let expected = rectangle_uv(p.truncate() / (2.0 * LARGE) + 0.5);
        assert!((*uv - expected).length() < 1e-15, "{p}: {uv}");
    }
}

/// Attributes are what interpolation over the two triangles gives at the same point; normals that
/// differ by more than a right angle, too.
#[test]
fn a_cut_mesh_has_its_attributes_at_the_same_points() {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let whole = Mesh {
        positions: corners.map(|(x, y)| LARGE * DVec3::new(x, y, 0.0)).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        normals: vec![
            DVec3::X,
            DVec3::Y * 2.0,
            DVec3::Z,
            DVec3::new(-3.0, 0.0, 0.1),
        ],
        uvs: corners.map(|(x, y)| DVec2::new(3.0 * x + y, y)).to_vec(),
        second_uvs: corners.map(|(x, y)| DVec2::new(x, x * y)).to_vec(),
        colors: corners
            .map(|(x, y)| Vec4::new(x as f32, y as f32, (x * y) as f32, 1.0))
            .to_vec(),
        ..Mesh::default()
    };
    let mesh = refined(Geometry::Mesh(whole.clone()));
    assert_covers(&mesh, (4.0 * LARGE * LARGE, 1e-12), on_square);
    for (index, p) in mesh.positions.iter().enumerate() {
        let st = p.truncate() / (2.0 * LARGE) + 0.5;
        // Triangle (0, 1, 2) holds s ≥ t, and (0, 2, 3) the rest.
        let (indices, weights) = if st.x >= st.y {
            ([0, 1, 2], [1.0 - st.x, st.x - st.y, st.y])
        } else {
            ([0, 2, 3], [1.0 - st.y, st.x, st.y - st.x])
        };
        let weighted = |i: usize| (indices[i], weights[i]);
        let uv: DVec2 = (0..3).map(weighted).map(|(i, w)| w * whole.uvs[i]).sum();
        let second: DVec2 = (0..3)
            .map(weighted)
            .map(|(i, w)| w * whole.second_uvs[i])
            .sum();
        let color: Vec4 = (0..3)
            .map(weighted)
            .map(|(i, w)| w as f32 * whole.colors[i])
            .sum();
        let normal: DVec3 = (0..3)
            .map(weighted)
            .map(|(i, w)| w * whole.normals[i].normalize())
            .sum();
        assert!((mesh.uvs[index] - uv).length() < 1e-14);
        assert!((mesh.second_uvs[index] - second).length() < 1e-14);
        assert!((mesh.colors[index] - color).length() < 1e-5);
        let found = mesh.normals[index].normalize();
        assert!(
            (found - normal.normalize()).length() < 1e-12,
            "{p}: {found}"
        );
    }
}

/// Around the view, and with its border through the view: the chords of the border lie within 2⁻¹⁶
/// of what is in view there, or of the distance.
#[test]
fn a_cut_disk_is_the_same_disk() {
    for center in [DVec2::ZERO, DVec2::X * LARGE] {
        let mesh = refined(Geometry::Disk {
            center: center.extend(0.0),
            u: DVec3::X * LARGE,
            v: DVec3::Y * LARGE,
        });
        let on_border = |p: DVec2| ((p - center).length() / LARGE - 1.0).abs() < 1e-14;
        let area = std::f64::consts::PI * LARGE * LARGE;
        assert_covers(&mesh, (area, 1e-4), on_border);
        for (p, uv) in mesh.positions.iter().zip(&mesh.uvs) {
            let expected = disk_uv((p.truncate() - center) / LARGE);
            assert!((*uv - expected).length() < 1e-15, "{p}: {uv}");
        }
        let eye = floor_pixel().camera.eye;
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|i| mesh.positions[i as usize].truncate());
            for (a, b) in [(a, b), (b, c), (c, a)] {
                if on_border(a) && on_border(b) {
                    let middle = 0.5 * (a + b);
                    let off = LARGE - (middle - center).length();
                    let distance = middle.length().max(eye.length());
                    assert!(off < distance / 65_536.0, "{off} at {distance}");
                }
            }
        }
    }
}

/// A pile of large triangles, too many to cut all of them, is named.
#[test]
fn what_stays_coarse_is_named() {
    let pile = |layers: u32| {
        let layer =
            |i: u32| format!("v -1e8 -1e8 -{i}\nv 1e8 -1e8 -{i}\nv 0 1e8 -{i}\nf -3 -2 -1\n");
        let folder = Folder::new();
        folder.write("pile.obj", (0..layers).map(layer).collect::<String>());
        let text = "[environment]\nradiance = 1\n[camera]\neye = [0, 0, 3]\ntarget = [0, 0, 0]\nup = [0, 1, 0]\nfov = 40\n\
                    [[shapes]]\ntype = \"mesh\"\nfile = \"pile.obj\"\n";
        folder.write("scene.toml", text);
        folder.load("scene.toml").expect("a valid scene").warnings
    };
    assert_eq!(pile(3), [""; 0]);
    let warnings = pile(2000);
    assert_eq!(warnings.len(), 1);
    assert!(
        warnings[0].starts_with("shapes[0]: too many of its triangles are large"),
        "{}",
        warnings[0]
    );
}
