//! Every value of `tests/data/reference_values.txt`, which were computed by other means, against
//! this module.

use super::lecture::LinearDensity;
use super::solid_angle::{cone_solid_angle, polygon_solid_angle, triangle_solid_angle};
use super::{disk, fresnel, ggx, point, polygon, rectangle, sphere, variance};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

const VALUES: &str = include_str!("../../../tests/data/reference_values.txt");

/// The number after `key` in a name.
fn number(name: &str, key: &str) -> f64 {
    let start = name
        .find(key)
        .unwrap_or_else(|| panic!("`{name}` has no `{key}`"))
        + key.len();
    let rest = name[start..].trim_start();
    let end = rest
        .find(|c: char| !(c.is_ascii_digit() || "+-.e".contains(c)))
        .unwrap_or(rest.len());
    rest[..end]
        .trim_end_matches(['e', '.', '-'])
        .parse()
        .unwrap_or_else(|e| panic!("`{name}` after `{key}`: {e}"))
}

fn radians(name: &str, key: &str) -> f64 {
    number(name, key).to_radians()
}

/// A light's vertices at height `z`.
fn at(z: f64, corners: &[(f64, f64)]) -> Vec<DVec3> {
    corners.iter().map(|&(x, y)| DVec3::new(x, y, z)).collect()
}

/// A unit square centred over the receiver.
fn square(z: f64) -> Vec<DVec3> {
    at(z, &[(-0.5, -0.5), (-0.5, 0.5), (0.5, 0.5), (0.5, -0.5)])
}

/// Lambert's factor for a receiver at the origin with normal +z.
fn lambert(vertices: &[DVec3]) -> f64 {
    polygon::polygon_factor(DVec3::ZERO, DVec3::Z, vertices).abs()
}

/// Two computations of the same value, both to be compared.
type Values = Vec<f64>;

/// What the file's line `name` should be; `gap` is that of the line before. Empty when the name is
/// unknown.
fn values(name: &str, gap: f64) -> Values {
    let sections = [lecture, polygons, disks_and_spheres, solid_angles];
    let mut found: Values = sections.iter().flat_map(|s| s(name)).collect();
    found.extend(variances(name, gap));
    found.extend(microfacets(name));
    found.extend(interfaces(name));
    found.extend(pixels(name));
    found
}

fn lecture(name: &str) -> Values {
    let Some((density, what)) = name.split_once(": ") else {
        return vec![];
    };
    let (constant, slope) = match density {
        "p=(6-x)/16" => (6.0 / 16.0, -1.0 / 16.0),
        "p=1/4" => (0.25, 0.0),
        "p=(x+2)/16" => (2.0 / 16.0, 1.0 / 16.0),
        "p=x/8" => (0.0, 1.0 / 8.0),
        _ => return vec![],
    };
    let density = LinearDensity { constant, slope };
    match what {
        "variance" => vec![density.variance()],
        "N = var/0.008^2" => vec![density.samples_for(0.008)],
        _ => vec![],
    }
}

fn polygons(name: &str) -> Values {
    if name.starts_with("parallel, corner") {
        let (a, b, c) = (number(name, "a="), number(name, "b="), number(name, "c="));
        let corners = at(c, &[(0.0, 0.0), (a, 0.0), (a, b), (0.0, b)]);
        vec![rectangle::parallel_corner(a, b, c), lambert(&corners)]
    } else if name.starts_with("parallel unit square centred, distance") {
        let distance = number(name, "distance");
        let sides = [-0.5, 0.5];
        vec![
            lambert(&square(distance)),
            rectangle::parallel_rectangle(sides, sides, distance),
        ]
    } else if name.starts_with("perpendicular wall") {
        let (b, a, c) = (number(name, "b="), number(name, "a="), number(name, "c="));
        let corners = [(0.0, 0.0), (b, 0.0), (b, a), (0.0, a)].map(|(y, z)| DVec3::new(c, y, z));
        vec![rectangle::perpendicular_corner(b, a, c), lambert(&corners)]
    } else if name.starts_with("triangle (1,0,-.5)") {
        vec![lambert(&[
            DVec3::new(1.0, 0.0, -0.5),
            DVec3::new(0.0, 1.0, 1.0),
            DVec3::new(-1.0, -0.5, 2.0),
        ])]
    } else if name.starts_with("quad z=-1") {
        vec![lambert(&square(-1.0))]
    } else {
        vec![]
    }
}

