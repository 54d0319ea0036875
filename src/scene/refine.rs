//! Cuts what is large beside its distance from the centre of an extreme scene.
//!
//! In f32 a primitive is as exact as its largest coordinate allows. A floor of 10⁸ under the camera
//! would be off by several units there. Cut into triangles, each about as large as it is far away,
//! it is exact as far as the camera can see.

use super::normalize::Normalization;
use super::texture::{disk_uv, rectangle_uv};
use super::{Geometry, Mesh, Scene};
use glam::{DVec2, DVec3};
use std::collections::HashMap;

/// A triangle's largest coordinate over its distance from the centre, at most.
const COARSENESS: f64 = 16.0;
/// How far the chords of a disk's border may lie off it, over their distance from the centre.
const ROUNDNESS: f64 = 1.0 / 65_536.0;
/// Times that a triangle is halved at most: f64 has no more binary digits than twice this.
const MAX_ROUNDS: usize = 128;
/// Triangles that a shape is cut into at most, beside those that it has.
const MAX_ADDED: usize = 1 << 15;
/// Longest edge of a triangle over its coordinates below which f64 has no digits left to cut it by.
const RESOLUTION: f64 = 1.0 / (1_u64 << 40) as f64;

/// Replaces shapes of `scene` by finer meshes of the same points, where `normalization` calls for
/// it. Spheres stay.
pub fn refine(scene: &mut Scene, normalization: &Normalization) {
    let near = Near::of(normalization);
    for shape in &mut scene.shapes {
        if let Some(mesh) = near.refined(&shape.geometry) {
            shape.geometry = Geometry::Mesh(mesh);
        }
    }
}

/// Names of the shapes of `scene` of which parts stay too coarse, as cutting them would take too
/// many triangles.
pub fn coarse_shapes<'a>(scene: &'a Scene, normalization: &Normalization) -> Vec<&'a str> {
    let near = Near::of(normalization);
    let is_coarse = |geometry: &Geometry| {
        let refined = near.refined(geometry);
        refined.is_some_and(|mesh| near.is_coarse_anywhere(&mesh))
    };
    let coarse = scene
        .shapes
        .iter()
        .filter(|shape| is_coarse(&shape.geometry));
    coarse.map(|shape| shape.field()).collect()
}

/// What has to be fine: lengths beside the distance from the centre, and none below the radius.
struct Near {
    center: DVec3,
    radius: f64,
}

impl Near {
    fn of(normalization: &Normalization) -> Self {
        Self {
            center: normalization.center,
            radius: normalization.radius / normalization.scale,
        }
    }

    /// `geometry` cut; `None` where that is not needed.
    fn refined(&self, geometry: &Geometry) -> Option<Mesh> {
        let (mesh, disk) = match geometry {
            Geometry::Sphere { .. } | Geometry::Ellipsoid { .. } => return None,
            Geometry::Mesh(mesh) if self.is_coarse_anywhere(mesh) => (mesh.clone(), None),
            Geometry::Mesh(_) => return None,
            Geometry::Rectangle { corner, u, v } => (of_rectangle(*corner, *u, *v), None),
            Geometry::Disk { center, u, v } => {
                let disk = Disk {
                    center: *center,
                    u: *u,
                    v: *v,
                };
                (disk.mesh(), Some(disk))
            }
        };
        if !self.is_coarse_anywhere(&mesh) {
            return None;
        }
        let most = mesh.triangles.len() + MAX_ADDED;
        let mut cut = Cut::new(mesh, disk);
        for _ in 0..MAX_ROUNDS {
            if cut.mesh.triangles.len() > most || !cut.round(self) {
                break;
            }
        }
        Some(cut.mesh)
    }

    fn is_coarse_anywhere(&self, mesh: &Mesh) -> bool {
        mesh.triangles.iter().any(|t| self.is_coarse(mesh, t))
    }

    fn is_coarse(&self, mesh: &Mesh, triangle: &[u32; 3]) -> bool {
        let corners = triangle.map(|i| mesh.positions[i as usize]);
        let [a, b, c] = corners.map(|p| p - self.center);
        let coordinates = corners.map(|p| p.abs().max_element());
        let longest = (b - a).abs().max((c - a).abs()).max((c - b).abs());
        if longest.max_element() <= RESOLUTION * coordinates.into_iter().fold(0.0, f64::max) {
            return false;
        }
        let reach = a.abs().max(b.abs()).max(c.abs()).max_element();
        reach > COARSENESS * self.radius
            && reach > COARSENESS * nearest_of_triangle([a, b, c]).length()
    }

