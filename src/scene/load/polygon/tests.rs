use super::*;
use glam::DQuat;

/// An L of area 3, counter-clockwise; its reflex corner is the third.
const L: [[f64; 2]; 6] = [
    [1.0, -1.0],
    [1.0, 0.0],
    [0.0, 0.0],
    [0.0, 1.0],
    [-1.0, 1.0],
    [-1.0, -1.0],
];

fn flat(points: &[[f64; 2]]) -> Vec<DVec3> {
    let points = points.iter();
    points.map(|[x, y]| DVec3::new(*x, *y, 0.0)).collect()
}

fn cut(points: &[DVec3]) -> (Vec<[u32; 3]>, Triangulator) {
    let (mut triangles, mut triangulator) = (Vec::new(), Triangulator::default());
    let corners: Vec<u32> = (0..points.len() as u32).collect();
    triangulator.add(&corners, points, &mut triangles);
    (triangles, triangulator)
}

/// How many triangles cover `point`, whichever way they turn.
fn covers(points: &[DVec3], triangles: &[[u32; 3]], point: DVec2) -> usize {
    let side = |a: DVec2, b: DVec2| (b - a).perp_dot(point - a);
    let covers = |t: &&[u32; 3]| {
        let [a, b, c] = t.map(|i| points[i as usize].truncate());
        let sides = [side(a, b), side(b, c), side(c, a)];
        sides.iter().all(|s| *s > 0.0) || sides.iter().all(|s| *s < 0.0)
    };
    triangles.iter().filter(covers).count()
}

/// Whether the crossing number of `point` in the polygon is odd.
fn is_inside(polygon: &[DVec3], point: DVec2) -> bool {
    let next = polygon.iter().cycle().skip(1);
    let crossings = polygon.iter().zip(next).filter(|(a, b)| {
        let at = (point.y - a.y) / (b.y - a.y);
        ((a.y > point.y) != (b.y > point.y)) && point.x < a.x + at * (b.x - a.x)
    });
    crossings.count() % 2 == 1
}

/// Every point of a lattice inside the polygon is covered once, none outside is.
#[track_caller]
fn assert_covers(points: &[DVec3]) {
    let (triangles, triangulator) = cut(points);
    assert_eq!(triangulator.warnings("it"), [""; 0]);
    for i in 0..2000 {
        let at = f64::from(i) * DVec2::new(0.754_877_666_246_692_8, 0.569_840_290_998_053_3);
        let at = 5.0 * at.fract() - DVec2::splat(2.5);
        let expected = usize::from(is_inside(points, at));
        assert_eq!(
            covers(points, &triangles, at),
            expected,
            "{at} of {points:?}"
        );
    }
}

fn rotated(points: &[DVec3], by: usize) -> Vec<DVec3> {
    let mut points = points.to_vec();
    points.rotate_left(by);
    points
}

const SHAPES: [&[[f64; 2]]; 7] = [
    &L,
    // A notch.
    &[
        [-1.0, -1.0],
        [1.0, -1.0],
        [1.0, 1.0],
        [0.0, -0.5],
        [-1.0, 1.0],
    ],
    // A comb, with corners on its edges.
    &[
        [-2.0, 0.0],
        [-2.0, -1.0],
        [0.0, -1.0],
        [2.0, -1.0],
        [2.0, 1.0],
        [1.0, 1.0],
        [1.0, 0.0],
        [0.5, 0.0],
        [0.5, 2.0],
        [-0.5, 2.0],
        [-0.5, 0.0],
    ],
    // A hole, reached over an edge there and back.
    &[
        [-2.0, -2.0],
        [2.0, -2.0],
        [2.0, 2.0],
        [-2.0, 2.0],
        [-2.0, -2.0],
        [-1.0, -1.0],
        [-1.0, 1.0],
        [1.0, 1.0],
        [1.0, -1.0],
        [-1.0, -1.0],
    ],
    // Two squares that touch in a corner.
    &[
        [0.0, 0.0],
        [1.0, 0.0],
        [1.0, 1.0],
        [0.0, 1.0],
        [0.0, 0.0],
        [-1.0, 0.0],
        [-1.0, -1.0],
        [0.0, -1.0],
    ],
    // The L with an edge that goes out and back.
    &[
        [1.0, -1.0],
        [1.0, 0.0],
        [1.5, 0.5],
        [1.0, 0.0],
        [0.0, 0.0],
        [0.0, 1.0],
        [-1.0, 1.0],
        [-1.0, -1.0],
    ],
    // The L with corners given twice.
    &[
        [1.0, -1.0],
        [1.0, 0.0],
        [1.0, 0.0],
        [0.0, 0.0],
        [0.0, 1.0],
        [0.0, 1.0],
        [-1.0, 1.0],
        [-1.0, -1.0],
    ],
];