fn disks_and_spheres(name: &str) -> Values {
    let facing = |offset: f64, height: f64, axis: DVec3, radius: f64| {
        let centre = DVec3::new(offset, 0.0, height);
        disk::disk_factor(DVec3::ZERO, DVec3::Z, centre, axis, radius).unwrap()
    };
    if name.starts_with("disk on axis h=") {
        let (h, r) = (number(name, "h="), number(name, "r="));
        vec![disk::disk_parallel(h, r, 0.0), facing(0.0, h, DVec3::Z, r)]
    } else if name.starts_with("disk p") {
        let (h, r, offset) = (
            number(name, "h="),
            number(name, "r="),
            number(name, "offset="),
        );
        if name.contains("parallel") {
            vec![
                disk::disk_parallel(h, r, offset),
                facing(offset, h, -DVec3::Z, r),
            ]
        } else {
            vec![
                disk::disk_perpendicular(h, r, offset),
                facing(h, offset, DVec3::X, r),
            ]
        }
    } else if name.starts_with("sphere d/r=") {
        let distance = number(name, "d/r=");
        // A quarter turn exactly, because F changes with cosβ/sinσ.
        let degrees = number(name, "beta=");
        let (sin, cos) = if degrees >= 90.0 {
            let beyond = (degrees - 90.0).to_radians();
            (beyond.cos(), -beyond.sin())
        } else {
            degrees.to_radians().sin_cos()
        };
        let centre = DVec3::new(sin, 0.0, cos) * distance;
        vec![
            sphere::sphere_factor(DVec3::ZERO, DVec3::Z, centre, 1.0),
            sphere::cone_factor(cos, 1.0 / distance),
        ]
    } else if name.starts_with("receiver inside an emitting sphere") {
        let centre = DVec3::new(0.3, 0.2, -0.5);
        vec![sphere::sphere_factor(DVec3::ZERO, DVec3::Z, centre, 1.0)]
    } else {
        vec![]
    }
}

fn solid_angles(name: &str) -> Values {
    let omega = |v: [DVec3; 3]| triangle_solid_angle(DVec3::ZERO, v).abs();
    let triangle = |z: f64, corners: [(f64, f64); 3]| corners.map(|(x, y)| DVec3::new(x, y, z));
    if name.starts_with("octant") {
        vec![omega([DVec3::X, DVec3::Y, DVec3::Z])]
    } else if name.starts_with("triangle (0,0)") {
        let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)];
        vec![omega(triangle(number(name, "z="), corners))]
    } else if name.starts_with("near-hemisphere") {
        let corners = [0.0, 1.0, 2.0]
            .map(|k| (TAU * k / 3.0).sin_cos())
            .map(|(s, c)| (c, s));
        vec![omega(triangle(number(name, "z="), corners))]
    } else if name.starts_with("sliver") {
        vec![omega(triangle(1.0, [(0.0, 0.0), (1.0, 0.0), (0.5, 1e-6)]))]
    } else if name.starts_with("unit square centred at") {
        let z = number(name, "z=");
        let corner = 0.25 / (0.25 + z * z);
        let polygon = polygon_solid_angle(DVec3::ZERO, &square(z)).abs();
        vec![polygon, 4.0 * corner.asin()]
    } else if name.starts_with("sphere cone") {
        vec![cone_solid_angle(number(name, "r/d="))]
    } else {
        vec![]
    }
}

fn variances(name: &str, gap: f64) -> Values {
    let wall = || variance::wall_by_area(1.0, 1.0, number(name, "gap c="));
    let above = || variance::parallel_rectangle_by_area(1.0, 1.0, 1.0);
    let starts = |start| name.starts_with(start);
    vec![if starts("const env, uniform hemisphere") {
        variance::environment_uniform_hemisphere()
    } else if starts("const env, uniform sphere") {
        variance::environment_uniform_sphere()
    } else if starts("const env, cosine") {
        variance::environment_cosine()
    } else if starts("const env, MIS balance") {
        variance::environment_balance()
    } else if starts("const env, MIS power2") {
        variance::environment_power()
    } else if starts("sphere on axis") {
        variance::sphere_by_cone(number(name, "r/d="))
    } else if starts("disk on axis R=h=1") {
        variance::disk_by_area(1.0, 1.0).variance
    } else if starts("parallel unit square centred d=1") {
        if name.ends_with("mean") {
            above().mean
        } else {
            above().variance
        }
    } else if starts("wall 1x1") {
        if name.ends_with("E (mean)") {
            wall().mean
        } else {
            wall().variance
        }
    } else if starts("asymptote") {
        variance::wall_asymptote(1.0, gap)
    } else if starts("wall: largest sample") {
        variance::wall_largest_sample()
    } else if starts("parallel light at height c") {
        variance::parallel_second_moment_limit()
    } else {
        return vec![];
    }]
}