    /// Whether the chord from `a` to `b` lies too far off the arc, whose middle is `middle`.
    fn is_off(&self, [a, b, middle]: [DVec3; 3]) -> bool {
        let off = (0.5 * (a + b) - middle).length();
        let distance = (middle - self.center).length() - (b - a).length();
        off > ROUNDNESS * distance.max(self.radius)
    }
}

/// A mesh that is being cut.
struct Cut {
    mesh: Mesh,
    /// The vertex that stands for all at the same place: neighbours are cut alike even where they
    /// share none.
    place: Vec<u32>,
    /// Of a disk: itself, and where its vertices lie on it.
    disk: Option<(Disk, Vec<OnDisk>)>,
}

impl Cut {
    fn new(mut mesh: Mesh, disk: Option<Disk>) -> Self {
        // Between them they are interpolated as unit vectors, and what comes of it is not
        // normalised before the last.
        for normal in &mut mesh.normals {
            *normal = normal.normalize_or_zero();
        }
        let mut first = HashMap::new();
        let place = (0..).zip(&mesh.positions);
        let place = place.map(|(i, p)| *first.entry(p.to_array().map(f64::to_bits)).or_insert(i));
        Self {
            place: place.collect(),
            disk: disk.map(|d| (d, Disk::VERTICES.to_vec())),
            mesh,
        }
    }

    /// Cuts every triangle that is too coarse in four, and its neighbours as their edges call for
    /// it; whether there was any.
    fn round(&mut self, near: &Near) -> bool {
        let mut marked: HashMap<[u32; 2], HashMap<[u32; 2], u32>> = HashMap::new();
        for t in &self.mesh.triangles {
            let coarse = near.is_coarse(&self.mesh, t);
            for edge in edges(*t) {
                if coarse || self.is_off(near, edge) {
                    marked.entry(self.place_of(edge)).or_default();
                }
            }
        }
        if marked.is_empty() {
            return false;
        }
        let mut triangles = Vec::with_capacity(self.mesh.triangles.len());
        for t in std::mem::take(&mut self.mesh.triangles) {
            let middles = edges(t).map(|edge| {
                let of_place = marked.get_mut(&self.place_of(edge))?;
                let own = sorted(edge);
                let found = of_place.get(&own).copied();
                Some(found.unwrap_or_else(|| {
                    let middle = self.middle(edge, of_place.values().next().copied());
                    of_place.insert(own, middle);
                    middle
                }))
            });
            cut_triangle(t, middles, &mut triangles);
        }
        self.mesh.triangles = triangles;
        true
    }

    fn place_of(&self, edge: [u32; 2]) -> [u32; 2] {
        sorted(edge.map(|i| self.place[i as usize]))
    }

    /// Adds the vertex in the middle of an edge, at the place of `same` where that is given.
    fn middle(&mut self, [a, b]: [u32; 2], same: Option<u32>) -> u32 {
        let index = self.mesh.push_middle(a as usize, b as usize);
        if let Some((disk, vertices)) = &mut self.disk {
            let vertex = vertices[a as usize].middle(vertices[b as usize]);
            vertices.push(vertex);
            self.mesh.positions[index as usize] = disk.point(vertex);
            if let Some(uv) = self.mesh.uvs.last_mut() {
                *uv = disk_uv(vertex.st);
            }
        }
        self.place
            .push(same.map_or(index, |s| self.place[s as usize]));
        index
    }

    /// Whether an edge is a chord of a disk's border that is to be cut.
    fn is_off(&self, near: &Near, [a, b]: [u32; 2]) -> bool {
        let Some((disk, vertices)) = &self.disk else {
            return false;
        };
        let [a, b] = [a, b].map(|i| vertices[i as usize]);
        let places = [a, b, a.middle(b)].map(|vertex| disk.point(vertex));
        a.on_border && b.on_border && near.is_off(places)
    }
}

impl Mesh {
    /// Adds the vertex in the middle between two; returns its index.
    fn push_middle(&mut self, a: usize, b: usize) -> u32 {
        let Self {
            positions,
            triangles: _,
            normals,
            uvs,
            second_uvs,
            colors,
            tangents,
        } = self;
        let index = positions.len() as u32;
        positions.push(0.5 * (positions[a] + positions[b]));
        if !normals.is_empty() {
            normals.push(0.5 * (normals[a] + normals[b]));
        }
        for uvs in [uvs, second_uvs] {
            if !uvs.is_empty() {
                uvs.push(0.5 * (uvs[a] + uvs[b]));
            }
        }
        if !colors.is_empty() {
            colors.push(0.5 * (colors[a] + colors[b]));
        }
        if !tangents.is_empty() {
            tangents.push(0.5 * (tangents[a] + tangents[b]));
        }
        index
    }
}

