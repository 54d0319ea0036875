//! The camera of a scene that has none: the whole geometry fits the film.

use crate::scene::normalize::bounds;
use crate::scene::{Camera, FilmSize, Geometry, Lens, Material, Projection, Shape};
use glam::DVec3;

/// Vertical field of view of a framed camera, in degrees.
pub(super) const FOV_DEGREES: f64 = 40.0;
/// Part of the film's half width and half height that stays free on each side.
const MARGIN: f64 = 0.05;
/// Part of the largest visible area below which a view counts as edge-on.
const EDGE_ON: f64 = 0.01;

/// A view along an axis.
struct View {
    /// How a sentence calls it.
    name: &'static str,
    forward: DVec3,
    up: DVec3,
}

/// The first is used unless it shows next to nothing.
const VIEWS: [View; 6] = [
    View {
        name: "−z",
        forward: DVec3::NEG_Z,
        up: DVec3::Y,
    },
    View {
        name: "−y",
        forward: DVec3::NEG_Y,
        up: DVec3::NEG_Z,
    },
    View {
        name: "−x",
        forward: DVec3::NEG_X,
        up: DVec3::Y,
    },
    View {
        name: "z",
        forward: DVec3::Z,
        up: DVec3::Y,
    },
    View {
        name: "y",
        forward: DVec3::Y,
        up: DVec3::Z,
    },
    View {
        name: "x",
        forward: DVec3::X,
        up: DVec3::Y,
    },
];

/// A camera that looks along −z at the middle of the shapes' bounding box, from just as far away
/// that the box's front face fits the film with a margin; along another axis where the shapes are
/// seen edge-on or from behind. Returns the axis as well.
pub(super) fn framed(
    shapes: &[Shape],
    materials: &[Material],
    film: FilmSize,
) -> (Camera, &'static str) {
    let view = &VIEWS[best_view(shapes, materials)];
    let right = view.forward.cross(view.up);
    let fov_y = FOV_DEGREES.to_radians();
    let (low, high) = bounds(shapes).unwrap_or((DVec3::NEG_ONE, DVec3::ONE));
    let (center, half) = (0.5 * (low + high), 0.5 * (high - low));
    let along = |axis: DVec3| half.dot(axis.abs());
    let tangent_y = (0.5 * fov_y).tan() * (1.0 - MARGIN);
    let tangent_x = tangent_y * film.aspect();
    let mut distance = (along(right) / tangent_x).max(along(view.up) / tangent_y);
    let depth = along(view.forward);
    if distance <= 1e-6 * half.max_element() || distance <= 0.0 {
        distance = if depth > 0.0 { depth } else { 1.0 };
    }
    let camera = Camera {
        eye: center - view.forward * (depth + distance),
        right,
        up: view.up,
        forward: view.forward,
        projection: Projection::Perspective { fov_y },
        lens: Lens::PINHOLE,
    };
    (camera, view.name)
}

/// Index of the first view, or, where that shows next to nothing, of the one that shows the largest
/// area.
fn best_view(shapes: &[Shape], materials: &[Material]) -> usize {
    let mut visible = [0.0; VIEWS.len()];
    for shape in shapes {
        let seen = Sides::of(shape, materials);
        for_each_area(&shape.geometry, |area| {
            for (visible, view) in visible.iter_mut().zip(&VIEWS) {
                *visible += seen.area(area.dot(-view.forward));
            }
        });
    }
    let largest = visible.iter().copied().fold(0.0, f64::max);
    if visible[0] >= EDGE_ON * largest {
        return 0;
    }
    let best = visible.iter().position(|v| *v >= largest);
    best.unwrap_or(0)
}

/// Which sides of a shape show something, as factors on the areas that face the viewer and that do
/// not.
struct Sides {
    back: f64,
}