fn microfacets(name: &str) -> Values {
    if name.starts_with("alpha=1 closed form") {
        vec![ggx::rough_albedo(1.0)]
    } else if name.starts_with("alpha=1 average") {
        vec![ggx::rough_average_albedo()]
    } else if name.starts_with("alpha=") {
        let (alpha, cos) = (number(name, "alpha="), radians(name, "theta=").cos());
        let mut found = vec![ggx::directional_albedo(alpha, cos).total()];
        if alpha >= 1.0 {
            found.push(ggx::rough_albedo(cos));
        }
        found
    } else {
        vec![]
    }
}

fn interfaces(name: &str) -> Values {
    if name.starts_with("eta=") {
        let (eta, theta) = (number(name, "eta="), radians(name, "theta="));
        // 1.000001 is not a double; what it exceeds 1 by is the better input.
        let excess = if name.starts_with("eta=1.000001") {
            1e-6
        } else {
            eta - 1.0
        };
        vec![fresnel::reflectance_of_excess(theta.cos(), excess)]
    } else if name.starts_with("critical angle") {
        vec![fresnel::critical_angle(1.0 / 1.5).unwrap().to_degrees()]
    } else if name.starts_with("Brewster") {
        vec![fresnel::dielectric_reflectance(
            fresnel::brewster_angle(1.5).cos(),
            1.5,
        )]
    } else {
        vec![]
    }
}

/// Radiance of a Lambertian pixel of reflectance ½.
fn pixels(name: &str) -> Values {
    let lit_by = |light| point::point_irradiance(DVec3::ZERO, DVec3::Z, light, 100.0);
    let from_60_degrees = DVec3::new(0.75_f64.sqrt(), 0.0, 0.5);
    let irradiance = if name.starts_with("point light I=100 at height 2") {
        lit_by(DVec3::new(0.0, 0.0, 2.0))
    } else if name.starts_with("point light I=100 at (3,0,4)") {
        lit_by(DVec3::new(3.0, 0.0, 4.0))
    } else if name.starts_with("directional E_perp=10") {
        point::directional_irradiance(DVec3::Z, from_60_degrees, 10.0)
    } else if name.starts_with("constant environment L=2") {
        PI * 2.0 * sphere::cone_factor(1.0, 1.0)
    } else if name.starts_with("sun cone half angle") {
        PI * 1e7 * sphere::cone_factor(0.5, radians(name, "half angle").sin())
    } else if name.starts_with("unit square light L=10") {
        PI * 10.0 * lambert(&square(1.0))
    } else {
        return vec![];
    };
    vec![0.5 / PI * irradiance]
}

/// Asserts ten digits; `listed` is the value as the file has it.
fn assert_close(name: &str, listed: &str, found: f64) {
    let expected: f64 = listed
        .parse()
        .unwrap_or_else(|e| panic!("`{name}` {listed}: {e}"));
    // The GGX rows have ten decimals only; where the value is zero, the scale is one.
    let ten_decimals =
        name.starts_with("alpha=") && name.contains("theta") || name.starts_with("Schlick");
    let tolerance = if ten_decimals || expected.abs() <= 0.0 {
        1e-10
    } else {
        1e-10 * expected.abs()
    };
    assert!(
        (found - expected).abs() <= tolerance,
        "`{name}`: {found:e}, listed {listed}"
    );
}

#[test]
fn every_reference_value_is_reproduced() {
    let (mut lines, mut compared) = (0, 0);
    let mut gap = f64::NAN;
    for line in VALUES
        .lines()
        .filter(|l| !l.starts_with('#') && !l.trim().is_empty())
    {
        lines += 1;
        if let Some((name, fit)) = line.split_once(": E(F0) = F0*") {
            let (scale, bias) = fit.split_once(" + ").unwrap();
            let (alpha, cos) = (number(name, "alpha="), radians(name, "theta=").cos());
            let albedo = ggx::directional_albedo(alpha, cos);
            assert_close(name.trim(), scale, albedo.scale);
            assert_close(name.trim(), bias, albedo.bias);
            compared += 2;
            continue;
        }
        let (name, listed) = line.rsplit_once(char::is_whitespace).unwrap();
        let name = name.trim().trim_end_matches("E =").trim();
        if name.contains("gap c=") {
            gap = number(name, "gap c=");
        }
        let found = values(name, gap);
        assert!(!found.is_empty(), "no computation for `{name}`");
        for value in found {
            assert_close(name, listed, value);
            compared += 1;
        }
    }
    assert_eq!(lines, 120, "lines of the file");
    assert!(compared > lines, "{compared} comparisons");
}