fn edges([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// The parts of a triangle whose edges have the vertices `middles` in their middle, where they are
/// cut.
fn cut_triangle(t: [u32; 3], middles: [Option<u32>; 3], out: &mut Vec<[u32; 3]>) {
    let [a, b, c] = t;
    match middles {
        [None, None, None] => out.push(t),
        [Some(ab), None, None] => out.extend([[a, ab, c], [ab, b, c]]),
        [None, Some(bc), None] => out.extend([[a, b, bc], [a, bc, c]]),
        [None, None, Some(ca)] => out.extend([[a, b, ca], [ca, b, c]]),
        [Some(ab), Some(bc), None] => out.extend([[ab, b, bc], [a, ab, bc], [a, bc, c]]),
        [None, Some(bc), Some(ca)] => out.extend([[bc, c, ca], [b, bc, ca], [b, ca, a]]),
        [Some(ab), None, Some(ca)] => out.extend([[ca, a, ab], [c, ca, ab], [c, ab, b]]),
        [Some(ab), Some(bc), Some(ca)] => {
            out.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
    }
}

fn of_rectangle(corner: DVec3, u: DVec3, v: DVec3) -> Mesh {
    let coordinates = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
    Mesh {
        positions: coordinates.map(|st| corner + st.x * u + st.y * v).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        uvs: coordinates.map(rectangle_uv).to_vec(),
        ..Mesh::default()
    }
}

/// A disk, the points `center + s·u + t·v` with s² + t² ≤ 1.
struct Disk {
    center: DVec3,
    u: DVec3,
    v: DVec3,
}

/// A vertex of a disk's mesh.
#[derive(Clone, Copy)]
struct OnDisk {
    st: DVec2,
    on_border: bool,
}

impl OnDisk {
    /// Half way to `other`, on the border where both are.
    fn middle(self, other: Self) -> Self {
        let st = 0.5 * (self.st + other.st);
        let on_border = self.on_border && other.on_border;
        Self {
            st: if on_border { st.normalize() } else { st },
            on_border,
        }
    }
}

impl Disk {
    /// Those of [`mesh`](Self::mesh).
    const VERTICES: [OnDisk; 5] = {
        const fn border(st: DVec2) -> OnDisk {
            OnDisk {
                st,
                on_border: true,
            }
        }
        let center = OnDisk {
            st: DVec2::ZERO,
            on_border: false,
        };
        let [x, y] = [border(DVec2::X), border(DVec2::Y)];
        [center, x, y, border(DVec2::NEG_X), border(DVec2::NEG_Y)]
    };

    fn point(&self, vertex: OnDisk) -> DVec3 {
        self.center + vertex.st.x * self.u + vertex.st.y * self.v
    }

    fn mesh(&self) -> Mesh {
        Mesh {
            positions: Self::VERTICES.map(|vertex| self.point(vertex)).to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]],
            uvs: Self::VERTICES.map(|vertex| disk_uv(vertex.st)).to_vec(),
            ..Mesh::default()
        }
    }
}

/// The point of a triangle that is nearest to the origin (Ericson 2005, "Real-Time Collision
/// Detection", 5.1.5).
fn nearest_of_triangle([a, b, c]: [DVec3; 3]) -> DVec3 {
    let (u, v) = (b - a, c - a);
    let (ua, va) = (-u.dot(a), -v.dot(a));
    if ua <= 0.0 && va <= 0.0 {
        return a;
    }
    let (ub, vb) = (-u.dot(b), -v.dot(b));
    if ub >= 0.0 && vb <= ub {
        return b;
    }
    let (uc, vc) = (-u.dot(c), -v.dot(c));
    if vc >= 0.0 && uc <= vc {
        return c;
    }
    let of_c = ua * vb - ub * va;
    if of_c <= 0.0 && ua >= 0.0 && ub <= 0.0 {
        return a + u * (ua / (ua - ub));
    }
    let of_b = uc * va - ua * vc;
    if of_b <= 0.0 && va >= 0.0 && vc <= 0.0 {
        return a + v * (va / (va - vc));
    }
    let of_a = ub * vc - uc * vb;
    if of_a <= 0.0 && vb - ub >= 0.0 && uc - vc >= 0.0 {
        return b + (c - b) * ((vb - ub) / ((vb - ub) + (uc - vc)));
    }
    let sum = of_a + of_b + of_c;
    a + u * (of_b / sum) + v * (of_c / sum)
}
