//! Domains of integration: polygons, disks and spheres mapped from rectangles, each so that the
//! integrand of direct lighting stays smooth up to the rim and the horizon.

use super::cap::Cap;
use super::cubature::{Estimate, Tolerance, integrate};
use super::polygon::split;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI};

/// What the receiver at the origin sees.
pub(super) struct View {
    pub normal: DVec3,
    pub mirror: DVec3,
    pub tolerance: Tolerance,
    pub two_sided: bool,
}

impl View {
    /// The integrand over area: f_r cosθ cosθ'/d² at `q` of a plane at distance `height`.
    fn per_area(&self, bsdf: &impl Fn(DVec3) -> DVec3, q: DVec3, height: f64) -> DVec3 {
        let d2 = q.length_squared();
        let rise = q.dot(self.normal);
        if rise <= 0.0 {
            return DVec3::ZERO;
        }
        bsdf(q / d2.sqrt()) * (rise * height / (d2 * d2))
    }

    /// Points of a plane through `origin` with this unit normal at signed distance `height` where
    /// the integrand may peak: the one nearest to the receiver, then the one in the mirror
    /// direction.
    fn hints(&self, plane: DVec3, height: f64) -> Vec<DVec3> {
        let reach = height / plane.dot(self.mirror);
        let mut hints = vec![plane * height];
        if reach.is_finite() && reach > 0.0 {
            hints.push(self.mirror * reach);
        }
        hints
    }

    /// Unit radiance from a polygon, its points relative to the receiver.
    pub(crate) fn polygon(&self, bsdf: &impl Fn(DVec3) -> DVec3, local: &[DVec3]) -> Estimate {
        let (above, _) = split(local, self.normal);
        let Some((&first, rest)) = above.split_first() else {
            return Estimate::ZERO;
        };
        let mut triangles: Vec<[DVec3; 3]> = rest.windows(2).map(|e| [first, e[0], e[1]]).collect();
        let area2: DVec3 = triangles.iter().map(normal2).sum();
        let plane = area2.normalize_or_zero();
        let height = plane.dot(first);
        let averted = height >= 0.0;
        if height.abs() <= 0.0 || (averted && !self.two_sided) {
            return Estimate::ZERO;
        }
        for hint in self.hints(plane, height) {
            let hint = nearest(&above, plane, hint);
            triangles = cut_at(&triangles, plane, hint);
        }
        let tolerance = Tolerance {
            absolute: self.tolerance.absolute / triangles.len() as f64,
            ..self.tolerance
        };
        let mut sum = Estimate::ZERO;
        for [a, b, c] in triangles {
            // Duffy 1982: the first vertex is the side u = 0, where points are dense; dA = |(b −
            // a)×(c − a)| u du dv.
            let jacobian = (b - a).cross(c - a).length();
            let f = |u: f64, v: f64| {
                let q = a + ((b - a) * (1.0 - v) + (c - a) * v) * u;
                self.per_area(bsdf, q, height.abs()) * (jacobian * u)
            };
            let part = integrate(f, &[0.0, 1.0], &[0.0, 1.0], tolerance);
            sum.value += part.value;
            sum.error += part.error;
        }
        sum
    }

    /// Unit radiance from a disk, its points relative to the receiver.
    pub(crate) fn disk(
        &self,
        bsdf: &impl Fn(DVec3) -> DVec3,
        centre: DVec3,
        axis: DVec3,
        radius: f64,
    ) -> Estimate {
        let height = axis.dot(centre);
        let averted = height >= 0.0;
        if height.abs() <= 0.0 || (averted && !self.two_sided) {
            return Estimate::ZERO;
        }
        // x points up from the horizon: heights over it are centre·n + slope·x.
        let up = self.normal - axis * self.normal.dot(axis);
        let slope = up.length();
        let x_axis = up
            .try_normalize()
            .unwrap_or_else(|| axis.any_orthonormal_vector());
        let y_axis = axis.cross(x_axis);
        let rise = centre.dot(self.normal);
        let tau_end = if rise.abs() >= slope * radius {
            if rise < 0.0 {
                return Estimate::ZERO;
            }
            PI
        } else {
            (-rise / (slope * radius)).acos()
        };
        // x = r cosτ, y = r sinτ·w: dA = r² sin²τ dτ dw, smooth up to the rim.
        let mut tau_cuts = vec![0.0, tau_end];
        let mut w_cuts = vec![-1.0, 1.0];
        for hint in self.hints(axis, height) {
            let (x, y) = ((hint - centre).dot(x_axis), (hint - centre).dot(y_axis));
            let shrink = (radius / x.hypot(y)).min(1.0);
            let tau = (shrink * x / radius).clamp(-1.0, 1.0).acos();
            tau_cuts.push(tau);
            w_cuts.push(shrink * y / (radius * tau.sin()));
        }
        let f = |tau: f64, w: f64| {
            let (sin, cos) = tau.sin_cos();
            let q = centre + x_axis * (radius * cos) + y_axis * (radius * sin * w);
            self.per_area(bsdf, q, height.abs()) * (radius * sin).powi(2)
        };
        let (tau_cuts, w_cuts) = (within(tau_cuts, 0.0, tau_end), within(w_cuts, -1.0, 1.0));
        integrate(f, &tau_cuts, &w_cuts, self.tolerance)
    }

