//! Exact variances of one-sample estimators of irradiance under unit radiance.

use super::cubature::{Tolerance, integrate};
use super::rectangle::{parallel_rectangle, perpendicular_corner};
use glam::DVec3;
use std::f64::consts::{LN_10, PI};

/// Mean and variance of one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampleMoments {
    /// The irradiance.
    pub mean: f64,
    /// Variance of one sample.
    pub variance: f64,
}

/// Relative tolerance of the quadratures here.
const TOLERANCE: f64 = 1e-13;

/// A constant environment, directions uniform over the hemisphere: π²/3. The mean is π.
pub fn environment_uniform_hemisphere() -> f64 {
    PI * PI / 3.0
}

/// A constant environment, directions uniform over the sphere: 5π²/3. The mean is π.
pub fn environment_uniform_sphere() -> f64 {
    5.0 * PI * PI / 3.0
}

/// A constant environment, directions by the cosine: every sample is π.
pub fn environment_cosine() -> f64 {
    0.0
}

/// A constant environment, one sample uniform over the hemisphere and one by the cosine, combined
/// by the balance heuristic (Veach & Guibas 1995).
///
/// With weights 1/(1+2μ) and 2μ/(1+2μ) the second moments add up to 4π²∫μ²/(1+2μ) dμ = ½π² ln 3;
/// the means are π(1 − ½ ln 3) and what it lacks to π.
pub fn environment_balance() -> f64 {
    let half_ln3 = 0.5 * 3.0_f64.ln();
    let uniform = PI * (1.0 - half_ln3);
    let cosine = PI - uniform;
    PI * PI * half_ln3 - uniform * uniform - cosine * cosine
}

/// As [`environment_balance`], by the power heuristic with exponent 2.
///
/// With weights 1/(1+4μ²) and 4μ²/(1+4μ²) the second moments add up to 4π²∫μ²(1+8μ³)/(1+4μ²)² dμ =
/// ¼π²(atan 2 + 22/5 − 2 ln 5); the means are ¼π ln 5 and what it lacks to π.
pub fn environment_power() -> f64 {
    let ln5 = LN_10 - std::f64::consts::LN_2;
    let uniform = 0.25 * PI * ln5;
    let cosine = PI - uniform;
    0.25 * PI * PI * (2.0_f64.atan() + 4.4 - 2.0 * ln5) - uniform * uniform - cosine * cosine
}

/// A sphere straight above with sine `sin_half_angle` of its half angle, directions uniform in its
/// cone: π²(1−c)⁴/3 with c = √(1−s²). The mean is πs².
pub fn sphere_by_cone(sin_half_angle: f64) -> f64 {
    let s2 = sin_half_angle * sin_half_angle;
    let k = s2 / (1.0 + (1.0 - s2).sqrt());
    PI * PI * k.powi(4) / 3.0
}

/// A disk of `radius` straight above and parallel at `height`, points uniform over its area.
///
/// The sample is πR²h²/(h²+ρ²)², ρ² uniform in [0, R²]: second moment π²R²h⁴/3·(h⁻⁶ − (h²+R²)⁻³),
/// mean πR²/(h²+R²).
pub fn disk_by_area(radius: f64, height: f64) -> SampleMoments {
    let (r2, h2) = (radius * radius, height * height);
    let mean = PI * r2 / (h2 + r2);
    let second = PI * PI * r2 * h2 * h2 / 3.0 * (h2.powi(-3) - (h2 + r2).powi(-3));
    SampleMoments {
        mean,
        variance: second - mean * mean,
    }
}

/// A rectangle of `width` by `depth`, parallel at `distance` and centred straight above, points
/// uniform over its area.
pub fn parallel_rectangle_by_area(width: f64, depth: f64, distance: f64) -> SampleMoments {
    let (x, y) = (0.5 * width, 0.5 * depth);
    let square = |u: f64, v: f64| {
        let d2 = (x * u).powi(2) + (y * v).powi(2) + distance * distance;
        DVec3::splat((distance * distance / (d2 * d2)).powi(2))
    };
    let quarter = integrate(
        square,
        &[0.0, 1.0],
        &[0.0, 1.0],
        Tolerance::relative(TOLERANCE),
    );
    let area = width * depth;
    let mean = PI * parallel_rectangle([-x, x], [-y, y], distance);
    SampleMoments {
        mean,
        variance: area * area * quarter.value.x - mean * mean,
    }
}