#[test]
fn concave_polygons_are_covered_from_every_corner() {
    for shape in SHAPES {
        let points = flat(shape);
        for start in 0..points.len() {
            assert_covers(&rotated(&points, start));
        }
    }
}

/// Triangles turn as the polygon does: seen from behind, clockwise.
#[test]
fn the_orientation_is_kept() {
    for shape in SHAPES {
        let mut points = flat(shape);
        points.reverse();
        let (triangles, _) = cut(&points);
        let normals = triangles.iter().map(|t| {
            let [a, b, c] = t.map(|i| points[i as usize]);
            (b - a).cross(c - a).z
        });
        let (mut turned, mut doubled) = (0, 0.0);
        for z in normals {
            turned += usize::from(z > 0.0);
            doubled += z;
        }
        assert_eq!(turned, 0, "{points:?}");
        let enclosed: f64 = fan(&points)
            .map(|t| area(t.map(|i| points[i].truncate())))
            .sum();
        assert!(
            (doubled - enclosed).abs() < 1e-12,
            "{doubled} of {enclosed}"
        );
    }
}

/// Convex polygons, with corners on their edges or not, and concave ones from where a fan covers
/// them.
#[test]
fn what_a_fan_covers_is_a_fan() {
    let square = [
        [-1.0, -1.0],
        [0.0, -1.0],
        [1.0, -1.0],
        [1.0, 1.0],
        [-1.0, 1.0],
    ];
    let on_a_line = [[-1.0, -1.0], [0.0, -1.0 + 1e-9], [1.0, -1.0], [1.0, 1.0]];
    let from_the_reflex_corner = rotated(&flat(&L), 2);
    let bent = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.5), DVec3::Y];
    for points in [
        flat(&square),
        flat(&on_a_line),
        from_the_reflex_corner,
        bent.to_vec(),
    ] {
        let expected: Vec<[u32; 3]> = fan(&points).map(|t| t.map(|i| i as u32)).collect();
        assert_eq!(cut(&points).0, expected, "{points:?}");
    }
}

/// The same triangles whichever corner comes first, also of a polygon that is not flat: from two of
/// its corners a fan covers it.
#[test]
fn the_first_corner_does_not_matter() {
    let heights = [0.0, 0.3, -0.1, 0.2, 0.1, -0.2];
    let points = L
        .iter()
        .zip(heights)
        .map(|([x, y], z)| DVec3::new(*x, *y, z));
    let points: Vec<DVec3> = points.collect();
    let triangles = |start: usize| {
        let points = rotated(&points, start);
        let (triangles, _) = cut(&points);
        let mut triangles: Vec<_> = triangles
            .iter()
            .map(|t| {
                let mut corners = t.map(|i| (i as usize + start) % 6);
                let least = (0..3).min_by_key(|&i| corners[i]).unwrap();
                corners.rotate_left(least);
                corners
            })
            .collect();
        triangles.sort();
        triangles
    };
    let expected = triangles(0);
    assert_eq!(expected.len(), 4);
    for start in [1, 3, 4] {
        assert_eq!(triangles(start), expected, "{start}");
    }
}