    /// Unit radiance from a sphere, its points relative to the receiver.
    pub(crate) fn sphere(
        &self,
        bsdf: &impl Fn(DVec3) -> DVec3,
        centre: DVec3,
        radius: f64,
    ) -> Estimate {
        let distance = centre.length();
        let rise = centre.dot(self.normal);
        let aside = centre - self.normal * rise;
        let x_axis = aside
            .try_normalize()
            .unwrap_or_else(|| self.normal.any_orthonormal_vector());
        let y_axis = self.normal.cross(x_axis);
        let mirror_theta = self
            .mirror
            .cross(self.normal)
            .length()
            .atan2(self.mirror.dot(self.normal));
        let mirror_phi = self.mirror.dot(y_axis).atan2(self.mirror.dot(x_axis));
        let f = |theta: f64, phi: f64| {
            let (sin, cos) = theta.sin_cos();
            let wi = (x_axis * phi.cos() + y_axis * phi.sin()) * sin + self.normal * cos;
            bsdf(wi) * (sin * cos.max(0.0))
        };
        let full_circles = |theta_end: f64| {
            let theta = within(vec![0.0, theta_end, mirror_theta], 0.0, theta_end);
            let phi = within(vec![-PI, PI, mirror_phi], -PI, PI);
            integrate(f, &theta, &phi, self.tolerance)
        };
        if distance < radius {
            return if self.two_sided {
                full_circles(FRAC_PI_2)
            } else {
                Estimate::ZERO
            };
        }
        let cap = Cap {
            beta: aside.length().atan2(rise),
            sigma: (radius / distance).min(1.0).asin(),
        };
        let mut sum = Estimate::ZERO;
        if cap.beta < cap.sigma {
            sum = full_circles((cap.sigma - cap.beta).min(FRAC_PI_2));
        }
        let Some(tau_end) = cap.tau_end() else {
            return sum;
        };
        let mirror_tau = cap.tau(mirror_theta);
        let widest = cap.ring(mirror_tau).1;
        let tau_cuts = within(vec![0.0, tau_end, mirror_tau], 0.0, tau_end);
        let w_cuts = within(vec![-1.0, 1.0, mirror_phi / widest], -1.0, 1.0);
        let partial = |tau: f64, w: f64| {
            let (theta, phi_end) = cap.ring(tau);
            f(theta, phi_end * w) * (phi_end * cap.spread() * tau.sin())
        };
        let rings = integrate(partial, &tau_cuts, &w_cuts, self.tolerance);
        sum.value += rings.value;
        sum.error += rings.error;
        sum
    }
}

/// The cuts within [low, high], ascending.
fn within(mut cuts: Vec<f64>, low: f64, high: f64) -> Vec<f64> {
    cuts.retain(|c| (low..=high).contains(c));
    cuts.sort_by(f64::total_cmp);
    cuts
}

/// Twice the vector area.
fn normal2([a, b, c]: &[DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// The point of a convex polygon that is nearest to `p` of its plane.
fn nearest(polygon: &[DVec3], plane: DVec3, p: DVec3) -> DVec3 {
    let edges = || (0..polygon.len()).map(|i| (polygon[i], polygon[(i + 1) % polygon.len()]));
    if edges().all(|(a, b)| (b - a).cross(p - a).dot(plane) >= 0.0) {
        return p;
    }
    edges()
        .map(|(a, b)| {
            let edge = b - a;
            a + edge * ((p - a).dot(edge) / edge.length_squared()).clamp(0.0, 1.0)
        })
        .min_by(|x, y| x.distance_squared(p).total_cmp(&y.distance_squared(p)))
        .unwrap_or(p)
}

/// Cuts the triangles that contain `p` into triangles with the first vertex `p`.
fn cut_at(triangles: &[[DVec3; 3]], plane: DVec3, p: DVec3) -> Vec<[DVec3; 3]> {
    let mut parts = Vec::new();
    for triangle in triangles {
        let [a, b, c] = *triangle;
        let whole = normal2(triangle).dot(plane);
        let fans = [[p, a, b], [p, b, c], [p, c, a]];
        let sizes = fans.map(|t| normal2(&t).dot(plane));
        if sizes.iter().any(|&s| s < -1e-12 * whole) {
            parts.push(*triangle);
            continue;
        }
        let kept = fans.iter().zip(sizes).filter(|&(_, s)| s > 1e-12 * whole);
        parts.extend(kept.map(|(t, _)| *t));
    }
    parts
}