impl Sides {
    fn of(shape: &Shape, materials: &[Material]) -> Self {
        let exists = materials
            .get(shape.material.index())
            .is_none_or(|m| m.double_sided);
        let dark = shape.emission.is_some_and(|e| !e.two_sided);
        Self {
            back: match (exists, dark) {
                (false, _) => 0.0,
                // Seen, but the front shows more.
                (true, true) => 0.5,
                (true, false) => 1.0,
            },
        }
    }

    /// What shows of an area whose projection towards the viewer is `projected`, below 0 from
    /// behind.
    fn area(&self, projected: f64) -> f64 {
        if projected >= 0.0 {
            projected
        } else {
            -projected * self.back
        }
    }
}

/// The areas that a surface consists of, as vectors along its normals. A sphere shows the same from
/// everywhere.
fn for_each_area(geometry: &Geometry, mut f: impl FnMut(DVec3)) {
    match geometry {
        Geometry::Rectangle { u, v, .. } => f(u.cross(*v)),
        Geometry::Disk { u, v, .. } => f(std::f64::consts::PI * u.cross(*v)),
        Geometry::Sphere { radius, .. } => {
            let disk = std::f64::consts::PI * radius * radius;
            for axis in DVec3::AXES {
                f(axis * disk);
                f(-axis * disk);
            }
        }
        Geometry::Ellipsoid { axes, .. } => {
            let [x, y, z] = [0, 1, 2].map(|i| axes.row(i));
            let outlines = [y.cross(z), z.cross(x), x.cross(y)].map(DVec3::length);
            for (axis, outline) in DVec3::AXES.into_iter().zip(outlines) {
                f(axis * std::f64::consts::PI * outline);
                f(-axis * std::f64::consts::PI * outline);
            }
        }
        Geometry::Mesh(mesh) => {
            for triangle in &mesh.triangles {
                let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
                f(0.5 * (b - a).cross(c - a));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Bsdf, Emission, MaterialId, MaterialTextures, Mesh, Opacity};
    use glam::DAffine3;

    fn material(double_sided: bool) -> Material {
        Material {
            name: "grey".to_owned(),
            bsdf: Bsdf::Lambert {
                reflectance: DVec3::splat(0.5),
            },
            double_sided,
            textures: MaterialTextures::default(),
            opacity: Opacity::default(),
        }
    }

    fn shape(geometry: Geometry) -> Shape {
        Shape {
            name: "shape".to_owned(),
            geometry,
            material: MaterialId(0),
            emission: None,
        }
    }

    fn sphere(center: DVec3, radius: f64) -> Shape {
        shape(Geometry::Sphere { center, radius })
    }

    fn camera(shapes: &[Shape], film: FilmSize) -> Camera {
        framed(shapes, &[material(true)], film).0
    }

    #[test]
    fn the_box_fits_with_the_margin() {
        let shapes = [
            sphere(DVec3::new(5.0, 0.0, 0.0), 1.0),
            sphere(DVec3::new(-5.0, 2.0, 3.0), 1.0),
        ];
        for (width, height) in [(512, 512), (100, 400), (1920, 1080)] {
            let film = FilmSize { width, height };
            let camera = camera(&shapes, film);
            // Corners of the front face, in units of the film's half sides.
            let depth = camera.eye.z - 4.0;
            let y = 2.0 / depth / camera.half_height();
            let x = 6.0 / depth / camera.half_height() / film.aspect();
            assert!((x.max(y) - 0.95).abs() < 1e-12, "{x} {y}");
            assert_eq!(camera.eye.truncate(), glam::DVec2::new(0.0, 1.0));
        }
    }

    #[test]
    fn nothing_and_a_point_are_framed_too() {
        let film = FilmSize::default();
        assert!(camera(&[], film).eye.is_finite());
        let point = shape(Geometry::Mesh(Mesh {
            positions: vec![DVec3::ONE],
            triangles: vec![[0; 3]],
            ..Mesh::default()
        }));
        assert_eq!(camera(&[point], film).eye, DVec3::new(1.0, 1.0, 2.0));
    }

    /// The square [-1, 1]² in the plane whose normal is `normal`, as two triangles.
    fn plane(normal: DVec3) -> Shape {
        let (u, v) = normal.any_orthonormal_pair();
        let corners = [-u - v, u - v, u + v, v - u];
        shape(Geometry::Mesh(Mesh {
            positions: corners.to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        }))
    }

    #[test]
    fn flat_models_are_not_seen_edge_on() {
        let film = FilmSize::default();
        for (normal, forward) in [
            (DVec3::Z, DVec3::NEG_Z),
            (DVec3::NEG_Z, DVec3::NEG_Z),
            (DVec3::Y, DVec3::NEG_Y),
            (DVec3::NEG_Y, DVec3::NEG_Y),
            (DVec3::X, DVec3::NEG_X),
            (DVec3::NEG_X, DVec3::NEG_X),
            // Upright, and askew: from the side that shows more.
            (DVec3::new(1.0, 0.5, 0.0).normalize(), DVec3::NEG_X),
            (DVec3::new(0.0, 1.0, 0.2).normalize(), DVec3::NEG_Z),
        ] {
            let camera = camera(&[plane(normal)], film);
            assert_eq!(camera.forward, forward, "{normal}");
            assert_eq!(camera.right, camera.forward.cross(camera.up));
            assert!(camera.eye.dot(forward) < -1.0, "{normal}: {}", camera.eye);
            // All corners lie on the film.
            let Geometry::Mesh(mesh) = plane(normal).geometry else {
                unreachable!()
            };
            for corner in mesh.positions {
                let to = corner - camera.eye;
                let depth = to.dot(forward) * camera.half_height();
                assert!(to.dot(camera.right).abs() < depth * film.aspect());
                assert!(to.dot(camera.up).abs() < depth);
            }
        }
    }

    /// What is culled from behind, and what emits on one side, is seen from the front.
    #[test]
    fn flat_models_are_seen_from_their_fronts() {
        let film = FilmSize::default();
        for (normal, forward, name) in [
            (DVec3::NEG_Y, DVec3::Y, "y"),
            (DVec3::NEG_Z, DVec3::Z, "z"),
            (DVec3::NEG_X, DVec3::X, "x"),
            (DVec3::Y, DVec3::NEG_Y, "−y"),
        ] {
            let (camera, axis) = framed(&[plane(normal)], &[material(false)], film);
            assert_eq!((camera.forward, axis), (forward, name));
        }
        let mut lamp = plane(DVec3::NEG_Y);
        lamp.emission = Some(Emission {
            radiance: DVec3::ONE,
            texture: None,
            two_sided: false,
        });
        assert_eq!(camera(&[lamp], film).forward, DVec3::Y);
    }

    /// A thin slab lying down is as good as flat, one standing up is not; nor is a flat floor with
    /// something on it.
    #[test]
    fn what_shows_enough_is_seen_along_z() {
        let film = FilmSize::default();
        let slab = |height: f64| {
            let scale = DAffine3::from_scale(DVec3::new(1.0, height, 1.0));
            [DVec3::X, DVec3::Y, DVec3::Z]
                .into_iter()
                .flat_map(|n| [n, -n])
                .map(|n| {
                    let mut face = plane(n);
                    if let Geometry::Mesh(mesh) = &mut face.geometry {
                        for p in &mut mesh.positions {
                            *p = scale.transform_point3(*p + n);
                        }
                    }
                    face
                })
                .collect::<Vec<_>>()
        };
        assert_eq!(camera(&slab(0.001), film).forward, DVec3::NEG_Y);
        assert_eq!(camera(&slab(0.1), film).forward, DVec3::NEG_Z);
        let floor = [plane(DVec3::Y), sphere(DVec3::ZERO, 0.3)];
        assert_eq!(camera(&floor, film).forward, DVec3::NEG_Z);
    }
}