/// Corners on an edge stay corners of triangles: the neighbour across it has them too.
#[test]
fn corners_on_edges_are_kept() {
    for shape in [&L, SHAPES[1], SHAPES[2]] {
        let corners = flat(shape);
        let next = corners.iter().cycle().skip(1);
        let halved = corners
            .iter()
            .zip(next)
            .flat_map(|(a, b)| [*a, 0.5 * (*a + *b)]);
        let points: Vec<DVec3> = halved.collect();
        for start in 0..points.len() {
            let points = rotated(&points, start);
            assert_covers(&points);
            let (triangles, _) = cut(&points);
            for corner in 0..points.len() as u32 {
                let used = triangles.iter().any(|t| t.contains(&corner));
                assert!(used, "{corner} of {points:?}");
            }
        }
    }
}

/// In any plane, of any size, far from the origin.
#[test]
fn polygons_lie_anywhere() {
    let turn = DQuat::from_scaled_axis(DVec3::new(0.3, -1.1, 0.7));
    for (scale, origin) in [(1.0, 1e6), (1e-150, 0.0), (1e120, 0.0)] {
        let place = |p: &DVec3| scale * (turn * *p) + DVec3::splat(origin);
        let points: Vec<DVec3> = flat(&L).iter().map(place).collect();
        for start in 0..6 {
            let points = rotated(&points, start);
            let (triangles, triangulator) = cut(&points);
            assert_eq!(triangulator.crossing, 0);
            let normal = turn * DVec3::Z;
            let areas = triangles.iter().map(|t| {
                let [a, b, c] = t.map(|i| points[i as usize]);
                ((b - a) / scale).cross((c - a) / scale).dot(normal) / 2.0
            });
            let (mut total, mut absolute) = (0.0, 0.0);
            for area in areas {
                total += area;
                absolute += area.abs();
            }
            assert!((total - 3.0).abs() < 1e-8, "{total}, {scale}");
            assert!((absolute - 3.0).abs() < 1e-8, "{absolute}, {scale}");
        }
    }
}

#[test]
fn faces_that_are_no_simple_polygons_are_counted() {
    let bow_tie = flat(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]]);
    let uneven = flat(&[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 1.0]]);
    let line = flat(&[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0], [3.0, 3.0]]);
    let mut triangulator = Triangulator::default();
    let mut triangles = Vec::new();
    for points in [&bow_tie, &uneven, &line] {
        triangulator.add(&[0, 1, 2, 3], points, &mut triangles);
    }
    triangulator.add(&[0, 1], &line, &mut triangles);
    assert_eq!(
        triangulator.warnings("m.obj"),
        [
            "m.obj: 2 polygons cross themselves: what triangles cover of them may differ from what is meant",
            "m.obj: 1 face has fewer than three corners"
        ]
    );
    let not_finite = [DVec3::ZERO, DVec3::X, DVec3::NAN, DVec3::Y];
    assert_eq!(cut(&not_finite).0.len(), 2);
}

/// A notch in the lower edge of a square, whatever its size and whichever corner comes first: what
/// lies in it is not covered.
#[test]
fn notches_of_every_size_are_kept() {
    for size in [0.1, 1e-3, 1e-4, 1e-5] {
        let square = flat(&[
            [-size, 0.0],
            [0.0, size],
            [size, 0.0],
            [1.0, 0.0],
            [1.0, 2.0],
            [-1.0, 2.0],
            [-1.0, 0.0],
        ]);
        for by in 0..square.len() {
            let points = rotated(&square, by);
            let (triangles, triangulator) = cut(&points);
            assert_eq!(triangulator.warnings("it"), [""; 0]);
            for (x, y, expected) in [
                (0.01, 0.4, 0),
                (0.01, 1.1, 1),
                (-0.6, 0.2, 0),
                (-0.9, 0.3, 1),
            ] {
                let at = size * DVec2::new(x, y);
                assert_eq!(
                    covers(&points, &triangles, at),
                    expected,
                    "{size}, {by}, {at}"
                );
            }
        }
    }
}
