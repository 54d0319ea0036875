//! Directions to a convex polygon, uniform over its projected solid angle; see
//! `shaders/light/polygon.wesl`.

use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// Halvings of the bracket around an azimuth.
const STEPS: u32 = 60;

/// An edge of a projected polygon.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Edge {
    normal: DVec3,
    /// 1 for an outer arc, −1 for an inner one.
    sign: f64,
    low: f64,
    high: f64,
}

/// A polygon seen from the origin of a surface's frame, above its horizon.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ProjectedPolygon {
    edges: Vec<Edge>,
    zero: DVec2,
    last: f64,
    /// Projected solid angle; 0 where nothing is above the horizon.
    pub area: f64,
}

/// Twice the area between the edge's arc and the origin, from direction e0 to direction e1 (less
/// than π apart): by quadrature's closed form ∫ dψ/(1 + m²cos²ψ) = atan(tanψ/√(1 + m²))/√(1 + m²).
fn sector(normal: DVec3, e0: DVec2, e1: DVec2) -> f64 {
    let flat = normal.truncate();
    let top = (-normal.z.signum() * flat).try_normalize().unwrap_or(e0);
    let angle = |e: DVec2| (normal.z.abs() * top.perp_dot(e)).atan2(top.dot(e));
    normal.z.abs() * (angle(e1) - angle(e0)).rem_euclid(TAU)
}

fn arc_radius_squared(normal: DVec3, e: DVec2) -> f64 {
    let across = normal.truncate().dot(e);
    let nz2 = normal.z * normal.z;
    nz2 / (nz2 + across * across).max(1e-300)
}

fn clip_to_horizon(v: &[DVec3]) -> Vec<DVec3> {
    let mut clipped = Vec::new();
    for (i, a) in v.iter().enumerate() {
        let b = v[(i + 1) % v.len()];
        if a.z > 0.0 {
            clipped.push(*a);
        }
        if (a.z > 0.0) != (b.z > 0.0) {
            let p = a.lerp(b, a.z / (a.z - b.z));
            clipped.push(DVec3::new(p.x, p.y, 0.0));
        }
    }
    clipped
}

/// The direction of the plane from which all vertices lie at azimuths of 0 to π; that of some
/// vertex where the polygon surrounds the zenith: the one that the shader takes.
fn first_direction(v: &[DVec3]) -> DVec2 {
    let directions: Vec<DVec2> = v.iter().map(|p| p.truncate().normalize_or_zero()).collect();
    let least = |e: &DVec2| {
        let all = directions.iter().map(|f| e.perp_dot(*f));
        all.fold(2.0, f64::min)
    };
    let mut best = (-2.0, DVec2::X);
    for e in &directions {
        if least(e) > best.0 {
            best = (least(e), *e);
        }
    }
    best.1
}

/// The convex polygon `vertices`, in a surface's frame with the point at the origin.
pub fn project_polygon(vertices: &[DVec3]) -> ProjectedPolygon {
    let mut v = clip_to_horizon(vertices);
    if v.len() < 3 {
        return ProjectedPolygon::default();
    }
    let zero = first_direction(&v);
    for p in &mut v {
        let q = p.truncate();
        *p = DVec2::new(zero.dot(q), zero.perp_dot(q)).extend(p.z);
    }
    let next = |i: usize| v[(i + 1) % v.len()];
    let turns: Vec<f64> = (0..v.len())
        .map(|i| v[i].truncate().perp_dot(next(i).truncate()))
        .collect();
    let surrounds = turns.iter().all(|t| *t > 0.0) || turns.iter().all(|t| *t < 0.0);
    let azimuth = |p: DVec3| {
        let a = p.y.atan2(p.x);
        if surrounds && a < -1e-5 {
            a + TAU
        } else {
            a.max(0.0)
        }
    };
    let mut edges = Vec::new();
    for (i, vertex) in v.iter().enumerate() {
        let Some(normal) = vertex.cross(next(i)).try_normalize() else {
            continue;
        };
        let (mut from, mut to) = (azimuth(*vertex), azimuth(next(i)));
        if surrounds && (to - from).abs() > PI {
            if from < to {
                from = TAU;
            } else {
                to = TAU;
            }
        }
        edges.push(Edge {
            normal,
            sign: if to >= from { 1.0 } else { -1.0 },
            low: from.min(to),
            high: from.max(to),
        });
    }
    let last = edges.iter().fold(0.0, |m: f64, e| m.max(e.high));
    let mut polygon = ProjectedPolygon {
        edges,
        zero,
        last,
        area: 0.0,
    };
    let area = polygon.area_before(last);
    if area < 0.0 {
        polygon.edges.iter_mut().for_each(|e| e.sign = -e.sign);
    }
    polygon.area = area.abs();
    polygon
}

impl ProjectedPolygon {
    fn area_before(&self, azimuth: f64) -> f64 {
        let of_edge = |edge: &Edge| {
            let end = azimuth.min(edge.high);
            if end <= edge.low {
                return 0.0;
            }
            let (e0, e1) = (DVec2::from_angle(edge.low), DVec2::from_angle(end));
            0.5 * edge.sign * sector(edge.normal, e0, e1)
        };
        self.edges.iter().map(of_edge).sum()
    }

    /// Squared radii of the inner and the outer arc at an azimuth, whose direction is `e`.
    fn arcs(&self, azimuth: f64, e: DVec2) -> (f64, f64) {
        let (mut inner, mut outer) = (0.0, 0.0);
        for edge in &self.edges {
            if !(edge.low..=edge.high).contains(&azimuth) {
                continue;
            }
            let r2 = arc_radius_squared(edge.normal, e);
            if edge.sign > 0.0 {
                outer = r2;
            } else {
                inner = r2;
            }
        }
        (inner, outer)
    }
}

/// A unit direction in the surface's frame with the density cosθ / area.
pub fn sample_projected_polygon(p: &ProjectedPolygon, u: DVec2) -> DVec3 {
    let wanted = u.x * p.area;
    let (mut low, mut high) = (0.0, p.last);
    for _ in 0..STEPS {
        let middle = 0.5 * (low + high);
        if p.area_before(middle) > wanted {
            high = middle;
        } else {
            low = middle;
        }
    }
    let azimuth = 0.5 * (low + high);
    let e = DVec2::from_angle(azimuth);
    let (inner, outer) = p.arcs(azimuth, e);
    let r2 = inner + (outer - inner) * u.y;
    (r2.sqrt() * p.zero.rotate(e)).extend((1.0 - r2).max(0.0).sqrt())
}

/// The point of the unit square that [`sample_projected_polygon`] takes to the direction `w` of the
/// surface's frame.
pub fn invert_projected_polygon(p: &ProjectedPolygon, w: DVec3) -> DVec2 {
    let q = w.truncate();
    let turned = DVec2::new(p.zero.dot(q), p.zero.perp_dot(q));
    let around = turned.y.atan2(turned.x);
    let azimuth = if around < 0.0 && p.last > PI {
        around + TAU
    } else {
        around.max(0.0)
    };
    let e = DVec2::from_angle(azimuth);
    let (inner, outer) = p.arcs(azimuth, e);
    DVec2::new(
        p.area_before(azimuth) / p.area,
        (q.length_squared() - inner) / (outer - inner).max(1e-300),
    )
}
