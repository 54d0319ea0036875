//! A circular cone of directions in spherical coordinates about the receiver's normal.

use std::f64::consts::FRAC_PI_2;

/// A cone of directions: its axis at angle β to the normal, its half angle σ. Rings of constant θ
/// that it covers in part lie at θ = m − h cosτ, τ in [0, π]: from |β − σ| to β + σ, smooth at both
/// ends.
pub(super) struct Cap {
    /// β, in [0, π].
    pub beta: f64,
    /// σ, in [0, π/2].
    pub sigma: f64,
}

impl Cap {
    /// m, the middle of the range of θ.
    fn middle(&self) -> f64 {
        self.beta.max(self.sigma)
    }

    /// h, half the range of θ.
    pub(crate) fn spread(&self) -> f64 {
        self.beta.min(self.sigma)
    }

    /// Where the rings meet the horizon, or end; `None` when all are below it.
    pub(crate) fn tau_end(&self) -> Option<f64> {
        let (m, h) = (self.middle(), self.spread());
        if h <= 0.0 || m - h >= FRAC_PI_2 {
            return None;
        }
        Some(self.tau(FRAC_PI_2))
    }

    /// The ring at θ, or the one next to it.
    pub(crate) fn tau(&self, theta: f64) -> f64 {
        ((self.middle() - theta) / self.spread())
            .clamp(-1.0, 1.0)
            .acos()
    }

    /// θ of the ring τ above the horizon, and the azimuth up to which it is covered:
    ///
    /// sin²(φ/2) : cos²(φ/2) = sin½(σ+θ−β) sin½(σ−θ+β) : sin½(θ+β+σ) sin½(θ+β−σ), from the
    /// spherical law of cosines.
    pub(crate) fn ring(&self, tau: f64) -> (f64, f64) {
        let (m, h) = (self.middle(), self.spread());
        let low = h * (0.5 * tau).sin().powi(2);
        let high = h * (0.5 * tau).cos().powi(2);
        let theta = m - h + 2.0 * low;
        let (inner, outer) = ((m - high).sin(), (m + low).sin());
        let (sin2, cos2) = if self.beta >= self.sigma {
            (low.sin() * high.sin(), outer * inner)
        } else {
            (inner * high.sin(), outer * low.sin())
        };
        (
            theta,
            2.0 * sin2.max(0.0).sqrt().atan2(cos2.max(0.0).sqrt()),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rings_end_where_the_cone_does() {
        for (beta, sigma) in [
            (0.3, 0.1),
            (0.1, 0.3),
            (1.4, 0.5),
            (0.2, 1.5),
            (2.0, 1.2),
            (1.0, 1e-6),
        ] {
            let cap = Cap { beta, sigma };
            for i in 1..20 {
                let (theta, phi) = cap.ring(f64::from(i) * 0.157);
                if theta > FRAC_PI_2 {
                    break;
                }
                // cosσ = cosθ cosβ + sinθ sinβ cosφ.
                let cos = theta.cos() * f64::cos(beta) + theta.sin() * f64::sin(beta) * phi.cos();
                assert!(
                    (cos - f64::cos(sigma)).abs() < 1e-15,
                    "{beta} {sigma} {theta}"
                );
                assert!((cap.ring(cap.tau(theta)).0 - theta).abs() < 1e-14);
            }
        }
    }
}