/// A wall of `width` by `height` that stands on the receiver's plane at `gap`, centred opposite to
/// it, points uniform over its area.
///
/// The second moment A∫(zc/d⁴)² dA is taken with y = c·sinh p, z = c·sinh q, because the integrand
/// has the gap's size.
pub fn wall_by_area(width: f64, height: f64, gap: f64) -> SampleMoments {
    let half = 0.5 * width;
    let f = |p: f64, q: f64| {
        let (y, z) = (gap * p.sinh(), gap * q.sinh());
        let d2 = gap * gap + y * y + z * z;
        let sample = z * gap / (d2 * d2);
        DVec3::splat(sample * sample * gap * gap * p.cosh() * q.cosh())
    };
    let (p, q) = ((half / gap).asinh(), (height / gap).asinh());
    let right = integrate(f, &[0.0, p], &[0.0, q], Tolerance::relative(TOLERANCE));
    let mean = 2.0 * PI * perpendicular_corner(half, height, gap);
    SampleMoments {
        mean,
        variance: width * height * 2.0 * right.value.x - mean * mean,
    }
}

/// What [`wall_by_area`]'s variance approaches for a small `gap` c: πA/(24c²).
pub fn wall_asymptote(area: f64, gap: f64) -> f64 {
    PI * area / (24.0 * gap * gap)
}

/// Largest sample of [`wall_by_area`] times c²/A: 9/(16√3), at z = c/√3.
pub fn wall_largest_sample() -> f64 {
    9.0 / (16.0 * 3.0_f64.sqrt())
}

/// What the second moment of [`parallel_rectangle_by_area`] times c²/A approaches for a small
/// distance c: π/3.
pub fn parallel_second_moment_limit() -> f64 {
    PI / 3.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mean_of(f: impl Fn(f64) -> f64) -> f64 {
        let found = integrate(
            |u, _| DVec3::splat(f(u)),
            &[0.0, 1.0],
            &[0.0, 1.0],
            Tolerance::relative(1e-13),
        );
        found.value.x
    }

    /// Variance of the two-sample estimator, `share(a, b)` being the weight of density a against b.
    fn combined(share: impl Fn(f64, f64) -> f64) -> f64 {
        let (uniform, cosine) = (|_: f64| 0.5 / PI, |mu: f64| mu / PI);
        let a = |mu: f64| share(uniform(mu), cosine(mu)) * mu / uniform(mu);
        let b = |mu: f64| share(cosine(mu), uniform(mu)) * mu / cosine(mu);
        let (mean_a, mean_b) = (mean_of(a), mean_of(|mu| 2.0 * mu * b(mu)));
        assert!((mean_a + mean_b - PI).abs() < 1e-12);
        mean_of(|mu| a(mu).powi(2)) + mean_of(|mu| 2.0 * mu * b(mu).powi(2))
            - mean_a.powi(2)
            - mean_b.powi(2)
    }

    #[test]
    fn closed_forms_are_the_integrals() {
        let balance = combined(|a, b| a / (a + b));
        assert!((environment_balance() - balance).abs() < 1e-12);
        let power = combined(|a, b| a * a / (a * a + b * b));
        assert!((environment_power() - power).abs() < 1e-12);
        let disk = disk_by_area(0.8, 1.3);
        let sample = |u: f64| PI * (0.8 * 1.3 / (1.69 + 0.64 * u)).powi(2);
        assert!((mean_of(sample) - disk.mean).abs() < 1e-12);
        assert!((mean_of(|u| sample(u).powi(2)) - disk.mean.powi(2) - disk.variance).abs() < 1e-12);
        // Uniform in cosine between c and 1, times the cone's solid angle.
        let c = 0.75_f64.sqrt();
        let cone = |u: f64| 2.0 * PI * (1.0 - c) * (c + (1.0 - c) * u);
        let variance = mean_of(|u| cone(u).powi(2)) - mean_of(cone).powi(2);
        assert!((variance - sphere_by_cone(0.5)).abs() < 1e-12);
    }

    #[test]
    fn limits_are_reached() {
        let wall = wall_by_area(1.0, 1.0, 1e-4);
        assert!((wall.variance / wall_asymptote(1.0, 1e-4) - 1.0).abs() < 1e-6);
        let near = parallel_rectangle_by_area(1.0, 1.0, 1e-2);
        let second = (near.variance + near.mean.powi(2)) * 1e-4;
        assert!((second - parallel_second_moment_limit()).abs() < 1e-6);
        let z = 1.0 / 3.0_f64.sqrt();
        assert!((z / (1.0 + z * z).powi(2) - wall_largest_sample()).abs() < 1e-15);
    }
}
